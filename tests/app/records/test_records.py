import os
import signal
import subprocess
import sys
import textwrap
from dataclasses import fields, replace
from pathlib import Path

import h5py
import numpy as np
import pytest

from app.records.export import export_log
from app.records.folder import make_run_folder, whole_file, write_whole
from app.records.layout import make_record
from app.records.reader import RunReader
from app.records.writer import RunWriter
from app.schemas.machine_data import read_machine
from knitlab_core.errors import FormatError, SpecificationError
from rigs.instruments.channels import Instrument, measure
from rigs.machines.machine import instrument_of
from rigs.protocol.catalogue import MachineName
from rigs.record import Outcome, units
from rigs.trace import trace_of
from tests.synthetic_run import BOTH, PROTOCOL, SIZE, knit_nodes, make_run, row, rows, stage_instrument

ROOT = Path(__file__).parents[3]


def writer(path: Path, instrument: Instrument | None = None) -> RunWriter:
    return RunWriter(
        make_record(
            path,
            protocol="name: ü\n",
            size=SIZE,
            axes=BOTH,
            strands=[4],
            instruments=[stage_instrument() if instrument is None else instrument],
            provenance={"seed": 1},
        )
    )


def test_tags_may_be_in_any_script(tmp_path: Path) -> None:
    with writer(tmp_path / "run.h5") as run:
        run.append(replace(row(0.0, 0.0, 1, "Hold"), tag="Prüfung"))
        run.append(replace(row(1.0, 0.0, 1, "Hold"), tag=None))
    read = RunReader(tmp_path / "run.h5")
    assert read.trace.tag == ("Prüfung", None)
    assert read.protocol == "name: ü\n"


def test_what_is_written_is_read(tmp_path: Path) -> None:
    run = make_run(tmp_path / "run.h5")
    trace = trace_of(rows())
    assert run.protocol == PROTOCOL
    assert run.size == SIZE
    assert run.outcome == Outcome(end="target")
    assert run.provenance["seed"] == 7
    assert run.provenance["thickness_convention"] == "unit"
    assert (run.trace.phase, run.trace.tag) == (trace.phase, trace.tag)
    for name in units(BOTH):
        assert run.trace.columns[name].tolist() == trace.columns[name].tolist()
    frames = run.frames()
    assert [round(frame.strain["C"], 6) for frame in frames] == [0.0, 0.2, 0.4]
    assert frames[2].nodes.tolist() == knit_nodes(0.4).tolist()
    assert len(frames[0].axial_strain) == len(frames[0].nodes) - 1
    samples = run.samples["biaxial-hook"]
    assert samples.measured["XForce"].shape == samples.time.shape
    assert (samples.units["XForce"], samples.reads["XForce"]) == ("N", "force_C")
    assert samples.tag[0] == "equibiaxial"


def test_layout_is_the_documented_one(tmp_path: Path) -> None:
    make_run(tmp_path / "run.h5")
    with h5py.File(tmp_path / "run.h5") as file:
        assert set(file) >= {"equilibria", "channels", "VTKHDF", "protocol"}
        assert set(file["equilibria"]) == {*units(BOTH), "phase", "tag", "checksum"}
        assert file["equilibria/force_C"].attrs["units"] == "N"
        assert file["channels/biaxial-hook/XForce"].attrs["units"] == "N"
        assert set(file["channels/biaxial-hook/clean"]) == {"XDisplacement", "YDisplacement", "XForce", "YForce"}
        assert file["equilibria/cycle"].dtype.kind == "i"
        assert file["outcome"].attrs["end"] == b"target"


def test_a_message_too_long_is_cut_not_lost(tmp_path: Path) -> None:
    with writer(tmp_path / "run.h5") as run:
        run.finish(Outcome(end="diverged", message="ü" * 2000))
    outcome = RunReader(tmp_path / "run.h5").outcome
    assert outcome.end == "diverged"
    assert outcome.message == "ü" * 512


def test_a_run_that_goes_on_can_be_looked_into(tmp_path: Path) -> None:
    with writer(tmp_path / "run.h5") as run:
        for one in rows(2)[:3]:
            run.append(one)
        seen = RunReader(tmp_path / "run.h5")
    assert len(seen.trace) == 3
    assert seen.outcome.end == "abort"
    assert seen.samples == {}


def test_another_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "run.h5").write_bytes(b"not a run")
    with pytest.raises(FormatError, match="record of a run"):
        RunReader(tmp_path / "run.h5")
    with h5py.File(tmp_path / "other.h5", "w") as file:
        file["x"] = 1
    with pytest.raises(FormatError, match="record of a run"):
        RunReader(tmp_path / "other.h5")
    with pytest.raises(FileNotFoundError):
        RunReader(tmp_path / "none.h5")


