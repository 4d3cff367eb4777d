"""The public door `import knitlab`: what it holds, what its import costs, and its page, which is run."""

from __future__ import annotations

import ast
import doctest
import re
import subprocess
import sys
import textwrap
import tomllib
import traceback
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

import knitlab
from knitlab_core.equilibrium.newton import equilibrate

if TYPE_CHECKING:
    from knitlab_core.equilibrium.workspace import Workspace

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "python.md").read_text(encoding="utf-8")
ROWS = re.findall(r"^\| `(\w+)` \| .+ \| `(.+)` \|$", PAGE, flags=re.MULTILINE)
EXAMPLE = re.findall(r"^>>>.*?\n(?=\n)", knitlab.__doc__ or "", flags=re.MULTILINE | re.DOTALL)[0]
ERRORS = {name for name in knitlab.__all__ if name.endswith("Error")}
NOT_RUN = {
    "calibrate",
    "design",
    "SolverError",
    "ConvergenceError",
    "RunStoppedError",
    "ServiceError",
}
"""Examples that take long, or need a full disk, a service or a knit without equilibrium; other tests have them."""


def test_imports_for_type_checkers_are_those_of_the_door() -> None:
    tree = ast.parse(Path(knitlab.__file__).read_text(encoding="utf-8"))
    block = next(node for node in tree.body if isinstance(node, ast.If))
    imports = {
        alias.asname or alias.name: f"{node.module}:{alias.name}"
        for node in block.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    assert imports == knitlab._HOMES
    assert sorted(imports) == sorted(knitlab.__all__) == dir(knitlab)


def test_every_name_is_there_and_says_what_it_is() -> None:
    for name in knitlab.__all__:
        found = getattr(knitlab, name)
        assert isinstance(found, str) if name == "__version__" else found.__doc__, name
    with pytest.raises(AttributeError, match="module 'knitlab' has no attribute 'walk'"):
        knitlab.walk  # type: ignore[attr-defined]  # noqa: B018 (as it says)


def test_every_error_of_the_core_is_in_the_door() -> None:
    import knitlab_core.errors as core  # noqa: PLC0415

    named = {name for name, found in vars(core).items() if isinstance(found, type) and issubclass(found, Exception)}
    assert named <= ERRORS


def test_every_step_is_in_the_door() -> None:
    from rigs.protocol import protocol  # noqa: PLC0415

    built = {name for name in protocol.__all__ if isinstance(getattr(protocol, name), type)}
    assert built - {"Step"} <= set(knitlab.__all__)


def test_the_import_loads_no_library() -> None:
    heavy = {"numpy", "scipy", "numba", "matplotlib", "pint", "pydantic", "h5py", "httpx", "ruamel.yaml", "rigs"}
    code = f"import knitlab, sys; print(sorted({heavy!r} & set(sys.modules)))"
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT)  # noqa: S603
    assert said.stdout == "[]\n"


def test_the_page_has_every_name_once() -> None:
    assert sorted(name for name, _ in ROWS) == sorted(set(knitlab.__all__) - {"__version__"})
    assert "`kl.__version__`" in PAGE


def test_the_examples_of_door_and_page_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    files: list[str] = []

    def search(work: Workspace, *rest: Any, **named: Any) -> Any:  # noqa: ANN401 (handed through)
        stack = [Path(frame.filename) for frame in traceback.extract_stack()[:-1]]
        stack += [Path(equilibrate.__code__.co_filename), Path(sys.modules[type(work).__module__].__file__ or "")]
        calls = [file.relative_to(ROOT).as_posix() for file in stack if file.is_relative_to(ROOT)]
        files[:] = list(dict.fromkeys(calls[calls.index("app/runs/use_cases.py") :]))
        return equilibrate(work, *rest, **named)

    with monkeypatch.context() as followed:
        followed.setattr("knitlab_core.equilibrium.advance.equilibrate", search)
        names = names_of_the_example()
    first = knitlab.to_yaml(names["test"])
    (tmp_path / "first.yaml").write_text(first, encoding="utf-8")
    (tmp_path / "head.yaml").write_text(first.partition("steps:")[0] + "steps: []\n", encoding="utf-8")
    rate = "params: {l: 8 mm}\nsweep: {l: [8 mm]}\n"
    (tmp_path / "sweep.yaml").write_text(rate + first.replace("loop: 8 mm", "loop: ${l}"), encoding="utf-8")
    names["Path"] = Path
    for name, example in ROWS:
        code = compile(example, f"docs/python.md: {name}", "eval")
        if name in NOT_RUN:
            continue
        if name in ERRORS:
            with pytest.raises(getattr(knitlab, name)) as raised:
                eval(code, names)  # noqa: S307 (our own page)
            assert "\n" not in str(raised.value)
        else:
            assert eval(code, names) is not None, name  # noqa: S307 (our own page)
    assert names["run"].force("W")[-1] > names["run"].force("C")[-1] > 0.0
    # session.py hands out the iterator of path.py, and so is no frame of the stack.
    assert files == [file for file in way_of_a_run() if file != "rigs/control/session.py"]
    assert names["kl"].load("first.yaml").protocol == names["test"]
    run_further_blocks(names)


