"""Tests of the scoreboard: which protocol, with which values of its parameters."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import product
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from app.schemas.sweep import Scalar

FOLDER: Final = "examples/paper"
"""Where the protocols are, from the folder in which the command is given."""

BASE: Final[Mapping[str, Scalar]] = {"a": 1.55, "h": 4.88, "d": 2.0, "w": 5.36, "r": 0.316, "l": 8.0, "n": 1}
"""Numbers of the declared planar specimen: a and n [1], lengths [mm]; those of `fig3c.yaml`."""

CHANGED: Final[Mapping[str, tuple[float, ...]]] = {
    "a": (1.45, 1.5, 1.6, 1.65),
    "h": (4.64, 4.76, 5.0, 5.12),
    "d": (1.8, 1.9, 2.1, 2.2),
    "r": (0.27, 0.29, 0.34, 0.36),
    "l": (7.5, 7.75, 8.25, 8.5),
    "n": (2, 3, 4, 6),
}
"""Values of each number of which the others stay; the row spacing w follows the height h."""

MATERIALS: Final = ("RGD8530-DM", "VeroUltraWhite")
"""The paper's two resins, as the catalogue has them."""

PRE_STRAINS: Final = (0.0, 0.1, 0.2, 0.3, 0.4)
PILE_PRE_STRAINS: Final = (0.0, 0.1, 0.2)
POLE: Final = 0.1
"""Friction of hooks on their poles in the test that has some [1]."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Test:
    """One test.

    Attributes
    ----------
    name : str
        What rows call it.
    protocol : str
        File in the folder of the protocols.
    values : Mapping
        Values of its parameters.
    weight : float
        How long it takes beside others [1]; the longest begin first.
    simulated : bool
        Whether it is run; of others the specimen alone is looked at.
    """

    name: str
    protocol: str
    values: Mapping[str, Scalar] = field(default_factory=dict)
    weight: float = 1.0
    simulated: bool = True


@dataclass(frozen=True, slots=True, kw_only=True)
class Sizes:
    """How large the specimens are, and how finely their yarns are divided.

    Attributes
    ----------
    planar, planar_nodes, design_nodes : int
        Rows and loops of planar specimens, nodes per loop; nodes per loop where a number of the stitch is changed.
    cotton, hooked : int
        Rows and loops of the cotton, and of the specimen on hooks that rub.
    volumetric, pulled, ruptured : int
        Rows, stitches and layers of the volumetric knits of Fig. 4d, of Fig. 4c and of Fig. 5.
    nodes, ruptured_nodes : int
        Their nodes per loop.
    pre_strains : tuple of float
        Those of Fig. 3d [1].
    """

    planar: int
    planar_nodes: int
    design_nodes: int
    cotton: int
    hooked: int
    volumetric: int
    pulled: int
    ruptured: int
    nodes: int
    ruptured_nodes: int
    pre_strains: tuple[float, ...]


FULL: Final = Sizes(
    planar=6,
    planar_nodes=48,
    design_nodes=32,
    cotton=3,
    hooked=3,
    volumetric=4,
    pulled=4,
    ruptured=2,
    nodes=32,
    ruptured_nodes=32,
    pre_strains=PRE_STRAINS,
)
QUICK: Final = Sizes(
    planar=3,
    planar_nodes=24,
    design_nodes=24,
    cotton=3,
    hooked=2,
    volumetric=2,
    pulled=2,
    ruptured=2,
    nodes=24,
    ruptured_nodes=16,
    pre_strains=(0.0, 0.2, 0.4),
)


def all_tests(sizes: Sizes) -> dict[str, Test]:
    """Return the tests by their names."""
    found = (*_planar(sizes), *_designs(sizes), *_volumetric(sizes), *_topologies())
    return {test.name: test for test in found}


def design_names() -> list[str]:
    """Return the names of the tests with a number or the material of the specimen changed, its own first."""
    changed = [f"fig3c {name}={value:g}" for name, values in CHANGED.items() for value in values]
    return ["fig3c", *changed, *(f"fig3c {material}" for material in MATERIALS)]


def _planar(sizes: Sizes) -> Iterator[Test]:
    size: dict[str, Scalar] = {"rows": sizes.planar, "nodes": sizes.planar_nodes}
    yield Test(name="fig3a", protocol="fig3a.yaml", values=size, weight=12.0)
    yield Test(name="control", protocol="control.yaml", values=size, weight=4.0)
    for axis in ("C", "W"):
        yield Test(name=f"uniaxial {axis}", protocol="uniaxial.yaml", values={"axis": axis, **size}, weight=3.0)
    for along, pre in product(("course", "wale"), sizes.pre_strains):
        values: dict[str, Scalar] = {"pre": pre, **size}
        yield Test(name=f"fig3d {along} {pre:g}", protocol=f"fig3d_{along}.yaml", values=values, weight=10.0)
    for pole in (0.0, POLE):
        rubbing: dict[str, Scalar] = {"pole": pole, "rows": sizes.hooked, "nodes": sizes.design_nodes}
        yield Test(name=f"hooks {pole:g}", protocol="hooks.yaml", values=rubbing)
    cotton: dict[str, Scalar] = {"rows": sizes.cotton, "nodes": sizes.design_nodes}
    yield Test(name="cotton", protocol="cotton.yaml", values=cotton, weight=20.0)


def _designs(sizes: Sizes) -> Iterator[Test]:
    size: dict[str, Scalar] = {"rows": sizes.planar, "nodes": sizes.design_nodes}
    yield Test(name="fig3c", protocol="fig3c.yaml", values=size)
    for name, values in CHANGED.items():
        for value in values:
            yield Test(name=f"fig3c {name}={value:g}", protocol="fig3c.yaml", values={**changed(name, value), **size})
    for material in MATERIALS:
        yield Test(name=f"fig3c {material}", protocol="fig3c.yaml", values={"material": material, **size})


def changed(name: str, value: float) -> dict[str, Scalar]:
    """Return the values that a protocol is given where one number of the specimen is changed."""
    if name in {"a", "n"}:
        return {name: int(value) if name == "n" else value}
    found: dict[str, Scalar] = {name: f"{value:g} mm"}
    if name == "h":
        found["w"] = f"{float(BASE['w']) + value - float(BASE['h']):g} mm"
    return found


def _volumetric(sizes: Sizes) -> Iterator[Test]:
    for axis in ("C", "W", "P"):
        values = {"axis": axis, **_block(sizes.pulled, sizes.nodes)}
        yield Test(name=f"fig4c {axis}", protocol="fig4c.yaml", values=values, weight=3.0 * sizes.pulled)
    for pre in PILE_PRE_STRAINS:
        values = {"pre": pre, **_block(sizes.volumetric, sizes.nodes)}
        yield Test(name=f"fig4d {pre:g}", protocol="fig4d.yaml", values=values, weight=2.0 * sizes.volumetric)
    block = _block(sizes.volumetric, sizes.nodes)
    yield Test(name="volumetric", protocol="volumetric_equibiaxial.yaml", values=block, weight=2.0)
    block = _block(sizes.ruptured, sizes.ruptured_nodes)
    yield Test(name="fig5 micro", protocol="fig5_micro.yaml", values=block, weight=100.0)
    yield Test(name="fig5 macro", protocol="fig5_macro.yaml", values=block, weight=50.0)


def _block(edge: int, nodes: int) -> dict[str, Scalar]:
    """Return the values of a volumetric knit with as many rows and stitches as layers."""
    return {"rows": edge, "layers": edge, "nodes": nodes}


def _topologies() -> Iterator[Test]:
    for rows, layers in ((4, 2), (6, 6)):
        values: dict[str, Scalar] = {"rows": rows, "layers": layers}
        name = f"topology {rows}x{rows}x{layers}"
        yield Test(name=name, protocol="fig4c.yaml", values=values, simulated=False)
