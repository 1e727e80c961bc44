#!/usr/bin/env bash
# The kernels for a GPU on a card: builds vitrine-gpu-check, compares the bytes of the device with those of the loops on the CPU and of a
# second run, prints the time of each kernel, and lets compute-sanitizer look for races where it is installed.
#
#   tests/bench/gpu_check.sh [BUILD]       BUILD: folder of the build (default: build of this checkout, configured if it is not)
#
# Needs nvcc and a CUDA device; where one is missing it exits with 77, which ctest counts as skipped. Two minutes besides the build (estimate:
# it has run on no card yet).
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

if command -v compute-sanitizer >/dev/null; then
  for tool in racecheck memcheck; do
    say "compute-sanitizer --tool $tool, small scenes"
    compute-sanitizer --tool "$tool" --error-exitcode 1 "$build/bin/vitrine-gpu-check" small
  done
else
  echo "compute-sanitizer is not installed: races were not looked for"
fi
