"""Routes that need no job: the catalogues, and the check of a protocol."""

from dataclasses import asdict
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Query, Request
from fastapi.responses import Response

from app.checks.dry_run import build_specimen, dry_run
from app.checks.specimen_facts import describe
from app.schemas import Loaded
from app.schemas.machine_data import read_machine
from app.schemas.material_files import known_materials
from app.service.api.bodies import Submission, read_raw, submission
from app.service.api.bounds import Bounds, check_rows
from app.service.api.checking import look
from app.service.api.context import Here, context_of
from app.service.api.documents import PROTOCOL_BODY
from app.service.api.models import MaterialList, PlanView, RigList, SpecimenView, problems
from app.views.plan_tables import plan_data
from app.views.renders import specimen_picture
from app.views.tables import materials_data, specimen_data
from rigs.logs.catalogue import LOGS
from rigs.machines.catalogue import MACHINES
from rigs.machines.fixtures import clamped_nodes
from rigs.machines.pins import pins_on
from rigs.protocol.catalogue import CATALOGUE

router = APIRouter(tags=["laboratory"])

Name = Annotated[
    str, Query(max_length=64, description="Name of a protocol that gives itself none.", examples=["biaxial_cycle"])
]


async def protocol_body(request: Request, name: Name = "test") -> Submission:
    """Return the protocol in the body of a request."""
    return submission(await read_raw(request, context_of(request).bounds.body), name)


Sent = Annotated[Submission, Depends(protocol_body)]


@router.get("/v1/rigs", summary="List the rigs and their machines, every number with its source", responses=problems())
def rigs() -> RigList:
    """Return the catalogue of rigs: axes, machines, the dialects of their logs, and the machines' numbers."""
    listed = []
    for name, rig in CATALOGUE.items():
        machines = list(dict.fromkeys(drive.machine for drive in rig.drives.values()))
        listed.append(
            {
                "name": name,
                "axes": rig.axes,
                "mounts_one": rig.mounts_one,
                "others": rig.others,
                "others_default": None,
                "machines": machines,
                "dialects": [dialect for dialect, log in LOGS.items() if set(log.machines) <= set(machines)],
            }
        )
    numbers = [
        {"name": name, "numbers": {part: value for part, value in asdict(read_machine(name)).items() if part != "rig"}}
        for name in MACHINES
    ]
    return RigList.model_validate({"rigs": listed, "machines": numbers})


@router.get("/v1/materials", summary="List the materials, every number with its source", responses=problems())
def materials() -> MaterialList:
    """Return the catalogue of materials."""
    return MaterialList.model_validate({"materials": list(materials_data(known_materials()).values())})


@router.post(
    "/v1/protocols:validate",
    summary="Say what a protocol would do, without physics",
    responses=problems(400, 408, 413, 415, 422, 503),
    openapi_extra=PROTOCOL_BODY,
)
async def validate(sent: Sent, here: Here) -> PlanView:
    """Return strokes, duration, rows, limits that would be passed and the arc-length budget; or what is wrong."""
    return await look(here, sent, _planned)


def _planned(loaded: Loaded, bounds: Bounds) -> PlanView:
    """Return what a protocol would do."""
    plan = dry_run(loaded)
    check_rows(plan.rows, bounds)
    return PlanView.model_validate(plan_data(plan))


@router.post(
    "/v1/specimens:preview",
    summary="Build the knit of a protocol: clearance, yarn length, budget, picture",
    responses={
        200: {"content": {"image/png": {"schema": {"type": "string", "format": "binary"}}}},
        **problems(400, 408, 413, 415, 422, 503),
    },
    openapi_extra=PROTOCOL_BODY,
    response_model=SpecimenView,
)
async def preview(request: Request, sent: Sent, here: Here) -> Any:  # noqa: ANN401 (facts, or a picture)
    """Return what is known of a specimen before any physics; with `Accept: image/png` its picture."""
    if "image/png" not in request.headers.get("accept", ""):
        return await look(here, sent, _described)
    content = await look(here, sent, _drawn, turns=here.drawing)
    return Response(content, media_type="image/png")


def _described(loaded: Loaded, _: Bounds) -> SpecimenView:
    """Return what is known of a specimen."""
    protocol = loaded.protocol
    facts = describe(build_specimen(loaded), protocol.fixtures, protocol.extensometer)
    return SpecimenView.model_validate(specimen_data(protocol, facts))


def _drawn(loaded: Loaded, _: Bounds) -> bytes:
    """Return the picture of a specimen."""
    with TemporaryDirectory() as folder:
        specimen = build_specimen(loaded)
        clamped = clamped_nodes(specimen, loaded.protocol.fixtures)
        pins = pins_on(specimen, loaded.protocol.extensometer)
        return specimen_picture(specimen, Path(folder) / "specimen.png", clamped, pins).read_bytes()
