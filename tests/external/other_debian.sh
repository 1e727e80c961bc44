#!/usr/bin/env bash
# Both commands of README.md on another release of Debian: in a root that debootstrap makes, on a copy of this checkout.
#
#   tests/external/other_debian.sh [RELEASE] [ROOT]
#
# RELEASE  code name (default: trixie)      ROOT  folder of the root (default: /var/tmp/vitrine-RELEASE)
#
# The root is kept: the next run installs and compiles only what is new. Needs root and debootstrap, about 8 GB of disk and an hour on two
# cores; where one is missing it exits with 77, which ctest counts as skipped. VITRINE_RENEW_GOLDEN=1 takes the stage digests of RELEASE
# (tests/golden) into this checkout instead of comparing them.
set -euo pipefail

skip() { echo "skipped: $*"; exit 77; }
fail() { echo "error: $*" >&2; exit "${2:-1}"; }

case "${1:-}" in -h | --help) sed -n '2,10s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; exit 0 ;; esac
[ $# -le 2 ] || fail "usage: other_debian.sh [RELEASE] [ROOT]"
release="${1:-trixie}" root="$(realpath -m "${2:-/var/tmp/vitrine-${1:-trixie}}")"
checkout="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)"
[[ "$root/" != "$checkout/"* ]] || fail "the root $root lies in the checkout: give a folder outside it"
[ "$(id -u)" -eq 0 ] || skip "not root, and debootstrap and chroot need it"
command -v debootstrap >/dev/null || skip "debootstrap is missing (apt-get install debootstrap)"
# A mount namespace of its own: what is mounted below goes with this process, however it ends.
if [ -z "${VITRINE_OWN_MOUNTS:-}" ]; then
  unshare --mount true 2>/dev/null || skip "this machine allows no mount namespace (a container without CAP_SYS_ADMIN?)"
  VITRINE_OWN_MOUNTS=1 exec unshare --mount --propagation private bash "${BASH_SOURCE[0]}" "$release" "$root"
fi

say() { printf '\n== %s\n' "$*"; }

# A bare root. debootstrap deletes its folder /debootstrap when it is done.
make_root() {
  local mirror
  if [ -e "$root/etc/os-release" ] && [ ! -d "$root/debootstrap" ]; then
    grep -q "^VERSION_CODENAME=$release$" "$root/etc/os-release" || fail "$root is not a root of Debian '$release': give another folder"
    return
  fi
  [ -d "$root/debootstrap" ] || [ -z "$(ls -A "$root" 2>/dev/null)" ] || fail "$root is neither empty nor a Debian root: give another folder"
  # The mirror and the proxy of this machine's apt.
  mirror="$(apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' 'Origin: Debian' 'Label: Debian' 2>/dev/null | head -n 1 || true)"
  mirror="${mirror:-http://deb.debian.org/debian}"
  say "debootstrap: $release from $mirror into $root"
  mkdir -p "$root"
  debootstrap --variant=minbase "$release" "$root" "$mirror" >"$root.debootstrap.log" 2>&1 ||
    { tail -n 5 "$root.debootstrap.log" >&2; fail "debootstrap failed; all of it: $root.debootstrap.log"; }
  rm -f "$root.debootstrap.log"
}

# Network settings of this machine that programs in the root need.
give_network() {
  cp -L /etc/resolv.conf "$root/etc/resolv.conf"
  apt-config dump 2>/dev/null | grep -iE '^Acquire::https?::Proxy' >"$root/etc/apt/apt.conf.d/90proxy" || true
  local certificates="${NODE_EXTRA_CA_CERTS:-${SSL_CERT_FILE:-}}" name
  for name in http_proxy https_proxy no_proxy HTTP_PROXY HTTPS_PROXY NO_PROXY; do
    [ -z "${!name:-}" ] || settings+=("$name=${!name}")
  done
  if [ -f "$certificates" ]; then
    cp -L "$certificates" "$root/opt/certificates.crt"
    settings+=(NODE_EXTRA_CA_CERTS=/opt/certificates.crt)
  fi
}

# All files of the checkout but the ignored ones. Unchanged files keep their time stamps, and the build folders stay: only what differs is
# compiled again.
copy_checkout() {
  local there="$root/opt/vitrine" fresh="$root/opt/vitrine.fresh" file kept
  say "checkout: $checkout to $there"
  rm -rf "$fresh"
  mkdir -p "$there" "$fresh"
  if git -C "$checkout" rev-parse --is-inside-work-tree >/dev/null 2>&1; then
    git -C "$checkout" ls-files -z --cached --others --exclude-standard
  else
    (cd "$checkout" && find . -name 'build*' -prune -o -name 'out*' -prune -o -type f -print0)
  fi | (cd "$checkout" && while IFS= read -r -d '' file; do [ ! -e "$file" ] || printf '%s\0' "$file"; done) |
    tar -C "$checkout" --null -T - -c | tar -C "$fresh" -m -x
  (cd "$fresh" && find . -type f -print0) | while IFS= read -r -d '' file; do
    ! cmp -s "$fresh/$file" "$there/$file" || touch -r "$there/$file" "$fresh/$file"
  done
  for kept in "$there"/build*; do
    [ ! -e "$kept" ] || mv "$kept" "$fresh/"
  done
  rm -rf "$there"
  mv "$fresh" "$there"
}

# inside COMMAND: in the checkout of the root, without the environment of this machine.
inside() {
  chroot "$root" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 "${settings[@]}" bash -c "cd /opt/vitrine && $1"
}

# step NAME COMMAND: one line of the summary.
step() {
  local begin=$SECONDS code=0
  say "$1: $2"
  inside "$2" || code=$?
  [ $code -eq 0 ] || failed=1
  summary+=("$(printf '%-12s %-20s %4d s   %s' "$1" "$([ $code -eq 0 ] && echo passed || echo "failed (exit $code)")" $((SECONDS - begin)) "$2")")
}

settings=() summary=() failed=0
make_root
give_network
copy_checkout
mount -t proc proc "$root/proc"
mount --rbind /dev "$root/dev"

# The first command with few steps: all stages and both pictures under other lights, a scene that nobody looks at.
step quickstart "pipeline/quickstart.sh -o /opt/out --set optimize.iterations=150 --set refine.fine_tune.iterations=20"
step tests "tests/run.sh --fast --no-sanitizers"
step digests "${VITRINE_RENEW_GOLDEN:+VITRINE_RENEW_GOLDEN=1 }build/bin/test_golden --gtest_brief=1 --gtest_filter='StageDigests*'"
if [ -n "${VITRINE_RENEW_GOLDEN:-}" ]; then
  cp "$root"/opt/vitrine/tests/golden/stage_digests.*.json "$checkout/tests/golden/"
fi

say "Debian $(cat "$root/etc/debian_version") ($release), $(inside "g++ --version | head -n 1"), $(inside 'colmap -h | grep -o -m 1 "COLMAP [0-9.]*"')"
printf '  %s\n' "${summary[@]}"
exit $failed
