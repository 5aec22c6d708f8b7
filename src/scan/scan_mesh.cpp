#include "procam/scan/scan_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "holes.hpp"

namespace procam::scan {
namespace {

/// The image's pixels in a square of 2^n + 1, split into right-angled triangles. A pixel's error belongs to both triangles
/// whose hypotenuse it halves: the largest deviation, in tolerances, of it and of all pixels that halve a smaller triangle
/// within them.
class Triangulation {
 public:
  Triangulation(const Scan& scan, const MeshOptions& options)
      : scan_(scan),
        options_(options),
        rays_(pixel_rays(scan.camera.camera)),
        depth_(scan.depth),
        sigma_(scan.sigma) {
    bridge_holes(depth_, sigma_, options.max_hole, options.max_deviation);
    const int longest = std::max({scan.depth.width(), scan.depth.height(), 3});
    while (side_ + 1 < longest) side_ *= 2;
    error_ = ImageF(side_ + 1, side_ + 1);
    for (int s = 2; s <= side_; s *= 2) {
      measure_edges(s);
      measure_diagonals(s);
    }
  }

  Mesh mesh() {
    vertex_.assign(std::size_t(scan_.depth.width()) * std::size_t(scan_.depth.height()), -1);
    emit({0, 0}, {side_, side_}, {side_, 0});
    emit({side_, side_}, {0, 0}, {0, side_});
    return std::move(mesh_);
  }

 private:
  struct Pixel {
    int x, y;
  };
  static constexpr float kSplit = std::numeric_limits<float>::infinity();

  /// The hypotenuses along x and y of length s, from the smaller ones on the diagonals of s/2.
  void measure_edges(int s) {
    const int half = s / 2, quarter = s / 4;
    for (int y = 0; y <= reach_y(s); y += s)
      for (int x = half; x <= reach_x(s); x += s) {
        raise({x, y}, {x - half, y}, {x + half, y});
        if (quarter > 0) raise_by_diagonals({x, y}, quarter);
      }
    for (int y = half; y <= reach_y(s); y += s)
      for (int x = 0; x <= reach_x(s); x += s) {
        raise({x, y}, {x, y - half}, {x, y + half});
        if (quarter > 0) raise_by_diagonals({x, y}, quarter);
      }
  }

  /// The hypotenuses on the diagonals of cells of s pixels, from the smaller ones on the cells' edges.
  void measure_diagonals(int s) {
    const int half = s / 2;
    for (int y = half; y <= reach_y(s); y += s)
      for (int x = half; x <= reach_x(s); x += s) {
        const int turn =
            ((x / s + y / s) % 2 == 0) ? half : -half;  // the diagonal through the larger cell's middle
        raise({x, y}, {x - half, y - turn}, {x + half, y + turn});
        for (const Pixel edge :
             {Pixel{x - half, y}, Pixel{x + half, y}, Pixel{x, y - half}, Pixel{x, y + half}})
          take(error_.at(edge.x, edge.y), {x, y});
      }
  }

  /// Cells that touch the image; nothing is measured in the others.
  int reach_x(int s) const { return std::min(side_, scan_.depth.width() + s); }
  int reach_y(int s) const { return std::min(side_, scan_.depth.height() + s); }

  void take(float error, const Pixel& middle) {
    error_.at(middle.x, middle.y) = std::max(error_.at(middle.x, middle.y), error);
  }
  void raise(const Pixel& middle, const Pixel& a, const Pixel& b) { take(deviation(a, b, middle), middle); }
  void raise_by_diagonals(const Pixel& middle, int quarter) {
    for (const int dy : {-quarter, quarter})
      for (const int dx : {-quarter, quarter}) {
        const Pixel centre{middle.x + dx, middle.y + dy};
        if (centre.x >= 0 && centre.y >= 0 && centre.x <= side_ && centre.y <= side_)
          take(error_.at(centre.x, centre.y), middle);
      }
  }

