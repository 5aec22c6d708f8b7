#include "pictures.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "html.hpp"

namespace procam::report {

using analyze::NextView;
namespace {

using calibrate::CalibrationResult;
using calibrate::Residual;

const std::string kTimes = "×";

/// A point that the lens cannot see has no residual (see CalibrationResult): it can be placed, not measured.
bool measured(const Residual& r) {
  return r.residual.allFinite() && (r.used || !r.residual.isZero());
}

std::string stroke_of(int view) {
  return "class=\"dots\" stroke=\"" + view_color(view) + "\"";
}

const Camera& lens_of(const CalibrationResult& result, int device) {
  const Device& d = result.devices[std::size_t(device)];
  return d.kind == DeviceKind::kCamera ? result.rig.camera(d.name).camera
                                       : result.rig.projector(d.name).projector.inverse_camera;
}

Vec2 extent(ImageSize size) {
  return Vec2(size.width, size.height);
}

/// What the scatter is about: spread of one coordinate, and how far the picture must reach.
struct Spread {
  double sigma = 0;  ///< of one coordinate, over the used residuals
  double reach = 1;  ///< half the picture's width, pixels of the device
  std::array<int, 3> within{};
  int used = 0, left_out = 0;
};

Spread spread_of(const CalibrationResult& result, int device) {
  Spread spread;
  double sum = 0, largest = 0;
  for (const Residual& r : result.residuals) {
    if (r.device != device) continue;
    if (!r.used) ++spread.left_out;
    if (!r.used || !measured(r)) continue;
    ++spread.used;
    sum += r.residual.squaredNorm();
    largest = std::max(largest, r.residual.cwiseAbs().maxCoeff());
  }
  if (spread.used > 0) spread.sigma = std::sqrt(sum / (2.0 * spread.used));
  for (const Residual& r : result.residuals)
    if (r.device == device && r.used && measured(r))
      for (std::size_t k = 0; k < 3; ++k)
        if (r.residual.norm() <= double(k + 1) * spread.sigma) ++spread.within[k];
  const double reach = std::max(3.6 * spread.sigma, 1.1 * largest);
  if (reach > 0) spread.reach = reach;
  return spread;
}

std::string share(int part, int whole) {
  return whole > 0 ? fixed(100.0 * part / whole, 0) + " %" : "-";
}

}  // namespace

std::string view_color(int view) {
  // Steps of the golden angle keep the hues of any number of views apart; two rings of lightness help.
  const int hue = int(std::lround(std::fmod(210.0 + view * 137.508, 360.0)));
  return "hsl(" + std::to_string(hue) + ",60%," + (view % 2 ? "44%" : "54%") + ")";
}

std::string residual_scatter(const CalibrationResult& result, int device) {
  const Spread spread = spread_of(result, device);
  const double half = 200, to_svg = half / spread.reach;
  const Vec2 centre(256, 226);
  const auto place = [&](const Vec2& residual) {
    const double outside = std::max(1.0, residual.cwiseAbs().maxCoeff() / spread.reach);
    return Vec2(centre + to_svg / outside * residual);
  };

  std::string content = rectangle("class=\"frame\"", centre - Vec2(half, half), Vec2(2 * half, 2 * half));
  Marks axes;
  axes.line(centre - Vec2(half, 0), centre + Vec2(half, 0));
  axes.line(centre - Vec2(0, half), centre + Vec2(0, half));
  content += axes.path("class=\"axis\"");
  const double step = round_step(spread.reach / 1.5);
  const int steps = int(spread.reach / step);
  for (int i = -steps; i <= steps; ++i) {
    const double at = i * step * to_svg;
    content +=
        label(centre + Vec2(at, half + 15), "class=\"tick\" text-anchor=\"middle\"", shortest(i * step));
    content +=
        label(centre + Vec2(-half - 6, at + 4), "class=\"tick\" text-anchor=\"end\"", shortest(i * step));
  }
  content += label(centre + Vec2(half, half + 30), "class=\"tick\" text-anchor=\"end\"", "x, px (right)");
  content += label(centre + Vec2(-half - 6, -half - 6), "class=\"tick\"", "y, px (down)") + "\n";

  for (std::size_t v = 0; v < result.views.size(); ++v) {
    Marks dots;
    for (const Residual& r : result.residuals)
      if (r.device == device && r.view == int(v) && r.used && measured(r)) dots.dot(place(r.residual));
    content += dots.path(stroke_of(int(v)), result.views[v].name);
  }
  for (const Residual& r : result.residuals) {
    if (r.device != device || r.used || !measured(r)) continue;
    Marks cross;
    cross.cross(place(r.residual), 4);
    content += cross.path("class=\"out\"", result.views[std::size_t(r.view)].name + ", point " +
                                               std::to_string(r.point) + ": " + r.reason);
  }
  for (int k = 1; spread.sigma > 0 && k <= 3; ++k) {
    const double radius = k * spread.sigma * to_svg;
    content += circle("class=\"ring\"", centre, radius);
    content += label(centre + Vec2(0, -radius - 3), "class=\"tick halo\" text-anchor=\"middle\"",
                     std::to_string(k) + " σ");
  }

  const std::string& name = result.devices[std::size_t(device)].name;
  std::string caption = element("b", "", escaped(name)) + ": " + std::to_string(spread.used) +
                        " residuals (projected − observed), σ " + significant(spread.sigma, 3) +
                        " px in each axis. Inside 1, 2, 3 σ: " + share(spread.within[0], spread.used) + ", " +
                        share(spread.within[1], spread.used) + ", " + share(spread.within[2], spread.used) +
                        " (pure noise: 39, 86, 99 %).";
  if (spread.left_out > 0)
    caption += " " + std::to_string(spread.left_out) + " rejected: crosses, at the edge when further away.";
  return figure(svg("0 0 480 462", "Residuals of " + name, content), caption);
}

namespace {

constexpr int kCellColumns = 8, kCellRows = 6;

/// How many used observations each cell of the picture has, row by row.
std::vector<int> cell_counts(const CalibrationResult& result, int device, ImageSize size) {
  std::vector<int> counts(kCellColumns * kCellRows, 0);
  for (const Residual& r : result.residuals) {
    if (r.device != device || !r.used || !size.contains(r.pixel)) continue;
    const int column = int((r.pixel.x() + 0.5) / size.width * kCellColumns),
              row = int((r.pixel.y() + 0.5) / size.height * kCellRows);
    ++counts[std::size_t(row * kCellColumns + column)];
  }
  return counts;
}

/// Observations of views that took no part, which leave no residual behind.
Marks unused_observations(const CalibrationResult& result, const Correspondences& data,
                          const std::string& device, double arm) {
  Marks marks;
  for (std::size_t d = 0; d < data.devices.size(); ++d) {
    if (data.devices[d].name != device) continue;
    for (std::size_t v = 0; v < data.views.size(); ++v) {
      if (result.views[v].used || d >= data.views[v].observations.size()) continue;
      for (const Observation& o : data.views[v].observations[d])
        if (o.pixel.allFinite()) marks.cross(o.pixel, arm);
    }
  }
  return marks;
}

/// The cells of a picture, of this first corner and size, in which nothing was observed.
std::string empty_cells(const std::vector<int>& counts, const Vec2& first, const Vec2& size) {
  const Vec2 cell(size.x() / kCellColumns, size.y() / kCellRows);
  std::string content;
  for (int row = 0; row < kCellRows; ++row)
    for (int column = 0; column < kCellColumns; ++column)
      if (counts[std::size_t(row * kCellColumns + column)] == 0)
        content += rectangle("class=\"empty\"", first + Vec2(column * cell.x(), row * cell.y()), cell);
  return content;
}

/// Dots in the colours of the views, and crosses for outliers.
std::string observations_of_views(const CalibrationResult& result, int device, double em) {
  std::string content;
  for (std::size_t v = 0; v < result.views.size(); ++v) {
    Marks dots;
    for (const Residual& r : result.residuals)
      if (r.device == device && r.view == int(v) && r.used && r.pixel.allFinite()) dots.dot(r.pixel);
    content += dots.path(stroke_of(int(v)), result.views[v].name);
  }
  Marks outliers;
  for (const Residual& r : result.residuals)
    if (r.device == device && !r.used && r.pixel.allFinite()) outliers.cross(r.pixel, 0.35 * em);
  return content + outliers.path("class=\"out\"", "rejected");
}

/// The d of a path through a board's outermost points as a device would see them; empty where it cannot.
std::string outline_of_points(const CalibrationResult& result, const Board& board, int device,
                              const Pose& rig_from_board) {
  const std::string& name = result.devices[std::size_t(device)].name;
  const bool camera = result.devices[std::size_t(device)].kind == DeviceKind::kCamera;
  const Pose& rig_from_device =
      camera ? result.rig.camera(name).rig_from_camera : result.rig.projector(name).rig_from_projector;
  const Points3 points = points_in_board(board);
  Vec3 low = points.front(), high = points.front();
  for (const Vec3& p : points) low = low.cwiseMin(p), high = high.cwiseMax(p);
  std::string d;
  for (const Vec3& corner : {low, Vec3(high.x(), low.y(), 0), high, Vec3(low.x(), high.y(), 0)}) {
    const auto pixel = lens_of(result, device).project(rig_from_device.inverse() * (rig_from_board * corner));
    if (!pixel) return "";
    d += (d.empty() ? "M" : "L") + position(*pixel);
  }
  return d + "Z";
}

}  // namespace

std::string coverage(const CalibrationResult& result, const Correspondences& data, int device,
                     const std::optional<NextView>& next) {
  const Device& about = result.devices[std::size_t(device)];
  const Intrinsics& k = lens_of(result, device).intrinsics;
  const Vec2 size = extent(about.size), first(-0.5, -0.5);
  const Vec2 principal(k.cx, k.cy);
  const bool placed = principal.allFinite();
  // An axis that leaves the picture is followed one picture far; its numbers stand beside it anyway.
  const Vec2 shown =
      placed ? Vec2(principal.cwiseMax(first - size).cwiseMin(first + 2 * size)) : Vec2(first + 0.5 * size);
  const double em = size.x() / 36;
  const Vec2 low = first.cwiseMin(shown - Vec2(2 * em, 2 * em)) - Vec2(em, 2 * em),
             high = (first + size).cwiseMax(shown + Vec2(2 * em, 2 * em)) + Vec2(em, 2 * em);

  std::string content = rectangle("class=\"frame\"", first, size);
  const std::vector<int> counts = cell_counts(result, device, about.size);
  content += empty_cells(counts, first, size);
  const Marks unused = unused_observations(result, data, about.name, 0.2 * em);
  content += unused.path("class=\"unused\"", "view rejected");
  content += observations_of_views(result, device, em);

  const std::string board_next =
      next ? outline_of_points(result, data.board, device, next->rig_from_board) : "";
  if (!board_next.empty())
    content += element("path", "class=\"next\" d=\"" + board_next + "\"",
                       element("title", "", "where the board should come next"));

  const std::string font = "font-size=\"" + coordinate(em) + "\"";
  if (placed) {
    Marks mark;
    mark.line(shown - Vec2(em, 0), shown + Vec2(em, 0));
    mark.line(shown - Vec2(0, em), shown + Vec2(0, em));
    content += mark.path("class=\"principal\"") + circle("class=\"principal\"", shown, 0.6 * em);
    const bool leftwards = shown.x() > 0.6 * (low.x() + high.x());
    content += label(shown + Vec2(leftwards ? -1.3 * em : 1.3 * em, 0.35 * em),
                     "class=\"tick halo accent\" " + font + (leftwards ? " text-anchor=\"end\"" : ""),
                     "principal point (" + fixed(k.cx, 1) + ", " + fixed(k.cy, 1) + ")");
  }
  content += label(first - Vec2(0, 0.5 * em), "class=\"tick\" " + font, "(0, 0)");
  const Vec2 last = first + size;
  content += label(
      Vec2(last.x(), first.y() - 0.5 * em), "class=\"tick\" text-anchor=\"end\" " + font,
      std::to_string(about.size.width) + " " + kTimes + " " + std::to_string(about.size.height) + " px");
  const auto seen = std::count_if(counts.begin(), counts.end(), [](int n) { return n > 0; });
  std::string caption = element("b", "", escaped(about.name)) + ": observed in " +
                        share(int(seen), int(counts.size())) + " of the picture's " +
                        std::to_string(kCellColumns) + " " + kTimes + " " + std::to_string(kCellRows) +
                        " cells. In the tinted cells the lens is extrapolated: bring the board there.";
  if (!board_next.empty()) caption += " Dashed: the board's points in the view to add next.";
  if (!unused.d.empty()) caption += " Grey crosses: views that were rejected.";
  return figure(svg(box(low, high - low), "Coverage of " + about.name, content), caption);
}

namespace {

struct QuiverScale {
  double magnified = 1;
  double typical = 0;  ///< length of the drawn RMS residual, picture pixels
  double longest = 0;  ///< picture pixels; a longer line is cut short
  double bar_px = 0;   ///< residual that the scale bar shows; 0: none
};

/// The typical residual becomes a thirtieth of the picture's width, so that lines seldom cross.
QuiverScale quiver_scale(const CalibrationResult& result, int device) {
  const int width = result.devices[std::size_t(device)].size.width;
  const double rms = std::sqrt(2.0) * spread_of(result, device).sigma;
  QuiverScale scale;
  scale.longest = 0.15 * width;
  if (rms > 0) {
    scale.magnified = round_step(std::clamp(width / 30.0 / rms, 1.0, 1e4));
    scale.typical = rms * scale.magnified;
    scale.bar_px = round_step(0.15 * width / scale.magnified);
  }
  return scale;
}

/// The lines of one view; marks at their feet so that a residual of zero still shows its place.
std::string quiver_of(const CalibrationResult& result, int device, int view, const QuiverScale& scale,
                      double arm) {
  Marks lines, feet, cut, crosses;
  for (const Residual& r : result.residuals) {
    if (r.device != device || r.view != view || !r.pixel.allFinite()) continue;
    if (!r.used) crosses.cross(r.pixel, arm);
    if (!measured(r)) continue;
    if (r.used) feet.dot(r.pixel);
    const Vec2 line = scale.magnified * r.residual;
    const double length = line.norm();
    const bool too_long = length > scale.longest;
    Marks& drawn = r.used ? lines : cut;
    drawn.line(r.pixel, r.pixel + (too_long ? scale.longest / length : 1.0) * line);
  }
  const std::string color = "stroke=\"" + view_color(view) + "\"";
  const std::string& name = result.views[std::size_t(view)].name;
  return lines.path("class=\"quiver\" " + color, name) + feet.path("class=\"feet\" " + color) +
         cut.path("class=\"out thin\"", name) + crosses.path("class=\"out\"", name);
}

/// The part of the picture that one view fills, in the picture's own shape.
std::string box_around(const CalibrationResult& result, int device, int view, double margin) {
  const Vec2 size = extent(result.devices[std::size_t(device)].size);
  Vec2 low = size, high = -size;
  for (const Residual& r : result.residuals) {
    if (r.device != device || r.view != view || !r.pixel.allFinite()) continue;
    low = low.cwiseMin(r.pixel);
    high = high.cwiseMax(r.pixel);
  }
  const Vec2 centre = 0.5 * (low + high), half = 0.5 * (high - low) + Vec2(margin, margin);
  const double share = std::max(half.cwiseQuotient(size).maxCoeff(), 0.02);
  return box(centre - share * size, 2 * share * size);
}

}  // namespace

std::string residual_quivers(const CalibrationResult& result, int device) {
  const Device& about = result.devices[std::size_t(device)];
  const QuiverScale scale = quiver_scale(result, device);
  const Vec2 size = extent(about.size), first(-0.5, -0.5);
  const double em = size.x() / 84, arm = 0.006 * size.x();
  const std::string factor = fixed(scale.magnified, 0) + kTimes;

  std::string content = rectangle("class=\"frame\"", first, size);
  for (std::size_t v = 0; v < result.views.size(); ++v)
    content += quiver_of(result, device, int(v), scale, arm);
  if (scale.bar_px > 0) {
    const Vec2 at(first.x(), size.y() + 1.5 * em);
    const Vec2 end = at + Vec2(scale.bar_px * scale.magnified, 0);
    Marks bar;
    bar.line(at, end);
    content += bar.path("class=\"bar\"") +
               label(end + Vec2(0.6 * em, 0.35 * em), "class=\"tick\" font-size=\"" + coordinate(em) + "\"",
                     shortest(scale.bar_px) + " px of residual, magnified " + factor);
  }
  std::string out = figure(
      svg(box(first - Vec2(em, em), size + Vec2(2 * em, 4 * em)), "Residual vectors of " + about.name,
          content),
      element("b", "", escaped(about.name)) + ", all views, residuals " + factor +
          " magnified. Noise points every way; neighbours of all views that point the same way mean that "
          "the lens model falls short there. Red: rejected.",
      "class=\"wide\"");

  std::string tiles;
  for (std::size_t v = 0; v < result.views.size(); ++v) {
    const std::string lines = quiver_of(result, device, int(v), scale, 0.6 * arm);
    if (lines.empty()) continue;
    const std::string around = box_around(result, device, int(v), 1.5 * scale.typical);
    tiles += figure(svg(around, "Residual vectors of " + about.name + " in " + result.views[v].name,
                        rectangle("class=\"frame\"", first, size) + lines),
                    escaped(result.views[v].name) + " · " +
                        pixels(result.views[v].rms_px[std::size_t(device)]) + " px RMS");
  }
  return out + element("div", "class=\"tiles\"", "\n" + tiles) + "\n" +
         element(
             "p", "class=\"hint\"",
             "One cut-out of the picture a view, " + escaped(about.name) + ", residuals " + factor +
                 " against the pixels below them; the foot is the observed pixel. Lines of one view that all "
                 "point one way: the board moved between its frames.");
}

}  // namespace procam::report
