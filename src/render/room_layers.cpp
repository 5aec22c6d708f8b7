#include "room_layers.hpp"

#include <Eigen/LU>
#include <cmath>

#include "mean_content.hpp"

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

}  // namespace

RoomLayer::RoomLayer(const PlacedPlane& placed, const TileGrid& grid) : is_plane_(true), grid_(grid) {
  Mat3 direction_from_plane = placed.projector_from_surface.rotation_matrix();
  direction_from_plane.col(2) = placed.projector_from_surface.translation;
  const Mat3 direction_from_content = direction_from_plane * placed.plane_from_content;
  Facet facet;
  const double scale = direction_from_content.norm();
  // Edge-on: no light lands.
  const bool lit = std::abs(direction_from_content.determinant()) > 1e-15 * scale * scale * scale;
  if (lit) {
    facet.content_from_direction = direction_from_content.inverse();
    facet.nearness = direction_from_plane.inverse().row(2);
    for (const Eigen::RowVector3d& border : border_combinations())
      facet.borders[std::size_t(facet.border_count++)] = (border * facet.content_from_direction).transpose();
    facets_.push_back(facet);
  }
  const ImageSize size = grid.frame;
  if (lit) plane_box_ = {{0, 0, size.width, size.height, 0}};
}

RoomLayer::RoomLayer(const PlacedMesh& placed, const Projector& projector, const TileGrid& grid)
    : is_plane_(false), grid_(grid) {
  const Mesh& mesh = *placed.mesh;
  const ViewCone cone(projector);
  const Mat3 rotation = placed.projector_from_surface.rotation_matrix();
  Points3 points;
  points.reserve(mesh.vertices.size());
  std::vector<std::optional<Vec2>> pixels;
  pixels.reserve(mesh.vertices.size());
  for (const Vec3& vertex : mesh.vertices) {
    points.push_back(rotation * vertex + placed.projector_from_surface.translation);
    pixels.push_back(projector.pixel_lighting(points.back()));
  }
  std::vector<FacetBox> boxes;
  for (const auto& triangle : mesh.triangles) {
    std::array<Vec3, 3> p;
    std::array<std::optional<Vec2>, 3> px;
    Mat3 uv;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto corner = std::size_t(triangle[i]);
      p[i] = points[corner];
      px[i] = pixels[corner];
      uv.col(Eigen::Index(i)) = mesh.uv[corner].homogeneous();
    }
    const Vec3 centre = (p[0] + p[1] + p[2]) / 3;
    double radius = 0;
    for (const Vec3& corner : p) radius = std::max(radius, (corner - centre).norm());
    if (!cone.meets(centre, radius)) continue;
    // Neighbours share an edge's cross product up to its sign, which is exact: no ray slips between them.
    Facet facet;
    const Vec3 e0 = p[1].cross(p[2]), e1 = p[2].cross(p[0]), e2 = p[0].cross(p[1]);
    const double determinant = p[0].dot(e0);
    if (!(std::abs(determinant) > 1e-12 * p[0].norm() * e0.norm())) continue;  // edge-on
    const double sign = determinant < 0 ? -1 : 1;
    facet.borders = {Vec3(sign * e0), Vec3(sign * e1), Vec3(sign * e2), Vec3::Zero()};
    facet.border_count = 3;
    Mat3 barycentric_from_direction;
    barycentric_from_direction << e0.transpose(), e1.transpose(), e2.transpose();
    barycentric_from_direction /= determinant;
    facet.content_from_direction = uv * barycentric_from_direction;
    facet.nearness = facet.content_from_direction.row(2);
    const FacetBox box = box_of(projector, p, px, int(facets_.size()));
    if (box.x0 >= box.x1 || box.y0 >= box.y1) continue;
    facets_.push_back(facet);
    boxes.push_back(box);
  }
  sort_into_tiles(boxes);
}

void RoomLayer::sort_into_tiles(const std::vector<FacetBox>& boxes) {
  tiles_.assign(std::size_t(grid_.across()) * std::size_t(grid_.down()), {});
  for (const FacetBox& box : boxes)
    for (int j = box.y0 / kTileHeight; j <= (box.y1 - 1) / kTileHeight; ++j)
      for (int i = box.x0 / kTileWidth; i <= (box.x1 - 1) / kTileWidth; ++i)
        tiles_[std::size_t(j * grid_.across() + i)].push_back(box);
}

