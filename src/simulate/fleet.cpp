#include "procam/simulate/fleet.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "noise.hpp"
#include "procam/core/base/closed_form.hpp"
#include "procam/core/geometry/se3.hpp"

namespace procam::simulate {
namespace {

Vec3 middle_of(const Board& layout) {
  const Points3 points = points_in_board(layout);
  return 0.5 * (points.front() + points.back());
}

using internal::Random;

constexpr double kBesideEachOther = 0.42;  ///< metres between neighbours
constexpr double kRimOfPicture = 6;        ///< pixels that the print keeps from a picture's rim

/// The level's lens, as another copy of it came from the factory.
Camera copy_of(const Camera& lens, Random& random) {
  VecX parameters = parameters_of(lens);
  for (Eigen::Index i = 0; i < parameters.size(); ++i)
    parameters[i] *= i < 2 ? random.uniform(0.995, 1.005) : random.uniform(0.97, 1.03);
  const double zoom = random.uniform(0.96, 1.04);
  parameters[0] *= zoom;
  parameters[1] *= zoom;
  return with_parameters(lens, parameters);
}

/// At a place, its picture's middle on the target.
Pose looking_at(const Camera& lens, const Vec3& place, const Vec3& target, Random& random) {
  const Vec2 middle(0.5 * (lens.size.width - 1), 0.5 * (lens.size.height - 1));
  const auto bearing = lens.unproject(middle);
  require(bearing.has_value(), "make_fleet: the level's lens does not reach its picture's middle");
  const Vec3 aim = (target - place).normalized();
  const Eigen::Quaterniond roll(Eigen::AngleAxisd(random.uniform(-0.05, 0.05), aim));
  return {roll * rotation_between(*bearing, aim), place};
}

/// To the right, to the left, farther right, ...
double step_aside(int number) {
  return kBesideEachOther * ((number + 1) / 2) * (number % 2 == 1 ? 1 : -1);
}

bool has_whole_print(const Camera& lens, const Pose& rig_from_device, const World& world,
                     const Pose& rig_from_board) {
  PrintedBoard print = world.board;
  print.margin = 0;
  const Pose device_from_board = rig_from_device.inverse() * rig_from_board;
  for (const Vec3& corner : sheet_corners_in_board(print)) {
    const auto pixel = lens.project(device_from_board * corner);
    if (!pixel || pixel->x() < kRimOfPicture || pixel->y() < kRimOfPicture ||
        pixel->x() > lens.size.width - 1 - kRimOfPicture || pixel->y() > lens.size.height - 1 - kRimOfPicture)
      return false;
  }
  // Towards the print, not too flat.
  const Vec3 eye_in_board = device_from_board.inverse().translation;
  return eye_in_board.z() < -0.5 * eye_in_board.norm();
}

Fleet::View seen_by(const Fleet& fleet, const Pose& rig_from_board) {
  Fleet::View view{rig_from_board, {}, {}};
  for (std::size_t c = 0; c < fleet.rig.cameras.size(); ++c)
    if (has_whole_print(fleet.rig.cameras[c].camera, fleet.rig.cameras[c].rig_from_camera, fleet.world,
                        rig_from_board))
      view.cameras.push_back(c);
  for (std::size_t p = 0; p < fleet.rig.projectors.size(); ++p)
    if (has_whole_print(fleet.rig.projectors[p].projector.inverse_camera,
                        fleet.rig.projectors[p].rig_from_projector, fleet.world, rig_from_board))
      view.projectors.push_back(p);
  return view;
}

std::string numbered_name(const std::string& kind, int number, int count) {
  return count == 1 ? kind : kind + "_" + std::to_string(number + 1);
}

/// Where the boards of a session were.
struct BoardRange {
  double nearest = 1e300, farthest = 0;  ///< from the rig, metres
  Vec3 middle = Vec3::Zero();            ///< mean of the boards' middles
};
BoardRange board_range(const SimulatedSession& session) {
  BoardRange range;
  for (const World& view : session.views) {
    const Vec3 middle = view.rig_from_board * middle_of(view.board.layout);
    range.nearest = std::min(range.nearest, middle.norm());
    range.farthest = std::max(range.farthest, middle.norm());
    range.middle += middle / double(session.views.size());
  }
  return range;
}

/// The first of each kind is the session's, the others copies beside it.
Rig make_fleet_rig(const Rig& base, int cameras, int projectors, const Vec3& target, Random& random) {
  Rig rig;
  for (int c = 0; c < cameras; ++c) {
    const RigCamera& first = base.camera();
    const Vec3 place(step_aside(c), random.uniform(-0.04, 0.04), random.uniform(-0.04, 0.04));
    RigCamera camera{numbered_name("camera", c, cameras), first.camera, Pose()};
    if (c > 0) {
      camera.camera = copy_of(first.camera, random);
      camera.rig_from_camera = looking_at(camera.camera, place, target, random);
    }
    rig.cameras.push_back(camera);
  }
  for (int p = 0; p < projectors; ++p) {
    RigProjector projector = base.projector();
    projector.name = numbered_name("projector", p, projectors);
    if (p > 0) {
      const Vec3 place = projector.rig_from_projector.translation + Vec3(-step_aside(p), 0.06, 0.03);
      projector.projector.inverse_camera = copy_of(projector.projector.inverse_camera, random);
      projector.rig_from_projector = looking_at(projector.projector.inverse_camera, place, target, random);
    }
    rig.projectors.push_back(projector);
  }
  return rig;
}

/// A board pose that all devices cover, or the camera of number `only` and a projector.
std::optional<Fleet::View> draw_view(const Fleet& fleet, const BoardRange& range,
                                     std::optional<std::size_t> only, Random& random) {
  const Vec3 middle_in_board = middle_of(fleet.world.board.layout);
  constexpr int kTries = 200000;
  for (int i = 0; i < kTries; ++i) {
    const double tilt_x = random.uniform(-0.6, 0.6), tilt_y = random.uniform(-0.6, 0.6),
                 roll = random.uniform(-0.4, 0.4);
    const double x = random.uniform(-0.6, 0.6), y = random.uniform(-0.25, 0.25),
                 z = random.uniform(range.nearest, range.farthest);
    const Eigen::Quaterniond rotation = so3_exp<double>(Vec3(tilt_x, tilt_y, roll));
    const Vec3 middle(range.middle.x() + x, range.middle.y() + y, z);
    Fleet::View view = seen_by(fleet, Pose(rotation, middle - rotation * middle_in_board));
    if (only) {
      if (std::count(view.cameras.begin(), view.cameras.end(), *only) == 0 || view.projectors.empty())
        continue;
      view.cameras = {*only};
      return view;
    }
    if (view.cameras.size() == fleet.rig.cameras.size() &&
        view.projectors.size() == fleet.rig.projectors.size())
      return view;
  }
  return std::nullopt;
}

}  // namespace

Fleet make_fleet(Level level, std::uint64_t seed, int cameras, int projectors) {
  return make_fleet(level, seed, cameras, projectors, level_conditions(level));
}

Fleet make_fleet(Level level, std::uint64_t seed, int cameras, int projectors, const Conditions& conditions) {
  require(cameras >= 1 && projectors >= 1, "make_fleet: there is one camera and one projector at least");
  const SimulatedSession base = make_session(level, seed, std::nullopt, std::nullopt, conditions);
  Random random(seed, std::uint64_t(level), 7);
  Fleet fleet;
  fleet.world = base.views.front();
  fleet.capture = base.capture;
  const BoardRange range = board_range(base);
  fleet.rig = make_fleet_rig(base.rig(), cameras, projectors, range.middle, random);
  for (int v = 0; v < std::max(8, 4 * cameras); ++v) {
    const bool alone = v % 2 == 1 && cameras > 1;
    const auto only = std::size_t((v / 2) % cameras);
    const auto view = draw_view(fleet, range, alone ? std::optional(only) : std::nullopt, random);
    if (!view)
      throw Error(ErrorKind::kNotConverged, "simulated fleet, view " + std::to_string(v),
                  "no board pose that its devices cover was found", "use another seed, or fewer devices");
    fleet.views.push_back(*view);
  }
  return fleet;
}

std::vector<ImageU8> capture_pair(const Fleet& fleet, std::size_t view, std::size_t camera,
                                  std::size_t projector, const std::vector<ImageU8>& frames) {
  require(view < fleet.views.size() && camera < fleet.rig.cameras.size() &&
              projector < fleet.rig.projectors.size(),
          "capture_pair: there is no such view, camera or projector");
  World world = fleet.world;
  world.rig.cameras = {fleet.rig.cameras[camera]};
  world.rig.projectors = {fleet.rig.projectors[projector]};
  world.rig_from_board = fleet.views[view].rig_from_board;
  CaptureOptions options = fleet.capture;
  options.seed = Random(fleet.capture.seed, view, 100 * camera + projector).next();
  return capture(world, frames, options);
}

}  // namespace procam::simulate
