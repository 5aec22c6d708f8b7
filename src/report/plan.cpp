#include <algorithm>
#include <cmath>

#include "html.hpp"
#include "procam/core/geometry/convex.hpp"
#include "procam/report/plan.hpp"

namespace procam::report {

using analyze::figures_of;
using analyze::light_on_wall;
using analyze::LightOnWall;
using analyze::PlanFigure;
using analyze::ProjectionPlan;
namespace {

// The page, SVG units: the wall above the two views of the room, the figures to their right.
constexpr double kPageWidth = 1180, kPageHeight = 840;
const Vec2 kWallCorner(62, 78), kWallSize(690, 440);
const Vec2 kAboveCorner(24, 606), kRightCorner(402, 606), kViewSize(360, 214);
const Vec2 kFiguresCorner(792, 78);

/// Paper is white: no dark form, and greys stay apart when printed without colour.
const char kPlanStyle[] = R"css(
text { font-family: system-ui, "Segoe UI", "Helvetica Neue", "DejaVu Sans", sans-serif; font-size: 12px; fill: #1d2327; }
.title { font-size: 20px; font-weight: 600; } .head { font-size: 14px; font-weight: 600; }
.soft { fill: #5d6870; } .tick { fill: #5d6870; font-size: 11px; }
.warning { fill: #9a3a00; } .accent { fill: #0b6e99; } .wanted { fill: #b0261a; }
.halo { paint-order: stroke; stroke: #fff; stroke-width: 3.5px; stroke-linejoin: round; }
path, rect { fill: none; }
.axis { stroke: #d9dde0; } .frame { stroke: #9aa4aa; } .edge { stroke: #1d2327; stroke-width: 1.6px; }
.undistorted { stroke: #0b6e99; stroke-width: 2.2px; stroke-dasharray: 8 4; }
.target { stroke: #b0261a; stroke-width: 2.2px; } .middle { stroke: #1d2327; stroke-width: 1.4px; }
.cone { fill: #0b6e99; fill-opacity: .14; stroke: #0b6e99; } .optical { stroke: #5d6870; stroke-dasharray: 6 4; }
.wall { stroke: #1d2327; stroke-width: 3px; } .lit { stroke: #0b6e99; stroke-width: 5px; }
.body { fill: #1d2327; } .measure { stroke: #5d6870; }
)css";

/// Fine to coarse, light to dark.
const std::vector<std::string> kShades = {"#e8f1f6", "#cfe2ec", "#b0d0df", "#8bbacf", "#62a0bb", "#3d84a4"};

/// A plane in metres drawn into a box, both axes at one scale.
struct Sheet2d {
  Vec2 middle_in_metres, middle_in_box;
  double scale;  ///< SVG units a metre

  Vec2 operator()(const Vec2& metres) const { return middle_in_box + scale * (metres - middle_in_metres); }
};

Sheet2d fitted(const Points2& points, const Vec2& corner, const Vec2& size) {
  Vec2 low = points.front(), high = points.front();
  for (const Vec2& p : points) low = low.cwiseMin(p), high = high.cwiseMax(p);
  return {0.5 * (low + high), corner + 0.5 * size, size.cwiseQuotient(high - low).minCoeff()};
}

std::string outline(const Points2& points, const std::string& attributes, const Sheet2d& place) {
  std::string d;
  for (const Vec2& p : points) d += (d.empty() ? "M" : "L") + position(place(p));
  return "<path " + attributes + " d=\"" + d + "Z\"/>\n";
}

std::string metre_words(double metres) {
  return fixed(metres, 2) + " m";
}
std::string size_words(const Vec2& size) {
  return fixed(size.x(), 2) + " × " + fixed(size.y(), 2) + " m";
}

/// The lit area as cells of the picture, shaded by the coarsest direction of their pixels.
class PixelShades {
 public:
  explicit PixelShades(const ProjectionPlan& plan) : plan_(plan) {
    for (int j = 0; j < kRows; ++j)
      for (int i = 0; i < kColumns; ++i) coarsest_.push_back(light(i + 0.5, j + 0.5).mm_per_pixel_max);
    low_ = *std::min_element(coarsest_.begin(), coarsest_.end());
    high_ = *std::max_element(coarsest_.begin(), coarsest_.end());
    // All but even light needs no shades: their bounds would read the same.
    steps_ = high_ < 1.01 * low_ ? 1 : int(kShades.size());
  }

  std::string cells(const Sheet2d& place) const {
    std::vector<std::string> paths(kShades.size());
    for (int j = 0; j < kRows; ++j) {
      // Neighbours of one shade make one piece: a row's edges land as straight lines.
      int begin = 0;
      for (int i = 1; i <= kColumns; ++i) {
        if (i < kColumns && step_at(i, j) == step_at(begin, j)) continue;
        std::string& d = paths[std::size_t(step_at(begin, j))];
        d += "M" + landed(place, begin, j) + "L" + landed(place, i, j) + "L" + landed(place, i, j + 1) + "L" +
             landed(place, begin, j + 1) + "Z";
        begin = i;
      }
    }
    std::string content;
    for (std::size_t s = 0; s < paths.size(); ++s)
      if (!paths[s].empty())  // The line in the fill's colour closes the seams between pieces.
        content += "<path style=\"fill:" + kShades[s] + ";stroke:" + kShades[s] + ";stroke-width:.7\" d=\"" +
                   paths[s] + "\"/>\n";
    return content;
  }

  std::string legend(const Vec2& corner) const {
    std::string content = label(corner + Vec2(0, 11), "class=\"tick\"", "mm per pixel, coarsest direction:");
    Vec2 at_step = corner + Vec2(196, 0);
    for (int s = 0; s < steps_; ++s) {
      content +=
          rectangle("class=\"frame\" style=\"fill:" + kShades[std::size_t(s)] + "\"", at_step, Vec2(14, 14));
      const double width = (high_ - low_) / steps_;
      content += label(at_step + Vec2(18, 11), "class=\"tick\"",
                       steps_ == 1
                           ? significant(high_, 3)
                           : significant(low_ + s * width, 3) + "–" + significant(low_ + (s + 1) * width, 3));
      at_step.x() += 86;
    }
    return content + "\n";
  }

 private:
  static constexpr int kColumns = 120, kRows = 75;

  /// The picture has landed (see plan_projection): so does every position in it.
  LightOnWall light(double column, double row) const {
    const ImageSize size = plan_.projector.size();
    const Vec2 pixel(column / kColumns * size.width - 0.5, row / kRows * size.height - 0.5);
    return light_on_wall(plan_.projector, plan_.projector_from_wall, pixel).value();
  }
  std::string landed(const Sheet2d& place, int column, int row) const {
    return position(place(light(column, row).on_wall));
  }
  int step_at(int column, int row) const {
    if (steps_ == 1) return 0;
    const double mm = coarsest_[std::size_t(row * kColumns + column)];
    return std::clamp(int(std::floor((mm - low_) / (high_ - low_) * steps_)), 0, steps_ - 1);
  }

  const ProjectionPlan& plan_;
  std::vector<double> coarsest_;  ///< mm per pixel at each cell's middle, row by row
  double low_ = 0, high_ = 0;
  int steps_ = 1;
};

/// The parts of the lit area whose depth lies outside the depth of field.
std::string blurred_parts(const ProjectionPlan& plan, const Sheet2d& place) {
  if (!plan.depth_of_field) return "";
  const Mat3 rotation = plan.projector_from_wall.rotation_matrix();
  const Vec2 deeper(rotation(2, 0), rotation(2, 1));  // depth = deeper . point + depth of the wall's origin
  const double origin = plan.projector_from_wall.translation.z();
  std::vector<HalfPlane> outside = {{deeper, plan.depth_of_field->near - origin}};
  if (std::isfinite(plan.depth_of_field->far))
    outside.push_back({-deeper, origin - plan.depth_of_field->far});
  std::string content;
  for (const HalfPlane& half_plane : outside)
    if (const Points2 part = clipped(plan.corners, half_plane); part.size() >= 3)
      content += outline(part, "style=\"fill:url(#blurred)\"", place);
  return content;
}

std::string metre_grid(const Sheet2d& place, const Vec2& corner, const Vec2& size) {
  const Vec2 low = place.middle_in_metres + (corner - place.middle_in_box) / place.scale;
  const Vec2 high = low + size / place.scale;
  const double step = round_step(0.17 * (high - low).maxCoeff());
  Marks lines;
  std::string words;
  for (int i = int(std::ceil(low.x() / step)); i * step <= high.x(); ++i) {
    const double x = place(Vec2(i * step, 0)).x();
    lines.line(Vec2(x, corner.y()), Vec2(x, corner.y() + size.y()));
    words += label(Vec2(x, corner.y() + size.y() + 14), "class=\"tick\" text-anchor=\"middle\"",
                   shortest(i * step));
  }
  for (int i = int(std::ceil(low.y() / step)); i * step <= high.y(); ++i) {
    const double y = place(Vec2(0, i * step)).y();
    lines.line(Vec2(corner.x(), y), Vec2(corner.x() + size.x(), y));
    words += label(Vec2(corner.x() - 6, y + 4), "class=\"tick\" text-anchor=\"end\"", shortest(i * step));
  }
  return lines.path("class=\"axis\"") + words + "\n";
}

/// The length of each side of the lit area, beside it.
std::string side_lengths(const ProjectionPlan& plan, const Sheet2d& place) {
  const std::vector<HalfPlane> sides = half_planes(plan.corners);
  std::string content;
  for (std::size_t i = 0; i < 4; ++i) {
    const Vec2 &from = plan.corners[i], &to = plan.corners[(i + 1) % 4];
    const Vec2 at = place(0.5 * (from + to)) + 13 * sides[i].normal + Vec2(0, 4);
    const double across = sides[i].normal.x();
    const std::string anchor = across > 0.5 ? "start" : across < -0.5 ? "end" : "middle";
    content += label(at, "class=\"halo\" text-anchor=\"" + anchor + "\"", metre_words((to - from).norm()));
  }
  return content + "\n";
}

/// A line of the picture with its meaning.
std::string rectangle_key(const Vec2& at, const std::string& line_class, const std::string& words_class,
                          const std::string& words) {
  Marks line;
  line.line(at + Vec2(0, -4), at + Vec2(36, -4));
  return line.path("class=\"" + line_class + "\"") +
         label(at + Vec2(44, 0), "class=\"" + words_class + "\"", words) + "\n";
}

std::string wall_view(const ProjectionPlan& plan) {
  Points2 shown = plan.corners;
  if (plan.target)
    for (const Vec2& corner : plan.target->rectangle.corners()) shown.push_back(corner);
  // Room for the sides' lengths.
  const Vec2 rim(70, 34);
  const Sheet2d place = fitted(shown, kWallCorner + rim, kWallSize - 2 * rim);
  const PixelShades shades(plan);

  std::string content =
      label(kWallCorner + Vec2(0, -12), "class=\"head\"", "The wall, seen straight on") + "\n";
  content += metre_grid(place, kWallCorner, kWallSize) + rectangle("class=\"frame\"", kWallCorner, kWallSize);
  content += shades.cells(place) + blurred_parts(plan, place);
  content += outline(plan.corners, "class=\"edge\"", place);
  content += outline(plan.undistorted.corners(), "class=\"undistorted\"", place);
  if (plan.target) content += outline(plan.target->rectangle.corners(), "class=\"target\"", place);
  Marks middle;
  middle.cross(place(plan.middle), 5);
  content += middle.path("class=\"middle\"", "the picture's middle");
  content += side_lengths(plan, place);
  content += rectangle_key(kWallCorner + Vec2(228, -12), "undistorted", "accent",
                           "largest undistorted " + size_words(plan.undistorted.size));
  if (plan.target)
    content += rectangle_key(kWallCorner + Vec2(490, -12), "target", "wanted",
                             "target " + size_words(plan.target->rectangle.size));
  const double below = kWallCorner.y() + kWallSize.y();
  content += label(Vec2(kWallCorner.x() + kWallSize.x(), below + 28), "class=\"tick\" text-anchor=\"end\"",
                   "metres right and down from the wall's origin; cross: the picture's middle" +
                       std::string(plan.depth_of_field && plan.depth_of_field->blur_max_px > 1
                                       ? "; hatched: blurred over more than a pixel"
                                       : ""));
  return content + "\n" + shades.legend(Vec2(kWallCorner.x(), below + 36));
}

/// The room along one of the wall's axes: the wall as a line, the lens, its light. `flat` drops that axis.
template <typename Flat>
std::string room_view(const ProjectionPlan& plan, const std::string& title, const Vec2& corner,
                      const Flat& flat) {
  const auto on_wall = [&](const Vec2& p) { return flat(Vec3(p.x(), p.y(), 0)); };
  const Pose wall_from_projector = plan.projector_from_wall.inverse();
  const Vec3 lens = wall_from_projector.translation;
  const Vec2 along_wall = (on_wall(Vec2(1, 1)) - on_wall(Vec2(0, 0))).normalized();
  const auto span = [&](const Points2& points) {
    std::pair<Vec2, Vec2> ends(on_wall(points.front()), on_wall(points.front()));
    for (const Vec2& p : points) {
      const Vec2 at = on_wall(p);
      if (at.dot(along_wall) < ends.first.dot(along_wall)) ends.first = at;
      if (at.dot(along_wall) > ends.second.dot(along_wall)) ends.second = at;
    }
    return ends;
  };
  const auto lit = span(plan.corners);
  const Vec2 at_lens = flat(lens), foot = on_wall(lens.head<2>());
  Points2 shown = {lit.first, lit.second, at_lens, foot};
  std::pair<Vec2, Vec2> target(Vec2::Zero(), Vec2::Zero());
  if (plan.target) {
    target = span(plan.target->rectangle.corners());
    shown.insert(shown.end(), {target.first, target.second});
  }
  const Vec2 rim(46, 28);
  const Sheet2d place = fitted(shown, corner + rim, kViewSize - 2 * rim);
  const double body = 11;  // SVG units: the projector's size is not on its data sheet's first page

  std::string content = label(corner + Vec2(0, -10), "class=\"head\"", title) + "\n";
  content += rectangle("class=\"frame\"", corner, kViewSize);
  content += outline({at_lens, lit.first, lit.second}, "class=\"cone\"", place);
  Marks axis, wall, lit_wall, target_wall, measure;
  const Vec2 forward = flat(wall_from_projector.rotate(Vec3::UnitZ())) - flat(Vec3::Zero());
  axis.line(place(at_lens), place(at_lens + 0.5 * std::abs(lens.z()) * forward));
  std::pair<Vec2, Vec2> ends = span(plan.corners);
  for (const Vec2& p : shown) {
    if (p == at_lens) continue;
    if (p.dot(along_wall) < ends.first.dot(along_wall)) ends.first = p;
    if (p.dot(along_wall) > ends.second.dot(along_wall)) ends.second = p;
  }
  wall.line(place(ends.first) - 12 * along_wall, place(ends.second) + 12 * along_wall);
  lit_wall.line(place(lit.first), place(lit.second));
  measure.line(place(at_lens), place(foot));
  content += axis.path("class=\"optical\"", "the optical axis") + measure.path("class=\"measure\"") +
             wall.path("class=\"wall\"") + lit_wall.path("class=\"lit\"", "lit");
  if (plan.target) {
    // Before the wall, not over the lit part.
    const Vec2 off = 7 * (place(at_lens) - place(foot)).normalized();
    target_wall.line(place(target.first) + off, place(target.second) + off);
    content += target_wall.path("class=\"target\"", "target");
  }
  // The lens is the front of the body.
  Points2 box_corners;
  const Vec2 back = forward.norm() > 0.05 ? Vec2(-forward.normalized()) : Vec2(0, 1),
             side(-back.y(), back.x());
  for (const Vec2& c : {Vec2(0, -1), Vec2(0, 1), Vec2(1.6, 1), Vec2(1.6, -1)})
    box_corners.push_back(at_lens + body / place.scale * (c.x() * back + c.y() * 0.6 * side));
  content += outline(box_corners, "class=\"body\"", place);
  content += label(place(0.5 * (at_lens + foot)) + Vec2(6, -5), "class=\"halo\"", metre_words(-lens.z()));
  return content + "\n";
}

/// Greedy, between words; a number stays with what follows it, its unit.
std::vector<std::string> wrapped(const std::string& words, std::size_t width) {
  std::vector<std::string> lines(1);
  for (std::size_t begin = 0; begin < words.size();) {
    std::size_t end = std::min(words.find(' ', begin), words.size());
    while (end < words.size() && words[end - 1] >= '0' && words[end - 1] <= '9')
      end = std::min(words.find(' ', end + 1), words.size());
    if (!lines.back().empty() && lines.back().size() + 1 + end - begin > width) lines.emplace_back();
    lines.back() += (lines.back().empty() ? "" : " ") + words.substr(begin, end - begin);
    begin = end + 1;
  }
  return lines;
}

std::string figures(const ProjectionPlan& plan) {
  std::string content = label(kFiguresCorner + Vec2(0, -12), "class=\"head\"", "In figures") + "\n";
  Vec2 at = kFiguresCorner + Vec2(0, 8);
  for (const PlanFigure& figure : figures_of(plan)) {
    content += label(at, "class=\"soft\"", figure.name);
    for (const std::string& line : wrapped(figure.value, 38)) {
      content += label(at + Vec2(124, 0), "", line);
      at.y() += 16;
    }
    at.y() += 5;
    content += "\n";
  }
  for (const Diagnostic& item : plan.diagnostics.items) {
    at.y() += 8;
    const bool warning = item.severity != Severity::kNote;
    for (const std::string& line : wrapped((warning ? "Warning: " : "Note: ") + item.message, 58)) {
      content += label(at, warning ? "class=\"warning\"" : "class=\"soft\"", line);
      at.y() += 15;
    }
    content += "\n";
  }
  return content;
}

}  // namespace

std::string plan_picture(const ProjectionPlan& plan) {
  require(plan.corners.size() == 4, "plan_picture: a plan without corners");
  const Projector& projector = plan.projector;
  const std::string sheet =
      std::to_string(projector.size().width) + " × " + std::to_string(projector.size().height) +
      " pixels, throw ratio " + shortest(projector.throw_ratio()) + ", lens shift " +
      shortest(projector.lens_shift().x()) + ", " + shortest(projector.lens_shift().y());
  const std::string hatching =
      "<defs><pattern id=\"blurred\" width=\"7\" height=\"7\" patternUnits=\"userSpaceOnUse\" "
      "patternTransform=\"rotate(45)\"><path d=\"M0 0V7\" style=\"stroke:#1d2327;stroke-opacity:.45\"/>"
      "</pattern></defs>\n";
  const std::string content =
      element("style", "", kPlanStyle) + "\n" + hatching +
      rectangle("style=\"fill:#fff\"", Vec2(0, 0), Vec2(kPageWidth, kPageHeight)) +
      label(Vec2(24, 34), "class=\"title\"", "Projection plan") +
      label(Vec2(212, 34), "class=\"soft\"", sheet) + "\n" + wall_view(plan) +
      room_view(plan, "From above", kAboveCorner, [](const Vec3& p) { return Vec2(p.x(), -p.z()); }) +
      room_view(plan, "From the right", kRightCorner, [](const Vec3& p) { return Vec2(p.z(), p.y()); }) +
      figures(plan);
  return element("svg",
                 "xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"" +
                     box(Vec2(0, 0), Vec2(kPageWidth, kPageHeight)) +
                     "\" role=\"img\" aria-label=\"Projection plan: the wall, the room and the figures\"",
                 "\n" + content) +
         "\n";
}

}  // namespace procam::report