namespace {

/// A pixel's ray over its area: d(dx, dy) = centre + dx * along_x + dy * along_y.
struct PixelRay {
  Vec3 centre, along_x, along_y;
};

struct Hit {
  int facet = -1;
  double nearness = 0;
};

constexpr double kStep = 0.02;  ///< share of the distance by which a mesh's depth may jump within one surface

/// One of 16 places in a pixel, no two in one row or column.
constexpr std::array<std::array<double, 2>, 16> kSubPixels = [] {
  std::array<std::array<double, 2>, 16> places{};
  for (std::size_t i = 0; i < 16; ++i)
    places[i] = {(double(i) + 0.5) / 16 - 0.5, (double(4 * (i % 4) + i / 4) + 0.5) / 16 - 0.5};
  return places;
}();

bool inside(const Facet& facet, const Vec3& d) {
  for (int i = 0; i < facet.border_count; ++i)
    if (!(facet.borders[std::size_t(i)].dot(d) >= 0)) return false;
  return facet.nearness.dot(d) > 0;
}

/// A tile and one pixel round it, to tell what ends at its rim.
template <typename Texture>
class CastTile {
 public:
  using Pixel = typename Texture::Pixel;

  CastTile(const std::vector<RoomItem<Texture>>& items, const std::vector<LensPiece>& pieces,
           const Kernels& kernels, bool area, Tile<Pixel>& tile)
      : items_(items),
        kernels_(kernels),
        area_(area),
        tile_(tile),
        rect_(tile.rect),
        across_(rect_.width() + 2),
        rays_(std::size_t(across_ * (rect_.height() + 2))),
        known_(rays_.size(), false),
        hits_(items.size(), std::vector<Hit>(rays_.size())) {
    for (const LensPiece& piece : pieces) follow(piece);
    for (std::size_t item = 0; item < items.size(); ++item) cast(item);
  }

  void draw() {
    constexpr float kUnit = std::is_same_v<Pixel, Light> ? float(kFull) : 255.0f;
    for (int y = rect_.y0; y < rect_.y1; ++y)
      for (int x = rect_.x0; x < rect_.x1; ++x) {
        const std::size_t at = place(x, y);
        if (!known_[at]) continue;
        Pixel* const there = tile_.row(y - rect_.y0) + 4 * (x - rect_.x0);
        Rgba pixel = Rgba(there[0], there[1], there[2], there[3]) / kUnit;
        if (is_even(x, y))
          draw_even(at, pixel);
        else
          draw_edge(x, y, at, pixel);
        for (int k = 0; k < 4; ++k)
          there[k] = Pixel(std::lround(kUnit * std::min(1.0f, std::max(0.0f, pixel[k]))));
      }
  }

 private:
  std::size_t place(int x, int y) const {
    return std::size_t((y - rect_.y0 + 1) * across_ + (x - rect_.x0 + 1));
  }

  /// The rays of a piece; at the tile's rim also of the pixel beyond it.
  void follow(const LensPiece& piece) {
    const PixelRect& r = piece.rect;
    const double ds = 2.0 / r.width(), dt = 2.0 / r.height();
    const int x0 = r.x0 - (r.x0 == rect_.x0), x1 = r.x1 + (r.x1 == rect_.x1);
    const int y0 = r.y0 - (r.y0 == rect_.y0), y1 = r.y1 + (r.y1 == rect_.y1);
    for (int y = y0; y < y1; ++y) {
      const Quadratic3 row = piece.direction_from_pixel.row(r.t(y)),
                       down = piece.direction_from_pixel.row_slope(r.t(y));
      for (int x = x0; x < x1; ++x) {
        const double s = r.s(x);
        const std::size_t at = place(x, y);
        rays_[at] = {row[0] + s * (row[1] + s * row[2]), ds * (row[1] + 2 * s * row[2]),
                     dt * (down[0] + s * (down[1] + s * down[2]))};
        known_[at] = true;
      }
    }
  }

