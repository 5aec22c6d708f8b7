#include <sys/stat.h>

#include <chrono>

#include "chaos_steps.hpp"
#include "e2e/lamp_rig.hpp"
#include "procam/detect/marker_edges.hpp"
#include "procam/device/video_file.hpp"
#include "procam/io/image/depth_file.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/marker_map_file.hpp"
#include "procam/io/pose_file.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/surface_file.hpp"
#include "procam/simulate/depth_view.hpp"
#include "procam/simulate/marker_view.hpp"

namespace procam::test {
namespace {

constexpr const char* kMarker = "apriltag_36h11:3:300mm";

ImageU8 colourful(int width, int height, int seed) {
  ImageU8 image(width, height, 3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      image.at(x, y, 0) = std::uint8_t(60 + (x + 20 * seed) % 190);
      image.at(x, y, 1) = std::uint8_t(60 + (2 * y + 30 * seed) % 190);
      image.at(x, y, 2) = (x / 20 + y / 20 + seed) % 2 == 0 ? 250 : 70;
    }
  return image;
}

RigCamera depth_camera() {
  RigCamera eye;
  eye.name = "depth";
  eye.camera = {{160, 120}, {146, 144.5, 79.3, 60.7, 0.2}, NoDistortion{}};
  eye.rig_from_camera = Pose(so3_exp(Vec3(-0.01, 0.04, 0.02)), Vec3(-0.04, 0.03, 0));
  return eye;
}

RigCamera marker_camera_of_rig() {
  RigCamera eye;
  eye.name = "eye";
  eye.camera = {{320, 240}, {360, 352.5, 165.5, 114, 0.6}, NoDistortion{}};
  eye.rig_from_camera = Pose(so3_exp(Vec3(0.02, -0.03, 0.01)), Vec3(0.05, -0.02, 0.03));
  return eye;
}

}  // namespace

ChaosStage::ChaosStage(std::uint64_t seed) : random(seed) {
  make_files();
  start_feeds(seed);
  start_shows();
}

ChaosStage::~ChaosStage() {
  // Their threads use what follows.
  depth.reset();
  people.reset();
  shared_frames.reset();
  shared_.reset();
}

void ChaosStage::write(const std::string& name, const std::string& bytes) const {
  std::ofstream(at(name), std::ios::binary) << bytes;
}

void ChaosStage::replace(const std::string& name, const std::string& bytes) const {
  write("next", bytes);
  fs::rename(at("next"), at(name));
}

void ChaosStage::make_files() {
  Rig rig = lamp_rig();
  io::save_rig(at("rig.json"), rig);
  rig.projectors[0].rig_from_projector = Pose(so3_exp(Vec3(0.02, -0.03, 0.01)), Vec3(0.05, -0.02, 0.03));
  rig.cameras = {depth_camera()};
  io::save_rig(at("room_rig.json"), rig);
  rig.cameras = {marker_camera_of_rig()};
  io::save_rig(at("marker_rig.json"), rig);
  io::save_pose(at("sensor.json"),
                {"projector",
                 "sensor",
                 {Pose(so3_exp(Vec3(-0.12, 0.1, 0.03)), Vec3(-0.1, 0.25, -0.05)), Mat6::Zero()}});

  io::save_image(at("picture.png"), colourful(200, 100, 0));
  io::save_image(at("other.png"), colourful(120, 90, 3));
  write("garbage.png", "this is no image");
  mkfifo(at("pipe.png").c_str(), 0600);
  fs::create_directory(at("shots"));
  for (int i = 0; i < 8; ++i) io::save_image(at("shots/" + std::to_string(i) + ".png"), colourful(90, 60, i));
  device::VideoFile video(at("clip.avi"), {96, 64}, 10);
  for (int i = 0; i < 12; ++i) video.add(colourful(96, 64, i).view());
  video.finish();

  fs::create_directory(at("depth"));
  simulate::Room walls;
  walls.bodies.push_back({"wall", simulate::Rectangle{Vec2(-2, -1.5), Vec2(2, 1.0)},
                          Pose(so3_exp(Vec3(0.03, 0.1, 0)), Vec3(0, 0, 2)), 0.5});
  simulate::DepthSensor sensor;
  sensor.camera = depth_camera().camera;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    io::save_depth(at("depth.png"),
                   simulate::depth_view(walls, sensor, depth_camera().rig_from_camera, seed).mm);
    depth_images_.push_back(slurp(at("depth.png")));
  }
}

void ChaosStage::start_feeds(std::uint64_t seed) {
  pose_port = free_port(SOCK_DGRAM);
  osc_port = free_port(SOCK_DGRAM);
  people_port = free_port(SOCK_DGRAM);
  tcp_port = free_port(SOCK_STREAM);
  poses = std::make_unique<PoseSender>(pose_port, seed);
  camera = std::make_unique<NetworkCamera>(colourful(160, 90, 5));
  const MarkerMap map = io::parse_marker(kMarker);
  const Pose camera_from_world(so3_exp(Vec3(0.4, -0.5, 0.1)), Vec3(0.05, -0.03, 1.3));
  marker_camera = std::make_unique<NetworkCamera>(simulate::marker_view(
      marker_camera_of_rig().camera, camera_from_world, map.markers, detect::marker_cells(map.dictionary)));
  depth = std::make_unique<Repeated>(8, [this](int i) {
    // As drivers should: under another name first. The last second is kept.
    write("next_depth", depth_images_[std::size_t(i) % depth_images_.size()]);
    std::error_code gone;
    fs::rename(at("next_depth"), at("depth/" + std::to_string(i) + ".png"), gone);
    fs::remove(at("depth/" + std::to_string(i - 8) + ".png"), gone);
  });
  people = std::make_unique<Repeated>(20, [this](int) {
    Socket(SOCK_DGRAM).send_to(people_port, people::to_json_line(person_at(device::now_s())));
  });
  open_shared_writer();
  shared_frames = std::make_unique<Repeated>(10, [this](int i) {
    const std::lock_guard<std::mutex> lock(shared_mutex_);
    if (shared_) shared_->show(colourful(64, 48, i));
  });
}

