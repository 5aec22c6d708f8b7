#pragma once
/// Pairs of elements of two maps: how far each is from an alignment, and where alignments may start.
#include <Eigen/Cholesky>
#include <vector>

#include "procam/track/align_maps.hpp"

namespace procam::track::internal {

using Kind = MapElementKind;

/// Indices into the elements of map A and of map B.
struct ElementPair {
  std::size_t a = 0, b = 0;
  Kind kind = Kind::kPose;
  int size() const { return kind == Kind::kPose ? 6 : 3; }  ///< of the residual
};

struct MapPairs {
  const std::vector<MapElement>& map_a;
  const std::vector<MapElement>& map_b;
  std::vector<ElementPair> pairs;

  const MapElement& a(const ElementPair& pair) const { return map_a[pair.a]; }
  const MapElement& b(const ElementPair& pair) const { return map_b[pair.b]; }
};

/// A pair's residual, whitened: cost |r|^2. The increment xi is about `centre`, a point of map A:
/// map_a_from_map_b <- shift(centre) exp(xi) shift(-centre) map_a_from_map_b.
struct PairEquations {
  VecX residual;
  MatX jacobian;  ///< d residual / d xi, 6 columns
};
PairEquations pair_equations(const MapPairs& all, const ElementPair& pair, const Pose& map_a_from_map_b,
                             const Vec3& centre);

/// Alignments by each pair of poses and by as many planes as a rotation and a position take.
std::vector<Pose> alignment_starts(const MapPairs& all);

}  // namespace procam::track::internal
