"""Pages made from code: the protocol and materials files from their schema, the command line, the public names."""

from __future__ import annotations

import inspect
import re
from dataclasses import fields
from importlib import import_module
from pkgutil import iter_modules
from typing import Any, Final

import typer

import knitlab as kl
from app import schemas
from app.cli.main import knitlab
from app.schemas import materials
from docs.site.worked import Worked, block, parts_of, shown, worked
from rigs import analysis

_CATALOGUE: Final = """\
# Materials: catalogue

What a protocol may name under `material` without a file of its own; `knitlab materials` prints the same. *assumed*
marks a choice that rests on no measurement of this material. Others come from a [materials file](material.md).
"""

_FORMULAS: Final = """\
# Figures and their formulas

The functions that compute figures from the rows of a test, be they equilibria of a run or lines of an instrument's
file; made from their docstrings. [Analysis](../analysis.md) says which table has which figure. Strain is travel by
gauge length, stress is force by initial section, energy densities are by initial volume.
"""

_KEYS: Final = {
    "CycleLogModel": "log",
    "StepLogModel": "log",
    "StitchModel": "knit",
    "VolumetricStitchModel": "knit",
    "FilamentModel": "knit",
    "CentrelineModel": "knit",
    "MeasuredYarnModel": "yarn",
    "MaterialModel": "my-resin",
    "SourcedYarnModel": "my-wool",
    "SourcedCompressionModel": "compression",
    "CurveModel": "yield_curve",
    "TargetModel": "to",
    "StressValue": "young_modulus",
    "NumberValue": "poisson_ratio",
    "StrainValue": "elongation_at_break",
    "BendingValue": "bending",
    "AxialValue": "axial",
    "LengthValue": "radius",
    "FrictionValue": "friction",
    "DensityValue": "density",
}
"""Words under which files have parts of other names."""

_LISTED: Final = {"TermModel": "terms", "PointModel": "points"}
"""The same of parts that are in a list."""


def pages() -> dict[str, str]:
    """Return the text of each page by its place below `docs`."""
    return {
        "reference/protocol.md": _schema_page("protocol"),
        "reference/material.md": _schema_page("material"),
        "reference/materials.md": _catalogue(),
        "reference/figures.md": _formulas(),
        "reference/command_line.md": _commands(),
        "reference/python.md": _names(),
    }


def _schema_page(kind: str) -> str:
    schema = materials.json_schema() if kind == "material" else schemas.json_schema()
    known = worked()
    whole = "MaterialsModel" if kind == "material" else "ProtocolModel"
    made_from = (
        f"Made from the schema that `knitlab schema --kind {kind}` prints and by which files are read. "
        "Every example is from a file that is read whenever the site is built."
    )
    found = [f"# {kind.capitalize()} file\n\n{made_from}\n", f"## The file\n\n{_table(whole, schema, known)}"]
    for name, part in parts_of(schema):
        found.append(f"## {_title(name)}\n\n{_purpose(part)}\n\n{_table(name, part, known)}")
        found += [_example(name, *known.wholes[name])] if name in known.wholes else []
    return "\n".join(found)


def _example(name: str, data: Any, path: str) -> str:  # noqa: ANN401 (what YAML holds)
    """Return a step or part as a file has it: of steps under their name, of others under the word where they are."""
    key = _LISTED.get(name) or _KEYS.get(name) or _title(name).lower().replace(" ", "_")
    text = block(key, [data] if name in _LISTED else data)
    return f"For example, from [`{path}`](../../{path}):\n\n```yaml\n{text}\n```\n"


def _title(name: str) -> str:
    words = re.sub(r"(?<!^)(?=[A-Z])", " ", name.removesuffix("Model").removesuffix("Value")).lower()
    return f"{words.capitalize()}"


def _purpose(part: dict[str, Any]) -> str:
    return str(part.get("description", "")).strip()


def _table(name: str, part: dict[str, Any], known: Worked) -> str:
    """Return the fields of a part: what each is, an example, and its default."""
    rows = ["| field | what it is | example | default |", "|---|---|---|---|"]
    needed, long = part.get("required", []), []
    for field, value in part["properties"].items():
        title = value.get("title")
        said = ": ".join(
            filter(None, [title if title != field else None, value.get("description", value.get("const"))])
        )
        what = said.replace("|", "\\|").replace("\n", " ")
        default = "must be said" if field in needed else _default(value.get("default"))
        example = "none yet"  # a test asks for one
        if (name, field) in known.fields:
            line = shown(known.fields[name, field])
            example = "below" if line is None else f"`{line}`".replace("|", "\\|")
            long += [f"```yaml\n{block(field, known.fields[name, field])}\n```\n"] * (line is None)
        rows.append(f"| `{field}` | {what}{_links(value)} | {example} | {default} |")
    return "\n".join([*rows, "", *long])


