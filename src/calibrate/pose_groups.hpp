#pragma once
/// Private to calibrate: views that repeat one pose of the board.
#include <string>
#include <vector>

#include "procam/calibrate/bundle.hpp"

namespace procam::calibrate {

/// By view: the number of its group, counted from 0 in the order of the first views. Two views belong
/// together when the points that both have lie within 0.25 % of the image's width of each other (RMS) in
/// every camera that has six of them or more: then their corners share paper, light and place within a pixel,
/// and what disturbs one view disturbs the other likewise. Groups are chains of such pairs.
std::vector<int> pose_groups(const Correspondences& data);

/// Groups of which a view takes part.
int count_groups(const UsedMask& used, const std::vector<int>& groups);

/// A sentence about the views that repeat a pose; empty when none does.
std::string repeated_poses(const Correspondences& data, const UsedMask& used, const std::vector<int>& groups);

}  // namespace procam::calibrate
