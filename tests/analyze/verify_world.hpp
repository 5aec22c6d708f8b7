#pragma once
/// What the tests of verify() and of its picture look at.
#include <Eigen/Cholesky>
#include <random>

#include "procam/analyze/verify.hpp"
#include "support/numeric_world.hpp"

namespace procam::test {

/// A rig before a wall two metres away, seen and lit at an angle; what the files say, and what is true.
struct VerifyWorld {
  Rig stated, truth;
  analyze::StatedSurface surface;
  Pose true_rig_from_surface;
  double noise_px = 0.05;
  /// Of the true wall about an axis along its y, 0: flat. It bulges towards the devices and touches the plane at `touches_at`.
  double radius = 0;
  double touches_at = 0.5;
  int step = 1;  ///< every which mark of a row and a column is there

  VerifyWorld() {
    const NumericWorld numbers;
    const Pose rig_from_camera = lopsided_pose();
    stated.cameras.push_back({"eye", numbers.camera, rig_from_camera});
    stated.projectors.push_back(
        {"lamp", numbers.projector, rig_from_camera * numbers.projector_from_camera.inverse()});
    const Pose camera_from_surface(so3_exp(Vec3(0.12, -0.31, 0.05)), Vec3(-0.45, -0.62, 1.9));
    surface.name = "wall";
    surface.rig_from_surface.pose = rig_from_camera * camera_from_surface;
    truth = stated;
    true_rig_from_surface = surface.rig_from_surface.pose;
  }

  /// Lens of a thousandth, places of 0.02 degrees and 0.3 mm, all correlated.
  void state_uncertainty() {
    NamedCovariance& covariance = stated.covariance;
    std::vector<double> sigmas;
    const auto add = [&](const std::string& device, const Camera& lens, bool placed) {
      for (const std::string& name : parameter_names(lens)) {
        covariance.names.push_back(device + "." + name);
        sigmas.push_back(name[0] == 'f' ? 0.8 : name[0] == 'c' ? 0.6 : name == "skew" ? 0.05 : 5e-4);
      }
      if (!placed) return;
      for (const std::string& name : pose_increment_names("rig_from_" + device))
        covariance.names.push_back(name);
      sigmas.insert(sigmas.end(), {4e-4, 3e-4, 3e-4, 3e-4, 4e-4, 5e-4});
    };
    add("eye", stated.camera().camera, false);
    add("lamp", stated.projector().projector.inverse_camera, true);
    const auto n = Eigen::Index(sigmas.size());
    std::mt19937_64 random(11);
    MatX mixed = 1.5 * MatX::Identity(n, n);
    for (Eigen::Index i = 0; i < n; ++i)
      for (Eigen::Index j = 0; j < n; ++j) mixed(i, j) += uniform(random, -0.6, 0.6);
    covariance.matrix = mixed * mixed.transpose();
    const VecX scale = Eigen::Map<const VecX>(sigmas.data(), n)
                           .cwiseQuotient(VecX(covariance.matrix.diagonal().cwiseSqrt()));
    covariance.matrix = scale.asDiagonal() * MatX(covariance.matrix) * scale.asDiagonal();
    const Mat6 to_rig = adjoint(surface.rig_from_surface.pose);
    Vec6 variances;
    variances << Vec3::Constant(1e-6), Vec3::Constant(4e-6);  // a milliradian, two millimetres
    surface.rig_from_surface.covariance = to_rig * variances.asDiagonal() * to_rig.transpose();
  }

  /// A truth drawn from what is stated.
  void draw_truth(std::mt19937_64& random) {
    std::normal_distribution<double> normal;
    const auto draw = [&](const MatX& covariance) {
      VecX unit(covariance.rows());
      for (Eigen::Index i = 0; i < unit.size(); ++i) unit[i] = normal(random);
      return VecX(MatX(Eigen::LLT<MatX>(covariance).matrixL()) * unit);
    };
    const VecX e = draw(stated.covariance.matrix);
    const VecX eye = parameters_of(stated.camera().camera),
               lamp = parameters_of(stated.projector().projector.inverse_camera);
    truth.cameras[0].camera = with_parameters(stated.camera().camera, eye + e.head(eye.size()));
    truth.projectors[0].projector.inverse_camera = with_parameters(
        stated.projector().projector.inverse_camera, lamp + e.segment(eye.size(), lamp.size()));
    truth.projectors[0].rig_from_projector =
        se3_exp(Vec6(e.tail<6>())) * stated.projector().rig_from_projector;
    true_rig_from_surface =
        se3_exp(Vec6(draw(surface.rig_from_surface.covariance))) * surface.rig_from_surface.pose;
  }