def _default(value: Any) -> str:  # noqa: ANN401 (what JSON holds)
    if value in (None, {}, []):
        return "none"
    if isinstance(value, dict):
        return ", ".join(f"{key}: {_default(one)}" for key, one in value.items())
    return {True: "on", False: "off"}.get(value, str(value)) if isinstance(value, bool) else str(value)


def _links(value: Any) -> str:  # noqa: ANN401
    """Return links to the parts that a field may be."""
    names = sorted(set(re.findall(r"#/\$defs/(\w+)", str(value))))
    titles = [_title(name) for name in names if not name.endswith("Step")]
    return "".join(f" ([{one.lower()}](#{one.lower().replace(' ', '-')}))" for one in titles)


def _catalogue() -> str:
    """Return the materials that a protocol may name without a file, with the source of every number."""
    found = [_CATALOGUE]
    for name, one in kl.materials().items():
        found.append(f"## {name}\n\n{getattr(one, 'note', '')}\n\n| number | value | source |\n|---|---|---|")
        for each in fields(one):
            values = getattr(one, each.name)
            if isinstance(values, kl.Value | tuple):
                rows = [values] if isinstance(values, kl.Value) else values
                found += [_number(each.name, row) for row in rows]
        found.append("")
    return "\n".join(found)


def _number(name: str, row: Any) -> str:  # noqa: ANN401 (a value, or a term of several)
    """Return a number of a material, or a term of its numbers, with the source."""
    parts = {"": row} if isinstance(row, kl.Value) else {one.name: getattr(row, one.name) for one in fields(row)}
    said = ", ".join(
        f"{part} {value.value:g} {'' if value.unit == '1' else value.unit}".strip() for part, value in parts.items()
    )
    first = next(iter(parts.values()))
    source = f"{'assumed: ' if first.assumed else ''}{first.source}".replace("|", "\\|")
    return f"| {name.replace('_', ' ')} | {said} | {source} |"


def _formulas() -> str:
    """Return what computes each figure, from the docstrings of the analysis."""
    found = [_FORMULAS]
    for module in sorted(iter_modules(analysis.__path__), key=lambda one: one.name):
        home = import_module(f"rigs.analysis.{module.name}")
        first, _, rest = (inspect.getdoc(home) or "").partition("\n")
        found.append(f"## {module.name.replace('_', ' ').capitalize()}\n\n{first}\n")
        if "References" in rest:
            found.append(f"```text\n{rest.strip()}\n```\n")
        for name, thing in vars(home).items():
            if inspect.isfunction(thing) and thing.__module__ == home.__name__ and not name.startswith("_"):
                words = f"{name}{str(inspect.signature(thing)).replace(chr(39), '')}\n\n{inspect.getdoc(thing)}"
                found.append(f"### {name}\n\n```text\n{words}\n```\n")
    return "\n".join(found)


def _commands() -> str:
    group: Any = typer.main.get_command(knitlab)
    context = group.make_context("knitlab", [], resilient_parsing=True)
    found = ["# Command line\n\nWhat `knitlab COMMAND --help` says, of all commands.\n"]
    for name in group.list_commands(context):
        command = group.get_command(context, name)
        inner = command.make_context(f"knitlab {name}", [], resilient_parsing=True, color=False)
        formatter = inner.make_formatter()
        command.format_usage(inner, formatter)
        command.format_help_text(inner, formatter)
        command.format_epilog(inner, formatter)
        found.append(f"## knitlab {name}\n\n```text\n{formatter.getvalue().strip()}\n```\n")
        rows = [record for one in command.get_params(inner) if (record := one.get_help_record(inner))]
        if rows:
            found.append("| option | what it does |\n|---|---|")
            found += [f"| `{a}` | {b} |".replace("|`", "`") for a, b in map(_plain, rows)]
            found.append("")
    return "\n".join(found)


def _plain(record: tuple[str, str]) -> tuple[str, str]:
    return record[0].replace("|", " or "), record[1].replace("|", "\\|").replace("\n", " ")


def _names() -> str:
    found = [
        "# Python: names\n\nThe docstring of every name of `import knitlab`; by example: [From Python](../python.md).\n"
    ]
    for name in sorted(kl.__all__, key=str.lower):
        thing = getattr(kl, name)
        try:
            signature = str(inspect.signature(thing)) if callable(thing) else ""
        except ValueError:
            signature = ""
        doc = (inspect.getdoc(thing) or "").strip() if callable(thing) else f"A {type(thing).__name__}."
        found.append(f"## {name}\n\n```text\n{name}{signature}\n\n{doc}\n```\n")
    return "\n".join(found)
