#include "common/examples.hpp"

#include <map>

namespace procam::tools {
namespace {

struct Row {
  const char* tool;
  const char* purpose;
  const char* command;
};

/// The examples of a tool stand together, the most usual first.
constexpr Row kRows[] = {
    {"align-maps", "surfaces with the same names in both maps",
     "align-maps --into room_a.json --map room_b.json -o alignment.json --write-moved room_b_in_a.json"},
    {"align-maps", "surfaces and markers, the surfaces known to 10 mm and half a degree",
     "align-maps --into room_a.json markers_a.json --map room_b.json markers_b.json --surface-sigma 10mm,0.5deg -o "
     "alignment.json"},
    {"align-maps", "surfaces without common names",
     "align-maps --into room_a.json --map room_b.json --by-geometry -o alignment.json"},
    {"calibrate-camera", "photographs of a printed chessboard",
     "calibrate-camera --images photos --board chessboard:9x6:24mm -o camera.json"},
    {"calibrate-camera", "with a report",
     "calibrate-camera --images photos --board board.json -o camera.json --report report.html"},
    {"calibrate-camera", "points and pixels of another program",
     "calibrate-camera --observations points.csv -o camera.json"},
    {"calibrate-projector", "captures of capture-session",
     "calibrate-projector --captures session -o rig.json --report report.html"},
    {"calibrate-projector", "captures of another program",
     "calibrate-projector --captures captures --pattern gray --projector-size 1024x768 --board "
     "charuco:5x7:34mm:25mm:5x5_100 -o rig.json"},
    {"calibrate-projector", "refresh a rig by one or two new views after the projector was bumped",
     "calibrate-projector --captures session --update rig.json --changed pose -o rig.json"},
    {"calibrate-mount", "a recorded drive, and the height as measured",
     "calibrate-mount --base base.log --sightings sightings.log --height 0.85m+-5mm -o mount.json"},
    {"calibrate-mount", "from the images of the rig's camera",
     "calibrate-mount --base base.log --images images --rig rig.json --marker-size 160mm --height 0.85m+-5mm -o mount.json"},
    {"calibrate-mount", "a rig on an arm, and where the arm stands among the markers",
     "calibrate-mount --arm arm.log --sightings sightings.log --markers markers.json -o mount.json --preview mount.svg"},
    {"calibrate-room",
     "a known lens, and the measured distance between two points of the walls, by their pixels in the first view",
     "calibrate-room --captures room --known-camera camera.json --distance 412,300:880,310:1.25m -o rig.json"},
    {"calibrate-room", "a lens from a data sheet, 3 % uncertain, and the scale by a printed marker",
     "calibrate-room --captures room --known-camera sheet.json --lens-sigma 3% --marker apriltag_36h11:3:160mm "
     "-o rig.json"},
    {"calibrate-room", "with the data sheet of the projector, and a drawing",
     "calibrate-room --captures room --throw-ratio 1.4+-0.02 --lens-shift 0,0.5 --distance "
     "412,300:880,310:1.25m -o rig.json --preview room.png"},
    {"capture-session", "which displays there are", "capture-session --list-displays"},
    {"capture-session", "a camera of this computer",
     "capture-session --camera 0 --camera-size 1280x720 --board charuco:5x7:34mm:25mm:5x5_100 --views 12 -o session"},
    {"capture-session",
     "a room for calibrate-room, by two projectors and two cameras that stay where they are",
     "capture-session --display lamp=1 --display beamer=2 --camera left=0 --camera right=1 -o room"},
    {"detect-surfaces", "a depth image in millimetres",
     "detect-surfaces --depth depth.png --scale 1mm --intrinsics 525,525,319.5,239.5 --gravity 0,1,0 -o surfaces.json"},
    {"detect-surfaces", "in the frame of a rig",
     "detect-surfaces --depth depth.png --rig rig.json -o surfaces.json --preview seen.png"},
    {"detect-surfaces", "a few large planes",
     "detect-surfaces --depth depth.png --intrinsics camera.json --main-planes -o surfaces.json"},
    {"export-camera", "a script for Blender",
     "export-camera --rig rig.json --pose pose.json --for blender -o camera.py"},
    {"export-camera", "glFrustum, projection and view matrix", "export-camera --rig rig.json --for opengl"},
    {"export-camera", "for Unity, with y upwards",
     "export-camera --rig rig.json --pose pose.json --for unity --world-up y"},
    {"export-warp", "an MPCDI archive",
     "export-warp --rig rig.json --surfaces solved.json --surface wall -o wall.mpcdi"},
    {"export-warp", "a map as an image",
     "export-warp --rig rig.json --surfaces solved.json --surface wall -o wall.png"},
    {"export-warp", "a mesh",
     "export-warp --rig rig.json --surfaces solved.json --surface wall --grid 32x18 -o wall.obj"},
    {"locate-projector", "one printed marker",
     "locate-projector --rig rig.json --image view.png --marker apriltag_36h11:3:160mm -o pose.json"},
    {"locate-projector", "several markers with known poses",
     "locate-projector --rig rig.json --image view.png --markers markers.json -o pose.json"},
    {"locate-projector", "with a drawing of the markers",
     "locate-projector --rig rig.json --image view.png --markers markers.json -o pose.json --preview seen.png"},
    {"make-board", "ChArUco on A4, the usual choice",
     "make-board --board charuco:5x7:34mm:25mm:5x5_100 -o board.pdf --save-board board.json"},
    {"make-board", "a chessboard on A3", "make-board --board chessboard:9x6:34mm --paper a3 -o board.pdf"},
    {"make-board", "the printed ruler is 99.2 mm long",
     "make-board --board charuco:5x7:34mm:25mm:5x5_100 --measured 99.2mm -o board.pdf --save-board board.json"},
    {"make-patterns", "Gray code",
     "make-patterns --pattern gray --projector-size 1024x768 --board board.json -o session"},
    {"make-patterns", "phase shift",
     "make-patterns --pattern phase --projector-size 1920x1080 --board board.json -o session"},
    {"make-patterns", "a projected board, for verify-projection",
     "make-patterns --pattern charuco --projector-size 1024x768 -o check"},
    {"plan-projection", "the size of the image",
     "plan-projection --resolution 1280x800 --throw-ratio 0.8 --distance 1.5m -o plan.svg"},
    {"plan-projection", "from the side, onto a given area",
     "plan-projection --resolution 1280x800 --throw-ratio 0.8 --lens-shift 0,0.5 --distance 1.5m --yaw 20deg "
     "--target 1.2mx0.8m -o plan.svg"},
    {"plan-projection", "can text be read",
     "plan-projection --resolution 1280x800 --throw-ratio 0.8 --distance 1.5m --viewer-distance 3m --text-height 20mm"},
    {"predict-error", "a localiser, a map, and a drive",
     "predict-error --rig rig.json --surfaces surfaces.json --pose pose.json --pose-sigma 10mm,0.5deg --map-sigma "
     "5mm --speed 0.5m/s,30deg/s --delay 50ms --report error.html"},
    {"predict-error", "standing still",
     "predict-error --rig rig.json --surfaces surfaces.json --map-sigma 5mm"},
    {"predict-error", "by Monte Carlo as well",
     "predict-error --rig rig.json --surfaces surfaces.json --map-sigma 5mm --monte-carlo 100000"},
    {"procam-convert", "ROS camera_info",
     "procam convert rig.json --format ros --device camera -o camera_info.yaml"},
    {"procam-convert", "another program's calibration as a rig",
     "procam convert camchain.yaml --format procam -o rig.json"},
    {"procam-convert", "the rig on its robot, for the robot's description",
     "procam convert rig.json --format urdf --mount mount.json -o rig.urdf"},
    {"procam-studio", "a project in this folder", "procam studio stage"},
    {"procam-studio", "without hardware", "procam studio stage --simulate"},
    {"procam-studio", "for a browser on another computer", "procam studio stage --control 0.0.0.0:8737"},
    {"project-live", "without calibration: drag four corners",
     "project-live --display 1 --surfaces wall.json --content wall=picture.png"},
    {"project-live", "a fixed projector",
     "project-live --rig rig.json --surfaces surfaces.json --pose pose.json --content wall=video.mp4 --display 1"},
    {"project-live", "a robot whose localiser sends poses",
     "project-live --rig rig.json --surfaces surfaces.json --content wall=picture.png --pose-source udp:9000 "
     "--blank-on-stale 500ms"},
    {"render-to-image", "one frame",
     "render-to-image --rig rig.json --surfaces solved.json --content wall=picture.png -o frame.png"},
    {"render-to-image", "ten seconds of a video",
     "render-to-image --rig rig.json --surfaces solved.json --content wall=video.mp4 --duration 10s -o frames.mp4"},
    {"render-to-image", "with a view of the room",
     "render-to-image --rig rig.json --surfaces solved.json --content wall=picture.png -o frame.png --preview view.png"},
    {"scan-surfaces", "a mesh for content, and an image of it",
     "scan-surfaces --captures scan --rig rig.json -o surfaces.json --preview scan.png"},
    {"scan-surfaces", "the points with standard deviations",
     "scan-surfaces --captures scan --rig rig.json -o surfaces.json --save-points points.ply"},
    {"scan-surfaces", "three stations of the moved rig, merged",
     "scan-surfaces --captures scan_1 --captures scan_2 --captures scan_3 --rig rig.json -o surfaces.json"},
    {"section_v", "a calibration against the truth of its simulation",
     "section_v --rig rig.json --truth session/truth.json --report evaluation.html"},
    {"simulate-captures", "a session with its true rig",
     "simulate-captures --seed 7 --level paper -o session"},
    {"simulate-captures", "another pattern and board",
     "simulate-captures --pattern phase --board charuco:5x7:34mm:25mm:5x5_100 -o session"},
    {"simulate-captures", "a room instead of boards",
     "simulate-captures --room corner --level paper -o room"},
    {"simulate-robot", "poses to project-live --pose-source udp:9000",
     "simulate-robot --path circle:0.95m --rate 30 --noise 5mm,0.2deg --to udp:127.0.0.1:9000"},
    {"simulate-robot", "a bad network",
     "simulate-robot --path walk --loss 5% --reorder 5% --garbage 1% --jitter 5ms --to udp:127.0.0.1:9000"},
    {"simulate-robot", "a log, and what a rig on it sees of markers",
     "simulate-robot --path walk --duration 60s --noise 10mm,0.5deg -o base.log --sightings sightings.log"},
    {"solve-surfaces", "surfaces in the frame of the rig",
     "solve-surfaces --rig rig.json --surfaces surfaces.json -o solved.json"},
    {"solve-surfaces", "surfaces in the room, and the pose of the projector",
     "solve-surfaces --rig rig.json --surfaces surfaces.json --pose pose.json -o solved.json"},
    {"solve-surfaces", "one of several projectors",
     "solve-surfaces --rig rig.json --surfaces surfaces.json --projector left -o left.json"},
    {"verify-projection", "has anything moved",
     "verify-projection --rig rig.json --surfaces surfaces.json --surface wall --captures check/view_00"},
    {"verify-projection", "correct the rig",
     "verify-projection --rig rig.json --surfaces surfaces.json --surface wall --captures check/view_00 --correct "
     "projector -o corrected.json"},
    {"verify-projection", "with a drawing and a table of the marks",
     "verify-projection --rig rig.json --surfaces surfaces.json --surface wall --captures check/view_00 --preview "
     "errors.svg --data marks"},
};

}  // namespace

const std::vector<Example>& examples(const std::string& tool) {
  static const auto by_tool = [] {
    std::map<std::string, std::vector<Example>> all;
    for (const Row& row : kRows) all[row.tool].push_back({row.purpose, row.command});
    return all;
  }();
  static const std::vector<Example> none;
  const auto found = by_tool.find(tool);
  return found != by_tool.end() ? found->second : none;
}

}  // namespace procam::tools
