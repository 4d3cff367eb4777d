"""The examples of docs/extending.md do what the page says, in a copy of the source that they are put into."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING

from knitlab_core.knits import fabric_named, registry

if TYPE_CHECKING:
    import pytest

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "extending.md"
USES_TRIANGLE = """\
from app.schemas import ProtocolError, from_yaml, loads, to_yaml
from rigs.control.plan import planned_steps

TEXT = '''\
schema: knitlab/protocol@1
rig: biaxial-hook
specimen: {knit: stockinette-default, loops: [2, 2], loop: 8 mm, material: RGD8530-DM}
others: hold
steps:
  - repeat: {n: 2, steps: [{triangle: {axes: [C], to: 5 %, rate: 0.2 mm/s, tag: there and back}}]}
'''
protocol = from_yaml(TEXT)
assert from_yaml(to_yaml(protocol)) == protocol
for stroke in [one for step in planned_steps(protocol, {"C": 0.05, "W": 0.05}) for one in step.strokes]:
    print(stroke.phase, stroke.cycle, stroke.tag, f"{stroke.end['C']:.4f}")
try:
    loads(TEXT.replace("5 %", "900 %"), "p.yaml")
except ProtocolError as error:
    print(error)
"""


def blocks(section: str) -> dict[str, str]:
    """Return the code of a section of the page, by the file that the first line of each block names."""
    text = PAGE.read_text(encoding="utf-8").partition(f"\n## {section}\n")[2].partition("\n## ")[0]
    return dict(re.findall(r"^```python\n# (\S+?\.py)[^\n]*\n(.*?)^```", text, re.DOTALL | re.MULTILINE))


def test_a_step_takes_two_files_and_an_entry(tmp_path: Path) -> None:
    for folder in ("app/schemas", "rigs"):
        shutil.copytree(ROOT / folder, tmp_path / folder, ignore=shutil.ignore_patterns("__pycache__"))
    for module in (ROOT / "app").glob("*.py"):
        shutil.copy(module, tmp_path / "app")
    code = blocks("A step")
    assert list(code) == ["rigs/protocol/triangle.py", "app/schemas/triangle.py", "app/schemas/steps.py"]
    registry = tmp_path / "app" / "schemas" / "steps.py"
    head, mark, tail = registry.read_text(encoding="utf-8").partition('        "repeat": StepEntry(')
    assert mark
    imported = "from app.schemas.triangle import TriangleModel, to_triangle, written_triangle\n"
    registry.write_text(imported + head + code.pop("app/schemas/steps.py") + mark + tail, encoding="utf-8")
    for file, text in code.items():
        (tmp_path / file).write_text(text, encoding="utf-8")
    # The folder first; the core is the one beside this test.
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(tmp_path), str(ROOT)])}
    command = [sys.executable, "-c", USES_TRIANGLE]
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)  # noqa: S603 (our own interpreter)
    assert done.returncode == 0, done.stderr
    *strokes, error = done.stdout.splitlines()
    assert strokes == [
        "Stretch 1 there and back 0.0025",
        "Recover 1 there and back 0.0000",
        "Stretch 2 there and back 0.0025",
        "Recover 2 there and back 0.0000",
    ]
    assert error.startswith("p.yaml:6:55: steps[0].repeat.steps[0].triangle.to.strain: found 9.0, allowed a strain")


def test_a_stitch_registered_from_outside_is_knit_by_name(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(registry, "_FABRICS", dict(registry._FABRICS))
    section = PAGE.read_text(encoding="utf-8").partition("\n## A stitch\n")[2].partition("\n## ")[0]
    (code,) = re.findall(r"^```python\n(.*?)^```", section, re.DOTALL | re.MULTILINE)
    said = StringIO()
    with redirect_stdout(said):
        exec(compile(code, "extending.md", "exec"), {})  # noqa: S102 (our own page)
    nodes, clearance = re.fullmatch(r"(\d+) nodes, clearance ([\d.]+) mm\n", said.getvalue()).groups()  # type: ignore[union-attr]
    assert int(nodes) > 8 * 48
    assert float(clearance) > 0.2
    assert fabric_named("rib-wide").budgets(0.05) != fabric_named("rib-1x1").budgets(0.05)
