from __future__ import annotations

from hmac import compare_digest
from typing import TYPE_CHECKING

import httpx
import pytest

from app.service.api.build import create_app
from app.service.api.context import Context
from app.service.api.guard import require_token_for, same_token
from knitlab_core.errors import SpecificationError
from tests.service.serving import served

if TYPE_CHECKING:
    from collections.abc import Iterator

    from app.service.store import Store

TOKEN = "wool-and-needles"  # noqa: S105 (of these tests alone)


@pytest.fixture(scope="module")
def guarded(store: Store) -> Iterator[str]:
    with served(create_app(Context(store=store, token=TOKEN))) as at:
        yield at


@pytest.mark.parametrize("host", ["0.0.0.0", "::", "192.168.0.7", "lab.example", "testserver"])  # noqa: S104 (it is refused)
def test_other_machines_need_a_token(host: str) -> None:
    with pytest.raises(SpecificationError, match="token"):
        require_token_for(host, None)
    require_token_for(host, TOKEN)
    with pytest.raises(SpecificationError, match="not empty"):
        require_token_for(host, " ")


@pytest.mark.parametrize("host", ["127.0.0.1", "::1", "localhost", "127.9.9.9"])
def test_this_machine_needs_none(host: str) -> None:
    require_token_for(host, None)


@pytest.mark.parametrize(
    "given",
    ["", "Bearer", "Bearer wool", f"Bearer {TOKEN}x", f"Basic {TOKEN}", f"bearer {TOKEN.upper()}", "Bearer ü"],
)
@pytest.mark.parametrize("path", ["/v1/jobs", "/v1/rigs", "/v1/jobs/a/events", "/metrics"])
def test_a_wrong_token_is_refused(guarded: str, given: str, path: str) -> None:
    answer = httpx.get(guarded + path, headers=[(b"Authorization", given.encode())])
    assert answer.status_code == 401
    assert answer.headers["www-authenticate"] == "Bearer"
    assert answer.headers["content-type"] == "application/problem+json"
    assert TOKEN not in answer.text


def test_the_token_opens(guarded: str) -> None:
    headers = {"Authorization": f"Bearer {TOKEN}"}
    for path in ("/v1/jobs", "/v1/rigs", "/metrics"):
        assert httpx.get(guarded + path, headers=headers).status_code == 200
    # Those who watch over it, and who reads its documentation, need none.
    for path in ("/healthz", "/openapi.json"):
        assert httpx.get(guarded + path).status_code == 200
    # From any name: the token says who may.
    assert httpx.get(guarded + "/v1/jobs", headers={**headers, "Host": "lab.example"}).status_code == 200


def test_tokens_are_compared_in_constant_time(monkeypatch: pytest.MonkeyPatch) -> None:
    lengths: list[tuple[int, int]] = []

    def spy(one: bytes, other: bytes) -> bool:
        lengths.append((len(one), len(other)))
        return compare_digest(one, other)

    monkeypatch.setattr("hmac.compare_digest", spy)
    assert same_token(TOKEN, TOKEN)
    assert not same_token("w", TOKEN)
    assert not same_token("\udc80", TOKEN)
    # Neither how far two agree nor how long they are shows.
    assert lengths == [(32, 32)] * 3


@pytest.mark.parametrize("host", ["evil.example", "127.0.0.1.evil.example", "[::1", "", "testserver", "localhost.evil"])
def test_a_name_that_was_pointed_here_is_refused(address: str, host: str) -> None:
    answer = httpx.get(address + "/v1/jobs", headers={"Host": host})
    assert answer.status_code in {400, 403}


def test_pages_of_other_sites_are_refused(address: str) -> None:
    post = address + "/v1/jobs/nobody/cancel"
    for origin in ("https://evil.example", "null", "http://localhost:1", "http://[bad"):
        assert httpx.post(post, headers={"Origin": origin}).status_code == 403
    assert httpx.post(post, headers={"Origin": address}).status_code == 404
