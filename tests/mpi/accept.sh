#!/usr/bin/env bash
# One scene on several processes of MPI: the bytes of one process, whatever happens. Prints `N passed, N failed`.
#
#   tests/mpi/accept.sh WITH_MPI WITHOUT_MPI
#
# WITH_MPI, WITHOUT_MPI: mercury-solve built with the feature `mpi` and without. That a wrong order of shares gives other bytes is seen by
# tests/tests/ranks, with ranks that are threads.
set -uo pipefail
with=$(realpath "$1")
without=$(realpath "$2")
scenes=$(realpath "$(dirname "$0")/../../scenes")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
run="mpirun --oversubscribe"
[ "$(id -u)" = 0 ] && run="$run --allow-run-as-root"
# Ranks that share cores yield them while they wait.
export OMPI_MCA_mpi_yield_when_idle=1 OMPI_MCA_btl_base_warn_component_unused=0
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

# same A B: all files but those with times are equal.
same() { diff -rq -x run.log -x summary.json "$1" "$2"; }

# same_outputs A B: likewise, but for checkpoints, of which an interrupted run has others.
same_outputs() { diff -rq -x run.log -x summary.json -x '*.restart' "$1" "$2"; }

# solve PROGRAM RANKS FOLDER SCENE ARGUMENTS...: on so many ranks; 0: without a launcher.
solve() {
    local program=$1 ranks=$2 folder=$3 scene=$4
    shift 4
    local launch=""
    [ "$ranks" -gt 0 ] && launch="$run -np $ranks"
    # shellcheck disable=SC2086
    timeout 300 $launch "$program" "$scene" --rows-per-block 64 --quiet --output "$folder" "$@"
}

