#pragma once
/// Private to calibrate: a camera's start. First by itself, then among the devices that stand already.
#include <optional>
#include <string>
#include <vector>

#include "procam/calibrate/bundle.hpp"
#include "procam/calibrate/options.hpp"

namespace procam::calibrate {

/// A camera by its own views alone.
struct CameraAlone {
  Camera lens;
  std::vector<std::optional<Pose>> camera_from_board;  ///< by view; nullopt where it is not determined
  std::vector<std::string> why;                        ///< by view: why there is none
};

/// Zhang's equations and a bundle of its own; a known lens is kept. Throws Error(kNotEnoughData) with fewer
/// than three views, Error(kDegenerate) for boards that are all parallel.
CameraAlone calibrate_alone(const Correspondences& data, std::size_t camera,
                            const std::optional<Camera>& known, const Options& options);

/// Where the camera stands: the place that a shared view gives it by which its median shared view fits best.
struct CameraPlace {
  Pose camera_from_rig;
  std::vector<std::size_t> agreeing;  ///< shared views that the place holds for
  std::vector<std::size_t> turned;    ///< shared views whose points it has in the order turned by 180 degrees
};

/// `rig_from_board` by view, for those that are posed already. nullopt when no view is shared.
std::optional<CameraPlace> place_camera(const Correspondences& data, std::size_t camera,
                                        const CameraAlone& alone,
                                        const std::vector<std::optional<Pose>>& rig_from_board);

/// A board's pose before a device from its known lens; nullopt when no pose explains the pixels.
std::optional<Pose> board_pose(const Camera& lens, const Points3& board,
                               const std::vector<Observation>& observations);

}  // namespace procam::calibrate