  void cast(std::size_t item) {
    const RoomLayer& layer = *items_[item].layer;
    std::vector<Hit>& hits = hits_[item];
    for (const FacetBox& box : layer.boxes(tile_.x, tile_.y)) {
      const Facet& facet = layer.facets()[std::size_t(box.facet)];
      const int x0 = std::max(box.x0, rect_.x0) - 1, x1 = std::min(box.x1, rect_.x1) + 1;
      const int y0 = std::max(box.y0, rect_.y0) - 1, y1 = std::min(box.y1, rect_.y1) + 1;
      for (int y = y0; y < y1; ++y)
        for (int x = x0; x < x1; ++x) {
          const std::size_t at = place(x, y);
          if (!known_[at] || !inside(facet, rays_[at].centre)) continue;
          const double nearness = facet.nearness.dot(rays_[at].centre);
          if (nearness > hits[at].nearness) hits[at] = {box.facet, nearness};
        }
    }
  }

  /// Does item a lie in front of item b (a != b)? Together: the later one does.
  static bool in_front(std::size_t a, double nearness_a, std::size_t b, double nearness_b) {
    if (std::abs(nearness_a - nearness_b) <= kTogether * std::max(nearness_a, nearness_b)) return a > b;
    return nearness_a > nearness_b;
  }

  /// Do the pixel's neighbours see the same surfaces in the same order?
  bool is_even(int x, int y) const {
    const std::size_t at = place(x, y);
    for (int j = -1; j <= 1; ++j)
      for (int i = -1; i <= 1; ++i) {
        const std::size_t other = place(x + i, y + j);
        if (other == at || !known_[other]) continue;
        for (std::size_t a = 0; a < items_.size(); ++a) {
          const Hit &mine = hits_[a][at], &its = hits_[a][other];
          if ((mine.facet < 0) != (its.facet < 0)) return false;
          if (mine.facet < 0) continue;
          if (mine.facet != its.facet) {
            // The same smooth surface, or one part of it before another?
            const double expected =
                items_[a].layer->facets()[std::size_t(mine.facet)].nearness.dot(rays_[other].centre);
            if (!(std::abs(expected - its.nearness) <= kStep * its.nearness)) return false;
          }
          for (std::size_t b = 0; b < a; ++b)
            if (hits_[b][at].facet >= 0 && hits_[b][other].facet >= 0 &&
                in_front(a, mine.nearness, b, hits_[b][at].nearness) !=
                    in_front(a, its.nearness, b, hits_[b][other].nearness))
              return false;
        }
      }
    return true;
  }

  /// What an item shows through one facet, about a place in the pixel.
  Rgba shade(std::size_t item, int facet_index, const PixelRay& ray, const Vec2& where) const {
    const Facet& facet = items_[item].layer->facets()[std::size_t(facet_index)];
    const Vec3 centre = ray.centre + where.x() * ray.along_x + where.y() * ray.along_y;
    Footprint footprint{facet.content_from_direction * centre, facet.content_from_direction * ray.along_x,
                        facet.content_from_direction * ray.along_y};
    // Where light grazes, the linear step would pass the horizon: keep to half the way there.
    const double reach = std::abs(footprint.slope_x.z()) + std::abs(footprint.slope_y.z());
    if (reach > footprint.centre.z()) {
      footprint.slope_x *= footprint.centre.z() / reach;
      footprint.slope_y *= footprint.centre.z() / reach;
    }
    return mean_content(*items_[item].texture, kernels_, footprint, area_);
  }

  struct Fragment {
    std::size_t item;
    int facet;
    double nearness;
  };
  static void sort(std::vector<Fragment>& fragments) {  // a handful: nearest first
    for (std::size_t i = 1; i < fragments.size(); ++i)
      for (std::size_t j = i; j > 0 && in_front(fragments[j].item, fragments[j].nearness,
                                                fragments[j - 1].item, fragments[j - 1].nearness);
           --j)
        std::swap(fragments[j], fragments[j - 1]);
  }

