#!/usr/bin/env bash
# What continuous integration checks of the feature `mpi`. It needs Debian's packages of Open MPI and libclang, and installs them where it can.
set -euo pipefail
cd "$(dirname "$0")/../.."

has_mpi() { command -v mpirun > /dev/null && echo '#include <mpi.h>' | mpicc -fsyntax-only -x c - 2> /dev/null; }
if ! has_mpi && [ "$(id -u)" = 0 ] && command -v apt-get > /dev/null; then
    apt-get install -y --no-install-recommends libopenmpi-dev openmpi-bin libclang-dev > /dev/null 2>&1 \
        || { apt-get update > /dev/null 2>&1 && apt-get install -y --no-install-recommends libopenmpi-dev openmpi-bin libclang-dev > /dev/null 2>&1; } \
        || true
fi
if ! has_mpi; then
    echo "not checked: Open MPI with its headers cannot be had (Debian: libopenmpi-dev openmpi-bin libclang-dev)"
    exit 0
fi
target="${CARGO_TARGET_DIR:-$PWD/target}"
# The whole workspace is selected, so that what it depends on has the features that it had before; the program alone and what it is made of differ.
cargo clippy --locked --workspace --features solver/mpi --bin mercury-solve -- -D warnings
# Programs of the tests, which are made with checks of overflow; the one without MPI is there already.
cp "$target/debug/mercury-solve" "$target/without-mpi"
cargo build --locked --workspace --features solver/mpi --bin mercury-solve
mv "$target/debug/mercury-solve" "$target/with-mpi"
cp "$target/without-mpi" "$target/debug/mercury-solve"
tests/mpi/accept.sh "$target/with-mpi" "$target/without-mpi"
