// procam: covariances, frames, homographies and meshes, as procam/core/geometry has them.
#include "procam/core.hpp"

#include "bind.hpp"
#include "components.hpp"
#include "mapped.hpp"

namespace procam::python {

namespace {

void bind_covariance(py::module_& m) {
  Record<PoseWithCovariance> pose_with_covariance(
      m, "PoseWithCovariance",
      "A pose and the covariance (6, 6) of its left increment: rotation (radians), then\n"
      "translation (metres).");
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
      .method("empty", &NamedCovariance::empty, "Has it no rows?")
      .method("index_of", &NamedCovariance::index_of, "The row of a name, or None.", py::arg("name"))
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
  function(m, Gil::kHeld, "inverse", &procam::inverse, "source_from_target with the covariance moved along.",
           py::arg("target_from_source"));
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
  Record<FrameTree> frame_tree(
      m, "FrameTree",
      "Frames joined by poses; the pose between any two of them is the product along\n"
      "the way.");
  Record<FrameTree::Link> link(frame_tree.type, "Link",
                               "One edge of the tree: the pose target_from_source between two named frames.");
  frame_tree.fields_init()
      .method("set",
              py::overload_cast<const std::string&, const std::string&, const PoseWithCovariance&>(
                  &FrameTree::set),
              "Adds or replaces the edge parent_from_child. Raises Error(kInput) when the child\n"
              "already hangs elsewhere or the edge would close a loop, ValueError when a\n"
              "number is not finite.",
              py::arg("parent"), py::arg("child"), py::arg("parent_from_child"))
      .method("set", py::overload_cast<const std::string&, const std::string&, const Pose&>(&FrameTree::set),
              "Of a pose without covariance.", py::arg("parent"), py::arg("child"),
              py::arg("parent_from_child"))
      .method("chain", &FrameTree::chain,
              "The chain from source to target, link by link in the order of multiplication; empty\n"
              "when both are one frame. Raises Error(kInput) when the two are not connected.",
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
            "ValueError.",
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
              "The mapped point; None on the horizon (to within rounding) or beyond it.", py::arg("source"))
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
              "horizon: ValueError.",
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
  Record<HomographyOptions> homography_options(m, "HomographyOptions", "How fit_homography() iterates.");
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

  Record<HomographyFit> homography_fit(m, "HomographyFit", "A homography with its covariance and residuals.");
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
           "uncertain as well. None beyond the horizon, or when the fit has no covariance.",
           py::arg("fit"), py::arg("source"),
           py::arg_v("source_covariance", Mat2(Mat2::Zero()), "zeros((2, 2))"));
  function(m, Gil::kHeld, "homography_dlt", &procam::homography_dlt,
           "The normalised DLT alone: minimises the algebraic error sum w |w_i (H(s_i) - d_i)|^2\n"
           "in one linear solve, the denominator at the centroid being one. For starts, and\n"
           "where an approximate answer will do.",
           py::arg("source"), py::arg("destination"), py::arg_v("weights", std::vector<double>{}, "()"));
  function(m, Gil::kHeld, "fit_homography", &procam::fit_homography,
           "destination_from_source by weighted geometric least squares, with the covariance.\n"
           "Coordinates are (n, 2), n >= 4, pixels or metres; no three of four points may lie on a\n"
           "line. Raises Error(kNotEnoughData), Error(kDegenerate), Error(kNotConverged).",
           py::arg("source"), py::arg("destination"),
           py::arg_v("options", HomographyOptions{}, "HomographyOptions()"));
}

void bind_robust_homography(py::module_& m) {
  Record<RobustHomographyOptions> robust_homography_options(
      m, "RobustHomographyOptions", "How fit_homography_robust() samples, and which points it rejects.");
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
  Record<PlanarPoseSolution> planar_pose_solution(m, "PlanarPoseSolution",
                                                  "One of the two poses that fit an image of a plane.");
  planar_pose_solution.fields_init()
      .field("camera_from_plane", &PlanarPoseSolution::camera_from_plane, "")
      .field("rmse", &PlanarPoseSolution::rmse,
             "sqrt(mean |r|^2) in normalised units: times the focal length, pixels")
      .field("covariance", &PlanarPoseSolution::covariance,
             "Of the left increment [rotation, translation]; from the given sigma, or from the\n"
             "residuals (2 N - 6).");

  Record<PlanarPose> planar_pose(m, "PlanarPose",
                                 "The poses of a plane that fit an image of it, the better first.");
  planar_pose.fields_init()
      .field("solutions", &PlanarPose::solutions, "one or two, smaller rmse first")
      .method(
          "best",
          [](const PlanarPose& self) {
            require(!self.solutions.empty(), "PlanarPose.best: no solutions");
            return self.best();
          },
          "The pose with the smaller residual.")
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
  Record<TriangulationOptions> triangulation_options(m, "TriangulationOptions",
                                                     "How triangulate() iterates, and what it refuses.");
  triangulation_options.fields_init()
      .field("sigma", &TriangulationOptions::sigma,
             "Angular standard deviation of every ray, radians; a pixel of 1/1500 of the focal\n"
             "length, halved.")
      .field("parallel_tolerance", &TriangulationOptions::parallel_tolerance,
             "Rays count as parallel when the largest angle among them is below this, radians.\n"
             "0.05 degrees: a 0.5 m baseline seen from 600 m.");

  Record<Triangulation> triangulation(m, "Triangulation",
                                      "A point from two rays or more, with its covariance.");
  triangulation.fields_init()
      .field("point", &Triangulation::point, "metres, in the frame of the rays")
      .field("covariance", &Triangulation::covariance,
             "m^2, for rays of angular noise options.sigma and exact origins")
      .field("rms_distance", &Triangulation::rms_distance, "of the point from the rays, metres")
      .field("distances", &Triangulation::distances, "per ray, metres");

  function(m, Gil::kHeld, "triangulate", &procam::triangulate,
           "All rays in one frame; the point is in it as well. Fewer than two rays:\n"
           "ValueError.",
           py::arg("rays"), py::arg_v("options", TriangulationOptions{}, "TriangulationOptions()"));
}

void bind_polygons(py::module_& m) {
  Record<HalfPlane> half_plane(m, "HalfPlane", "The points x with normal . x <= offset.");
  half_plane.fields_init()
      .field("normal", &HalfPlane::normal, "unit vector, points outwards")
      .field("offset", &HalfPlane::offset, "inside is normal . x <= offset, in the unit of x");

  function(m, Gil::kHeld, "half_planes", &procam::half_planes,
           "One a side, normals of unit length pointing outwards.", py::arg("polygon"));
  function(m, Gil::kHeld, "area", &procam::area,
           "Area of a polygon of corners (n, 2), in the square of their unit; positive if\n"
           "they run from x to y.",
           py::arg("polygon"));
  function(m, Gil::kHeld, "clipped", &procam::clipped,
           "The part of the polygon inside the half-plane: fewer than three corners when nothing\n"
           "of it is (Sutherland and Hodgman, \"Reentrant polygon clipping\", 1974).",
           py::arg("polygon"), py::arg("half_plane"));
}

void bind_meshes(py::module_& m) {
  Record<Mesh, std::shared_ptr<Mesh>> mesh(m, "Mesh",
                                           "Triangles: corners in metres, and three indices for each.");
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
           "Why nothing can be drawn on it, in words; None for a good mesh: at least one\n"
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
  function(m, Gil::kHeld, "reflect", &procam::reflect, "The mirror image of a point (3,), metres.",
           py::arg("mirror"), py::arg("point"));
  function(m, Gil::kHeld, "camera_from_mirrored_camera", &procam::camera_from_mirrored_camera,
           "Where the mirrored camera stands: x_camera = S F x_mirrored. The mirror in the\n"
           "camera's frame.",
           py::arg("mirror_in_camera"));
}

}  // namespace

void bind_core_geometry(py::module_& m) {
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
