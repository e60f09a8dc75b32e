#!/usr/bin/env bash
# Acceptance of Mercury Cloud: accept.sh NAME... or accept.sh all; without a name it lists them.
# ACCEPT_JOBS=N makes N of them at a time, but for those that need a machine that does nothing else.
# Needs python3 and the programs mercury-cloud, mercury-solve (MERCURY_BIN: folders to look in, with : between).
set -euo pipefail
exec python3 "$(dirname "$0")/accept.py" "$@"
