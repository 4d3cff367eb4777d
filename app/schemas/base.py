"""Base of all pydantic models of a user's YAML."""

from typing import Final

from pydantic import BaseModel, ConfigDict

# Marks the branches of a union in pydantic's locations, so that they can be told from fields.
BRANCH: Final = "|"


class Model(BaseModel):
    """A model that refuses unknown fields and silent conversions."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)
