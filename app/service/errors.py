"""Errors between a client and a service.

KnitlabError
├── ServiceError        the service refused, or failed
└── UnreachableError    no service answered
"""

from __future__ import annotations

from knitlab_core.errors import KnitlabError


class ServiceError(KnitlabError):
    """A service answered with a problem.

    Parameters
    ----------
    status : int
        Status of the answer.
    detail : str
        Its one line.
    kind : str
        The last part of the problem's type, such as ``invalid-protocol``; empty where the status is enough.

    Examples
    --------
    >>> print(ServiceError(404, "job 'a': there is none"))
    job 'a': there is none
    """

    def __init__(self, status: int, detail: str, kind: str = "") -> None:
        super().__init__(detail)
        self.status, self.detail, self.kind = status, detail, kind


class UnreachableError(KnitlabError):
    """No service answered.

    Parameters
    ----------
    server : str
        The address that was tried.
    reason : str
        What happened.
    """

    def __init__(self, server: str, reason: str) -> None:
        super().__init__(f"{server}: {reason}; is 'knitlab serve' running there?")
        self.server = server
