#include "joined.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <string>

namespace procam::calibrate {
namespace {

/// "left, right and light".
std::string names_of(const Correspondences& data, const std::vector<std::size_t>& group) {
  std::string names;
  for (std::size_t i = 0; i < group.size(); ++i)
    names += (i == 0 ? "" : i + 1 < group.size() ? ", " : " and ") + data.devices[group[i]].name;
  return names;
}

/// A camera of the group where it has one: what a person would point.
const Device& speaker_of(const Correspondences& data, const std::vector<std::size_t>& group) {
  for (const std::size_t d : group)
    if (data.devices[d].kind == DeviceKind::kCamera) return data.devices[d];
  return data.devices[group.front()];
}

}  // namespace

int count_used(const UsedMask& used, std::size_t view, std::size_t device) {
  const std::vector<char>& mask = used[view][device];
  return int(std::count(mask.begin(), mask.end(), char(1)));
}

std::vector<std::vector<std::size_t>> joined_devices(const Correspondences& data, const UsedMask& used) {
  std::vector<std::size_t> group_of(data.devices.size());
  std::iota(group_of.begin(), group_of.end(), 0);
  std::vector<char> present(data.devices.size(), 0);
  for (std::size_t v = 0; v < data.views.size(); ++v) {
    std::optional<std::size_t> first;
    for (std::size_t d = 0; d < data.devices.size(); ++d) {
      if (count_used(used, v, d) < kMinPointsPerView) continue;
      present[d] = 1;
      if (!first) first = d;
      const std::size_t from = group_of[d], to = group_of[*first];
      std::replace(group_of.begin(), group_of.end(), from, to);
    }
  }
  std::map<std::size_t, std::vector<std::size_t>> by_group;
  for (std::size_t d = 0; d < data.devices.size(); ++d)
    if (present[d]) by_group[group_of[d]].push_back(d);
  std::vector<std::vector<std::size_t>> groups;
  for (auto& [number, group] : by_group) groups.push_back(std::move(group));
  std::sort(groups.begin(), groups.end());
  return groups;
}

void require_joined(const Correspondences& data, const UsedMask& used) {
  const auto groups = joined_devices(data, used);
  if (groups.size() < 2) return;
  const Device &one = speaker_of(data, groups[0]), &other = speaker_of(data, groups[1]);
  const auto shares = [](const Device& device) {
    return device.name + (device.kind == DeviceKind::kCamera ? " sees the board" : " lights the board");
  };
  throw Error(ErrorKind::kNotEnoughData, "calibration",
              "no view joins " + names_of(data, groups[0]) + " to " + names_of(data, groups[1]) +
                  ", so where they stand to each other is unknown",
              "capture views, best three or more, in which " + shares(one) + " while " + shares(other) +
                  ", or calibrate them apart");
}

}  // namespace procam::calibrate
