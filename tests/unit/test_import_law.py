"""The wings look one way: import-linter's contracts, kept with the tests."""

from __future__ import annotations

from pathlib import Path

from click.testing import CliRunner
from importlinter.cli import lint_imports_command

ROOT = Path(__file__).parents[2]


def test_contracts_of_pyproject_are_kept() -> None:
    result = CliRunner().invoke(
        lint_imports_command, ["--config", str(ROOT / "pyproject.toml"), "--no-cache"], catch_exceptions=False
    )
    assert result.exit_code == 0, result.output


def test_core_carries_no_data_files() -> None:
    strangers = [
        path.name
        for path in (ROOT / "knitlab_core").rglob("*")
        if path.is_file() and "__pycache__" not in path.parts and path.suffix != ".py" and path.name != "py.typed"
    ]
    assert strangers == []
