#!/usr/bin/env bash
# The main job, without any hardware: a capture station adapts a model to what it sees, a handheld device draws with it.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
root=$(dirname "$here")

usage() {
  cat <<TXT
usage: deploy/demo.sh [--out DIR] [--noise N] [--seed N] [--real]
  --out DIR    where everything goes (default: out); its former content is replaced
  --noise N    sensor noise: 1 a Kinect's (default), 0 none, at most 10
  --seed N     seed of the simulation, at most 999999999 (default: 1)
  --real       real images (RealSense sequence of Debian's visp-images-data) instead of the simulator
Installs the Debian packages it needs, builds, runs, and ends with DIR/report.html and DIR/report.json.
TXT
}

# wrong WHAT: the command line is not right.
wrong() { printf 'demo: %s (try --help)\n' "$1" >&2; exit 2; }

out=out noise=1 seed=1 real=no
while [ $# -gt 0 ]; do
  case "$1" in
    --out | --noise | --seed)
      [ $# -ge 2 ] && [ -n "$2" ] || wrong "$1 needs a value"
      printf -v "${1#--}" %s "$2"
      shift 2 ;;
    --real) real=yes; shift ;;
    -h | --help) usage; exit 0 ;;
    *) wrong "there is no option '$1'" ;;
  esac
done

. "$here/lib/demo_steps.sh"
[[ $noise =~ ^([0-9](\.[0-9]+)?|10(\.0+)?)$ ]] || wrong "--noise is a number from 0 to 10, not '$noise'"
[[ $seed =~ ^[0-9]{1,9}$ ]] || wrong "--seed is a whole number from 0 to 999999999, not '$seed'"
check_out "$out"

if [ "$real" = yes ]; then "$here/lib/install_packages.sh" build real; else "$here/lib/install_packages.sh" build; fi
build_programs
prepare_out "$out"
started=$SECONDS
if [ "$real" = yes ]; then make_real_data; else make_simulated_data; fi
run_loop
if [ "$real" = yes ]; then measure_real; else measure_simulated; fi
python3 "$here/lib/report.py" "$out"
say "done in $((SECONDS - started)) s: open $out/report.html"
