#!/usr/bin/env bash
# From a bare Debian 12 or 13 to a relit scene: installs what is missing, builds, runs the whole road on your photos, and shows the scene
# under other lamps.
#
#   pipeline/quickstart.sh [PHOTOS] [-o OUT] [vitrine run options...]
#
# PHOTOS  folder of photos (default: sample_data/cabinet/photos)      OUT  output folder (default: out)
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

sample="$VITRINE_ROOT/sample_data/cabinet/photos" photos="" out=out options=()
while [ $# -gt 0 ]; do
  case "$1" in
    -h | --help) sed -n '2,7s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; exit 0 ;;
    -o | --output) [ $# -gt 1 ] || { echo "error: $1 needs a folder" >&2; exit 2; }; out="$2"; shift 2 ;;
    -o?*) out="${1#-o}"; shift ;;
    --output=*) out="${1#*=}"; shift ;;
    --force | -n | --dry-run | --no-preflight | --no-progress | -q | --quiet | -v | --verbose | --*=* | -[!-]?*) options+=("$1"); shift ;;
    -*) [ $# -gt 1 ] || { echo "error: $1 needs a value; vitrine run --help lists the options" >&2; exit 2; }
        options+=("$1" "$2"); shift 2 ;;
    *) [ -z "$photos" ] || { echo "error: two folders of photos: '$photos' and '$1'" >&2; exit 2; }
       photos="$1"; shift ;;
  esac
done
photos="${photos:-$sample}"
[ -d "$photos" ] || { echo "error: there is no photo folder '$photos'" >&2; exit 3; }
# The sample comes with marks of its glass and metal.
if [ "$photos" -ef "$sample" ] && [[ " ${options[*]} " != *" --masks"* ]]; then
  options+=(--masks "$VITRINE_ROOT/sample_data/cabinet/marks.yaml")
fi

install_packages "${VITRINE_PACKAGES[@]}"
build "$VITRINE_ROOT/build" -DVITRINE_TESTS=OFF
vitrine="$VITRINE_ROOT/build/bin/vitrine"
say "run: vitrine run $photos -o $out --preset preview"
"$vitrine" run "$photos" -o "$out" --preset preview "${options[@]}"
[[ " ${options[*]} " != *" --dry-run "* && " ${options[*]} " != *" -n "* ]] || exit 0
# A partial run (--to mesh) has no materials: relighting is not possible.
if [ -e "$out/decompose/materials.ply" ]; then
  lamps="$VITRINE_ROOT/configs/lights/lamps.yaml"
  say "relight: vitrine relight $out --lights $lamps"
  "$vitrine" relight "$out" --lights "$lamps"
  "$vitrine" relight "$out" --lights "$lamps" --turntable 24 --size 320x240 --spp 16 --output "$out/turntable"
  "$vitrine" report "$out"  # adds the relit pictures
fi

say "done. Where to look:"
# show FILE WHAT: prints a line if the file exists.
show() { [ ! -e "$out/$1" ] || printf '  %-32s %s\n' "$out/$1" "$2"; }
show view.html "the scene from any side, under any light; open it in a browser"
show report.html "how well it went, what is weak, what to try next; open it in a browser"
show eval/contact_sheet.jpg "photo, render, error, normals and depth of the held-out views"
show mesh/mesh.ply "the mesh, with colours and normals (MeshLab, Blender, CloudCompare)"
show relit/ "held-out views under two lamps (another light: vitrine relight $out --env HDRI)"
show turntable/ "a turntable under the same lamps"
show export/mesh.glb "the mesh with materials; glass transmits (three.js, Blender, any glTF viewer)"
show export/ "Gaussians (2DGS, 3DGS, merged preview), COLMAP model, OBJ, USD"
show eval/metrics.json "PSNR, SSIM; errors against truth when there is a truth folder"
[[ " ${options[*]} " == *" --masks"* ]] || echo "glass, polished metal, a mirror in it? Draw them:   $vitrine mark $out --open"
echo "again, or with other options:   $vitrine run $out --preset standard"