  void bump_projector(const Vec6& in_own_frame) {
    Pose& place = truth.projectors[0].rig_from_projector;
    place = place * se3_exp(in_own_frame);
  }

  std::optional<Vec3> on_wall(const Ray& in_rig, const Pose& rig_from_wall) const {
    if (radius == 0) return intersect(in_rig, Plane::of_xy(rig_from_wall));
    const Ray ray = rig_from_wall.inverse() * in_rig;
    const Vec2 from(ray.origin.x() - touches_at, ray.origin.z() - radius),
        along(ray.direction.x(), ray.direction.z());
    const double a = along.squaredNorm(), b = from.dot(along), c = from.squaredNorm() - radius * radius;
    if (!(b * b > a * c)) return std::nullopt;
    return rig_from_wall * ray.at((-b - std::sqrt(b * b - a * c)) / a);
  }
  /// The planes that touch the wall as it is stated, where the stated camera sees the marks.
  void state_tangents(const std::vector<LightPoint>& of) {
    surface.tangents.clear();
    const Pose& wall = surface.rig_from_surface.pose;
    const RigCamera& eye = stated.camera();
    for (const LightPoint& mark : of) {
      const Ray ray = eye.rig_from_camera * Ray{Vec3::Zero(), *eye.camera.unproject(mark.camera_pixel)};
      const Vec3 at = wall.inverse() * *on_wall(ray, wall);
      const Pose turned(so3_exp(Vec3(0, -std::asin((at.x() - touches_at) / radius), 0)), Vec3::Zero());
      surface.tangents.push_back(wall * Pose(turned.rotation, at - turned.rotate(Vec3(at.x(), at.y(), 0))));
    }
  }

  /// 15 x 11 marks over the picture (at step 1), where they fall on the wall and the camera truly sees them.
  std::vector<LightPoint> marks(std::uint64_t seed) const {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    const RigCamera& eye = truth.camera();
    const RigProjector& lamp = truth.projector();
    std::vector<LightPoint> result;
    for (int y = 0; y < 11; y += step)
      for (int x = 0; x < 15; x += step) {
        LightPoint mark;
        mark.projector_pixel = Vec2(63.5 + 64 * x, 47.5 + 64 * y);
        const auto ray = lamp.projector.emit(mark.projector_pixel);
        const auto lit = on_wall(lamp.rig_from_projector * *ray, true_rig_from_surface);
        if (!lit) continue;  // past the curved wall's edge
        const auto seen = eye.camera.project(eye.rig_from_camera.inverse() * *lit);
        if (!seen || !eye.camera.size.contains(*seen)) continue;
        mark.camera_pixel = *seen + noise_px * Vec2{normal(random), normal(random)};
        mark.camera_covariance = std::pow(noise_px, 2) * Mat2::Identity();
        result.push_back(mark);
      }
    return result;
  }

  analyze::VerifyResult verified(const analyze::VerifyOptions& options = {}, std::uint64_t seed = 5) const {
    return analyze::verify(stated, stated.camera(), stated.projector(), surface, marks(seed), options);
  }
};

inline Vec6 turned_by(double degrees) {
  Vec6 bump = Vec6::Zero();
  bump.head<3>() = degrees * kDegree * Vec3(0.7, -0.6, 0.38).normalized();
  return bump;
}

inline analyze::VerifyOptions correcting(analyze::Correct what) {
  analyze::VerifyOptions options;
  options.correct = what;
  return options;
}

}  // namespace procam::test
