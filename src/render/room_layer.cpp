#include "room_layer.hpp"

#include <Eigen/LU>
#include <cmath>

#include "footprint.hpp"

namespace procam::render {

namespace {

/// The directions of the whole picture lie within `angle` of `axis` (unit).
struct ViewCone {
  Vec3 axis = Vec3::UnitZ();
  double angle = kPi;

  explicit ViewCone(const Projector& projector) {
    const ImageSize size = projector.size();
    std::vector<Vec3> rim;
    Vec3 sum = Vec3::Zero();
    constexpr int kSteps = 32;
    for (int i = 0; i <= kSteps; ++i)
      for (int j = 0; j <= kSteps; ++j) {
        if (i != 0 && i != kSteps && j != 0 && j != kSteps) continue;
        const auto ray =
            projector.emit(Vec2(-1 + (size.width + 1.0) * i / kSteps, -1 + (size.height + 1.0) * j / kSteps));
        if (!ray) return;  // part of the picture lies beyond the lens model: no cone is certain
        rim.push_back(ray->direction.normalized());
        sum += rim.back();
      }
    axis = sum.normalized();
    double least = 1;
    for (const Vec3& d : rim) least = std::min(least, d.dot(axis));
    angle = std::acos(std::max(-1.0, least)) + 0.01;
  }

  /// Can light of the picture meet the ball?
  bool meets(const Vec3& centre, double radius) const {
    const double distance = centre.norm();
    if (distance <= radius) return true;
    const double to_centre = std::acos(std::max(-1.0, std::min(1.0, centre.dot(axis) / distance)));
    return to_centre - std::asin(radius / distance) <= angle;
  }
};

constexpr double kBoxMargin = 1.5;      ///< px: the pixel's own half, and the neighbours that tell an edge
constexpr double kStraightWithin = 24;  ///< px: over which an edge may be taken as straight through any lens

FacetBox box_of(const Projector& projector, const std::array<Vec3, 3>& corners,
                const std::array<std::optional<Vec2>, 3>& pixels, int facet) {
  const ImageSize size = projector.size();
  if (!pixels[0] || !pixels[1] || !pixels[2]) return {0, 0, size.width, size.height, facet};
  Vec2 low = pixels[0]->cwiseMin(*pixels[1]).cwiseMin(*pixels[2]);
  Vec2 high = pixels[0]->cwiseMax(*pixels[1]).cwiseMax(*pixels[2]);
  if ((high - low).maxCoeff() > kStraightWithin) {
    // Lenses bend long edges: by what the middles are off, and half as much again.
    double bend = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec2 &a = *pixels[i], &b = *pixels[(i + 1) % 3];
      const Vec3 &p = corners[i], &q = corners[(i + 1) % 3];
      for (const double s : {0.25, 0.5, 0.75}) {
        const auto between = projector.pixel_lighting((1 - s) * p + s * q);
        if (!between) return {0, 0, size.width, size.height, facet};
        const Vec2 along = b - a;
        const double length = along.norm();
        if (length > 0)
          bend = std::max(bend,
                          std::abs(along.x() * (*between - a).y() - along.y() * (*between - a).x()) / length);
      }
    }
    low.array() -= 1.5 * bend;
    high.array() += 1.5 * bend;
  }
  const auto whole = [](double v, int most) { return int(std::min(std::max(v, 0.0), double(most))); };
  return {whole(std::floor(low.x() - kBoxMargin), size.width),
          whole(std::floor(low.y() - kBoxMargin), size.height),
          whole(std::ceil(high.x() + kBoxMargin) + 1, size.width),
          whole(std::ceil(high.y() + kBoxMargin) + 1, size.height), facet};
}

void set(const Vec3& from, float (&to)[3]) {
  for (int k = 0; k < 3; ++k) to[k] = float(from[k]);
}

}  // namespace

RoomLayer::RoomLayer(const PlacedPlane& placed, const TileGrid& grid) : is_plane_(true), grid_(grid) {
  const Pose& pose = placed.projector_from_surface;
  Mat3 direction_from_plane = pose.rotation_matrix();
  direction_from_plane.col(2) = pose.translation;
  const Mat3 direction_from_content = direction_from_plane * placed.plane_from_content;
  const double scale = direction_from_content.norm();
  if (std::abs(direction_from_content.determinant()) > 1e-15 * scale * scale * scale) {  // else edge-on
    Facet facet;
    facet.content_from_direction = direction_from_content.inverse();
    set(direction_from_plane.inverse().row(2).transpose(), facet.nearness);
    for (std::size_t i = 0; i < 4; ++i)
      set((border_combinations()[i] * facet.content_from_direction).normalized().transpose(),
          facet.borders[i]);
    facets_.push_back(facet);
    boxes_.push_back({0, 0, grid.frame.width, grid.frame.height, 0});
  }
  make_views();
}

