#include "procam/surface/lay_out.hpp"

#include <Eigen/LU>
#include <map>

#include "content_aspect.hpp"
#include "procam/core/geometry/homography.hpp"
#include "shape_mask.hpp"

namespace procam::surface {

namespace {

std::optional<double> ratio(double width, double height) {
  const double aspect = width / height;
  return aspect > 0 && std::isfinite(aspect) ? std::optional(aspect) : std::nullopt;
}

std::optional<double> aspect_of(const Mat3& destination_from_content) {
  const Homography h(destination_from_content);
  const auto left = h.apply(Vec2(0, 0.5)), right = h.apply(Vec2(1, 0.5)), top = h.apply(Vec2(0.5, 0)),
             bottom = h.apply(Vec2(0.5, 1));
  if (!left || !right || !top || !bottom) return std::nullopt;
  return ratio((*right - *left).norm(), (*bottom - *top).norm());
}
std::optional<double> aspect_of(const PlacedPlane& placed) {
  return aspect_of(placed.plane_from_content);
}
std::optional<double> aspect_of(const Mesh& mesh) {
  double along_u = 0, along_v = 0;
  for (const auto& triangle : mesh.triangles) {
    const auto corner = [&](std::size_t i) -> const Vec3& { return mesh.vertices[std::size_t(triangle[i])]; };
    const auto uv = [&](std::size_t i) -> const Vec2& { return mesh.uv[std::size_t(triangle[i])]; };
    const Vec2 a = uv(1) - uv(0), b = uv(2) - uv(0);
    const Vec3 p = corner(1) - corner(0), q = corner(2) - corner(0);
    // dX/du = (b_v p - a_v q) / area, dX/dv = (a_u q - b_u p) / area; times the area in (u, v).
    along_u += (b.y() * p - a.y() * q).norm();
    along_v += (a.x() * q - b.x() * p).norm();
  }
  return ratio(along_u, along_v);
}
std::optional<double> aspect_of(const PlacedMesh& placed) {
  return aspect_of(*placed.mesh);
}
std::optional<double> aspect_of(const PlacedPixels& placed) {
  return placed.mesh ? aspect_of(*placed.mesh) : aspect_of(placed.pixel_from_content);
}

/// The part of a mesh where coordinate `axis` of its uv, times `sign`, is at least `bound`. Triangles that
/// share a side still do: each side is cut once.
Mesh cut(const Mesh& mesh, int axis, double sign, double bound) {
  Mesh kept{mesh.vertices, mesh.uv, {}};
  std::map<std::pair<int, int>, int> cuts;
  const auto inside = [&](int i) { return sign * mesh.uv[std::size_t(i)][axis] - bound; };
  const auto between = [&](int i, int j) {
    const auto [place, is_new] = cuts.emplace(std::minmax(i, j), int(kept.vertices.size()));
    if (is_new) {
      const auto a = std::size_t(std::min(i, j)), b = std::size_t(std::max(i, j));
      const double s = inside(int(a)) / (inside(int(a)) - inside(int(b)));
      kept.vertices.push_back((1 - s) * mesh.vertices[a] + s * mesh.vertices[b]);
      kept.uv.push_back((1 - s) * mesh.uv[a] + s * mesh.uv[b]);
    }
    return place->second;
  };
  for (const std::array<int, 3>& triangle : mesh.triangles) {
    std::vector<int> ring;
    for (std::size_t k = 0; k < 3; ++k) {
      const int i = triangle[k], j = triangle[(k + 1) % 3];
      if (inside(i) >= 0) ring.push_back(i);
      if ((inside(i) > 0 && inside(j) < 0) || (inside(i) < 0 && inside(j) > 0)) ring.push_back(between(i, j));
    }
    for (std::size_t k = 2; k < ring.size(); ++k) {
      const std::array<int, 3> part{ring[0], ring[k - 1], ring[k]};
      if (area_vector(kept, part).norm() > 1e-12 * area_vector(mesh, triangle).norm())
        kept.triangles.push_back(part);
    }
  }
  return kept;
}

/// The surface's content coordinates where the picture's corners come to lie.
struct Place {
  Vec2 from = Vec2(0, 0), to = Vec2(1, 1);

