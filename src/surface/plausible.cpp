#include "plausible.hpp"

#include <Eigen/LU>
#include <cmath>

#include "lighting.hpp"
#include "procam/core/base/words.hpp"

namespace procam::surface {

namespace {

/// Nobody projects farther, metres: such numbers have another unit.
constexpr double kFarthest = 200;
/// Nor wider, metres, or from so near.
constexpr double kWidest = 100, kWidestFromNear = 10, kWidestByDistance = 30;
/// Content coordinates beyond this are pixels: a measured point is on the content or near it.
constexpr double kLargestContent = 10;
/// Diagonal of the smallest picture, projector pixels.
constexpr double kSmallestPicture = 4;

/// Distance of the content's middle and length of its longer diagonal, metres.
struct Extent {
  double distance = 0, diagonal = 0;
};

Extent extent_of(const PlacedPlane& plane) {
  const Homography plane_from_content(plane.plane_from_content);
  Extent extent;
  if (const auto middle = plane_from_content.apply(Vec2(0.5, 0.5)))
    extent.distance = (plane.projector_from_surface * Vec3(middle->x(), middle->y(), 0)).norm();
  for (const double v : {0.0, 1.0}) {
    const auto from = plane_from_content.apply(Vec2(0, v)), to = plane_from_content.apply(Vec2(1, 1 - v));
    if (from && to) extent.diagonal = std::max(extent.diagonal, (*to - *from).norm());
  }
  return extent;
}

Extent extent_of(const PlacedMesh& mesh) {
  Vec3 sum = Vec3::Zero();
  for (const Vec3& vertex : mesh.mesh->vertices) sum += vertex;
  return {(mesh.projector_from_surface * Vec3(sum / double(mesh.mesh->vertices.size()))).norm(), 0};
}

const Points2* content_of(const SurfaceGeometry& geometry) {
  if (const auto* planar = std::get_if<PlanarSurface>(&geometry)) return &planar->content;
  if (const auto* pixel = std::get_if<PixelSurface>(&geometry)) return &pixel->content;
  return nullptr;
}

double largest_coordinate(const Points2& points) {
  double largest = 0;
  for (const Vec2& point : points) largest = std::max(largest, point.cwiseAbs().maxCoeff());
  return largest;
}

/// Empty, or that the content's coordinates are pixels.
std::string content_in_pixels(const SurfaceGeometry& geometry) {
  const Points2* content = content_of(geometry);
  const double largest = content != nullptr ? largest_coordinate(*content) : 0;
  if (!(largest > kLargestContent)) return {};
  return "its content points reach " + significant(largest, 4) +
         ", but content coordinates run from 0 to 1 and seem to be in pixels; divide them by the content's "
         "width and height";
}

}  // namespace

void judge_units(SolvedSurface& solved) {
  Extent extent;
  if (const auto* plane = std::get_if<PlacedPlane>(&solved.placement)) extent = extent_of(*plane);
  if (const auto* mesh = std::get_if<PlacedMesh>(&solved.placement); mesh && mesh->mesh)
    extent = extent_of(*mesh);
  const bool too_wide = extent.diagonal > kWidest || (extent.diagonal > kWidestFromNear &&
                                                      extent.diagonal > kWidestByDistance * extent.distance);
  if (extent.distance > kFarthest)
    solved.diagnostics.warn("implausible_units",
                            "it is " + std::to_string(std::llround(extent.distance)) +
                                " m from the projector: its numbers, or those of the pose, seem to be in "
                                "millimetres; write them in metres");
  else if (too_wide)
    solved.diagnostics.warn("implausible_units", "its content has a diagonal of " +
                                                     std::to_string(std::llround(extent.diagonal)) + " m, " +
                                                     significant(extent.distance, 2) +
                                                     " m from the projector: its points seem to be in "
                                                     "millimetres; write them in metres");
}

void judge_size(SolvedSurface& solved) {
  const std::string pixels = content_in_pixels(solved.surface.geometry);
  double diagonal = kSmallestPicture;
  if (const auto& corners = solved.corners_px)
    diagonal = std::max(((*corners)[2] - (*corners)[0]).norm(), ((*corners)[3] - (*corners)[1]).norm());
  if (!(diagonal < kSmallestPicture)) {
    if (!pixels.empty()) solved.diagnostics.warn("implausible_units", pixels);
    return;
  }
  const auto* pixel = std::get_if<PixelSurface>(&solved.surface.geometry);
  std::string cause = pixels;
  if (cause.empty() && pixel != nullptr)
    cause = "at_px seem to be divided by the frame's size; write projector pixels";
  if (cause.empty()) cause = "check its points (at_m in metres) and the distance of the surface";
  solved.diagnostics.fail("too_small", "all of its content falls within " + significant(diagonal, 2) +
                                           " projector pixels: " + cause);
}

void judge_mirrored(const Projector& projector, SolvedSurface& solved) {
  constexpr const char* kNext =
      "if that is not meant, correct the order of its points or the sign of an axis";
  if (const auto* plane = std::get_if<PlacedPlane>(&solved.placement)) {
    const Mat3& h = plane->plane_from_content;
    const double denominator = h.row(2).dot(Vec3(0.5, 0.5, 1));
    // From behind the reader may stand on either side: "seen_from_behind" asks for it.
    if (solved.visibility.facing && h.determinant() * denominator < 0)
      solved.diagnostics.warn("mirrored",
                              std::string("its content is mirrored for a reader on the projector's side (x "
                                          "goes to the right and y down, as in the content); ") +
                                  kNext);
  } else if (const auto* pixels = std::get_if<PlacedPixels>(&solved.placement)) {
    constexpr double kStep = 0.01;
    const auto middle = lighting_pixel(projector, *pixels, Vec2(0.5, 0.5)),
               right = lighting_pixel(projector, *pixels, Vec2(0.5 + kStep, 0.5)),
               below = lighting_pixel(projector, *pixels, Vec2(0.5, 0.5 + kStep));
    if (!middle || !right || !below) return;
    const Vec2 du = *right - *middle, dv = *below - *middle;
    if (du.x() * dv.y() - du.y() * dv.x() < 0)
      solved.diagnostics.warn("mirrored",
                              std::string("its content is mirrored in the projector's frame, as for rear "
                                          "projection; ") +
                                  kNext);
  }
}

}  // namespace procam::surface
