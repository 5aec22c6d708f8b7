#pragma once
/// Named frames and the poses between them: marker -> camera -> projector, world -> robot -> rig.
///
///   FrameTree frames;
///   frames.set("camera", "marker", camera_from_marker);
///   frames.set("projector", "camera", projector_from_camera);
///   frames.get("projector", "marker").pose == projector_from_camera * camera_from_marker
///
/// Each edge is stored as parent_from_child with its covariance; edges are taken as independent of each
/// other.
#include <map>
#include <string>
#include <vector>

#include "procam/core/geometry/covariance.hpp"

namespace procam {

class FrameTree {
 public:
  struct Link {
    std::string target, source;
    PoseWithCovariance target_from_source;
  };

  /// Adds or replaces the edge parent_from_child. Throws Error(kInput) when the child already hangs elsewhere
  /// or the edge would close a loop, std::invalid_argument when a number is not finite.
  PROCAM_EXPORT void set(const std::string& parent, const std::string& child,
                         const PoseWithCovariance& parent_from_child);
  void set(const std::string& parent, const std::string& child, const Pose& parent_from_child) {
    set(parent, child, PoseWithCovariance{parent_from_child, Mat6::Zero()});
  }

  /// The chain from source to target, link by link in the order of multiplication; empty when both are one
  /// frame. Throws Error(kInput) when the two are not connected.
  PROCAM_EXPORT std::vector<Link> chain(const std::string& target, const std::string& source) const;

  /// target_from_source with its covariance.
  PROCAM_EXPORT PoseWithCovariance get(const std::string& target, const std::string& source) const;

 private:
  struct Edge {
    std::string parent;
    PoseWithCovariance parent_from_child;
  };
  std::map<std::string, Edge> edges_;  ///< by child

  /// The frame itself, its parent, and so on to the root.
  PROCAM_EXPORT std::vector<std::string> ancestors(const std::string& frame) const;
};

}  // namespace procam

#ifndef PROCAM_CORE_COMPILED
#include "procam/core/geometry/detail/frame_tree_body.hpp"
#endif
