"""The examples of docs/live.md do what the page says."""

from __future__ import annotations

import doctest
import re
from pathlib import Path
from typing import Any

import pytest

from app.live import command_errors, commands

PAGE = (Path(__file__).parents[2] / "docs" / "live.md").read_text(encoding="utf-8")


def test_the_examples_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {}
    blocks = re.findall(r"^```pycon\n(.*?)^```$", PAGE, flags=re.MULTILINE | re.DOTALL)
    for number, block in enumerate(blocks):
        example = doctest.DocTestParser().get_doctest(block, names, f"docs/live.md {number}", "docs/live.md", 0)
        assert doctest.DocTestRunner().run(example, clear_globs=False).failed == 0
        names = example.globs
    pytest.importorskip("bluesky")
    (plan,) = re.findall(r"^```python\n(.*?)^```$", PAGE, flags=re.MULTILINE | re.DOTALL)
    exec(compile(plan, "docs/live.md", "exec"), names)  # noqa: S102 (our own page)
    assert names["rig"].result.outcome == "target"


def test_the_page_lists_every_command_and_error() -> None:
    rows = re.findall(r"^\| (`.*?`) \|", PAGE.partition("## Lab software")[2], flags=re.MULTILINE)
    said = {name.split()[0] for row in rows for name in re.findall(r"`([^`]+)`", row)}
    known = {header for header in said if any(one.fullmatch(header) for one in (*commands.COMMANDS, commands.ABORTS))}
    assert known == said
    assert len(known - {"ABORt"}) == len(commands.COMMANDS) - 1  # one is listed in its short form alone
    errors = {int(number) for number in re.findall(r"(-\d{3})\b", PAGE)}
    assert errors == set(command_errors.ERRORS) - {0}
