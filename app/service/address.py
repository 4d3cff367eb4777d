"""Say where a service is, unless it is told otherwise."""

from typing import Final

PORT: Final = 8731
DEFAULT_SERVER: Final = f"http://127.0.0.1:{PORT}"
