"""The pages of the service: what a browser may do with them, and who may show them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    import httpx


@pytest.mark.parametrize("path", ["/", "/index.html", "/main.js", "/style.css", "/docs"])
def test_pages_are_nobody_elses_frame_and_never_stale(http: httpx.Client, path: str) -> None:
    answer = http.get(path)
    policy = dict(part.split(" ", 1) for part in answer.headers["content-security-policy"].split("; "))
    assert policy["frame-ancestors"] == "'none'"
    assert policy["default-src"] == "'self'"
    assert "unsafe" not in policy["script-src"]
    assert answer.headers["x-frame-options"] == "DENY"
    assert answer.headers["cache-control"] == "no-cache"
    if "etag" in answer.headers:
        same = http.get(path, headers={"If-None-Match": answer.headers["etag"]})
        assert (same.status_code, same.headers["cache-control"]) == (304, "no-cache")
