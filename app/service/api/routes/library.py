"""Routes of what helps to write a protocol: the schemas of its files, and the examples."""

from typing import Annotated, Any, Literal

from fastapi import APIRouter, Path
from pydantic import ConfigDict, Field

from app import schemas
from app.schemas import materials
from app.service.api.library import examples, texts_of_example
from app.service.api.models import problems
from app.service.api.progress import Answer

router = APIRouter(tags=["laboratory"])

ExamplePath = Annotated[
    str,
    Path(pattern=r"^[A-Za-z0-9_./-]{1,128}$", description="Path of an example.", examples=["fabric/rib_course"]),
]


class ExampleView(Answer):
    """An example that is shipped."""

    model_config = ConfigDict(frozen=True, from_attributes=True)
    path: str = Field(description="path among the examples")
    group: str = Field(description="folder that it is in; empty for none")
    title: str
    purpose: str
    rig: str


class ExampleList(Answer):
    """The examples."""

    examples: list[ExampleView]


class ExampleTexts(Answer):
    """The texts of an example, as the body of a request takes them."""

    name: str = Field(description="name of the file")
    protocol: str
    materials: str = Field(description="of the file that it names under `materials`; empty for none")
    files: dict[str, str] = Field(description="of the centreline and the tables that it names, by their names")


@router.get("/v1/schemas/{kind}", summary="Return the JSON Schema of a kind of file", responses=problems(422))
def schema(
    kind: Annotated[Literal["protocol", "material"], Path(description="Protocols, or files of materials.")],
) -> dict[str, Any]:
    """Return what `knitlab schema` prints: fields, descriptions, defaults, words that are allowed."""
    return materials.json_schema() if kind == "material" else schemas.json_schema()


@router.get("/v1/examples", summary="List the examples that are shipped", responses=problems())
def list_examples() -> ExampleList:
    """Return the examples, each with the purpose that its first comment gives."""
    return ExampleList.model_validate({"examples": list(examples().values())})


@router.get(
    "/v1/examples/{path:path}", summary="Return an example with the files it names", responses=problems(404, 422)
)
def example(path: ExamplePath) -> ExampleTexts:
    """Return the texts of a protocol, its materials file and other files, as `POST /v1/jobs` takes them."""
    protocol, own, files = texts_of_example(path)
    return ExampleTexts(name=path.rpartition("/")[2], protocol=protocol, materials=own, files=files)
