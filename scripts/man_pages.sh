#!/usr/bin/env bash
# Writes a manual page for each tool, from its --help (needs help2man):
#
#   scripts/man_pages.sh BIN MAN [LIBRARIES]
#
# BIN: the folder of the installed tools; MAN: the folder to write; LIBRARIES: where their shared libraries are, if they
# would not be found there.
set -euo pipefail
bin=$1 man=$2
[[ -n ${3:-} ]] && export LD_LIBRARY_PATH=$3${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}
mkdir -p "$man"

# One line for the page's title: the tool's first sentence, without its name.
purpose() {
  "$1" --help | tr '\n' ' ' | sed -E 's/^[a-z-]+: *//; s/[.;:] .*//; s/  +/ /g; s/\.$//; s/^./\L&/'
}

# The examples line by line: a filled paragraph would join a comment and the command below it.
keep_lines_of_examples() {
  awk '
    /^\.S[HS]/ && inside { print ".fi"; inside = 0 }
    { print }
    /^\.SS "Try:"/ { inside = 1; print ".nf" }
  ' "$1" >"$1".kept && mv "$1".kept "$1"
}

for tool in "$bin"/*; do
  [[ -f $tool && -x $tool ]] || continue
  name=${tool##*/}
  if [[ $name == procam ]]; then
    title="projector-camera calibration and projection"
  else
    title=$(purpose "$tool")
  fi
  help2man --no-info --name="$title" --output="$man/$name.1" "$tool"
  keep_lines_of_examples "$man/$name.1"
done
