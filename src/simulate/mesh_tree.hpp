#pragma once
/// Triangles and rays, in the mesh's own frame.
///
/// A binary tree of boxes, split where the surface-area heuristic finds it cheapest (I. Wald, "On fast
/// construction of SAH-based bounding volume hierarchies", IEEE Symposium on Interactive Ray Tracing, 2007),
/// over triangles met by T. Moller and B. Trumbore, "Fast, minimum storage ray/triangle intersection", 1997.
/// All in doubles: a point met by one eye's ray is met again from another's to 1e-12 of the distance.
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "procam/core/geometry/mesh.hpp"

namespace procam::simulate::internal {

/// Facets are the mesh's triangles, numbered as they lie in the tree.
class MeshTree {
 public:
  /// The mesh must be a good one (fault_of).
  explicit MeshTree(std::shared_ptr<const Mesh> mesh);

  const Mesh& mesh() const { return *mesh_; }
  const Eigen::AlignedBox3d& bounds() const { return bounds_; }

  struct Found {
    double s = std::numeric_limits<double>::infinity();
    int facet = -1;
  };
  /// The first point eye + s * direction on a facet with from < s < to.
  Found first(const Vec3& eye, const Vec3& direction, double from, double to) const {
    return walk<false>(eye, direction, from, to);
  }
  /// Is there any?
  bool meets(const Vec3& eye, const Vec3& direction, double from, double to) const {
    return walk<true>(eye, direction, from, to).facet >= 0;
  }

  /// Corners, as the mesh's vertices.
  const std::array<int, 3>& corners(int facet) const {
    return mesh_->triangles[std::size_t(triangle_of_[std::size_t(facet)])];
  }
  /// Of the facet's plane, on the painted side.
  Vec3 normal(int facet) const;
  /// Of the surface that the facets stand for: smooth where they meet at less than kCrease.
  Vec3 smooth_normal(int facet, const Vec3& point) const;
  /// How u, v grow with the point on the facet; at its first corner they are that vertex's.
  Mat23 uv_by_point(int facet) const;

  static constexpr double kCrease = 30 * kDegree;

 private:
  struct Node {
    Vec3 low, high;
    std::uint32_t first = 0;  ///< of a leaf's facets; else the second child, the first lies behind its parent
    std::uint32_t count = 0;  ///< facets of a leaf; 0: no leaf
  };
  struct Facet {
    Vec3 corner, side_1, side_2;
  };
  using Normals = std::array<Eigen::Vector3f, 3>;

  struct Builder;
  void smooth();
  template <bool kAny>
  Found walk(const Vec3& eye, const Vec3& direction, double from, double to) const;

  std::shared_ptr<const Mesh> mesh_;
  Eigen::AlignedBox3d bounds_;
  std::vector<Node> nodes_;
  std::vector<Facet> facets_;
  std::vector<int> triangle_of_;         ///< of each facet
  std::vector<Normals> corner_normals_;  ///< of each facet's corners
};

}  // namespace procam::simulate::internal