  bool is_whole() const { return from == Vec2(0, 0) && to == Vec2(1, 1); }
  Mat3 content_from_picture() const {
    Mat3 matrix;
    matrix << to.x() - from.x(), 0, from.x(), 0, to.y() - from.y(), from.y(), 0, 0, 1;
    return matrix;
  }
};

PlacedPlane narrowed(PlacedPlane placed, const Place& place) {
  placed.plane_from_content *= place.content_from_picture();
  return placed;
}
std::shared_ptr<const Mesh> narrowed(Mesh mesh, const Place& place) {
  for (int axis = 0; axis < 2; ++axis) {
    mesh = cut(mesh, axis, 1, place.from[axis]);
    mesh = cut(mesh, axis, -1, -place.to[axis]);
  }
  for (Vec2& uv : mesh.uv) uv = (uv - place.from).cwiseQuotient(place.to - place.from);
  return std::make_shared<const Mesh>(std::move(mesh));
}
PlacedMesh narrowed(const PlacedMesh& placed, const Place& place) {
  return {narrowed(*placed.mesh, place), placed.projector_from_surface};
}
PlacedPixels narrowed(PlacedPixels placed, const Place& place) {
  placed.pixel_from_content *= place.content_from_picture();
  if (placed.mesh) placed.mesh = narrowed(*placed.mesh, place);
  return placed;
}

/// Whole pixels of [from, to] on a side of `pixels`, at least one.
void crop(double from, double to, int pixels, int& first, int& count) {
  first = std::min(int(std::lround(from * pixels)), pixels - 1);
  count = std::max(1, std::min(int(std::lround(to * pixels)), pixels) - first);
}

/// `least` of them is kept of `count`, from the middle.
void narrow(double wanted, int& first, int& count) {
  const int kept = std::min(count, std::max(1, int(std::lround(wanted))));
  first += (count - kept) / 2;
  count = kept;
}

}  // namespace

std::optional<double> content_aspect(const Placement& placement) {
  return std::visit([](const auto& placed) { return aspect_of(placed); }, placement);
}

LaidOut lay_out(const Placement& placement, const Surface& surface, ImageSize picture) {
  require(picture.width > 0 && picture.height > 0, "lay_out: the picture is empty");
  const auto refuse = [&](const std::string& why, const char* next) {
    throw Error(ErrorKind::kInput, "surface '" + surface.name + "'", why, next);
  };
  const ContentLayout& layout = surface.layout;
  if (!(layout.crop_from.x() >= 0 && layout.crop_from.y() >= 0 && layout.crop_to.x() <= 1 &&
        layout.crop_to.y() <= 1 && layout.crop_from.x() < layout.crop_to.x() &&
        layout.crop_from.y() < layout.crop_to.y()))
    refuse("its crop has no area, or goes beyond the picture", "give left, top, right, bottom from 0 to 1");
  if (const auto fault = fault_of(surface.shape)) refuse(*fault, "correct its outline, holes and mask");

  LaidOut laid;
  crop(layout.crop_from.x(), layout.crop_to.x(), picture.width, laid.x, laid.size.width);
  crop(layout.crop_from.y(), layout.crop_to.y(), picture.height, laid.y, laid.size.height);
  Place place;
  const std::optional<double> area = content_aspect(placement);
  const bool is_color = picture.width == 1 && picture.height == 1;
  if (area && !is_color && layout.fit != Fit::kStretch) {
    const double shown = double(laid.size.width) / laid.size.height;
    const int axis =
        (shown > *area) == (layout.fit == Fit::kContain) ? 1 : 0;  // in which something is given up
    if (layout.fit == Fit::kContain) {
      const double share = axis == 1 ? *area / shown : shown / *area;
      place.from[axis] = 0.5 - 0.5 * share;
      place.to[axis] = 0.5 + 0.5 * share;
    } else if (axis == 0) {
      narrow(laid.size.height * *area, laid.x, laid.size.width);
    } else {
      narrow(laid.size.width / *area, laid.y, laid.size.height);
    }
  }
  laid.placement = placement;
  if (!place.is_whole())
    laid.placement =
        std::visit([&](const auto& placed) -> Placement { return narrowed(placed, place); }, placement);
  if (surface.shape.is_whole()) return laid;

  const double aspect = std::min(
      64.0, std::max(1 / 64.0, area.value_or(1) * (place.to - place.from).x() / (place.to - place.from).y()));
  const ImageSize size{aspect >= 1 ? kMaskSide : int(std::lround(kMaskSide * aspect)),
                       aspect >= 1 ? int(std::lround(kMaskSide / aspect)) : kMaskSide};
  laid.mask = shape_mask(surface.shape, place.from, place.to, size);
  return laid;
}

}  // namespace procam::surface
