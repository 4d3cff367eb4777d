"""Reading of a protocol once for every point of its sweep."""

from __future__ import annotations

from typing import TYPE_CHECKING

from app.schemas.errors import ProtocolError
from app.schemas.loading import load
from app.schemas.sweep import grid_of

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from app.schemas.document import Data
    from app.schemas.loading import Loaded, Source
    from app.schemas.sweep import Point, Scalar


def load_sweep(
    source: Source,
    chosen: Mapping[str, Data] | None = None,
    values: Mapping[str, Sequence[Scalar]] | None = None,
) -> list[tuple[Point, Loaded]]:
    """Read a protocol once for every point of its sweep, with values `chosen` for other parameters.

    Parameters
    ----------
    source : Path, str, Mapping, Protocol or Loaded
        As `load` has it.
    chosen : Mapping, optional
        Values for some of its parameters.
    values : Mapping, optional
        Values of parameters to sweep over, in the place of the protocol's own `sweep`.

    Raises
    ------
    ProtocolError
        For whatever is wrong with it or with one of the points, or if it has no sweep, in one line.
    """
    swept = load(source, chosen)
    points = swept.points
    if values:
        data = swept.document.data
        params = data.get("params") if isinstance(data, dict) else None
        points = grid_of(values, list(params) if isinstance(params, dict) else [], swept.document)
    if not points:
        spot, path = swept.document.spot(()), swept.document.path
        raise ProtocolError(path, spot, "sweep", "nothing", "a sweep, such as {pre: [0, 0.1, 0.2]}, or a sample")
    return [(point, load(source, {**(chosen or {}), **point.values})) for point in points]
