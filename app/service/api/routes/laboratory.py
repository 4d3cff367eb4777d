"""Answer what needs no job: the catalogues, and what a protocol would do."""

import threading
from dataclasses import asdict
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Any, get_args

from fastapi import APIRouter, Depends, Query, Request
from fastapi.responses import Response

from app.check import build_specimen, describe, dry_run
from app.pictures import specimen_picture
from app.plan_tables import plan_data
from app.rig_data import read_machine
from app.schemas.material_files import known_materials
from app.service.api.bodies import Submission, read_raw, submission
from app.service.api.bounds import check_plan, check_protocol
from app.service.api.context import Here, context_of
from app.service.api.documents import PROTOCOL_BODY
from app.service.api.models import MaterialList, PlanView, RigList, SpecimenView, problems
from app.service.api.problems import ProblemError
from app.tables import materials_data, specimen_data
from rigs.catalogue import CATALOGUE, MachineName
from rigs.logs.catalogue import LOGS

router = APIRouter(tags=["laboratory"])

# Drawing takes seconds of CPU and hundreds of MB: one picture at a time.
_drawing = threading.Semaphore(1)
_PATIENCE = 30.0

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
                "others": rig.sides,
                "machines": machines,
                "dialects": [dialect for dialect, log in LOGS.items() if set(log.machines) <= set(machines)],
            }
        )
    numbers = [
        {"name": name, "numbers": {part: value for part, value in asdict(read_machine(name)).items() if part != "rig"}}
        for name in get_args(MachineName)
    ]
    return RigList.model_validate({"rigs": listed, "machines": numbers})


@router.get("/v1/materials", summary="List the materials, every number with its source", responses=problems())
def materials() -> MaterialList:
    """Return the catalogue of materials."""
    return MaterialList.model_validate({"materials": list(materials_data(known_materials()).values())})


@router.post(
    "/v1/protocols:validate",
    summary="Say what a protocol would do, without physics",
    responses=problems(400, 408, 413, 415, 422),
    openapi_extra=PROTOCOL_BODY,
)
def validate(sent: Sent, here: Here) -> PlanView:
    """Return strokes, duration, rows, limits that would be passed and the arc-length budget; or what is wrong."""
    loaded = sent.load()
    check_protocol(loaded.protocol, here.bounds)
    plan = dry_run(loaded)
    check_plan(plan, here.bounds)
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
def preview(request: Request, sent: Sent, here: Here) -> Any:  # noqa: ANN401 (facts, or a picture)
    """Return what is known of a specimen before any physics; with `Accept: image/png` its picture."""
    loaded = sent.load()
    check_protocol(loaded.protocol, here.bounds)
    specimen = build_specimen(loaded)
    if "image/png" not in request.headers.get("accept", ""):
        return SpecimenView.model_validate(specimen_data(loaded.protocol, describe(specimen)))
    if not _drawing.acquire(timeout=_PATIENCE):
        raise ProblemError("busy", "another picture is being drawn", headers={"Retry-After": "10"})
    try:
        with TemporaryDirectory() as folder:
            picture = specimen_picture(specimen, Path(folder) / "specimen.png").path
            return Response(picture.read_bytes(), media_type="image/png")
    finally:
        _drawing.release()
