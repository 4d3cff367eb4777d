"""The wings look one way: import-linter's contracts, kept with the tests."""

from __future__ import annotations

import tomllib
from pathlib import Path

import grimp
import pytest
from click.testing import CliRunner
from importlinter.cli import lint_imports_command

ROOT = Path(__file__).parents[1]
WINGS = ("knitlab_core", "rigs", "app")


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


@pytest.fixture(scope="module")
def graph() -> grimp.ImportGraph:
    """Return the imports of all wings; those for types count."""
    return grimp.build_graph(*WINGS, cache_dir=None)


def packages(graph: grimp.ImportGraph) -> list[str]:
    """Return every package that has modules of its own below it."""
    return sorted(module for module in graph.modules if graph.find_children(module))


def test_every_package_has_exhaustive_layers(graph: grimp.ImportGraph) -> None:
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]["contracts"]
    layered = {container for rule in contracts if rule.get("exhaustive") for container in rule["containers"]}
    assert [package for package in packages(graph) if package not in layered] == []


def test_no_module_imports_the_package_that_holds_it(graph: grimp.ImportGraph) -> None:
    upward = [
        f"{module} imports {package}"
        for package in packages(graph)
        for module in graph.find_descendants(package)
        if package in graph.find_modules_directly_imported_by(module)
    ]
    assert upward == []
