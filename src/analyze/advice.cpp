#include "procam/analyze/advice.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "light_error_model.hpp"
#include "procam/calibrate/next_view.hpp"
#include "procam/core/base/words.hpp"

namespace procam::analyze {
namespace {

using calibrate::CalibrationResult;

constexpr double kTiltDeg = 35;

Vec3 middle_of(const Points3& points) {
  Vec3 middle = Vec3::Zero();
  for (const Vec3& p : points) middle += p / double(points.size());
  return middle;
}

std::string metres(double value) {
  return fixed(value, 2) + " m";
}

/// Right and down to a word: "upper left", "right", "middle". Less than `still` of the larger counts as none.
std::string towards(const Vec2& right_down, double still, const std::string& nowhere) {
  const double largest = right_down.cwiseAbs().maxCoeff();
  if (!(largest > 1e-9)) return nowhere;
  std::string word;
  if (std::abs(right_down.y()) > still * largest) word = right_down.y() > 0 ? "lower" : "upper";
  if (std::abs(right_down.x()) > still * largest)
    word += (word.empty() ? "" : " ") + std::string(right_down.x() > 0 ? "right" : "left");
  return word;
}

struct Place {
  Pose rig_from_board;
  double distance = 0;
  Vec2 in_picture;  ///< steps from the middle of the projector's picture, -1, 0, 1
  std::optional<Vec2>
      nearest;  ///< of the board's sides, as the camera sees it: right and down; none: untilted
};

/// A board at a place, facing the rig's origin and then tilted so that its side in direction `nearest` comes
/// nearer. `level` is the direction of the board's x axis that the views so far have.
Pose placed(const Vec3& at, const Vec3& level, const Vec3& middle_in_board,
            const std::optional<Vec2>& nearest) {
  const Vec3 sight = at.normalized();
  const Vec3 down = sight.cross(level).normalized(), right = down.cross(sight);
  Mat3 facing;
  facing << right, down, sight;
  Eigen::Quaterniond rotation(facing);
  if (nearest) {
    // With a = sight x side, a x side = -sight: a turn about a brings that side nearer.
    const Vec3 axis = sight.cross(facing * Vec3(nearest->x(), nearest->y(), 0));
    rotation = Eigen::Quaterniond(Eigen::AngleAxisd(kTiltDeg * kDegree, axis)) * rotation;
  }
  return {rotation, at - rotation * middle_in_board};
}

std::vector<Place> places(const CalibrationResult& result, const RigProjector& projector) {
  const Points3& points = result.solved.state.points_in_board;
  const Vec3 middle = middle_of(points);
  double near = 1e300, far = 0;
  Vec3 level = Vec3::Zero();
  for (const calibrate::ViewResult& view : result.views) {
    if (!view.used) continue;
    const double distance = (view.rig_from_board * middle).norm();
    near = std::min(near, distance), far = std::max(far, distance);
    const Vec3 x = view.rig_from_board.rotate(Vec3::UnitX());
    level += x.dot(level) < 0 ? Vec3(-x) : x;
  }
  std::vector<Place> all;
  if (!(far > 0) || level.norm() < 1e-6) return all;
  constexpr int kDistances = 5;
  const ImageSize size = projector.projector.size();
  for (int i = 0; i < kDistances; ++i) {
    const double distance = 0.7 * near * std::pow(1.3 * far / (0.7 * near), i / double(kDistances - 1));
    for (int row = -1; row <= 1; ++row)
      for (int column = -1; column <= 1; ++column) {
        const Vec2 pixel((0.5 + 0.28 * column) * size.width, (0.5 + 0.28 * row) * size.height);
        const auto emitted = projector.projector.emit(pixel);
        if (!emitted) continue;
        const Ray ray = projector.rig_from_projector * *emitted;
        // |origin + s direction| = distance, the far root
        const double b = ray.origin.dot(ray.direction);
        const double root = b * b - ray.origin.squaredNorm() + distance * distance;
        if (root < 0) continue;
        const Vec3 at = ray.at(-b + std::sqrt(root));
        if (!(at.z() > 0)) continue;
        const Vec2 in_picture(column, row);
        all.push_back({placed(at, level, middle, std::nullopt), distance, in_picture, std::nullopt});
        for (int turn = 0; turn < 8; ++turn) {
          const Vec2 side(std::cos(turn * 45 * kDegree), std::sin(turn * 45 * kDegree));
          all.push_back({placed(at, level, middle, side), distance, in_picture, side});
        }
      }
  }
  return all;
}

std::string words_of(const Place& place, const std::string& projector) {
  std::string where = towards(place.in_picture, 0.5, "middle");
  if (where != "middle" && where.find(' ') == std::string::npos) where += " part";
  std::string words = metres(place.distance) + " away, in the " + where + " of " + projector + "'s frame, ";
  if (!place.nearest) return words + "facing the camera";
  const std::string side = towards(*place.nearest, 0.5, "");
  words += "tilted " + fixed(kTiltDeg, 0) + " degrees";
  if (side == "left" || side == "right") words += " about its vertical axis";
  if (side == "upper" || side == "lower") words += " about its horizontal axis";
  const bool corner = side.find(' ') != std::string::npos;
  return words + ", its " + side + (corner ? " corner" : " edge") + " nearest to the camera";
}

/// Of a device's points of one view.
struct Spot {
  int used = 0;
  double reach = 0;  ///< farthest from the picture's middle, over the half diagonal
};

}  // namespace

std::optional<NextView> advise_next_view(const CalibrationResult& result, double wall,
                                         const std::string& projector, SurfaceLocated located) {
  const RigProjector& device = result.rig.projector(projector);
  const std::vector<Place> candidates = places(result, device);
  std::vector<Pose> poses;
  for (const Place& place : candidates) poses.push_back(place.rig_from_board);
  const auto covariances = calibrate::covariance_with_view(result, poses);
  auto model = light_error_model(result.rig, wall, device.name, located);
  if (!model) model = light_error_model(result.rig, wall, device.name, SurfaceLocated::kExternally);
  double smallest_mm = model->rms_mm(result.rig.covariance);
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if (!covariances[i]) continue;
    const double mm = model->rms_mm(*covariances[i]);
    if (mm < smallest_mm) smallest_mm = mm, best = i;
  }
  if (!best) return std::nullopt;
  Rig rig = result.rig;
  rig.covariance = *covariances[*best];
  return NextView{
      candidates[*best].rig_from_board, candidates[*best].distance, words_of(candidates[*best], device.name),
      predicted_light_errors(result.rig, wall, device.name), predicted_light_errors(rig, wall, device.name)};
}

