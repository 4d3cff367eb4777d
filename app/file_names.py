"""Names of files and folders from texts: safe on Linux, macOS and Windows, and unique to the text.

A text of letters and digits of any script, blanks and the signs ``. _ - = , +`` is used as it is. In any other text the
characters that a file system forbids become ``_``, and eight digits of its hash follow, so that texts which differ only
in such characters have different names. Names that differ only in capitals are the same on macOS and Windows; who
creates a folder has to check that.
"""

from __future__ import annotations

import hashlib
import re
import unicodedata
from typing import Final

MOST_SIGNS: Final = 96
"""Characters in a name; a run nests two of them, and Windows allows 260 in a path."""

MOST_BYTES: Final = 160
"""Bytes of UTF-8 in a name; Linux allows 255, and suffixes follow."""

_SIGNS: Final = frozenset(" ._-=,+")
#: Letters and marks that are never drawn (Default_Ignorable_Code_Point): HFS+ takes names with and without for one.
_UNSEEN: Final = re.compile(
    "[\u034f\u115f\u1160\u17b4\u17b5\u180b-\u180f\u3164\ufe00-\ufe0f\uffa0\U000e0100-\U000e01ef]"
)
#: Devices of Windows, with any extension.
_RESERVED: Final = re.compile(
    r"(con|prn|aux|nul|conin\$|conout\$|clock\$|(com|lpt)[0-9\u00b9\u00b2\u00b3])\s*(\..*)?", re.IGNORECASE
)
_HASHED: Final = re.compile(r".*-[0-9a-f]{8}", re.IGNORECASE | re.DOTALL)


def file_stem(text: str) -> str:
    """Return the name of files and folders for a text; the same for every way to encode its characters (NFC).

    Parameters
    ----------
    text : str
        Any text.

    Returns
    -------
    str
        A name without a suffix: no device of Windows, no dot or blank at an end, at most `MOST_SIGNS` long.

    Examples
    --------
    >>> file_stem("biaxial_cycle"), file_stem("Prüfling"), file_stem("knit (2)")
    ('biaxial_cycle', 'Prüfling', 'knit_2-2c4af33b')
    """
    plain = unicodedata.normalize("NFC", text)
    if _is_safe(plain) and not _HASHED.fullmatch(plain):
        return plain
    digits = hashlib.sha256(plain.encode("utf-8", "surrogatepass")).hexdigest()[:8]
    # On Windows `con.x` is a device too, so no dot is kept.
    kept = "".join(sign if _is_kept(sign) and sign not in " ." else "_" for sign in plain)
    short = re.sub(r"^[\W_]+", "", re.sub("_+", "_", kept))[: MOST_SIGNS // 2]
    cut = short.encode()[: MOST_BYTES // 2].decode(errors="ignore").rstrip("_-=,+")
    return f"{cut or 'test'}-{digits}"


def _is_safe(text: str) -> bool:
    """Return whether a text can name a file on every system as it is."""
    short = 0 < len(text) <= MOST_SIGNS and len(text.encode("utf-8", "surrogatepass")) <= MOST_BYTES
    if not short or not all(map(_is_kept, text)) or _RESERVED.fullmatch(text):
        return False
    return unicodedata.category(text[0])[0] in "LN" and text[-1] not in " ."


def _is_kept(sign: str) -> bool:
    """Return whether a character may be in a name: a letter, its marks, a digit, or one of few others."""
    letter = unicodedata.category(sign)[0] in "LMN" and not _UNSEEN.match(sign)
    return letter or sign in _SIGNS
