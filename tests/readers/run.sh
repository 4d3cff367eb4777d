#!/usr/bin/env bash
# Read files of real runs with people's own readers, in an environment of their own.
# Usage: run.sh PYTHON, the interpreter that knitlab is installed for. Every read_*.py beside it is a check: it is
# given the folder that write_files.py filled and fails if what it reads differs from the record.
set -euo pipefail
python="${1:?usage: run.sh PYTHON}"
here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
root="$(cd "$here/../.." && pwd)"
env="$root/.venv-readers"
wanted="$(cat "$here/requirements.txt" "$here/constraints.txt")"
if [ "$(cat "$env/installed" 2>/dev/null)" != "$wanted" ]; then
    "$python" -m venv --clear "$env"
    "$env/bin/python" -m pip install --quiet --disable-pip-version-check --no-compile \
        --constraint "$here/constraints.txt" --requirement "$here/requirements.txt"
    printf '%s\n' "$wanted" > "$env/installed"
fi
files="$(mktemp -d)"
trap 'rm -rf "$files"' EXIT
(cd "$root" && "$python" -m tests.readers.write_files "$files")
for check in "$here"/read_*.py; do
    echo "$(basename "$check")"
    "$env/bin/python" "$check" "$files"
done
