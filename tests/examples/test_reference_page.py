"""The reference pages have an example of every part and field, from files that are read as any user's."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from app.checks.dry_run import dry_run
from app.schemas import json_schema, load, load_sweep, materials
from docs.site.reference import pages
from docs.site.worked import Worked, parts_of, worked

OWN = sorted((Path(__file__).parents[2] / "docs" / "site" / "examples").glob("*.yaml"))


@pytest.fixture(scope="module")
def known() -> Worked:
    return worked()


@pytest.mark.parametrize(
    ("whole", "schema"), [("ProtocolModel", json_schema()), ("MaterialsModel", materials.json_schema())]
)
def test_every_part_and_field_has_an_example(whole: str, schema: dict[str, Any], known: Worked) -> None:
    parts = [(whole, schema), *parts_of(schema)]
    missing = [
        (name, field) for name, part in parts for field in part["properties"] if (name, field) not in known.fields
    ]
    assert missing == [], "a file in docs/site/examples must use each"
    assert {name for name, _ in parts} <= known.wholes.keys()
    assert len(parts) > 10


@pytest.mark.parametrize("path", OWN, ids=lambda path: path.stem)
def test_its_own_examples_can_be_carried_out(path: Path) -> None:
    loaded = load(path)
    for one in [test for _, test in load_sweep(path)][:1] if loaded.points else [loaded]:
        assert dry_run(one).warnings == []


def test_the_pages_show_a_step_as_a_file_has_it() -> None:
    page = pages()["reference/protocol.md"]
    part = page.partition("## Until rupture\n")[2].partition("\n## ")[0]
    assert "| `drop` | fall of the force from its peak: a share of the peak, such as 60 % | `60 %` | 0.6 |" in part
    assert "until_rupture:\n  axes: [C]" in part
    assert "below" not in part.partition("For example")[0]
