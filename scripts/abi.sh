#!/usr/bin/env bash
# Compares the interfaces of shared libraries, before and after (abidiff of abigail-tools):
#
#   scripts/abi.sh BEFORE AFTER
#
# BEFORE, AFTER: folders with libprocam_*.so. Compiled with -g, types are compared as well, else symbols alone. Prints what
# changed. Exit status 0: programs that were linked before still run; 1: they may not; 2: the comparison failed.
set -euo pipefail
(($# == 2)) || { sed -n '2,6s/^# \?//p' "$0" >&2 && exit 2; }
before=$1 after=$2
command -v abidiff >/dev/null || { echo "abi.sh: abidiff is missing: apt-get install abigail-tools" >&2 && exit 2; }
shopt -s nullglob
libraries=("$before"/libprocam_*.so)
((${#libraries[@]} > 0)) || { echo "abi.sh: no libprocam_*.so in $before" >&2 && exit 2; }

broken=0
for library in "${libraries[@]}"; do
  name=${library##*/}
  if [[ ! -e $after/$name ]]; then
    echo "$name: removed"
    broken=$((broken + 1))
    continue
  fi
  # abidiff's status is a sum: 1 it failed, 2 wrong use, 4 something changed, 8 it is incompatible. Removed functions and
  # changed layouts of types are not always in its 8: added symbols are left out, so that every 4 counts.
  status=0
  abidiff --no-added-syms --no-show-locs "$library" "$after/$name" || status=$?
  if ((status & 3)); then
    echo "abi.sh: abidiff failed on $name (status $status)" >&2 && exit 2
  elif ((status)); then
    echo "$name: changed"
    broken=$((broken + 1))
  fi
done
echo "${#libraries[@]} libraries, $broken with another interface"
((broken == 0))
