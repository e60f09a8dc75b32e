#!/usr/bin/env bash
# A scene by `srun` on two nodes, drained in the middle and resumed on one: the bytes of a run that never stopped. Prints `N passed, N failed`.
#
#   tests/mpi/slurm.sh WITH_MPI
#
# It needs a Slurm of two nodes with the plugin pmix. Where both nodes are one machine, each needs a folder for temporary files of its own
# (TmpFS=FOLDER/%n in slurm.conf), as the plugin makes one of the same name on each.
set -uo pipefail
program=$(realpath "$1")
scene=$(realpath "$(dirname "$0")/../../scenes/bench/dense-2k.toml")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
arguments=(--rows-per-block 64 --threads 1 --quiet --set time.end=0.6 --set output.interval=0.1 --set output.data=true)
passed=0
failed=0
check() {
    if [ "$1" = 0 ]; then
        passed=$((passed + 1))
    else
        failed=$((failed + 1))
        echo "failed: $2"
    fi
}
same() { diff -rq -x run.log -x summary.json -x '*.restart' "$1" "$2"; }

"$program" "$scene" "${arguments[@]}" --output alone
srun --mpi=pmix -N2 -n2 "$program" "$scene" "${arguments[@]}" --output two
check $? "two nodes"
same alone two
check $? "two nodes: the same files"

cat > job.sh << JOB
#!/bin/bash
srun --mpi=pmix -N2 -n2 $program $scene ${arguments[@]} --output stopped
echo \$? > code
JOB
job=$(sbatch --parsable -N2 --ntasks-per-node=1 --output=job.log job.sh)
for _ in $(seq 100); do
    [ -e stopped/dense-2k.data ] && break
    sleep 0.1
done
sleep 0.5
for node in $(scontrol show hostnames "$(squeue -h -j "$job" -o %N)"); do
    scontrol update nodename="$node" state=drain reason=test
done
# As `--signal=USR2@300` does before a limit.
scancel --signal=USR2 "$job"
for _ in $(seq 300); do
    [ -e code ] && break
    sleep 0.1
done
[ "$(cat code)" = 75 ]
check $? "drained: exit code $(cat code)"
for node in $(sinfo -h -N -o %N); do
    scontrol update nodename="$node" state=resume
done
srun --mpi=pmix -N1 -n1 "$program" "$scene" "${arguments[@]}" --output stopped --resume
check $? "resumed on one node"
same alone stopped
check $? "resumed on one node: the same files"

echo "$passed passed, $failed failed"
[ "$failed" = 0 ]
