"""Ask the service for whatever its own OpenAPI document allows, and for what it does not."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from app.service.store import Store

CHECKS = "not_a_server_error,content_type_conformance,response_headers_conformance,response_schema_conformance"
PROGRAM = shutil.which("schemathesis", path=str(Path(sys.executable).parent)) or shutil.which("schemathesis")


@pytest.mark.slow
@pytest.mark.skipif(PROGRAM is None, reason="schemathesis is not installed (extra 'test')")
def test_no_request_makes_the_service_fail(address: str, store: Store, tmp_path: Path) -> None:
    ran = subprocess.run(  # noqa: S603 (a program of the test environment)
        [
            *(str(PROGRAM), "run", f"{address}/openapi.json", "--checks", CHECKS),
            *(
                "--phases",
                "examples,coverage,fuzzing",
                "--max-examples",
                "5",
                "--request-timeout",
                "30",
                "--generation-deterministic",
                "--no-color",
            ),
        ],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert ran.returncode == 0, ran.stdout[-6000:]
    assert "Tested: 31" in ran.stdout
    assert sum(store.counts().values()) > 0
