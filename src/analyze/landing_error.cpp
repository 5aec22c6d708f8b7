#include "procam/analyze/landing_error.hpp"

#include <cmath>

#include "light_chain.hpp"
#include "procam/core/base/closed_form.hpp"
#include "procam/core/geometry/se3.hpp"

namespace procam::analyze {
namespace {

constexpr double kLargestIncidenceDeg = 75;
constexpr double kLargestSecondOrder = 0.1;  ///< of the rms error

/// A part of a covariance, by its rows and columns from `first` on.
Mat6 part_of(const Mat6& covariance, int first) {
  Mat6 part = Mat6::Zero();
  part.block<3, 3>(first, first) = covariance.block<3, 3>(first, first);
  return part;
}

LandingError::SourceError pose_source(const std::string& name,
                                      const Eigen::Matrix<double, 2, 6>& by_increment,
                                      const Mat6& covariance) {
  const auto spread = [&](const Mat6& c) -> Mat2 { return by_increment * c * by_increment.transpose(); };
  LandingError::SourceError source{name, Vec2::Zero(), spread(covariance), {}};
  source.parts = {{"position", Vec2::Zero(), spread(part_of(covariance, 3)), {}},
                  {"rotation", Vec2::Zero(), spread(part_of(covariance, 0)), {}}};
  return source;
}

/// Where the light of a pixel lands.
struct Landing {
  const LightPath& path;
  Vec2 pixel, on_surface;
};

/// Half the sum of what errors along +-each column of `root` do together, from exact landings: the second
/// derivative's trace.
template <typename Errors>
Vec2 second_order_of(const Landing& at, const MatX& root, const Errors& errors_of) {
  Vec2 sum = Vec2::Zero();
  for (Eigen::Index i = 0; i < root.cols(); ++i) {
    if (root.col(i).cwiseAbs().maxCoeff() == 0) continue;
    const auto forward = land(at.path, at.pixel, errors_of(VecX(root.col(i)))),
               back = land(at.path, at.pixel, errors_of(VecX(-root.col(i))));
    // Past the horizon no series holds: infinitely bad.
    if (!forward || !back) return Vec2::Constant(1e300);
    sum += 0.5 * (*forward + *back) - at.on_surface;
  }
  return sum;
}

/// The errors of the chain when one increment alone is wrong.
auto one_increment(Vec6 ChainErrors::*increment) {
  return [increment](const VecX& e) {
    ChainErrors errors;
    errors.*increment = e;
    return errors;
  };
}

void add_calibration(const CalibrationErrors& all, const ChainDerivatives& chain, const Landing& at,
                     LandingError& error) {
  const MatX by_all = all.landing_by(chain);
  const auto spread = [&](Eigen::Index first, Eigen::Index size) -> Mat2 {
    return by_all.middleCols(first, size) * all.covariance.block(first, first, size, size) *
           by_all.middleCols(first, size).transpose();
  };
  LandingError::SourceError calibration{"calibration", Vec2::Zero(), spread(0, by_all.cols()), {}};
  calibration.parts.push_back({"lens", Vec2::Zero(), spread(0, all.lens), {}});
  if (all.has_mount()) calibration.parts.push_back({"mount", Vec2::Zero(), spread(all.lens, 6), {}});
  const Eigen::Index camera = all.rig_by_camera.cols();
  if (camera > 0)
    calibration.parts.push_back({"camera", Vec2::Zero(), spread(by_all.cols() - camera, camera), {}});
  error.sources.push_back(calibration);
  error.second_order += second_order_of(at, square_root(all.covariance, "calibration"),
                                        [&](const VecX& e) { return all.chain_errors(e); });
}

struct PoseError {
  const char* name;
  const Eigen::Matrix<double, 2, 6>& by_increment;
  const Mat6& covariance;
  Vec6 ChainErrors::*increment;
};
void add_pose(const PoseError& pose, const Landing& at, LandingError& error) {
  const MatX root = square_root(pose.covariance, pose.name);
  if (pose.covariance.isZero(0)) return;
  error.sources.push_back(pose_source(pose.name, pose.by_increment, pose.covariance));
  error.second_order += second_order_of(at, root, one_increment(pose.increment));
}

}  // namespace

bool LandingError::first_order_holds() const {
  return incidence_deg <= kLargestIncidenceDeg && second_order.norm() <= kLargestSecondOrder * total.rms();
}

std::optional<LandingError> landing_error(const LightPath& path, const ErrorSources& sources,
                                          const Vec2& on_surface) {
  require(sources.pixel_sigma >= 0 && std::isfinite(sources.pixel_sigma),
          "landing_error: the pixel's sigma must be finite and not negative");
  auto chain = chain_derivatives(path, on_surface);
  if (!chain) return std::nullopt;
  LandingError error;
  error.on_surface = on_surface;
  error.pixel = chain->pixel;
  error.incidence_deg = chain->incidence_deg;

  // The drive's mean may be large: it is followed exactly, and the spread taken where it leads.
  const MotionError motion = motion_error(sources.motion);
  LightPath at_mean = path;
  Vec2 landed = on_surface;
  if (path.through_pose && !motion.mean.isZero(0)) {
    at_mean.rig_from_surface = se3_exp(Vec6(-motion.mean)) * path.rig_from_surface;
    const auto moved = landing_place(at_mean, error.pixel);
    const auto chain_there = moved ? chain_derivatives(at_mean, *moved) : std::nullopt;
    if (!chain_there) return std::nullopt;  // it drives away from the surface
    landed = *moved;
    chain = chain_there;
  }
  const Landing landing{at_mean, error.pixel, landed};
  if (!sources.calibration.empty()) add_calibration(CalibrationErrors(path, sources), *chain, landing, error);
  if (path.through_pose)
    add_pose({"rig pose", chain->by_rig, sources.rig_pose, &ChainErrors::rig}, landing, error);
  add_pose({"map", chain->by_surface, sources.map, &ChainErrors::surface}, landing, error);
  if (path.through_pose && !(motion.mean.isZero(0) && motion.covariance.isZero(0))) {
    error.sources.push_back({"delay",
                             Vec2(landed - on_surface),
                             Mat2(chain->by_rig * motion.covariance * chain->by_rig.transpose()),
                             {}});
    error.second_order +=
        second_order_of(landing, square_root(motion.covariance, "delay"), one_increment(&ChainErrors::rig));
  }
  if (sources.pixel_sigma > 0)
    error.sources.push_back(
        {"pixels",
         Vec2::Zero(),
         Mat2(sources.pixel_sigma * sources.pixel_sigma * chain->by_pixel * chain->by_pixel.transpose()),
         {}});

  error.total.name = "total";
  for (const LandingError::SourceError& source : error.sources) {
    error.total.bias += source.bias;
    error.total.covariance += source.covariance;
  }
  return error;
}

Ellipse region95(const Mat2& covariance) {
  constexpr double kChiSquare95 = 5.991464547107979;  // -2 log 0.05
  const SymmetricEigen2 eigen = symmetric_eigen(covariance);
  return {std::sqrt(kChiSquare95 * std::max(eigen.values[0], 0.0)),
          std::sqrt(kChiSquare95 * std::max(eigen.values[1], 0.0)),
          std::atan2(eigen.vectors(1, 0), eigen.vectors(0, 0))};
}

}  // namespace procam::analyze
