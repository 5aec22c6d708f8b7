#include "mesh_tree.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace procam::simulate::internal {
namespace {

constexpr int kBins = 16;
constexpr std::size_t kMaxInLeaf = 4;
constexpr double kBoxCost = 1.0;  ///< of a box, in tests of a triangle
constexpr int kDeepest = 60;
/// A ray within this share of a facet beside its edge meets it: none slips between neighbours.
constexpr double kEdge = 1e-9;

double half_area(const Eigen::AlignedBox3d& box) {
  if (box.isEmpty()) return 0;
  const Vec3 d = box.sizes();
  return d.x() * d.y() + d.y() * d.z() + d.z() * d.x();
}

/// 1 where the area's vector points away from the painted side, as of mesh_of()'s triangles; else -1.
double sense_of(const Mesh& mesh, const std::array<int, 3>& triangle) {
  const Vec2& a = mesh.uv[std::size_t(triangle[0])];
  const Vec2 along = mesh.uv[std::size_t(triangle[1])] - a, down = mesh.uv[std::size_t(triangle[2])] - a;
  return along.x() * down.y() - along.y() * down.x() < 0 ? -1 : 1;
}

}  // namespace

struct MeshTree::Builder {
  MeshTree& tree;
  std::vector<Eigen::AlignedBox3d> boxes;  ///< of the triangles
  std::vector<Vec3> middles;
  std::vector<int>& order;

  struct Split {
    int axis = -1, bin = 0;  ///< the last bin of the first side
    double low = 0, scale = 0, cost = 0;

    int bin_of(const Vec3& middle) const {
      return std::min(kBins - 1, std::max(0, int(scale * (middle[axis] - low))));
    }
  };

  /// axis -1: they are better left together.
  Split cheapest(std::size_t first, std::size_t last, const Eigen::AlignedBox3d& box,
                 const Eigen::AlignedBox3d& of_middles) const {
    struct Bin {
      Eigen::AlignedBox3d box;
      std::size_t count = 0;
    };
    Split best;
    const std::size_t n = last - first;
    best.cost = n <= kMaxInLeaf ? double(n) : std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
      const double extent = of_middles.sizes()[axis];
      if (!(extent > 0)) continue;
      Split split{axis, 0, of_middles.min()[axis], kBins / extent, 0};
      std::array<Bin, kBins> bins;
      for (std::size_t i = first; i < last; ++i) {
        const std::size_t triangle = std::size_t(order[i]);
        Bin& bin = bins[std::size_t(split.bin_of(middles[triangle]))];
        bin.box.extend(boxes[triangle]);
        ++bin.count;
      }
      std::array<double, kBins> cost_after{};
      Bin sum;
      for (std::size_t k = kBins - 1; k > 0; --k) {
        sum.box.extend(bins[k].box);
        sum.count += bins[k].count;
        cost_after[k] = half_area(sum.box) * double(sum.count);
      }
      sum = {};
      for (std::size_t k = 0; k + 1 < kBins; ++k) {
        sum.box.extend(bins[k].box);
        sum.count += bins[k].count;
        if (sum.count == 0 || sum.count == n) continue;
        split.bin = int(k);
        split.cost = kBoxCost + (half_area(sum.box) * double(sum.count) + cost_after[k + 1]) /
                                    std::max(half_area(box), 1e-300);
        if (split.cost < best.cost) best = split;
      }
    }
    return best;
  }

  void build(std::size_t first, std::size_t last, int depth) {
    const std::size_t at = tree.nodes_.size();
    tree.nodes_.emplace_back();
    Eigen::AlignedBox3d box, of_middles;
    for (std::size_t i = first; i < last; ++i) {
      box.extend(boxes[std::size_t(order[i])]);
      of_middles.extend(middles[std::size_t(order[i])]);
    }
    // A little more, for the slabs' rounding; boxes of flat meshes have a side of zero.
    const Vec3 more = Vec3::Constant(1e-12 * (box.min().cwiseAbs() + box.max().cwiseAbs()).maxCoeff());
    tree.nodes_[at].low = box.min() - more;
    tree.nodes_[at].high = box.max() + more;
    const Split split = depth < kDeepest ? cheapest(first, last, box, of_middles) : Split{};
    const auto begin = order.begin() + std::ptrdiff_t(first), end = order.begin() + std::ptrdiff_t(last);
    auto middle = begin;
    if (split.axis >= 0)
      middle = std::partition(begin, end,
                              [&](int i) { return split.bin_of(middles[std::size_t(i)]) <= split.bin; });
    if (middle == begin || middle == end) {  // all in one place, or few
      tree.nodes_[at].first = std::uint32_t(first);
      tree.nodes_[at].count = std::uint32_t(last - first);
      return;
    }
    const std::size_t half = std::size_t(middle - order.begin());
    build(first, half, depth + 1);
    tree.nodes_[at].first = std::uint32_t(tree.nodes_.size());
    build(half, last, depth + 1);
  }
};

