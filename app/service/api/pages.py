"""Pages of the service, console and documentation, with their security headers."""

import hashlib
import os
import re
from base64 import b64encode
from functools import cache
from typing import Final

from fastapi.openapi.docs import get_swagger_ui_html
from fastapi.responses import HTMLResponse
from fastapi.staticfiles import StaticFiles
from starlette.responses import Response
from starlette.types import Scope

_SCRIPT: Final = re.compile(rb"<script>(.*?)</script>", re.DOTALL)


def _policy(*scripts: str) -> dict[str, str]:
    """Return the headers of a page: content of this service alone, no framing, revalidation."""
    parts = (
        "default-src 'self'",
        " ".join(("script-src 'self'", *scripts)),
        "style-src 'self' 'unsafe-inline'",
        "img-src 'self' blob: data:",
        "object-src 'none'",
        "base-uri 'none'",
        "form-action 'self'",
        "frame-ancestors 'none'",
    )
    return {
        "Content-Security-Policy": "; ".join(parts),
        "X-Frame-Options": "DENY",
        # Asked for each time, sent when changed: a browser must not mix files of before and after an upgrade.
        "Cache-Control": "no-cache",
    }


class Console(StaticFiles):
    """Static files of the console."""

    def file_response(
        self, full_path: str | os.PathLike[str], stat_result: os.stat_result, scope: Scope, status_code: int = 200
    ) -> Response:
        """Return the answer with a file, or that it has not changed."""
        answer = super().file_response(full_path, stat_result, scope, status_code)
        answer.headers.update(_policy())
        return answer


@cache
def documentation() -> HTMLResponse:
    """Return the OpenAPI document as a page; its parts are shipped, so that it needs no internet."""
    page = get_swagger_ui_html(
        openapi_url="/openapi.json",
        title="knitlab: REST",
        swagger_js_url="/vendor/swagger-ui-bundle.js",
        swagger_css_url="/vendor/swagger-ui.css",
        swagger_favicon_url="/icon.svg",
    )
    # The one script inside the page itself is allowed by its hash.
    digests = (b64encode(hashlib.sha256(script).digest()).decode() for script in _SCRIPT.findall(bytes(page.body)))
    page.headers.update(_policy(*(f"'sha256-{digest}'" for digest in digests)))
    return page
