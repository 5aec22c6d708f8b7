#!/usr/bin/env bash
# clang-tidy over the libraries' sources, as preset ci compiles them, several in one (build/ci has to be configured):
#
#   scripts/tidy.sh          what has files, sockets, threads and devices: tests/run.sh
#   scripts/tidy.sh --all    the mathematics as well, which takes twice the time: scripts/release.sh
#
# Half of a file's time is parsing Eigen. Not the Python bindings: they are declarations, and take minutes to parse.
set -uo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.." || exit 1
omitted=python
[[ ${1:-} == --all ]] || omitted+='|core|pattern|detect|surface|calibrate|scan|room|depth|analyze|simulate'
sed -n 's/^ *"file": "\(.*\)".*/\1/p' build/ci/compile_commands.json | grep -E "^$PWD/(build/ci/)?src/" |
  grep -vE "/src/($omitted)/" | sort | xargs -P "$(nproc)" -n 1 clang-tidy -p build/ci --quiet
