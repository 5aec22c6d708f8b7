// A robot before a wall that it knows: its localiser is off by 20 mm and 1 degree, and the light stays (docs/watch.md):
//
//   10_robot picture.png OUT
//
// The localiser reports ten poses a second. Their error changes slowly, with a correlation time of 3 s. The robot stands for six
// seconds, then it drives and turns to and fro before a poster. A camera of its rig compares the light on the wall with what it
// should be (distance and tilt of the wall), and sees two printed markers beside the poster (the place along the wall). Drawn
// twice: with the localiser's poses alone, and with the corrected ones. OUT/robot.mp4 has both side by side, OUT/robot.png a
// moment of them, OUT/robot_error.svg the true error over time. The program fails unless the correction brings the
// error to less than 4 mm RMS standing and 10 mm driving.
#include <array>
#include <cstdio>
#include <deque>
#include <iostream>
#include <random>

#include "../common/error_plot.hpp"
#include "../common/stage.hpp"
#include "procam/core/geometry/se3.hpp"
#include "procam/detect/marker_edges.hpp"
#include "procam/simulate/live_view.hpp"
#include "procam/track/locate.hpp"
#include "procam/track/pose_correction.hpp"
#include "procam/watch/watch.hpp"

using namespace procam;

namespace {

constexpr double kFramesPerSecond = 20, kBegin = 10, kDrives = 6, kEnd = 13, kSettled = 1;  // seconds
constexpr double kMessages = 10, kLatency = 0.05, kCorrelation = 3, kCameraDelay = 0.06,
                 kDisplayDelay = 0.035;
const Vec2 kPoster(0.90, 0.60);  // metres

/// Axes of something that looks along x, its own being x right, y down, z ahead.
Eigen::Quaterniond looking_ahead() {
  Mat3 axes;
  axes.col(0) = -Vec3::UnitY(), axes.col(1) = -Vec3::UnitZ(), axes.col(2) = Vec3::UnitX();
  return Eigen::Quaterniond(axes);
}
Pose base_from_rig() {
  return Pose(looking_ahead() * so3_exp(Vec3(0.02, -0.01, 0.01)), Vec3(0.1, 0.02, 0.9));
}
/// The middle of the poster, in the world.
Pose poster() {
  return Pose(looking_ahead() * so3_exp(Vec3(0, 0.14, 0)), Vec3(2.2, 0.05, 1.08));
}

/// At most 0.5 m/s and 30 degrees a second.
Pose robot(double time) {
  const double t = std::max(0.0, time - kBegin - kDrives), way = 0.25 * std::sin(2.0 * t) * std::min(1.0, t),
               turn = 0.16 * std::sin(2.0 * t + 0.5) * std::min(1.0, t);
  return Pose(so3_exp(Vec3(0, 0, 0.02 - turn)), Vec3(0.1 * way, way, 0));
}

MarkerMap markers() {
  MarkerMap map;
  map.dictionary = MarkerDictionary::kAprilTag36h11;
  map.markers = {{5, 0.12, poster() * Pose(Eigen::Quaterniond::Identity(), Vec3(-0.57, 0.1, 0))},
                 {9, 0.12, poster() * Pose(Eigen::Quaterniond::Identity(), Vec3(0.57, -0.15, 0))}};
  return map;
}

simulate::Room room(const MarkerCells& cells) {
  simulate::Room room;
  room.ambient = 0.08;
  room.bodies.push_back(examples::sheet("wall", {-3, -2}, {3, 2}, 0.75, poster()));
  examples::add_tape(room, kPoster, 0.01, poster(), 0.75);
  for (const PlacedMarker& marker : markers().markers)
    room.bodies.push_back(simulate::marker_sheet(marker, cells, Pose(), 1));
  return room;
}

show::Projection projection(const Rig& rig, const ImageU8& picture) {
  show::ProjectionOptions options;
  options.child_from_rig = base_from_rig();
  options.track.delay = kLatency;
  show::Projection projection(rig, options);
  projection.set_show(examples::one_surface("poster", "world", poster(), kPoster, picture));
  return projection;
}

/// Ten messages a second, with an error that lasts.
class Localiser {
 public:
  track::StampedPose next(double time) {
    const double phi = std::exp(-1 / kMessages / kCorrelation);
    for (int k = 0; k < 3; ++k)
      off_[k] =
          (is_first_ ? 0 : phi * off_[k]) + (is_first_ ? 1 : std::sqrt(1 - phi * phi)) * normal_(random_);
    is_first_ = false;
    const Pose truth = robot(time);
    track::StampedPose message;
    message.arrival = time + kLatency;
    message.frame = "map";
    message.child = "base";
    message.frame_from_child = Pose(so3_exp(Vec3(0, 0, kDegree * off_.z())) * truth.rotation,
                                    truth.translation + 0.02 * Vec3(off_.x(), off_.y(), 0));
    return message;
  }

