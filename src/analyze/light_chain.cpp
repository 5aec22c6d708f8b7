#include "light_chain.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "procam/core/base/dual.hpp"
#include "procam/core/geometry/se3.hpp"

namespace procam::analyze {
namespace {

constexpr int kMaxLensParameters = Intrinsics::kNumParameters + 8;  ///< the largest model: rational

/// Its lens, then its mount.
std::vector<std::string> projector_names(const NamedCovariance& calibration, const RigProjector& projector) {
  if (!calibration.index_of(projector.name + ".fx"))
    throw Error(ErrorKind::kInput, "rig projector '" + projector.name + "'",
                "the rig carries no covariance of it", "calibrate it with procam, or state its sigmas");
  std::vector<std::string> names;
  for (const std::string& name : parameter_names(projector.projector.inverse_camera))
    names.push_back(projector.name + "." + name);
  for (const std::string& name : pose_increment_names("rig_from_" + projector.name)) names.push_back(name);
  return names;
}

}  // namespace

std::optional<PixelDerivatives> pixel_derivatives(const Camera& lens, const Vec3& point) {
  using D = Dual<3 + kMaxLensParameters>;
  Vec3T<D> variable;
  for (int i = 0; i < 3; ++i) variable[i] = D(point[i], i);
  const VecX parameters = parameters_of(lens);
  std::vector<D> lens_parameters;
  for (int i = 0; i < int(parameters.size()); ++i) lens_parameters.emplace_back(parameters[i], 3 + i);
  const std::optional<Vec2T<D>> projected = std::visit(
      [&](const auto& model) {
        return project<std::decay_t<decltype(model)>>(IntrinsicsT<D>::from_array(lens_parameters.data()),
                                                      lens_parameters.data() + Intrinsics::kNumParameters,
                                                      variable);
      },
      lens.distortion);
  if (!projected) return std::nullopt;
  PixelDerivatives pixel{Vec2((*projected)[0].a, (*projected)[1].a), {}, MatX(2, parameters.size())};
  for (int i = 0; i < 2; ++i) {
    pixel.by_point.row(i) = (*projected)[i].v.head<3>().transpose();
    pixel.by_lens.row(i) = (*projected)[i].v.segment(3, parameters.size()).transpose();
  }
  return pixel;
}

std::optional<ChainDerivatives> chain_derivatives(const LightPath& path, const Vec2& on_surface) {
  const Pose projector_from_rig = path.projector.rig_from_projector.inverse();
  const Vec3 in_surface(on_surface.x(), on_surface.y(), 0);
  const Vec3 in_rig = path.rig_from_surface * in_surface;
  const auto pixel = pixel_derivatives(path.projector.projector.inverse_camera, projector_from_rig * in_rig);
  if (!pixel) return std::nullopt;
  const Mat23 by_point_in_rig = pixel->by_point * projector_from_rig.rotation_matrix();
  const Mat23 by_point_in_surface = by_point_in_rig * path.rig_from_surface.rotation_matrix();

  ChainDerivatives chain;
  chain.pixel = pixel->pixel;
  const Vec3 axis = path.rig_from_surface.rotate(Vec3::UnitZ());
  const Vec3 light = (in_rig - path.projector.rig_from_projector.translation).normalized();
  chain.incidence_deg = std::acos(std::min(std::abs(axis.dot(light)), 1.0)) / kDegree;
  const Mat2 by_offset = by_point_in_surface.leftCols<2>();
  const double determinant = by_offset.determinant();
  if (!std::isfinite(determinant) || std::abs(determinant) <= 1e-12 * by_offset.squaredNorm())
    return std::nullopt;
  chain.by_pixel = by_offset.inverse();
  chain.by_lens = -chain.by_pixel * pixel->by_lens;
  // exp(-xi) q = q + q x rotation - translation;  exp(xi) X = X - X x rotation + translation.
  Eigen::Matrix<double, 3, 6> point_by_rig, point_by_surface;
  point_by_rig << hat(in_rig), -Mat3::Identity();
  point_by_surface << -hat(in_surface), Mat3::Identity();
  chain.by_rig = -chain.by_pixel * by_point_in_rig * point_by_rig;
  chain.by_surface = -chain.by_pixel * by_point_in_surface * point_by_surface;
  return chain;
}

Camera wrong_lens(const Camera& lens, const VecX& errors) {
  Camera wrong = lens;
  auto k = lens.intrinsics.to_array();
  for (std::size_t i = 0; i < k.size(); ++i) k[i] += errors[Eigen::Index(i)];
  wrong.intrinsics = Intrinsics::from_array(k.data());
  std::visit(
      [&](auto& model) {
        for (std::size_t i = 0; i < model.coefficients.size(); ++i)
          model.coefficients[i] += errors[Eigen::Index(k.size() + i)];
      },
      wrong.distortion);
  return wrong;
}

std::optional<Vec2> land(const LightPath& path, const Vec2& pixel, const ChainErrors& errors) {
  Camera lens = path.projector.projector.inverse_camera;
  if (errors.lens.size() > 0) lens = wrong_lens(lens, errors.lens);
  const Pose rig_from_surface = se3_exp(Vec6(-errors.rig)) * path.rig_from_surface * se3_exp(errors.surface);
  const Pose surface_from_projector =
      rig_from_surface.inverse() * se3_exp(errors.mount) * path.projector.rig_from_projector;
  const auto ray = Projector{lens}.emit(pixel + errors.pixel);
  if (!ray) return std::nullopt;
  const auto hit = intersect(surface_from_projector * *ray, Plane{Vec3::UnitZ(), 0});
  if (!hit) return std::nullopt;
  return Vec2(hit->head<2>());
}

std::optional<Vec2> landing_place(const LightPath& path, const Vec2& pixel) {
  return land(path, pixel, {});
}

MatX calibration_covariance(const NamedCovariance& calibration, const RigProjector& projector) {
  return calibration.block(projector_names(calibration, projector));
}

CalibrationErrors::CalibrationErrors(const LightPath& path, const ErrorSources& sources) {
  names = projector_names(sources.calibration, path.projector);
  lens = Eigen::Index(names.size()) - 6;
  if (!path.through_mount) names.resize(std::size_t(lens));
  rig_by_camera.resize(6, 0);
  if (path.through_pose && sources.through_camera) {
    const PoseThroughCamera& through = *sources.through_camera;
    require(Eigen::Index(through.names.size()) == through.by_parameters.cols() &&
                through.by_parameters.allFinite(),
            "through_camera: one finite column for each name");
    names.insert(names.end(), through.names.begin(), through.names.end());
    rig_by_camera = through.by_parameters;
  }
  covariance = sources.calibration.block(names);
}

ChainErrors CalibrationErrors::chain_errors(const VecX& errors) const {
  ChainErrors chain;
  chain.lens = errors.head(lens);
  if (has_mount()) chain.mount = errors.segment<6>(lens);
  if (rig_by_camera.cols() > 0) chain.rig = rig_by_camera * errors.tail(rig_by_camera.cols());
  return chain;
}

MatX CalibrationErrors::landing_by(const ChainDerivatives& chain) const {
  MatX by_all(2, covariance.cols());
  by_all.leftCols(lens) = chain.by_lens;
  if (has_mount()) by_all.middleCols<6>(lens) = chain.by_rig;
  if (rig_by_camera.cols() > 0) by_all.rightCols(rig_by_camera.cols()) = chain.by_rig * rig_by_camera;
  return by_all;
}

MatX square_root(const MatX& covariance, const std::string& name) {
  const double largest = covariance.size() > 0 ? covariance.cwiseAbs().maxCoeff() : 0;
  require(covariance.rows() == covariance.cols() && covariance.allFinite() &&
              (covariance - covariance.transpose()).cwiseAbs().maxCoeff() <= 1e-9 * largest,
          name + ": its covariance is not finite and symmetric");
  // Units differ by many powers of ten (pixels, radians): scaled to ones on the diagonal first.
  const VecX sigmas = covariance.diagonal().cwiseMax(0).cwiseSqrt();
  const VecX inverse = sigmas.unaryExpr([](double s) { return s > 0 ? 1 / s : 0.0; });
  const Eigen::SelfAdjointEigenSolver<MatX> eigen(inverse.asDiagonal() * covariance * inverse.asDiagonal());
  require(covariance.diagonal().minCoeff() >= 0 && eigen.eigenvalues().minCoeff() >= -1e-7,
          name + ": its covariance is not positive semidefinite");
  return sigmas.asDiagonal() * eigen.eigenvectors() *
         eigen.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal();
}

MotionError motion_error(const RobotMotion& motion) {
  require(motion.twist.allFinite() && motion.twist_sigma.allFinite() && motion.acceleration.allFinite() &&
              std::isfinite(motion.delay) && motion.delay >= 0 && motion.delay_sigma >= 0 &&
              std::isfinite(motion.delay_sigma) && motion.twist_sigma.minCoeff() >= 0,
          "RobotMotion: delay and sigmas must be finite and not negative");
  MotionError error;
  error.mean = 0.5 * motion.delay * motion.delay * motion.acceleration;
  error.covariance = motion.delay_sigma * motion.delay_sigma * motion.twist * motion.twist.transpose();
  if (motion.predicted)
    error.covariance += Mat6((motion.delay * motion.twist_sigma).cwiseAbs2().asDiagonal());
  else
    error.mean += motion.delay * motion.twist;
  return error;
}

}  // namespace procam::analyze
