#!/usr/bin/env bash
# Builds the image of deploy/Containerfile by buildah, without a container engine and without rights of a daemon, and writes it
# as an OCI archive. image.sh FOLDER-WITH-PROGRAMS ARCHIVE.tar [BASE]
# Without BASE the base is a Debian tree by debootstrap, so no registry is needed; that needs root.
set -euo pipefail
bin="$(realpath "$1")" archive="$(realpath -m "$2")"
here="$(cd "$(dirname "$0")" && pwd)"
scratch="$(mktemp -d)"
trap 'rm -rf "$scratch"' EXIT
# vfs and chroot need neither a kernel's overlays nor namespaces.
buildah() { command buildah --storage-driver vfs --root "$scratch/images" --runroot "$scratch/run" "$@"; }
base="${3:-}"
if [ -z "$base" ]; then
  debootstrap --variant=minbase --include=ca-certificates bookworm "$scratch/tree" "${DEBIAN_MIRROR:-http://deb.debian.org/debian}" > "$scratch/debootstrap.log" \
    || { tail -n 5 "$scratch/debootstrap.log" >&2; exit 1; }
  rm -rf "$scratch/tree/var/cache/apt" "$scratch/tree/var/lib/apt/lists" "$scratch/tree/usr/share/doc" "$scratch/tree/usr/share/man" "$scratch/tree/dev"
  mkdir -p "$scratch/tree/dev"
  empty="$(buildah from scratch)"
  buildah add --quiet "$empty" "$scratch/tree" /
  buildah commit --quiet "$empty" mercury-base
  rm -rf "$scratch/tree"
  base=localhost/mercury-base
fi
mkdir "$scratch/context"
cp "$bin/mercury-cloud" "$bin/mercury-solve" "$bin/mercury-export" "$scratch/context"
buildah bud --isolation chroot --build-arg "BASE=$base" --tag mercury-cloud --file "$here/Containerfile" "$scratch/context"
# The programs start in it, as a user without rights.
container="$(buildah from localhost/mercury-cloud)"
for program in mercury-cloud mercury-solve mercury-export; do
  buildah run --isolation chroot "$container" -- "/usr/local/bin/$program" --version
done
if [ -n "${CHECK:-}" ]; then
  # A run in the image alone: server, worker and solver.
  buildah run --isolation chroot "$container" -- /bin/sh -ec "$CHECK"
fi
rm -f "$archive"
buildah push --quiet mercury-cloud "oci-archive:$archive:mercury-cloud"
ls -l "$archive"
