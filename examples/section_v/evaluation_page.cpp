#include "evaluation_page.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>

#include "html.hpp"
#include "page.hpp"
#include "pictures.hpp"
#include "style.hpp"

namespace procam::section_v {

using namespace report;

namespace {

const char* const kCornerNames[] = {"top left", "top right", "bottom right", "bottom left"};

std::string millimetres(const Vec2& metres) {
  return element("td", "class=\"n\"", fixed(1e3 * metres.x(), 2)) +
         element("td", "class=\"n\"", fixed(1e3 * metres.y(), 2));
}

std::string corner_table(const SheetEvaluation& result) {
  std::string rows;
  for (std::size_t i = 0; i < 4; ++i) {
    const CornerRow& row = result.corners[i];
    if (row.count == 0) continue;
    rows += element("tr", "",
                    element("td", "", kCornerNames[i]) + millimetres(row.physical) + millimetres(row.median) +
                        millimetres(row.standard_deviation) +
                        element("td", "class=\"n\"", fixed(1e3 * row.error, 2)) +
                        element("td", "class=\"n\"", std::to_string(row.count))) +
            "\n";
  }
  const auto pair = [](const char* name) { return element("th", "class=\"n\" colspan=\"2\"", name); };
  return element("div", "class=\"scroll\"",
                 element("table", "",
                         element("tr", "",
                                 element("th", "", "Corner") + pair("physical x, y, mm") +
                                     pair("projected, median, mm") + pair("standard deviation, mm") +
                                     element("th", "class=\"n\"", "error, mm") +
                                     element("th", "class=\"n\"", "placements")) +
                             "\n" + rows));
}

/// Distances of the placements, sorted; equal ones once.
std::vector<double> distances_of(const Evaluation& evaluation) {
  std::vector<double> all;
  for (const SheetPlacement& placement : evaluation.placements) all.push_back(placement.distance);
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end(), [](double a, double b) { return b - a < 5e-3; }), all.end());
  return all;
}

/// Pale to dark with the distance.
std::string distance_color(const std::vector<double>& distances, double distance) {
  static const char* const kColors[] = {"#e0921a", "#c8402f", "#5b2a86", "#1f6f8b", "#2e7d32", "#555555"};
  std::size_t i = 0;
  while (i + 1 < distances.size() && distances[i] < distance - 5e-3) ++i;
  return kColors[i % std::size(kColors)];
}

/// Mean of the predicted errors of one corner over the placements of its sheet.
std::optional<analyze::LandingError::SourceError> mean_prediction(const Evaluation& evaluation, int sheet,
                                                                  int corner) {
  analyze::LandingError::SourceError mean;
  int count = 0;
  for (const SheetPlacement& placement : evaluation.placements)
    for (const Landing& landing : placement.landings) {
      if (placement.sheet != sheet || landing.corner != corner || !landing.predicted) continue;
      mean.bias += landing.predicted->total.bias;
      mean.covariance += landing.predicted->total.covariance;
      ++count;
    }
  if (count == 0) return std::nullopt;
  mean.bias /= count;
  mean.covariance /= count;
  return mean;
}

constexpr double kPanel = 250, kGap = 14, kTitle = 20;

/// One corner of the sheet, enlarged: `scale` pixels a metre about `middle`.
std::string corner_panel(const Evaluation& evaluation, int sheet, int corner, const Vec2& middle,
                         double scale) {
  const Vec2 half = Vec2::Constant(0.5 * kPanel);
  std::string content = rectangle("class=\"axis\"", middle - half, 2 * half);
  content += label(middle - half + Vec2(2, -6), "class=\"tick\"", kCornerNames[corner]);
  Marks origin;
  origin.cross(middle, 6);
  content += origin.path("class=\"bar\"", "the sheet's corner");
  if (const auto predicted = mean_prediction(evaluation, sheet, corner)) {
    const analyze::Ellipse region = analyze::region95(predicted->covariance);
    const Vec2 at = middle + scale * predicted->bias;
    content += element("ellipse",
                       "class=\"ring\" cx=\"" + coordinate(at.x()) + "\" cy=\"" + coordinate(at.y()) +
                           "\" rx=\"" + coordinate(scale * region.semi_major) + "\" ry=\"" +
                           coordinate(scale * region.semi_minor) + "\" transform=\"rotate(" +
                           fixed(region.angle / kDegree, 1) + " " + position(at) + ")\"",
                       element("title", "", "predicted 95 % region"));
  }
  const std::vector<double> distances = distances_of(evaluation);
  for (const SheetPlacement& placement : evaluation.placements) {
    if (placement.sheet != sheet) continue;
    Marks dots;
    for (const Landing& landing : placement.landings)
      if (landing.corner == corner) dots.dot(middle + scale * (landing.projected - landing.physical));
    content += dots.path(
        "class=\"dots\" stroke=\"" + distance_color(distances, placement.distance) + "\" stroke-width=\"5\"",
        fixed(placement.distance, 2) + " m");
  }
  return content;
}

