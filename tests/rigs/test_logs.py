import csv
import io
from dataclasses import replace

import numpy as np
import pytest

from knitlab_core.errors import SpecificationError
from rigs.instruments import Samples
from rigs.logs.biotester import BIOTESTER, biotester_channels, cycle_text
from rigs.logs.bluehill import BLUEHILL_UNIVERSAL, bluehill_channels
from rigs.logs.writer import Column, Dialect, write_log
from rigs.record import SpecimenSize

SIZE = SpecimenSize(extents={"C": 45e-3, "W": 40e-3, "P": 1e-3}, fibre_radius=0.4e-3)

# Golden file: worked out by hand from the samples below and the dialect's description.
GOLDEN = (
    b"SetName,Cycle,Time_S,Temperature,XSize_um,YSize_um,"
    b"XDisplacement_um,YDisplacement_um,XForce_mN,YForce_mN\r\n"
    b"sample,1-Preload,0.000,22.0,45000,40000,0,0,0.00,0.00\r\n"
    b"equibiaxial,1-Stretch,0.100,22.0,45010,40009,10,9,1.50,-2.25\r\n"
    b"equibiaxial,1-Hold,0.200,22.0,45020,40018,20,18,3000.00,12.35\r\n"
    b'"pull, again",2-Recover,0.300,22.0,45010,40009,10,9,1.00,0.00\r\n'
)


def small_samples() -> Samples:
    measured = {
        "XDisplacement": np.array([0.0, 10e-6, 20e-6, 10e-6]),
        "YDisplacement": np.array([-4e-8, 9e-6, 18e-6, 9e-6]),
        "XForce": np.array([0.0, 1.5e-3, 3.0, 1e-3]),
        "YForce": np.array([-1e-7, -2.25e-3, 12.346e-3, 0.0]),
    }
    return Samples(
        instrument="biaxial-hook",
        time=np.array([0.0, 0.1, 0.2, 0.3]),
        measured=measured,
        clean=measured,
        offset={name: np.zeros(4) for name in measured},
        units={},
        reads={},
        cycle=np.array([1, 1, 1, 2]),
        phase=("Zero", "Stretch", "Hold", "Recover"),
        tag=(None, "equibiaxial", "equibiaxial", "pull, again"),
        overloads=(),
    )


def biotester_bytes(samples: Samples) -> bytes:
    channels = biotester_channels(samples, SIZE, set_name="sample", temperature=22.0)
    return b"".join(write_log(BIOTESTER, channels))


def test_biotester_golden_file() -> None:
    assert biotester_bytes(small_samples()) == GOLDEN


def frame_samples() -> Samples:
    measured = {
        "Displacement": np.array([3.88711e-3, 3.9e-3, -1e-9, 12.0e-3]),
        "Force": np.array([-0.0004, 0.00004, -0.00004, 100.25]),
    }
    return replace(
        small_samples(),
        instrument="uniaxial-frame",
        time=np.array([0.0, 0.02, 0.04, 10.0]),
        measured=measured,
        clean=measured,
        offset={name: np.zeros(4) for name in measured},
    )


def test_bluehill_universal_golden_file() -> None:
    # The first three lines are those of the dialect's description.
    written = b"".join(write_log(BLUEHILL_UNIVERSAL, bluehill_channels(frame_samples())))
    assert written == (
        b"Time,Displacement,Force\r\n(s),(mm),(N)\r\n0,3.8871,-0.0004\r\n0.02,3.9,0\r\n0.04,0,0\r\n10,12,100.25\r\n"
    )


def test_biotester_opens_in_a_plain_csv_reader() -> None:
    table = list(csv.DictReader(io.StringIO(biotester_bytes(small_samples()).decode(), newline="")))
    assert len(table) == 4
    reference = float(table[0]["XSize_um"])
    strain = [float(line["XSize_um"]) / reference - 1 for line in table]
    assert strain == pytest.approx([0.0, 10 / 45000, 20 / 45000, 10 / 45000])
    assert table[3]["SetName"] == "pull, again"


def test_zeroing_the_display_does_not_move_the_hooks() -> None:
    samples = small_samples()
    samples.offset["XDisplacement"][:] = 5e-3
    channels = biotester_channels(samples, SIZE, set_name="s", temperature=22.0)
    assert channels["XSize"][0] == pytest.approx(50e-3)
    assert channels["XDisplacement"][0] == 0.0


@pytest.mark.parametrize(
    ("phase", "text"),
    [
        ("Preload", "1-Preload"),
        ("Stretch", "1-Stretch"),
        ("Recover", "1-Recover"),
        ("Hold", "1-Hold"),
        ("Zero", "1-Preload"),
    ],
)
def test_cycle_is_text(phase: str, text: str) -> None:
    assert cycle_text(1, phase) == text  # type: ignore[arg-type]


def test_the_description_decides_the_bytes() -> None:
    dialect = Dialect(
        name="tabs",
        columns=(Column(name="µ", channel="a", scale=1e6, form=".0f"), Column(name="t", channel="b")),
        delimiter="\t",
        line_end="\n",
        quote="'",
        encoding="cp1252",
    )
    written = b"".join(write_log(dialect, {"a": [1e-6, -1e-9], "b": ["x", "it's"]}))
    assert written == b"\xb5\tt\n1\tx\n0\t'it''s'\n"


def test_a_missing_channel_is_named() -> None:
    with pytest.raises(SpecificationError, match="'Cycle'"):
        list(write_log(BIOTESTER, {"SetName": []}))


def test_channels_must_be_of_one_length() -> None:
    dialect = Dialect(name="d", columns=(Column(name="a", channel="a"), Column(name="b", channel="b")))
    with pytest.raises(SpecificationError, match="one length"):
        list(write_log(dialect, {"a": [1], "b": [1, 2]}))
