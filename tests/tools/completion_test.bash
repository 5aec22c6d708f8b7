#!/usr/bin/env bash
# completion_test.bash TOOLS: asks tools/completion/procam.bash what it would complete.
set -u
tools=$1
source "$tools/completion/procam.bash" || exit 1
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cd "$scratch" && touch rig.json "two words.json" && mkdir captures || exit 1
failed=0

# expect NAME FOUND WORD...: FOUND is among the completions of the last word; with "-FOUND" it is not.
expect() {
  local name=$1 wanted=$2 found
  shift 2
  COMP_WORDS=("$@") COMP_CWORD=$(($# - 1))
  _procam
  found=$(printf '%s\n' "${COMPREPLY[@]}" | grep -cxF -e "${wanted#!}")
  if [[ $wanted == !* && $found -gt 0 ]] || [[ $wanted != !* && $found -ne 1 ]]; then
    echo "$name: '${wanted}' expected, got: ${COMPREPLY[*]}"
    failed=1
  fi
}

expect "a tool's name" calibrate-projector "$tools/procam" cal
expect "no other tool" '!make-board' "$tools/procam" cal
expect "an option" --holdout "$tools/calibrate-projector" --hol
expect "an option with a short form" --output "$tools/calibrate-projector" --out
expect "an option by procam" --holdout "$tools/procam" calibrate-projector --hol
expect "an option of a general word" --simulate "$tools/procam" studio --sim
expect "a choice" free "$tools/calibrate-projector" --board-shape f
expect "a format" kalibr "$tools/procam" convert --format ka
expect "a program" unreal "$tools/export-camera" --for unr
expect "a level" paper "$tools/simulate-captures" --level p
expect "no other choice" '!flat' "$tools/calibrate-projector" --board-shape fr
expect "a choice after an equals sign" free "$tools/calibrate-projector" --board-shape = f
expect "a file" rig.json "$tools/solve-surfaces" --rig r
expect "a file with a space" "two words.json" "$tools/solve-surfaces" --rig t
expect "a file after the short form" rig.json "$tools/solve-surfaces" -o ri
expect "a folder" captures "$tools/calibrate-projector" --captures cap
expect "all options" --rig "$tools/solve-surfaces" ""
expect "nothing after a wrong tool" '!--rig' "$tools/procam" no-such-tool --r
for tool in "$tools"/completion/*; do
  [[ -L $tool && $(readlink "$tool") != procam ]] && echo "$tool: not a link to procam" && failed=1
done
exit $failed
