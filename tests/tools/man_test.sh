#!/usr/bin/env bash
# man_test.sh SCRIPT TOOLS: manual pages by scripts/man_pages.sh, as a reader sees them.
set -u
script=$1 tools=$2
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
mkdir "$scratch"/bin || exit 1
for tool in procam-convert make-board; do ln -s "$(readlink -f "$tools/$tool")" "$scratch/bin/$tool" || exit 1; done
bash "$script" "$scratch"/bin "$scratch"/man || exit 1
failed=0

# expect PAGE LINE: the page has this line, by itself.
expect() {
  groff -man -Tutf8 -P-cbou -rLL=200n "$scratch/man/$1.1" 2>"$scratch"/warnings | sed 's/^ *//' >"$scratch"/text
  if [[ -s $scratch/warnings ]]; then cat "$scratch"/warnings && failed=1; fi
  grep -qxF -e "$2" "$scratch"/text || { echo "$1: no line '$2'" && cat "$scratch"/text && failed=1; }
}

expect procam-convert "procam-convert - converts calibrations between procam and other programs"
# Examples are copied line by line: a comment must not swallow the command.
expect procam-convert "# another program's calibration as a rig"
expect procam-convert "procam convert camchain.yaml --format procam -o rig.json"
expect procam-convert "OPTIONS"
expect make-board "OPTIONS"
exit $failed