  double depth(const Pixel& p) const {
    const bool inside = p.x < scan_.depth.width() && p.y < scan_.depth.height();
    return inside ? double(depth_.at(p.x, p.y)) : 0.0;
  }
  double sigma(const Pixel& p) const { return double(sigma_.at(p.x, p.y)); }
  Vec3 point(const Pixel& p) const {
    const double z = depth(p);
    return Vec3(z * rays_.at(p.x, p.y, 0), z * rays_.at(p.x, p.y, 1), z);
  }

  /// Are both on one surface, which is seen at no flatter angle than allowed?
  bool joined(const Pixel& p, const Pixel& q) const {
    const Vec3 a = point(p), b = point(q), along = b - a, sight = 0.5 * (a + b);
    if (std::abs(along.z()) <= 3 * std::hypot(sigma(p), sigma(q))) return true;
    return along.cross(sight).norm() >= std::sin(options_.min_angle) * along.norm() * sight.norm();
  }

  /// Of the line between a and b at the pixel m halfway, in tolerances; kSplit where they are not on one surface.
  float deviation(const Pixel& a, const Pixel& b, const Pixel& m) const {
    const double za = depth(a), zb = depth(b), zm = depth(m);
    const int measured = (za > 0) + (zb > 0) + (zm > 0);
    if (measured == 0) return 0;
    if (measured < 3 || !joined(a, m) || !joined(m, b)) return kSplit;
    const double line = 2 / (1 / za + 1 / zb);
    return float(std::abs(line - zm) / std::max(options_.max_deviation, options_.max_sigmas * sigma(m)));
  }

  /// a, b: the ends of the hypotenuse; c: the right angle.
  void emit(const Pixel& a, const Pixel& b, const Pixel& c) {
    if (std::min({a.x, b.x, c.x}) >= scan_.depth.width() || std::min({a.y, b.y, c.y}) >= scan_.depth.height())
      return;
    const Pixel middle{(a.x + b.x) / 2, (a.y + b.y) / 2};
    if (std::abs(a.x - c.x) + std::abs(a.y - c.y) > 1 && error_.at(middle.x, middle.y) > 1) {
      emit(c, a, middle);
      emit(b, c, middle);
      return;
    }
    if (!(depth(a) > 0 && depth(b) > 0 && depth(c) > 0) || !joined(a, b) || !joined(b, c) || !joined(c, a))
      return;
    const std::array<int, 3> corners{vertex(a), vertex(b), vertex(c)};
    mesh_.triangles.push_back(corners);
  }

  int vertex(const Pixel& p) {
    const ImageSize size = scan_.depth.size();
    int& number = vertex_[std::size_t(p.y) * std::size_t(size.width) + std::size_t(p.x)];
    if (number < 0) {
      number = int(mesh_.vertices.size());
      mesh_.vertices.push_back(scan_.camera.rig_from_camera * point(p));
      mesh_.uv.push_back(Vec2((p.x + 0.5) / size.width, (p.y + 0.5) / size.height));
    }
    return number;
  }

  const Scan& scan_;
  MeshOptions options_;
  ImageF rays_, depth_, sigma_;
  int side_ = 2;
  ImageF error_;
  std::vector<int> vertex_;
  Mesh mesh_;
};

}  // namespace

Mesh mesh_of(const Scan& scan, const MeshOptions& options) {
  require(options.max_deviation >= 0 && options.max_sigmas >= 0 &&
              options.max_deviation + options.max_sigmas > 0 && options.min_angle >= 0 &&
              options.min_angle < kPi / 2 && options.max_hole >= 0,
          "mesh_of: options out of range");
  Mesh mesh = Triangulation(scan, options).mesh();
  if (mesh.triangles.empty())
    throw Error(ErrorKind::kNotEnoughData, "scan", "no three neighbouring pixels are measured on one surface",
                "move the camera closer, or use wider stripes");
  return mesh;
}

}  // namespace procam::scan
