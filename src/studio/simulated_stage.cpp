#include "simulated_stage.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <random>

#include "procam/core/geometry/plane.hpp"
#include "procam/core/geometry/ray.hpp"
#include "procam/core/geometry/se3.hpp"
#include "procam/detect/board_artwork.hpp"
#include "procam/detect/marker_edges.hpp"
#include "procam/simulate/depth_view.hpp"

namespace procam::studio {
namespace {

constexpr double kWallDistance = 2.1;           // on the camera's axis, metres
const Vec3 kWallNormal = Vec3(0.2, -0.06, -1);  // towards the rig, not of unit length
constexpr double kWallAlbedo = 0.6, kColumnAlbedo = 0.5, kAmbient = 0.02;
/// A column half sunk into the wall, upright on it: its axis is at kColumnX to the right of the camera's axis, and it stands
/// out by kColumnDepth.
constexpr double kColumnRadius = 0.35, kColumnDepth = 0.08, kColumnX = 0.14, kColumnHalfHeight = 2;
/// A marker that somebody hangs: metres in the wall's frame, radians.
const Vec3 kMarkerOnWall = Vec3(-0.3, 0.02, 0);
constexpr double kMarkerTurn = 0.15;
constexpr double kFreeAir = 0.05;  ///< between a board and what is behind it, metres
constexpr double kMargin = 0.02;   // white paper round a print, metres
/// White paper at this distance is as bright as the level's brightest sheet.
constexpr double kExposedFor = 0.85;
constexpr double kProjectorGamma = 2.2, kProjectorBlack = 0.001;
constexpr std::size_t kShownFrames = 64;
/// Of the second projector, against the first one: metres in the rig's frame, radians about its y axis.
const Vec3 kSecondPlace = Vec3(0.42, 0.02, 0.03);
constexpr double kSecondTurn = 0.02;

/// The camera cut to the shape of `size` about its middle row, then reduced.
Camera cut_to(Camera camera, ImageSize size) {
  const double height = double(camera.size.width) * size.height / size.width;
  camera.intrinsics.cy -= 0.5 * (camera.size.height - height);
  const double scale = double(size.width) / camera.size.width;
  Intrinsics& k = camera.intrinsics;
  k.fx *= scale, k.fy *= scale, k.skew *= scale;
  k.cx = scale * (k.cx + 0.5) - 0.5;
  k.cy = scale * (k.cy + 0.5) - 0.5;
  camera.size = size;
  return camera;
}

ImageU8 copy(ViewU8 picture) {
  ImageU8 result(picture.width, picture.height, picture.channels);
  for (int y = 0; y < picture.height; ++y)
    std::copy_n(picture.row(y), picture.width * picture.channels, result.row(y));
  return result;
}

Pose wall_pose() {
  const Vec3 z = -kWallNormal.normalized();
  const Vec3 x = (Vec3::UnitX() - Vec3::UnitX().dot(z) * z).normalized();
  Mat3 axes;
  axes << x, z.cross(x), z;
  return Pose(axes, Vec3(0, 0, kWallDistance));
}

Pose column_pose(const Pose& rig_from_wall) {
  Mat3 axes;  // along the wall's x, into it, and down it
  axes << Vec3::UnitX(), -Vec3::UnitZ(), Vec3::UnitY();
  return rig_from_wall * Pose(axes, Vec3(kColumnX, 0, kColumnRadius - kColumnDepth));
}

}  // namespace

class SimulatedStage::Sink : public device::FrameSink {
 public:
  Sink(SimulatedStage& stage, std::size_t number) : stage_(stage), number_(number) {}
  ImageSize size() const override { return stage_.rig_.projectors[number_].projector.size(); }
  double show(ViewU8 picture) override {
    require(picture.size() == size(), "simulated projector: a frame of another size");
    auto frame = std::make_shared<const ImageU8>(copy(picture));
    const double now = device::now_s();
    const std::lock_guard<std::mutex> lock(stage_.mutex_);
    std::deque<Shown>& shown = stage_.shown_[number_];
    shown.push_back({now, std::move(frame)});
    while (shown.size() > kShownFrames) shown.pop_front();
    return now;
  }

