#include "pose_check.hpp"

#include <algorithm>
#include <limits>

#include "procam/core/base/words.hpp"
#include "procam/core/geometry/se3.hpp"

namespace procam::scan {
namespace {

constexpr double kFarStation = 10;  // of the deepest scan
// A mistake explains the poses when so much of each station is seen by another (minus what is seen through), and so much more
// than by the poses as given.
constexpr double kFittingShare = 0.3, kMoreThanGiven = 0.15;
constexpr double kNearlyAsWell = 0.9;  // of the best: another mistake explains the poses, too
// Larger corrections are no correction of a pose: the surfaces were brought together elsewhere.
constexpr double kMaxCorrection = 0.15, kMaxCorrectionAngle = 6 * kDegree;
constexpr std::size_t kMaxExchanged = 5;  // stations: all pairs of more are too many to try

/// The poses with one mistake undone.
struct PoseMistake {
  std::string words;
  std::vector<Pose> poses;
};

std::string quoted(const Station& station) {
  return "'" + station.name + "'";
}

std::vector<Pose> given_poses(const std::vector<Station>& stations) {
  std::vector<Pose> poses;
  for (const Station& station : stations) poses.push_back(station.world_from_rig->pose);
  return poses;
}

std::vector<PoseMistake> usual_mistakes(const std::vector<Station>& stations) {
  const std::vector<Pose> given = given_poses(stations);
  std::vector<PoseMistake> all;
  PoseMistake inverted{"they are inverted (rig_from_world instead of world_from_rig)", given};
  for (Pose& pose : inverted.poses) pose = pose.inverse();
  all.push_back(std::move(inverted));
  PoseMistake scaled{"their translations are in millimetres", given};
  for (Pose& pose : scaled.poses) pose.translation *= 1e-3;
  all.push_back(std::move(scaled));
  if (stations.size() > kMaxExchanged) return all;
  for (std::size_t a = 0; a < stations.size(); ++a)
    for (std::size_t b = a + 1; b < stations.size(); ++b) {
      all.push_back(
          {"those of stations " + quoted(stations[a]) + " and " + quoted(stations[b]) + " are exchanged",
           given});
      std::swap(all.back().poses[a], all.back().poses[b]);
    }
  return all;
}

/// The smallest share over the stations that another sees of one; negative where a station does not fit the others near its pose.
double fit(const std::vector<StationView>& views, const std::vector<Pose>& poses) {
  double worst = std::numeric_limits<double>::infinity();
  for (std::size_t s = 0; s < views.size(); ++s) {
    double best = -1;
    for (std::size_t t = 0; t < views.size(); ++t)
      if (t != s)
        best = std::max(best, alignment_near(views[s], views[t], poses[t].inverse() * poses[s],
                                             kMaxCorrection, kMaxCorrectionAngle));
    worst = std::min(worst, best);
  }
  return worst;
}

double deepest(const Station& station) {
  double depth = 0;
  for (const Scan& scan : station.scans)
    for (int y = 0; y < scan.depth.height(); y += 4)
      for (int x = 0; x < scan.depth.width(); x += 4) depth = std::max(depth, double(scan.depth.at(x, y)));
  return depth;
}

void refuse_pose_twice(const std::vector<Station>& stations) {
  for (std::size_t a = 0; a < stations.size(); ++a)
    for (std::size_t b = a + 1; b < stations.size(); ++b) {
      const Pose change = stations[a].world_from_rig->pose.inverse() * stations[b].world_from_rig->pose;
      if (se3_log(change).norm() > 1e-6) continue;
      throw Error(ErrorKind::kInput, "stations " + quoted(stations[a]) + " and " + quoted(stations[b]),
                  "both have the same pose, but their surfaces do not fit by it",
                  "one pose is probably given twice; give that of each station");
    }
}

}  // namespace

void require_near_stations(const std::vector<Station>& stations) {
  double depth = 0;
  for (const Station& station : stations) depth = std::max(depth, deepest(station));
  for (const Station& one : stations) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Station& other : stations)
      if (&other != &one)
        nearest = std::min(
            nearest, (other.world_from_rig->pose.translation - one.world_from_rig->pose.translation).norm());
    if (nearest <= kFarStation * depth) continue;
    throw Error(
        ErrorKind::kInput, "station " + quoted(one),
        format("by the known poses it is %.3g m from all others, and nothing is scanned beyond %.2g m",
               nearest, depth),
        "poses are in metres: are these in millimetres?");
  }
}

void refuse_mistaken_poses(const std::vector<Station>& stations, const std::vector<StationView>& views) {
  const double as_given = fit(views, given_poses(stations));
  if (as_given >= kFittingShare) return;
  refuse_pose_twice(stations);
  std::vector<std::pair<double, std::string>> fitting;
  double best = std::max(kFittingShare, as_given + kMoreThanGiven);
  for (const PoseMistake& mistake : usual_mistakes(stations)) {
    fitting.push_back({fit(views, mistake.poses), mistake.words});
    best = std::max(best, fitting.back().first);
  }
  std::vector<std::string> words;
  for (const auto& [share, mistake] : fitting)
    if (share >= kNearlyAsWell * best && share >= std::max(kFittingShare, as_given + kMoreThanGiven))
      words.push_back(mistake);
  if (words.empty()) return;
  std::string all = words.front();
  for (std::size_t i = 1; i < words.size(); ++i) all += ", or " + words[i];
  throw Error(ErrorKind::kInput, "the known poses of the stations",
              "the surfaces do not fit by them, but they do if " + all, "correct the poses or their order");
}

}  // namespace procam::scan
