#!/usr/bin/env bash
# Builds the fuzz targets (preset asan) and runs all of them:
#
#   tests/fuzz/run.sh 2            two hours for all targets together; the default is one
#   tests/fuzz/run.sh 0.5 osc psn  these targets alone
#
# JOBS=4: so many targets at a time; the default is one. New inputs are kept in build/fuzz/corpus/TARGET, findings in
# build/fuzz/findings, what libFuzzer says in build/fuzz/TARGET.log. Prints executions, covered edges and features
# (edges by how often they were passed) of each target, and the sum. Exit status 0 if there was no finding.
set -uo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.." || exit 1
source scripts/common.sh

hours=1 jobs=${JOBS:-1}
[[ ${1:-} =~ ^[0-9]+(\.[0-9]+)?$ ]] && hours=$1 && shift

install_packages "${build_packages[@]}" "${fuzz_packages[@]}" || exit 1
cmake --preset asan && cmake --build --preset asan --target procam_fuzz || exit 1
program=build/asan/tests/fuzz/procam_fuzz
targets=("$@")
((${#targets[@]} > 0)) || mapfile -t targets < <("$program" --list)
seconds=$(awk -v hours="$hours" -v count="${#targets[@]}" -v jobs="$jobs" \
  'BEGIN { each = int(hours * 3600 * jobs / count); print (each > 0 ? each : 1) }')

export ASAN_OPTIONS=allocator_may_return_null=1:handle_abort=2:detect_leaks=1
export UBSAN_OPTIONS=print_stacktrace=1

# Runs a target; its log ends with a line of the exit status.
run_target() {
  local target=$1 corpus=build/fuzz/corpus/$1 inputs=() folder dictionary
  mkdir -p "$corpus" build/fuzz/findings
  for folder in tests/fuzz/corpus/"$target" tests/fuzz/regressions/"$target"; do
    [[ -d $folder ]] && inputs+=("$folder")
  done
  dictionary=tests/fuzz/dictionaries/$(sed -n "s/^$target //p" tests/fuzz/dictionaries/of_targets.txt).dict
  [[ -f $dictionary ]] && inputs+=("-dict=$dictionary")
  # Unoptimised and under sanitizers, large scenes take up to a minute (replay, vector_widths), and so do OpenGL's shaders
  # without a card on a busy machine.
  "$program" --target="$target" -max_total_time="$seconds" -timeout=120 -rss_limit_mb=2048 -len_control=100 \
    -artifact_prefix=build/fuzz/findings/"$target"- -print_final_stats=1 "$corpus" "${inputs[@]}" \
    >build/fuzz/"$target".log 2>&1
  echo "exit status $?" >>build/fuzz/"$target".log
}

# Each target is a process group of its own, so that Ctrl-C ends them all.
set -m
trap 'for group in $(jobs -p); do kill -- "-$group"; done 2>/dev/null' EXIT
for target in "${targets[@]}"; do
  while (($(jobs -rp | wc -l) >= jobs)); do wait -n; done
  run_target "$target" &
done
wait

total=0 findings=0 found=()
printf '%-18s %14s %8s %8s\n' target executions edges features
for target in "${targets[@]}"; do
  log=build/fuzz/$target.log
  count=$(sed -n 's/^stat::number_of_executed_units: *//p' "$log")
  edges=$(sed -n 's/.* cov: \([0-9]*\) .*/\1/p' "$log" | tail -n 1)
  features=$(sed -n 's/.* ft: \([0-9]*\) .*/\1/p' "$log" | tail -n 1)
  printf '%-18s %14d %8s %8s' "$target" "${count:-0}" "${edges:--}" "${features:--}"
  total=$((total + ${count:-0}))
  if ! grep -q '^exit status 0$' "$log"; then
    findings=$((findings + 1))
    printf '  FINDING, see %s' "$log"
    found+=("$log")
  fi
  printf '\n'
done
# A machine that is gone afterwards must have told the finding: the report, and the input as Base64.
for log in "${found[@]}"; do
  printf -- '-- %s\n' "$log"
  grep -nE 'runtime error|ERROR: |SUMMARY|^ *#[0-9]+ .*/(src|include|tests)/|Base64|exit status' "$log" | cut -c1-400 | head -n 30
done
printf '%-18s %14d\n' all "$total"
echo "$findings targets with a finding"
((findings == 0))
