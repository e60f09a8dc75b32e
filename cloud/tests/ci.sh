#!/usr/bin/env bash
# The stage of `.ci/run` for the cloud: its own workspace in the dev profile, with all features; whole programs that are stopped,
# lost and resumed, over a folder and over object storage; the page in Chromium. What cannot be had here is named in a line of its
# own and left out. CLOUD_BROWSER=no and CLOUD_AWS=no leave out what needs packages of Debian, npm and PyPI.
set -euo pipefail
cd "$(dirname "$0")/.."
cargo fmt --all --check
cargo clippy --locked --workspace --all-features --all-targets -- -D warnings
cargo test --locked --workspace --all-features
cargo build --locked --workspace --all-features
(cd web/page/vendor && sha256sum --check --quiet SHA256SUMS)
if grep -rnE 'innerHTML|outerHTML|insertAdjacentHTML|document\.write' web/page --include '*.js' --exclude-dir vendor; then
  echo "the page makes HTML from text" >&2
  exit 1
fi

bin="${MERCURY_BIN:-$PWD/../target/release}"
# The solver in release first: a target folder of both workspaces has it in debug, too.
export MERCURY_BIN="$bin:${CARGO_TARGET_DIR:-$PWD/target}/debug"
if ! command -v python3 > /dev/null; then
  echo "cloud: whole programs not tested, python3 is missing"
  exit 0
fi
scratch="$(mktemp -d)"
trap 'rm -rf "$scratch"; [ -z "${moto:-}" ] || kill "$moto" 2> /dev/null' EXIT
# Most checks wait for their programs most of the time.
export ACCEPT_JOBS="${ACCEPT_JOBS:-2}"
# The others of `tests/accept.sh all` need minutes of an idle machine: run them by hand. `attacks` has the downloads of `unread`.
tests/accept.sh start extend start-from-run stop-resume passwd study projects prices \
  log-in archives limits taken-back private inputs cage root attacks audit log hook

# Object storage and AWS: moto from PyPI, and s3s-fs where it is installed (cargo install s3s-fs --version 0.14.1 --features binary).
if [ "${CLOUD_AWS:-yes}" != yes ]; then
  echo "cloud: object storage and AWS not tested, CLOUD_AWS is not yes"
elif command -v moto_server > /dev/null || { python3 -m venv "$scratch/venv" && "$scratch/venv/bin/pip" install --quiet --disable-pip-version-check \
  'moto[server]==5.2.*' 'cfn-lint==1.*' > "$scratch/pip.log" 2>&1 && PATH="$scratch/venv/bin:$PATH"; }; then
  port="$(python3 -c 'import socket; s = socket.socket(); s.bind(("127.0.0.1", 0)); print(s.getsockname()[1])')"
  moto_server -p "$port" > "$scratch/moto.log" 2>&1 &
  moto=$!
  for _ in $(seq 60); do curl -s -o /dev/null "http://127.0.0.1:$port/" && break; sleep 0.5; done
  signed="AWS4-HMAC-SHA256 Credential=test/20260101/us-east-1/s3/aws4_request, SignedHeaders=host, Signature=0"
  curl -s -o /dev/null -X PUT -H "Authorization: $signed" "http://127.0.0.1:$port/bucket"
  AWS_ENDPOINT_URL="http://127.0.0.1:$port" AWS_ACCESS_KEY_ID=test AWS_SECRET_ACCESS_KEY=test AWS_REGION=us-east-1 MERCURY_TEST_S3=s3://bucket/test \
    cargo test --locked --workspace --all-features --test bucket
  tests/accept.sh s3 batch cloudformation
else
  echo "cloud: object storage and AWS not tested, moto cannot be installed: $(tail -n 1 "$scratch/pip.log" 2> /dev/null)"
fi

# The page: types and accessibility by packages of npm, a newcomer in Debian's Chromium.
if [ "${CLOUD_BROWSER:-yes}" != yes ]; then
  echo "cloud: the page not tested, CLOUD_BROWSER is not yes"
  exit 0
fi
if ! command -v chromium > /dev/null && [ "$(id -u)" = 0 ] && command -v apt-get > /dev/null; then
  apt-get install -y -qq --no-install-recommends chromium > "$scratch/apt.log" 2>&1 || echo "cloud: chromium cannot be installed"
fi
if command -v npm > /dev/null && npm install --silent --no-audit --no-fund --prefix "$scratch" typescript@5.9 axe-core@4 > "$scratch/npm.log" 2>&1; then
  export ACCEPT_NPM="$scratch"
else
  echo "cloud: types and accessibility of the page not checked, typescript and axe-core cannot be installed"
fi
tests/accept.sh page newcomer study-page draft view account-page known
