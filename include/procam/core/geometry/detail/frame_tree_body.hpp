#pragma once
/// The bodies of frame_tree.hpp. NOLINTBEGIN(misc-definitions-in-headers)
#include "procam/core/base/error.hpp"
#include "procam/core/geometry/frame_tree.hpp"

namespace procam {

PROCAM_CORE_INLINE void FrameTree::set(const std::string& parent, const std::string& child,
                                       const PoseWithCovariance& parent_from_child) {
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

PROCAM_CORE_INLINE std::vector<FrameTree::Link> FrameTree::chain(const std::string& target,
                                                                 const std::string& source) const {
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
    links.push_back({above_source[i], above_source[i - 1], edges_.at(above_source[i - 1]).parent_from_child});
  return links;
}

PROCAM_CORE_INLINE PoseWithCovariance FrameTree::get(const std::string& target,
                                                     const std::string& source) const {
  PoseWithCovariance result;
  for (const Link& link : chain(target, source)) result = compose(result, link.target_from_source);
  return result;
}

PROCAM_CORE_INLINE std::vector<std::string> FrameTree::ancestors(const std::string& frame) const {
  std::vector<std::string> path{frame};
  for (auto edge = edges_.find(frame); edge != edges_.end(); edge = edges_.find(path.back()))
    path.push_back(edge->second.parent);
  return path;
}

}  // namespace procam
// NOLINTEND(misc-definitions-in-headers)
