"""File downloads: whole, or the requested range (RFC 9110, 14).

The framework's own answer sends a file that grows beyond its announced length, and errors in a form of its own.
"""

from __future__ import annotations

import os
import re
from typing import TYPE_CHECKING, BinaryIO, Final
from urllib.parse import quote

from fastapi.responses import Response, StreamingResponse

from app.service.api.etags import has_tag
from app.service.api.head_requests import asks_head
from app.service.api.problems import ProblemError

if TYPE_CHECKING:
    from collections.abc import Iterator

    from fastapi import Request
    from starlette.types import Receive, Scope, Send

_CHUNK: Final = 64 * 1024
_RANGE: Final = re.compile(r"bytes=\s*(\d{0,18})-(\d{0,18})\s*")


def transfer(request: Request, stream: BinaryIO, name: str, media: str) -> Response:
    """Return the response with a file at its present length.

    Parameters
    ----------
    request : Request
        May ask for a range, or for the file only if it changed.
    stream : BinaryIO
        An open file.
    name : str
        Under which it is saved.
    media : str
        What it holds.

    Raises
    ------
    ProblemError
        If the range is outside the file.
    """
    found = os.fstat(stream.fileno())
    tag = f'"{found.st_mtime_ns:x}-{found.st_size:x}"'
    headers = {
        "Accept-Ranges": "bytes",
        "Cache-Control": "no-cache",
        # Only as RFC 8187 encodes it: no name can end the header, or start another.
        "Content-Disposition": f"attachment; filename*=utf-8''{quote(name, safe='')}",
        "ETag": tag,
    }
    if has_tag(request.headers.get("if-none-match", ""), tag):
        stream.close()
        return Response(status_code=304, headers=headers)
    start, end, status = 0, found.st_size, 200
    wanted = request.headers.get("range")
    if wanted is not None and request.headers.get("if-range", tag) == tag:
        span = range_of(wanted, found.st_size)
        if span is not None and span[0] >= span[1]:
            stream.close()
            detail = f"range: found {wanted}, allowed bytes 0 to {found.st_size - 1}"
            raise ProblemError("range", detail, headers={"Content-Range": f"bytes */{found.st_size}"})
        if span is not None:
            (start, end), status = span, 206
            headers["Content-Range"] = f"bytes {start}-{end - 1}/{found.st_size}"
    headers["Content-Length"] = str(end - start)
    if asks_head(request):
        stream.close()
        return Response(status_code=status, headers=headers, media_type=media)
    return _Transfer(stream, (start, end), status, headers, media)


class _Transfer(StreamingResponse):
    """Response with a part of a file, which is closed at the end in any case."""

    def __init__(
        self, stream: BinaryIO, part: tuple[int, int], status: int, headers: dict[str, str], media: str
    ) -> None:
        super().__init__(_chunks(stream, *part), status_code=status, headers=headers, media_type=media)
        self._stream = stream

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Send the file."""
        try:
            await super().__call__(scope, receive, send)
        finally:
            self._stream.close()


def range_of(wanted: str, size: int) -> tuple[int, int] | None:
    """Return the first byte of a range and the one after its last; None for a range that may be ignored.

    Several ranges in one request are passed over, as a server may; so is what is no range of bytes.

    Examples
    --------
    >>> range_of("bytes=0-4", 10), range_of("bytes=-3", 10), range_of("bytes=8-", 10), range_of("lines=1-2", 10)
    ((0, 5), (7, 10), (8, 10), None)
    """
    match = _RANGE.fullmatch(wanted)
    if match is None or match[1] + match[2] == "":
        return None
    if not match[1]:
        return max(0, size - int(match[2])), size
    if match[2] and int(match[2]) < int(match[1]):
        return None
    return int(match[1]), min(size, int(match[2]) + 1 if match[2] else size)


def _chunks(stream: BinaryIO, start: int, end: int) -> Iterator[bytes]:
    """Yield a part of a file in chunks, and close it."""
    with stream:
        stream.seek(start)
        while start < end and (chunk := stream.read(min(_CHUNK, end - start))):
            start += len(chunk)
            yield chunk
