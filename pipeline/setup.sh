# Shared by pipeline/quickstart.sh and tests/run.sh (sourced, not run): installs missing Debian packages and
# builds. Idempotent. Debian 12 and 13 call the packages the same.

VITRINE_ROOT="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"

# The smallest set: OpenCV by component (libopencv-dev would install VTK, MPI and Qt, 300 MB more).
VITRINE_PACKAGES=(
  g++ cmake ninja-build ccache pkg-config
  libopencv-core-dev libopencv-imgproc-dev libopencv-imgcodecs-dev libopencv-dnn-dev
  libjpeg-dev libpng-dev libtiff-dev
  libceres-dev libcgal-dev libopenmesh-dev libmeshoptimizer-dev libembree-dev libopenexr-dev libeigen3-dev
  libyaml-cpp-dev libspdlog-dev libfmt-dev nlohmann-json3-dev libtbb-dev libxxhash-dev libutf8proc-dev libexif-dev liblcms2-dev libpugixml-dev zlib1g-dev libzstd-dev
  libsqlite3-dev libdnnl-dev
  libheif-dev libraw-dev
  python3-dev python3-numpy pybind11-dev
  colmap ffmpeg
)
# npm, from Debian or elsewhere, bundles the pages of `vitrine view`, `vitrine mark` and `vitrine ct`.
command -v npm >/dev/null && command -v node >/dev/null || VITRINE_PACKAGES+=(nodejs npm)
# Decoders of HEIC and AVIF, and the encoder of the tests: packages of their own since Debian 13.
VITRINE_WANTED_PACKAGES=(libheif-plugin-libde265 libheif-plugin-dav1d libheif-plugin-x265)
VITRINE_TEST_PACKAGES=(libgtest-dev libbenchmark-dev)
# Browser for the tests of the pages: Debian's Chromium, or an installed Chrome.
[ -x /usr/bin/google-chrome ] || VITRINE_TEST_PACKAGES+=(chromium)

say() { printf '\n== %s\n' "$*"; }

# known_packages PACKAGE...: those that this distribution has.
known_packages() {
  local package
  for package in "$@"; do
    apt-cache show "$package" >/dev/null 2>&1 && echo "$package"
  done
  return 0
}

# install_packages PACKAGE...: installs missing packages; needs root or sudo.
install_packages() {
  local missing=() package
  for package in "$@" $(known_packages "${VITRINE_WANTED_PACKAGES[@]}"); do
    [ "$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null)" = installed ] || missing+=("$package")
  done
  if [ ${#missing[@]} -eq 0 ]; then
    say "packages: all $# are installed"
    return
  fi
  say "packages: installing ${#missing[@]} of $#: ${missing[*]}"
  local as_root=()
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null || { echo "error: not root and no sudo; ask an administrator to install: ${missing[*]}" >&2; exit 7; }
    as_root=(sudo)
  fi
  "${as_root[@]}" apt-get update -qq
  missing+=($(known_packages "${VITRINE_WANTED_PACKAGES[@]}"))  # before the update apt may know no package
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
}

# build FOLDER [TARGET...] [CMAKE OPTION...]: configure and build (everything, or those targets), from nothing as a rule: the
# sources of a target together.
build() {
  local folder="$1" targets=(); shift
  while [ $# -gt 0 ] && [ "${1#-}" = "$1" ]; do targets+=("$1"); shift; done
  say "build: $folder"
  cmake -S "$VITRINE_ROOT" -B "$folder" -G Ninja -DVITRINE_MERGE=ON "$@" >"$folder.configure.log" 2>&1 ||
    { cat "$folder.configure.log" >&2; echo "error: configuring failed; the lines above say why" >&2; exit 1; }
  rm -f "$folder.configure.log"
  cmake --build "$folder" ${targets[@]:+--target "${targets[@]}"}
}
