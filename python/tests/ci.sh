#!/usr/bin/env bash
# The stage of `.ci/run` for the package of Python: its own workspace in the dev profile, a wheel, and its tests in a new environment with
# packages of PyPI. What cannot be had here is named in a line of its own and left out. PYTHONS lists interpreters, python3 by default;
# all of them use the one wheel.
set -euo pipefail
cd "$(dirname "$0")/.."
cargo fmt --all --check
cargo clippy --locked --workspace --all-targets -- -D warnings
cargo test --locked -p mercury-dem -p c-interface
cargo test --locked -p c-header

read -ra pythons <<< "${PYTHONS:-python3}"
scratch="$(mktemp -d)"
trap 'rm -rf "$scratch"' EXIT
for python in "${pythons[@]}"; do
  if ! "$python" -c 'import sys; sys.exit(sys.version_info < (3, 10))' 2> /dev/null; then
    echo "python: not tested with $python, which is missing or older than 3.10"
    continue
  fi
  "$python" -m venv "$scratch/venv"
  if ! "$scratch/venv/bin/pip" install --quiet --disable-pip-version-check 'maturin>=1.9,<2' mypy nbclient ipykernel matplotlib numpy pandas \
    polars pyarrow pytest > "$scratch/pip.log" 2>&1; then
    echo "python: not tested with $python, packages cannot be installed: $(tail -n 1 "$scratch/pip.log")"
    rm -rf "$scratch/venv"
    continue
  fi
  PATH="$scratch/venv/bin:$PATH"
  if [ ! -d "$scratch/wheels" ]; then
    maturin build --locked --out "$scratch/wheels"
  fi
  pip install --quiet --disable-pip-version-check "$scratch"/wheels/*.whl
  # Outside of the folder that holds the sources of the package.
  (cd tests && python -m pytest -q -p no:cacheprovider .)
  PATH="${PATH#*:}"
  rm -rf "$scratch/venv"
done