def way_of_a_run() -> list[str]:
    """Return the files that README names for one run, from the first that the door and the command share."""
    text = (ROOT / "README.md").read_text(encoding="utf-8").partition("in the order of its calls: ")[2]
    files: list[str] = []
    for name in re.findall(r"`([^`]+)`", text.partition(". ")[0]):
        files.append(name if "/" in name or not files else f"{files[-1].rpartition('/')[0]}/{name}")
        assert (ROOT / files[-1]).is_file(), name
    assert files[:3] == ["knitlab_entry.py", "app/cli/main.py", "app/cli/run.py"]
    return files[3:]


def names_of_the_example() -> dict[str, Any]:
    """Run the example of the door, which the page shows too, and return the names that it defines."""
    assert "```pycon\n" + EXAMPLE + "```" in PAGE
    names: dict[str, Any] = {}
    example = doctest.DocTestParser().get_doctest(knitlab.__doc__ or "", names, "knitlab", knitlab.__file__, 0)
    assert doctest.DocTestRunner().run(example, clear_globs=False).failed == 0
    return example.globs


def run_further_blocks(names: dict[str, Any]) -> None:
    """Run the sessions of the page after its first, in their order."""
    _, *blocks = re.findall(r"^```pycon\n(.*?)^```$", PAGE, flags=re.MULTILINE | re.DOTALL)
    assert len(blocks) == 2
    for number, block in enumerate(blocks, start=2):
        example = doctest.DocTestParser().get_doctest(block, names, f"docs/python.md {number}", "docs/python.md", 0)
        assert doctest.DocTestRunner().run(example, clear_globs=False).failed == 0
        names = example.globs


STRANGERS = {
    "a package": ("app", "app/__init__.py", "app"),
    "a package with a folder of ours": ("app", "app/cli/main.py", "app"),
    "a module": ("rigs", "rigs.py", "rigs.py"),
    "the core": ("knitlab_core", "knitlab_core/__init__.py", "knitlab_core"),
}


def stranger(folder: Path, kind: str) -> tuple[str, Path]:
    """Write another package of the name of one of ours; return its name and what hides ours."""
    name, file, shown = STRANGERS[kind]
    path = folder / file
    path.parent.mkdir(parents=True, exist_ok=True)
    path.touch()
    if "/" in file:
        (folder / name / "__init__.py").touch()
    return name, folder / shown


def python(code: str, *first: Path) -> subprocess.CompletedProcess[str]:
    """Run Python with some folders before ours on its path."""
    paths = [*map(str, first), str(ROOT)]
    return subprocess.run(  # noqa: S603 (our own interpreter and text)
        [sys.executable, "-I", "-c", f"import sys; sys.path[:0] = {paths!r}\n{code}"],
        capture_output=True,
        text=True,
        check=False,
    )


def command() -> str:
    """Return the code of the script that installers make of the command."""
    scripts = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["scripts"]
    module, function = scripts["knitlab"].split(":")
    return f"from {module} import {function}\nsys.argv = ['knitlab', '--version']\nsys.exit({function}())"


@pytest.mark.parametrize("kind", STRANGERS)
def test_a_package_that_hides_ours_is_named(kind: str, tmp_path: Path) -> None:
    name, path = stranger(tmp_path, kind)
    said = python("import knitlab", tmp_path)
    assert said.returncode == 1
    expected = f"ImportError: module {name} at {path} hides knitlab's; "
    assert said.stderr.splitlines()[-1].startswith(expected)


def test_the_command_says_so_in_one_line(tmp_path: Path) -> None:
    name, path = stranger(tmp_path, "a package")
    said = python(command(), tmp_path)
    assert (said.returncode, said.stdout) == (2, "")
    assert said.stderr.startswith(f"module {name} at {path} hides knitlab's; ")
    assert said.stderr.count("\n") == 1
    fine = python(command())
    assert (fine.returncode, fine.stdout, fine.stderr) == (0, f"knitlab {knitlab.__version__}\n", "")


def test_a_folder_without_init_hides_what_a_finder_finds_later(tmp_path: Path) -> None:
    # As an editable install does: its finder comes after the search path, where a bare folder is a package too.
    (tmp_path / "app").mkdir()
    code = textwrap.dedent(
        f"""
        from importlib.machinery import PathFinder
        class Editable:
            @staticmethod
            def find_spec(name, path=None, target=None):
                return None if path else PathFinder.find_spec(name, [{str(ROOT)!r}])
        sys.path.remove({str(ROOT)!r})
        sys.meta_path.append(Editable)
        import knitlab
        """
    )
    said = python(code, tmp_path)
    assert said.stderr.splitlines()[-1].startswith(f"ImportError: module app at {tmp_path / 'app'} hides knitlab's; ")
