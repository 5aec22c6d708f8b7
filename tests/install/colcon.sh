#!/bin/sh
# colcon.sh PROCAM CONSUMER WORKSPACE CXX: builds a workspace of colcon, ROS' build tool, with procam (core alone) and a
# package that depends on it, and runs that package's program. procam is built first because package.xml names it.
set -eu
procam=$1 consumer=$2 workspace=$3 cxx=$4
rm -rf "$workspace" && mkdir -p "$workspace" && cd "$workspace"
colcon --log-base log build --base-paths "$consumer" "$procam" --event-handlers console_direct+ \
  --cmake-args -DCMAKE_BUILD_TYPE=Debug -DCMAKE_UNITY_BUILD=ON -DCMAKE_CXX_COMPILER="$cxx" -DPROCAM_CORE_ONLY=ON -DPROCAM_BUILD_TESTS=OFF \
  -DPROCAM_BUILD_EXAMPLES=OFF
test -f install/procam/share/procam/package.xml
build/consumer/consumer
