#!/usr/bin/env bash
# Sets everything up on a bare Debian 12 or 13, Chromium for the tests of the pages included, and runs all tests through ctest; then those of core/
# and of all parsers again under AddressSanitizer and UndefinedBehaviorSanitizer.
#
#   tests/run.sh [--fast] [--no-sanitizers | --sanitize-stages] | --races | --external
#
# --fast            only the fast tier (about a minute)      --no-sanitizers   skip the sanitized build
# --sanitize-stages the suites of stages and pipeline sanitized, too
# --races           instead: the suites of multi-threaded code under ThreadSanitizer (core/foundation/base/parallel.cpp says how)
# --external        instead: what other people's programs say about exported files, long runs of sfm, and the other release of Debian
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../pipeline/setup.sh"

labels=(-LE external) sanitizers=1 stages=OFF races=0 jobs="$(nproc)"
for argument in "$@"; do
  case "$argument" in
    --fast) labels=(-L fast) ;;
    --no-sanitizers) sanitizers=0 ;;
    --sanitize-stages) stages=ON ;;
    --races) races=1 ;;
    --external)  # one at a time: they share a folder of npm packages
      labels=(-L external) sanitizers=0 jobs=1
      VITRINE_TEST_PACKAGES+=(debootstrap)
      ;;
    -h | --help) sed -n '2,10s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; exit 0 ;;
    *) echo "error: unknown option '$argument'" >&2; exit 2 ;;
  esac
done

install_packages "${VITRINE_PACKAGES[@]}" "${VITRINE_TEST_PACKAGES[@]}"

if [ "$races" = 1 ]; then
  suites=(stage optim train loss render trace model)
  build "$VITRINE_ROOT/build-thread" "${suites[@]/#/test_}" -DVITRINE_SANITIZE=thread -DCMAKE_BUILD_TYPE=RelWithDebInfo
  say "under ThreadSanitizer: ${suites[*]}"
  for suite in "${suites[@]}"; do
    TSAN_OPTIONS=second_deadlock_stack=1 "$VITRINE_ROOT/build-thread/bin/test_$suite" --gtest_brief=1
  done
  exit
fi
build "$VITRINE_ROOT/build" -DVITRINE_TESTS=ON
say "tests"
export VITRINE_NEED_CHROMIUM=1  # what elsewhere skips the tests of the pages is a failure here
ctest --test-dir "$VITRINE_ROOT/build" --output-on-failure --no-tests=error -j "$jobs" "${labels[@]}"
grep -h '^skipped: ' "$VITRINE_ROOT/build/Testing/Temporary/LastTest.log" || true  # reasons; ctest prints only the names

if [ "$sanitizers" = 1 ]; then
  build "$VITRINE_ROOT/build-sanitize" vitrine_tests -DVITRINE_TESTS=ON -DVITRINE_SANITIZE=ON -DVITRINE_SANITIZE_STAGES="$stages" -DCMAKE_BUILD_TYPE=RelWithDebInfo
  say "tests of core/ and parsers under AddressSanitizer and UndefinedBehaviorSanitizer"
  # Eight frames of where memory came from are enough, and cost a tenth less than thirty. Without intercept_tls_get_addr=0
  # the leak checker of g++ 13 and older mistakes some thread-local blocks of loaded libraries (codecs) for those of glibc 2.19,
  # reads a length where there is none, and now and then dies in a test that passed (github.com/google/sanitizers/issues/1322).
  ASAN_OPTIONS=malloc_context_size=8:intercept_tls_get_addr=0 UBSAN_OPTIONS=print_stacktrace=1 \
    ctest --test-dir "$VITRINE_ROOT/build-sanitize" --output-on-failure --no-tests=error -j "$(nproc)" -L fast
fi
