"""Examples of every part and field of a file, taken from real files that are read and converted like any user's.

Those of `examples` come first; `docs/site/examples` has what none of them uses.
"""

from __future__ import annotations

import io
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from ruamel.yaml import YAML

from app.schemas.base import Model
from app.schemas.document import parse_text
from app.schemas.errors import Faults
from app.schemas.material_models import MaterialsModel
from app.schemas.models import ProtocolModel
from app.schemas.params import substitute

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

ROOT: Final = Path(__file__).parents[2]
WIDEST: Final = 68
"""Letters of an example in a table; a longer one is shown where its part is described."""

_PLACES: Final = ("examples", "examples/*", "docs/site/examples")


@dataclass(frozen=True, slots=True, kw_only=True)
class Worked:
    """Examples by part of the schema: of each field, and of the whole with the file that has it."""

    fields: dict[tuple[str, str], Any] = field(default_factory=dict)
    wholes: dict[str, tuple[Any, str]] = field(default_factory=dict)

    def add(self, model: object, data: Any, path: str) -> None:  # noqa: ANN401 (what YAML holds)
        """Add what a model was read from, and all within it."""
        if isinstance(model, Model) and isinstance(data, dict):
            name = type(model).__name__
            known = self.wholes.get(name)
            # The fullest example says most, and the first of those.
            if known is None or len(data) > len(known[0]):
                self.wholes[name] = data, path
            for attribute, one in type(model).model_fields.items():
                key = one.alias or attribute
                if key in data:
                    before = self.fields.get((name, key))
                    # The shortest fits into a table.
                    if before is None or len(str(data[key])) < len(str(before)):
                        self.fields[name, key] = data[key]
                    self.add(getattr(model, attribute), data[key], path)
        elif isinstance(model, list | tuple) and isinstance(data, list):
            for one, part in zip(model, data, strict=False):
                self.add(one, part, path)
        elif isinstance(model, dict) and isinstance(data, dict):
            for key in model.keys() & data.keys():
                self.add(model[key], data[key], path)


def files() -> Iterator[Path]:
    """Yield the files that examples are taken from."""
    for place in _PLACES:
        yield from sorted(path for folder in sorted(ROOT.glob(place)) for path in folder.glob("*.yaml"))


@lru_cache(maxsize=1)
def worked() -> Worked:
    """Return examples of all parts and fields of protocols and files of materials."""
    found = Worked()
    for path in files():
        document = parse_text(path.read_text(encoding="utf-8"), str(path))
        kind = document.data.get("schema") if isinstance(document.data, dict) else None
        if kind not in {"knitlab/protocol@1", "knitlab/materials@1"}:
            continue
        model = ProtocolModel if kind == "knitlab/protocol@1" else MaterialsModel
        data: Any = document.data
        if model is ProtocolModel:
            data, _ = substitute(document, {}, Faults())
        found.add(model.model_validate(data), data, path.relative_to(ROOT).as_posix())
    return found


def shown(value: Any, width: int = WIDEST) -> str | None:  # noqa: ANN401 (what YAML holds)
    """Return a value as a file has it, in one line; None if it is too long for that."""
    text = _dumped(value, flow=True, width=10_000)
    return text if len(text) <= width and "\n" not in text else None


def block(key: str, value: Any) -> str:  # noqa: ANN401 (as above)
    """Return a key with its value as a file has it, in one line where that is short."""
    line = shown(value, 100)
    return f"{key}: {line}" if line is not None else _dumped({key: value}, flow=None, width=100)


def _dumped(value: Any, *, flow: bool | None, width: int) -> str:  # noqa: ANN401 (as above)
    yaml = YAML(typ="safe", pure=True)
    yaml.default_flow_style = flow
    yaml.width = width
    yaml.sort_base_mapping_type_on_output = False  # type: ignore[assignment]  # a flag that ships as None
    stream = io.StringIO()
    yaml.dump(value, stream)
    return stream.getvalue().removesuffix("...\n").strip()


def parts_of(schema: dict[str, Any]) -> Sequence[tuple[str, dict[str, Any]]]:
    """Return the parts of a schema that have fields, in the order of their names; wrappers of steps have but one."""
    found = []
    for name, part in sorted(schema.get("$defs", {}).items()):
        held = next((one for one in [part, *part.get("anyOf", [])] if "properties" in one), None)
        if held is not None and not name.endswith("Step"):
            found.append((name, {**held, "description": part.get("description", held.get("description", ""))}))
    return found