# The same files on several ranks with 1 or 2 threads as without MPI: on those of `on`.
bytes_of() {
    local name=$1
    shift
    local scene=$scenes/$name.toml
    local out=bytes/${name//\//-}
    # Pictures are drawn by the first rank from the files, and take longer than most of these runs.
    set -- "$@" --set output.pictures=false
    solve "$without" 0 "$out/alone" "$scene" --threads 1 --fixed-threads "$@" 2> "$out.err"
    check $? "$name alone: $(tail -1 "$out.err" 2> /dev/null)"
    local of ranks threads
    for of in $on; do
        ranks=${of%-*}
        threads=${of#*-}
        solve "$with" "$ranks" "$out/$of" "$scene" --threads "$threads" --fixed-threads "$@" 2> /dev/null \
            && same "$out/alone" "$out/$of"
        check $? "$name on $ranks ranks with $threads threads"
        rm -rf "${out:?}/$of"
    done
}
mkdir -p bytes
on="1-1 1-2 2-1 2-2 3-1 3-2 4-1 4-2 7-1 7-2"
bytes_of bench/dense-2k --set time.end=0.006 --set output.interval=0.002 --set output.data=true --set output.fstat=true
# tests/tests/ranks has most scenes with more ranks.
on="3-2 7-1"
bytes_of bench/mesh-drum-6k --set time.end=0.004 --set output.interval=0.002 --set output.triangle_loads=true
bytes_of bench/boulder-20k --set time.end=0.0006 --set output.interval=0.0003
bytes_of hopper-simple --set time.end=0.003 --set output.interval=0.001
bytes_of hopper-psd --set time.end=0.0005 --set output.interval=0.00025
bytes_of chute --set time.end=0.002 --set output.interval=0.001
bytes_of settle --set time.end=0.002 --set output.interval=0.001
bytes_of press --set time.end=0.02 --set output.interval=0.01 --set output.energy_budget=true
bytes_of triaxial --set time.end=0.004 --set output.interval=0.002
bytes_of discs-2d --set time.end=0.004 --set output.interval=0.002
bytes_of rolling --set time.end=0.01
bytes_of two-spheres
bytes_of clumps/drum --set time.end=0.02 --set output.interval=0.01
bytes_of clumps/rod-gas --set time.end=0.02 --set output.interval=0.01
bytes_of clumps/dominoes --set time.end=0.02 --set output.interval=0.01
bytes_of clumps/egg --set time.end=0.02 --set output.interval=0.01
bytes_of stress/overlaps --set time.end=0.002
bytes_of stress/dense-shear --set time.end=0.002 --set output.interval=0.001
bytes_of jkr-powder --set time.end=0.002 --set output.interval=0.001
bytes_of wet-packing --set time.end=0.02 --set output.interval=0.005
bytes_of wet-piles --set time.end=0.1 --set output.interval=0.05
bytes_of wet-pair
bytes_of spray-drum --set time.end=0.03 --set output.interval=0.01 --set sprays.0.from=0 --set sprays.0.speed=5 --set sprays.0.flow_rate=1e-4
bytes_of agglomerate --set time.end=0.0004 --set output.interval=0.0002
bytes_of bonded-cantilever --set time.end=0.002
bytes_of membrane --set particles.0.velocity=[0.0,0.0,-1.0] --set time.end=0.004 --set output.interval=0.002
bytes_of balloon --set time.end=0.002 --set output.interval=0.001
bytes_of gripper --set time.end=0.002 --set output.interval=0.001
bytes_of gripper-pull --set time.end=0.002 --set output.interval=0.001
bytes_of sleeve --set time.end=0.004 --set output.interval=0.002

# One scene of many things, in blocks of 8 rows: a sphere twenty times its neighbours, insertion over cuts, grains that go round through a periodic
# face, a servo, removal, a flux plane, tracks.
cat > many.toml << 'SCENE'
gravity = [0.0, 0.0, -9.81]
[time]
end  = 0.02
step = 2e-5
[domain]
min      = [0.0, 0.0, 0.0]
max      = [0.15, 0.1, 0.1]
periodic = ["x"]
[materials.bead]
density    = 2500.0
normal     = { law = "linear", stiffness = 2000.0, restitution = 0.6 }
tangential = { law = "linear", friction = 0.4, stiffness_ratio = 0.3 }
rolling    = { law = "luding", friction = 0.05 }
[[walls]]
name     = "floor"
shape    = "plane"
point    = [0.0, 0.0, 0.0]
normal   = [0.0, 0.0, 1.0]
material = "bead"
[[walls]]
name     = "lid"
shape    = "plane"
point    = [0.0, 0.0, 0.08]
normal   = [0.0, 0.0, -1.0]
material = "bead"
motion   = [{ kind = "servo", axis = [0.0, 0.0, 1.0], force = -5.0, max_speed = 0.1 }]
[[particles]]
name     = "rock"
position = [0.05, 0.05, 0.045]
radius   = 0.03
velocity = [5.0, 0.0, 0.0]
material = "bead"
[[insertions]]
name     = "fill"
material = "bead"
region   = { shape = "box", min = [0.0, 0.0, 0.0], max = [0.15, 0.1, 0.08] }
psd      = { kind = "lognormal", median_diameter = 3e-3, sigma = 0.4, weighting = "number", cut = [0.01, 0.99] }
total    = { number = 400 }
velocity = { mean = [4.0, 0.5, 0.0], spread = [0.5, 0.5, 0.5] }
[[insertions]]
name     = "later"
material = "bead"
region   = { shape = "box", min = [0.0, 0.0, 0.05], max = [0.15, 0.1, 0.08] }
psd      = { kind = "monodisperse", diameter = 2e-3 }
total    = { number = 300 }
rate     = { number = 20000.0 }
velocity = { mean = [0.0, 0.0, -2.0] }
[[deletions]]
name   = "out"
region = { shape = "half-space", point = [0.0, 0.07, 0.0], normal = [0.0, 1.0, 0.0] }
[[fluxes]]
name  = "gate"
plane = { point = [0.05, 0.0, 0.0], normal = [1.0, 0.0, 0.0] }
[[regions]]
name   = "low"
region = { shape = "box", min = [0.0, 0.0, 0.0], max = [0.15, 0.1, 0.04] }
[output]
interval = 0.005
data     = true
ene      = true
fstat    = true
left     = true
track    = ["rock", "later"]
SCENE
# shellcheck disable=SC2086
many() {
    local program=$1 ranks=$2 folder=$3
    shift 3
    local launch=""
    [ "$ranks" -gt 0 ] && launch="$run -np $ranks"
    timeout 300 $launch "$program" many.toml --rows-per-block 8 --quiet --output "$folder" "$@"
}
many "$without" 0 many/alone --threads 1
check $? "the scene of many things alone"
for ranks in 2 3 4 7; do
    many "$with" "$ranks" "many/$ranks" --threads 1 2> /dev/null && same many/alone "many/$ranks"
    check $? "the scene of many things on $ranks ranks"
done

# A checkpoint at the same step is the same file.
cmp -s many/alone/many.0.restart many/3/many.0.restart
check $? "checkpoints of 1 and 3 ranks"

# Stopped on two ranks, gone on with on three, again alone: the files of a run that never stopped.
long=$scenes/bench/dense-2k.toml
keys=(--set time.end=0.5 --set output.interval=0.1 --set output.data=true)
solve "$without" 0 stop/whole "$long" --threads 1 "${keys[@]}"
stop_by() {
    local how=$1 folder=stop/$1 code
    case $how in
        file)
            (sleep 1.5; touch "$folder/STOP") &
            solve "$with" 2 "$folder" "$long" --threads 1 "${keys[@]}" 2> /dev/null
            code=$?
            ;;
        usr2)
            (sleep 1.5; pkill -USR2 -x mpirun) &
            solve "$with" 2 "$folder" "$long" --threads 1 "${keys[@]}" 2> /dev/null
            code=$?
            ;;
        limit)
            solve "$with" 2 "$folder" "$long" --threads 1 --time-limit 1s "${keys[@]}" 2> /dev/null
            code=$?
            ;;
    esac
    [ "$code" = 75 ]
    check $? "stopped by $how: exit code $code"
    solve "$with" 3 "$folder" "$long" --threads 1 --resume --time-limit 1s "${keys[@]}" 2> /dev/null
    solve "$without" 0 "$folder" "$long" --threads 2 --resume "${keys[@]}"
    same_outputs stop/whole "$folder"
    check $? "stopped by $how on 2 ranks, gone on with on 3 and alone"
}
stop_by file
stop_by usr2
stop_by limit

