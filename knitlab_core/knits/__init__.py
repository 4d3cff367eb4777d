"""Describe knits: from the stitch's formula to one yarn of nodes with named boundary sites.

stitch      five numbers in loop widths, and the sets that have a name
arclength   a loop's parameter to arc length and back
pieces      rows of loops and turn-arounds, by arc length
centreline  pieces strung to one C1 yarn, and sites on it
stockinette the planar knit
volumetric_stitch, volumetric_row, volumetric  the knit of many layers
distance    where the yarn comes closest to itself
clearance   ... refused where strands overlap
directors   frames that follow the yarn without turning about it
fibres      the fibres of a yarn, wound around its centreline
fibre_clearance  ... refused where they overlap
linking     how often closed curves wind around each other
clasp       ... whether loops hold each other
mesh        where the nodes are
filament    no knit: a straight fibre to prove a rig with
specimen    nodes in metres, checked
plates      which of them a load plate is printed around
wires       rigid wires through the boundary loops
"""

from knitlab_core.knits.arclength import yarn_per_loop
from knitlab_core.knits.centreline import Centreline, Site, SiteSet
from knitlab_core.knits.clasp import clasp_numbers
from knitlab_core.knits.clearance import check_clearance
from knitlab_core.knits.distance import Approach, closest_approach
from knitlab_core.knits.fibre_clearance import FibreClearance, check_fibres
from knitlab_core.knits.fibres import Yarn, fibre_strands, same_area
from knitlab_core.knits.filament import Filament
from knitlab_core.knits.linking import linking_number
from knitlab_core.knits.plates import Plates, plate_nodes
from knitlab_core.knits.specimen import Specimen, filament_specimen, planar_specimen, volumetric_specimen
from knitlab_core.knits.stitch import NAMED_STITCHES, Stitch, locking_strain, neighbour_gap
from knitlab_core.knits.stockinette import stockinette
from knitlab_core.knits.volumetric import volumetric
from knitlab_core.knits.volumetric_stitch import NAMED_VOLUMETRIC_STITCHES, VolumetricStitch
from knitlab_core.knits.wires import LoopWires, wires_through

__all__ = [
    "NAMED_STITCHES",
    "NAMED_VOLUMETRIC_STITCHES",
    "Approach",
    "Centreline",
    "FibreClearance",
    "Filament",
    "LoopWires",
    "Plates",
    "Site",
    "SiteSet",
    "Specimen",
    "Stitch",
    "VolumetricStitch",
    "Yarn",
    "check_clearance",
    "check_fibres",
    "clasp_numbers",
    "closest_approach",
    "fibre_strands",
    "filament_specimen",
    "linking_number",
    "locking_strain",
    "neighbour_gap",
    "planar_specimen",
    "plate_nodes",
    "same_area",
    "stockinette",
    "volumetric",
    "volumetric_specimen",
    "wires_through",
    "yarn_per_loop",
]
