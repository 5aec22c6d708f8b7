#pragma once
/// Least squares from edges (or corners) of placed markers to the camera's pose.
#include <optional>
#include <vector>

#include "procam/core/board/marker.hpp"
#include "procam/core/geometry/se3.hpp"
#include "procam/core/lens/camera.hpp"

namespace procam::track::internal {

/// A marker that is in the map and in the image.
struct Sighting {
  const SeenMarker* seen = nullptr;
  const PlacedMarker* placed = nullptr;
};

/// What is solved beside the pose for each marker, in sigmas of its prior.
struct Nuisance {
  Vec6 misplaced = Vec6::Zero();
  double spread = 0;
};

struct State {
  Pose camera_from_world;
  std::vector<Nuisance> nuisance;   ///< a marker each
  double cost = 0;                  ///< sum of squares, priors included
  Mat6 information = Mat6::Zero();  ///< of the pose, everything else eliminated
};

struct Problem {
  Camera camera;
  std::vector<Sighting> sightings;
  Vec6 map_sigma = Vec6::Zero();  ///< rotation, translation, in the marker's frame
  bool corners_only = false;      ///< a quicker start; edges are ignored
  std::vector<double> weights;    ///< a marker each; empty: 1

  /// Degrees of freedom: residuals less the pose and each marker's spread where edges show it; 1 or more.
  int freedom() const;
};

/// Levenberg-Marquardt; nullopt when a marker cannot be projected from the start, or nothing converges.
std::optional<State> solve(const Problem& problem, const Pose& start);

/// d increment / d camera parameters at a solution, 6 rows.
MatX sensitivity_to_lens(const Problem& problem, const State& solution);

/// rms distance of the marker's corners from where the pose puts them; a large number behind the camera.
double corner_error(const Camera& camera, const Sighting& sighting, const Pose& camera_from_world);

/// rms distance of the marker's edges from where the state puts them; 0 without edges.
double edge_error(const Problem& problem, const State& state, std::size_t sighting);

}  // namespace procam::track::internal
