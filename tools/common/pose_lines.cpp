#include "common/pose_lines.hpp"

namespace procam::tools {

constexpr double kDegrees = 1 / kDegree;

void say_link(Console& console, const FrameTree::Link& link, const std::string& at) {
  const PoseWithCovariance& pose = link.target_from_source;
  const Vec3 turn = so3_log(pose.pose.rotation) * kDegrees, shift = pose.pose.translation * 1e3;
  const Vec3 turn_sigma = pose.covariance.diagonal().head<3>().cwiseMax(0).cwiseSqrt() * kDegrees;
  const Vec3 shift_sigma = point_covariance(pose, Vec3::Zero()).diagonal().cwiseMax(0).cwiseSqrt() * 1e3;
  const auto values = [](const Vec3& v, int decimals) {
    return format("%9.*f %9.*f %9.*f", decimals, v.x(), decimals, v.y(), decimals, v.z());
  };
  const auto sigmas = [](const Vec3& v) {
    return comma_list(std::vector<double>{v.x(), v.y(), v.z()},
                      [](double sigma) { return significant(sigma, 2); });
  };
  console.say(format("%-22s rotation    %s deg (+- %s)", (link.target + "_from_" + link.source).c_str(),
                     values(turn, 3).c_str(), sigmas(turn_sigma).c_str()));
  console.say(
      format("%-22s translation %s mm  (+- %s)", "", values(shift, 2).c_str(), sigmas(shift_sigma).c_str()));
  const auto list = [](const Vec3& v) { return std::vector<double>{v.x(), v.y(), v.z()}; };
  Summary& summary = console.summary();
  summary.set(at + "/target", link.target);
  summary.set(at + "/source", link.source);
  summary.set(at + "/rotation_deg", list(turn));
  summary.set(at + "/rotation_sigma_deg", list(turn_sigma));
  summary.set(at + "/translation_mm", list(shift));
  summary.set(at + "/translation_sigma_mm", list(shift_sigma));
}

}  // namespace procam::tools
