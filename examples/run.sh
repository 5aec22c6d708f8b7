#!/usr/bin/env bash
# See procam work, from nothing on Debian 12 and without any hardware:   examples/run.sh [OUT]
# Installs missing packages, builds what that takes, simulates the captures of an office projector, calibrates it, solves two
# surfaces, renders the projector's frame, drives past a wall, corrects a bump, refreshes the rig, follows a cart, calibrates a
# mount on a robot, an arm and a head, and prints the true error in millimetres. Pictures, videos and reports: OUT (out/).
# PROCAM_PRESET names another configure preset to build and use (quick, which is release by Clang).
set -euo pipefail
mkdir -p "${1:-$(dirname "${BASH_SOURCE[0]}")/../out}"
out=$(cd "${1:-$(dirname "${BASH_SOURCE[0]}")/../out}" && pwd)
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source scripts/common.sh
preset=${PROCAM_PRESET:-quick}
build=$PWD/build/$preset
tools=$build/tools
jobs=$(nproc)

build() {
  cmake --preset "$preset" && cmake --build --preset "$preset" -j "$jobs" --target \
    simulate-captures calibrate-projector solve-surfaces render-to-image export-warp export-camera section_v \
    example_03_true_error example_04_drive example_07_watch example_08_cart example_09_mount example_10_robot example_12_update example_13_arm_and_head
}

simulate() {
  "$tools/simulate-captures" --seed 7 --level paper -o "$out/session" --force
}

calibrate() {
  "$tools/calibrate-projector" --captures "$out/session" --pattern gray --projector-size 1024x768 \
    --board chessboard:9x6:36mm -o "$out/rig.json" --report "$out/report.html"
}

solve() {
  "$tools/solve-surfaces" --rig "$out/rig.json" --surfaces examples/data/surfaces.json -o "$out/solved.json"
}

render() {
  "$tools/render-to-image" --rig "$out/rig.json" --surfaces "$out/solved.json" \
    --content wall=examples/data/test_card.png --content poster=examples/data/test_card.png \
    -o "$out/frame.png" --preview "$out/view.png"
}

judge() {
  "$build/examples/example_03_true_error" "$out/session/truth.json" "$out/rig.json"
}

drive() {
  "$build/examples/example_04_drive" "$out/session/truth.json" "$out/rig.json" examples/data/test_card.png \
    "$out/drive.mp4" "$out/drive.png"
}

# Each takes a core; side by side they take half the time. Their words in order, when all have ended.
correct() {
  local card=examples/data/test_card.png words status=0 pids=()
  words=$(mktemp -d)
  "$build/examples/example_07_watch" "$card" "$out" >"$words/1" 2>&1 & pids+=($!)
  "$build/examples/example_07_watch" --marks "$out" >"$words/2" 2>&1 & pids+=($!)
  "$build/examples/example_08_cart" "$card" "$out" >"$words/3" 2>&1 & pids+=($!)
  "$build/examples/example_09_mount" "$card" "$out" >"$words/4" 2>&1 & pids+=($!)
  "$build/examples/example_10_robot" "$card" "$out" >"$words/5" 2>&1 & pids+=($!)
  "$build/examples/example_13_arm_and_head" "$card" "$out" >"$words/6" 2>&1 & pids+=($!)
  for pid in "${pids[@]}"; do wait "$pid" || status=$?; done
  cat "$words"/* && rm -r "$words"
  return "$status"
}

refresh() {
  "$tools/simulate-captures" --seed 7 --level paper --views 1 --bump 0.3deg -o "$out/after" --force
  "$tools/calibrate-projector" --captures "$out/after" --pattern gray --projector-size 1024x768 \
    --board chessboard:9x6:36mm --update "$out/rig.json" --changed pose -o "$out/fresh.json"
  "$build/examples/example_12_update" "$out/session/truth.json" "$out/after/truth.json" "$out/rig.json" \
    "$out/fresh.json" examples/data/test_card.png "$out"
}

evaluate() {
  "$build/examples/section_v/section_v" --rig "$out/rig.json" --truth "$out/session/truth.json" \
    --report "$out/evaluation.html"
}

exchange() {
  "$tools/export-warp" --rig "$out/rig.json" --surfaces "$out/solved.json" --surface wall -o "$out/wall_warp.png"
  "$tools/export-camera" --rig "$out/rig.json" --for blender -o "$out/blender_camera.py"
}

phase "Packages" install_packages "${build_packages[@]}"
phase "Build" build
phase "Simulate a capture session" simulate
phase "Calibrate camera and projector" calibrate
phase "Solve the surfaces" solve
phase "Render the projector's frame" render
phase "Export the warp and the camera for other programs" exchange
phase "Compare with the truth" judge
phase "Drive past a wall" drive
phase "Bump a projector, follow a cart, mount a rig on a robot, an arm and a head" correct
phase "Refresh the rig by one view after a bump" refresh
phase "Project a sheet's corners on the sheet" evaluate

cat <<END

In $out:
  report.html  the calibration, one self-contained page
  evaluation.html  where the corners of a sheet land, at 47 and 60 degrees
  frame.png    what the projector shows
  view.png     how it looks in the room
  drive.mp4    a robot drives past a wall: drawn for the newest pose, and for the moment of light
  watch.mp4    a projector is bumped: alone, and corrected by its camera
  cart.mp4     a cart moves: its picture where it was seen, and where it is
  marks.mp4    the same before a plain colour, by small marks
  mount.mp4    a robot before a wall: the rig's place on it by ruler, and calibrated by a drive
  arm.mp4, head.mp4  the same of a rig on an arm and on a pan-tilt head
  robot.mp4    a robot before a wall: by its localiser, and corrected by its camera
  update.mp4   a projector is bumped: with its old calibration, and refreshed by one view of the board
  watch_error.svg, ..., update_error.svg  the true error over time of each
  wall_warp.png, blender_camera.py  the same for programs that draw for themselves
  rig.json, solved.json, session/  the calibrated rig, the solved surfaces, the captures with their truth
All of it took $SECONDS s.

The tools that made it are in $tools; README.md says how to install all of them.
Next: open report.html. With a projector, docs/mapping.md leads to a first picture by hand, docs/capture.md to a
calibration.
END