 private:
  SimulatedStage& stage_;
  const std::size_t number_;
};

class SimulatedStage::Source : public device::FrameSource {
 public:
  explicit Source(SimulatedStage& stage) : stage_(stage) {}
  std::optional<device::SeenFrame> next(double after_s, double timeout_s) override {
    std::unique_lock<std::mutex> lock(stage_.mutex_);
    const double end = device::now_s() + timeout_s;
    while (true) {
      while (!stage_.seen_.empty() && stage_.seen_.front().time_s <= after_s) stage_.seen_.pop_front();
      const double now = device::now_s();
      if (!stage_.seen_.empty() && stage_.seen_.front().time_s <= now) {
        device::SeenFrame frame = std::move(stage_.seen_.front());
        stage_.seen_.pop_front();
        return frame;
      }
      if (now >= end) return std::nullopt;
      const double until = stage_.seen_.empty() ? end : std::min(end, stage_.seen_.front().time_s);
      stage_.changed_.wait_for(lock, std::chrono::duration<double>(until - now));
    }
  }

 private:
  SimulatedStage& stage_;
};

class SimulatedStage::Depth : public device::DepthSource {
 public:
  explicit Depth(SimulatedStage& stage) : stage_(stage) {}
  std::optional<device::SeenDepth> next(double, double) override {
    simulate::DepthSensor sensor;
    sensor.camera = stage_.rig_.camera().camera;
    simulate::Room room;
    {
      const std::lock_guard<std::mutex> lock(stage_.mutex_);
      room = stage_.room(stage_.held_);
    }
    simulate::DepthView view = simulate::depth_view(room, sensor, Pose(), stage_.options_.seed + ++taken_);
    device::SeenDepth seen;
    seen.pixels = std::move(view.mm);
    seen.time_s = device::now_s();
    return seen;
  }

 private:
  SimulatedStage& stage_;
  std::uint64_t taken_ = 0;
};

SimulatedStage::SimulatedStage(const SimulatedRoom& options) : options_(options) {
  const simulate::SimulatedSession session =
      simulate::make_session(simulate::level_named(options.level), options.seed);
  rig_ = session.rig();
  rig_.cameras.front().camera = cut_to(rig_.cameras.front().camera, options.camera_size);
  capture_ = session.capture;
  rig_from_wall_ = wall_pose();
  rig_from_column_ = column_pose(rig_from_wall_);
  if (options.projectors > 1) add_projector();
  for (std::size_t i = 0; i < rig_.projectors.size(); ++i) {
    sinks_.push_back(std::make_unique<Sink>(*this, i));
    shown_.push_back({{0, std::make_shared<const ImageU8>(sinks_.back()->size(), 1)}});
  }
  source_ = std::make_unique<Source>(*this);
  depth_ = std::make_unique<Depth>(*this);
  view_ = trace(std::nullopt);
  person_ = std::thread([this] { move_boards(); });
  sensor_ = std::thread([this] { expose_images(); });
}

SimulatedStage::~SimulatedStage() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ended_ = true;
  }
  changed_.notify_all();
  person_.join();
  sensor_.join();
}

/// Right of the first one, turned so that their light overlaps on the wall.
void SimulatedStage::add_projector() {
  RigProjector second = rig_.projectors.front();
  rig_.projectors.front().name = "projector_1";
  second.name = "projector_2";
  Intrinsics& k = second.projector.inverse_camera.intrinsics;
  k.fx *= 1.03, k.fy *= 1.034, k.skew *= -0.6;
  k.cx += 9, k.cy -= 6;
  second.rig_from_projector =
      Pose(Eigen::Quaterniond(Eigen::AngleAxisd(kSecondTurn, Vec3::UnitY())), kSecondPlace) *
      second.rig_from_projector;
  rig_.projectors.push_back(second);
}

device::FrameSink& SimulatedStage::projector(std::size_t i) {
  return *sinks_.at(i);
}

std::vector<ChosenProjector> SimulatedStage::all_projectors() const {
  if (rig_.projectors.size() == 1) return {{"", "simulated"}};
  return {{"projector_1", "simulated"}, {"projector_2", "simulated 2"}};
}
device::FrameSource& SimulatedStage::camera() {
  return *source_;
}

device::DepthSource& SimulatedStage::depth_camera() {
  return *depth_;
}

std::optional<Vec3> SimulatedStage::on_wall(const Ray& ray_in_rig) const {
  const auto wall = intersect(ray_in_rig, Plane::of_xy(rig_from_wall_));
  const Pose column_from_rig = rig_from_column_.inverse();
  const Vec3 from = column_from_rig * ray_in_rig.origin,
             direction = column_from_rig.rotate(ray_in_rig.direction);
  // |(from + s direction) across the axis| = radius, the near root
  const double a = direction.head<2>().squaredNorm(), b = from.head<2>().dot(direction.head<2>()),
               c = from.head<2>().squaredNorm() - kColumnRadius * kColumnRadius, root = b * b - a * c;
  if (!(a > 0 && root >= 0)) return wall;
  const double s = (-b - std::sqrt(root)) / a;
  if (!(s > 0) || std::abs(from.z() + s * direction.z()) > kColumnHalfHeight) return wall;
  const Vec3 column = ray_in_rig.at(s);
  return wall && (*wall - ray_in_rig.origin).norm() < (column - ray_in_rig.origin).norm() ? wall : column;
}

