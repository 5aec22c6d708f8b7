#include <algorithm>
#include <cmath>

#include "html.hpp"
#include "pictures.hpp"

namespace procam::report {
namespace {

constexpr double kShapeWidth = 720, kShapeMargin = 46;

std::string millimetres(double metres) {
  return fixed(1e3 * metres, 2) + " mm";
}

}  // namespace

std::string board_shape(const calibrate::CalibrationResult& result, const Board& board) {
  const calibrate::EstimatedShape& shape = result.shape;
  const Points3 printed = points_in_board(board);
  if (result.diagnostics.find("board_shape") == nullptr || printed.empty() ||
      shape.offsets.size() != printed.size())
    return "";
  Vec2 low = printed.front().head<2>(), high = low;
  for (const Vec3& p : printed) low = low.cwiseMin(p.head<2>()), high = high.cwiseMax(p.head<2>());
  const double to_svg = (kShapeWidth - 2 * kShapeMargin) / std::max(1e-9, (high - low).x());
  const auto place = [&](const Vec3& p) {
    return Vec2(Vec2::Constant(kShapeMargin) + to_svg * (p.head<2>() - low));
  };
  const double height = 2 * kShapeMargin + to_svg * (high - low).y();

  double max_off = 0, max_along = 0;
  for (const Vec3& offset : shape.offsets) {
    max_off = std::max(max_off, std::abs(offset.z()));
    max_along = std::max(max_along, offset.head<2>().norm());
  }
  // The largest disc and the longest line reach almost to the neighbouring point.
  double gap = 1e300;
  for (std::size_t i = 1; i < printed.size(); ++i)
    gap = std::min(gap, (place(printed[i]) - place(printed[i - 1])).norm());
  const double disc = 0.42 * gap, along = round_step(0.6 * gap / (to_svg * std::max(max_along, 1e-9)));

  std::string content;
  for (std::size_t i = 0; i < printed.size(); ++i) {
    const Vec3& offset = shape.offsets[i];
    const double radius = disc * std::sqrt(std::abs(offset.z()) / std::max(max_off, 1e-12));
    const char* colour = offset.z() > 0 ? "hsl(214,65%,55%)" : "hsl(22,80%,55%)";
    content += "<g>" + element("title", "",
                               "point " + std::to_string(i) + ": " + millimetres(offset.x()) + ", " +
                                   millimetres(offset.y()) + " along, " + millimetres(offset.z()) +
                                   " into the sheet");
    content += circle("style=\"fill:" + std::string(colour) + ";fill-opacity:.45\"", place(printed[i]),
                      std::max(radius, 0.5));
    if (shape.free_points) {
      Marks line;
      line.line(place(printed[i]), place(printed[i] + along * Vec3(offset.x(), offset.y(), 0)));
      content += line.path("class=\"bar\"");
    }
    content += "</g>\n";
  }
  const std::string stretch = std::abs(shape.stretch_x_over_y) > 5e-4
                                  ? " The print is " + fixed(100 * std::abs(shape.stretch_x_over_y), 2) +
                                        " % longer along its " + (shape.stretch_x_over_y > 0 ? "x" : "y") +
                                        " than stated."
                                  : "";
  const std::string along_it =
      shape.free_points ? element("b", "", "Along it") + ": lines, " + shortest(along) + "× magnified; rms " +
                              millimetres(shape.in_plane_rms) + "."
      : shape.largest_of_light > 0 ? "Projected points on the same bent sheet lie up to " +
                                         millimetres(shape.largest_of_light) + " off that plane."
                                   : "Bent like a sheet: three curvatures.";
  return figure(svg(box(Vec2::Zero(), Vec2(kShapeWidth, height)), "Shape of the board", content),
                element("b", "", "Off its plane") + ": discs, by area, the largest " + millimetres(max_off) +
                    " (blue into the sheet, orange towards the reader); rms " +
                    millimetres(shape.out_of_plane_rms) + ". " + along_it + stretch +
                    " Held-out views are predicted to " + pixels(shape.holdout_free_px) +
                    " px with this shape, to " + pixels(shape.holdout_flat_px) + " px as printed.",
                "style=\"max-width:560px\"");
}

}  // namespace procam::report
