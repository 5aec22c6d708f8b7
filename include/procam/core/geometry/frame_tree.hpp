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
  void set(const std::string& parent, const std::string& child, const PoseWithCovariance& parent_from_child) {
    require(parent_from_child.pose.is_finite() && parent_from_child.covariance.allFinite(),
            "FrameTree::set: pose of '" + child + "' in '" + parent + "' is not finite");
    const auto existing = edges_.find(child);
    if (existing != edges_.end() && existing->second.parent != parent)
      throw Error(ErrorKind::kInput, "frame '" + child + "'",
                  "it already hangs below '" + existing->second.parent + "' and cannot also hang below '" +
                      parent + "'",
                  "give every frame one parent, or give this one another name");
    for (std::string up = parent;; up = edges_.at(up).parent) {
      if (up == child)
        throw Error(ErrorKind::kInput, "frame '" + child + "'",
                    "placing it below '" + parent + "' closes a loop",
                    "give the poses of a tree: every frame has one parent");
      if (edges_.count(up) == 0) break;
    }
    edges_[child] = {parent, parent_from_child};
  }
  void set(const std::string& parent, const std::string& child, const Pose& parent_from_child) {
    set(parent, child, PoseWithCovariance{parent_from_child, Mat6::Zero()});
  }

  /// The chain from source to target, link by link in the order of multiplication; empty when both are one
  /// frame. Throws Error(kInput) when the two are not connected.
  std::vector<Link> chain(const std::string& target, const std::string& source) const {
    std::vector<std::string> above_target = ancestors(target), above_source = ancestors(source);
    if (above_target.back() != above_source.back())
      throw Error(ErrorKind::kInput, "pose " + target + "_from_" + source,
                  "no chain of known poses joins '" + target + "' and '" + source + "'",
                  "give the pose between '" + above_target.back() + "' and '" + above_source.back() + "'");
    while (above_target.size() > 1 && above_source.size() > 1 &&
           above_target[above_target.size() - 2] == above_source[above_source.size() - 2]) {
      above_target.pop_back();
      above_source.pop_back();
    }
    std::vector<Link>
        links;  // down from the common frame to the target (inverted edges), then up from the source
    for (std::size_t i = 0; i + 1 < above_target.size(); ++i)
      links.push_back(
          {above_target[i], above_target[i + 1], inverse(edges_.at(above_target[i]).parent_from_child)});
    for (std::size_t i = above_source.size() - 1; i > 0; --i)
      links.push_back(
          {above_source[i], above_source[i - 1], edges_.at(above_source[i - 1]).parent_from_child});
    return links;
  }

  /// target_from_source with its covariance.
  PoseWithCovariance get(const std::string& target, const std::string& source) const {
    PoseWithCovariance result;
    for (const Link& link : chain(target, source)) result = compose(result, link.target_from_source);
    return result;
  }

 private:
  struct Edge {
    std::string parent;
    PoseWithCovariance parent_from_child;
  };
  std::map<std::string, Edge> edges_;  ///< by child

  /// The frame itself, its parent, and so on to the root.
  std::vector<std::string> ancestors(const std::string& frame) const {
    std::vector<std::string> path{frame};
    for (auto edge = edges_.find(frame); edge != edges_.end(); edge = edges_.find(path.back()))
      path.push_back(edge->second.parent);
    return path;
  }
};

}  // namespace procam
