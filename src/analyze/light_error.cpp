#include "procam/analyze/light_error.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "light_chain.hpp"
#include "light_error_model.hpp"
#include "procam/core/geometry/se3.hpp"

namespace procam::analyze {
namespace {

constexpr int kGridColumns = 17, kGridRows = 13;
/// Of the grid. A pose from less says little of the rest of the picture.
constexpr double kMinShareSeen = 0.1;

Points2 picture_grid(ImageSize size) {
  Points2 pixels;
  for (int j = 0; j < kGridRows; ++j)
    for (int i = 0; i < kGridColumns; ++i)
      pixels.emplace_back((size.width - 1) * i / (kGridColumns - 1.0),
                          (size.height - 1) * j / (kGridRows - 1.0));
  return pixels;
}

LightPath path_to_wall(const RigProjector& device, double distance) {
  return light_path(device, device.rig_from_projector * Plane{-Vec3::UnitZ(), distance});
}

/// Where the grid's pixels fall on the wall, metres along its axes.
Points2 lit_points(const LightPath& path) {
  Points2 points;
  for (const Vec2& pixel : picture_grid(path.projector.projector.size()))
    if (const auto on_wall = landing_place(path, pixel)) points.push_back(*on_wall);
  return points;
}

Vec3 in_space(const Vec2& on_wall) {
  return Vec3(on_wall.x(), on_wall.y(), 0);
}

Points2 seen_points(const RigCamera& camera, const LightPath& path, const Points2& on_wall) {
  const Pose camera_from_wall = camera.rig_from_camera.inverse() * path.rig_from_surface;
  Points2 seen;
  for (const Vec2& point : on_wall)
    if (camera.camera.sees(camera_from_wall * in_space(point))) seen.push_back(point);
  return seen;
}

struct Locator {
  const RigCamera* camera = nullptr;
  Points2 seen;
  double share = 0;  ///< of the grid
};

/// The camera that sees most of the light on the wall; nullopt when that is too little.
std::optional<Locator> camera_that_locates(const Rig& rig, const LightPath& path) {
  const Points2 points = lit_points(path);
  Locator best;
  for (const RigCamera& camera : rig.cameras) {
    Points2 seen = seen_points(camera, path, points);
    if (seen.size() > best.seen.size()) best = {&camera, std::move(seen), 0};
  }
  best.share = double(best.seen.size()) / (kGridColumns * kGridRows);
  if (best.share < kMinShareSeen) return std::nullopt;
  return best;
}

/// Normal equations of a pose from known points: A = d pixel / d camera_from_wall (left increment), B = d
/// pixel / d lens.
struct PoseEquations {
  Mat6 a_a = Mat6::Zero();                       ///< A^T A
  Eigen::Matrix<double, 6, Eigen::Dynamic> a_b;  ///< A^T B
  Vec6 a_residual = Vec6::Zero();                ///< A^T (seen - projected)
};

/// `seen` is empty, or holds the pixel of every point. nullopt when the lens cannot image one of them.
std::optional<PoseEquations> pose_equations(const Camera& lens, const Pose& camera_from_wall,
                                            const Points2& on_wall, const Points2& seen) {
  PoseEquations sum;
  sum.a_b.setZero(6, parameters_of(lens).size());
  for (std::size_t i = 0; i < on_wall.size(); ++i) {
    const Vec3 point = camera_from_wall * in_space(on_wall[i]);
    const auto pixel = pixel_derivatives(lens, point);
    if (!pixel) return std::nullopt;
    Eigen::Matrix<double, 3, 6> by_increment;
    by_increment << -hat(point), Mat3::Identity();
    const Eigen::Matrix<double, 2, 6> a = pixel->by_point * by_increment;
    sum.a_a += a.transpose() * a;
    sum.a_b += a.transpose() * pixel->by_lens;
    if (!seen.empty()) sum.a_residual += a.transpose() * (seen[i] - pixel->pixel);
  }
  return sum;
}

/// The pose that a camera with this lens computes from the pixels of known points (Gauss-Newton from
/// `start`).
std::optional<Pose> located_wall(const Camera& lens, const Pose& start, const Points2& on_wall,
                                 const Points2& seen) {
  constexpr int kMaxSteps = 30;
  constexpr double kConverged = 1e-12;  // radians, metres
  Pose camera_from_wall = start;
  for (int step = 0; step < kMaxSteps; ++step) {
    const auto equations = pose_equations(lens, camera_from_wall, on_wall, seen);
    if (!equations) return std::nullopt;
    const Vec6 change = equations->a_a.ldlt().solve(equations->a_residual);
    if (!change.allFinite()) return std::nullopt;
    camera_from_wall = se3_exp<double>(change) * camera_from_wall;
    if (change.norm() < kConverged) break;
  }
  return camera_from_wall;
}

/// Figures over a list of distances, metres.
LightError summarised(LightError error, const std::vector<double>& distances) {
  double sum = 0, squares = 0;
  for (const double distance : distances) {
    const double mm = 1e3 * distance;
    sum += mm, squares += mm * mm;
    error.worst_mm = std::max(error.worst_mm, mm);
  }
  error.mean_mm = sum / double(distances.size());
  error.rms_mm = std::sqrt(squares / double(distances.size()));
  return error;
}

LightErrorMap true_map_externally(const RigProjector& estimated, const RigProjector& truth, double distance) {
  const Plane wall = truth.rig_from_projector * Plane{-Vec3::UnitZ(), distance};
  LightErrorMap map;
  map.columns = kGridColumns, map.rows = kGridRows;
  std::vector<double> distances;
  for (const Vec2& pixel : picture_grid(truth.projector.size())) {
    const auto ray = estimated.projector.emit(pixel), true_ray = truth.projector.emit(pixel);
    if (!ray || !true_ray) continue;
    const auto at = intersect(estimated.rig_from_projector * *ray, wall),
               true_at = intersect(truth.rig_from_projector * *true_ray, wall);
    if (!at || !true_at) continue;
    distances.push_back((*at - *true_at).norm());
    map.pixels.push_back(pixel);
    map.rms_mm.push_back(1e3 * distances.back());
  }
  map.error = summarised({distance, 0, 0, 0, estimated.name}, distances);
  return map;
}

/// Of that name in both rigs; in rigs with one projector each, their only ones.
std::pair<const RigProjector&, const RigProjector&> same_projector(const Rig& estimated, const Rig& truth,
                                                                   const std::string& name) {
  const RigProjector &device = estimated.projector(name), &known = truth.projector(name);
  if (device.projector.size() != known.projector.size())
    throw Error(ErrorKind::kInput, "the true rig", "its projector has another size than the estimated one",
                "compare rigs of the same session");
  return {device, known};
}

std::optional<LightError> true_error_by_camera(const Rig& estimated, const Rig& truth,
                                               const RigProjector& projector,
                                               const RigProjector& true_projector, double distance) {
  const LightPath path = path_to_wall(true_projector, distance);
  const auto locator = camera_that_locates(truth, path);
  if (!locator) return std::nullopt;
  const RigCamera& true_camera = *locator->camera;
  const RigCamera& camera = estimated.camera(estimated.cameras.size() > 1 ? true_camera.name : "");
  const Pose true_camera_from_wall = true_camera.rig_from_camera.inverse() * path.rig_from_surface;
  Points2 seen;
  for (const Vec2& point : locator->seen)
    seen.push_back(*true_camera.camera.project(true_camera_from_wall * in_space(point)));
  const auto camera_from_wall = located_wall(camera.camera, true_camera_from_wall, locator->seen, seen);
  if (!camera_from_wall) return std::nullopt;
  const Pose projector_from_wall =
      projector.rig_from_projector.inverse() * camera.rig_from_camera * *camera_from_wall;
  std::vector<double> distances;
  for (const Vec2& point : locator->seen) {
    const auto pixel = projector.projector.project(projector_from_wall * in_space(point));
    const auto at = pixel ? landing_place(path, *pixel) : std::nullopt;
    if (at) distances.push_back((*at - point).norm());
  }
  return summarised(
      {distance, 0, 0, 0, projector.name, SurfaceLocated::kByCamera, camera.name, locator->share}, distances);
}

}  // namespace

const char* to_string(SurfaceLocated located) {
  return located == SurfaceLocated::kByCamera ? "by camera" : "externally";
}

double LightErrorModel::rms_mm(const NamedCovariance& covariance) const {
  return 1e3 * std::sqrt(mean_square.cwiseProduct(covariance.block(names)).sum());
}

namespace {

/// Of z^T L z, z unit normal numbers and L of the same eigenvalues as `weights`. The quantile of the
/// chi-squared distribution is E. Wilson and M. Hilferty's (1931): 1.2 % too small in its root for one degree
/// of freedom, less for more.
double quantile95(const MatX& weights) {
  const MatX squared = weights * weights;
  const double first = weights.trace(), second = squared.trace(),
               third = squared.cwiseProduct(weights.transpose()).sum();
  if (!(second > 0) || !(third > 0)) return first;
  constexpr double kNormal95 = 1.6448536269514722;
  const double freedom = second * second * second / (third * third);
  const double ninth = 2 / (9 * freedom);
  const double quantile = freedom * std::pow(1 - ninth + kNormal95 * std::sqrt(ninth), 3);
  return first + third / second * (quantile - freedom);
}

}  // namespace

LightError LightErrorModel::under(const NamedCovariance& covariance) const {
  const MatX block = covariance.block(names);
  LightError error = kind;
  error.rms_mm = 1e3 * std::sqrt(mean_square.cwiseProduct(block).sum());
  error.rms95_mm = 1e3 * std::sqrt(quantile95(mean_square * block));
  for (const MatX& by_all : by_parameters)
    error.worst_mm = std::max(error.worst_mm, 1e3 * std::sqrt((by_all * block * by_all.transpose()).trace()));
  return error;
}

std::optional<LightErrorModel> light_error_model(const Rig& rig, double distance,
                                                 const std::string& projector, SurfaceLocated located) {
  require(distance > 0, "predicted_light_errors: distance must be positive");
  const RigProjector& device = rig.projector(projector);
  LightPath path = path_to_wall(device, distance);
  LightErrorModel model;
  model.kind = {distance, 0, 0, 0, device.name};
  ErrorSources sources;
  sources.calibration = rig.covariance;
  Points2 points;
  if (located == SurfaceLocated::kExternally) {
    points = lit_points(path);
  } else {
    const auto locator = camera_that_locates(rig, path);
    if (!locator) return std::nullopt;
    const RigCamera& camera = *locator->camera;
    points = locator->seen;
    model.kind.located = located;
    model.kind.camera = camera.name;
    model.kind.share = locator->share;
    const auto equations =
        pose_equations(camera.camera, camera.rig_from_camera.inverse() * path.rig_from_surface, points, {});
    if (!equations) return std::nullopt;
    // The wall is the world that the camera locates: d camera_from_wall = -(A^T A)^-1 A^T B d lens.
    path.through_pose = true;
    set_measured_pose(sources, camera, Mat6::Zero(), -equations->a_a.ldlt().solve(equations->a_b));
  }
  const CalibrationErrors errors(path, sources);
  model.names = errors.names;
  model.mean_square = MatX::Zero(errors.covariance.cols(), errors.covariance.cols());
  for (const Vec2& point : points) {
    const auto chain = chain_derivatives(path, point);
    if (!chain) continue;
    model.pixels.push_back(chain->pixel);
    model.by_parameters.push_back(errors.landing_by(*chain));
    model.mean_square += model.by_parameters.back().transpose() * model.by_parameters.back();
  }
  model.mean_square /= double(model.by_parameters.size());
  return model;
}

LightErrors predicted_light_errors(const Rig& rig, double distance, const std::string& projector) {
  LightErrors errors;
  errors.externally = predicted_light_error(rig, distance, projector);
  if (const auto model = light_error_model(rig, distance, projector, SurfaceLocated::kByCamera))
    errors.by_camera = model->under(rig.covariance);
  return errors;
}

LightError predicted_light_error(const Rig& rig, double distance, const std::string& projector) {
  return light_error_model(rig, distance, projector, SurfaceLocated::kExternally)->under(rig.covariance);
}

std::optional<LightErrorMap> predicted_error_map(const Rig& rig, double distance,
                                                 const std::string& projector, SurfaceLocated located) {
  const auto model = light_error_model(rig, distance, projector, located);
  if (!model) return std::nullopt;
  LightErrorMap map{model->under(rig.covariance), kGridColumns, kGridRows, model->pixels, {}};
  const MatX block = rig.covariance.block(model->names);
  for (const MatX& by_all : model->by_parameters)
    map.rms_mm.push_back(1e3 * std::sqrt((by_all * block * by_all.transpose()).trace()));
  return map;
}

LightErrors true_light_errors(const Rig& estimated, const Rig& truth, double distance,
                              const std::string& projector) {
  require(distance > 0, "true_light_errors: distance must be positive");
  const auto [device, known] = same_projector(estimated, truth, projector);
  return {true_map_externally(device, known, distance).error,
          true_error_by_camera(estimated, truth, device, known, distance)};
}

LightErrorMap true_error_map(const Rig& estimated, const Rig& truth, double distance,
                             const std::string& projector) {
  require(distance > 0, "true_error_map: distance must be positive");
  const auto [device, known] = same_projector(estimated, truth, projector);
  return true_map_externally(device, known, distance);
}

LightError true_light_error(const Rig& estimated, const Rig& truth, double distance,
                            const std::string& projector) {
  return true_light_errors(estimated, truth, distance, projector).externally;
}

WithinTruth parameters_within_truth(const Rig& estimated, const Rig& truth) {
  WithinTruth within;
  const auto count = [&](double difference, const std::string& name) {
    if (!estimated.covariance.index_of(name)) return;
    ++within.parameters;
    within.inside_3_sigma += std::abs(difference) <= 3 * estimated.covariance.sigma(name);
  };
  const auto count_device = [&](const std::string& device, const Camera& lens, const Camera& true_lens,
                                const Pose& pose, const Pose& true_pose) {
    const VecX difference = parameters_of(lens) - parameters_of(true_lens);
    const std::vector<std::string> names = parameter_names(lens);
    for (std::size_t i = 0; i < names.size(); ++i)
      count(difference[Eigen::Index(i)], device + "." + names[i]);
    const Vec6 xi = se3_log(true_pose * pose.inverse());
    const auto pose_names = pose_increment_names("rig_from_" + device);
    for (int i = 0; i < 6; ++i) count(xi[i], pose_names[std::size_t(i)]);
  };
  for (const RigCamera& camera : estimated.cameras) {
    const RigCamera& known = truth.camera(estimated.cameras.size() > 1 ? camera.name : "");
    count_device(camera.name, camera.camera, known.camera, camera.rig_from_camera, known.rig_from_camera);
  }
  for (const RigProjector& projector : estimated.projectors) {
    const RigProjector& known = truth.projector(estimated.projectors.size() > 1 ? projector.name : "");
    count_device(projector.name, projector.projector.inverse_camera, known.projector.inverse_camera,
                 projector.rig_from_projector, known.rig_from_projector);
  }
  return within;
}

}  // namespace procam::analyze
