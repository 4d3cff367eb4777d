"""Build of the package: what `pyproject.toml` says, and the examples, which are beside the code, inside it."""

from __future__ import annotations

import shutil
from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py

ROOT = Path(__file__).parent
SUFFIXES = {".yaml", ".csv"}
LICENCE = "LICENSE"  # of measured files, which it has to go with


class BuildWithExamples(build_py):
    """Copy the examples and the files that they name into `app/examples`, where an installed service finds them."""

    def run(self) -> None:
        """Copy the modules, then the examples; an editable install has both where they are."""
        super().run()
        if not self.editable_mode:
            for source, copy in self._examples():
                copy.parent.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(source, copy)

    def get_outputs(self, include_bytecode: bool = True) -> list[str]:  # noqa: FBT001, FBT002 (setuptools' own)
        """Return the files that are made."""
        made = super().get_outputs(include_bytecode)
        return made if self.editable_mode else [*made, *(str(copy) for _, copy in self._examples())]

    def _examples(self) -> list[tuple[Path, Path]]:
        """Return each file of the examples, and where it is copied to."""
        folder = ROOT / "examples"
        found = [path for path in sorted(folder.rglob("*")) if path.suffix in SUFFIXES or path.name == LICENCE]
        return [(path, Path(self.build_lib, "app", "examples", path.relative_to(folder))) for path in found]


setup(cmdclass={"build_py": BuildWithExamples})
