"""Base of all pydantic models of a user's YAML."""

from typing import Final

from pydantic import BaseModel, ConfigDict

from app.schemas.field_titles import title_of

# Marks the branches of a union in pydantic's locations, so that they can be told from fields.
BRANCH: Final = "|"


class Model(BaseModel):
    """A model that refuses unknown fields and silent conversions."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True, field_title_generator=title_of)
