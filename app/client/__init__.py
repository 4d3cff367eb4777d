"""Python client of a knitlab service.

Examples
--------
Submit a protocol, watch it, fetch what its instruments logged::

    with Client("http://127.0.0.1:8731") as client:
        job = client.submit(Path("examples/biaxial_cycle.yaml").read_text())
        for event in client.follow(job.id):
            print(event.kind, event.data)
        client.log(job.id, "biotester", Path("log.csv"))
"""

from app.client.answers import Curve, Event, File, Job, JobComparison, Page, Progress, Score
from app.client.client import Client
from app.service.address import DEFAULT_SERVER
from app.service.errors import ServiceError, UnreachableError

__all__ = [
    "DEFAULT_SERVER",
    "Client",
    "Curve",
    "Event",
    "File",
    "Job",
    "JobComparison",
    "Page",
    "Progress",
    "Score",
    "ServiceError",
    "UnreachableError",
]