 private:
  std::mt19937_64 random_{3};
  std::normal_distribution<double> normal_;
  Vec3 off_ = Vec3::Zero();
  bool is_first_ = true;
};

/// The camera of the rig, and what its images tell of the rig's place.
class WatchCamera {
 public:
  explicit WatchCamera(const Rig& rig)
      : rig_(rig),
        cells_(detect::marker_cells(markers().dictionary)),
        room_(room(cells_)),
        watcher_(rig.camera(), rig.projector(), options()) {}

  static watch::WatchOptions options() {
    watch::WatchOptions options;
    options.locates_rig = true;
    return options;
  }
  const simulate::Room& place() const { return room_; }

  std::vector<track::PoseSight> look(double time, const show::Projection& shown, const ImageU8& frame) {
    const Pose world_from_rig = robot(time) * base_from_rig();
    simulate::LiveViewOptions seeing;
    seeing.view.exposure = exposure_;
    seeing.view.brightest_grey = 210;
    seeing.view.camera_blur_px = 0.6;
    seeing.view.gamma = 2.2;
    seeing.view.noise = {2, 0.02};
    seeing.view.adaptive = true;
    simulate::RoomLight light{
        rig_.projector().projector, world_from_rig * rig_.projector().rig_from_projector, {}};
    light.gamma = simulate::kSrgb;
    const simulate::LiveView view(room_, rig_.camera().camera, world_from_rig, light, seeing);
    exposure_ = view.exposure();
    const ImageU8 image = view.capture(frame, ++images_);
    const Pose drawn_for =
        (shown.rig_from_projector() * *shown.solved().projector_from_world).inverse().normalized();
    watcher_.place(watch::watched_surfaces(shown.solved(), rig_.projector()));
    const watch::WatchReport report = watcher_.add(time, {frame, frame, 0, 0}, image);
    std::vector<track::PoseSight> sights;
    if (report.rig && report.rig->cells > 0)
      sights.push_back({time, drawn_for, report.rig->information, report.rig->score});
    const MarkerDetections found = detect::detect_marker_edges(image, cells_, {rig_.camera().camera});
    if (found.markers.size() < 2) return sights;
    const track::LocateResult located = track::locate(found, rig_.camera().camera, markers());
    // The camera is the rig's frame.
    const Mat6 covariance = located.covariance + 1e-8 * Mat6::Identity();
    sights.push_back(
        {time, located.camera_from_world.inverse(), covariance.llt().solve(Mat6::Identity()), Vec6::Zero()});
    return sights;
  }

