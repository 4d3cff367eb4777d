"""Design: its file, its parameters, what a run came to, and a design that a last run confirms."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from typer.testing import CliRunner

from app.cli.main import knitlab
from app.records.reader import read_run
from app.schemas import load
from app.schemas.designs import load_design
from app.studies.design import design
from app.studies.design_space import Choice, Space
from app.studies.design_target import target_of
from app.studies.printability import printer_of, refusal
from knitlab_core.errors import SpecificationError
from rigs.analysis.estimation import Bounded
from rigs.analysis.work import loop_area
from tests.synthetic_run import PROTOCOL, make_run, stress

if TYPE_CHECKING:
    from app.schemas.designs import DesignTarget

EXAMPLE = Path(__file__).parents[3] / "examples" / "design"
FILE = """schema: knitlab/design@1
protocol: cell.yaml
free: {r: [0.04, 0.065], loop: [7 mm, 9 mm]}
choices: {mesh: [draft, default]}
target: {secant: 40 kPa, to: 20 %, axis: C}
"""


def written(folder: Path, text: str = FILE) -> Path:
    path = folder / "design.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def wanted(folder: Path, target: str) -> DesignTarget:
    return load_design(written(folder, FILE.replace("{secant: 40 kPa, to: 20 %, axis: C}", target))).target


def test_a_file_says_what_is_free_and_what_is_wanted(tmp_path: Path) -> None:
    found = load_design(written(tmp_path))
    assert found.protocol == tmp_path / "cell.yaml"
    assert [(one.name, one.low, one.high, one.unit) for one in found.ranges] == [
        ("r", 0.04, 0.065, ""),
        ("loop", 7.0, 9.0, "mm"),
    ]
    assert (found.target.secant, found.target.to, found.within, found.printer) == (40e3, 0.2, 0.05, "j35")


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("[0.04, 0.065]", "[0.065, 0.04]", "3:11: free.r: found"),
        ("[7 mm, 9 mm]", "[7 mm, 9]", "two numbers of one unit"),
        ("[draft, default]", "[draft, draft]", "4:17: choices.mesh: found '2 values'"),
        ("mesh: [draft, default]", "r: [1, 2]", "each parameter once"),
        (", to: 20 %", "", "secant or to without the other"),
        ("secant: 40 kPa, to: 20 %", "loop_area: -3 Pa", "5:21: target.loop_area: found '-3 Pa'"),
        ("secant: 40 kPa, to: 20 %", "loop_area: 3 Pa, curve: a.csv", "target: found 'loop_area, curve'"),
        ("secant: 40 kPa, to: 20 %, ", "", "nothing that is wanted"),
        ("40 kPa", "40", "5:18: target.secant: found"),
        ("axis: C", "axis: Q", "target.axis: found 'Q', allowed C, W or P"),
        ("axis: C", "axis: C, speed: 3", "target.speed: found 'an unknown field'"),
        ("choices:", "choice:", "did you mean choices?"),
        ("protocol: cell.yaml\n", "", "protocol: found 'nothing'"),
        ("axis: C}", "axis: C}\npoints: 3", "6:9: points: found '3', allowed a whole number from 4 to 1000"),
        ("axis: C}", "axis: C}\nwithin: 0", "within: found '0'"),
    ],
)
def test_a_mistake_in_the_file_is_one_line_with_its_place(tmp_path: Path, old: str, new: str, said: str) -> None:
    assert old in FILE
    with pytest.raises(SpecificationError) as refused:
        load_design(written(tmp_path, FILE.replace(old, new)))
    every = "\n".join(map(str, [refused.value, *refused.value.more]))
    assert said.replace("'", "") in every.replace("'", "")
    assert all("\n" not in str(one) for one in [refused.value, *refused.value.more])


def test_parameters_are_numbers_or_words() -> None:
    number = Bounded(name="r", low=0.5, high=2.0, start=1.0, unit="mm")
    space = Space(parameters=[number, Choice(name="resin", values=["soft", "hard", "none"])])
    z = space.snapped(np.array([[0.5, 0.1], [0.123456, 0.99], [1.0, 1.0]]))
    assert z[:, 1].tolist() == pytest.approx([1 / 6, 5 / 6, 5 / 6])
    assert space.encoded(z)[:, 1:].tolist() == [[1, 0, 0], [0, 0, 1], [0, 0, 1]]
    assert [space.parameters[1].value(at) for at in (0.0, 0.5, 1.0)] == ["soft", "hard", "none"]
    value = number.value(float(space.rounded(z[1])[0]))
    assert value == pytest.approx(float(f"{number.value(0.123456):.4g}"), rel=1e-7)
    assert space.rounded(z[2])[0] == pytest.approx(1.0)


def test_a_run_comes_to_a_secant_a_loop_and_a_curve(tmp_path: Path) -> None:
    run = make_run(tmp_path / "run.h5", protocol=PROTOCOL.replace("[6, 6]", "[2, 2]"))
    secant = target_of(wanted(tmp_path, "{secant: 40 kPa, to: 40 %, axis: W, cycle: 2}"))
    found = secant.features(run.path.parent)
    assert found is not None
    assert found[0] == pytest.approx(stress(0.4, 2, "Stretch", "W") / 0.4, rel=1e-3)
    assert secant.goal.distance(found) == pytest.approx(abs(found[0] / 40e3 - 1.0))
    loop = target_of(wanted(tmp_path, "{loop_area: 30 Pa, axis: C}")).features(run.path.parent)
    up = np.linspace(0.0, 0.4, 2001)
    path = np.array([stress(e, 1, "Stretch", "C") for e in up] + [stress(e, 1, "Recover", "C") for e in up[::-1]])
    assert loop is not None
    assert loop[0] == pytest.approx(loop_area(np.concatenate([up, up[::-1]]), path), rel=0.05)
    # The curve that the test itself follows is met; twice as much is as far off as its range is large.
    (tmp_path / "wanted.csv").write_text(
        "Time [s],Extension [mm],Load [N],Tensile strain [%],Tensile stress [kPa]\n"
        + "".join(
            f"{k},{45 * e},{s / 2.5e4},{100 * e},{s / 1e3}\n" for k, (e, s) in enumerate(zip(up, path, strict=False))
        )
    )
    curve = target_of(wanted(tmp_path, "{curve: wanted.csv, axis: C}"))
    here = curve.features(run.path.parent)
    assert here is not None
    assert float(curve.goal.distance(here)) < 0.01
    assert float(curve.goal.distance(2.0 * here)) > 0.2


def test_what_a_run_does_not_reach_is_none(tmp_path: Path) -> None:
    run = make_run(tmp_path / "run.h5", protocol=PROTOCOL.replace("[6, 6]", "[2, 2]"))
    for target in (
        "{secant: 1 kPa, to: 60 %, axis: C}",
        "{loop_area: 1 Pa, axis: C, cycle: 7}",
        "{loop_area: 1 Pa, axis: P}",
    ):
        assert target_of(wanted(tmp_path, target)).features(run.path.parent) is None


def test_a_knit_that_no_printer_can_make_is_refused_with_its_reason() -> None:
    printer = printer_of("j35")
    assert refusal(load(EXAMPLE / "design_cell.yaml"), printer) == ""
    thin = refusal(load(EXAMPLE / "design_cell.yaml", {"r": 0.01}), printer)
    assert thin.startswith("fibre diameter of 0.16 mm, ")
    assert refusal(load(EXAMPLE / "design_cell.yaml", {"r": 0.01}), None) == ""
    assert "gap of" in refusal(load(EXAMPLE / "design_cell.yaml", {"r": 0.11}), printer)
    assert refusal(load(EXAMPLE / "design_cell.yaml", {"r": 0.14}), printer) != ""
    assert printer_of("none") is None


def test_names_that_are_no_parameters_and_ranges_that_cannot_be_made_are_refused(tmp_path: Path) -> None:
    (tmp_path / "cell.yaml").write_text((EXAMPLE / "design_cell.yaml").read_text(encoding="utf-8"), encoding="utf-8")
    with pytest.raises(SpecificationError, match="radius: found 'no parameter', allowed a name under params: loop, r"):
        design(written(tmp_path, FILE.replace("r: [", "radius: [")), tmp_path / "out")
    with pytest.raises(SpecificationError, match=r"no point that can be made: .*fibre diameter"):
        design(written(tmp_path, f"{FILE.replace('[0.04, 0.065]', '[0.005, 0.006]')}points: 4\n"), tmp_path / "out")
    assert not (tmp_path / "out").exists()


def designed(*words: str) -> dict[str, Any]:
    said = CliRunner().invoke(knitlab, ["design", *words, "--json", "--quiet"])
    assert said.exit_code == 0, said.output + repr(said.exception)
    found: dict[str, Any] = json.loads(said.stdout)
    return found


@pytest.mark.slow
def test_the_last_run_of_a_design_confirms_it(tmp_path: Path) -> None:
    words = (str(EXAMPLE / "secant.yaml"), "--out", str(tmp_path / "out"), "--jobs", "2")
    found = designed(*words)
    target = found["target"]
    assert target["reached"] == pytest.approx(0.5e6, rel=0.1)
    assert target["predicted"] == pytest.approx(0.5e6, rel=0.1)
    assert target["low"] < target["predicted"] < target["high"]
    assert found["tests"] > 8
    assert all(check["met"] for check in found["checks"])
    # The last run is one on the finer mesh, and says the same by itself.
    run = read_run(found["folder"])
    assert run.test.specimen.nodes_per_loop == 48
    peak = int(np.argmax(run.strain("C")))
    assert run.force("C")[peak] / run.size.section("C") / run.strain("C")[peak] == pytest.approx(
        target["reached"], rel=1e-6
    )
    assert (tmp_path / "out" / "design.png").stat().st_size > 20_000
    # Nothing is run twice.
    again = designed(*words)
    assert again["reused"] == again["runs"] == found["runs"]
    assert {**again, "reused": 0} == {**found, "reused": 0}
