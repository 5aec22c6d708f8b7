// procam: poses, rays and planes, as procam/core/geometry has them.
#include "procam/core.hpp"

#include "bind.hpp"
#include "components.hpp"

namespace procam::python {

namespace {

Record<Pose> bind_pose(py::module_& m) {
  Record<Pose> pose(m, "Pose",
                    "A rigid transform named target_from_source, e.g. rig_from_camera: a rotation and\n"
                    "the source's origin in the target's frame.");
  pose.field("rotation", &Pose::rotation, "unit quaternion x, y, z, w")
      .field("translation", &Pose::translation, "the source's origin in the target's frame, metres")
      .static_method("identity", &Pose::identity, "The transform that moves nothing.")
      .method("rotation_matrix", &Pose::rotation_matrix, "Rotation from source to target, (3, 3).")
      .method("matrix34", &Pose::matrix34, "3x4 matrix [R t].")
      .method("matrix", &Pose::matrix, "4x4 homogeneous matrix.")
      .method("inverse", &Pose::inverse, "source_from_target.")
      .method("__mul__", py::overload_cast<const Pose&>(&Pose::operator*, py::const_),
              "c_from_a = c_from_b * b_from_a", py::arg("b_from_a"))
      .method("__mul__", py::overload_cast<const Vec3&>(&Pose::operator*, py::const_),
              "point_in_target = target_from_source * point_in_source", py::arg("point_in_source"))
      .method("rotate", &Pose::rotate, "Rotates a direction; translation does not act on it.",
              py::arg("direction_in_source"))
      .method("normalized", &Pose::normalized,
              "Brings a drifted quaternion back to unit length (after long chains of products).")
      .method("is_finite", &Pose::is_finite, "Are all of its numbers finite?");
  return pose;
}

void bind_ray_and_plane(py::module_& m) {
  Record<Ray> ray(m, "Ray", "A half-line: origin + s * direction, s >= 0.");
  ray.fields_init()
      .field("origin", &Ray::origin, "metres")
      .field("direction", &Ray::direction, "need not have unit length; `s` counts in its lengths")
      .method("at", &Ray::at, "origin + s * direction, (3,), metres.", py::arg("s"));

  Record<Plane> plane(m, "Plane", "All points p with normal . p + offset = 0.");
  plane.fields_init()
      .field("normal", &Plane::normal, "unit vector")
      .field("offset", &Plane::offset, "metres")
      .method("signed_distance", &Plane::signed_distance,
              "Metres from the plane, positive on the normal's side.", py::arg("point"))
      .static_method("through", &Plane::through,
                     "The plane through a point, metres; the normal may have any length.", py::arg("point"),
                     py::arg("normal"))
      .static_method("of_xy", &Plane::of_xy,
                     "The plane z = 0 of a placed thing (board, sheet, surface), its normal along the\n"
                     "thing's +z.",
                     py::arg("target_from_thing"));

  Record<BentSheet> sheet(
      m, "BentSheet",
      "z = (c_xx dx^2 + 2 c_xy dx dy + c_yy dy^2) / 2 in the frame of the board that is printed\n"
      "on it, (dx, dy) = (x, y) - centre.");
  sheet.fields_init()
      .field("curvature", &BentSheet::curvature, "c_xx, c_xy, c_yy, 1/metre; zero: flat")
      .field("centre", &BentSheet::centre, "metres")
      .method("height_by_curvature", &BentSheet::height_by_curvature, "dz/dcurvature at (x, y).",
              py::arg("point"))
      .method("height", &BentSheet::height, "z at (x, y), metres.", py::arg("point"))
      .method("slope", &BentSheet::slope, "(dz/dx, dz/dy) at (x, y).", py::arg("point"))
      .method("is_flat", &BentSheet::is_flat, "Is its curvature zero?");

  function(m, Gil::kHeld, "intersect", py::overload_cast<const Ray&, const Plane&>(&procam::intersect),
           "Where the ray meets the plane; None when it is parallel (|cos| <= 1e-12), has no\n"
           "direction, or meets the plane behind its origin.",
           py::arg("ray"), py::arg("plane"));
  function(m, Gil::kHeld, "intersect", py::overload_cast<const Ray&, const BentSheet&>(&procam::intersect),
           "Where the ray meets the sheet, of two such points the one that goes over into the flat\n"
           "sheet's; None when there is none ahead of its origin.",
           py::arg("ray"), py::arg("sheet"));
}

Mat3 checked_rotation(const Mat3& r, const char* function) {
  require((r * r.transpose() - Mat3::Identity()).norm() < 1e-6 && r.determinant() > 0,
          std::string(function) + ": the rotation is not orthonormal and right-handed");
  return r;
}

/// A pose from matrices, and its products with what is bound after it.
void bind_pose_conversions(Record<Pose>& pose) {
  pose.value_like()
      .init([]() { return Pose(); }, "The identity.")
      .init(
          [](const Eigen::Quaterniond& rotation, const Vec3& translation) {
            require(rotation.norm() > 0 && std::isfinite(rotation.norm()),
                    "Pose: rotation: a quaternion of length 0, or not finite");
            return Pose(rotation.normalized(), translation);
          },
          "From a quaternion x, y, z, w, (4,), brought to unit length, and the source's origin\n"
          "in the target, (3,) in metres.",
          py::arg("rotation"), py::arg("translation"))
      .static_method(
          "from_matrix",
          [](const Mat4& matrix) {
            require(matrix.row(3) == Eigen::RowVector4d(0, 0, 0, 1),
                    "Pose.from_matrix: matrix: its last row is not 0 0 0 1");
            return Pose(checked_rotation(matrix.topLeftCorner<3, 3>(), "Pose.from_matrix: matrix"),
                        Vec3(matrix.topRightCorner<3, 1>()));
          },
          "From a homogeneous matrix, (4, 4), whose rotation must be orthonormal.", py::arg("matrix"))
      .static_method(
          "from_rotation_matrix",
          [](const Mat3& rotation, const Vec3& translation) {
            return Pose(checked_rotation(rotation, "Pose.from_rotation_matrix: rotation"), translation);
          },
          "From a rotation matrix, (3, 3), which must be orthonormal, and the source's origin\n"
          "in the target, (3,) in metres.",
          py::arg("rotation"), py::arg("translation"))
      .method(
          "__mul__", [](const Pose& self, const Plane& plane) { return self * plane; }, "plane_in_target",
          py::arg("plane"))
      .method(
          "__mul__", [](const Pose& self, const Ray& ray) { return self * ray; }, "ray_in_target",
          py::arg("ray"))
      .method(
          "apply_points",
          [](const Pose& self, const Points3& points) {
            Points3 out;
            for (const Vec3& p : points) out.push_back(self * p);
            return out;
          },
          "points_in_target of points_in_source, both (n, 3).", py::arg("points"));
}

void bind_se3(py::module_& m) {
  function(
      m, Gil::kHeld, "hat", [](const Vec3& v) { return hat(v); },
      "[v]x, (3, 3), the matrix with [v]x w = v x w.", py::arg("v"));
  function(
      m, Gil::kHeld, "so3_exp", [](const Vec3& w) { return so3_exp(w); },
      "Unit quaternion x, y, z, w of the rotation by |w| radians about w.", py::arg("w"));
  function(
      m, Gil::kHeld, "so3_log", [](const Eigen::Quaterniond& q) { return so3_log(q); },
      "Rotation vector, (3,), angle in [0, pi], of a unit quaternion x, y, z, w.", py::arg("q"));
  function(
      m, Gil::kHeld, "so3_left_jacobian", [](const Vec3& w) { return so3_left_jacobian(w); },
      "Left Jacobian of SO(3), (3, 3).", py::arg("w"));
  function(
      m, Gil::kHeld, "se3_exp", [](const Vec6& xi) { return se3_exp(xi); },
      "SE(3) exponential of xi, (6,): rotation (radians), translation (metres).", py::arg("xi"));
  function(
      m, Gil::kHeld, "se3_log", [](const Pose& pose) { return se3_log(pose); },
      "SE(3) logarithm, (6,): rotation (radians), translation (metres).", py::arg("pose"));
  function(
      m, Gil::kHeld, "adjoint", [](const Pose& pose) { return adjoint(pose); },
      "Adjoint, (6, 6), order rotation, translation: pose * se3_exp(xi) ==\n"
      "se3_exp(adjoint(pose) * xi) * pose.",
      py::arg("pose"));
}

}  // namespace

void bind_core_pose(py::module_& m) {
  Record<Pose> pose = bind_pose(m);
  bind_ray_and_plane(m);
  bind_pose_conversions(pose);
  bind_se3(m);
}

}  // namespace procam::python