 private:
  const Rig& rig_;
  MarkerCells cells_;
  simulate::Room room_;
  watch::Watch watcher_;
  double exposure_ = 0;
  std::uint64_t images_ = 0;
};

double squared_error(const Rig& rig, const show::Projection& shown, const Pose& truth) {
  const auto& drawn = std::get<PlacedPlane>(shown.solved().surfaces[0].placement);
  const Pose world_from_projector = truth * base_from_rig() * rig.projector().rig_from_projector;
  return examples::squared_error(rig.projector().projector, drawn.projector_from_surface,
                                 rig.projector().projector, world_from_projector.inverse() * poster(),
                                 kPoster);
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 3) {
    std::cerr << "usage: 10_robot picture.png OUT\n";
    return 2;
  }
  const std::filesystem::path out = argv[2];
  const ImageU8 picture = io::load_image(argv[1]).image;
  const Rig rig = examples::camera_with_projector({560, 554, 322, 251, 0.4}, {1190, 1178, 530, 702, -0.8});
  WatchCamera camera(rig);
  Localiser localiser;
  std::array<show::Projection, 2> shows{projection(rig, picture), projection(rig, picture)};
  track::PoseCorrectionOptions options;
  options.track.delay = kLatency;
  options.child_from_rig = base_from_rig();
  track::PoseCorrection correction(options);
  examples::Spectator spectator;
  spectator.eye.intrinsics = {560, 560, 239.5, 179.5};
  spectator.room_from_eye = poster() * Pose(Eigen::Quaterniond::Identity(), Vec3(0, 0, -1.75));
  examples::SideBySide video(out / "robot.mp4", spectator.eye.size, kFramesPerSecond / 4);
  examples::ErrorPlot plot{"the localiser's poses", "corrected by the camera", {}, {}, {}, {}};
  plot.events.emplace_back(kDrives, "drives");
  std::deque<std::pair<double, std::vector<track::PoseSight>>> under_way;
  ImageU8 frame(shows[0].frame_size(), 3);
  std::array<std::array<double, 2>, 2> sums{};  // standing, driving; without, with
  std::array<int, 2> counts{};
  double next_message = kBegin;
  for (int k = 4; k < int(kEnd * kFramesPerSecond); ++k) {
    const double light = kBegin + k / kFramesPerSecond, now = light - kDisplayDelay;
    for (; next_message + kLatency <= now; next_message += 1 / kMessages) {
      const track::StampedPose message = localiser.next(next_message);
      shows[0].add(message);
      if (const auto pose = correction.add(message)) shows[1].add(*pose);
    }
    for (; !under_way.empty() && under_way.front().first <= now; under_way.pop_front())
      if (const auto pose = correction.add(under_way.front().second)) shows[1].add(*pose);
    const Pose truth = robot(light);
    const std::size_t part = light - kBegin < kDrives ? 0 : 1;
    std::array<double, 2> errors{};
    for (std::size_t i = 0; i < 2; ++i) {
      shows[i].draw(light, light, frame);
      errors[i] = squared_error(rig, shows[i], truth);
      if (k % 4 != 0) continue;
      char words[64];
      std::snprintf(words, sizeof words, "%s: %.1f mm off", i == 0 ? "localiser" : "corrected",
                    1e3 * std::sqrt(errors[i]));
      video.put(int(i),
                spectator.view(camera.place(), rig.projector().projector,
                               truth * base_from_rig() * rig.projector().rig_from_projector, frame),
                words);
    }
    if (k % 4 == 0) video.add();
    if (k == 40) video.save(out / "robot.png");
    if (k % 2 == 0) under_way.emplace_back(light + kCameraDelay, camera.look(light, shows[1], frame));
    if (light - kBegin < kSettled) continue;
    plot.add(light - kBegin, std::sqrt(errors[0]), std::sqrt(errors[1]));
    for (std::size_t i = 0; i < 2; ++i) sums[part][i] += errors[i];
    ++counts[part];
  }
  video.finish();
  plot.save(out / "robot_error.svg");
  const auto rms_mm = [&](std::size_t part, std::size_t i) {
    return 1e3 * std::sqrt(sums[part][i] / counts[part]);
  };
  std::printf(
      "on the wall, RMS: standing %.1f mm by the localiser, %.2f mm corrected; driving %.1f mm and %.2f mm\n",
      rms_mm(0, 0), rms_mm(0, 1), rms_mm(1, 0), rms_mm(1, 1));
  return rms_mm(0, 1) < 4 && rms_mm(1, 1) < 10 ? 0 : 1;
} catch (const Error& error) {
  std::cerr << error.what() << "\n";
  return 3;
}
