// procam: cameras and projectors, as procam/core/lens has them.
#include "procam/core.hpp"

#include "bind.hpp"
#include "components.hpp"
#include "mapped.hpp"

namespace procam::python {

namespace {

void bind_distortion(py::module_& m) {
  Record<BrownConrady> brown_conrady(
      m, "BrownConrady",
      "Lens of OpenCV's plumb_bob: radial k1 k2 k3, tangential p1 p2, on coordinates of\n"
      "the plane z = 1.");
  brown_conrady.fields_init().field("coefficients", &BrownConrady::coefficients,
                                    "k1 k2 p1 p2 k3, without unit");

  Record<FisheyeDistortion> fisheye_distortion(
      m, "FisheyeDistortion",
      "Equidistant fisheye of Kannala and Brandt: k1 k2 k3 k4, on the angle to the\n"
      "optical axis in radians.");
  fisheye_distortion.fields_init().field("coefficients", &FisheyeDistortion::coefficients,
                                         "k1 k2 k3 k4, without unit");

  Record<NoDistortion> no_distortion(m, "NoDistortion", "A pinhole: straight lines stay straight.");
  no_distortion.fields_init().field("coefficients", &NoDistortion::coefficients, "none");

  Record<RationalDistortion> rational_distortion(
      m, "RationalDistortion",
      "Lens of OpenCV's rational_polynomial: k1 k2 p1 p2 k3, and k4 k5 k6 in the\n"
      "denominator.");
  rational_distortion.fields_init().field("coefficients", &RationalDistortion::coefficients,
                                          "k1 k2 p1 p2 k3 k4 k5 k6, without unit");

  function(m, Gil::kHeld, "name_of", &procam::name_of,
           "The lens model's name in files, e.g. \"brown_conrady\".", py::arg("distortion"));
  function(m, Gil::kHeld, "coefficient_names", &procam::coefficient_names,
           "Names of the lens's coefficients in their order, e.g. \"k1\".", py::arg("distortion"));
  function(m, Gil::kHeld, "coefficients_of", &procam::coefficients_of,
           "The lens's coefficients in the order of coefficient_names(), without unit.",
           py::arg("distortion"));
  function(m, Gil::kHeld, "distortion_named", &procam::distortion_named,
           "The model of that name, all coefficients zero. Raises Error(kUnsupported) for an\n"
           "unknown name.",
           py::arg("name"));
  function(m, Gil::kHeld, "with_coefficients", &procam::with_coefficients,
           "The same model with other coefficients; their number must be the model's.", py::arg("distortion"),
           py::arg("values"));
}

void bind_intrinsics(py::module_& m) {
  Record<Intrinsics> intrinsics(
      m, "Intrinsics",
      "The camera matrix [fx skew cx; 0 fy cy; 0 0 1], in pixels; pixel (0, 0) is the\n"
      "centre of the first.");
  intrinsics.fields_init()
      .field("fx", &Intrinsics::fx, "focal length along x, pixels")
      .field("fy", &Intrinsics::fy, "focal length along y, pixels")
      .field("cx", &Intrinsics::cx, "principal point, pixels; may lie outside the image")
      .field("cy", &Intrinsics::cy, "principal point, pixels; may lie outside the image")
      .field("skew", &Intrinsics::skew, "pixels of x per unit of y in the plane z = 1")
      .method("matrix", &Intrinsics::matrix, "The camera matrix K, (3, 3), pixels.")
      .static_method("from_matrix", &Intrinsics::from_matrix,
                     "From a K of the form above: upper triangular, K(2,2) = 1.", py::arg("k"))
      .method("to_array", &Intrinsics::to_array, "fx, fy, cx, cy, skew in pixels.")
      .method("pixel_from_normalized", &Intrinsics::pixel_from_normalized,
              "From the (distorted) normalised image plane z = 1 to pixels.", py::arg("n"))
      .method("normalized_from_pixel", &Intrinsics::normalized_from_pixel,
              "Pixel (2,) -> its point (2,) in the plane z = 1, without distortion.", py::arg("pixel"));
}

void bind_camera(py::module_& m) {
  Record<Camera> camera(m, "Camera",
                        "Image size, intrinsics and lens of a camera, in its optical frame: x right, y\n"
                        "down, z forward.");
  camera.fields_init()
      .field("size", &Camera::size, "")
      .field("intrinsics", &Camera::intrinsics, "")
      .field("distortion", &Camera::distortion, "")
      .method("project", &Camera::project,
              "Point in the optical frame (metres) -> pixel, which may lie outside the image;\n"
              "None when the lens cannot see it.",
              py::arg("point_in_camera"))
      .method("unproject", &Camera::unproject,
              "Pixel -> unit bearing in the optical frame; None where the lens model has no\n"
              "inverse.",
              py::arg("pixel"))
      .method("sees", &Camera::sees, "Does the point fall on the image?", py::arg("point_in_camera"));
  camera
      .method(
          "project_points",
          [](const Camera& self, const Points3& points) {
            return mapped<2>(points, [&](const Vec3& p) { return self.project(p); });
          },
          kMappedDoc, py::arg("points_in_camera"))
      .method(
          "unproject_points",
          [](const Camera& self, const Points2& pixels) {
            return mapped<3>(pixels, [&](const Vec2& p) { return self.unproject(p); });
          },
          kMappedDoc, py::arg("pixels"));

  function(m, Gil::kHeld, "parameter_names", &procam::parameter_names,
           "Names of all parameters in the order of files and covariances: fx fy cx cy skew,\n"
           "then the model's coefficients.",
           py::arg("camera"));
  function(m, Gil::kHeld, "parameters_of", &procam::parameters_of,
           "fx, fy, cx, cy, skew and the lens's coefficients, (m,), in the order of\n"
           "parameter_names().",
           py::arg("camera"));
  function(m, Gil::kHeld, "with_parameters", &procam::with_parameters,
           "The same camera (size, distortion model) with other parameters, in the order of\n"
           "parameter_names().",
           py::arg("camera"), py::arg("parameters"));
}

void bind_mirrored_lens(py::module_& m) {
  function(m, Gil::kHeld, "turned_signs", &procam::turned_signs,
           "Signs of d(turned lens) / d(lens) in the order of parameter_names(): cx, skew and p2\n"
           "turn with x.",
           py::arg("lens"));
  function(m, Gil::kHeld, "turned_left_to_right", &procam::turned_left_to_right,
           "The lens of the picture turned left to right: u -> width - 1 - u. Its own inverse.",
           py::arg("lens"));
}

void bind_projector(py::module_& m) {
  Record<Projector> projector(m, "Projector",
                              "A projector as the camera that it is backwards: pixels to rays of light.");
  projector.fields_init()
      .field("inverse_camera", &Projector::inverse_camera, "")
      .method("size", &Projector::size, "Size of its frame in pixels.")
      .method("emit", &Projector::emit,
              "The ray of light that leaves a pixel, in the projector's frame, unit direction.",
              py::arg("pixel"))
      .method("intersect", &Projector::intersect,
              "Where the light of a pixel lands on a plane (both in the projector's frame); None\n"
              "when it misses.",
              py::arg("pixel"), py::arg("plane_in_projector"))
      .method("project", &Projector::project,
              "The pixel whose light passes through a point (it may lie outside the picture).",
              py::arg("point_in_projector"))
      .method("throw_ratio", &Projector::throw_ratio,
              "Distance over picture width on a screen across the axis, as on a data sheet (without\n"
              "lens distortion): fx / W.")
      .method("lens_shift", &Projector::lens_shift,
              "How far the optical axis lies from the picture's centre, in picture widths and\n"
              "heights (x right, y down positive). (0, 0.5): the axis passes the bottom edge, the\n"
              "common table-top projector.");
  projector
      .method(
          "project_points",
          [](const Projector& self, const Points3& points) {
            return mapped<2>(points, [&](const Vec3& p) { return self.project(p); });
          },
          kMappedDoc, py::arg("points_in_projector"))
      .method(
          "intersect_points",
          [](const Projector& self, const Points2& pixels, const Plane& plane) {
            return mapped<3>(pixels, [&](const Vec2& p) { return self.intersect(p, plane); });
          },
          kMappedDoc, py::arg("pixels"), py::arg("plane_in_projector"));
}

void bind_frustum(py::module_& m) {
  Enum<GraphicsApi>(m, "GraphicsApi", "Whose clip space a projection matrix is for.")
      .value("kOpenGL", GraphicsApi::kOpenGL, "eye x right, y up, z backward; clip y up, depth -1..1")
      .value("kVulkan", GraphicsApi::kVulkan,
             "eye = optical frame, x right, y down, z forward; clip y down, depth 0..1")
      .value("kDirect3D", GraphicsApi::kDirect3D,
             "eye x right, y up, z forward (left-handed); clip y up, depth 0..1");

  Record<Frustum> frustum(m, "Frustum", "glFrustum's six numbers, metres.");
  frustum.fields_init()
      .field("left", &Frustum::left, "at the near plane, metres")
      .field("right", &Frustum::right, "at the near plane, metres")
      .field("bottom", &Frustum::bottom, "at the near plane, metres")
      .field("top", &Frustum::top, "at the near plane, metres")
      .field("near", &Frustum::near, "distance of the near plane, metres")
      .field("far", &Frustum::far, "distance of the far plane, metres");

  function(m, Gil::kHeld, "frustum", &procam::frustum,
           "The six numbers for intrinsics without skew. Raises ValueError for skew\n"
           "!= 0: use clip_from_eye().",
           py::arg("k"), py::arg("size"), py::arg("near"), py::arg("far"));
  function(m, Gil::kHeld, "eye_from_optical", &procam::eye_from_optical,
           "Eye frame of the API from procam's optical frame (x right, y down, z forward): a\n"
           "change of axis signs.",
           py::arg("api"));
  function(m, Gil::kHeld, "clip_from_optical", &procam::clip_from_optical,
           "The 4x4 matrix (column vectors: clip = M * point) from the optical frame to the\n"
           "API's clip space.",
           py::arg("k"), py::arg("size"), py::arg("near"), py::arg("far"), py::arg("api"));
  function(m, Gil::kHeld, "clip_from_eye", &procam::clip_from_eye,
           "The projection matrix as the API's users know it: from its own eye frame to its clip\n"
           "space.",
           py::arg("k"), py::arg("size"), py::arg("near"), py::arg("far"), py::arg("api"));
}

}  // namespace

void bind_core_lens(py::module_& m) {
  bind_distortion(m);
  bind_intrinsics(m);
  bind_camera(m);
  bind_mirrored_lens(m);
  bind_projector(m);
  bind_frustum(m);
}

}  // namespace procam::python
