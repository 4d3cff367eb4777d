"""Default address of a service."""

from typing import Final

PORT: Final = 8731
DEFAULT_SERVER: Final = f"http://127.0.0.1:{PORT}"
