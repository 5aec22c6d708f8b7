#include <cmath>

#include "csv.hpp"
#include "fields.hpp"
#include "procam/report/prediction.hpp"

namespace procam::report {

static void fields(Fields& f, const analyze::Cause& cause) {
  f.field("name", cause.name);
  f.field("rms_mm", cause.rms_mm);
  f.field("without_mm", cause.without_mm);
}

static void fields(Fields& f, const analyze::SurfacePrediction& prediction) {
  f.field("name", prediction.surface);
  f.field("rms_mm", prediction.rms_mm);
  f.field("worst_mm", prediction.worst_mm);
  f.field("worst_content", prediction.worst_content);
  f.field("lit_share", prediction.lit_share);
  f.field("largest_incidence_deg", prediction.incidence_deg);
  if (!prediction.drawn.empty()) f.field("monte_carlo_rms_mm", prediction.drawn_rms_mm);
  f.field("causes", prediction.causes);
  f.field("advice", prediction.advice);
}

std::string to_json(const std::vector<analyze::SurfacePrediction>& surfaces) {
  Json object = Json::object();
  Fields(object).field("surfaces", surfaces);
  return text(object);
}

std::vector<std::string> lines(const analyze::SurfacePrediction& one) {
  std::vector<std::string> lines{
      format("%s: %.2f mm rms, %.2f mm at the worst point (u %.2f, v %.2f); light at up to %.1f deg%s",
             one.surface.c_str(), one.rms_mm, one.worst_mm, one.worst_content.x(), one.worst_content.y(),
             one.incidence_deg,
             one.drawn.empty() ? "" : format("; %.2f mm rms by Monte Carlo", one.drawn_rms_mm).c_str())};
  const char* const names[] = {"top left", "top right", "bottom right", "bottom left"};
  std::string corners = "  corners:";
  for (std::size_t i = 0; i < one.corners.size(); ++i)
    corners += (i > 0 ? ", " : " ") + std::string(names[i]) +
               (one.corners[i] ? format(" %.2f mm", 1e3 * one.corners[i]->total.rms()) : " not lit");
  lines.push_back(corners);
  for (const analyze::Cause& cause : one.causes)
    lines.push_back(format("  %-22s %8.2f mm alone, %8.2f mm without it", cause.name.c_str(), cause.rms_mm,
                           cause.without_mm));
  lines.push_back("  helps most: " + one.advice);
  return lines;
}

static std::string points_table(const std::vector<analyze::SurfacePrediction>& surfaces) {
  std::string table =
      "surface,u,v,surface_x,surface_y,pixel_x,pixel_y,incidence_deg,rms_mm,bias_x_mm,bias_y_mm,sigma_x_mm,sigma_y_mm\n";
  for (const analyze::SurfacePrediction& one : surfaces)
    for (std::size_t i = 0; i < one.grid.size(); ++i) {
      if (!one.grid[i]) continue;
      const analyze::LandingError& at = *one.grid[i];
      std::vector<std::string> cells{csv_quoted(one.surface)};
      for (const double value :
           {one.content[i].x(), one.content[i].y(), at.on_surface.x(), at.on_surface.y(), at.pixel.x(),
            at.pixel.y(), at.incidence_deg, 1e3 * at.total.rms(), 1e3 * at.total.bias.x(),
            1e3 * at.total.bias.y(), 1e3 * std::sqrt(at.total.covariance(0, 0)),
            1e3 * std::sqrt(at.total.covariance(1, 1))})
        cells.push_back(csv_number(value));
      add_csv_row(table, cells);
    }
  return table;
}

std::vector<TextFile> prediction_tables(const std::vector<analyze::SurfacePrediction>& surfaces) {
  std::string causes = "surface,cause,rms_mm,without_mm\n", sweeps = "surface,quantity,unit,value,rms_mm\n";
  for (const analyze::SurfacePrediction& one : surfaces) {
    for (const analyze::Cause& cause : one.causes)
      add_csv_row(causes, {csv_quoted(one.surface), csv_quoted(cause.name), csv_number(cause.rms_mm),
                           csv_number(cause.without_mm)});
    for (const analyze::Sweep& sweep : one.sweeps)
      for (std::size_t i = 0; i < sweep.values.size(); ++i)
        add_csv_row(sweeps, {csv_quoted(one.surface), csv_quoted(sweep.name), csv_quoted(sweep.unit),
                             csv_number(sweep.values[i]), csv_number(sweep.rms_mm[i])});
  }
  return {{"points.csv", points_table(surfaces)}, {"causes.csv", causes}, {"sweeps.csv", sweeps}};
}

}  // namespace procam::report
