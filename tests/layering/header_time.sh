#!/usr/bin/env bash
# How long g++ takes to include public headers, against <Eigen/Dense> in the same run:
#
#   header_time.sh [--tries N] [--table] INCLUDE HEADER... -- FLAG...
#   header_time.sh [--tries N] [--table] INCLUDE --all -- FLAG...
#
# Each header is the only line of a file, which is compiled (-O2). Processor time of the compiler, the best of N tries (3), so
# that another load on the machine counts little. Limit: 3 times <Eigen/Dense>, which is 2 s where that takes 0.67 s. A header of all of a component (procam/core.hpp) may take 3.5 times as long as <Eigen/Dense>.
# Fails with the headers above their limits; --table prints all.
set -euo pipefail
tries=3 table=false
while [[ ${1:-} == --tries || ${1:-} == --table ]]; do
  if [[ $1 == --tries ]]; then tries=$2 && shift; else table=true; fi
  shift
done
include=$1 && shift
headers=()
while (($#)) && [[ $1 != -- ]]; do headers+=("$1") && shift; done
(($#)) && shift
flags=(-std=c++17 -O2 -I "$include" "$@")
if [[ ${headers[0]} == --all ]]; then
  mapfile -t headers < <(cd "$include" && find procam -name '*.hpp' -not -path '*/detail/*' | sort)
fi
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

# once LINE: milliseconds of user time.
once() {
  local TIMEFORMAT=%U seconds
  echo "$1" >"$scratch"/one.cpp
  seconds=$({ time g++ "${flags[@]}" -c "$scratch"/one.cpp -o "$scratch"/one.o 2>"$scratch"/errors; } 2>&1) ||
    { cat "$scratch"/errors >&2 && return 1; }
  echo $((10#${seconds/./}))
}

# best LINE TRIES ENOUGH: the least of so many tries; no more tries than it takes to be at most ENOUGH.
best() {
  local least=1000000 i t
  for ((i = 0; i < $2 && least > $3; ++i)); do
    t=$(once "$1") || return 1
    if ((t < least)); then least=$t; fi
  done
  echo "$least"
}

too_long=0
reference=$(best "#include <Eigen/Dense>" "$tries" 0)
echo "<Eigen/Dense>: $reference ms"
for header in "${headers[@]}"; do
  limit=$((reference * 3))
  if [[ $header != procam/*/* ]]; then limit=$((reference * 7 / 2)); fi
  t=$(best "#include \"$header\"" "$tries" "$limit") || exit 1
  $table && echo "$t ms, $((100 * t / reference)) %: $header"
  if ((t > limit)); then
    echo "$header: $t ms, above the limit of $limit ms"
    too_long=$((too_long + 1))
  fi
done
echo "${#headers[@]} headers, $too_long too long"
((too_long == 0))
