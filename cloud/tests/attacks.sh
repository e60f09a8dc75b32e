#!/usr/bin/env bash
# Twelve attacks on a server of Mercury Cloud on this machine: attacks.sh LINK [NAME...]; without a link it lists them.
# LINK is the content of `link` in the data folder of the server. Needs python3.
set -euo pipefail
exec python3 "$(dirname "$0")/attacks.py" "$@"
