#!/usr/bin/env bash
# scripts/abi.sh on small builds of one library: it accepts an addition, and finds a removed function, a struct that grew, and
# a removed library.   interfaces.sh ROOT CXX
set -euo pipefail
root=$1 cxx=$2
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

build() {  # FOLDER: source from stdin
  mkdir -p "$scratch/$1"
  cat >"$scratch/$1"/toy.cpp
  "$cxx" -std=c++17 -g -shared -fPIC -o "$scratch/$1"/libprocam_toy.so "$scratch/$1"/toy.cpp
}
expect() {  # STATUS TEXT FOLDER
  local status=0
  "$root"/scripts/abi.sh "$scratch"/before "$scratch/$3" >"$scratch"/said 2>&1 || status=$?
  if ((status != $1)) || ! grep -q -- "$2" "$scratch"/said; then
    echo "FAILED: $3: status $status, not $1, or no word of '$2'"
    cat "$scratch"/said
    exit 1
  fi
}

options='struct Options { int views = 1; double sigma = 0.5; };'
solve='double solve(const Options& o) { return o.views * o.sigma; }'
locate='double locate(const Options& o) { return o.sigma; }'
build before <<<"$options $solve $locate"
build same <<<"$options $solve $locate"
build more <<<"$options $solve $locate double verify(const Options& o) { return o.views; }"
build removed <<<"$options $solve"
build grown <<<"struct Options { int views = 1; double sigma = 0.5; double weight = 1; }; $solve $locate"
mkdir "$scratch"/none
expect 0 "0 with another interface" same
expect 0 "0 with another interface" more
expect 1 "locate" removed
expect 1 "weight" grown
expect 1 "libprocam_toy.so: removed" none
echo "passed"
