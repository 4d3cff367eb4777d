#!/usr/bin/env bash
# Build the wheel, install it into an environment of its own, and use it outside the sources.
# Usage: run.sh PYTHON, an interpreter with pip.
set -euo pipefail
python="${1:?usage: run.sh PYTHON}"
root="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)"
env="$root/.venv-installed"
place="$(mktemp -d)"
trap 'rm -rf "$place"' EXIT
"$python" -m pip wheel --quiet --disable-pip-version-check --no-deps --wheel-dir "$place/dist" "$root"
if ! cmp --silent "$root/constraints.txt" "$env/constraints.txt"; then
    "$python" -m venv --clear "$env"
    cp "$root/constraints.txt" "$env"
fi
pip=("$env/bin/python" -m pip install --quiet --disable-pip-version-check --no-compile)
"${pip[@]}" --constraint "$root/constraints.txt" "$place"/dist/knitlab-*.whl
"${pip[@]}" --force-reinstall --no-deps "$place"/dist/knitlab-*.whl  # of equal version but newer sources
cp "$root/examples/biaxial_small.yaml" "$place"
cd "$place"
export PATH="$env/bin:$PATH"
unset PYTHONPATH
knitlab --version
knitlab check biaxial_small.yaml > checked
knitlab run biaxial_small.yaml --no-pictures --out run > ran
test "$(wc -l < run/biaxial_small.csv)" -gt 100
python - "$root" <<'PYTHON'
import sys
from pathlib import Path

import knitlab as kl

home = Path(kl.__file__)
assert not home.is_relative_to(sys.argv[1]) or ".venv-installed" in home.parts, home
run = kl.open_run("run")

from app.service.api.library import examples, examples_folder, texts_of_example

assert examples_folder() == home.parent.parent / "app" / "examples", examples_folder()
_, materials, files = texts_of_example("fabric/rib_course")
assert materials and len(examples()) > 50, len(examples())
print(home.parent, "reads a run that ended by", run.outcome.end)
PYTHON
