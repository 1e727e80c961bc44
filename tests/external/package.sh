#!/usr/bin/env bash
# The Debian package as a user meets it: built from this checkout, read by lintian, installed into a clean root of the same release, and
# run there on photos; and the OCI image of that root.
#
#   tests/external/package.sh [ROOT]
#
# ROOT  folder of the clean root, deleted first (default: /var/tmp/vitrine-package). Needs root, debootstrap and mounts, 3 GB of disk and
# some fifteen minutes besides the build; where one is missing it exits with 77, which ctest counts as skipped.
set -euo pipefail

skip() { echo "skipped: $*"; exit 77; }
fail() { echo "error: $*" >&2; exit 1; }
say() { printf '\n== %s\n' "$*"; }

[ "${1:-}" != --help ] || { sed -n '2,9s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; exit 0; }
root="$(realpath -m "${1:-/var/tmp/vitrine-package}")"
checkout="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)"
[ "$(id -u)" -eq 0 ] || skip "not root, and debootstrap and chroot need it"
if [ -z "${VITRINE_OWN_MOUNTS:-}" ] || [ -z "${VITRINE_PACKAGE_MOUNTS:-}" ]; then
  unshare --mount true 2>/dev/null || skip "this machine allows no mount namespace (a container without CAP_SYS_ADMIN?)"
  VITRINE_OWN_MOUNTS=1 VITRINE_PACKAGE_MOUNTS=1 exec unshare --mount --propagation private bash "${BASH_SOURCE[0]}" "$@"
fi
source "$checkout/pipeline/setup.sh"
install_packages "${VITRINE_PACKAGES[@]}" debootstrap buildah netavark lintian help2man dpkg-dev fakeroot

programs=(vitrine vitrine-report vitrine-farm $(sed -n 's/^set(VITRINE_\(STAGES\|TOOLS\) \([a-z ]*\))$/\2/p' "$checkout/stages/CMakeLists.txt" | tr ' ' '\n' | sed 's/^/vitrine-/'))
build "$checkout/build" "${programs[@]}" vitrine_page vitrine_python
say "package"
rm -f "$checkout"/build/vitrine_*.deb
(cd "$checkout/build" && cpack --config CPackConfig.cmake)
deb="$(ls "$checkout"/build/vitrine_*.deb)"

say "lintian"
lintian --fail-on error --allow-root "$deb"

say "a clean root with the package, and the image: $root"
[[ "$root" != "$checkout"* ]] || fail "the root $root lies in the checkout"
image="$root.tar"
"$checkout/pipeline/package/image.sh" "$deb" "$image" "$root"
mount -t proc proc "$root/proc"
mount --rbind /dev "$root/dev"
mkdir "$root/photos"
cp "$checkout"/sample_data/cabinet/photos/*[02468].* "$root/photos/"
inside() { chroot "$root" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 bash -c "$1"; }

say "vitrine run"
inside "{ vitrine doctor || [ \$? -eq 7 ]; } && vitrine run /photos -o /out --preset preview --set ingest.max_side=320 --set optimize.iterations=60 --set refine.fine_tune.iterations=10 --no-progress"
for file in out/report.html out/mesh/mesh.ply out/view.html usr/share/man/man1/vitrine-run.1.gz usr/share/bash-completion/completions/vitrine; do
  [ -s "$root/$file" ] || fail "/$file is missing"
done
if command -v qemu-x86_64 >/dev/null; then
  code=0
  said="$(qemu-x86_64 -cpu Nehalem -L "$root" "$root/usr/lib/vitrine/vitrine" --version 2>&1)" || code=$?
  [[ $code -eq 8 && "$said" == *"no AVX2"* ]] || fail "on a processor without AVX2: exit $code, $said"
fi
say "the image"
store="$(mktemp -d /var/tmp/vitrine-store.XXXXXX)"
trap 'rm -rf --one-file-system "$store"' EXIT
load=(buildah --root "$store/storage" --runroot "$store/run" --storage-driver vfs)
container="$("${load[@]}" from --ulimit "nofile=$(ulimit -Hn)" --ulimit "nproc=$(ulimit -Hu)" "oci-archive:$image")"  # its own may be above this machine's
[[ "$("${load[@]}" run --isolation chroot "$container" -- /usr/bin/vitrine --version)" == "$("$checkout/build/bin/vitrine" --version)" ]] || fail "the image holds another version"
[[ "$("${load[@]}" inspect --format '{{.OCIv1.Config.Entrypoint}}' "$container")" == "[/usr/bin/vitrine]" ]] || fail "the image starts something else"
say "passed: $(basename "$deb"), $(du -h "$deb" | cut -f1)"
