"""Pages made from code: the protocol and materials files from their schema, the command line, the public names."""

from __future__ import annotations

import inspect
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import typer

import knitlab as kl
from app import schemas
from app.cli.main import knitlab
from app.schemas import materials

if TYPE_CHECKING:
    from collections.abc import Iterator

ROOT: Final = Path(__file__).parents[2]

_EXAMPLES: Final = tuple(sorted((ROOT / "examples").glob("*.yaml")))


def pages() -> dict[str, str]:
    """Return the text of each page by its place below `docs`."""
    return {
        "reference/protocol.md": _schema_page("protocol"),
        "reference/material.md": _schema_page("material"),
        "reference/command_line.md": _commands(),
        "reference/python.md": _names(),
    }


def _schema_page(kind: str) -> str:
    schema = materials.json_schema() if kind == "material" else schemas.json_schema()
    parts = schema.get("$defs", {})
    made_from = f"Made from the schema that `knitlab schema --kind {kind}` prints and by which files are read."
    found = [f"# {kind.capitalize()} file\n\n{made_from}\n", f"## The file\n\n{_table(schema)}"]
    for name, part in _in_order(parts):
        found.append(f"## {_title(name)}\n\n{_purpose(part)}\n\n{_table(part)}")
        if name.endswith("Model") and (example := _example(name.removesuffix("Model"))):
            found.append(f"For example, from `{example[0]}`:\n\n```yaml\n{example[1]}\n```\n")
    return "\n".join(found)


def _in_order(parts: dict[str, Any]) -> Iterator[tuple[str, Any]]:
    """Yield the parts that have fields; the wrappers of steps have but one, their name."""
    for name, part in sorted(parts.items()):
        if name.endswith("Step") or not any("properties" in one for one in [part, *part.get("anyOf", [])]):
            continue
        yield name, part


def _title(name: str) -> str:
    words = re.sub(r"(?<!^)(?=[A-Z])", " ", name.removesuffix("Model").removesuffix("Value")).lower()
    return f"{words.capitalize()}"


def _purpose(part: dict[str, Any]) -> str:
    return str(part.get("description", "")).strip()


def _table(part: dict[str, Any]) -> str:
    part = next(one for one in [part, *part.get("anyOf", [])] if "properties" in one)
    rows = ["| field | what it is | default |", "|---|---|---|"]
    needed = part.get("required", [])
    for field, value in part["properties"].items():
        title = value.get("title")
        said = ": ".join(
            filter(None, [title if title != field else None, value.get("description", value.get("const"))])
        )
        what = said.replace("|", "\\|").replace("\n", " ")
        default = "must be said" if field in needed else _default(value.get("default"))
        rows.append(f"| `{field}` | {what} {_links(value)} | {default} |")
    return "\n".join(rows) + "\n"


def _default(value: Any) -> str:  # noqa: ANN401 (what JSON holds)
    if value in (None, {}, []):
        return "none"
    if isinstance(value, dict):
        return ", ".join(f"{key}: {_default(one)}" for key, one in value.items())
    return {True: "on", False: "off"}.get(value, str(value)) if isinstance(value, bool) else str(value)


def _links(value: Any) -> str:  # noqa: ANN401
    """Return links to the parts that a field may be."""
    names = sorted(set(re.findall(r"#/\$defs/(\w+)", str(value))))
    shown = [_title(name) for name in names if not name.endswith("Step")]
    return "".join(f" ([{one.lower()}](#{one.lower().replace(' ', '-')}))" for one in shown)


def _example(name: str) -> tuple[str, str] | None:
    """Return where a step or part stands in an example, and its line there."""
    key = re.sub(r"(?<!^)(?=[A-Z])", "_", name).lower()
    for path in _EXAMPLES:
        if match := re.search(rf"^ *(?:- )?{key}: .*$", path.read_text(encoding="utf-8"), re.MULTILINE):
            return f"examples/{path.name}", match[0].strip()
    return None


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
