"""Settings of the service: data folder and database, from options, then the environment."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

from knitlab_core.errors import SpecificationError

if TYPE_CHECKING:
    from collections.abc import Mapping

DATA: Final = "knitlab-data"
_POSTGRES: Final = ("postgresql://", "postgres://", "postgresql+psycopg://")


@dataclass(frozen=True, slots=True, kw_only=True)
class Settings:
    """Data folder and database.

    Attributes
    ----------
    data : Path
        Folder of the jobs' folders; of the database too, if it is embedded.
    database : str
        URL of the database, as SQLAlchemy takes it.
    embedded : bool
        Whether the database is a file of ours: one server, nothing to install.
    """

    data: Path
    database: str
    embedded: bool

    @property
    def jobs(self) -> Path:
        """Return the folder of the jobs' folders."""
        return self.data / "jobs"


def settings(data: Path | None = None, environment: Mapping[str, str] = os.environ) -> Settings:
    """Return the settings of this process.

    Parameters
    ----------
    data : Path or None
        Data folder; None takes ``KNITLAB_DATA``, else ``knitlab-data`` in the working folder.
    environment : mapping of str to str
        ``KNITLAB_DB`` names a PostgreSQL database; without it the data folder holds an SQLite file.

    Raises
    ------
    SpecificationError
        If ``KNITLAB_DB`` is no PostgreSQL URL.
    """
    root = (data or Path(environment.get("KNITLAB_DATA") or DATA)).absolute()
    url = environment.get("KNITLAB_DB", "")
    if not url:
        return Settings(data=root, database=f"sqlite:///{root / 'knitlab.sqlite'}", embedded=True)
    if not url.startswith(_POSTGRES):
        raise SpecificationError("KNITLAB_DB", url.split(":", 1)[0] + ":…", "a URL postgresql://user@host/database")
    return Settings(data=root, database=f"postgresql+psycopg://{url.split('://', 1)[1]}", embedded=False)
