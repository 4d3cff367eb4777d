"""Parts of the OpenAPI document that no type gives: request bodies, with examples that run."""

from __future__ import annotations

import json
from typing import Any, Final

from app.schemas import json_schema

MOST_FILES: Final = 16
"""Files that may come with a protocol, beside that of its materials."""

EXAMPLE_YAML: Final = """\
schema: knitlab/protocol@1
name: biaxial_small
rig: biaxial-hook
specimen: {knit: stockinette-default, loops: [2, 2], loop: 8 mm, material: RGD8530-DM, friction: 0.3}
speed_ref: pair
others: hold
log: {rate: 10 Hz, noise: off}
params: {peak: 20 %}
steps:
  - zero: {channels: [force, displacement]}
  - cycle: {axes: [C, W], lower: 0, upper: "${peak}", rate: 0.2 mm/s, n: 1, tag: equibiaxial}
"""

EXAMPLE_JSON: Final[dict[str, Any]] = {
    "schema": "knitlab/protocol@1",
    "name": "biaxial_small",
    "rig": "biaxial-hook",
    "specimen": {
        "knit": "stockinette-default",
        "loops": [2, 2],
        "loop": "8 mm",
        "material": "RGD8530-DM",
        "friction": 0.3,
    },
    "speed_ref": "pair",
    "others": "hold",
    "log": {"rate": "10 Hz", "noise": "off"},
    "params": {"peak": "20 %"},
    "steps": [
        {"zero": {"channels": ["force", "displacement"]}},
        {"cycle": {"axes": ["C", "W"], "lower": 0, "upper": "${peak}", "rate": "0.2 mm/s", "n": 1}},
    ],
}

EXAMPLE_SWEEP: Final[dict[str, Any]] = {"protocol": EXAMPLE_JSON, "values": {"peak": ["5 %", "10 %"]}}

_REF: Final = {"$ref": "#/components/schemas/Protocol"}
_ENVELOPE: Final = {
    "type": "object",
    "required": ["protocol"],
    "additionalProperties": False,
    "properties": {
        "protocol": {"anyOf": [{"type": "string", "description": "the protocol's YAML"}, _REF]},
        "name": {"type": "string", "description": "name of a protocol that gives itself none"},
        "materials": {"type": "string", "description": "the YAML of the file that it names under `materials`"},
        "files": {
            "type": "object",
            "description": "texts of the CSV files that it names, by their names: a centreline, tables",
            "maxProperties": MOST_FILES,
            "additionalProperties": {"type": "string"},
        },
    },
}

PROTOCOL_BODY: Final[dict[str, Any]] = {
    "requestBody": {
        "required": True,
        "content": {
            "application/yaml": {
                "schema": {"type": "string", "description": "a protocol, as in a file"},
                "example": EXAMPLE_YAML,
            },
            "application/json": {
                "schema": {"anyOf": [_REF, _ENVELOPE]},
                "examples": {
                    "protocol": {"summary": "a protocol", "value": EXAMPLE_JSON},
                    "envelope": {"summary": "a protocol's file, as it is", "value": {"protocol": EXAMPLE_YAML}},
                },
            },
        },
    }
}

SWEEP_BODY: Final[dict[str, Any]] = {
    "requestBody": {
        "required": True,
        "content": {
            "application/json": {
                "schema": {
                    "anyOf": [
                        {
                            "type": "object",
                            "required": ["protocol", "values"],
                            "additionalProperties": False,
                            "properties": {
                                **_ENVELOPE["properties"],  # type: ignore[dict-item]
                                "values": {
                                    "type": "object",
                                    "description": "values of `params`; every combination is a job",
                                    "minProperties": 1,
                                    "additionalProperties": {
                                        "type": "array",
                                        "minItems": 1,
                                        "items": {"type": ["string", "number", "boolean"]},
                                    },
                                },
                            },
                        },
                        {
                            "type": "object",
                            "required": ["protocols"],
                            "additionalProperties": False,
                            "properties": {
                                "protocols": {"type": "array", "minItems": 1, "items": {"anyOf": [_REF, _ENVELOPE]}}
                            },
                        },
                    ]
                },
                "examples": {
                    "values": {"summary": "a protocol, and values of its parameters", "value": EXAMPLE_SWEEP},
                    "protocols": {"summary": "a list of protocols", "value": {"protocols": [EXAMPLE_JSON]}},
                },
            }
        },
    }
}


def protocol_schemas() -> dict[str, Any]:
    """Return the JSON Schema of a protocol and of its parts, as components of the OpenAPI document."""
    text = json.dumps(json_schema()).replace('"#/$defs/', '"#/components/schemas/')
    schema = json.loads(text)
    schema.pop("$schema")
    return {**schema.pop("$defs"), "Protocol": schema}