void ChaosStage::open_shared_writer() {
  const std::lock_guard<std::mutex> lock(shared_mutex_);
  shared_.reset();
  device::SinkOptions options;
  options.size = {64, 48};
  shared_ = device::open_sink("shm:" + shared_name(), options);
  shared_->show(colourful(64, 48, 1));
}

void ChaosStage::start_shows() {
  SurfaceSet set;
  set.surfaces = {wall_around(0, "picture.png"),
                  wall_around(1, "clip.avi"),
                  wall_around(2, "shots@10"),
                  wall_around(3, "picture.png"),
                  lamp_sign("another program", "shm:" + shared_name()),
                  lamp_sign("camera", camera->url(), {150, -20}),
                  lamp_sign("sign", "#ff8040", {80, -60})};
  io::save_surfaces(at("surfaces.json"), set);
  first_surfaces_ = nlohmann::json::array();
  for (const Surface& surface : set.surfaces) first_surfaces_.push_back({surface.name, surface.content});
  set.surfaces = {wall_around(0, "picture.png"), lamp_sign("sign", "#ff8040")};
  io::save_surfaces(at("marker.json"), set);
  const std::string from = "udp:127.0.0.1:";
  show = std::make_unique<ChaosShow>(
      "show",
      "--rig " + at("rig.json") + " --surfaces " + at("surfaces.json") + " --pose-source " + from +
          std::to_string(pose_port) + " --pose-source tcp-listen:127.0.0.1:" + std::to_string(tcp_port) +
          " --pose-source osc:127.0.0.1:" + std::to_string(osc_port) +
          " --frame map --child base --blank-on-stale 300ms --delay 20ms --fps 20 --output none --autosave --record " +
          at("run.log"),
      folder_ / "show.out");
  room = std::make_unique<ChaosShow>(
      "room",
      "--rig " + at("room_rig.json") + " --surfaces depth:watch:" + at("depth") +
          " --content wall_1=" + at("picture.png") + " --people " + from + std::to_string(people_port) +
          " --sensor " + at("sensor.json") + " --silhouettes --blank-on-stale 1s --fps 10 --output none",
      folder_ / "room.out");
  marker = std::make_unique<ChaosShow>("marker",
                                       "--rig " + at("marker_rig.json") + " --surfaces " + at("marker.json") +
                                           " --marker-camera " + marker_camera->url() + " --marker " +
                                           kMarker + " --blank-on-stale 1s --fps 5 --output none",
                                       folder_ / "marker.out");
  for (const char* name : {"clip.avi", "surfaces.json"}) files_[name] = slurp(at(name));
  for (int i = 0; i < 8; ++i) {
    const std::string name = "shots/" + std::to_string(i) + ".png";
    files_[name] = slurp(at(name));
  }
}

bool ChaosStage::repair_files() const {
  bool surfaces_written = false;
  for (const auto& [name, bytes] : files_) {
    std::error_code ignored;
    if (!fs::is_regular_file(at(name), ignored)) fs::remove_all(at(name), ignored);
    if (slurp(at(name)) == bytes) continue;
    replace(name, bytes);
    if (name == "surfaces.json") surfaces_written = true;
  }
  return surfaces_written;
}

std::string ChaosStage::unrecovered() const {
  const nlohmann::json status = show->status(), of_room = room->status(), of_marker = marker->status();
  if (!status.is_object() || !of_room.is_object() || !of_marker.is_object()) return "a show does not answer";
  nlohmann::json surfaces = nlohmann::json::array();
  for (const nlohmann::json& surface : status["surfaces"])
    surfaces.push_back({surface["name"], surface["content"]});
  if (surfaces != first_surfaces_) return "the surfaces file is not read again";
  if (status.value("unsaved", true)) return "edits are not saved";
  if (status["pose_state"] != "fresh") return "the pose is " + status["pose_state"].get<std::string>();
  if (show->metric("contents_stopped") != 0) return "a content has not come back";
  if (of_room["surfaces"].empty()) return "the depth camera's surfaces have not come back";
  if (of_marker["pose_state"] != "fresh") return "the marker camera has not come back";
  return "";
}

std::string ChaosStage::repair() {
  poses->set({});
  camera->set(NetworkCamera::State::kSends);
  marker_camera->set(NetworkCamera::State::kSends);
  depth->pause(false);
  people->pause(false);
  std::string missing;
  double written = device::now_s(), reloads = -1;
  for (const double end = device::now_s() + 30; device::now_s() < end;) {
    // Again and again: an edit that is saved late replaces the file.
    const double before = show->metric("reloads");
    if (repair_files()) {
      written = device::now_s();
      reloads = before;
    }
    missing = unrecovered();
    // A file that is read only during the next step would undo the edit of that step. A file whose bytes the show has
    // saved itself is not read.
    if (missing.empty() && (show->metric("reloads") > reloads || device::now_s() - written > 5)) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  return missing;
}

}  // namespace procam::test
