#include <algorithm>
#include <cmath>

#include "fields.hpp"
#include "procam/report/verify.hpp"

namespace procam::report {

static void fields(Fields& f, const analyze::Movement& m) {
  constexpr double kPerRadian = 1 / kDegree;
  const Vec6 sigma = m.covariance.diagonal().cwiseMax(0).cwiseSqrt();
  f.field("what", m.what);
  f.field("angle_deg", m.angle() * kPerRadian);
  f.field("angle_sigma_deg", m.angle_sigma() * kPerRadian);
  f.field("shift_mm", 1e3 * m.shift());
  f.field("shift_sigma_mm", 1e3 * m.shift_sigma());
  f.field("rotation_deg", Vec3(kPerRadian * m.moved.head<3>()));
  f.field("rotation_sigma_deg", Vec3(kPerRadian * sigma.head<3>()));
  f.field("translation_mm", Vec3(1e3 * m.moved.tail<3>()));
  f.field("translation_sigma_mm", Vec3(1e3 * sigma.tail<3>()));
  f.field("rms_after_mm", 1e3 * m.rms_after);
}

static void fields(Fields& f, const analyze::VerifiedMark& mark) {
  f.field("projector_px", mark.seen.projector_pixel);
  f.field("camera_px", mark.seen.camera_pixel);
  f.field("on_surface_mm", Vec2(1e3 * mark.intended));
  f.field("error_mm", Vec2(1e3 * mark.error));
  f.field("sigma_mm", Vec2(1e3 * mark.covariance.diagonal().cwiseSqrt()));
  f.field("chi2", mark.chi2);
  f.field("used", mark.rejection.empty());
  f.optional("left_out", mark.rejection);
}

static void fields(Fields& f, const analyze::VerifyResult& result) {
  f.field("alarm", result.alarm);
  f.field("surface", result.surface);
  f.field("rms_mm", 1e3 * result.rms);
  f.field("worst_mm", 1e3 * result.worst);
  f.field("rms_after_mm", 1e3 * result.rms_after);
  f.field("worst_after_mm", 1e3 * result.worst_after);
  f.field("chi2", result.chi2);
  f.field("degrees_of_freedom", result.degrees_of_freedom);
  f.field("chi2_limit", result.limit);
  f.field("false_alarm_rate", result.false_alarm_rate);
  f.field("marks_used", result.used);
  f.field("scatter", result.scatter);
  f.field("scatter_rms_mm", 1e3 * result.scatter_rms);
  f.field("projector_moved", result.projector_moved);
  f.optional("surface_moved", result.surface_moved);
  if (result.surface_moved)
    f.field("log_odds_projector", result.projector_moved.log_evidence - result.surface_moved->log_evidence);
  f.field("marks", result.marks);
}

std::string to_json(const analyze::VerifyResult& result) {
  return text(json(result));
}

std::string description(const analyze::Movement& m) {
  return format("%s turned by %.3f +- %.3f deg and shifted by %.2f +- %.2f mm: leaves %.3f mm rms",
                m.what.c_str(), m.angle() / kDegree, m.angle_sigma() / kDegree, 1e3 * m.shift(),
                1e3 * m.shift_sigma(), 1e3 * m.rms_after);
}

static std::string mark_line(std::size_t index, const analyze::VerifiedMark& mark) {
  const Vec2 at = 1e3 * mark.intended, error = 1e3 * mark.error,
             sigma = 1e3 * mark.covariance.diagonal().cwiseSqrt();
  const Vec2& pixel = mark.seen.projector_pixel;
  return format("%-6zu %7.1f %8.1f  %8.1f %8.1f  %8.3f %8.3f  %7.3f %7.3f %8.3g", index, pixel.x(), pixel.y(),
                at.x(), at.y(), error.x(), error.y(), sigma.x(), sigma.y(), mark.chi2) +
         (!mark.rejection.empty() ? "  rejected: " + mark.rejection
          : mark.beyond           ? "  beyond"
                                  : "");
}

std::vector<std::string> lines(const analyze::VerifyResult& result) {
  std::vector<std::string> lines{format(
      "%s: light on '%s' lies %.3f mm rms from its place, %.3f at most (%d marks; chi-square %.1f of "
      "%d, limit %.1f at a false-alarm rate of %g)",
      result.alarm ? "ALARM" : "all well", result.surface.c_str(), 1e3 * result.rms, 1e3 * result.worst,
      result.used, result.chi2, result.degrees_of_freedom, result.limit, result.false_alarm_rate)};
  if (result.alarm) lines.push_back("either " + description(result.projector_moved));
  if (result.alarm && result.surface_moved) {
    lines.push_back("or     " + description(*result.surface_moved));
    const double odds = result.projector_moved.log_evidence - result.surface_moved->log_evidence;
    lines.push_back(format("odds of the first to the second: %s%.3g to 1",
                           std::abs(odds) > 13 ? "beyond " : "", std::exp(std::clamp(odds, -13.8, 13.8))));
  }
  if (result.rig || result.rig_from_surface)
    lines.push_back(
        format("corrected: %.3f mm rms, %.3f at most", 1e3 * result.rms_after, 1e3 * result.worst_after));
  lines.push_back(format("residual RMS without movement: %.3f mm, %.2f times the detected noise",
                         1e3 * result.scatter_rms, result.scatter));
  lines.push_back(format("%-6s %16s %18s %18s %15s %8s", "mark", "projector px", "on surface mm", "error mm",
                         "sigma mm", "chi2"));
  for (std::size_t i = 0; i < result.marks.size(); ++i) lines.push_back(mark_line(i, result.marks[i]));
  return lines;
}

}  // namespace procam::report
