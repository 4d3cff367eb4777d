"""Parts of the pages by which results show themselves in a notebook."""

from __future__ import annotations

import html
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from rigs.analysis.table import Cell, Table

MOST_ROWS: Final = 60
"""Rows of a table that are shown; the table itself has all."""


def head_html(name: str, words: str) -> str:
    """Return the line above a result: its name, and how it ended."""
    return f"<p><b>{html.escape(name)}</b>, {html.escape(words)}</p>"


def table_html(table: Table) -> str:
    """Return a table of figures, its first rows where there are many."""
    rows = list(table.rows())
    left = len(rows) - MOST_ROWS
    more = f"<p>... {left} more rows</p>" if left > 0 else ""
    return f"{rows_html(rows[:MOST_ROWS], table.headings())}{more}"


def rows_html(rows: Iterable[Sequence[Cell]], headings: Sequence[str] = ()) -> str:
    """Return rows of texts and numbers as a table; numbers have four digits."""
    top = "".join(f"<th>{html.escape(one)}</th>" for one in headings)
    body = "".join(f"<tr>{''.join(f'<td>{_cell(one)}</td>' for one in row)}</tr>" for row in rows)
    return f"<table>{f'<tr>{top}</tr>' if top else ''}{body}</table>"


def folded(title: str, content: str) -> str:
    """Return content that a click unfolds."""
    return f"<details><summary>{html.escape(title)}</summary>{content}</details>"


def notes_html(notes: Iterable[str]) -> str:
    """Return what a user must know besides, as a list; nothing of none."""
    lines = "".join(f"<li>{html.escape(one)}</li>" for one in notes)
    return f"<ul>{lines}</ul>" if lines else ""


def _cell(value: Cell) -> str:
    if isinstance(value, float):
        return "" if value != value else f"{value:.4g}"  # noqa: PLR0124 (nan is what is not itself)
    return html.escape(str(value))
