#!/usr/bin/env bash
# Everything that procam promises, tested from nothing on Debian 12:   tests/run.sh
# Installs missing packages, checks style and sources, builds and tests three presets (ci: everything; core-only: Eigen
# alone, under sanitizers; asan: what reads files and the fuzz targets over their kept inputs, under sanitizers), walks the main
# job (examples/run.sh), does five minutes of faults to running shows beside that, and ends with "N passed, N failed". The
# tests labelled "long" are left to `ctest --preset ci -L long`, fuzzing to tests/fuzz/run.sh.
# Exit status 0 if nothing failed.
set -uo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.." || exit 1
source scripts/common.sh
jobs=$(nproc)
# As the tools do for themselves (tools/common/cli.cpp): memory that is freed stays with the process. Half of the CPU time of
# tests with many images.
export MALLOC_TRIM_THRESHOLD_=2147483647 MALLOC_MMAP_THRESHOLD_=33554432 MALLOC_TOP_PAD_=16777216
passed=0 failed=0 skipped=0

# A phase that is no test run counts only when it fails.
step() {
  phase "$@" || { failed=$((failed + 1)); return 1; }
}

configure_and_build() {
  cmake --preset "$1" && cmake --build --preset "$1" -j "$jobs"
}

# Of ctest's report, "passed failed skipped": tests of GoogleTest by the sums at their programs' end, as an entry may run many.
count_tests() {
  awk '
    /<testcase / { status = $0; sub(/.* status="/, "", status); sub(/".*/, "", status); own_failed = ran = 0 }
    /^\[  PASSED  \] [0-9]+ test/ { passed += $4; ran = 1 }
    /^\[  SKIPPED \] [0-9]+ test/ { skipped += $4; ran = 1 }
    /^\[  FAILED  \] [0-9]+ test/ { failed += $4; ran = own_failed = 1 }
    /<\/testcase>/ {
      if (status == "fail") failed += !own_failed
      else if (!ran) { if (status == "run") ++passed; else ++skipped }
    }
    END { print passed + 0, failed + 0, skipped + 0 }' "$1"
}

# Adds a preset's tests to the sums.
run_ctest() {
  local report=$PWD/build/$1/ctest.xml sums
  rm -f "$report"
  # Two more than there are cores: the long shows at the begin wait more than they work.
  ctest --preset "$1" -j "$((jobs + 2))" -LE long --output-junit "$report" --test-output-truncation head
  local status=$?
  if [[ ! -s $report ]]; then
    failed=$((failed + 1))
    return 1
  fi
  read -r -a sums < <(count_tests "$report")
  passed=$((passed + sums[0]))
  failed=$((failed + sums[1]))
  skipped=$((skipped + sums[2]))
  return "$status"
}

build_and_test() {
  step "Build: $2" configure_and_build "$1" && phase "Test: $2" run_ctest "$1"
}

check_format() {
  find include src tools tests examples -name '*.hpp' -o -name '*.cpp' | sort | xargs clang-format --dry-run --Werror
}

# Faults at random to running shows. All that follows is begun at a lower priority, so that the shows have their frames;
# still, how many are dropped is judged on a quiet machine alone (docs/soak.md).
begin_chaos() {
  build/ci/tests/soak/chaos --minutes 5 --seed 20 --dropped 0.3 >build/ci/chaos.log 2>&1 &
  chaos=$!
  renice -n 10 $$ >/dev/null
}

end_chaos() {
  local status=0
  wait "$chaos" || status=$?
  if ((status == 0)); then passed=$((passed + 1)); tail -n 20 build/ci/chaos.log; else cat build/ci/chaos.log; fi
  return "$status"
}

step "Packages" install_packages "${build_packages[@]}" "${test_packages[@]}" "${fuzz_packages[@]}" || { echo "$passed passed, $failed failed"; exit 1; }
step "Style: clang-format" check_format
build_and_test ci "everything, optimised"
begin_chaos
step "Style: clang-tidy" scripts/tidy.sh
step "The main job: examples/run.sh" env PROCAM_PRESET=ci examples/run.sh build/ci/out
build_and_test core-only "core alone, without OpenCV and Ceres, under sanitizers"
build_and_test asan "what reads files, under sanitizers"
step "Soak: five minutes of faults, beside the phases above" end_chaos

printf '\nAll phases: %d s\n' "$SECONDS"
if ((skipped > 0)); then
  echo "$skipped skipped (they say why above; real captures are looked for in PROCAM_TEST_DATA)"
fi
echo "$passed passed, $failed failed"
# What scripts/release.sh asks for: this tree has passed.
rm -f build/tests_passed
if ((failed == 0)) && [[ -z "$(git status --porcelain 2>&1)" ]]; then git rev-parse 'HEAD^{tree}' >build/tests_passed; fi
((failed == 0))
