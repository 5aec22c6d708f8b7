#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>

#include "html.hpp"
#include "pictures.hpp"

namespace procam::report {
namespace {

constexpr int kGridColumns = 12, kGridRows = 9;  // cells

/// Where the lens images what a lens without distortion images at `pixel`, minus that pixel.
std::optional<Vec2> displacement(const Camera& lens, const Vec2& pixel) {
  const Vec2 direction = lens.intrinsics.normalized_from_pixel(pixel);
  const auto distorted = lens.project(Vec3(direction.x(), direction.y(), 1));
  if (!distorted) return std::nullopt;
  return Vec2(*distorted - pixel);
}

struct DistortionGrid {
  const Camera& lens;
  Vec2 size, cell;
  double magnified = 1;
  double largest = 0;  ///< displacement at a node, pixels
  Vec2 largest_at = Vec2::Zero();

  Vec2 node(double column, double row) const { return Vec2(column * cell.x() - 0.5, row * cell.y() - 0.5); }
};

DistortionGrid grid_of(const Camera& lens) {
  const Vec2 size(lens.size.width, lens.size.height);
  DistortionGrid grid{lens, size, size.cwiseQuotient(Vec2(kGridColumns, kGridRows))};
  for (int row = 0; row <= kGridRows; ++row)
    for (int column = 0; column <= kGridColumns; ++column) {
      const Vec2 at = grid.node(column, row);
      const auto moved = displacement(lens, at);
      if (moved && moved->norm() > grid.largest) grid.largest = moved->norm(), grid.largest_at = at;
    }
  if (grid.largest > 0)
    grid.magnified = round_step(std::clamp(1.4 * grid.cell.minCoeff() / grid.largest, 1.0, 1e4));
  return grid;
}

/// The d of a path along a line of the grid, its displacement magnified.
std::string bent_line(const DistortionGrid& grid, const std::function<Vec2(double)>& along) {
  constexpr int kSamples = 36;
  std::string d;
  bool open = false;
  for (int i = 0; i <= kSamples; ++i) {
    const Vec2 at = along(double(i) / kSamples);
    const auto moved = displacement(grid.lens, at);
    if (moved) d += (open ? "L" : "M") + position(at + grid.magnified * *moved);
    open = moved.has_value();
  }
  return d;
}

void add_arrow(const Vec2& from, const Vec2& to, double head, Marks& marks) {
  marks.line(from, to);
  const double length = (to - from).norm();
  if (length < 1e-9) return;
  const Vec2 back = (from - to) / length * std::min(head, 0.6 * length), across(-back.y(), back.x());
  marks.line(to, to + back + 0.5 * across);
  marks.line(to, to + back - 0.5 * across);
}

std::string drawn(const DistortionGrid& grid) {
  Marks straight, arrows;
  std::string bent;
  for (int row = 0; row <= kGridRows; ++row) {
    straight.line(grid.node(0, row), grid.node(kGridColumns, row));
    bent += bent_line(grid, [&](double t) { return grid.node(t * kGridColumns, row); });
  }
  for (int column = 0; column <= kGridColumns; ++column) {
    straight.line(grid.node(column, 0), grid.node(column, kGridRows));
    bent += bent_line(grid, [&](double t) { return grid.node(column, t * kGridRows); });
    for (int row = 0; row <= kGridRows; ++row) {
      const Vec2 at = grid.node(column, row);
      if (const auto moved = displacement(grid.lens, at))
        add_arrow(at, at + grid.magnified * *moved, 0.012 * grid.size.x(), arrows);
    }
  }
  return straight.path("class=\"axis\"") + "<path class=\"lens\" d=\"" + bent + "\"/>\n" +
         arrows.path("class=\"arrow\"");
}

}  // namespace

std::string lens_distortion(const Camera& lens, const std::string& name) {
  constexpr double kVisiblePx = 0.01;
  const DistortionGrid grid = grid_of(lens);
  if (!(grid.largest >= kVisiblePx)) return "";
  const Vec2 margin = 1.5 * grid.cell, corner = -margin - Vec2(0.5, 0.5);
  return figure(svg(box(corner, grid.size + 2 * margin), "Lens distortion of " + name,
                    drawn(grid) + rectangle("class=\"frame\"", Vec2(-0.5, -0.5), grid.size)),
                element("b", "", escaped(name)) + ": displacement of a regular grid by the lens, " +
                    (grid.magnified > 1 ? "magnified " + fixed(grid.magnified, 0) + "×" : "to scale") +
                    ". Max " + significant(grid.largest, 2) + " px at pixel (" +
                    fixed(grid.largest_at.x(), 0) + ", " + fixed(grid.largest_at.y(), 0) +
                    "). Frame: the image.");
}

}  // namespace procam::report
