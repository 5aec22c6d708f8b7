// procam: poses, planes, homographies and meshes, as procam/core/geometry has them.
#include "procam/core.hpp"

#include "bind.hpp"
#include "components.hpp"
#include "mapped.hpp"

namespace procam::python {

namespace {

Record<Pose> bind_pose(py::module_& m) {
  Record<Pose> pose(m, "Pose", "");
  pose.field("rotation", &Pose::rotation, "")
      .field("translation", &Pose::translation, "")
      .static_method("identity", &Pose::identity, "")
      .method("rotation_matrix", &Pose::rotation_matrix, "")
      .method("matrix34", &Pose::matrix34, "3x4 matrix [R t].")
      .method("matrix", &Pose::matrix, "4x4 homogeneous matrix.")
      .method("inverse", &Pose::inverse, "")
      .method("__mul__", py::overload_cast<const Pose&>(&Pose::operator*, py::const_),
              "c_from_a = c_from_b * b_from_a", py::arg("b_from_a"))
      .method("__mul__", py::overload_cast<const Vec3&>(&Pose::operator*, py::const_),
              "point_in_target = target_from_source * point_in_source", py::arg("point_in_source"))
      .method("rotate", &Pose::rotate, "Rotates a direction; translation does not act on it.",
              py::arg("direction_in_source"))
      .method("normalized", &Pose::normalized,
              "Brings a drifted quaternion back to unit length (after long chains of products).")
      .method("is_finite", &Pose::is_finite, "");
  return pose;
}

void bind_ray_and_plane(py::module_& m) {
  Record<Ray> ray(m, "Ray", "");
  ray.fields_init()
      .field("origin", &Ray::origin, "")
      .field("direction", &Ray::direction, "need not have unit length; `s` counts in its lengths")
      .method("at", &Ray::at, "", py::arg("s"));

  Record<Plane> plane(m, "Plane", "");
  plane.fields_init()
      .field("normal", &Plane::normal, "")
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
      .method("is_flat", &BentSheet::is_flat, "");

  function(m, Gil::kHeld, "intersect", py::overload_cast<const Ray&, const Plane&>(&procam::intersect),
           "Where the ray meets the plane; nullopt when it is parallel (|cos| <= 1e-12), has no\n"
           "direction, or meets the plane behind its origin.",
           py::arg("ray"), py::arg("plane"));
  function(m, Gil::kHeld, "intersect", py::overload_cast<const Ray&, const BentSheet&>(&procam::intersect),
           "Where the ray meets the sheet, of two such points the one that goes over into the flat\n"
           "sheet's; nullopt when there is none ahead of its origin.",
           py::arg("ray"), py::arg("sheet"));
}

/// A pose from matrices, and its products with what is bound after it.
void bind_pose_conversions(Record<Pose>& pose) {
  pose.init([]() { return Pose(); }, "The identity.")
      .init([](const Eigen::Quaterniond& rotation,
               const Vec3& translation) { return Pose(rotation.normalized(), translation); },
            "From a quaternion x, y, z, w, (4,), brought to unit length, and the source's origin\n"
            "in the target, (3,) in metres.",
            py::arg("rotation"), py::arg("translation"))
      .static_method(
          "from_matrix",
          [](const Mat4& matrix) {
            return Pose(Mat3(matrix.topLeftCorner<3, 3>()), Vec3(matrix.topRightCorner<3, 1>()));
          },
          "From a homogeneous matrix, (4, 4), whose rotation must be orthonormal.", py::arg("matrix"))
      .static_method(
          "from_rotation_matrix",
          [](const Mat3& rotation, const Vec3& translation) { return Pose(rotation, translation); },
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

void bind_covariance(py::module_& m) {
  Record<PoseWithCovariance> pose_with_covariance(m, "PoseWithCovariance", "");
  pose_with_covariance.fields_init()
      .field("pose", &PoseWithCovariance::pose, "")
      .field("covariance", &PoseWithCovariance::covariance,
             "of the left increment [rotation, translation]; rad^2, rad m, m^2");

  Record<NamedCovariance> named_covariance(
      m, "NamedCovariance",
      "A covariance matrix whose rows have names, e.g. \"projector.fx\",\n"
      "\"rig_from_projector.rx\": what a solver leaves behind.");
  named_covariance.fields_init()
      .field("names", &NamedCovariance::names, "")
      .field("matrix", &NamedCovariance::matrix, "names.size() square, units of the named parameters")
      .method("empty", &NamedCovariance::empty, "")
      .method("index_of", &NamedCovariance::index_of, "", py::arg("name"))
      .method(
          "sigma",
          [](const NamedCovariance& self, const std::string& name) {
            require(std::size_t(self.matrix.rows()) == self.names.size() &&
                        self.matrix.rows() == self.matrix.cols(),
                    "NamedCovariance.sigma: the matrix is not as large as the list of names");
            return self.sigma(name);
          },
          "One standard deviation; 0 for a parameter that was held fixed (not in the list).", py::arg("name"))
      .method(
          "block",
          [](const NamedCovariance& self, const std::vector<std::string>& wanted) {
            require(std::size_t(self.matrix.rows()) == self.names.size() &&
                        self.matrix.rows() == self.matrix.cols(),
                    "NamedCovariance.block: the matrix is not as large as the list of names");
            return self.block(wanted);
          },
          "The rows and columns of these names, in this order; zero where a name was held\n"
          "fixed.",
          py::arg("wanted"));

  function(m, Gil::kHeld, "compose", &procam::compose,
           "c_from_a = c_from_b * b_from_a. `cross` is E[xi_cb xi_ba^T], zero when the two are\n"
           "independent.",
           py::arg("c_from_b"), py::arg("b_from_a"), py::arg_v("cross", Mat6(Mat6::Zero()), "zeros((6, 6))"));
  function(m, Gil::kHeld, "inverse", &procam::inverse, "", py::arg("target_from_source"));
  function(m, Gil::kHeld, "relative", &procam::relative,
           "b_from_a = (c_from_b)^-1 * c_from_a: two things seen from one place. `cross` is\n"
           "E[xi_cb xi_ca^T]: what both share (the common camera's own error) cancels only when\n"
           "it is given.",
           py::arg("c_from_b"), py::arg("c_from_a"), py::arg_v("cross", Mat6(Mat6::Zero()), "zeros((6, 6))"));
  function(m, Gil::kHeld, "point_covariance", &procam::point_covariance,
           "Covariance of target_from_source * point, for an exact point: J = [-hat(p), I] in\n"
           "the target frame.",
           py::arg("target_from_source"), py::arg("point_in_source"));
  function(m, Gil::kHeld, "pose_increment_names", &procam::pose_increment_names,
           "Names of a pose's six increments below a prefix: prefix.rx ry rz tx ty tz.", py::arg("prefix"));
}

void bind_frame_tree(py::module_& m) {
  Record<FrameTree> frame_tree(m, "FrameTree", "");
  Record<FrameTree::Link> link(frame_tree.type, "Link", "");
  frame_tree.fields_init()
      .method("set",
              py::overload_cast<const std::string&, const std::string&, const PoseWithCovariance&>(
                  &FrameTree::set),
              "Adds or replaces the edge parent_from_child. Throws Error(kInput) when the child\n"
              "already hangs elsewhere or the edge would close a loop, std::invalid_argument when a\n"
              "number is not finite.",
              py::arg("parent"), py::arg("child"), py::arg("parent_from_child"))
      .method("set", py::overload_cast<const std::string&, const std::string&, const Pose&>(&FrameTree::set),
              "", py::arg("parent"), py::arg("child"), py::arg("parent_from_child"))
      .method("chain", &FrameTree::chain,
              "The chain from source to target, link by link in the order of multiplication; empty\n"
              "when both are one frame. Throws Error(kInput) when the two are not connected.",
              py::arg("target"), py::arg("source"))
      .method("get", &FrameTree::get, "target_from_source with its covariance.", py::arg("target"),
              py::arg("source"));
  link.fields_init()
      .field("target", &FrameTree::Link::target, "")
      .field("source", &FrameTree::Link::source, "")
      .field("target_from_source", &FrameTree::Link::target_from_source, "");
}

void bind_homography(py::module_& m) {
  Record<Homography> homography(
      m, "Homography", "A map named destination_from_source, e.g. projector_from_wall * wall_from_picture.");
  homography.init([]() { return Homography(); }, "")
      .init([](const Mat3& matrix) { return Homography(matrix); },
            "The map with this matrix, kept as it is. Singular or non-finite:\n"
            "std::invalid_argument.",
            py::arg("matrix"))
      .static_method("trusted", &Homography::trusted,
                     "For solvers that know their matrix to be regular: nothing is checked.",
                     py::arg("matrix"))
      .method("matrix", &Homography::matrix,
              "Positive denominators in front; any positive scale (a fit of many points: unit\n"
              "Frobenius norm).")
      .method("normalised", &Homography::normalised,
              "The same map with unit Frobenius norm: the form to compare and to store.")
      .method("denominator", &Homography::denominator,
              "The third homogeneous coordinate of the mapped point: positive in front of the\n"
              "horizon.",
              py::arg("source"))
      .method("apply", &Homography::apply,
              "The mapped point; nullopt on the horizon (to within rounding) or beyond it.",
              py::arg("source"))
      .method("apply_unchecked", &Homography::apply_unchecked,
              "The mapped point for inner loops whose points are known to be in front.", py::arg("source"))
      .method("jacobian", &Homography::jacobian, "d(mapped point) / d(source point), for a point in front.",
              py::arg("source"))
      .method("jacobian_of_entries", &Homography::jacobian_of_entries,
              "d(mapped point) / d(h), h the nine entries row by row, for a point in front.",
              py::arg("source"))
      .method("mirrors", &Homography::mirrors,
              "Does the map turn a clockwise figure (in front of the horizon) into a\n"
              "counter-clockwise one? Legal: rear projection and y-up surface coordinates do it.")
      .method("inverse", &Homography::inverse, "source_from_destination.")
      .method("with_in_front", &Homography::with_in_front,
              "The same projective map, with its front on this source point's side of the horizon\n"
              "(for matrices of unknown sign, such as those read from files). A point on the\n"
              "horizon: std::invalid_argument.",
              py::arg("source"));
  homography
      .method(
          "__mul__", [](const Homography& self, const Homography& other) { return self * other; },
          "target_from_source = target_from_middle * middle_from_source", py::arg("other"))
      .method(
          "apply_points",
          [](const Homography& self, const Points2& points) {
            return mapped<2>(points, [&](const Vec2& p) { return self.apply(p); });
          },
          kMappedDoc, py::arg("points"));

  function(m, Gil::kHeld, "homography_from_four_points", &procam::homography_from_four_points,
           "destination_from_source exactly through four pairs, in closed form; all four are in\n"
           "front of the horizon.\n"
           "\n"
           "Errors: kInput for a non-finite coordinate; kDegenerate for repeated points, three\n"
           "collinear of the four (in either plane, kCollinearTolerance), points across the\n"
           "horizon. Messages name the points by their position 0..3.",
           py::arg("source"), py::arg("destination"));
  m.attr("kCollinearTolerance") = procam::kCollinearTolerance;
}

void bind_homography_fit(py::module_& m) {
  Record<HomographyOptions> homography_options(m, "HomographyOptions", "");
  homography_options.fields_init()
      .field("weights", &HomographyOptions::weights,
             "One per pair, proportional to 1 / variance; zero leaves a pair out. Empty: all one.")
      .field("sigma", &HomographyOptions::sigma,
             "Standard deviation of one coordinate of a point of weight one, in destination units.\n"
             "Unset: estimated from the residuals, which takes more than four pairs.")
      .field("collinear_tolerance", &HomographyOptions::collinear_tolerance,
             "Points within this fraction of their extent of one line count as collinear. A pixel\n"
             "over a thousand: measured points that thin fit their own noise across the line.")
      .field("max_iterations", &HomographyOptions::max_iterations, "");

  Record<HomographyFit> homography_fit(m, "HomographyFit", "");
  homography_fit.fields_init()
      .field("destination_from_source", &HomographyFit::destination_from_source,
             "unit Frobenius norm, all pairs in use in front")
      .field("residuals", &HomographyFit::residuals,
             "mapped - measured, per pair (zero for a pair whose image lies beyond the horizon)")
      .field("rmse", &HomographyFit::rmse, "sqrt(sum w |r|^2 / sum w), destination units")
      .field("covariance", &HomographyFit::covariance,
             "Of the nine entries of matrix(), row by row: rank 8, with the entries themselves as\n"
             "its null direction (the scale). Unset when sigma is neither given nor can be\n"
             "estimated.")
      .field("sigma", &HomographyFit::sigma, "as given, or sqrt(sum w |r|^2 / (2 N - 8))")
      .field("condition", &HomographyFit::condition,
             "sqrt(|J^T W J|_1 |(J^T W J)^-1|_1) in normalised coordinates: between the ratio of\n"
             "J's largest and smallest singular values and 8 times that. Below ten for points\n"
             "spread well; in the hundreds for points near a line.")
      .field("inliers", &HomographyFit::inliers,
             "pairs in use: positive weight, and not rejected by a robust fit");

  function(m, Gil::kHeld, "mapped_covariance", &procam::mapped_covariance,
           "The mapped point's 2 x 2 covariance: the fit's own, plus the source point's if it is\n"
           "uncertain as well. nullopt beyond the horizon, or when the fit has no covariance.",
           py::arg("fit"), py::arg("source"),
           py::arg_v("source_covariance", Mat2(Mat2::Zero()), "zeros((2, 2))"));
  function(m, Gil::kHeld, "homography_dlt", &procam::homography_dlt,
           "The normalised DLT alone: minimises the algebraic error sum w |w_i (H(s_i) - d_i)|^2\n"
           "in one linear solve, the denominator at the centroid being one. For starts, and\n"
           "where an approximate answer will do.",
           py::arg("source"), py::arg("destination"), py::arg_v("weights", std::vector<double>{}, "()"));
  function(m, Gil::kHeld, "fit_homography", &procam::fit_homography,
           "destination_from_source by weighted geometric least squares; see the top of this\n"
           "file.",
           py::arg("source"), py::arg("destination"),
           py::arg_v("options", HomographyOptions{}, "HomographyOptions()"));
}

void bind_robust_homography(py::module_& m) {
  Record<RobustHomographyOptions> robust_homography_options(m, "RobustHomographyOptions", "");
  robust_homography_options.fields_init()
      .field("sigma", &RobustHomographyOptions::sigma,
             "Standard deviation of one coordinate of a good destination point, in pixels (or\n"
             "whatever the destination's unit is). Pairs farther than 3.03 sigma from their image\n"
             "are outliers: 1 % of the good ones (chi^2, two degrees).")
      .field("confidence", &RobustHomographyOptions::confidence,
             "Probability of having drawn an all-inlier sample when the search stops.")
      .field("max_samples", &RobustHomographyOptions::max_samples,
             "Enough for 80 % outliers (4316 samples at 0.999).")
      .field("seed", &RobustHomographyOptions::seed, "")
      .field("collinear_tolerance", &RobustHomographyOptions::collinear_tolerance, "The final fit's.");

  function(m, "fit_homography_robust", &procam::fit_homography_robust,
           "destination_from_source from the pairs that agree; fit.inliers names them. sigma is\n"
           "the option's.\n"
           "\n"
           "Errors: as fit_homography(), and kNotEnoughData for fewer than five pairs (four\n"
           "always agree), kDegenerate when no consensus stands out from chance.",
           py::arg("source"), py::arg("destination"),
           py::arg_v("options", RobustHomographyOptions{}, "RobustHomographyOptions()"));
}

void bind_planar_pose(py::module_& m) {
  Record<PlanarPoseSolution> planar_pose_solution(m, "PlanarPoseSolution", "");
  planar_pose_solution.fields_init()
      .field("camera_from_plane", &PlanarPoseSolution::camera_from_plane, "")
      .field("rmse", &PlanarPoseSolution::rmse,
             "sqrt(mean |r|^2) in normalised units: times the focal length, pixels")
      .field("covariance", &PlanarPoseSolution::covariance,
             "Of the left increment [rotation, translation]; from the given sigma, or from the\n"
             "residuals (2 N - 6).");

  Record<PlanarPose> planar_pose(m, "PlanarPose", "");
  planar_pose.fields_init()
      .field("solutions", &PlanarPose::solutions, "one or two, smaller rmse first")
      .method(
          "best",
          [](const PlanarPose& self) {
            require(!self.solutions.empty(), "PlanarPose.best: no solutions");
            return self.best();
          },
          "")
      .method("ambiguity", &PlanarPose::ambiguity,
              "rmse of the best over that of the other one: 0 is settled (or there is no other), 1\n"
              "undecided.");

  function(m, Gil::kHeld, "planar_pose", &procam::planar_pose,
           "camera_from_plane, both solutions. `sigma`: standard deviation of one normalised\n"
           "image coordinate (pixels over focal length), unset: from the residuals. Needs four\n"
           "points, no three of any four on a line.",
           py::arg("plane_points"), py::arg("image_points"), py::arg("sigma") = py::none());
}

void bind_triangulation(py::module_& m) {
  Record<TriangulationOptions> triangulation_options(m, "TriangulationOptions", "");
  triangulation_options.fields_init()
      .field("sigma", &TriangulationOptions::sigma,
             "Angular standard deviation of every ray, radians; a pixel of 1/1500 of the focal\n"
             "length, halved.")
      .field("parallel_tolerance", &TriangulationOptions::parallel_tolerance,
             "Rays count as parallel when the largest angle among them is below this, radians.\n"
             "0.05 degrees: a 0.5 m baseline seen from 600 m.");

  Record<Triangulation> triangulation(m, "Triangulation", "");
  triangulation.fields_init()
      .field("point", &Triangulation::point, "")
      .field("covariance", &Triangulation::covariance,
             "m^2, for rays of angular noise options.sigma and exact origins")
      .field("rms_distance", &Triangulation::rms_distance, "of the point from the rays, metres")
      .field("distances", &Triangulation::distances, "per ray, metres");

  function(m, Gil::kHeld, "triangulate", &procam::triangulate,
           "All rays in one frame; the point is in it as well. Fewer than two rays:\n"
           "std::invalid_argument.",
           py::arg("rays"), py::arg_v("options", TriangulationOptions{}, "TriangulationOptions()"));
}

void bind_polygons(py::module_& m) {
  Record<HalfPlane> half_plane(m, "HalfPlane", "The points x with normal . x <= offset.");
  half_plane.fields_init().field("normal", &HalfPlane::normal, "").field("offset", &HalfPlane::offset, "");

  function(m, Gil::kHeld, "half_planes", &procam::half_planes,
           "One a side, normals of unit length pointing outwards.", py::arg("polygon"));
  function(m, Gil::kHeld, "area", &procam::area, "", py::arg("polygon"));
  function(m, Gil::kHeld, "clipped", &procam::clipped,
           "The part of the polygon inside the half-plane: fewer than three corners when nothing\n"
           "of it is (Sutherland and Hodgman, \"Reentrant polygon clipping\", 1974).",
           py::arg("polygon"), py::arg("half_plane"));
}

void bind_meshes(py::module_& m) {
  Record<Mesh, std::shared_ptr<Mesh>> mesh(m, "Mesh", "");
  mesh.fields_init()
      .field("vertices", &Mesh::vertices, "metres, in the mesh's own frame")
      .field("uv", &Mesh::uv, "content coordinates (core/surface/surface.hpp), one a vertex")
      .field("triangles", &Mesh::triangles, "vertices, by their places in the list");

  Record<PointCloud> point_cloud(m, "PointCloud", "Measured points of surfaces, in no order.");
  point_cloud.fields_init()
      .field("points", &PointCloud::points, "float64 (n, 3), metres")
      .field("normals", &PointCloud::normals, "float64 (n, 3) unit vectors, or none at all")
      .field("sigma", &PointCloud::sigma,
             "standard deviation along the device's ray, metres, or none at all");

  function(m, Gil::kHeld, "fault_of", py::overload_cast<const Mesh&>(&procam::fault_of),
           "Why nothing can be drawn on it, in words; nullopt for a good mesh: at least one\n"
           "triangle, a uv for every vertex, numbers all finite, corners that exist, and no\n"
           "triangle without area (less than 1e-12 of its longest side squared).",
           py::arg("mesh"));
  function(
      m, Gil::kHeld, "area_vector",
      [](const Mesh& mesh, const std::array<int, 3>& triangle) {
        for (int corner : triangle) require_pixel({int(mesh.vertices.size()), 1}, corner, 0, "area_vector");
        return area_vector(mesh, triangle);
      },
      "Twice the area's vector of a triangle, along its normal.", py::arg("mesh"), py::arg("triangle"));
}

void bind_mirror(py::module_& m) {
  function(m, Gil::kHeld, "reflect", &procam::reflect, "", py::arg("mirror"), py::arg("point"));
  function(m, Gil::kHeld, "camera_from_mirrored_camera", &procam::camera_from_mirrored_camera,
           "Where the mirrored camera stands: x_camera = S F x_mirrored. The mirror in the\n"
           "camera's frame.",
           py::arg("mirror_in_camera"));
}

}  // namespace

void bind_core_geometry(py::module_& m) {
  Record<Pose> pose = bind_pose(m);
  bind_ray_and_plane(m);
  bind_pose_conversions(pose);
  bind_se3(m);
  bind_covariance(m);
  bind_frame_tree(m);
  bind_homography(m);
  bind_homography_fit(m);
  bind_robust_homography(m);
  bind_planar_pose(m);
  bind_triangulation(m);
  bind_polygons(m);
  bind_meshes(m);
  bind_mirror(m);
}

}  // namespace procam::python
