#!/usr/bin/env bash
# Builds the fuzz targets (preset fuzz) and runs all of them, one after the other:
#
#   tests/fuzz/run.sh 2            two hours for all targets together; the default is one
#   tests/fuzz/run.sh --minute     one minute for all targets together
#   tests/fuzz/run.sh 0.5 osc psn  these targets alone
#
# New inputs are kept in build/fuzz/corpus/TARGET, findings in build/fuzz/findings. Prints executions and covered
# edges of each target, and their sum. Exit status 0 if there was no finding.
set -uo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.." || exit 1

hours=1
[[ ${1:-} == --minute ]] && hours=0.0166667 && shift
[[ ${1:-} =~ ^[0-9]+(\.[0-9]+)?$ ]] && hours=$1 && shift

cmake --preset fuzz && cmake --build --preset fuzz || exit 1
program=build/fuzz/tests/fuzz/procam_fuzz
targets=("$@")
((${#targets[@]} > 0)) || mapfile -t targets < <("$program" --list)
seconds=$(awk -v hours="$hours" -v count="${#targets[@]}" \
  'BEGIN { each = int(hours * 3600 / count); print each > 0 ? each : 1 }')

export ASAN_OPTIONS=allocator_may_return_null=1:handle_abort=2:detect_leaks=1
export UBSAN_OPTIONS=print_stacktrace=1
mkdir -p build/fuzz/findings
total=0 findings=0
printf '%-18s %14s %8s\n' target executions edges
for target in "${targets[@]}"; do
  corpus=build/fuzz/corpus/$target log=build/fuzz/$target.log
  mkdir -p "$corpus"
  inputs=()
  for folder in tests/fuzz/corpus/"$target" tests/fuzz/regressions/"$target"; do
    [[ -d $folder ]] && inputs+=("$folder")
  done
  dictionary=tests/fuzz/dictionaries/$(sed -n "s/^$target //p" tests/fuzz/dictionaries/of_targets.txt).dict
  [[ -f $dictionary ]] && inputs+=("-dict=$dictionary")
  "$program" --target="$target" -max_total_time="$seconds" -timeout=20 -rss_limit_mb=2048 \
    -artifact_prefix=build/fuzz/findings/"$target"- -print_final_stats=1 "$corpus" "${inputs[@]}" >"$log" 2>&1
  status=$?
  count=$(sed -n 's/^stat::number_of_executed_units: *//p' "$log")
  edges=$(sed -n 's/.* cov: \([0-9]*\) .*/\1/p' "$log" | tail -n 1)
  printf '%-18s %14d %8s' "$target" "${count:-0}" "${edges:--}"
  total=$((total + ${count:-0}))
  if ((status != 0)); then
    findings=$((findings + 1))
    printf '  FINDING, see %s' "$log"
  fi
  printf '\n'
done
printf '%-18s %14d\n' all "$total"
echo "$findings targets with a finding"
((findings == 0))
