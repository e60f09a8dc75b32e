#!/usr/bin/env bash
# The stage of `.ci/run` for the cloud: its own workspace in the dev profile, whole programs stopped and resumed, what others may not see.
# The page in a browser: `node web/tests/newcomer.mjs LINK`, by hand.
# What cannot be had here is named in a line of its own and left out.
set -euo pipefail
cd "$(dirname "$0")/.."
cargo fmt --all --check
cargo clippy --locked --workspace --all-targets -- -D warnings
cargo test --locked --workspace
cargo build --locked --workspace
(cd web/page/vendor && sha256sum --check --quiet SHA256SUMS)
if grep -rnE 'innerHTML|outerHTML|insertAdjacentHTML|document\.write' web/page --include '*.js' --exclude-dir vendor; then
  echo "the page makes HTML from text" >&2
  exit 1
fi

bin="${MERCURY_BIN:-$PWD/../target/release}"
export MERCURY_BIN="$PWD/target/debug:$bin"
if command -v python3 > /dev/null; then
  # The others of `tests/accept.sh all` need minutes of an idle machine, Slurm or a browser: run them by hand.
  tests/accept.sh start extend stop-resume passwd
else
  echo "cloud: whole programs not tested, python3 is missing"
fi

scratch="$(mktemp -d)"
trap 'rm -rf "$scratch"' EXIT
if command -v npm > /dev/null && npm install --silent --no-audit --no-fund --prefix "$scratch" typescript@5.9 > /dev/null 2>&1; then
  "$scratch/node_modules/.bin/tsc" -p web/tests/tsconfig.json
else
  echo "cloud: types of the page not checked, typescript cannot be installed"
fi