KILLED = textwrap.dedent(
    """
    import sys
    from dataclasses import fields, replace
    from pathlib import Path
    from tests.app.records.test_records import writer
    from tests.synthetic_run import frame, row
    from rigs.record import Frame
    import numpy as np
    with writer(Path(sys.argv[1])) as run:
        for k in range(10**6):
            run.append(replace(row(float(k), 0.1, 1, "Stretch"), tag=f"tag {k // 50}"))
            if k % 10 == 0:
                run.add_frame(Frame(time=float(k), nodes=np.full((4, 3), 1.0 + k), axial_strain=np.ones(3),
                                    bending_strain=np.ones(3), contact_force=np.ones(4),
                                    strain={"C": 0.1, "W": 0.1}, cycle=1, phase="Stretch"))
            print(k, flush=True)
    """
)


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="kill -9 is Unix")
@pytest.mark.parametrize("after", [3, 57, 140])
def test_a_killed_run_keeps_every_accepted_row(tmp_path: Path, after: int) -> None:
    path = tmp_path / "run.h5"
    command = [sys.executable, "-P", "-c", KILLED, str(path)]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    with subprocess.Popen(command, stdout=subprocess.PIPE, env=environment, text=True) as process:  # noqa: S603
        if process.stdout is None:
            pytest.fail("no pipe")
        accepted = [int(process.stdout.readline()) for _ in range(after)][-1]
        process.kill()
        accepted = max([accepted, *(int(line) for line in process.stdout if line.endswith("\n"))])
    run = RunReader(path)
    assert len(run.trace) >= accepted + 1
    assert run.trace.columns["time"].tolist() == list(range(len(run.trace)))
    assert run.trace.tag[accepted] == f"tag {accepted // 50}"
    assert run.outcome.end == "abort"
    frames = run.frames()
    assert len(frames) >= accepted // 10
    assert all(np.all(one.nodes == 1.0 + one.time) for one in frames)
    with h5py.File(path) as file:
        assert len(file["equilibria/time"]) >= accepted + 1


def test_a_run_folder_is_never_overwritten(tmp_path: Path) -> None:
    wanted = tmp_path / "runs" / "a"
    assert make_run_folder(wanted) == wanted
    assert make_run_folder(wanted) == wanted  # still empty
    (wanted / "run.h5").touch()
    assert make_run_folder(wanted).name == "a-2"
    (tmp_path / "runs" / "a-2" / "run.h5").touch()
    assert make_run_folder(wanted).name == "a-3"


def test_a_file_is_whole_or_not_there(tmp_path: Path) -> None:
    path = write_whole(tmp_path / "log.csv", [b"a\r\n", b"b\r\n"])
    assert path.read_bytes() == b"a\r\nb\r\n"
    with pytest.raises(ZeroDivisionError):
        _fail_half_way(path)
    assert path.read_bytes() == b"a\r\nb\r\n"
    assert [one.name for one in tmp_path.iterdir()] == ["log.csv"]


def _fail_half_way(path: Path) -> None:
    with whole_file(path) as temporary:
        temporary.write_bytes(b"half")
        raise ZeroDivisionError


def test_log_is_exported_from_the_record(tmp_path: Path) -> None:
    run = make_run(tmp_path / "run.h5")
    path = export_log(run, tmp_path / "new", "biotester")
    assert path == tmp_path / "new" / "synthetic.csv"
    lines = path.read_bytes().split(b"\r\n")
    assert lines[0].startswith(b"SetName,Cycle,Time_S")
    assert len(lines) == len(run.samples["biaxial-hook"].time) + 2
    assert lines[1].startswith(b"equibiaxial,1-Preload,0.000,22.0,")
    assert lines[1].endswith(b",0,0,0.00,0.00")
    with pytest.raises(SpecificationError, match="one of biotester"):
        export_log(run, tmp_path, "none")
    with pytest.raises(SpecificationError, match="a run on uniaxial-frame"):
        export_log(run, tmp_path, "bluehill3")


def test_a_record_with_a_name_that_leaves_the_folder_is_refused(tmp_path: Path) -> None:
    make_run(tmp_path / "run.h5")
    with h5py.File(tmp_path / "run.h5", "r+") as file:
        file.attrs["name"] = "../../elsewhere"
    with pytest.raises(SpecificationError, match=r"run\.name: found '\.\./"):
        export_log(RunReader(tmp_path / "run.h5"), tmp_path, "biotester")


