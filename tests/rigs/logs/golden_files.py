"""Write the golden files again: ``python -m tests.rigs.logs.golden_files``. Nothing else does; look at what changed."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from rigs.logs.catalogue import LOGS
from rigs.logs.locales import LOCALES, localised
from rigs.logs.writer import write_log
from tests.rigs.logs.hand_made import logged

if TYPE_CHECKING:
    from collections.abc import Iterator

FOLDER = Path(__file__).parent / "golden"


def golden() -> Iterator[tuple[str, str]]:
    """Yield every dialect and locale that has a golden file; a workbook has that of its text."""
    for name, log in LOGS.items():
        if log.kind == "text":
            yield from ((name, locale) for locale in LOCALES if locale == "en" or log.dialect.delimiter == ",")


def written(name: str, locale: str) -> bytes:
    """Return the hand-made test's log."""
    log, test = LOGS[name], logged()
    return b"".join(write_log(localised(log.shown(test), locale), *log.gather(test)))


if __name__ == "__main__":
    for dialect, language in golden():
        (FOLDER / f"{dialect}.{language}").write_bytes(written(dialect, language))
