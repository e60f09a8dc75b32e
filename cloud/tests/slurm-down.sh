#!/usr/bin/env bash
# slurm-down.sh FOLDER: ends what slurm-up.sh has started.
folder="$(realpath "$1")"
for name in n1 n2 ctld munged; do kill "$(cat "$folder/run/$name.pid")"; done