MeshTree::MeshTree(std::shared_ptr<const Mesh> mesh) : mesh_(std::move(mesh)) {
  triangle_of_.resize(mesh_->triangles.size());
  std::iota(triangle_of_.begin(), triangle_of_.end(), 0);
  Builder builder{*this, {}, {}, triangle_of_};
  for (const std::array<int, 3>& triangle : mesh_->triangles) {
    Eigen::AlignedBox3d box;
    for (const int corner : triangle) box.extend(mesh_->vertices[std::size_t(corner)]);
    builder.boxes.push_back(box);
    builder.middles.push_back(box.center());
    bounds_.extend(box);
  }
  nodes_.reserve(mesh_->triangles.size());
  builder.build(0, triangle_of_.size(), 0);
  facets_.reserve(triangle_of_.size());
  for (std::size_t i = 0; i < triangle_of_.size(); ++i) {
    const std::array<int, 3>& of = corners(int(i));
    const auto vertex = [&](std::size_t k) -> const Vec3& { return mesh_->vertices[std::size_t(of[k])]; };
    facets_.push_back({vertex(0), vertex(1) - vertex(0), vertex(2) - vertex(0)});
  }
  smooth();
}

/// A corner's normal is the mean, by area, of the facets that meet there and turn from its own by less than a
/// crease. Vertices in one place are one: files repeat them where the texture has a seam.
void MeshTree::smooth() {
  const Points3& vertices = mesh_->vertices;
  std::vector<int> sorted(vertices.size());
  std::iota(sorted.begin(), sorted.end(), 0);
  const auto before = [&](int i, int j) {
    const Vec3 &a = vertices[std::size_t(i)], &b = vertices[std::size_t(j)];
    return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
  };
  std::sort(sorted.begin(), sorted.end(), before);
  std::vector<std::size_t> place(vertices.size());
  std::size_t places = 0;
  for (std::size_t k = 0; k < sorted.size(); ++k) {
    if (k > 0 && before(sorted[k - 1], sorted[k])) ++places;
    place[std::size_t(sorted[k])] = places;
  }
  std::vector<std::uint32_t> ends(places + 2, 0);  // of the facets at each place
  for (std::size_t i = 0; i < facets_.size(); ++i)
    for (const int corner : corners(int(i))) ++ends[place[std::size_t(corner)] + 1];
  std::partial_sum(ends.begin(), ends.end(), ends.begin());
  std::vector<std::uint32_t> at_place(3 * facets_.size()), next(ends.begin(), ends.end() - 1);
  std::vector<Vec3> areas, normals;
  for (std::size_t i = 0; i < facets_.size(); ++i) {
    for (const int corner : corners(int(i))) at_place[next[place[std::size_t(corner)]]++] = std::uint32_t(i);
    const double outward = -sense_of(*mesh_, corners(int(i)));
    areas.emplace_back(outward * facets_[i].side_1.cross(facets_[i].side_2));
    normals.push_back(areas.back().normalized());
  }
  const double least = std::cos(kCrease);
  corner_normals_.resize(facets_.size());
  for (std::size_t i = 0; i < facets_.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      Vec3 sum = Vec3::Zero();
      const std::size_t at = place[std::size_t(corners(int(i))[k])];
      for (std::uint32_t j = ends[at]; j < ends[at + 1]; ++j)
        if (normals[at_place[j]].dot(normals[i]) > least) sum += areas[at_place[j]];
      corner_normals_[i][k] = sum.normalized().cast<float>();
    }
}

Vec3 MeshTree::normal(int facet) const {
  const Facet& f = facets_[std::size_t(facet)];
  return -sense_of(*mesh_, corners(facet)) * f.side_1.cross(f.side_2).normalized();
}

