"""The examples of docs/extending.md do what the page says, in a copy of the source that they are put into."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
import tomllib
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path

import pytest

from knitlab_core.knits import fabric_named, registry

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
    return dict(re.findall(r"^```[a-z]+\n# (\S+?\.[a-z]+)[^\n]*\n(.*?)^```", text, re.DOTALL | re.MULTILINE))


def python(code: str, *words: str, folder: Path, **variables: str) -> subprocess.CompletedProcess[str]:
    """Run code in a process that looks for modules in a folder first, then in the source."""
    path = os.pathsep.join([str(folder), str(ROOT)])
    return subprocess.run(  # noqa: S603 (our own interpreter)
        [sys.executable, "-c", code, *words],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": path, **variables},
        capture_output=True,
        text=True,
        check=False,
    )


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
    done = python(USES_TRIANGLE, folder=tmp_path)
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


USES_LAW = """\
from knitlab_core.contact.law import make_law, pair_potential
law = make_law(0.37, 0.0)
for p in (0.1, 0.1 + 1e-6):
    print(*(value / law.coefficient for value in pair_potential(p, law)))
"""
USES_CONTACT = """\
import numpy as np
from tests.contact_scenes import straight, touch, unit_model

strands = [straight((0, 0, 1.95 * level), (level, 1 - level, 0), 8.0) for level in (0, 1)]
model, state = unit_model(strands)
scene = touch(model, state)
turned = np.random.default_rng(0).normal(size=state.q.shape)
turned[:, 3] = 0.0
ahead, back = (scene.energy(state.q + sign * 1e-5 * turned) for sign in (1.0, -1.0))
print((ahead - back) / 2e-5, np.sum(scene.gradient(state.q) * turned))
"""


@pytest.fixture
def other_law(tmp_path: Path) -> Path:
    """Return a folder with a core that has the normal law of the page."""
    shutil.copytree(ROOT / "knitlab_core", tmp_path / "knitlab_core", ignore=shutil.ignore_patterns("__pycache__"))
    file = tmp_path / "knitlab_core" / "contact" / "law.py"
    own = blocks("A law")["knitlab_core/contact/law.py"]
    before, _, rest = file.read_text(encoding="utf-8").partition("@inline_kernel\ndef pair_potential")
    _, mark, after = rest.partition("\n\n\n")
    assert mark
    file.write_text(f"{before}{own}\n\n{after}", encoding="utf-8")
    return tmp_path


def numbers(code: str, folder: Path) -> list[list[float]]:
    """Return what code prints with the core of a folder, whose kernels are kept there."""
    done = python(code, folder=folder, KNITLAB_CACHE=str(folder / "cache"))
    assert done.returncode == 0, done.stderr
    return [[float(word) for word in line.split()] for line in done.stdout.splitlines()]


def test_a_normal_law_takes_one_file(other_law: Path) -> None:
    at, ahead = numbers(USES_LAW, other_law)
    assert at == pytest.approx([0.5 * 0.14**2, 0.14, 1.0])
    assert [(ahead[0] - at[0]) / 1e-6, (ahead[1] - at[1]) / 1e-6] == pytest.approx(at[1:], rel=1e-5)


@pytest.mark.slow  # it compiles the kernels of contact
def test_forces_of_another_normal_law_are_the_slope_of_its_energy(other_law: Path) -> None:
    ((slope, force),) = numbers(USES_CONTACT, other_law)
    assert slope == pytest.approx(force, rel=1e-6)
    assert force != 0.0


COMMAND = "import sys; from app.cli.main import main; sys.argv[0] = 'knitlab'; main()"


@pytest.fixture
def my_lab(tmp_path: Path) -> Path:
    """Return a folder with the extension of the page as it would be installed, and the page's protocol."""
    files = blocks("From outside")
    frame = (ROOT / "rigs" / "data" / "uniaxial_frame.yaml").read_text(encoding="utf-8")
    files["desk_tester.yaml"] = frame.replace("rig: uniaxial-frame", "rig: desk-tester")
    points = tomllib.loads(files.pop("pyproject.toml"))["project"]["entry-points"]["knitlab.extensions"]
    (tmp_path / "my_lab-1.0.dist-info").mkdir()
    files["my_lab-1.0.dist-info/METADATA"] = "Metadata-Version: 2.1\nName: my-lab\nVersion: 1.0\n"
    listed = "".join(f"{name} = {place}\n" for name, place in points.items())
    files["my_lab-1.0.dist-info/entry_points.txt"] = f"[knitlab.extensions]\n{listed}"
    for name, text in files.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    return tmp_path


def test_an_installed_package_adds_machine_rig_dialect_and_knit_in_every_process(my_lab: Path) -> None:
    done = python(COMMAND, "sweep", "pulled.yaml", "--jobs", "2", "--out", "runs", "--quiet", folder=my_lab)
    assert done.returncode == 0, done.stderr
    logs = sorted((my_lab / "runs").glob("*/*_desk.csv"))
    for log, strain in zip(logs, (0.02, 0.03), strict=True):
        head, *rows = log.read_text(encoding="utf-8").splitlines()
        assert head == "t [s];u [mm];F [mN]"
        travel, force = (float(value) for value in rows[-1].split(";")[1:])
        assert travel > 1e3 * strain * 8e-3  # of a knit higher than one loop is wide
        assert force > 0.0
    listed = python(
        "from app.service.api.routes.laboratory import rigs; from app.extensions import load_extensions\n"
        "load_extensions(); print(rigs().model_dump_json())",
        folder=my_lab,
    )
    assert listed.returncode == 0, listed.stderr
    (desk,) = [rig for rig in json.loads(listed.stdout)["rigs"] if rig["name"] == "desk"]
    assert (desk["axes"], desk["machines"], desk["dialects"]) == (["W"], ["desk-tester"], ["desk-tester"])


def test_an_extension_that_fails_is_one_line(my_lab: Path) -> None:
    (my_lab / "my_lab.py").write_text("def register_parts():\n    raise KeyError('desk')\n", encoding="utf-8")
    done = python(COMMAND, "check", "pulled.yaml", folder=my_lab)
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert line.startswith("knitlab.extensions.my-lab: found \"my_lab:register_parts: KeyError: 'desk'\", allowed")
