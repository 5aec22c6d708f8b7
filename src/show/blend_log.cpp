#include "blend_log.hpp"

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "procam/io/surface_file.hpp"

namespace procam::show {
namespace {

using nlohmann::json;

std::optional<Pose> unit_pose(const json& numbers) {
  constexpr double kUnit = 1e-6;
  std::array<double, 7> v{};
  if (!numbers.is_array() || numbers.size() != v.size()) return std::nullopt;
  for (std::size_t i = 0; i < v.size(); ++i) {
    if (!numbers[i].is_number()) return std::nullopt;
    v[i] = numbers[i].get<double>();
  }
  const Pose pose(Eigen::Quaterniond(v[0], v[1], v[2], v[3]), Vec3(v[4], v[5], v[6]));
  if (!pose.is_finite() || std::abs(pose.rotation.norm() - 1) > kUnit) return std::nullopt;
  return pose;
}

}  // namespace

std::string blend_line(const BlendScene& scene) {
  const Eigen::Quaterniond& q = scene.rig_from_projector.rotation;
  const Vec3& t = scene.rig_from_projector.translation;
  std::string text = io::surfaces_to_text(scene.surfaces);
  for (char& letter : text)
    if (letter == '\n') letter = ' ';
  return kBlendLine + json(scene.projectors).dump(-1, ' ', false, json::error_handler_t::replace) +
         ",\"rig_from_projector\":" + json{q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()}.dump() +
         ",\"surfaces\":" + text + "}";
}

std::optional<BlendScene> read_blend_line(const std::string& line, const std::filesystem::path& surfaces) {
  const json document = json::parse(line, nullptr, false);
  if (!document.is_object() || !document.contains("blend") || !document["blend"].is_array() ||
      !document.contains("rig_from_projector") || !document.contains("surfaces"))
    return std::nullopt;
  BlendScene scene;
  for (const json& name : document["blend"]) {
    if (!name.is_string()) return std::nullopt;
    scene.projectors.push_back(name.get<std::string>());
  }
  const std::optional<Pose> pose = unit_pose(document["rig_from_projector"]);
  if (!pose) return std::nullopt;
  scene.rig_from_projector = *pose;
  scene.surfaces = io::surfaces_from_text(document["surfaces"].dump(), surfaces);
  return scene;
}

}  // namespace procam::show
