#include "procam/analyze/prediction.hpp"

#include <algorithm>
#include <cmath>

#include "light_chain.hpp"
#include "procam/core/base/words.hpp"
#include "procam/core/geometry/homography.hpp"
#include "procam/core/geometry/se3.hpp"

namespace procam::analyze {
namespace {

constexpr int kColumns = 24, kRows = 16;
constexpr double kToDegrees = 1 / kDegree;

std::optional<LandingError> error_at(const LightPath& path, const ErrorSources& sources,
                                     const Mat3& plane_from_content, const Vec2& content) {
  const auto on_surface = Homography(plane_from_content).apply(content);
  if (!on_surface) return std::nullopt;
  auto error = landing_error(path, sources, *on_surface);
  if (error && !path.projector.projector.size().contains(error->pixel)) return std::nullopt;
  return error;
}

/// What cannot be split stays whole: the delay, the pixels.
std::vector<LandingError::SourceError> parts_of(const LandingError& error) {
  std::vector<LandingError::SourceError> parts;
  for (const LandingError::SourceError& source : error.sources) {
    // Lens and mount of one calibration lean on each other: apart they look far worse than they are.
    if (source.parts.empty() || source.name == "calibration") {
      parts.push_back(source);
      continue;
    }
    for (LandingError::SourceError part : source.parts) {
      part.name = source.name + ": " + part.name;
      parts.push_back(part);
    }
  }
  return parts;
}

double squared(const LandingError::SourceError& source) {
  return source.rms() * source.rms();
}

}  // namespace

std::vector<Cause> rank_causes(const std::vector<const LandingError*>& lit) {
  require(!lit.empty(), "rank_causes: no points");
  std::vector<Cause> causes;
  for (const LandingError::SourceError& part : parts_of(*lit.front())) causes.push_back({part.name, 0, 0});
  for (const LandingError* error : lit) {
    const std::vector<LandingError::SourceError> parts = parts_of(*error);
    require(parts.size() == causes.size(), "rank_causes: points of different sources");
    for (std::size_t i = 0; i < parts.size(); ++i) {
      causes[i].rms_mm += squared(parts[i]);
      LandingError::SourceError rest = error->total;
      rest.bias -= parts[i].bias;
      rest.covariance -= parts[i].covariance;
      causes[i].without_mm += std::max(rest.bias.squaredNorm() + rest.covariance.trace(), 0.0);
    }
  }
  for (Cause& cause : causes) {
    cause.rms_mm = 1e3 * std::sqrt(cause.rms_mm / double(lit.size()));
    cause.without_mm = 1e3 * std::sqrt(cause.without_mm / double(lit.size()));
  }
  causes.erase(std::remove_if(causes.begin(), causes.end(), [](const Cause& c) { return c.rms_mm == 0; }),
               causes.end());
  std::sort(causes.begin(), causes.end(), [](const Cause& a, const Cause& b) { return a.rms_mm > b.rms_mm; });
  return causes;
}

namespace {

std::string advice_for(const SurfacePrediction& prediction, const ErrorSources& sources) {
  const auto best =
      std::min_element(prediction.causes.begin(), prediction.causes.end(),
                       [](const Cause& a, const Cause& b) { return a.without_mm < b.without_mm; });
  if (best == prediction.causes.end() || prediction.rms_mm == 0)
    return "nothing is uncertain: no source was given";
  const std::string effect = " would bring " + fixed(prediction.rms_mm, 1) + " mm down to at best " +
                             fixed(best->without_mm, 1) + " mm";
  if (best->name == "delay")
    return (sources.motion.predicted ? "a shorter delay, or a better known speed,"
                                     : "predicting the pose to the moment of light (--with-prediction)") +
           effect;
  if (best->name == "rig pose: rotation")
    return "a better known direction of the robot (a marker on the surface, a gyro)" + effect;
  if (best->name == "rig pose: position") return "a better known position of the robot" + effect;
  if (best->name.rfind("map", 0) == 0)
    return "measuring the surface itself (depth sensor, marker on it, verify-projection)" + effect;
  if (best->name == "pixels") return "a finer projector, or one that stands closer," + effect;
  return "a better calibration (its report names the next view)" + effect;
}

double rms_mm_at(const LightPath& path, const ErrorSources& sources, const Vec2& on_surface) {
  const auto error = landing_error(path, sources, on_surface);
  return error ? 1e3 * error->total.rms() : -1;
}

template <typename Value>
Sweep sweep(const char* name, const char* unit, double here, double lowest, double highest,
            const Value& rms_at) {
  Sweep curve{name, unit, here, {}, {}};
  constexpr int kPoints = 33;
  for (int i = 0; i < kPoints; ++i) {
    const double value = lowest + (highest - lowest) * i / (kPoints - 1);
    const double rms = rms_at(value);
    if (!(rms >= 0) || !std::isfinite(rms)) continue;
    curve.values.push_back(value);
    curve.rms_mm.push_back(rms);
  }
  return curve;
}

/// The light's own way: the projector's ray to the point, and the surface pushed along it or turned about the
/// point across it.
LightPath pushed(LightPath path, const Vec3& light_in_rig, double metres) {
  path.rig_from_surface = Pose(Eigen::Quaterniond::Identity(), metres * light_in_rig) * path.rig_from_surface;
  return path;
}

std::vector<Sweep> sweeps_of(const LightPath& path, const ErrorSources& sources, const Vec2& middle) {
  const Vec3 point = path.rig_from_surface * Vec3(middle.x(), middle.y(), 0);
  const Vec3 from_lens = point - path.projector.rig_from_projector.translation;
  const double distance = from_lens.norm();
  const Vec3 light = from_lens / distance;
  Vec3 normal = path.rig_from_surface.rotate(Vec3::UnitZ());
  if (normal.dot(light) < 0) normal = -normal;
  const double incidence = std::acos(std::min(normal.dot(light), 1.0));
  const Vec3 hinge = incidence > 1e-3 ? Vec3(light.cross(normal).normalized()) : Vec3(light.unitOrthogonal());

  std::vector<Sweep> curves;
  curves.push_back(sweep("distance", "m", distance, 0.4 * distance, 2.5 * distance, [&](double d) {
    return rms_mm_at(pushed(path, light, d - distance), sources, middle);
  }));
  curves.push_back(sweep("incidence", "deg", incidence * kToDegrees, 0, 80, [&](double degrees) {
    LightPath turned = path;
    const Pose about(so3_exp(Vec3(hinge * (degrees / kToDegrees - incidence))), Vec3::Zero());
    turned.rig_from_surface = Pose(Eigen::Quaterniond::Identity(), point) * about *
                              Pose(Eigen::Quaterniond::Identity(), -point) * path.rig_from_surface;
    return rms_mm_at(turned, sources, middle);
  }));
  if (!path.through_pose) return curves;
  const auto scaled_pose = [&](double factor) {
    ErrorSources changed = sources;
    changed.rig_pose *= factor * factor;
    return rms_mm_at(path, changed, middle);
  };
  if (!sources.rig_pose.isZero(0))
    curves.push_back(sweep("localisation sigma", "times what it is", 1, 0, 3, scaled_pose));
  const RobotMotion& motion = sources.motion;
  const double speed = motion.twist.tail<3>().norm();
  if (motion.delay > 0 && !motion.twist.isZero(0)) {
    curves.push_back(sweep("speed", speed > 0 ? "m/s, turning in proportion" : "times what it is",
                           speed > 0 ? speed : 1, 0, 3 * (speed > 0 ? speed : 1), [&](double value) {
                             ErrorSources changed = sources;
                             changed.motion.twist *= value / (speed > 0 ? speed : 1);
                             return rms_mm_at(path, changed, middle);
                           }));
    curves.push_back(sweep("delay", "ms", 1e3 * motion.delay, 0, 3e3 * motion.delay, [&](double ms) {
      ErrorSources changed = sources;
      changed.motion.delay = 1e-3 * ms;
      return rms_mm_at(path, changed, middle);
    }));
  }
  return curves;
}

/// On the surface: the lit point nearest to the content's middle. There is one.
Vec2 lit_middle(const SurfacePrediction& prediction) {
  Vec2 middle = Vec2::Zero();
  double nearest = 1e300;
  for (std::size_t i = 0; i < prediction.grid.size(); ++i) {
    const double away = (prediction.content[i] - Vec2(0.5, 0.5)).norm();
    if (!prediction.grid[i] || away >= nearest) continue;
    nearest = away;
    middle = prediction.grid[i]->on_surface;
  }
  return middle;
}

/// The same errors by Monte Carlo, at the lit points of the grid.
void add_draws(const LightPath& path, const ErrorSources& sources, const MonteCarloOptions& draws,
               const std::vector<const LandingError*>& lit, SurfacePrediction& prediction) {
  Points2 points;
  for (const LandingError* error : lit) points.push_back(error->on_surface);
  const auto drawn = monte_carlo_landing(path, sources, points, draws);
  std::vector<std::optional<LandingSpread>> on_grid(prediction.grid.size());
  std::size_t next = 0;
  for (std::size_t i = 0; i < prediction.grid.size(); ++i)
    if (prediction.grid[i]) on_grid[i] = drawn[next++];
  merge_draws({on_grid}, prediction);
}

void remark(SurfacePrediction& prediction, const std::vector<const LandingError*>& lit) {
  if (prediction.lit_share < 1)
    prediction.diagnostics.warn("not_lit", "the projector's picture misses " +
                                               fixed(100 * (1 - prediction.lit_share), 0) +
                                               " % of the content: these points are not in the numbers");
  int failed = 0;
  for (const LandingError* error : lit) failed += !error->first_order_holds();
  if (prediction.incidence_deg > 75)
    prediction.diagnostics.warn("grazing", "light meets the surface at up to " +
                                               fixed(prediction.incidence_deg, 1) +
                                               " degrees: the closed form is of first order and fails beyond "
                                               "75; trust --monte-carlo there");
  else if (failed > 0)
    prediction.diagnostics.warn(
        "first_order",
        fixed(100.0 * failed / double(lit.size()), 0) +
            " % of the points have errors too large for first order; trust --monte-carlo there");
}

}  // namespace

void merge_draws(const std::vector<std::vector<std::optional<LandingSpread>>>& parts,
                 SurfacePrediction& prediction) {
  require(!parts.empty(), "merge_draws: no part");
  for (const auto& part : parts)
    require(part.size() == prediction.grid.size(), "merge_draws: a part of another grid");
  prediction.drawn.assign(prediction.grid.size(), std::nullopt);
  double squares = 0;
  int lit = 0;
  for (std::size_t i = 0; i < prediction.grid.size(); ++i) {
    if (!prediction.grid[i]) continue;
    ++lit;
    std::vector<LandingSpread> of_point;
    for (const auto& part : parts)
      if (part[i]) of_point.push_back(*part[i]);
    if (of_point.empty()) continue;
    prediction.drawn[i] = merged(of_point);
    squares += prediction.drawn[i]->rms() * prediction.drawn[i]->rms();
  }
  prediction.drawn_rms_mm = 1e3 * std::sqrt(squares / double(std::max(lit, 1)));
}

SurfacePrediction predict_surface(const std::string& name, const LightPath& path,
                                  const Mat3& plane_from_content, const ErrorSources& sources,
                                  const std::optional<MonteCarloOptions>& draws) {
  SurfacePrediction prediction;
  prediction.surface = name;
  prediction.columns = kColumns;
  prediction.rows = kRows;
  for (int j = 0; j < kRows; ++j)
    for (int i = 0; i < kColumns; ++i)
      prediction.content.emplace_back((i + 0.5) / kColumns, (j + 0.5) / kRows);
  const Homography placed(plane_from_content);
  const auto left = placed.apply(Vec2(0, 0.5)), right = placed.apply(Vec2(1, 0.5)),
             above = placed.apply(Vec2(0.5, 0)), below = placed.apply(Vec2(0.5, 1));
  if (left && right && above && below)
    prediction.size = Vec2((*right - *left).norm(), (*below - *above).norm());
  std::vector<const LandingError*> lit;
  for (const Vec2& content : prediction.content)
    prediction.grid.push_back(error_at(path, sources, plane_from_content, content));
  const Vec2 corners[] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  for (const Vec2& corner : corners) {
    prediction.corners.push_back(error_at(path, sources, plane_from_content, corner));
    if (const auto at = placed.apply(corner))
      prediction.corners_in_rig.push_back(path.rig_from_surface * Vec3(at->x(), at->y(), 0));
  }
  const auto note_worst = [&](const LandingError& error, const Vec2& content) {
    prediction.incidence_deg = std::max(prediction.incidence_deg, error.incidence_deg);
    if (1e3 * error.total.rms() <= prediction.worst_mm) return;
    prediction.worst_mm = 1e3 * error.total.rms();
    prediction.worst_content = content;
  };
  double sum = 0;
  for (std::size_t i = 0; i < prediction.grid.size(); ++i) {
    if (!prediction.grid[i]) continue;
    lit.push_back(&*prediction.grid[i]);
    sum += squared(lit.back()->total);
    note_worst(*lit.back(), prediction.content[i]);
  }
  const Pose projector_from_rig = path.projector.rig_from_projector.inverse();
  const bool behind = std::all_of(prediction.corners_in_rig.begin(), prediction.corners_in_rig.end(),
                                  [&](const Vec3& at) { return (projector_from_rig * at).z() <= 0; });
  if (lit.empty())
    throw Error(ErrorKind::kDegenerate, "surface '" + name + "'",
                behind ? "it lies behind the projector" : "the projector's picture lights no point of it",
                "look at it with solve-surfaces; turn the projector or move the surface");
  for (int i = 0; i < 4; ++i)
    if (prediction.corners[std::size_t(i)]) note_worst(*prediction.corners[std::size_t(i)], corners[i]);
  prediction.lit_share = double(lit.size()) / double(prediction.grid.size());
  prediction.rms_mm = 1e3 * std::sqrt(sum / double(lit.size()));
  prediction.causes = rank_causes(lit);
  prediction.advice = advice_for(prediction, sources);
  prediction.sweeps = sweeps_of(path, sources, lit_middle(prediction));
  if (draws) add_draws(path, sources, *draws, lit, prediction);
  remark(prediction, lit);
  return prediction;
}

}  // namespace procam::analyze
