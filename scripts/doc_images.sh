#!/usr/bin/env bash
# Makes the pictures of the documents that the tools can draw, from simulated sessions:   scripts/doc_images.sh [BUILD]
# BUILD: a build folder with the tools (build/release). Needs Chromium to put several pictures side by side. Look at each
# picture before it is committed.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
tools=$PWD/${1:-build/release}/tools images=$PWD/docs/images data=$PWD/examples/data
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cd "$scratch"
PATH=$tools:$PATH

# side_by_side NAME WIDTH HEIGHT CELL_WIDTH CELL_HEIGHT FIT  FILE CAPTION ...: pictures in a grid with captions.
side_by_side() {
  local name=$1 width=$2 height=$3 cell=$4 cell_height=$5 fit=$6
  shift 6
  {
    echo "<style>body{margin:0;padding:10px;background:#fff;font:15px sans-serif;color:#222;display:flex;flex-wrap:wrap;gap:14px}
      figure{margin:0;width:${cell}px}img{width:${cell}px;height:${cell_height}px;object-fit:${fit};border:1px solid #bbb;
      box-sizing:border-box;background:#fff;image-rendering:pixelated}figcaption{padding-top:4px}</style>"
    while (($# > 0)); do
      echo "<figure><img src=\"$1\"><figcaption>$2</figcaption></figure>"
      shift 2
    done
  } >page.html
  chromium --headless --no-sandbox --disable-gpu --hide-scrollbars --window-size="$width,$height" \
    --screenshot="$images/$name" "file://$PWD/page.html" >/dev/null 2>&1
}

boards() {
  make-board --board charuco:5x7:34mm:25mm:5x5_100 -o charuco.svg
  make-board --board chessboard:8x5:22mm -o chessboard.svg
  make-board --board markers:4x5:40mm:9mm:4x4_50 -o markers.svg
  make-board --board circles:4x11:20mm:14mm -o circles.svg
  side_by_side boards.png 1010 410 235 345 contain charuco.svg "ChArUco: the default" chessboard.svg "chessboard" \
    markers.svg "marker grid" circles.svg "circle grid"
}

patterns() {
  local size=(--projector-size 1024x768 --board chessboard:7x9:75mm)
  for pattern in gray phase chessboard charuco markers circles; do
    make-patterns --pattern "$pattern" "${size[@]}" -o "$pattern"
  done
  side_by_side patterns.png 1010 560 320 240 cover gray/show_08.png "gray: stripes, one frame a bit" \
    phase/show_20.png "phase: cosine waves" chessboard/show_01.png "chessboard" charuco/show_01.png "charuco" \
    markers/show_01.png "markers" circles/show_01.png "circles"
}

calibration() {
  simulate-captures --seed 7 --level paper --board charuco:5x7:34mm:25mm:5x5_100 -o session
  calibrate-projector --captures session -o rig.json --figures figures
  cp figures/the_rig_and_the_boards_in_space.svg "$images/calibration_scene.svg"
  cp figures/residual_vectors_of_projector.svg "$images/calibration_residuals.svg"
  cp figures/coverage_of_projector.svg "$images/calibration_coverage.svg"
  side_by_side capture.png 1010 560 320 240 cover session/view_00/frame_40.png "pose 0: white" \
    session/view_00/frame_09.png "stripes of 64 pixels" session/view_00/frame_17.png "stripes of 4 pixels" \
    session/view_03/frame_40.png "pose 3" session/view_05/frame_40.png "pose 5" session/view_06/frame_40.png "pose 6"
}

error() {
  predict-error --rig rig.json --surfaces "$data/surfaces.json" --pose-sigma 10mm,0.5deg --map-sigma 5mm --figures errors
  cp errors/error_over_wall_*.svg "$images/error_map.svg"
}

locate() {
  simulate-captures --seed 7 --level paper --views 1 --marker-view -o markers_seen
  locate-projector --rig markers_seen/truth.json --image markers_seen/marker_view.png \
    --markers markers_seen/markers.json -o pose.json --preview seen.png
  side_by_side locate.png 660 560 640 480 cover seen.png "detected markers (green), as the pose predicts them (red), axes of the world"
}

verify() {
  simulate-captures --seed 7 --level paper --views 1 --check-board charuco --bump 0.2deg -o bumped
  verify-projection --rig bumped/truth.json --surfaces bumped/check/surfaces.json --captures bumped/check \
    --correct projector -o corrected.json --preview "$images/verify.svg" || (($? == 5))
}

photographs() {
  simulate-captures --seed 7 --level paper --pattern chessboard --views 2 -o photographs
  side_by_side photographs.png 1010 410 480 360 cover photographs/view_00/frame_01.png "print and projected board" \
    photographs/view_01/frame_01.png "another position of the sheet"
}

matching() {
  simulate-captures --seed 7 --level paper --views 1 -o stripes
  PYTHONPATH=$tools/../src/python/package "$images/../../scripts/doc_matching.py" stripes "$images/matching.png"
}

exchange() {
  simulate-captures --seed 7 --level paper --views 1 -o exchange
  solve-surfaces --rig exchange/truth.json --surfaces "$data/surfaces.json" -o solved.json
  export-warp --rig exchange/truth.json --surfaces solved.json --surface wall -o warp.png
  render-to-image --rig exchange/truth.json --surfaces solved.json --content wall="$data/test_card.png" -o warped.png
  side_by_side warp.png 1010 300 320 240 contain "$data/test_card.png" "the content" warp.png "ST map of the surface" \
    warped.png "what the other program draws through it"
}

exposure() {
  simulate-captures --seed 7 --level paper --views 1 --pattern chessboard -o exposure
  "$images/../../scripts/doc_exposure.py" exposure/view_00/frame_01.png "$images/exposure.png"
}

drive() {
  simulate-captures --seed 7 --level paper --pattern chessboard -o drive
  calibrate-projector --captures drive -o drive.json
  "$tools/../examples/example_04_drive" drive/truth.json drive.json "$data/test_card.png" drive.avi "$images/drive.png"
  "$images/../../scripts/doc_gif.py" drive.avi "$images/drive.gif" 1 5.5 4 760
}

demonstrations() {
  local examples=$tools/../examples
  "$examples/example_07_watch" "$data/test_card.png" .
  "$examples/example_07_watch" --marks .
  "$examples/example_07_watch" --watch-only "$data/test_card.png" .
  "$examples/example_08_cart" "$data/test_card.png" .
  "$examples/example_09_mount" "$data/test_card.png" .
  "$examples/example_10_robot" "$data/test_card.png" .
  "$examples/example_13_arm_and_head" "$data/test_card.png" .
  simulate-captures --seed 7 -o before
  calibrate-projector --captures before -o before.json
  simulate-captures --seed 7 --views 1 --bump 0.3deg -o after
  calibrate-projector --captures after --update before.json --changed pose -o fresh.json
  "$examples/example_12_update" before/truth.json after/truth.json before.json fresh.json "$data/test_card.png" .
  cp watch_error.svg "$images/watch_error.svg"
  cp cart_error.svg "$images/tracked_error.svg"
  cp mount_error.svg "$images/mount_error.svg"
  cp robot_error.svg "$images/robot_error.svg"
  cp watch.png "$images/watch_corrected.png"
  cp cart.png "$images/tracked_cart.png"
  cp mount.png "$images/mount_wall.png"
  cp robot.png "$images/robot_corrected.png"
  cp marks.png "$images/marks_corrected.png"
  cp arm.png "$images/arm_wall.png"
  cp head.png "$images/head_wall.png"
  cp update.png "$images/update_corrected.png"
  cp marks_error.svg watch_only_error.svg arm_error.svg head_error.svg update_error.svg "$images"
}

# Needs the Python package and PIL.
front() {
  (cd "$images/../.." && PYTHONPATH=$tools/../src/python/package scripts/doc_room.py "$images/undistorted.png")
}

for picture in front boards patterns calibration error locate verify photographs matching exchange exposure drive demonstrations; do
  echo "$picture"
  "$picture" >/dev/null
done
ls -l "$images"