simulate::Room SimulatedStage::room(const std::optional<Pose>& rig_from_board) const {
  simulate::Room room;
  room.ambient = kAmbient;
  room.bodies.push_back({"wall", simulate::Rectangle{Vec2(-6, -4), Vec2(6, 4)}, rig_from_wall_, kWallAlbedo});
  room.bodies.push_back({"column", simulate::Cylinder{kColumnRadius, -kColumnHalfHeight, kColumnHalfHeight},
                         rig_from_column_, kColumnAlbedo});
  if (marker_) room.bodies.push_back(*marker_);
  if (rig_from_board) room.bodies.push_back(simulate::printed_sheet("board", *board_, *rig_from_board));
  return room;
}

std::shared_ptr<const simulate::LiveView> SimulatedStage::trace(
    const std::optional<Pose>& rig_from_board) const {
  std::vector<simulate::RoomLight> lights;
  for (const RigProjector& projector : rig_.projectors) {
    simulate::RoomLight& light = lights.emplace_back();
    light.projector = projector.projector;
    light.room_from_projector = projector.rig_from_projector;
    light.lens = capture_.projector_lens;
    light.blur_px = capture_.projector_blur_px;
    light.gamma = kProjectorGamma;
    light.black = kProjectorBlack;
  }
  simulate::LiveViewOptions options;
  options.view.exposure = capture_.brightest_grey * kExposedFor * kExposedFor / 0.8;
  options.view.camera_blur_px = capture_.camera_blur_px * options_.camera_size.width / 1280.0;
  options.view.vignetting = capture_.vignetting;
  options.view.gamma = capture_.gamma;
  options.view.noise = capture_.noise;
  options.view.seed = options_.seed;
  options.view.adaptive = true;
  options.glare = capture_.glare;
  return std::make_shared<const simulate::LiveView>(room(rig_from_board), rig_.camera().camera, Pose(),
                                                    lights, options);
}

void SimulatedStage::take_board(const std::optional<Board>& board) {
  std::optional<simulate::PrintedBoard> print;
  if (board) {
    print.emplace();
    print->layout = *board;
    print->margin = kMargin;
    if (!std::holds_alternative<Chessboard>(*board)) print->artwork = detect::board_artwork(*board);
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  board_ = std::move(print);
}

bool SimulatedStage::is_usable(const Pose& rig_from_board, const RigProjector& projector) const {
  constexpr double kRim = 8;
  const auto inside = [](const Camera& device, const Vec3& point) {
    const std::optional<Vec2> p = device.project(point);
    return p && p->x() >= kRim && p->y() >= kRim && p->x() <= device.size.width - 1 - kRim &&
           p->y() <= device.size.height - 1 - kRim;
  };
  const Pose projector_from_board = projector.rig_from_projector.inverse() * rig_from_board;
  for (const Pose& device_from_board : {rig_from_board, projector_from_board}) {
    const Vec3 eye = device_from_board.inverse().translation;
    if (eye.z() > -0.6 * eye.norm()) return false;
  }
  for (const Vec3& corner : simulate::sheet_corners_in_board(*board_)) {
    if (!inside(rig_.camera().camera, rig_from_board * corner)) return false;
    const Vec3 in_rig = rig_from_board * corner;
    if (!((rig_from_wall_.inverse() * in_rig).z() < -kFreeAir)) return false;
    if (!((rig_from_column_.inverse() * in_rig).head<2>().norm() > kColumnRadius + kFreeAir)) return false;
  }
  // As many points in the light as advised poses have (calibrate/next_view.hpp).
  const Points3 points = points_in_board(board_->layout);
  const auto lit = std::count_if(points.begin(), points.end(), [&](const Vec3& point) {
    return inside(projector.projector.inverse_camera, projector_from_board * point);
  });
  return 10 * std::size_t(lit) >= 9 * points.size();
}

bool SimulatedStage::hold_at(const Pose& wished, std::size_t projector) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!board_) return false;
  // Nearest first: a hand moves the board until the light covers it, away from the camera rather than towards it.
  std::mt19937 random(unsigned(options_.seed));
  std::uniform_real_distribution<double> unit(-1, 1);
  constexpr int kTries = 20000;
  for (int i = 0; i < kTries; ++i) {
    const double reach = double(i) / kTries;
    Vec6 change;
    for (int k = 0; k < 6; ++k) change[k] = unit(random);
    change.head<3>() *= 0.7 * reach;
    change.tail<3>() *= 0.5 * reach;
    // About the board's middle, not the rig's origin.
    const Pose about(Eigen::Quaterniond::Identity(), wished.translation);
    Pose pose = about * se3_exp(change) * about.inverse() * wished;
    pose.translation *= 1 + reach * (1 + unit(random)) / 2;
    if (!is_usable(pose, rig_.projectors.at(projector))) continue;
    wish_ = Wish{pose};
    moving_ = true;
    changed_.notify_all();
    return true;
  }
  return false;
}

