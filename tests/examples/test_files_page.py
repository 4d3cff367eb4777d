"""Hold the page of files to what the program writes."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import pytest

from rigs.logs.catalogue import LOGS
from tests.examples.files_page import PAGE, beginnings

if TYPE_CHECKING:
    from pathlib import Path

TEXT = PAGE.read_text(encoding="utf-8")
NUMBER = re.compile(r"-?\d+\.\d+")


def test_the_page_lists_every_dialect_and_its_place() -> None:
    places = dict(re.findall(r"^\| \**`([\w-]+)`\** \| [^|]+ \| `([^`]+)` \|$", TEXT, re.MULTILINE))
    assert places == {name: log.place.format(sample="s") for name, log in LOGS.items()}


def test_the_page_shows_how_files_begin(tmp_path: Path) -> None:
    shown = dict(re.findall(r"\n`([\w-]+)`\n\n```\n(.*?)\n```\n", TEXT, re.DOTALL))
    begun = beginnings(tmp_path)
    assert list(shown) == list(begun)
    for name, text in begun.items():
        # Another processor may round a last digit otherwise.
        assert NUMBER.sub("#", shown[name]) == NUMBER.sub("#", text)
        numbers = [[float(one) for one in NUMBER.findall(part)] for part in (shown[name], text)]
        assert numbers[0] == pytest.approx(numbers[1], rel=1e-4, abs=2e-4)
