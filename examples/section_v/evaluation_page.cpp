#include "evaluation_page.hpp"

#include <algorithm>
#include <cmath>

#include "html.hpp"
#include "page.hpp"
#include "pictures.hpp"
#include "style.hpp"

namespace procam::section_v {

using namespace report;

namespace {

const char* const kCornerNames[] = {"top left", "top right", "bottom right", "bottom left"};

std::string centimetres(const Vec2& metres) {
  return element("td", "class=\"n\"", fixed(100 * metres.x(), 2)) +
         element("td", "class=\"n\"", fixed(100 * metres.y(), 2));
}

std::string corner_table(const SheetEvaluation& result) {
  std::string rows;
  for (std::size_t i = 0; i < 4; ++i) {
    const CornerRow& row = result.corners[i];
    if (row.count == 0) continue;
    rows += element("tr", "",
                    element("td", "", kCornerNames[i]) + centimetres(row.physical) + centimetres(row.median) +
                        centimetres(row.standard_deviation) +
                        element("td", "class=\"n\"", fixed(1e3 * row.error, 2)) +
                        element("td", "class=\"n\"", std::to_string(row.count))) +
            "\n";
  }
  const auto pair = [](const char* name) { return element("th", "class=\"n\" colspan=\"2\"", name); };
  return element("div", "class=\"scroll\"",
                 element("table", "",
                         element("tr", "",
                                 element("th", "", "Corner") + pair("physical x, y, cm") +
                                     pair("projected, median, cm") + pair("standard deviation, cm") +
                                     element("th", "class=\"n\"", "error, mm") +
                                     element("th", "class=\"n\"", "placements")) +
                             "\n" + rows));
}

std::string distance_color(double distance) {
  // As the distances of the experiment; what is farther is darker.
  return distance < 1.4 ? "#e0921a" : distance < 1.9 ? "#c8402f" : "#5b2a86";
}

/// The sheet as it stands, its corners as crosses, every landing as a dot; the offsets magnified where they
/// would not show.
std::string scatter(const Evaluation& evaluation, const SheetEvaluation& result) {
  constexpr double kWidth = 520, kRim = 30;
  const Vec2 half = 0.5 * result.sheet.size;
  const double magnified =
      std::max(1.0, round_step(0.24 * half.x() / std::max(1e-3 * result.worst_mm, 1e-9)));
  const Vec2 reach = half + Vec2::Constant(magnified * 1e-3 * result.worst_mm);
  const double scale = (0.5 * kWidth - kRim) / reach.x(), height = 2 * (reach.y() * scale + kRim);
  const Vec2 middle(0.5 * kWidth, 0.5 * height);
  std::string content = rectangle("class=\"axis\"", middle - scale * half, 2 * scale * half);
  Marks corners;
  for (const CornerRow& row : result.corners)
    if (row.count > 0) corners.cross(middle + scale * row.physical, 7);
  content += corners.path("class=\"bar\"", "the physical corners");
  for (const SheetPlacement& placement : evaluation.placements) {
    if (evaluation.sheets[std::size_t(placement.sheet)].name != result.sheet.name) continue;
    Marks dots;
    for (const Landing& landing : placement.landings)
      dots.dot(middle + scale * (landing.physical + magnified * (landing.projected - landing.physical)));
    content += dots.path("class=\"dots\" stroke=\"" + distance_color(placement.distance) + "\"",
                         fixed(placement.distance, 2) + " m");
  }
  for (const CornerRow& row : result.corners)
    if (row.count > 0)
      content += circle("class=\"ring\"",
                        middle + scale * (row.physical + magnified * (row.median - row.physical)), 6);
  const double bar = 1e-3 * round_step(1e3 * 40 / (scale * magnified));
  Marks length;
  length.line(Vec2(20, height - 14), Vec2(20 + bar * scale * magnified, height - 14));
  content += length.path("class=\"bar\"") + label(Vec2(26 + bar * scale * magnified, height - 10),
                                                  "class=\"tick\"", shortest(1e3 * bar) + " mm");
  return figure(
      svg("0 0 " + coordinate(kWidth) + " " + coordinate(height),
          "Where the corners landed on " + result.sheet.name, content),
      "Crosses: the sheet's corners. Dots: where their light landed, " +
          (magnified > 1 ? "offsets magnified " + shortest(magnified) + " times" : std::string("to scale")) +
          "; orange up to 1.4 m, red to 1.9 m, violet beyond. Rings: medians.");
}

std::string key_figure(const std::string& value, const std::string& words) {
  return element("div", "", element("b", "", value) + element("span", "", words));
}

std::string of_sheet_result(const Evaluation& evaluation, const SheetEvaluation& result) {
  std::string key =
      key_figure(significant(result.mean_mm, 3) + " mm", "mean distance of a corner from its place") +
      key_figure(significant(result.median_mm, 3) + " mm", "median") +
      key_figure(significant(result.worst_mm, 3) + " mm",
                 "worst of " + std::to_string(result.landings) + " landings");
  if (result.predicted_rms_mm > 0)
    key += key_figure(significant(result.rms_mm, 3) + " mm",
                      "rms, " + significant(result.predicted_rms_mm, 3) + " predicted; " +
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
                             result.causes.empty()
                                 ? ""
                                 : element("h3", "", "Predicted causes") + cause_table(result.causes))) +
         "\n";
}

std::string in_space(const Evaluation& evaluation) {
  if (evaluation.rig.projectors.empty()) return "";
  std::vector<SpaceOutline> outlines;
  for (std::size_t i = 0; i < evaluation.placements.size(); ++i) {
    const SheetPlacement& placement = evaluation.placements[i];
    const Sheet& sheet = evaluation.sheets[std::size_t(placement.sheet)];
    SpaceOutline outline{
        sheet.name + ", " + fixed(placement.distance, 2) + " m", {}, distance_color(placement.distance)};
    const Pose rig_from_sheet =
        evaluation.rig.projectors.front().rig_from_projector * placement.projector_from_sheet;
    for (const Vec2& corner : sheet_corners(sheet))
      outline.corners_in_rig.push_back(rig_from_sheet * Vec3(corner.x(), corner.y(), 0));
    outlines.push_back(outline);
  }
  return surfaces_in_space(evaluation.rig, outlines, "The sheets where they stood.");
}

}  // namespace

std::string evaluation_report(const Evaluation& evaluation, const std::string& title,
                              const std::vector<std::string>& verdict) {
  std::string items;
  for (std::size_t i = 1; i < verdict.size(); ++i) items += element("li", "", escaped(verdict[i]));
  std::string body =
      element("p", "class=\"kicker\"", "Evaluation") + "\n" + element("h1", "", escaped(title)) + "\n";
  if (!verdict.empty())
    body += element("div", "class=\"verdict\"",
                    element("p", "", escaped(verdict.front())) +
                        (items.empty() ? "" : element("ul", "", items))) +
            "\n";
  for (const SheetEvaluation& result : evaluation.results)
    body += section(escaped(result.sheet.name) + " (" + fixed(100 * result.sheet.size.x(), 2) + " by " +
                        fixed(100 * result.sheet.size.y(), 2) + " cm)",
                    of_sheet_result(evaluation, result));
  body += section("In space", in_space(evaluation));
  return page(title, body + element("script", "", kReportScript) + "\n");
}

}  // namespace procam::section_v
