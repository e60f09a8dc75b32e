#!/usr/bin/env bash
# Instructions per particle and step of dense-2k (steps 20 to 60, one thread), with two lanes and with four, counted by callgrind.
# Pictures are left out: their instructions depend on where the particles are, by a tenth of the whole.
# Counts do not depend on other programs on the machine. Compared with the last row of each in benches/results/instructions.csv:
# more than 3 % above it is an error, until a row with the reason is added. Rows of another compiler say nothing.
#
# usage: benches/instructions.sh [--solver PROGRAM] [--record REASON]
set -euo pipefail
cd "$(dirname "$0")/.."
export LC_ALL=C
solver="${CARGO_TARGET_DIR:-target}/release/mercury-solve"
results=benches/results/instructions.csv
reason=""
while (($#)); do
  case "$1" in
    --solver) solver="$2" ;;
    --record) reason="$2" ;;
    *) sed -n '2,7s/^# \{0,1\}//p' "$0" >&2; exit 2 ;;
  esac
  shift 2
done
command -v valgrind > /dev/null || { echo "valgrind is missing: apt-get install valgrind" >&2; exit 2; }
test -x "$solver" || { echo "$solver is missing: cargo build --release --bin mercury-solve" >&2; exit 2; }
scratch="$(mktemp -d)"
trap 'rm -rf "$scratch"' EXIT

# count LANES STEPS: instructions of a whole run.
count() {
  valgrind --tool=callgrind --callgrind-out-file=/dev/null "$solver" scenes/bench/dense-2k.toml --threads 1 --lanes "$1" --quiet \
    --set output.pictures=false --set "time.end=$(awk "BEGIN { printf \"%.9g\", $2 * 3e-5 }")" --output "$scratch/$1-$2" 2> "$scratch/log" || { cat "$scratch/log" >&2; return 1; }
  awk '/Collected/ { print $4 }' "$scratch/log"
}

compiler=$(rustc --version | cut -d' ' -f2)
worse=0
for lanes in 2 4; do
  if ! "$solver" scenes/bench/dense-2k.toml --check --lanes "$lanes" > /dev/null 2>&1; then
    echo "$lanes lanes: not counted, this processor has not so many"
    continue
  fi
  now=$(awk "BEGIN { printf \"%.1f\", ($(count $lanes 60) - $(count $lanes 20)) / (2000 * 40) }")
  before=$(awk -F, -v lanes=$lanes -v compiler="$compiler" '$3 == lanes && $2 == compiler { last = $4 } END { print last }' $results 2> /dev/null || true)
  echo "$lanes lanes: $now instructions per particle-step; recorded with rustc $compiler: ${before:-nothing}"
  if [ -n "$reason" ]; then
    test -e $results || echo "date,rustc,lanes,instructions,reason" > $results
    echo "$(date +%F),$compiler,$lanes,$now,\"$reason\"" >> $results
  elif [ -n "$before" ] && awk "BEGIN { exit !($now > 1.03 * $before) }"; then
    worse=1
  fi
done
if ((worse)); then
  echo "more than 3 % above what is recorded: find out why, or tell the reason: benches/instructions.sh --record \"REASON\"" >&2
  exit 1
fi
