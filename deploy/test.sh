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

say "release build, each header alone"
cmake --preset release >/dev/null
cmake --build --preset release -j "$jobs" --target all headers_stand_alone

say "address and undefined-behaviour sanitizers"
cmake --preset asan >/dev/null
cmake --build --preset asan -j "$jobs"
# Leaks are looked for in our own code; what Mesa and DDS keep until the end of the process is left out.
LSAN_OPTIONS=suppressions=$PWD/tests/lsan.supp:print_suppressions=0 \
  ctest --preset asan -j "$jobs" -L 'unit|sanitize' --no-tests=error

say "thread sanitizer"
cmake --preset tsan >/dev/null
cmake --build --preset tsan -j "$jobs" --target thread_tests
TSAN_OPTIONS=suppressions=$PWD/tests/tsan.supp:second_deadlock_stack=1 \
  ctest --preset tsan -L threads --no-tests=error

say "fuzzers, a few seconds each"
CC=clang CXX=clang++ cmake -S . -B build/fuzz -G Ninja -DCMAKE_BUILD_TYPE=RelWithDebInfo -DMESHLOOP_FUZZ=ON >/dev/null
cmake --build build/fuzz -j "$jobs" --target fuzzers
ctest --test-dir build/fuzz -L fuzz --output-on-failure --no-tests=error

say "all tests, release"
ctest --preset release -j "$jobs" --no-tests=error
