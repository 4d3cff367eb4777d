"""Prometheus metrics of requests and jobs."""

from __future__ import annotations

from time import perf_counter
from typing import TYPE_CHECKING

from prometheus_client import CollectorRegistry, Counter, Gauge, Histogram, PlatformCollector, ProcessCollector

if TYPE_CHECKING:
    from starlette.requests import Request
    from starlette.types import ASGIApp, Message, Receive, Scope, Send

_BUCKETS = (0.005, 0.02, 0.05, 0.1, 0.5, 1.0, 5.0, 30.0)


class Metrics:
    """Counters of one service."""

    def __init__(self) -> None:
        self.registry = CollectorRegistry()
        ProcessCollector(registry=self.registry)
        PlatformCollector(registry=self.registry)
        self.requests = Counter(
            "knitlab_requests", "Requests answered.", ["method", "route", "status"], registry=self.registry
        )
        self.seconds = Histogram(
            "knitlab_request_seconds",
            "Time until an answer began [s].",
            ["method", "route"],
            buckets=_BUCKETS,
            registry=self.registry,
        )
        self.open_streams = 0
        streams = Gauge("knitlab_event_streams", "Event streams that are open.", registry=self.registry)
        streams.set_function(lambda: self.open_streams)
        self.jobs = Gauge("knitlab_jobs", "Jobs by state.", ["state"], registry=self.registry)

    def take_stream(self, most: int) -> bool:
        """Take one of the allowed event streams; the holder gives it back."""
        if self.open_streams >= most:
            return False
        self.open_streams += 1
        return True

    def give_stream(self) -> None:
        """Give an event stream back."""
        self.open_streams -= 1


def metrics_of(request: Request) -> Metrics:
    """Return the counters of the service that a request came to."""
    found = request.app.state.metrics
    if not isinstance(found, Metrics):
        raise TypeError("an app without counters")
    return found


class CountRequests:
    """ASGI middleware that counts answers, and adds the common headers.

    Parameters
    ----------
    app : ASGIApp
        What answers.
    metrics : Metrics
        Where to count.
    """

    def __init__(self, app: ASGIApp, metrics: Metrics) -> None:
        self.app, self.metrics = app, metrics

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        began = perf_counter()

        async def counted(message: Message) -> None:
            if message["type"] == "http.response.start":
                message["headers"] = [*message["headers"], (b"x-content-type-options", b"nosniff")]
                # The template, not the path, or every job would add a label.
                route = getattr(scope.get("route"), "path", "none")
                method = scope["method"] if scope["method"] in _METHODS else "other"
                self.metrics.requests.labels(method, route, str(message["status"])).inc()
                self.metrics.seconds.labels(method, route).observe(perf_counter() - began)
            await send(message)

        await self.app(scope, receive, counted)


_METHODS = frozenset({"GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS"})
