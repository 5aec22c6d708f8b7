#pragma once
/// The options of scan-surfaces that several stations have, and what they lead to.
#include <optional>
#include <string>
#include <vector>

#include "common/cli.hpp"
#include "procam/core/rig/rig.hpp"
#include "procam/io/text.hpp"
#include "procam/report/stations.hpp"

namespace procam::tools {

struct StationFlags {
  std::vector<std::string> poses;  ///< one a station
  std::string save_poses;
  io::LengthAndAngle pose_sigma;
  bool keep_poses = false;
  scan::RegistrationOptions registration;
  scan::MergeOptions merge;
};

void declare_stations(CLI::App& app, StationFlags& flags);

/// Of each station, world_from_rig with its covariance; none without --station-pose. Throws Error(kInput) for files of other frames, of
/// another number than the stations, and without a covariance where no --pose-sigma is given.
std::vector<PoseWithCovariance> known_poses(const StationFlags& flags, const Rig& rig, std::size_t stations);

/// A station of a simulation: its pose, and its views' true depths.
struct TrueStation {
  Pose world_from_rig;
  std::vector<scan::TrueView> views;  ///< in the world
};

/// Registration and merging; `truth` is empty or has one for each station, in the simulation's world.
report::StationsReport merged_stations(const StationFlags& flags, const std::vector<scan::Station>& stations,
                                       std::vector<TrueStation> truth);

/// Of simulate-captures --room: truth.json, truth_station.json and the depths of `view`.
TrueStation load_true_station(const std::string& folder, const std::string& view);

/// Throws Error(kInput) for options that several stations alone have, or do not have, and for a `truth` of some stations.
void require_stations(const StationFlags& flags, std::size_t stations, std::size_t truth, bool has_depth);

/// The merged points, the picture, and of --save-poses for each station FILE_STATION.json. The names of the files.
std::vector<std::string> save_station_files(const StationFlags& flags, const std::string& points,
                                            const std::string& preview, const report::StationsReport& report);

}  // namespace procam::tools
