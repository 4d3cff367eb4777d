"""Knits: from the stitch's formula to one yarn of nodes with named boundary sites.

fabric      protocol of a fabric, which all knits implement
registry    fabrics that have a name
stitch      planar stockinette (its numbers: loop_shape; its rows: pieces, planar)
garter, rib, seed  ... with purl rows, wales, or loops in turn
relaxed_stitch  ... with the loops of a cell at rest
volumetric_stitch  the knit of many layers (volumetric_shape, volumetric_row, volumetric)
chain       a chained edge: bound off, or cast on
bound_edges ... of a knit whose last row or first is chained
own_centreline  a user's own yarn, through points (curve)
filament    no knit: a straight fibre to prove a rig with
arclength   a loop's parameter to arc length and back
centreline  pieces strung to one C1 yarn, and sites on it
distance    where the yarn comes closest to itself
clearance   ... refused where strands overlap
directors   frames that follow the yarn without turning about it
fibres      the fibres of a yarn, wound around its centreline
fibre_clearance  ... refused where they overlap
clasp       ... whether loops hold each other
mesh        where the nodes are
specimen    nodes in metres, checked
cell        ... of a periodic cell, which has no edges (cell_rows)
plates      which of them a load plate is printed around
clamps      ... which of them the jaws of clamps hold
pins        spots of stitches that are followed through a test
wires       rigid wires through the boundary loops
"""

from knitlab_core.knits.arclength import yarn_per_loop
from knitlab_core.knits.bound_edges import BoundEdges
from knitlab_core.knits.cell import knit_cell
from knitlab_core.knits.cell_rows import has_cells, is_planar
from knitlab_core.knits.centreline import Centreline, Site, SiteSet
from knitlab_core.knits.clamps import Clamps, clamp_faces, clamp_nodes
from knitlab_core.knits.clasp import (
    ClaspNodes,
    clasp_counts,
    clasp_kind,
    clasp_nodes,
    clasp_numbers,
    clasp_place,
    clasps_held,
    clasps_hold,
    joined_clasps,
    parted_at,
)
from knitlab_core.knits.clearance import check_clearance
from knitlab_core.knits.distance import Approach, closest_approach
from knitlab_core.knits.fabric import Clasps, Counts, Fabric, LoopBudget, Pin, PlateRoom
from knitlab_core.knits.fibre_clearance import FibreClearance, check_fibres
from knitlab_core.knits.fibres import Yarn, fibre_strands, same_area
from knitlab_core.knits.filament import Filament
from knitlab_core.knits.loop_shape import locking_strain
from knitlab_core.knits.own_centreline import OwnCentreline
from knitlab_core.knits.pins import PinSpots, pin_spots
from knitlab_core.knits.planar import planar_line
from knitlab_core.knits.plates import Plates, plate_nodes
from knitlab_core.knits.registry import fabric_named, fabric_names, register
from knitlab_core.knits.relaxed_stitch import RelaxedStitch, relaxed_stitch
from knitlab_core.knits.specimen import Cell, Specimen, knit_specimen
from knitlab_core.knits.stitch import NAMED_STITCHES, Stitch
from knitlab_core.knits.volumetric import volumetric
from knitlab_core.knits.volumetric_stitch import NAMED_VOLUMETRIC_STITCHES, VolumetricStitch
from knitlab_core.knits.wires import LoopWires, wires_through

__all__ = [
    "NAMED_STITCHES",
    "NAMED_VOLUMETRIC_STITCHES",
    "Approach",
    "BoundEdges",
    "Cell",
    "Centreline",
    "Clamps",
    "ClaspNodes",
    "Clasps",
    "Counts",
    "Fabric",
    "FibreClearance",
    "Filament",
    "LoopBudget",
    "LoopWires",
    "OwnCentreline",
    "Pin",
    "PinSpots",
    "PlateRoom",
    "Plates",
    "RelaxedStitch",
    "Site",
    "SiteSet",
    "Specimen",
    "Stitch",
    "VolumetricStitch",
    "Yarn",
    "check_clearance",
    "check_fibres",
    "clamp_faces",
    "clamp_nodes",
    "clasp_counts",
    "clasp_kind",
    "clasp_nodes",
    "clasp_numbers",
    "clasp_place",
    "clasps_held",
    "clasps_hold",
    "closest_approach",
    "fabric_named",
    "fabric_names",
    "fibre_strands",
    "has_cells",
    "is_planar",
    "joined_clasps",
    "knit_cell",
    "knit_specimen",
    "locking_strain",
    "parted_at",
    "pin_spots",
    "planar_line",
    "plate_nodes",
    "register",
    "relaxed_stitch",
    "same_area",
    "volumetric",
    "wires_through",
    "yarn_per_loop",
]
