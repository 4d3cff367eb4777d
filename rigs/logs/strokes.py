"""Number the strokes of a test as Bluehill 3 does: segment identities and the total cycle count."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from rigs.instruments import Samples
    from rigs.record import FloatArray

OUTWARD: Final = 22476
RETURN: Final = 22412
COUNTED_AFTER: Final = 0.01
"""Share of a stroke after a turnaround at which the cycle is counted."""


def segments(samples: Samples) -> list[int]:
    """Return the segment identity of every sample: outward, return, or, at rest, that of the stroke before."""
    found, current = [], OUTWARD
    for phase in samples.phase:
        current = {"Stretch": OUTWARD, "Recover": RETURN}.get(phase, current)
        found.append(current)
    return found


def cycle_counts(samples: Samples, travel: FloatArray) -> list[int]:
    """Return the total cycle count of every sample.

    It starts at 0 and rises when an outward stroke that follows a return has made 1 % of its way.

    Parameters
    ----------
    samples : Samples
        What the machine logged.
    travel : FloatArray, shape (n,)
        Its displacement without noise [m].
    """
    counts = np.zeros(len(samples.time), dtype=np.int64)
    returned = False
    going = [phase == "Stretch" for phase in samples.phase]
    for k, phase in enumerate(samples.phase):
        if phase == "Recover":
            returned = True
        elif going[k] and not going[k - 1] and returned:
            returned = False
            end = next((i for i in range(k, len(going)) if not going[i]), len(going)) - 1
            # It turned between two samples, or at the lower of them.
            way = travel[k : end + 1] - travel[k - 1 : k + 1].min()
            first = k + int(np.argmax(way >= COUNTED_AFTER * way[-1]))
            counts[first:] += 1
    return [int(count) for count in counts]
