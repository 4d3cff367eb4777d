"""Bounds on what one request may ask for, checked before memory is allocated for it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from app.checks.specimen_facts import shape_of
from app.service.api.problems import beyond
from rigs.protocol.protocol import stroke_count

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigs.protocol.protocol import Protocol
    from rigs.protocol.specimen import SpecimenSpec


@dataclass(frozen=True, slots=True, kw_only=True)
class Bounds:
    """Bounds of a service.

    Attributes
    ----------
    body, sweep_body : int
        Bytes of a request's body: of a protocol, of a sweep.
    nodes : int
        Nodes of a specimen.
    strokes : int
        Moves of the axes in a protocol, repeats counted out.
    rows : int
        Rows of a log.
    sweep, sweep_text : int
        Jobs of a sweep, characters of all their protocols and materials.
    sweep_nodes, sweep_strokes : int
        Nodes of all its specimens that differ in shape, strokes of all its protocols.
    streams : int
        Event streams open at a time.
    measured : int
        Bytes of a measured file that is laid over a job.
    """

    body: int = 1_000_000
    sweep_body: int = 8_000_000
    nodes: int = 200_000
    strokes: int = 10_000
    rows: int = 2_000_000
    sweep: int = 10_000
    sweep_text: int = 64_000_000
    sweep_nodes: int = 2_000_000
    sweep_strokes: int = 500_000
    streams: int = 64
    measured: int = 4_000_000


def node_count(spec: SpecimenSpec) -> int:
    """Estimate the number of nodes of a specimen from its numbers alone."""
    strands = spec.yarn.fibres if spec.yarn is not None and spec.yarn.model == "bundle" else 1
    # A stitch of a volumetric knit is two loops.
    loops = spec.rows * spec.loops * spec.layers * (2 if "P" in spec.axes else 1)
    return loops * spec.nodes_per_loop * strands


def check_texts(size: int, bounds: Bounds, pointer: str) -> None:
    """Refuse a sweep whose jobs have more text [characters] than the store may take.

    Raises
    ------
    ProblemError
        With the bound.
    """
    if size > bounds.sweep_text:
        raise beyond("characters of the sweep's protocols and materials", size, bounds.sweep_text, pointer=pointer)


def check_sweep(protocols: Sequence[Protocol], bounds: Bounds) -> None:
    """Refuse a sweep whose protocols are together too large to be checked.

    Raises
    ------
    ProblemError
        With the bound.
    """
    nodes = sum(map(node_count, {shape_of(protocol.specimen) for protocol in protocols}))
    strokes = sum(stroke_count(protocol.steps) for protocol in protocols)
    if nodes > bounds.sweep_nodes:
        raise beyond("nodes of the sweep", nodes, bounds.sweep_nodes)
    if strokes > bounds.sweep_strokes:
        raise beyond("strokes of the sweep", strokes, bounds.sweep_strokes)


def check_protocol(protocol: Protocol, bounds: Bounds) -> None:
    """Refuse a protocol that is too large to be checked.

    Raises
    ------
    ProblemError
        With the bound.
    """
    nodes, strokes = node_count(protocol.specimen), stroke_count(protocol.steps)
    if nodes > bounds.nodes:
        raise beyond("nodes", nodes, bounds.nodes, pointer="/specimen/loops")
    if strokes > bounds.strokes:
        raise beyond("strokes", strokes, bounds.strokes, pointer="/steps")


def check_rows(rows: int, bounds: Bounds) -> None:
    """Refuse a protocol whose log would be too long.

    Raises
    ------
    ProblemError
        With the bound.
    """
    if rows > bounds.rows:
        raise beyond("rows", rows, bounds.rows, pointer="/log/rate")
