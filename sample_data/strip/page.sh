#!/usr/bin/env bash
# The two pictures of view.html in README.md, from a finished run: as photographed, and under an HDRI. Needs Chromium and the packages
# of the tests of pages, which every build with tests installs.
#
#   sample_data/strip/page.sh RUN [HDRI] [OUT]
#
# HDRI  default: the studio of tiny_room;  OUT  default: sample_data/page, for page_photo.jpg and page_relit.jpg
set -euo pipefail
root="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)"
[ $# -ge 1 ] || { sed -n '2,7s/^# \{0,1\}//p' "${BASH_SOURCE[0]}" >&2; exit 2; }
page="$(realpath "$1")/view.html" light="$(realpath "${2:-$root/sample_data/tiny_room/truth/env/studio.exr}")" out="$(realpath -m "${3:-$root/sample_data/page}")"

packages="$root/build/tests_pages"
[ -d "$packages/node_modules" ] || { echo "error: there are no packages in $packages; building the target test_pages installs them" >&2; exit 7; }
cp "$root/tests/pages/chromium.mjs" "$root/sample_data/strip/page.mjs" "$packages"
(cd "$packages" && node page.mjs "$page" "$light" "$out")
for picture in "${out}_photo.jpg" "${out}_relit.jpg"; do
  size=$(stat -c %s "$picture")
  [ "$size" -lt 120000 ] || { echo "error: $picture has $size bytes; at most 120000 are committed" >&2; exit 1; }
done
