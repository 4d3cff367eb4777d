"""The scoreboard as plain data and as Markdown, and its words that page and Markdown share."""

from __future__ import annotations

from math import isfinite
from typing import TYPE_CHECKING, Any, Final

from app.studies.scoreboard.board import VERDICTS
from app.studies.scoreboard.plan import FULL, QUICK

if TYPE_CHECKING:
    from collections.abc import Iterator

    from app.studies.scoreboard.board import Board, Scored

SPECIMEN: Final = (
    "One specimen serves all planar rows: the stitch `paper-fit`, loops of 8 mm, the resin `paper-fit-resin` that "
    "relaxes and yields, friction 0.55. Stitch, friction and modulus were fitted to the four secants of rows 13 and "
    "14; the yield curve and the relaxation were chosen near the course's loops (row 15) and for a stiffer first "
    "loading (row 3). Those rows are marked as fitted and are no predictions. Rows 8 to 12 change one number or the "
    "material of that specimen; volumetric rows have the elastic RGD8530-DM, rows 22 to 24 resins that yield and "
    "break, both with a friction of 0.3."
)

TENSIONS: Final = (
    "ξ is called dimensionless but has the unit 1/(Pa² m), and α = 900 carries hidden units: β, R² and spreads count.",
    "v_C = 0.5 and v_W = 1 imply σ_C = 2 σ_W on the master curve, while the text says that the wale is stiffer.",
    "n² r⁴ is constant where the yarn's section is held, yet n is said to stiffen.",
    "The secant is said to be up to 0.4 %, beside strains of 0.4; rows 13 and 14 take 40 %, and show 0.4 % beside it.",
    "6.9e-3 MPa is a large loop for a largest stress of 0.066 MPa at 40 %: half of the work of a straight loading.",
)
"""Contradictions in the paper itself, which no row is bent to meet."""


def sizes_said(board: Board) -> str:
    """Return in words how large the specimens of a board are."""
    one = QUICK if board.quick else FULL
    return (
        f"planar {one.planar}x{one.planar} ({one.planar_nodes} nodes per loop, {one.design_nodes} for rows 8 to 11), "
        f"cotton {one.cotton}x{one.cotton}, hooks {one.hooked}x{one.hooked}, Fig. 4c {_cube(one.pulled)}, Fig. 4d and "
        f"row 20 {_cube(one.volumetric)}, Fig. 5 {_cube(one.ruptured)}"
    )


def _cube(edge: int) -> str:
    return f"{edge}x{edge}x{edge}"


def counts_said(board: Board) -> str:
    """Return in words how many rows have each verdict."""
    words = [f"{board.count(verdict)} {verdict}" for verdict in VERDICTS]
    fitted = board.count("reproduced", fitted=True)
    return f"{', '.join(words)}, of {len(board.rows)} rows; {fitted} of the reproduced were fitted in part"


def board_data(board: Board) -> dict[str, Any]:
    """Return a board as plain data; figures that are not known are null."""
    return {
        "quick": board.quick,
        "counts": {verdict: board.count(verdict) for verdict in VERDICTS},
        "failed": dict(board.failed),
        "rows": [
            {
                "row": one.row.number,
                "claim": one.row.claim.words,
                "figure": one.row.claim.where,
                "paper": one.row.claim.paper,
                "criterion": one.row.criterion,
                "fitted": one.row.fitted or None,
                "verdict": one.score.verdict,
                "ours": one.score.ours,
                "why": one.score.why,
                "values": {name: value if isfinite(value) else None for name, value in one.score.values.items()},
                "command": one.command,
                "runs": list(one.runs),
            }
            for one in board.rows
        ],
    }


def markdown_of(board: Board) -> str:
    """Return a board as the page of the documentation."""
    return "\n".join(_lines(board)) + "\n"


def _lines(board: Board) -> Iterator[str]:
    size = " --quick" * board.quick
    kind = "quick mode: small specimens, coarse meshes" if board.quick else "full size"
    yield "# Scoreboard"
    yield ""
    yield f"Made by `knitlab scoreboard{size} --markdown docs/scoreboard.md` ({kind}); edit nothing here by hand."
    yield ""
    yield f"**{counts_said(board)}.**"
    yield ""
    yield f"Sizes: {sizes_said(board)}."
    yield ""
    yield SPECIMEN
    yield ""
    yield (
        "Figures are those of `knitlab analyse` ([analysis](analysis.md)), from the records of the tests in "
        "[`examples/paper`](../examples/paper). A criterion was set before its row was run and is not moved "
        "afterwards: within 25 % of a number, sign or order of what is said in words."
    )
    yield ""
    yield "| # | claim (figure) | paper | ours | verdict | reproduced if |"
    yield "|---|---|---|---|---|---|"
    for one in board.rows:
        claim, score = one.row.claim, one.score
        fitted = " (fitted)" if one.row.fitted and score.verdict == "reproduced" else ""
        cells = (
            f"{one.row.number}",
            f"{claim.words} ({claim.where})",
            claim.paper,
            score.ours,
            f"{_emphasised(one)}{fitted}",
            one.row.criterion,
        )
        yield f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in cells)} |"
    yield ""
    yield f"A row is repeated by `knitlab scoreboard --row N{size}`; `--json` names a command for each run behind it."
    yield from _explained(board)


def _emphasised(one: Scored) -> str:
    verdict = one.score.verdict
    return verdict if verdict == "reproduced" else f"**{verdict}**"


def _explained(board: Board) -> Iterator[str]:
    others = [one for one in board.rows if one.score.verdict != "reproduced"]
    if others:
        yield ""
        yield "## Why rows differ"
        yield ""
        for one in others:
            yield f"- **{one.row.number}, {one.row.claim.words}:** {one.score.why}."
    fitted = [one for one in board.rows if one.row.fitted]
    if fitted:
        yield ""
        yield "## What was fitted"
        yield ""
        for one in fitted:
            yield f"- Row {one.row.number}: {one.row.fitted}."
    yield ""
    yield "## Tensions in the paper"
    yield ""
    for tension in TENSIONS:
        yield f"- {tension}"
