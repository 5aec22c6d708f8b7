#include "mesh_layer.hpp"

#include <Eigen/LU>
#include <cmath>
#include <limits>

#include "footprint.hpp"

namespace procam::render {

/// The directions of the whole picture lie within `angle` of `axis` (unit).
struct MeshLayer::ViewCone {
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

namespace {

/// px: over which an edge may be taken as straight through any lens, to the margin.
constexpr double kStraightWithin = 24;
constexpr float kBoxMargin = 0.02f;  ///< px: what floats make, and
constexpr float kBoxBend = 0.3f;     ///< what a lens does

void set(const Vec3& from, float (&to)[3]) {
  for (int k = 0; k < 3; ++k) to[k] = float(from[k]);
}

std::int16_t whole(float v, int most) {
  return std::int16_t(std::min(std::max(v, -1.0f), float(most)));
}

FacetBox whole_frame(ImageSize frame) {
  return {-1, -1, std::int16_t(frame.width + 1), std::int16_t(frame.height + 1), 0};
}

}  // namespace

MeshLayer::MeshLayer(const PlacedPlane& placed, const TileGrid& grid) : is_plane_(true), grid_(grid) {
  const Pose& pose = placed.projector_from_surface;
  Mat3 direction_from_plane = pose.rotation_matrix();
  direction_from_plane.col(2) = pose.translation;
  const Mat3 direction_from_content = direction_from_plane * placed.plane_from_content;
  const double scale = direction_from_content.norm();
  if (!(std::abs(direction_from_content.determinant()) > 1e-15 * scale * scale * scale)) return;  // edge-on
  Facet facet;
  const Mat3 content_from_direction = direction_from_content.inverse();
  set(direction_from_plane.inverse().row(2).transpose(), facet.nearness);
  for (int k = 0; k < 3; ++k) set(content_from_direction.row(k).transpose(), facet.content[k]);
  for (std::size_t i = 0; i < 4; ++i)  // unit borders, so that floats do: an edge's place to 1e-7
    set((border_combinations()[i] * content_from_direction).normalized().transpose(), facet.borders[i]);
  facets_.push_back(facet);
  boxes_.push_back(whole_frame(grid.frame));
}

void MeshLayer::move(const PlacedMesh& placed, const Projector& projector, const TileGrid& grid,
                     Workers& workers) {
  constexpr std::size_t kMinAtOnce = 4096, kMaxParts = 32;
  grid_ = grid;
  place_corners(placed, projector, workers);

  const std::size_t triangles = placed.mesh->triangles.size();
  const std::size_t parts = std::min((triangles + kMinAtOnce - 1) / kMinAtOnce, kMaxParts);
  facets_.resize(triangles);
  boxes_.resize(triangles);
  parts_.resize(parts);
  const ViewCone cone(projector);
  workers.run(int(parts), [&](int turn) {
    const auto n = std::size_t(turn);
    parts_[n].first = triangles * n / parts;
    parts_[n].last = triangles * (n + 1) / parts;
    set_up(placed, projector, cone, parts_[n]);
  });
  sort_into_tiles(workers);
}

void MeshLayer::place_corners(const PlacedMesh& placed, const Projector& projector, Workers& workers) {
  constexpr std::size_t kAtOnce = 4096;
  const Points3& vertices = placed.mesh->vertices;
  const Mat3 rotation = placed.projector_from_surface.rotation_matrix();
  const Vec3 translation = placed.projector_from_surface.translation;
  corners_.resize(vertices.size());
  pixels_.resize(vertices.size());
  workers.run(int((vertices.size() + kAtOnce - 1) / kAtOnce), [&](int turn) {
    const std::size_t first = std::size_t(turn) * kAtOnce;
    for (std::size_t i = first; i < std::min(first + kAtOnce, vertices.size()); ++i) {
      corners_[i] = rotation * vertices[i] + translation;
      const auto pixel = projector.project(corners_[i]);
      const float x = pixel ? float(pixel->x()) : std::numeric_limits<float>::quiet_NaN();
      const float y = pixel ? float(pixel->y()) : x;
      pixels_[i] = {x, y, -x, -y};
    }
  });
}

FacetBox MeshLayer::box_of(const Projector& projector, const ViewCone& cone,
                           const std::array<int, 3>& triangle) const {
  const ImageSize frame = grid_.frame;
  const auto pixel = [&](std::size_t i) -> const CornerPixel& { return pixels_[std::size_t(triangle[i])]; };
  const CornerPixel &a = pixel(0), &b = pixel(1), &c = pixel(2);
  const auto corner = [&](std::size_t i) -> const Vec3& { return corners_[std::size_t(triangle[i])]; };
  const float sum = a.x + b.x + c.x;
  if (sum != sum) {  // a corner is nowhere in the picture
    const Vec3 centre = (corner(0) + corner(1) + corner(2)) / 3;
    double radius = 0;
    for (std::size_t i = 0; i < 3; ++i) radius = std::max(radius, (corner(i) - centre).norm());
    return cone.meets(centre, radius) ? whole_frame(frame) : FacetBox{};
  }
  const auto least = [](float p, float q, float r) { return std::min(std::min(p, q), r); };
  const float x0 = least(a.x, b.x, c.x), y0 = least(a.y, b.y, c.y);
  const float x1 = -least(a.minus_x, b.minus_x, c.minus_x), y1 = -least(a.minus_y, b.minus_y, c.minus_y);
  const bool straight = std::holds_alternative<NoDistortion>(projector.inverse_camera.distortion);
  float margin = straight ? kBoxMargin : kBoxMargin + kBoxBend;
  if (!straight && std::max(x1 - x0, y1 - y0) > kStraightWithin) {
    // Lenses bend long edges: by what the middles are off, and half as much again.
    double bend = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const CornerPixel &p = pixel(i), &q = pixel((i + 1) % 3);
      const Vec2 start(double(p.x), double(p.y)), along(double(q.x - p.x), double(q.y - p.y));
      const double length = along.norm();
      for (const double s : {0.25, 0.5, 0.75}) {
        const auto between = projector.project((1 - s) * corner(i) + s * corner((i + 1) % 3));
        if (!between) return whole_frame(frame);
        const Vec2 off = *between - start;
        if (length > 0) bend = std::max(bend, std::abs(along.x() * off.y() - along.y() * off.x()) / length);
      }
    }
    margin += 1.5f * float(bend);
  }
  return {whole(std::ceil(x0 - margin), frame.width + 1), whole(std::ceil(y0 - margin), frame.height + 1),
          whole(std::floor(x1 + margin) + 1, frame.width + 1),
          whole(std::floor(y1 + margin) + 1, frame.height + 1), 0};
}

template <typename Visit>
void MeshLayer::for_tiles(const FacetBox& box, const Visit& visit) const {
  const int x0 = std::max(box.x0 - 1, 0) / kTileWidth,
            x1 = std::min<int>(box.x1, grid_.frame.width - 1) / kTileWidth;
  const int y0 = std::max(box.y0 - 1, 0) / kTileHeight,
            y1 = std::min<int>(box.y1, grid_.frame.height - 1) / kTileHeight;
  for (int y = y0; y <= y1; ++y)
    for (int x = x0; x <= x1; ++x) visit(std::size_t(y * grid_.across() + x));
}

void MeshLayer::set_up(const PlacedMesh& placed, const Projector& projector, const ViewCone& cone,
                       Part& part) {
  const Mesh& mesh = *placed.mesh;
  part.boxes = 0;
  part.in_tile.assign(std::size_t(grid_.across()) * std::size_t(grid_.down()), 0);
  for (std::size_t n = part.first; n < part.last; ++n) {
    const std::array<int, 3>& triangle = mesh.triangles[n];
    FacetBox box = box_of(projector, cone, triangle);
    if (box.x0 >= box.x1 || box.y0 >= box.y1) continue;
    const auto corner = [&](std::size_t i) { return std::size_t(triangle[i]); };
    const Vec3 &p = corners_[corner(0)], &q = corners_[corner(1)], &r = corners_[corner(2)];
    // Neighbours share an edge's cross product up to its sign, exactly: no ray slips between them.
    const std::array<Vec3, 3> edges{q.cross(r), r.cross(p), p.cross(q)};
    const double determinant = p.dot(edges[0]);
    if (!(determinant * determinant > 1e-24 * p.squaredNorm() * edges[0].squaredNorm())) continue;  // edge-on
    const double sign = determinant < 0 ? -1 : 1, inverse = 1 / determinant;
    Facet& facet = facets_[n];
    for (int i = 0; i < 4; ++i) set(sign * edges[std::min<std::size_t>(std::size_t(i), 2)], facet.borders[i]);
    set((edges[0] + edges[1] + edges[2]) * inverse, facet.nearness);
    if (placed.content_from_point) {
      std::array<Vec3, 3> content;
      for (std::size_t i = 0; i < 3; ++i)
        content[i] = *placed.content_from_point * mesh.vertices[corner(i)].homogeneous();
      for (int k = 0; k < 3; ++k)
        set((content[0][k] * edges[0] + content[1][k] * edges[1] + content[2][k] * edges[2]) * inverse,
            facet.content[k]);
    } else {
      for (int k = 0; k < 2; ++k)
        set((mesh.uv[corner(0)][k] * edges[0] + mesh.uv[corner(1)][k] * edges[1] +
             mesh.uv[corner(2)][k] * edges[2]) *
                inverse,
            facet.content[k]);
      std::copy_n(facet.nearness, 3, facet.content[2]);
    }
    box.facet = std::int32_t(n);
    boxes_[part.first + part.boxes++] = box;
    for_tiles(box, [&](std::size_t tile) { ++part.in_tile[tile]; });
  }
}

/// By counting. A tile's boxes are in the order of their facets.
void MeshLayer::sort_into_tiles(Workers& workers) {
  const std::size_t tiles = std::size_t(grid_.across()) * std::size_t(grid_.down());
  tile_ends_.resize(tiles + 1);
  std::uint32_t end = 0;
  for (std::size_t tile = 0; tile < tiles; ++tile) {
    tile_ends_[tile] = end;
    for (Part& part : parts_) end += std::exchange(part.in_tile[tile], end);
  }
  tile_ends_[tiles] = end;
  tile_boxes_.resize(end);
  workers.run(int(parts_.size()), [&](int turn) {
    Part& part = parts_[std::size_t(turn)];
    for (std::size_t i = part.first; i < part.first + part.boxes; ++i)
      for_tiles(boxes_[i], [&](std::size_t tile) { tile_boxes_[part.in_tile[tile]++] = boxes_[i]; });
  });
  // Together.
  std::size_t count = 0;
  for (const Part& part : parts_) {
    const auto first = boxes_.begin() + std::ptrdiff_t(part.first);
    if (count < part.first) std::copy_n(first, part.boxes, boxes_.begin() + std::ptrdiff_t(count));
    count += part.boxes;
  }
  boxes_.resize(count);
}

}  // namespace procam::render
