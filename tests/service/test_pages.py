"""The pages of the service: what a browser may do with them, and who may show them."""

from __future__ import annotations

import shutil
import threading
from http.server import BaseHTTPRequestHandler, HTTPServer
from typing import TYPE_CHECKING

import pytest
from playwright.sync_api import sync_playwright

if TYPE_CHECKING:
    from collections.abc import Iterator

    import httpx

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")


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


@pytest.fixture
def stranger(address: str) -> Iterator[str]:
    """Serve a page of another site that shows the console in a frame."""

    class Page(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            self.send_response(200)
            self.send_header("Content-Type", "text/html")
            self.end_headers()
            self.wfile.write(f"<iframe src='{address}/'></iframe><iframe src='{address}/docs'></iframe>".encode())

        def log_message(self, *_: object) -> None:
            pass

    with HTTPServer(("127.0.0.1", 0), Page) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        yield f"http://127.0.0.1:{server.server_port}"
        server.shutdown()
        thread.join()


@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium is installed")
def test_a_browser_shows_the_pages_alone_and_never_in_a_frame(address: str, stranger: str) -> None:
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        page = browser.new_page()
        said: list[str] = []
        page.on("console", lambda message: said.append(message.text))
        page.on("pageerror", lambda error: said.append(str(error)))
        page.goto(f"{address}/docs")
        page.wait_for_selector(".opblock")
        page.goto(f"{address}/")
        page.wait_for_selector("nav")
        # The policy forbids nothing that the pages themselves need.
        assert said == []
        page.goto(stranger, wait_until="load")
        assert [frame.url for frame in page.frames[1:]] == ["chrome-error://chromewebdata/"] * 2
        browser.close()