Vec3 MeshTree::smooth_normal(int facet, const Vec3& point) const {
  const Facet& f = facets_[std::size_t(facet)];
  const Vec3 area = f.side_1.cross(f.side_2), to_point = point - f.corner;
  const double whole = area.squaredNorm();
  const double b1 = to_point.cross(f.side_2).dot(area) / whole;
  const double b2 = f.side_1.cross(to_point).dot(area) / whole;
  const Normals& n = corner_normals_[std::size_t(facet)];
  return (float(1 - b1 - b2) * n[0] + float(b1) * n[1] + float(b2) * n[2]).cast<double>().normalized();
}

Mat23 MeshTree::uv_by_point(int facet) const {
  const Facet& f = facets_[std::size_t(facet)];
  const std::array<int, 3>& of = corners(facet);
  const auto uv = [&](std::size_t k) -> const Vec2& { return mesh_->uv[std::size_t(of[k])]; };
  Mat3 sides;
  sides << f.side_1, f.side_2, f.side_1.cross(f.side_2).normalized() * f.side_1.norm();
  Mat23 uv_by_sides;
  uv_by_sides << uv(1) - uv(0), uv(2) - uv(0), Vec2::Zero();
  return uv_by_sides * sides.inverse();
}

template <bool kAny>
MeshTree::Found MeshTree::walk(const Vec3& eye, const Vec3& direction, double from, double to) const {
  Vec3 inverse;
  for (int k = 0; k < 3; ++k)
    inverse[k] = 1 / (std::abs(direction[k]) > 1e-300 ? direction[k] : std::copysign(1e-300, direction[k]));
  /// Where the ray enters the box; infinite where it does not within (from, to).
  const auto enters = [&](const Node& node, double until) {
    double in = from, out = until;
    for (int k = 0; k < 3; ++k) {
      const double a = (node.low[k] - eye[k]) * inverse[k], b = (node.high[k] - eye[k]) * inverse[k];
      in = std::max(in, std::min(a, b));
      out = std::min(out, std::max(a, b));
    }
    return in <= out ? in : std::numeric_limits<double>::infinity();
  };
  struct Later {
    std::uint32_t node;
    double enters;
  };
  Found found{to, -1};
  std::array<Later, kDeepest + 4> later;
  std::size_t waiting = 0;
  std::uint32_t at = 0;
  if (std::isinf(enters(nodes_[0], to))) return {};
  for (;;) {
    const Node& node = nodes_[at];
    if (node.count == 0) {
      const double first = enters(nodes_[at + 1], found.s), second = enters(nodes_[node.first], found.s);
      const bool swap = second < first;
      const double near_in = swap ? second : first, far_in = swap ? first : second;
      if (!std::isinf(near_in)) {
        if (!std::isinf(far_in)) later[waiting++] = {swap ? at + 1 : node.first, far_in};
        at = swap ? node.first : at + 1;
        continue;
      }
    } else {
      for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
        const Facet& f = facets_[i];
        const Vec3 p = direction.cross(f.side_2);
        const double inverse_determinant = 1 / f.side_1.dot(p);  // infinite, then NaN: edge-on, not met
        const Vec3 from_corner = eye - f.corner;
        const double b1 = from_corner.dot(p) * inverse_determinant;
        if (!(b1 >= -kEdge && b1 <= 1 + kEdge)) continue;
        const Vec3 q = from_corner.cross(f.side_1);
        const double b2 = direction.dot(q) * inverse_determinant;
        if (!(b2 >= -kEdge && b1 + b2 <= 1 + kEdge)) continue;
        const double s = f.side_2.dot(q) * inverse_determinant;
        if (!(s > from && s < found.s)) continue;
        found = {s, int(i)};
        if (kAny) return found;
      }
    }
    do {
      if (waiting == 0) return found.facet < 0 ? Found{} : found;
      --waiting;
    } while (!(later[waiting].enters < found.s));
    at = later[waiting].node;
  }
}

template MeshTree::Found MeshTree::walk<false>(const Vec3&, const Vec3&, double, double) const;
template MeshTree::Found MeshTree::walk<true>(const Vec3&, const Vec3&, double, double) const;

}  // namespace procam::simulate::internal
