"""The service on a file system that is read-only but for its data and temporary files, as the container has it."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Final

import pytest

from app.client import Client
from knitlab_core.jit import CACHE_FOLDER
from tests.service.knitlab_serve import QUICK, serving
from tests.service.lab import until

#: A user without a name, as containers have them.
USER: Final = 12345
PROBE: Final = "mount -t tmpfs tmpfs /mnt && mount -o remount,ro,bind / && ! touch /written 2>/dev/null"
#: Mounts of the container: everything read-only, the volume `/data`, a tmpfs for temporary files, kernels in the image.
MOUNTS: Final = """\
set -eu
mount -t tmpfs -o mode=755 tmpfs /mnt
mkdir -p /mnt/data /mnt/tmp /mnt/cache
mount --bind "$1" /mnt/data
mount -t tmpfs -o mode=1777 tmpfs /mnt/tmp
cp -r "$2" /mnt/cache
mount -o remount,ro /mnt
mount -o remount,ro,bind /
! touch /written /tmp/written /mnt/cache/written 2>/dev/null
user="$3"
shift 3
exec setpriv --reuid "$user" --regid "$user" --clear-groups --bounding-set=-all --no-new-privs "$@"
"""


def user_of_the_service() -> int:
    """Return a user without rights that can run this interpreter; root where it is in a folder of root's own."""
    asked = ["setpriv", "--reuid", str(USER), "--regid", str(USER), "--clear-groups", "--bounding-set=-all"]
    # A process that it starts must find the interpreter too.
    tried = [*asked, "sh", "-c", '"$0" -c "import numpy"', sys.executable]
    return USER if subprocess.run(tried, capture_output=True, check=False).returncode == 0 else 0  # noqa: S603


@pytest.mark.slow
def test_a_job_is_done_where_nothing_else_can_be_written(tmp_path: Path) -> None:
    if not hasattr(os, "getuid") or os.getuid() != 0 or shutil.which("unshare") is None or CACHE_FOLDER is None:
        pytest.skip("needs root, unshare, and a cache of kernels")
    tried = ["unshare", "-m", "sh", "-c", PROBE]
    if subprocess.run(tried, capture_output=True, check=False).returncode != 0:  # noqa: S603
        pytest.skip("needs mounts of its own")
    user = user_of_the_service()
    data = tmp_path / "data"
    data.mkdir()
    os.chown(data, user, user)
    within = ["unshare", "-m", "sh", "-c", MOUNTS, "sh", str(data), str(CACHE_FOLDER), str(user)]
    places = {"HOME": "/mnt", "TMPDIR": "/mnt/tmp", "MPLCONFIGDIR": "/mnt/tmp", "KNITLAB_CACHE": "/mnt/cache"}
    with serving(Path("/mnt/data"), "--slots", 1, within=within, **places) as (address, _), Client(address) as client:
        job = client.submit(QUICK).id
        until(lambda: client.job(job).over)
        assert client.job(job).end == "target"
        assert client.log(job, "biotester", tmp_path / "log.csv").stat().st_size > 1000
        assert client.report(job, tmp_path / "report.html").stat().st_size > 10_000
    assert (data / "knitlab.sqlite").stat().st_uid == user