def test_clocks_and_delays_are_in_the_record(tmp_path: Path) -> None:
    instrument = replace(stage_instrument(), offset=0.3, skew=0.01)
    first, *others = instrument.channels
    instrument = replace(instrument, channels=(replace(first, delay=0.002), *others))
    with writer(tmp_path / "run.h5", instrument) as run:
        for one in rows():
            run.append(one)
        run.write_samples(measure(instrument, trace_of(rows()), seed=0))
    samples = RunReader(tmp_path / "run.h5").samples["biaxial-hook"]
    assert (samples.clock_offset, samples.clock_skew) == (0.3, 0.01)
    assert samples.delay == {first.name: 0.002}
    assert samples.true_time[:2] == pytest.approx([0.0, 0.1 / 1.01])


@pytest.mark.parametrize("machine", ["biaxial-hook", "uniaxial-frame", "nanoindenter"])
def test_rig_data_says_where_every_number_comes_from(machine: MachineName) -> None:
    data = read_machine(machine)
    # The paper gives a speed for what it prints in millimetres, and for the indenter a strain rate.
    assert (data.carriage.speed.value == 0.2e-3) == (not data.carriage.speed.assumed) == (machine != "nanoindenter")
    assert data.load_cell.limit.assumed
    parts = [data.carriage, data.pole, *data.cells, data.encoder, data.clock, data.convention]
    for part in parts:
        for field in () if part is None else fields(part):
            datum = getattr(part, field.name)
            assert datum is None or datum.source
    # Of the stage nothing is known beyond what every machine must have.
    assert (data.carriage.capacity is None) == (machine == "biaxial-hook")
    assert (data.pole is None) == (data.carriage.gap is not None) == (machine == "nanoindenter")


def test_the_frame_has_cells_to_choose_from() -> None:
    data = read_machine("uniaxial-frame")
    assert [cell.limit.value for cell in data.cells] == [500.0, 1000.0, 2000.0]
    strong = data.fitted(2000.0)
    assert strong is not None
    assert (strong.load_cell, strong.cells) == (data.cells[2], (data.cells[2],))
    assert strong.load_cell.noise.value > data.load_cell.noise.value
    assert data.fitted(300.0) is None


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("  noise:", "  nose:", r"bad\.yaml:\d+: .*'nose'"),
        ("value: 100.0", "value: lots", r"bad\.yaml:\d+: .*found 'lots'"),
        ("    assumed: true\n", "", r"also assumed"),
        ("rig: biaxial-hook", "rig: [", r"YAML"),
        ("rig: biaxial-hook", "rig: true", r"a str, found True"),
    ],
)
def test_bad_rig_data_is_refused_with_its_line(tmp_path: Path, old: str, new: str, message: str) -> None:
    text = (ROOT / "rigs" / "data" / "biaxial_hook.yaml").read_text()
    bad = tmp_path / "bad.yaml"
    bad.write_text(text.replace(old, new))
    with pytest.raises(FormatError, match=message):
        read_machine("biaxial-hook", bad)


def test_rig_data_of_another_machine_is_refused() -> None:
    with pytest.raises(FormatError, match="the numbers of uniaxial-frame"):
        read_machine("uniaxial-frame", ROOT / "rigs" / "data" / "biaxial_hook.yaml")


def test_a_frame_bears_no_more_than_its_capacity() -> None:
    data = read_machine("uniaxial-frame")
    limits = {channel.name: channel.limit for channel in instrument_of("uniaxial-frame", data, ["P"], 1.0).channels}
    assert limits == {"Displacement": 0.6, "Force": 500.0}
    strong = replace(data.load_cell, limit=replace(data.load_cell.limit, value=5e3))
    _, force = instrument_of("uniaxial-frame", replace(data, load_cell=strong), ["P"], 1.0).channels
    assert force.limit == 2e3


def test_a_record_of_another_layout_is_refused(tmp_path: Path) -> None:
    make_run(tmp_path / "run.h5")
    with h5py.File(tmp_path / "run.h5", "r+") as file:
        file.attrs["layout"] = 1
    with pytest.raises(FormatError, match="a run in layout 4"):
        RunReader(tmp_path / "run.h5")


def test_row_is_flushed_before_append_returns(tmp_path: Path) -> None:
    with writer(tmp_path / "run.h5") as run:
        run.append(row(0.0, 0.0, 1, "Zero"))
        copy = tmp_path / "copy.h5"
        copy.write_bytes((tmp_path / "run.h5").read_bytes())
        assert len(RunReader(copy).trace) == 1
