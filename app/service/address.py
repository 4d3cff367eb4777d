"""Addresses of services: the default one, and which are this machine's own."""

import ipaddress
from typing import Final

PORT: Final = 8731
DEFAULT_SERVER: Final = f"http://127.0.0.1:{PORT}"


def is_loopback(host: str) -> bool:
    """Return whether a name or an address is this machine's own.

    Examples
    --------
    >>> is_loopback("127.0.0.1"), is_loopback("::1"), is_loopback("localhost"), is_loopback("0.0.0.0")
    (True, True, True, False)
    """
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"
