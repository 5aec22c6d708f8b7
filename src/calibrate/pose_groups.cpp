#include "pose_groups.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "solve.hpp"

namespace procam::calibrate {
namespace {

constexpr double kSameShare = 0.0025;  ///< of the image's width: 3 px of 1280
constexpr int kMinShared = 6;

bool same_pose(const Correspondences& data, std::size_t a, std::size_t b) {
  bool same = false;
  for (std::size_t d = 0; d < data.devices.size(); ++d) {
    if (data.devices[d].kind != DeviceKind::kCamera) continue;
    std::map<int, Vec2> pixels;
    for (const Observation& o : data.views[a].observations[d]) pixels[o.point] = o.pixel;
    double sum = 0;
    int shared = 0;
    for (const Observation& o : data.views[b].observations[d])
      if (const auto other = pixels.find(o.point); other != pixels.end())
        sum += (o.pixel - other->second).squaredNorm(), ++shared;
    if (shared < kMinShared) continue;
    if (std::sqrt(sum / shared) > kSameShare * data.devices[d].size.width) return false;
    same = true;
  }
  return same;
}

}  // namespace

std::vector<int> pose_groups(const Correspondences& data) {
  std::vector<int> groups;
  int count = 0;
  for (std::size_t v = 0; v < data.views.size(); ++v) {
    groups.push_back(count++);
    for (std::size_t u = 0; u < v; ++u) {
      if (groups[u] == groups[v] || !same_pose(data, u, v)) continue;
      const int from = std::max(groups[u], groups[v]), to = std::min(groups[u], groups[v]);
      std::replace(groups.begin(), groups.end(), from, to);
    }
  }
  return groups;
}

int count_groups(const UsedMask& used, const std::vector<int>& groups) {
  std::set<int> numbers;
  for (std::size_t v = 0; v < used.size(); ++v)
    if (takes_part(used, v)) numbers.insert(groups[v]);
  return int(numbers.size());
}

std::string repeated_poses(const Correspondences& data, const UsedMask& used,
                           const std::vector<int>& groups) {
  std::map<int, std::vector<std::string>> names;
  int views = 0;
  for (std::size_t v = 0; v < data.views.size(); ++v)
    if (takes_part(used, v)) names[groups[v]].push_back(data.views[v].name), ++views;
  if (int(names.size()) == views) return "";
  std::string repeated;
  for (const auto& [number, of_group] : names) {
    if (of_group.size() < 2) continue;
    repeated += (repeated.empty() ? "" : "; ") + of_group.front();
    for (std::size_t i = 1; i < of_group.size(); ++i)
      repeated += (i + 1 < of_group.size() ? ", " : " and ") + of_group[i];
  }
  return "the " + std::to_string(views) + " views show " + std::to_string(names.size()) +
         " poses of the board: " + repeated +
         " repeat one each, and count as one view; move the board between views";
}

}  // namespace procam::calibrate