# A rank that is killed ends the job soon, and the run goes on from its last checkpoint.
folder=stop/kill
solve "$with" 3 "$folder" "$long" --threads 1 --checkpoint-every 1s "${keys[@]}" 2> /dev/null &
job=$!
sleep 2.5
began=$SECONDS
pkill -KILL -n -f -- "--output $folder"
wait $job
code=$?
[ "$code" != 0 ] && [ $((SECONDS - began)) -le 5 ]
check $? "a killed rank: exit code $code after $((SECONDS - began)) s"
solve "$with" 2 "$folder" "$long" --threads 1 --resume "${keys[@]}" 2> /dev/null
same_outputs stop/whole "$folder"
check $? "gone on with after a rank was killed"

# A rank that panics ends the job.
began=$SECONDS
solve "$with" 3 stop/panic "$long" --threads 1 --fail-at 100 "${keys[@]}" 2> err.txt
code=$?
[ "$code" = 101 ] && [ "$(grep -c "rank 2 of 3 failed" err.txt)" = 1 ] && [ $((SECONDS - began)) -le 5 ]
check $? "a rank that panics: exit code $code after $((SECONDS - began)) s"

# The runs of a study, one after the other on all ranks, and again where they are finished.
sweep=(--threads 1 --set time.end=0.003 --set output.pictures=false --sweep materials.bead.normal.restitution=0.3,0.6)
solve "$without" 0 study/alone "$long" "${sweep[@]}"
solve "$with" 3 study/3 "$long" "${sweep[@]}" 2> /dev/null && diff -rq -x run.log -x summary.json -x 'study.*' study/alone study/3
check $? "a study on 3 ranks"
solve "$with" 2 study/3 "$long" "${sweep[@]}" 2> /dev/null
check $? "a study that is finished, on 2 ranks"

