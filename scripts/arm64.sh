#!/usr/bin/env bash
# Builds procam for arm64 with Debian's arm64 packages, and tests it under qemu-user:
#
#   scripts/arm64.sh            components core, pattern, render, depth, track and calibrate
#   scripts/arm64.sh TEST...    these alone (core render): the names of ctest before the point
#
# The packages are extracted into build/arm64-sysroot (1.4 GB) at the first run; this machine's own packages stay as they
# are. Emulation takes 10 to 30 times the time. Ends with an error if a test fails.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source scripts/common.sh

tests=("$@")
((${#tests[@]} > 0)) || tests=(core pattern render depth track track_wire calibrate)
sysroot=$PWD/build/arm64-sysroot

# Packages are extracted, not configured. The links that Debian's alternatives make to BLAS and LAPACK are made here, and
# absolute links, which would lead to this machine's files, become relative.
make_sysroot() {
  [[ -e $sysroot/complete ]] && return 0
  rm -rf "$sysroot" && mkdir -p build || return 1
  local list
  list=$(IFS=, && echo "${arm64_libraries[*]}")
  mmdebstrap --quiet --variant=extract --architectures=arm64 --include="$list" bookworm "$sysroot" || return 1
  local folder=$sysroot/usr/lib/aarch64-linux-gnu library
  for library in "$folder"/{blas,lapack}/*.so*; do
    ln -sf "$(realpath --relative-to="$folder" "$library")" "$folder"/"${library##*/}" || return 1
  done
  local link target
  while read -r link target; do
    ln -sf "$(realpath -m --relative-to="${link%/*}" "$sysroot$target")" "$link" || return 1
  done < <(find "$sysroot"/usr "$sysroot"/lib -lname '/*' -printf '%p %l\n')
  # Ceres' CMake file names these libraries by the path on the machine where they are installed.
  sed -i "s|;/usr/lib/|;$sysroot/usr/lib/|g" "$folder"/cmake/Ceres/CeresTargets.cmake || return 1
  touch "$sysroot"/complete
}

build() {
  cmake --preset arm64 && cmake --build --preset arm64 --target "${tests[@]/#/test_}"
}

# Tests labelled long, as a filter of GoogleTest: "a.B.C/value" of ctest is "B.C/0" there.
long_ones() {
  ctest --preset arm64 -N -L long -R "^$1\." | sed -nE "s/^ *Test +#[0-9]+: $1\.//p" | sed -E 's/^([^.]*\.[^/]*).*/\1*/' |
    sort -u | paste -sd :
}

# A whole test program in as many runs of the emulator as there are cores: it needs two seconds to start one, and shares
# its threads' work badly.
run_test_program() {
  local program shards index status=0 runs=() logs=()
  program=$(find build/arm64/tests -type f -name "test_$1")
  shards=$(nproc)
  for ((index = 0; index < shards; ++index)); do
    logs+=("build/arm64/test_$1.$index.log")
    GTEST_TOTAL_SHARDS=$shards GTEST_SHARD_INDEX=$index qemu-aarch64-static -L "$sysroot" "$program" \
      "--gtest_filter=-$(long_ones "$1")" >"${logs[-1]}" 2>&1 &
    runs+=($!)
  done
  for index in "${!runs[@]}"; do
    if ! wait "${runs[index]}"; then
      tail -n 40 "${logs[index]}"
      status=1
    fi
  done
  echo "$1: $(awk '/^\[  (PASSED|SKIPPED) +\] [0-9]+ test/ { counts[$2] += $4 }
    END { printf "%d passed, %d skipped", counts["PASSED"], counts["SKIPPED"] }' "${logs[@]}")"
  ((status == 0)) || echo "$1: FAILED"
  return "$status"
}

run_tests() {
  local name status=0
  for name in "${tests[@]}"; do
    run_test_program "$name" || status=1
  done
  return "$status"
}

phase "Packages" install_packages "${arm64_packages[@]}"
phase "Sysroot: Debian's arm64 packages" make_sysroot
phase "Build: arm64" build
phase "Test: arm64, under qemu-user" run_tests