void SimulatedStage::put_board_away() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!held_ && !wish_) return;
  wish_ = Wish{};
  moving_ = true;
  changed_.notify_all();
}

void SimulatedStage::hang_marker(const std::optional<PlacedMarker>& marker, MarkerDictionary dictionary) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (moving_) return;  // the other thread traces the room as it is
  marker_.reset();
  if (marker) {
    Mat3 turned;
    turned = Eigen::AngleAxisd(kMarkerTurn, Vec3::UnitZ());
    marker_ = simulate::marker_sheet({marker->id, marker->size, rig_from_wall_ * Pose(turned, kMarkerOnWall)},
                                     detect::marker_cells(dictionary));
  }
  wish_ = Wish{held_};
  moving_ = true;
  changed_.notify_all();
}

void SimulatedStage::bump_projector() {
  constexpr double kAngle = 0.2 * kPi / 180;
  const std::lock_guard<std::mutex> lock(mutex_);
  if (moving_) return;  // the other thread traces the rig as it is
  Vec6 bump = Vec6::Zero();
  bump.head<3>() = kAngle * Vec3(0.3, -0.9, 0.2).normalized();
  RigProjector& projector = rig_.projectors.front();
  projector.rig_from_projector = projector.rig_from_projector * se3_exp(bump);
  wish_ = Wish{held_};
  moving_ = true;
  changed_.notify_all();
}

void SimulatedStage::move_boards() {
  while (true) {
    std::optional<Pose> pose;
    {
      std::unique_lock<std::mutex> lock(mutex_);
      changed_.wait(lock, [&] { return ended_ || wish_; });
      if (ended_) return;
      pose = wish_->rig_from_board;
      wish_.reset();
    }
    auto view = trace(pose);
    const std::lock_guard<std::mutex> lock(mutex_);
    view_ = std::move(view);
    held_ = pose;
    if (!wish_) moving_ = false;
  }
}

std::shared_ptr<const ImageU8> SimulatedStage::frame_at(std::size_t projector, double time_s) {
  const std::lock_guard<std::mutex> lock(mutex_);
  auto frame = shown_[projector].front().frame;
  for (const Shown& one : shown_[projector])
    if (one.time_s <= time_s) frame = one.frame;
  return frame;
}

void SimulatedStage::expose_images() {
  const double period = 1 / options_.frames_per_s;
  double due = device::now_s();
  std::vector<std::shared_ptr<const ImageU8>> lit_frames(sinks_.size());
  std::shared_ptr<const simulate::LiveView> lit_view;
  std::vector<std::shared_ptr<const simulate::LiveView::Light>> lights(sinks_.size());
  for (std::uint64_t number = 0; !ended_; ++number) {
    // The light is that of `latency` before the image arrives, whatever the drawing takes.
    std::this_thread::sleep_for(std::chrono::duration<double>(std::max(0.0, due - device::now_s())));
    const double exposed = device::now_s();
    std::shared_ptr<const simulate::LiveView> view;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      view = view_;
    }
    for (std::size_t i = 0; i < sinks_.size(); ++i) {
      const auto frame = frame_at(i, exposed);
      if (frame != lit_frames[i] || view != lit_view) lights[i] = view->light_of(*frame, i);
      lit_frames[i] = frame;
    }
    lit_view = view;
    ImageU8 image = view->capture(lights, number);
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      seen_.push_back({std::move(image), std::max(device::now_s(), exposed + options_.latency_s)});
      while (seen_.size() > device::FrameSource::kNewest) seen_.pop_front();
    }
    changed_.notify_all();
    due = std::max(due + period, device::now_s());
  }
}

}  // namespace procam::studio
