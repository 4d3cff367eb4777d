"""Hide from our own modules what Windows does not have; read by every Python whose path begins with this folder.

Libraries keep what they need of this system: theirs is to run on others.
"""

from __future__ import annotations

import builtins
import os
import signal
from typing import Any

OURS = ("app", "knitlab", "knitlab_core", "knitlab_entry", "rigs")
POSIX_ONLY = {"fcntl", "grp", "posix", "pwd", "resource", "syslog", "termios", "tty"}
#: SIGKILL stays: psutil ends processes by it here.
MISSING = {
    os: ("fork", "forkpty", "getuid", "geteuid", "killpg", "setsid", "O_ASYNC"),
    signal: ("SIGIO", "SIGHUP", "SIGUSR1", "SIGALRM", "pthread_kill"),
}

_import = builtins.__import__


def refuse(name: str, globals: Any = None, locals: Any = None, fromlist: Any = (), level: int = 0) -> Any:  # noqa: A002, ANN401 (Python's)
    """Import, unless one of our modules asks for what other systems lack."""
    importer = (globals or {}).get("__name__", "").split(".")[0]
    if importer in OURS and name.partition(".")[0] in POSIX_ONLY:
        raise ModuleNotFoundError(f"No module named {name!r}", name=name)
    return _import(name, globals, locals, fromlist, level)


builtins.__import__ = refuse
for module, missing in MISSING.items():
    for one in missing:
        if hasattr(module, one):
            delattr(module, one)