/// The largest offset of a landing, and of a predicted region, metres.
double reach_of(const Evaluation& evaluation, int sheet) {
  double reach = 1e-9;
  for (const SheetPlacement& placement : evaluation.placements)
    for (const Landing& landing : placement.landings)
      if (placement.sheet == sheet) reach = std::max(reach, (landing.projected - landing.physical).norm());
  for (int corner = 0; corner < 4; ++corner)
    if (const auto predicted = mean_prediction(evaluation, sheet, corner))
      reach = std::max(reach, predicted->bias.norm() + analyze::region95(predicted->covariance).semi_major);
  return reach;
}

/// The four corners enlarged, at one scale, with a legend.
std::string scatter(const Evaluation& evaluation, const SheetEvaluation& result) {
  int sheet = 0;
  while (evaluation.sheets[std::size_t(sheet)].name != result.sheet.name) ++sheet;
  const double scale = 0.46 * kPanel / reach_of(evaluation, sheet);
  // On the page as on the sheet: clockwise from the top left.
  const Vec2 places[] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  const double width = 2 * kPanel + kGap, height = 2 * (kPanel + kTitle) + kGap + 34;
  std::string content;
  for (int corner = 0; corner < 4; ++corner) {
    const Vec2 middle(0.5 * kPanel + places[corner].x() * (kPanel + kGap),
                      kTitle + 0.5 * kPanel + places[corner].y() * (kPanel + kTitle + kGap));
    content += corner_panel(evaluation, sheet, corner, middle, scale);
  }
  const double bar = 1e-3 * round_step(1e3 * 80 / scale), y = height - 12;
  Marks length;
  length.line(Vec2(4, y), Vec2(4 + bar * scale, y));
  content += length.path("class=\"bar\"") +
             label(Vec2(10 + bar * scale, y + 4), "class=\"tick\"", shortest(1e3 * bar) + " mm");
  double x = 60 + bar * scale;
  const std::vector<double> distances = distances_of(evaluation);
  for (const double distance : distances) {
    Marks dot;
    dot.dot(Vec2(x, y));
    content +=
        dot.path("class=\"dots\" stroke=\"" + distance_color(distances, distance) + "\" stroke-width=\"7\"") +
        label(Vec2(x + 8, y + 4), "class=\"tick\"", fixed(distance, 2) + " m");
    x += 64;
  }
  return figure(
      svg("0 0 " + coordinate(width) + " " + coordinate(height),
          "Projected corners on the sheet at " + result.sheet.name, content),
      "The four corners, enlarged. Crosses: the sheet's corners. Dots: the projected corners, coloured by the "
      "distance of the sheet. Ellipses: predicted 95 % regions.");
}

/// One row a sheet: what was measured, what was predicted, and what remains if one half of the chain is perfect.
std::string sheet_rows(const Outcome& outcome) {
  const auto cell = [](const std::string& text) { return element("td", "class=\"n\"", text); };
  const auto head = [](const std::string& text) { return element("th", "class=\"n\"", text); };
  const bool has_halves = !outcome.halves.empty();
  std::string rows;
  bool is_predicted = false;
  for (const SheetEvaluation& one : outcome.evaluation.results) is_predicted |= one.predicted_rms_mm > 0;
  for (std::size_t i = 0; i < outcome.evaluation.results.size(); ++i) {
    const SheetEvaluation& one = outcome.evaluation.results[i];
    rows += element("tr", "",
                    element("td", "", escaped(one.sheet.name)) + cell(fixed(one.median_mm, 2)) +
                        cell(fixed(one.mean_mm, 2)) + cell(fixed(one.rms_mm, 2)) +
                        (is_predicted ? cell(fixed(one.predicted_rms_mm, 2)) : "") +
                        (has_halves ? cell(fixed(outcome.halves[i].with_true_calibration_mm, 2)) +
                                          cell(fixed(outcome.halves[i].with_true_pose_mm, 2))
                                    : "")) +
            "\n";
  }
  return element("div", "class=\"scroll\"",
                 element("table", "",
                         element("tr", "",
                                 element("th", "", "Sheet") + head("median, mm") + head("mean, mm") +
                                     head("RMS, mm") + (is_predicted ? head("predicted RMS, mm") : "") +
                                     (has_halves ? head("median with a perfect calibration, mm") +
                                                       head("median with an external pose, mm")
                                                 : "")) +
                             "\n" + rows)) +
         "\n" +
         (has_halves
              ? element(
                    "p", "class=\"hint\"",
                    "Perfect calibration: marker detection noise alone. External pose: from a tracker that makes "
                    "no error; calibration errors shared by camera and projector then no longer cancel.")
              : "") +
         "\n";
}

