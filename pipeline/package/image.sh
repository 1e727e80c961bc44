#!/usr/bin/env bash
# An OCI image of vitrine from its Debian package: a minimal Debian of this machine's release with the package in it, no daemon needed.
#
#   pipeline/package/image.sh PACKAGE.deb ARCHIVE.tar [ROOT]
#
# ARCHIVE.tar  an OCI archive: `podman load -i`, `docker load -i`, or for clusters `apptainer build vitrine.sif oci-archive:ARCHIVE.tar`
# ROOT         folder of the file system of the image, deleted first and kept (default: a temporary one)
#
# Needs root, debootstrap, buildah (with netavark since Debian 13) and mounts. Exit codes: 2 usage, 7 a missing program, 1 anything else.
set -euo pipefail

fail() { echo "error: $2" >&2; exit "$1"; }

[ "${1:-}" != --help ] || { sed -n '2,9s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; exit 0; }
[ $# -ge 2 ] && [ $# -le 3 ] || fail 2 "usage: image.sh PACKAGE.deb ARCHIVE.tar [ROOT]"
[ -s "$1" ] || fail 2 "there is no package $1 (cd build && cpack makes one)"
[ "$(id -u)" -eq 0 ] || fail 1 "debootstrap and chroot need root"
for program in debootstrap buildah; do command -v "$program" >/dev/null || fail 7 "$program is missing: apt-get install $program"; done
if [ -z "${VITRINE_IMAGE_MOUNTS:-}" ]; then
  VITRINE_IMAGE_MOUNTS=1 exec unshare --mount --propagation private bash "${BASH_SOURCE[0]}" "$@"
fi
package="$(realpath "$1")" archive="$(realpath -m "$2")"
work="$(mktemp -d "${TMPDIR:-/var/tmp}/vitrine-image.XXXXXX")"
root="$(realpath -m "${3:-$work/root}")"
trap 'umount -R "$root/proc" 2>/dev/null || true; rm -rf --one-file-system "$work"' EXIT

release="$(. /etc/os-release && echo "$VERSION_CODENAME")"
# The suites of this machine, security updates among them: the package depends on the versions of the libraries that are installed here.
suites="$(apt-get indextargets --format 'deb $(REPO_URI) $(RELEASE) $(COMPONENT)' 'Created-By: Packages' 'Origin: Debian' 2>/dev/null | sort -u || true)"
[ -n "$suites" ] || suites="deb http://deb.debian.org/debian $release main"
mirror="$(awk -v release="$release" '$3 == release { print $2; exit }' <<<"$suites")"
rm -rf --one-file-system "$root"
debootstrap --variant=minbase "$release" "$root" "${mirror:-http://deb.debian.org/debian}" >"$work/log" 2>&1 || { tail -n 5 "$work/log" >&2; fail 1 "debootstrap failed"; }
# What this machine needs to reach the mirror is no part of the image.
printf '%s\n' "$suites" >"$root/etc/apt/sources.list"
cp -L /etc/resolv.conf "$root/etc/resolv.conf"
apt-config dump 2>/dev/null | grep -iE '^Acquire::https?::Proxy' >"$root/etc/apt/apt.conf.d/90proxy" || true
mount -t proc proc "$root/proc"
cp "$package" "$root/tmp/vitrine.deb"
chroot "$root" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 DEBIAN_FRONTEND=noninteractive bash -c \
  'apt-get update -qq && apt-get install -y -qq --no-install-recommends /tmp/vitrine.deb && apt-get clean' >"$work/log" 2>&1 || { tail -n 20 "$work/log" >&2; fail 1 "the package could not be installed"; }
umount "$root/proc"
rm -rf "$root"/tmp/vitrine.deb "$root"/var/lib/apt/lists/* "$root/etc/apt/apt.conf.d/90proxy" "$root/etc/resolv.conf"
sed -i -E 's#^deb \S+ (\S+-security) #deb http://deb.debian.org/debian-security \1 #; t; s#^deb \S+ #deb http://deb.debian.org/debian #' "$root/etc/apt/sources.list"

build=(buildah --root "$work/storage" --runroot "$work/run" --storage-driver vfs)
container="$("${build[@]}" from scratch)"
"${build[@]}" add -q "$container" "$root" / >/dev/null
"${build[@]}" config --entrypoint '["/usr/bin/vitrine"]' --workingdir /data --env LANG=C.UTF-8 \
  --label "org.opencontainers.image.version=$(dpkg-deb -f "$package" Version)" --label org.opencontainers.image.title=vitrine "$container"
rm -f "$archive"
"${build[@]}" commit -q --format oci "$container" "oci-archive:$archive:vitrine:$(dpkg-deb -f "$package" Version | tr '~+' '--')" >/dev/null
echo "$archive: $(du -h "$archive" | cut -f1)"
