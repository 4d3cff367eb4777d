"""Pydantic models of a job's progress, with what happened to its specimen so far."""

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field


class Answer(BaseModel):
    """Base of all answers."""

    model_config = ConfigDict(frozen=True)


class CrossingView(Answer):
    """Where a fibre first passed a limit of its material."""

    model_config = ConfigDict(frozen=True, from_attributes=True)
    name: Literal["strength", "elongation at break"]
    limit: float = Field(description="strain of a fibre's surface at the limit")
    row: int = Field(description="first row beyond it")
    time: float = Field(description="time of that row [s]")
    strain: dict[str, float] = Field(description="strain of every driven axis there")
    fibre_strain: float = Field(description="strain of the most strained fibre there")
    text: str = Field(description="the same for people")


class LossView(Answer):
    """Where clasps of the knit let go: the yarn of a held loop left the head that held it."""

    model_config = ConfigDict(frozen=True, from_attributes=True)
    joined: str = Field(description="what the clasps join: rows, layers, or bound_off or cast_on, a chained edge")
    row: int = Field(description="first row at which they do not hold")
    time: float = Field(description="time of that row [s]")
    strain: dict[str, float] = Field(description="strain of every driven axis there")
    lost: int = Field(description="clasps that let go there")
    held: int = Field(description="clasps that hold still")
    mounted: int = Field(description="clasps that held as mounted")
    places: str = Field(default="", description="where, of clasps that were lost before the test")
    text: str = Field(description="the same for people")


class ProgressView(Answer):
    """Progress of a job."""

    model_config = ConfigDict(frozen=True, from_attributes=True)
    share: float = Field(description="share of the protocol that is done, 0 to 1")
    text: str = Field(description="what is being done, for people")
    strain: dict[str, float] = Field(description="strain of every driven axis")
    force: dict[str, float] = Field(description="force of every driven axis [N]")
    seconds_left: float | None = Field(description="estimate of the time to the end [s]")
    rows: int = Field(description="equilibria so far")
    crossings: list[CrossingView] = Field(
        default=[],
        description="limits of the material that fibres passed: curves are not to be believed beyond the first",
    )
    losses: list[LossView] = Field(default=[], description="clasps that let go, at most the first hundred rows")