std::string key_figure(const std::string& value, const std::string& words) {
  return element("div", "", element("b", "", value) + element("span", "", words));
}

/// Position and rotation of a pose from one marker compensate each other.
std::string pose_hint(const SheetEvaluation& result) {
  if (!(result.pose_rms_mm > 0)) return "";
  return element("p", "class=\"hint\"",
                 "Position and rotation of the rig's pose are correlated: together they cause " +
                     significant(result.pose_rms_mm, 2) + " mm, less than each alone.");
}

std::string of_sheet_result(const Evaluation& evaluation, const SheetEvaluation& result) {
  std::string key = key_figure(significant(result.mean_mm, 3) + " mm", "mean error of a projected corner") +
                    key_figure(significant(result.median_mm, 3) + " mm", "median") +
                    key_figure(significant(result.worst_mm, 3) + " mm",
                               "largest of " + std::to_string(result.landings) + " corners");
  if (result.predicted_rms_mm > 0)
    key += key_figure(significant(result.rms_mm, 3) + " mm",
                      "RMS, " + significant(result.predicted_rms_mm, 3) + " predicted; " +
                          fixed(100 * result.inside_95, 0) + " % inside their 95 % regions");
  std::string words;
  if (result.turn)
    words = element("p", "class=\"hint\"",
                    "One pixel of reprojection error is " + significant(result.mm_per_pixel, 2) +
                        " mm here. A common rotation of the projector by " +
                        significant(result.turn->rotation.norm() / kDegree, 2) + "° would explain " +
                        fixed(100 * result.turn->explained, 0) + " % of the squared error; " +
                        significant(result.turn->rest_mm, 2) + " mm RMS remain.");
  return element("div", "class=\"key\"", key) + "\n" + corner_table(result) + words + "\n" +
         element("div", "class=\"pair\"",
                 scatter(evaluation, result) +
                     element("div", "",
                             result.causes.empty() ? ""
                                                   : element("h3", "", "Predicted causes") +
                                                         cause_table(result.causes) + pose_hint(result))) +
         "\n";
}

std::string in_space(const Evaluation& evaluation) {
  if (evaluation.rig.projectors.empty()) return "";
  const std::vector<double> distances = distances_of(evaluation);
  std::vector<SpaceOutline> outlines;
  for (std::size_t i = 0; i < evaluation.placements.size(); ++i) {
    const SheetPlacement& placement = evaluation.placements[i];
    const Sheet& sheet = evaluation.sheets[std::size_t(placement.sheet)];
    SpaceOutline outline{sheet.name + ", " + fixed(placement.distance, 2) + " m",
                         {},
                         distance_color(distances, placement.distance)};
    const Pose rig_from_sheet =
        evaluation.rig.projectors.front().rig_from_projector * placement.projector_from_sheet;
    for (const Vec2& corner : sheet_corners(sheet))
      outline.corners_in_rig.push_back(rig_from_sheet * Vec3(corner.x(), corner.y(), 0));
    outlines.push_back(outline);
  }
  return surfaces_in_space(evaluation.rig, outlines, "The sheets where they stood.");
}

}  // namespace

std::string evaluation_report(const Outcome& outcome, const std::string& title) {
  const Evaluation& evaluation = outcome.evaluation;
  std::string body =
      element("p", "class=\"kicker\"", "Evaluation") + "\n" + element("h1", "", escaped(title)) + "\n";
  if (!outcome.verdict.empty())
    body += element("div", "class=\"verdict\"", element("p", "", escaped(outcome.verdict.front()))) + "\n";
  body += sheet_rows(outcome);
  std::string items;
  if (outcome.halves.empty())
    for (std::size_t i = 1; i < outcome.verdict.size(); ++i)
      items += element("li", "", escaped(outcome.verdict[i]));
  if (!items.empty()) body += element("ul", "", items) + "\n";
  for (const SheetEvaluation& result : evaluation.results)
    body += section(escaped(result.sheet.name) + " (" + fixed(1e3 * result.sheet.size.x(), 1) + " by " +
                        fixed(1e3 * result.sheet.size.y(), 1) + " mm)",
                    of_sheet_result(evaluation, result));
  body += section("In space", in_space(evaluation));
  return page(title, body + element("script", "", kReportScript) + "\n");
}

}  // namespace procam::section_v
