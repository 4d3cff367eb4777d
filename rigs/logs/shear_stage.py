"""The log of the shear stage: a table of every axis that it drives, with strain and stress.

It is knitlab's own, no instrument writes it. A row has, for each axis, displacement and force as its encoder and load
cell show them, strain by the gauge length and stress over the initial section. Of an axis of shear, ``WC``, the strain
is the engineering shear strain, and the stress the force on the face across the wale along the course over its section.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rigs.axes import SHEARS
from rigs.instruments.samples import parts_of
from rigs.instruments.zeros import size_in_time
from rigs.logs.dialect import Column, Dialect
from rigs.logs.logged import Log, axes_of

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigs.axes import Axis
    from rigs.instruments.samples import Samples
    from rigs.logs.dialect import Channels
    from rigs.logs.logged import Facts, Logged

STAGE: Final = "shear-stage"


def _column(name: str, channel: str, unit: str, form: str) -> Column:
    return Column(name=name, channel=channel, below="({unit})", unit=unit, form=form)


def axis_columns(axis: Axis) -> tuple[Column, ...]:
    """Return the columns of an axis.

    Examples
    --------
    >>> [column.name for column in axis_columns("WC")]
    ['Displacement WC', 'Force WC', 'Shear strain WC', 'Shear stress WC']
    """
    strain, stress = ("Shear strain", "Shear stress") if axis in SHEARS else ("Strain", "Stress")
    return (
        _column(f"Displacement {axis}", f"Displacement {axis}", "mm", ".3f"),
        _column(f"Force {axis}", f"Force {axis}", "N", ".4f"),
        _column(f"{strain} {axis}", f"Strain {axis}", "1", ".6f"),
        _column(f"{stress} {axis}", f"Stress {axis}", "kPa", ".5f"),
    )


DIALECT: Final = Dialect(name="shear-stage", columns=(_column("Time", "Time", "s", ".3f"),))


def gather(test: Logged) -> tuple[Iterator[Channels], Facts]:
    """Gather encoder and load cell of every axis, with strain and stress, in SI units."""
    return (_shown(test, samples) for samples in parts_of(test.samples[STAGE])), {}


def _shown(test: Logged, samples: Samples) -> Channels:
    """Return what the columns show of a part of the samples, in SI units."""
    size = size_in_time(samples.true_time, test.size, test.zeroings)
    channels = {"Time": samples.time.tolist()}
    named = {column: name for name, column in samples.reads.items()}
    for axis in axes_of(samples):
        travel, force = (samples.measured[named[f"{column}_{axis}"]] for column in ("crosshead", "force"))
        channels |= {
            f"Displacement {axis}": travel.tolist(),
            f"Force {axis}": force.tolist(),
            f"Strain {axis}": (travel / size.gauge(axis)).tolist(),
            f"Stress {axis}": (force / size.section(axis)).tolist(),
        }
    return channels


LOG: Final = Log(
    dialect=DIALECT,
    machines=(STAGE,),
    place="{sample}_shear.csv",
    gather=gather,
    axis_columns=axis_columns,
    about="the shear stage's: displacement, force, strain and stress of every axis",
)
