"""The scoreboard as one HTML file with its figures in it, which needs no network."""

from __future__ import annotations

from html import escape
from typing import TYPE_CHECKING, Final

from app.studies.scoreboard.curves import CLAIMS, figures_of
from app.studies.scoreboard.report import SPECIMEN, TENSIONS, counts_said, sizes_said
from app.views.score_figures import svg_of

if TYPE_CHECKING:
    from collections.abc import Iterator

    from app.studies.scoreboard.board import Board, Scored
    from app.views.score_figures import Drawn

STYLE: Final = """
body { font: 16px/1.5 system-ui, sans-serif; color: #1b1b1b; background: #fff; margin: 0 auto; max-width: 78rem;
  padding: 1.5rem; }
h1 { margin: 0 0 .3rem; } h2 { margin: 2.2rem 0 .6rem; } code { font-size: .9em; }
figure { margin: 0 0 2rem; display: grid; grid-template-columns: minmax(0, 3fr) minmax(16rem, 2fr); gap: 1.2rem;
  border-top: 1px solid #ddd; padding-top: 1rem; align-items: start; }
figure svg { width: 100%; height: auto; }
figcaption h3 { margin: 0 0 .5rem; } figcaption ul { padding: 0; margin: 0; list-style: none; font-size: .9rem; }
figcaption li { margin-bottom: .6rem; }
table { border-collapse: collapse; width: 100%; font-size: .88rem; } .wide { overflow-x: auto; }
th, td { text-align: left; vertical-align: top; padding: .45rem .6rem; border-bottom: 1px solid #e2e2e2; }
th { position: sticky; top: 0; background: #f4f4f4; }
.verdict { font-weight: 600; white-space: nowrap; } .why { color: #444; }
.reproduced { color: #00694b; } .differs { color: #a8430a; } .not { color: #555; }
@media (max-width: 60rem) { figure { grid-template-columns: 1fr; } }
"""


def page_of(board: Board) -> str:
    """Return a board as HTML: figures redrawn with their claims beside them, then all rows."""
    return "\n".join(
        (
            '<!doctype html><html lang="en"><head><meta charset="utf-8">',
            '<meta name="viewport" content="width=device-width, initial-scale=1">',
            f"<title>knitlab scoreboard</title><style>{STYLE}</style></head><body>",
            "<h1>Scoreboard: the paper's claims in the virtual lab</h1>",
            f"<p><strong>{escape(counts_said(board))}.</strong> {_sizes(board)}</p>",
            f"<p>{_marked(SPECIMEN)}</p>",
            "<h2>Figures, redrawn from the lab's logs</h2>",
            *(_figure(one, board) for one in figures_of(board.runs)),
            "<h2>All claims</h2>",
            *_table(board),
            "<h2>Tensions in the paper</h2><ul>",
            *(f"<li>{escape(one)}</li>" for one in TENSIONS),
            "</ul></body></html>",
        )
    )


def _sizes(board: Board) -> str:
    return f"{'Quick mode' if board.quick else 'Full size'}: {escape(sizes_said(board))}."


def _marked(text: str) -> str:
    """Return a text as HTML; what is between backquotes is code."""
    parts = escape(text).split("`")
    return "".join(f"<code>{part}</code>" if number % 2 else part for number, part in enumerate(parts))


def _figure(drawn: Drawn, board: Board) -> str:
    rows = [one for one in board.rows if one.row.number in CLAIMS[drawn.name]]
    claims = "".join(
        f"<li><b>{one.row.number}</b> {escape(one.row.claim.words)} <i>({escape(one.row.claim.paper)})</i><br>"
        f"{_verdict(one)} {escape(one.score.ours)}</li>"
        for one in rows
    )
    caption = f"<h3>Fig. {drawn.name}: {escape(drawn.title)}</h3><ul>{claims}</ul>"
    label = f'<svg role="img" aria-label="Fig. {drawn.name}: {escape(drawn.title)}"'
    return f"<figure>{svg_of(drawn).replace('<svg', label, 1)}<figcaption>{caption}</figcaption></figure>"


def _verdict(one: Scored) -> str:
    verdict = one.score.verdict
    fitted = " (fitted)" if one.row.fitted and verdict == "reproduced" else ""
    return f'<span class="verdict {verdict.split()[0]}">{verdict}{fitted}</span>'


def _table(board: Board) -> Iterator[str]:
    yield '<div class="wide"><table><thead><tr>'
    yield "".join(f"<th>{name}</th>" for name in ("#", "claim", "paper", "ours", "verdict", "reproduced if", "repeat"))
    yield "</tr></thead><tbody>"
    for one in board.rows:
        why = f'<div class="why">{escape(one.score.why)}</div>' if one.score.why else ""
        cells = (
            str(one.row.number),
            f"{escape(one.row.claim.words)} ({escape(one.row.claim.where)})",
            escape(one.row.claim.paper),
            f"{escape(one.score.ours)}{why}",
            _verdict(one),
            escape(one.row.criterion),
            f"<code>{escape(one.command)}</code>",
        )
        yield f"<tr>{''.join(f'<td>{cell}</td>' for cell in cells)}</tr>"
    yield "</tbody></table></div>"