  void draw_even(std::size_t at, Rgba& light) {
    fragments_.clear();
    for (std::size_t a = 0; a < items_.size(); ++a)
      if (hits_[a][at].facet >= 0) fragments_.push_back({a, hits_[a][at].facet, hits_[a][at].nearness});
    sort(fragments_);
    Rgba seen = Rgba::Zero();
    for (const Fragment& f : fragments_) {
      seen += (1 - seen[3]) * shade(f.item, f.facet, rays_[at], Vec2::Zero());
      if (seen[3] >= 1) break;
    }
    light = seen + (1 - seen[3]) * light;
  }

  void draw_edge(int x, int y, std::size_t at, Rgba& light) {
    const PixelRay& ray = rays_[at];
    // Phase 1: what each sub-pixel meets; each facet is shaded once, about the middle of where it is met.
    struct Shown {
      std::size_t item;
      int facet;
      Vec2 sum;
      int count;
      Rgba light;
    };
    std::vector<Shown> shown;
    candidates_.clear();
    for (std::size_t a = 0; a < items_.size(); ++a)
      for (const FacetBox& box : items_[a].layer->boxes(tile_.x, tile_.y))
        if (x >= box.x0 && x < box.x1 && y >= box.y0 && y < box.y1) candidates_.push_back({a, box.facet, 0});
    std::array<std::vector<std::size_t>, 16> order;
    for (std::size_t k = 0; k < 16; ++k) {
      const Vec2 where(kSubPixels[k][0], kSubPixels[k][1]);
      const Vec3 d = ray.centre + where.x() * ray.along_x + where.y() * ray.along_y;
      fragments_.clear();
      for (const Fragment& candidate : candidates_) {
        const Facet& facet = items_[candidate.item].layer->facets()[std::size_t(candidate.facet)];
        if (!inside(facet, d)) continue;
        const Fragment met{candidate.item, candidate.facet, facet.nearness.dot(d)};
        if (fragments_.empty() || fragments_.back().item != met.item)
          fragments_.push_back(met);
        else if (met.nearness > fragments_.back().nearness)
          fragments_.back() = met;
      }
      sort(fragments_);
      for (const Fragment& f : fragments_) {
        std::size_t i = 0;
        while (i < shown.size() && (shown[i].item != f.item || shown[i].facet != f.facet)) ++i;
        if (i == shown.size()) shown.push_back({f.item, f.facet, Vec2::Zero(), 0, Rgba::Zero()});
        shown[i].sum += where;
        ++shown[i].count;
        order[k].push_back(i);
      }
    }
    for (Shown& s : shown) s.light = shade(s.item, s.facet, ray, s.sum / s.count);
    // Phase 2: each sub-pixel's light.
    Rgba sum = Rgba::Zero();
    for (const std::vector<std::size_t>& front_to_back : order) {
      Rgba seen = Rgba::Zero();
      for (const std::size_t i : front_to_back) seen += (1 - seen[3]) * shown[i].light;
      sum += seen;
    }
    sum /= 16;
    light = sum + (1 - sum[3]) * light;
  }

  const std::vector<RoomItem<Texture>>& items_;
  const Kernels& kernels_;
  bool area_;
  Tile<Pixel>& tile_;
  PixelRect rect_;
  int across_;
  std::vector<PixelRay> rays_;
  std::vector<bool> known_;
  std::vector<std::vector<Hit>> hits_;
  std::vector<Fragment> fragments_, candidates_;  // kept, to allocate once
};

}  // namespace

template <typename Texture>
void draw_cast(const std::vector<RoomItem<Texture>>& items, const std::vector<LensPiece>& pieces,
               const Kernels& kernels, bool area, Tile<typename Texture::Pixel>& tile) {
  CastTile<Texture>(items, pieces, kernels, area, tile).draw();
}

template void draw_cast(const std::vector<RoomItem<LightTexture>>&, const std::vector<LensPiece>&,
                        const Kernels&, bool, Tile<Light>&);
template void draw_cast(const std::vector<RoomItem<ValueTexture>>&, const std::vector<LensPiece>&,
                        const Kernels&, bool, Tile<Value>&);

}  // namespace procam::render
