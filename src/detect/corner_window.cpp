#include "corner_window.hpp"

#include <algorithm>
#include <numeric>

namespace procam::detect {
namespace {

/// Half a window along a grid direction, pixels, and how much of a window the image must leave.
constexpr double kMinPixels = 2.5, kMinPart = 0.4;

/// Takes the pixels of a lattice that no line of pixels avoids: an edge along the rows or the columns has samples at
/// all distances. With (x, y) it takes (x + every, y) and (x - shift, y + 1).
struct Lattice {
  int every, shift;

  /// A shift of the golden section spreads the points evenly.
  explicit Lattice(int of) : every(of), shift(std::max(1, int(std::lround(0.618 * of)))) {
    while (std::gcd(shift, every) > 1) ++shift;
  }
  /// The first x from `from` on, in row y.
  int first(int from, int y) const {
    const int beyond = (from + shift * y) % every;
    return beyond == 0 ? from : from + every - beyond;
  }
};

/// Pixels of a row.
struct Span {
  int first, last;
  bool has(int x) const { return x >= first && x <= last; }
  bool covers(int from, int to) const { return from >= first && to <= last; }
};

/// The pixels where |gradient . (pixel - corner)| is `most` at most.
class Strip {
 public:
  Strip(const Vec2& gradient, const Vec2& corner, double most) : corner_(corner) {
    constexpr double kFlat = 1e-12;
    const double slope = std::max({std::abs(gradient.x()), most / kFar, kFlat});
    along_ = -gradient.y() / std::copysign(slope, gradient.x());
    half_ = most / slope;
  }
  Span in_row(int y) const {
    const double centre = corner_.x() + along_ * (y - corner_.y());
    return {int(std::ceil(std::clamp(centre - half_, -kFar, kFar))),
            int(std::floor(std::clamp(centre + half_, -kFar, kFar)))};
  }

 private:
  static constexpr double kFar = 1e9;
  Vec2 corner_;
  double along_, half_;
};

}  // namespace

Window::Window(const CornerNeighbourhood& of, double share, const ViewU8& image)
    : around(of),
      share_x(std::max(share, kMinPixels / of.e_x.norm())),
      share_y(std::max(share, kMinPixels / of.e_y.norm())),
      det(of.e_x.x() * of.e_y.y() - of.e_x.y() * of.e_y.x()) {
  const Vec2 half(std::abs(of.e_x.x()) * share_x + std::abs(of.e_y.x()) * share_y,
                  std::abs(of.e_x.y()) * share_x + std::abs(of.e_y.y()) * share_y);
  const Vec2 room = of.corner.cwiseMin(Vec2(image.width - 1, image.height - 1) - of.corner);
  const double part = std::min(1.0, (room.array() / half.array()).minCoeff());
  share_x *= part, share_y *= part;
  const double least = std::min(share_x * of.e_x.norm(), share_y * of.e_y.norm());
  usable =
      of.corner.allFinite() && std::abs(det) >= 1 && (part == 1 || (part >= kMinPart && least >= kMinPixels));
  if (!usable) return;
  x0 = int(std::ceil(of.corner.x() - part * half.x())), x1 = int(std::floor(of.corner.x() + part * half.x()));
  y0 = int(std::ceil(of.corner.y() - part * half.y())), y1 = int(std::floor(of.corner.y() + part * half.y()));
}

Samples Window::samples(const ViewU8& image, const Sampling& sampling) const {
  // (a, b): squares away along both grid directions. Across an edge a pixel is nearer than along the other direction:
  // the band is not narrower than stated.
  const Vec2 a_by(around.e_y.y() / det, -around.e_y.x() / det),
      b_by(-around.e_x.y() / det, around.e_x.x() / det);
  const auto with_a = [&](double most) { return Strip(a_by, around.corner, most); };
  const auto with_b = [&](double most) { return Strip(b_by, around.corner, most); };
  const Strip inside_a = with_a(share_x), inside_b = with_b(share_y);
  const Strip clear_a = with_a(around.clear), clear_b = with_b(around.clear);
  const Strip edge_a = with_a(sampling.band / around.e_x.norm()),
              edge_b = with_b(sampling.band / around.e_y.norm());
  Samples all(around.corner);
  const Lattice lattice(sampling.every);
  for (int y = y0; y <= y1; ++y) {
    const Span in_a = inside_a.in_row(y), in_b = inside_b.in_row(y);
    const int first = std::max({x0, in_a.first, in_b.first}), last = std::min({x1, in_a.last, in_b.last});
    if (first > last) continue;
    const Span seen[] = {clear_a.in_row(y), clear_b.in_row(y)};
    const std::uint8_t* const greys = image.row(y);
    const auto take_one = [&](int x) {
      if (seen[0].has(x) || seen[1].has(x)) all.add(x, y, greys[x]);
    };
    const auto take = [&](int from, int to) {
      if (seen[0].covers(from, to) || seen[1].covers(from, to))
        return all.add(from, y, greys + from, to - from + 1);
      for (int x = from; x <= to; ++x) take_one(x);
    };
    if (sampling.every == 1) {
      take(first, last);
      continue;
    }
    Span edges[] = {edge_a.in_row(y), edge_b.in_row(y)};
    if (edges[1].first < edges[0].first) std::swap(edges[0], edges[1]);
    // The edges' pixels, and between them those of the lattice.
    int x = first, on_lattice = lattice.first(first, y);
    const auto take_lattice = [&](int before) {
      for (; on_lattice < before; on_lattice += sampling.every) take_one(on_lattice);
    };
    for (const Span& edge : edges) {
      const int from = std::max(x, edge.first), to = std::min(last, edge.last);
      if (from > to) continue;
      take_lattice(from);
      take(from, to);
      x = to + 1;
      on_lattice = lattice.first(x, y);
    }
    take_lattice(last + 1);
  }
  all.fill_up();
  return all;
}

}  // namespace procam::detect