# A branch: its first rank makes the steps of the run again, and all go on.
kept=(--threads 1 --set time.end=0.01 --set output.link_interval=0.001 --set output.keep_checkpoints=4 --set output.pictures=false)
solve "$without" 0 branch/of "$long" "${kept[@]}"
branch() {
    # shellcheck disable=SC2086
    timeout 300 $2 "$1" --from branch/of --at 0.005 --set "gravity=[0,0,-1.62]" --rows-per-block 64 --quiet --threads 1 --output "$3"
}
branch "$without" "" branch/alone
branch "$with" "$run -np 3" branch/3 2> /dev/null && same branch/alone branch/3
check $? "a branch on 3 ranks"

# What is no run is made once.
# shellcheck disable=SC2086
$run -np 3 "$with" new drum new > new.txt 2> err.txt && [ "$(grep -c "next:" new.txt)" = 1 ] && [ ! -s err.txt ]
check $? "a scene to start from, by 3 processes"
# shellcheck disable=SC2086
$run -np 5 "$with" "$scenes/two-spheres.toml" --output idle > /dev/null 2> err.txt
[ "$(grep -c "5 ranks, of which 1 will have something to compute" err.txt)" = 1 ]
check $? "a note where there are more ranks than blocks"

# Errors: once, with the exit code of a single process, and nothing hangs.
error_of() {
    local name=$1 expected=$2 text=$3
    shift 3
    "$@" 2> err.txt > out.txt
    local code=$?
    local count
    count=$(grep -c -- "$text" err.txt)
    [ "$code" = "$expected" ] && [ "$count" = 1 ]
    check $? "$name: exit code $code, the message $count times: $(head -3 err.txt)"
}
sed 's/restitution = 0.6/restitution = 1.6/' many.toml > wrong.toml
error_of "a wrong scene" 2 "must lie in" solve "$with" 3 bad/wrong wrong.toml
error_of "a folder in use" 2 "already" solve "$with" 2 many/alone "$scenes/settle.toml"
error_of "standard input" 2 "standard input" solve "$with" 2 bad/input -
error_of "jobs of a study" 2 "one run is made at a time" solve "$with" 2 bad/study many.toml --sweep time.end=0.01,0.02 --jobs 2
error_of "without the feature" 2 "without MPI" solve "$without" 2 bad/none many.toml
[ ! -e bad/none ]
check $? "without the feature the folder is untouched"
sed 's/stiffness = 2000.0/stiffness = 0.2/' many.toml > soft.toml
error_of "the guard stops" 1 "help: the contact is too soft" solve "$with" 3 bad/soft soft.toml
# Where a small disk can be had: the first rank finds it full, and the others end with it.
if [ "$(id -u)" = 0 ] && mkdir small && mount -t tmpfs -o size=300k tmpfs small 2> /dev/null; then
    error_of "a full disk" 1 "No space left" solve "$with" 3 small/run "$long" --threads 1 --set output.data=true --set output.interval=0.001 --set time.end=0.03
    umount small
fi
# Memory: that of all ranks on the machine counts, and one rank may have less than the others.
sed -e 's/^max      = .*/max      = [9.0, 9.0, 9.0]/' -e 's/total    = { number = 400 }/total    = { number = 400000 }/' -e 's/max = \[0.15, 0.1, 0.08\]/max = [9.0, 9.0, 9.0]/' many.toml > large.toml
# shellcheck disable=SC2086
error_of "memory that one rank lacks" 1 "rank 1: .*is expected to need" $run -np 1 "$with" large.toml --quiet --output bad/large \
    : -np 1 bash -c "ulimit -v 1000000; exec '$with' large.toml --quiet --output bad/large"
[ ! -e bad/large ]
check $? "without the memory the folder is untouched"
# shellcheck disable=SC2086
$run -np 2 "$with" many.toml --check 2> /dev/null | grep -q "on this machine  *2,"
check $? "the ranks of the machine in --check"
cp many.toml other.toml
cat > other.sh << 'SCRIPT'
#!/bin/sh
[ "${OMPI_COMM_WORLD_RANK:-0}" = 1 ] && set -- "$@" --set time.end=0.01
exec "$PROGRAM" "$@"
SCRIPT
chmod +x other.sh
# shellcheck disable=SC2086
error_of "another scene on a rank" 2 "has another scene" env PROGRAM="$with" $run -np 2 ./other.sh other.toml --quiet --output bad/other

echo "$passed passed, $failed failed"
[ "$failed" = 0 ]