RoomLayer::RoomLayer(const PlacedMesh& placed, const Projector& projector, const TileGrid& grid,
                     Workers& workers)
    : is_plane_(false), grid_(grid) {
  constexpr std::size_t kAtOnce = 4096;  // vertices or triangles a turn
  const Mesh& mesh = *placed.mesh;
  const ViewCone cone(projector);
  const Mat3 rotation = placed.projector_from_surface.rotation_matrix();
  const std::size_t vertices = mesh.vertices.size(), triangles = mesh.triangles.size();
  Points3 points(vertices);
  std::vector<std::optional<Vec2>> pixels(vertices);
  workers.run(int((vertices + kAtOnce - 1) / kAtOnce), [&](int turn) {
    const std::size_t first = std::size_t(turn) * kAtOnce;
    for (std::size_t i = first; i < std::min(first + kAtOnce, vertices); ++i) {
      points[i] = rotation * mesh.vertices[i] + placed.projector_from_surface.translation;
      pixels[i] = projector.pixel_lighting(points[i]);
    }
  });

  struct Part {
    std::vector<Facet> facets;
    std::vector<FacetBox> boxes;
  };
  std::vector<Part> parts((triangles + kAtOnce - 1) / kAtOnce);
  workers.run(int(parts.size()), [&](int turn) {
    Part& part = parts[std::size_t(turn)];
    const std::size_t first = std::size_t(turn) * kAtOnce, last = std::min(first + kAtOnce, triangles);
    part.facets.reserve(last - first);
    part.boxes.reserve(last - first);
    for (std::size_t n = first; n < last; ++n) {
      std::array<Vec3, 3> p;
      std::array<std::optional<Vec2>, 3> px;
      Mat3 uv;
      for (std::size_t i = 0; i < 3; ++i) {
        const auto corner = std::size_t(mesh.triangles[n][i]);
        p[i] = points[corner];
        px[i] = pixels[corner];
        uv.col(Eigen::Index(i)) = placed.content_from_point
                                      ? Vec3(*placed.content_from_point * mesh.vertices[corner].homogeneous())
                                      : Vec3(mesh.uv[corner].homogeneous());
      }
      const FacetBox box = box_of(projector, p, px, int(part.facets.size()));
      if (box.x0 >= box.x1 || box.y0 >= box.y1) continue;
      if (!px[0] || !px[1] || !px[2]) {  // its box is the whole frame
        const Vec3 centre = (p[0] + p[1] + p[2]) / 3;
        double radius = 0;
        for (const Vec3& corner : p) radius = std::max(radius, (corner - centre).norm());
        if (!cone.meets(centre, radius)) continue;
      }
      // Neighbours share an edge's cross product up to its sign, exactly: no ray slips between them.
      const std::array<Vec3, 3> edges{p[1].cross(p[2]), p[2].cross(p[0]), p[0].cross(p[1])};
      const double determinant = p[0].dot(edges[0]);
      if (!(std::abs(determinant) > 1e-12 * p[0].norm() * edges[0].norm())) continue;  // edge-on
      Facet facet;
      for (std::size_t i = 0; i < 4; ++i)
        set((determinant < 0 ? -1 : 1) * edges[std::min<std::size_t>(i, 2)].normalized(), facet.borders[i]);
      Mat3 barycentric_from_direction;
      barycentric_from_direction << edges[0].transpose(), edges[1].transpose(), edges[2].transpose();
      barycentric_from_direction /= determinant;
      facet.content_from_direction = uv * barycentric_from_direction;
      set(barycentric_from_direction.colwise().sum().transpose(), facet.nearness);
      part.facets.push_back(facet);
      part.boxes.push_back(box);
    }
  });
  facets_.reserve(triangles);
  boxes_.reserve(triangles);
  for (const Part& part : parts) {
    const int before = int(facets_.size());
    facets_.insert(facets_.end(), part.facets.begin(), part.facets.end());
    for (FacetBox box : part.boxes) {
      box.facet += before;
      boxes_.push_back(box);
    }
  }
  make_views();
  sort_into_tiles();
}

void RoomLayer::make_views() {
  views_.resize(std::max<std::size_t>(facets_.size(), 1));  // the kernels read the first in any case
  for (std::size_t i = 0; i < facets_.size(); ++i) {
    const Facet& facet = facets_[i];
    for (int k = 0; k < 9; ++k) views_[i].content[k] = float(facet.content_from_direction(k / 3, k % 3));
    std::copy_n(facet.nearness, 3, views_[i].nearness);
  }
}

void RoomLayer::sort_into_tiles() {
  tiles_.resize(std::size_t(grid_.across()) * std::size_t(grid_.down()));
  for (const FacetBox& box : boxes_)
    for (int y = box.y0 / kTileHeight; y <= (box.y1 - 1) / kTileHeight; ++y)
      for (int x = box.x0 / kTileWidth; x <= (box.x1 - 1) / kTileWidth; ++x)
        tiles_[std::size_t(y * grid_.across() + x)].push_back(box);
}

}  // namespace procam::render
