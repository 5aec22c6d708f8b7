#!/usr/bin/env bash
# Does to the running show everything that a year on a shared network may bring, for so many minutes (docs/soak.md):
#
#   tests/soak/chaos.sh 30                    every kind of fault, then at random
#   tests/soak/chaos.sh 10 --seed 7           the same faults in the same order again
#   tests/soak/chaos.sh 1 --only "full disk"  one kind
#
# Builds preset ci's project-live and the test. All traffic is on 127.0.0.1. Exit status 0 if nothing failed.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
minutes=${1:?usage: tests/soak/chaos.sh MINUTES [--seed N] [--memory-mib L] [--only STEP] [--log FOLDER]}
shift
cmake --preset ci >/dev/null
cmake --build --preset ci --target chaos project-live >/dev/null
exec build/ci/tests/soak/chaos --minutes "$minutes" "$@"