std::vector<std::string> view_verdicts(const CalibrationResult& result) {
  constexpr double kFew = 0.5;           // of what the fullest view has
  constexpr double kCentral = 0.35;      // of the half diagonal
  constexpr double kParallelDeg = 5;     // between the boards
  constexpr double kSameDistance = 0.1;  // of the distance
  constexpr double kLittle = 0.25;       // of an equal share
  const std::size_t views = result.views.size(), devices = result.devices.size();
  std::vector<std::vector<Spot>> spots(views, std::vector<Spot>(devices));
  std::vector<int> fullest(devices, 0);
  for (const calibrate::Residual& r : result.residuals) {
    if (!r.used) continue;
    Spot& spot = spots[std::size_t(r.view)][std::size_t(r.device)];
    fullest[std::size_t(r.device)] = std::max(fullest[std::size_t(r.device)], ++spot.used);
    const ImageSize size = result.devices[std::size_t(r.device)].size;
    const Vec2 half(0.5 * size.width, 0.5 * size.height);
    spot.reach = std::max(spot.reach, (r.pixel - half).norm() / half.norm());
  }
  const Vec3 middle = middle_of(result.solved.state.points_in_board);
  std::vector<std::string> verdicts;
  for (std::size_t v = 0; v < views; ++v) {
    const calibrate::ViewResult& view = result.views[v];
    std::vector<std::string> wrong;
    if (!view.used) {
      verdicts.emplace_back("not used");
      continue;
    }
    for (std::size_t d = 0; d < devices; ++d) {
      const Spot& spot = spots[v][d];
      const std::string& name = result.devices[d].name;
      if (spot.used == 0)
        wrong.push_back("nothing of " + name);
      else if (spot.used < kFew * fullest[d])
        wrong.push_back("few points for " + name + " (" + std::to_string(spot.used) + ", others up to " +
                        std::to_string(fullest[d]) + ")");
      else if (spot.reach < kCentral)
        wrong.push_back("all points near the centre of " + name +
                        "'s image; move the board towards the edges");
    }
    for (std::size_t other = 0; other < v; ++other) {
      const calibrate::ViewResult& earlier = result.views[other];
      if (!earlier.used) continue;
      const double cosine =
          view.rig_from_board.rotate(Vec3::UnitZ()).dot(earlier.rig_from_board.rotate(Vec3::UnitZ()));
      const double here = (view.rig_from_board * middle).norm(),
                   there = (earlier.rig_from_board * middle).norm();
      if (cosine < std::cos(kParallelDeg * kDegree) || std::abs(here - there) > kSameDistance * there)
        continue;
      wrong.push_back("parallel to " + earlier.name + " and as far away");
      break;
    }
    const double equal = 1.0 / std::max(1, result.rig.quality.views_used);
    if (view.share < kLittle * equal)
      wrong.push_back("contributes only " + fixed(100 * view.share, 1) + " % of the total information");
    std::string verdict;
    for (const std::string& one : wrong) verdict += (verdict.empty() ? "" : "; ") + one;
    verdicts.push_back(verdict.empty() ? "fine" : verdict);
  }
  return verdicts;
}

}  // namespace procam::analyze
