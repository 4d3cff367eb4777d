"""Numbers with their source."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Value:
    """A measured or assumed number with its source.

    Parameters
    ----------
    value : float
        The number, in SI.
    unit : str
        Its SI unit: ``Pa``, ``kg/m**3``; ``1`` for a pure number.
    source : str
        Where it was found, or why it was chosen.
    assumed : bool
        Whether it is a choice rather than a figure of its source.
    """

    value: float
    unit: str
    source: str
    assumed: bool = False

    def __str__(self) -> str:
        """Return the number, its unit and, where it is a choice, the word `assumed`."""
        unit = "" if self.unit == "1" else f" {self.unit}"
        return f"{self.value:g}{unit}{' (assumed)' if self.assumed else ''}"
