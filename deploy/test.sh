#!/usr/bin/env bash
# Everything that is tested, on a fresh Debian 12: installs, builds, runs. Ends with the test runner's summary.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
cd "$(dirname "$here")"
say() { printf '\n== %s (%s s)\n' "$*" "$SECONDS"; }

"$here/lib/install_packages.sh" build test real
jobs=$(nproc)

say "formatting"
git ls-files -z '*.h' '*.cpp' | xargs -0 clang-format --dry-run -Werror

say "release build, each public header alone"
cmake --preset release >/dev/null
cmake --build --preset release -j "$jobs" --target all headers_stand_alone

say "address and undefined-behaviour sanitizers; fuzzers, a few seconds each"
cmake --preset asan >/dev/null
cmake --build --preset asan -j "$jobs"
# Leaks are looked for in our own code; what Mesa and DDS keep until the end of the process is left out.
export LSAN_OPTIONS=suppressions=$PWD/tests/lsan.supp:print_suppressions=0
# clang 14 takes a thread's memory for that of a glibc before 2.25 where it happens to lie at a certain place in its
# page, and its leak checker then dies.
export ASAN_OPTIONS=intercept_tls_get_addr=0
# What measures accuracy over many frames runs the same code as its neighbours, only longer.
accuracy='ABoxThat|SmallChange|NoDeviation|SimulatedNoise|NoiseThatSticks|IsNotPulledBy|IsPulledNoFarther|ThatHasNoColors|AnotherExposure|StaleModel|DemoData|LeavesNoOpenBorder|KeepsTheBorderWhen|DoublesNoSurface|LetRealChangesPass|FindAPoseThatIsOff|DoNoHarmTo|AreNotWorseThanEach'
ctest --preset asan -j "$jobs" -L 'unit|sanitize|fuzz' -E "$accuracy" --no-tests=error

say "thread sanitizer"
cmake --preset tsan >/dev/null
cmake --build --preset tsan -j "$jobs" --target thread_tests
TSAN_OPTIONS=suppressions=$PWD/tests/tsan.supp:second_deadlock_stack=1 \
  ctest --preset tsan -L threads --no-tests=error

say "all tests, release"
ctest --preset release -j "$jobs" --no-tests=error
