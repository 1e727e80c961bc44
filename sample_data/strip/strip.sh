#!/usr/bin/env bash
# The pictures at the top of README.md, from a finished run with glass: photo, held-out view, view without its glass, relit.
#
#   sample_data/strip/strip.sh RUN VIEW [HDRI] [OUT]
#
# VIEW  a held-out photo without its extension (optimize/views.json); HDRI  default: the studio of tiny_room;
# OUT   default: sample_data/strip.jpg. The pictures go to RUN/render and RUN/relit.
set -euo pipefail
root="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)"
[ $# -ge 2 ] || { sed -n '2,7s/^# \{0,1\}//p' "${BASH_SOURCE[0]}" >&2; exit 2; }
run="$1" view="$2" light="${3:-$root/sample_data/tiny_room/truth/env/studio.exr}" out="${4:-$root/sample_data/strip.jpg}"

"$root/build/bin/vitrine" render "$run" --views heldout --layers --quiet
"$root/build/bin/vitrine" relight "$run" --env "$light" --views heldout --quiet
"$root/build/bin/vitrine-strip" "$run" "$view" "$run/relit/$(basename "${light%.*}")/$view.png" "$out"
size=$(stat -c %s "$out")
[ "$size" -lt 300000 ] || { echo "error: $out has $size bytes; at most 300000 are committed" >&2; exit 1; }
