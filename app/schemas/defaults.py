"""Default values that a protocol takes without naming them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from app.schemas.specimen import YarnModel
from app.schemas.units import write
from app.schemas.yarns import MeasuredYarnModel

if TYPE_CHECKING:
    from collections.abc import Mapping

    from app.schemas.models import ProtocolModel
    from rigs.protocol.protocol import Protocol

_MESH: Final = frozenset({"mesh", "nodes_per_loop"})


def defaults_of(model: ProtocolModel, protocol: Protocol) -> Mapping[str, str]:
    """Return the defaults taken for fields that the file leaves out, by place: ``log.rate`` is ``10 Hz``.

    Parameters
    ----------
    model : ProtocolModel
        The file's content.
    protocol : Protocol
        What it was taken for.
    """
    said = {
        *model.model_fields_set,
        *(f"specimen.{name}" for name in model.specimen.model_fields_set),
        *(f"log.{name}" for name in model.log.model_fields_set),
    }
    if model.specimen.model_fields_set & _MESH:
        said.add("specimen.nodes_per_loop")
    yarn = protocol.specimen.yarn
    bonded = yarn is not None and yarn.model == "yarn" and yarn.fibres > 1
    if isinstance(model.specimen.yarn, YarnModel):
        said |= {f"specimen.yarn.{name}" for name in model.specimen.yarn.model_fields_set}
    if isinstance(model.specimen.yarn, MeasuredYarnModel) and model.specimen.yarn.friction is not None:
        said.add("specimen.friction")
    taken = {
        "speed_ref": protocol.speed_ref,
        "others": protocol.others,
        "specimen.friction": f"{protocol.specimen.friction:g}",
        "specimen.hook": protocol.hook,
        "specimen.nodes_per_loop": str(protocol.specimen.nodes_per_loop),
        **({"specimen.yarn.bonding": f"{yarn.bonding:g}"} if yarn is not None and bonded else {}),
        "log.rate": write(protocol.log.rate, "frequency"),
        "log.noise": "on" if protocol.log.noise else "off",
        "log.seed": str(protocol.log.seed),
        "max_strain_increment": f"{protocol.max_strain_increment:g}",
    }
    return {place: text for place, text in taken.items() if place not in said}


def shown_defaults(defaults: Mapping[str, str]) -> str:
    """Return defaults on one line, as a record and `knitlab check` show them.

    Examples
    --------
    >>> shown_defaults({"speed_ref": "pair", "others": "free"})
    'speed_ref: pair, others: free'
    """
    return ", ".join(f"{place}: {text}" for place, text in defaults.items())
