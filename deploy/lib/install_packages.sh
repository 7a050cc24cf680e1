#!/usr/bin/env bash
# Installs the packages of the named sections of packages.txt that are not there yet: install_packages.sh build test
set -euo pipefail
here=$(cd "$(dirname "$0")/.." && pwd)

wanted=()
for section in "$@"; do
  mapfile -t names < <(awk -v s="[$section]" '/^#/ || !NF {next} /^\[/ {on = ($0 == s); next} on {print $1}' "$here/packages.txt")
  wanted+=("${names[@]}")
done

missing=()
for name in "${wanted[@]}"; do
  [ "$(dpkg-query -W -f '${db:Status-Status}' "$name" 2>/dev/null)" = installed ] || missing+=("$name")
done
[ ${#missing[@]} -gt 0 ] || exit 0

echo "Installing ${#missing[@]} Debian packages: ${missing[*]}"
as_root=()
if [ "$(id -u)" -ne 0 ]; then
  command -v sudo >/dev/null || { echo "Not root, and there is no sudo: install these packages, then start again." >&2; exit 1; }
  as_root=(sudo)
fi
export DEBIAN_FRONTEND=noninteractive
"${as_root[@]}" apt-get update -q=2
"${as_root[@]}" apt-get install -y -q=2 --no-install-recommends "${missing[@]}" >/dev/null
