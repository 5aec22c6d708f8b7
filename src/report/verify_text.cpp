#include <algorithm>
#include <cmath>

#include "csv.hpp"
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
  f.optional("rejected", mark.rejection);
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
  return format("%s rotated by %.3f +- %s deg and translated by %.2f +- %s mm: %s mm RMS remain",
                m.what.c_str(), m.angle() / kDegree, significant(m.angle_sigma() / kDegree, 2).c_str(),
                1e3 * m.shift(), significant(1e3 * m.shift_sigma(), 2).c_str(),
                significant(1e3 * m.rms_after, 2).c_str());
}

std::vector<std::string> lines(const analyze::VerifyResult& result) {
  const auto size = [](double rms, double max) {
    return significant(1e3 * rms, 2) + " mm RMS, " + significant(1e3 * max, 2) + " mm max";
  };
  std::vector<std::string> lines{format(
      "%-11serror on '%s': %s (%d marks; false-alarm rate %g)", result.alarm ? "ALARM" : "no alarm",
      result.surface.c_str(), size(result.rms, result.worst).c_str(), result.used, result.false_alarm_rate)};
  if (result.alarm) lines.push_back("cause 1    " + description(result.projector_moved));
  if (result.alarm && result.surface_moved) {
    lines.push_back("cause 2    " + description(*result.surface_moved));
    const double odds = result.projector_moved.log_evidence - result.surface_moved->log_evidence;
    lines.push_back(format("odds       cause %d is %s%.2g times more probable than cause %d",
                           odds >= 0 ? 1 : 2, std::abs(odds) > 13 ? "at least " : "",
                           std::exp(std::min(std::abs(odds), 13.8)), odds >= 0 ? 2 : 1));
  }
  if (result.rig || result.rig_from_surface)
    lines.push_back("corrected  " + size(result.rms_after, result.worst_after));
  lines.push_back(
      format("remaining  %s mm RMS after the best rigid correction, %.2f times the detection noise",
             significant(1e3 * result.scatter_rms, 2).c_str(), result.scatter));
  return lines;
}

std::vector<TextFile> verify_tables(const analyze::VerifyResult& result) {
  std::string table =
      "mark,projector_x,projector_y,camera_x,camera_y,surface_x_mm,surface_y_mm,error_x_mm,error_y_mm,"
      "sigma_x_mm,sigma_y_mm,chi2,used,reason\n";
  for (std::size_t i = 0; i < result.marks.size(); ++i) {
    const analyze::VerifiedMark& mark = result.marks[i];
    std::vector<std::string> cells{std::to_string(i)};
    for (const Vec2& pair : {mark.seen.projector_pixel, mark.seen.camera_pixel, Vec2(1e3 * mark.intended),
                             Vec2(1e3 * mark.error), Vec2(1e3 * mark.covariance.diagonal().cwiseSqrt())})
      for (int k = 0; k < 2; ++k) cells.push_back(csv_number(pair[k]));
    cells.insert(cells.end(),
                 {csv_number(mark.chi2), mark.rejection.empty() ? "1" : "0", csv_quoted(mark.rejection)});
    add_csv_row(table, cells);
  }
  return {{"marks.csv", table}};
}

}  // namespace procam::report
