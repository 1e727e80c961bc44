#!/usr/bin/env bash
# The kernels for a GPU on a card: builds vitrine-gpu-check, compares the bytes of the device with those of the loops on the CPU and of a
# second run, and prints the time of each kernel, of training steps, whose surfels stay on the device (480 x 270 with 50,000 of them,
# 1280 x 800 with 300,000), and of one million rays (300,000 surfels). Then `preview` of sample_data/cabinet, its training with
# --device cuda and with --device cpu: seconds and dB of held-out photos. At last compute-sanitizer looks for races where it is installed.
#
#   tests/bench/gpu_check.sh [BUILD]       BUILD: folder of the build (default: build of this checkout, configured if it is not)
#
# Needs nvcc and a CUDA device; where one is missing it exits with 77, which ctest counts as skipped. VITRINE_GPU_CHECK=kernels leaves the
# cabinet out. A quarter of an hour on 16 cores (estimate: it has run on no card yet).
set -euo pipefail

skip() { echo "skipped: $*"; exit 77; }
say() { printf '\n== %s\n' "$*"; }

checkout="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)"
build="${1:-$checkout/build}"
command -v nvcc >/dev/null || [ -x "${CUDA_PATH:-/usr/local/cuda}/bin/nvcc" ] || skip "there is no nvcc"
nvidia-smi -L 2>/dev/null | grep -q GPU || skip "there is no CUDA device (nvidia-smi lists none)"
nvidia-smi --query-gpu=name,driver_version --format=csv,noheader

[ -f "$build/build.ninja" ] || cmake -S "$checkout" -B "$build" -G Ninja -DVITRINE_TESTS=ON -DVITRINE_MERGE=ON >/dev/null
say "build"
cmake --build "$build" --target vitrine-gpu-check

say "bytes and times"
"$build/bin/vitrine-gpu-check"

# seconds and dB of `vitrine run` from training to evaluation; what training reads is computed before
preview() {
  local cabinet="$checkout/sample_data/cabinet" targets=(vitrine vitrine-report vitrine-view) stage device begin out
  while read -r stage; do targets+=("vitrine-$stage"); done < "$build/bin/vitrine.stages"
  say "build for preview"
  cmake --build "$build" --target "${targets[@]}"
  "$build/bin/vitrine" doctor | grep GPU || true
  out="$(mktemp -d)"
  trap 'rm -rf "$out"' EXIT
  "$build/bin/vitrine" run "$cabinet/photos" --masks "$cabinet/marks.yaml" -o "$out/cuda" --preset preview --to normals --no-progress --quiet
  cp -r "$out/cuda" "$out/cpu"
  for device in cuda cpu; do
    say "preview of sample_data/cabinet, training to evaluation, --device $device"
    begin=$SECONDS
    "$build/bin/vitrine" run "$out/$device" --device "$device" --to evaluate --no-progress --quiet
    echo "$((SECONDS - begin)) s, $(grep -o '"psnr": *[0-9.]*' "$out/$device/eval/metrics.json" | head -n 1) dB of held-out photos"
  done
}
[ "${VITRINE_GPU_CHECK:-}" = kernels ] || preview

if command -v compute-sanitizer >/dev/null; then
  for tool in racecheck memcheck; do
    say "compute-sanitizer --tool $tool, small scenes"
    compute-sanitizer --tool "$tool" --error-exitcode 1 "$build/bin/vitrine-gpu-check" small
  done
else
  echo "compute-sanitizer is not installed: races were not looked for"
fi
