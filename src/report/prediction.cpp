#include <algorithm>
#include <cmath>

#include "heat.hpp"
#include "html.hpp"
#include "page.hpp"
#include "pictures.hpp"
#include "procam/report/prediction.hpp"
#include "style.hpp"

namespace procam::report {

using analyze::Cause;
using analyze::Ellipse;
using analyze::LandingError;
using analyze::region95;
using analyze::SurfacePrediction;
using analyze::Sweep;
std::string cause_table(const std::vector<Cause>& causes) {
  std::string rows;
  for (const Cause& cause : causes)
    rows += element("tr", "",
                    element("td", "", escaped(cause.name)) +
                        element("td", "class=\"n\"", significant(cause.rms_mm, 3)) +
                        element("td", "class=\"n\"", significant(cause.without_mm, 3))) +
            "\n";
  return element("div", "class=\"scroll\"",
                 element("table", "",
                         element("tr", "",
                                 element("th", "", "Cause") + element("th", "class=\"n\"", "alone, mm") +
                                     element("th", "class=\"n\"", "all but this, mm")) +
                             "\n" + rows));
}

namespace {

std::string in_millimetres(double mm) {
  return significant(mm, 3) + " mm";
}

/// The content as it hangs, coloured by the rms error; arrows for the bias, ellipses for the 95 % region,
/// both magnified.
std::string heat_map(const SurfacePrediction& prediction) {
  constexpr double kWidth = 720;
  const double aspect = prediction.size.y() > 0 && prediction.size.x() > 0
                            ? std::clamp(prediction.size.y() / prediction.size.x(), 0.2, 2.0)
                            : 0.6;
  const Vec2 map(kWidth, kWidth * aspect), cell(map.x() / prediction.columns, map.y() / prediction.rows);
  std::string content;
  for (std::size_t i = 0; i < prediction.grid.size(); ++i) {
    const auto& error = prediction.grid[i];
    if (!error) continue;
    const double mm = 1e3 * error->total.rms();
    content += filled(prediction.content[i].cwiseProduct(map) - 0.5 * cell, cell,
                      heat(mm / prediction.worst_mm), in_millimetres(mm));
  }
  const double pixels_per_metre = prediction.size.x() > 0 ? map.x() / prediction.size.x() : 1;
  // The largest bar and 95 % region together reach halfway to the next.
  double reach = 1e-12;
  for (const auto& error : prediction.grid)
    if (error)
      reach = std::max(reach, error->total.bias.norm() + region95(error->total.covariance).semi_major);
  const double magnified = round_step(2 * std::min(cell.x(), cell.y()) / (reach * pixels_per_metre));
  Marks bias;
  for (int row = 2; row < prediction.rows; row += 4)
    for (int column = 2; column < prediction.columns; column += 4) {
      const std::size_t i = std::size_t(row * prediction.columns + column);
      if (!prediction.grid[i]) continue;
      const LandingError& error = *prediction.grid[i];
      const Vec2 at = prediction.content[i].cwiseProduct(map);
      const Ellipse region = region95(error.total.covariance);
      const double scale = magnified * pixels_per_metre;
      const Vec2 centre = at + scale * error.total.bias;
      const std::string shape = " cx=\"" + coordinate(centre.x()) + "\" cy=\"" + coordinate(centre.y()) +
                                "\" rx=\"" + coordinate(scale * region.semi_major) + "\" ry=\"" +
                                coordinate(scale * region.semi_minor) + "\" transform=\"rotate(" +
                                fixed(region.angle / kDegree, 1) + " " + position(centre) + ")\"";
      for (const char* const layer : {"under", "over"})
        content += element("ellipse", "class=\"" + std::string(layer) + "\"" + shape, "");
      bias.line(at, centre);
    }
  content += bias.path("class=\"under\"") + bias.path("class=\"over\"", "bias");
  content += rectangle("class=\"frame\"", Vec2(0, 0), map);
  content += heat_scale(Vec2(0, map.y() + 14), 300, in_millimetres(prediction.worst_mm));
  return figure(
      svg("-6 -6 732 " + coordinate(map.y() + 54),
          "Error over " + prediction.surface + ", at worst " + in_millimetres(prediction.worst_mm), content),
      "Root mean square distance between where the light is meant to land and where it lands, over the "
      "content as it hangs (" +
          fixed(prediction.size.x(), 2) + " m by " + fixed(prediction.size.y(), 2) +
          " m). Bars: bias; ellipses: 95 % regions; " +
          (magnified == 1 ? "both to scale" : "both drawn " + shortest(magnified) + " times as large") +
          ". White: not lit.");
}

std::string curve(const Sweep& sweep) {
  constexpr double kWidth = 340, kHeight = 190, kLeft = 44, kBottom = 34;
  if (sweep.values.size() < 2) return "";
  const double low = sweep.values.front(), high = sweep.values.back();
  // An error that explodes at grazing angles would flatten all the rest: the curve is cut.
  std::vector<double> sorted = sweep.rms_mm;
  std::sort(sorted.begin(), sorted.end());
  const double top = std::min(sorted.back(), 4 * sorted[sorted.size() / 2]) * 1.05;
  if (!(top > 0) || !(high > low)) return "";
  const auto at = [&](double value, double mm) {
    return Vec2(kLeft + (kWidth - kLeft) * (value - low) / (high - low),
                (kHeight - kBottom) * (1 - std::min(mm, top) / top));
  };
  std::string content;
  const double step_y = round_step(top / 3), step_x = round_step((high - low) / 3);
  for (double mm = 0; mm <= top; mm += step_y) {
    content +=
        element("path", "class=\"axis\" d=\"M" + position(at(low, mm)) + "H" + coordinate(kWidth) + "\"", "");
    content += label(at(low, mm) + Vec2(-6, 4), "class=\"tick\" text-anchor=\"end\"", shortest(mm));
  }
  for (double value = step_x * std::ceil(low / step_x); value <= high; value += step_x)
    content += label(at(value, 0) + Vec2(0, 14), "class=\"tick\" text-anchor=\"middle\"", shortest(value));
  std::string d;
  for (std::size_t i = 0; i < sweep.values.size(); ++i)
    d += (i == 0 ? "M" : "L") + position(at(sweep.values[i], sweep.rms_mm[i]));
  content += element("path", "class=\"principal\" d=\"" + d + "\"", "");
  content += element("path", "class=\"ring\" d=\"M" + position(at(sweep.here, 0)) + "V0\"",
                     element("title", "", "as it is"));
  content +=
      label(Vec2(kWidth, kHeight - 4), "class=\"tick\" text-anchor=\"end\"", sweep.name + ", " + sweep.unit);
  content += label(Vec2(0, -6), "class=\"tick\"", "mm");
  return figure(svg("0 -18 350 214", "Error against " + sweep.name, content), "");
}

std::string of_surface(const SurfacePrediction& prediction) {
  std::string key = element("div", "",
                            element("b", "", in_millimetres(prediction.rms_mm)) +
                                element("span", "", "rms over the content")) +
                    element("div", "",
                            element("b", "", in_millimetres(prediction.worst_mm)) +
                                element("span", "",
                                        "at the worst point (u " + fixed(prediction.worst_content.x(), 2) +
                                            ", v " + fixed(prediction.worst_content.y(), 2) + ")")) +
                    element("div", "",
                            element("b", "", fixed(prediction.incidence_deg, 1) + "\u00b0") +
                                element("span", "", "largest angle of the light to the surface's normal"));
  if (!prediction.drawn.empty())
    key += element("div", "",
                   element("b", "", in_millimetres(prediction.drawn_rms_mm)) +
                       element("span", "", "rms by Monte Carlo"));
  std::string remarks;
  for (const Diagnostic& item : prediction.diagnostics.items)
    remarks += element("p", "class=\"warning\"", escaped(item.message)) + "\n";
  std::string curves;
  for (const Sweep& sweep : prediction.sweeps) curves += curve(sweep);
  return element("div", "class=\"key\"", key) + "\n" + remarks +
         element("div", "class=\"pair\"",
                 heat_map(prediction) +
                     element("div", "",
                             element("h3", "", "Causes") + cause_table(prediction.causes) +
                                 element("p", "class=\"hint\"",
                                         "What would help most: " + escaped(prediction.advice) + "."))) +
         "\n" + element("h3", "", "What if (at the content's middle)") +
         element("div", "class=\"tiles\"", curves) + "\n";
}

std::string in_space(const std::vector<SurfacePrediction>& surfaces, const Rig& rig) {
  std::vector<SpaceOutline> outlines;
  for (std::size_t i = 0; i < surfaces.size(); ++i)
    outlines.push_back({surfaces[i].surface + ", " + in_millimetres(surfaces[i].rms_mm) + " rms",
                        surfaces[i].corners_in_rig, view_color(int(i))});
  std::string names;
  for (const SpaceOutline& outline : outlines)
    names += (names.empty() ? "" : "; ") +
             element("span", "class=\"note\"",
                     element("span", "class=\"swatch\" style=\"background:" + outline.color + "\"", "") +
                         escaped(outline.name));
  return surfaces_in_space(rig, outlines, "The content on its surfaces: " + names + ". ");
}

}  // namespace

std::string prediction_report(const std::vector<SurfacePrediction>& surfaces, const Rig& rig,
                              const std::string& title) {
  require(!surfaces.empty(), "prediction_report: no surface");
  const auto worst = std::max_element(surfaces.begin(), surfaces.end(),
                                      [](const auto& a, const auto& b) { return a.rms_mm < b.rms_mm; });
  std::string body = element("p", "class=\"kicker\"", "Predicted error") + "\n" +
                     element("h1", "", escaped(title)) + "\n" +
                     element("div", "class=\"verdict\"",
                             element("p", "",
                                     "Predicted projection error on " + escaped(worst->surface) +
                                         (surfaces.size() > 1 ? ", the least certain surface" : "") + ": " +
                                         in_millimetres(worst->rms_mm) + " RMS.")) +
                     "\n";
  std::string sections;
  for (const SurfacePrediction& surface : surfaces)
    sections += section(escaped(surface.surface), of_surface(surface));
  sections += section("In space", in_space(surfaces, rig));
  body += table_of_contents(sections) + sections;
  return page(title, body + data(to_json(surfaces)) + element("script", "", kReportScript) + "\n");
}

}  // namespace procam::report
