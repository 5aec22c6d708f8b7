#include "visibility.hpp"

#include <Eigen/LU>
#include <cmath>

#include "lighting.hpp"
#include "plausible.hpp"
#include "procam/core/base/closed_form.hpp"

namespace procam::surface {

namespace {

constexpr int kSamples = 128;  ///< a side of the content, for the covered share: it is right to about 1/128

std::optional<Vec2> in_plane(const Mat3& destination_from_content, const Vec2& uv) {
  return Homography(destination_from_content).apply(uv);
}

/// How much content there is at a place of the surface, 0..1.
double alpha_at(const ContentShape& shape, const Vec2& uv) {
  if (!in_shape(shape, uv)) return 0;
  if (!shape.mask) return 1;
  const ImageU8& mask = *shape.mask;
  const auto texel = [](double at, int count) { return std::min(std::max(int(at * count), 0), count - 1); };
  return mask.at(texel(uv.x(), mask.width()), texel(uv.y(), mask.height())) / 255.0;
}

template <typename Placed>
double covered_share(const Projector& projector, const Placed& placed, const ContentShape& shape) {
  double covered = 0, whole = 0;
  for (int j = 0; j < kSamples; ++j)
    for (int i = 0; i < kSamples; ++i) {
      const Vec2 uv = Vec2(i + 0.5, j + 0.5) / kSamples;
      const double alpha = alpha_at(shape, uv);
      whole += alpha;
      const auto pixel = lighting_pixel(projector, placed, uv);
      if (pixel && projector.size().contains(*pixel)) covered += alpha;
    }
  return whole > 0 ? covered / whole : 0;
}

template <typename Placed>
std::optional<Points2> corners(const Projector& projector, const Placed& placed) {
  Points2 result;
  for (const Vec2& uv : {Vec2(0, 0), Vec2(1, 0), Vec2(1, 1), Vec2(0, 1)}) {
    const auto pixel = lighting_pixel(projector, placed, uv);
    if (!pixel) return std::nullopt;
    result.push_back(*pixel);
  }
  return result;
}

/// Widens the range of pixel sizes by the one at a surface point: the singular values of d (mm) / d (pixel),
/// for steps along `right` and `down` (unit, across each other, in the surface).
void measure_pixel(const Projector& projector, const Vec3& point, const Vec3& right, const Vec3& down,
                   Visibility& visibility) {
  const auto centre = projector.project(point);
  if (!centre || !projector.size().contains(*centre)) return;
  constexpr double kStep = 1e-5;  // metres: central differences, good to 1e-8 of the value
  const auto east = projector.project(point + kStep * right), west = projector.project(point - kStep * right),
             south = projector.project(point + kStep * down), north = projector.project(point - kStep * down);
  if (!east || !west || !south || !north) return;
  Mat2 pixel_by_metre;
  pixel_by_metre << *east - *west, *south - *north;
  pixel_by_metre /= 2 * kStep;
  const Vec2 stretch = singular_values(pixel_by_metre);
  if (!(stretch[1] > 0)) return;
  const double finest = 1e3 / stretch[0], coarsest = 1e3 / stretch[1];
  visibility.mm_per_pixel_min =
      visibility.mm_per_pixel_max == 0 ? finest : std::min(visibility.mm_per_pixel_min, finest);
  visibility.mm_per_pixel_max = std::max(visibility.mm_per_pixel_max, coarsest);
}

/// Over the part of the content inside the picture.
void measure_pixels(const Projector& projector, const PlacedPlane& placed, Visibility& visibility) {
  constexpr int kGrid = 16;
  for (int j = 0; j <= kGrid; ++j)
    for (int i = 0; i <= kGrid; ++i) {
      const auto p = in_plane(placed.plane_from_content, Vec2(i, j) / kGrid);
      if (!p) continue;
      const Pose& pose = placed.projector_from_surface;
      measure_pixel(projector, pose * Vec3(p->x(), p->y(), 0), pose.rotate(Vec3::UnitX()),
                    pose.rotate(Vec3::UnitY()), visibility);
    }
}

void warn_of_rear_projection(Diagnostics& diagnostics) {
  diagnostics.warn("seen_from_behind",
                   "the projector stands behind the surface: a reader in front sees the content through it "
                   "(rear projection); if that is not meant, the surface's z axis must point into the wall");
}

void warn_of_grazing(const SolveOptions& options, const Visibility& visibility, Diagnostics& diagnostics) {
  if (visibility.incidence_deg > options.largest_incidence_deg)
    diagnostics.warn("grazing", "light meets the surface at " +
                                    std::to_string(int(std::lround(visibility.incidence_deg))) +
                                    " degrees to its normal: small errors of the pose become large; move the "
                                    "projector towards its front");
}

/// Can light of the projector meet the plane of the content at all, and from which side?
bool judge_side(const PlacedPlane& placed, const SolveOptions& options, Visibility& visibility,
                Diagnostics& diagnostics) {
  const Pose& pose = placed.projector_from_surface;
  const Vec3 into_wall = pose.rotate(Vec3::UnitZ());
  const double height = into_wall.dot(pose.translation);  // of the projector above the plane, reading side
  visibility.facing = height > 0;
  const std::optional<Vec2> middle = in_plane(placed.plane_from_content, Vec2(0.5, 0.5));
  if (!middle) return true;
  const Vec3 to_middle = pose * Vec3(middle->x(), middle->y(), 0);
  const double cosine = std::abs(height) / to_middle.norm();
  visibility.incidence_deg = std::acos(std::min(1.0, cosine)) / kDegree;
  if (!(cosine > 1e-6)) {
    diagnostics.fail("edge_on",
                     "the projector stands in the surface's plane: no light can land; move the "
                     "projector or correct the pose");
    return false;
  }
  if (!visibility.facing) warn_of_rear_projection(diagnostics);
  warn_of_grazing(options, visibility, diagnostics);
  return true;
}

/// Where light grazes a curved surface at more than 80 degrees a pixel's size is meaningless.
constexpr double kLimbCosine = 0.1736;

/// A mesh is looked at where points are spread evenly over its area.
struct MeshLook {
  double area = 0, reached = 0, in_front = 0, facing = 0;
};

/// `reading_side_only`: light reaches only what is turned towards the projector.
MeshLook look_at_mesh(const Projector& projector, const PlacedMesh& placed, const ContentShape& shape,
                      bool reading_side_only, Visibility& visibility) {
  const Mesh& mesh = *placed.mesh;
  double whole = 0;
  for (const auto& triangle : mesh.triangles) whole += area_vector(mesh, triangle).norm();
  MeshLook look;
  double nearest_to_centre = 1e300;
  for (const auto& triangle : mesh.triangles) {
    const auto corner = [&](std::size_t i) -> const Vec3& { return mesh.vertices[std::size_t(triangle[i])]; };
    const auto uv = [&](std::size_t i) -> const Vec2& { return mesh.uv[std::size_t(triangle[i])]; };
    const Vec2 du = uv(1) - uv(0), dv = uv(2) - uv(0);
    // The sense in which the content reads: x right and y down make z into the wall.
    const double sense = du.x() * dv.y() - du.y() * dv.x();
    const Vec3 area = area_vector(mesh, triangle);
    const Vec3 into_wall =
        placed.projector_from_surface.rotate(Vec3((sense < 0 ? -1 : 1) * area / area.norm()));
    const int side = std::max(1, int(std::lround(kSamples * std::sqrt(area.norm() / whole))));
    const double whole_share = area.norm() / (0.5 * side * (side + 1));
    const Vec3 right = into_wall.unitOrthogonal(), down = into_wall.cross(right);
    for (int j = 0; j < side; ++j)
      for (int i = 0; i + j < side; ++i) {
        const double s = (i + 1.0 / 3) / side, t = (j + 1.0 / 3) / side;
        const Vec3 point = placed.projector_from_surface *
                           Vec3(corner(0) + s * (corner(1) - corner(0)) + t * (corner(2) - corner(0)));
        const double cosine = into_wall.dot(point) / point.norm();
        const double share = whole_share * alpha_at(shape, uv(0) + s * du + t * dv);
        look.area += share;
        if (cosine > 0) look.facing += share;
        const auto pixel = projector.project(point);
        if (pixel) look.in_front += share;
        if (!pixel || !projector.size().contains(*pixel) || (reading_side_only && !(cosine > 0))) continue;
        look.reached += share;
        if (std::abs(cosine) > kLimbCosine) measure_pixel(projector, point, right, down, visibility);
        const double from_centre = (uv(0) + s * du + t * dv - Vec2(0.5, 0.5)).norm();
        if (from_centre < nearest_to_centre) {
          nearest_to_centre = from_centre;
          visibility.incidence_deg = std::acos(std::min(1.0, std::abs(cosine))) / kDegree;
        }
      }
  }
  return look;
}

void judge_coverage(const SolveOptions& options, bool in_front, SolvedSurface& solved) {
  const double share = solved.visibility.covered_share;
  Diagnostics& diagnostics = solved.diagnostics;
  if (!in_front)
    diagnostics.fail(
        "behind_projector",
        "all of it lies behind the projector or outside what its lens can light; check the pose's "
        "direction (projector_from_world, not its inverse) or turn the projector");
  else if (share == 0)
    diagnostics.warn(
        "outside_picture",
        "nothing of it falls inside the projector's picture; turn the projector or move the surface");
  else if (share < options.min_covered_share)
    diagnostics.warn("partly_outside",
                     "only " + std::to_string(int(std::floor(100 * share))) +
                         " % of it falls inside the projector's picture; the rest stays dark");
}

}  // namespace

void look_at(const Projector& projector, const SolveOptions& options, SolvedSurface& solved) {
  judge_units(solved);
  const auto look = [&](const auto& placed) {
    solved.corners_px = corners(projector, placed);
    solved.visibility.covered_share = covered_share(projector, placed, solved.surface.shape);
    bool in_front = solved.visibility.covered_share > 0;
    for (int j = 0; j <= 8 && !in_front; ++j)
      for (int i = 0; i <= 8 && !in_front; ++i)
        in_front = lighting_pixel(projector, placed, Vec2(i, j) / 8).has_value();
    judge_coverage(options, in_front, solved);
    judge_size(solved);
    judge_mirrored(projector, solved);
  };
  if (const auto* mesh = std::get_if<PlacedMesh>(&solved.placement)) {
    MeshLook seen = look_at_mesh(projector, *mesh, solved.surface.shape, true, solved.visibility);
    solved.visibility.facing = seen.facing > 0;
    if (!solved.visibility.facing) {
      seen = look_at_mesh(projector, *mesh, solved.surface.shape, false, solved.visibility);
      warn_of_rear_projection(solved.diagnostics);
    }
    solved.visibility.covered_share = seen.area > 0 ? seen.reached / seen.area : 0;
    judge_coverage(options, seen.in_front > 0, solved);
    warn_of_grazing(options, solved.visibility, solved.diagnostics);
    return;
  }
  if (const auto* plane = std::get_if<PlacedPlane>(&solved.placement)) {
    if (!judge_side(*plane, options, solved.visibility, solved.diagnostics)) return;
    look(*plane);
    measure_pixels(projector, *plane, solved.visibility);
  } else {
    look(std::get<PlacedPixels>(solved.placement));
  }
}

}  // namespace procam::surface
