#include "procam/pattern/stripe_map.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "edge_scatter.hpp"

namespace procam::pattern {
namespace {

/// The edges of one projector axis on one camera line, and the pixels of that line.
class StripeLine {
 public:
  using Edges = std::vector<const StripeEdge*>;

  StripeLine(const DecodedMap& decoded, LightMap& light, StripeAxis axis, ScanAxis scan, int line)
      : decoded_(decoded),
        light_(light),
        codes_(axis == StripeAxis::kColumn ? decoded.columns : decoded.rows),
        channel_(axis == StripeAxis::kColumn ? 0 : 1),
        along_x_(scan == ScanAxis::kCameraX),
        line_(line),
        length_(along_x_ ? decoded.camera_size().width : decoded.camera_size().height) {}

  /// How far each edge lies off the line through its neighbours, over what the images' noise explains.
  void measure(const Edges& edges, const StripeMapOptions& options, internal::EdgeScatter& scatter) const {
    for (std::size_t i = 1; i + 1 < edges.size(); ++i) {
      const StripeEdge &a = *edges[i - 1], &b = *edges[i], &c = *edges[i + 1];
      if (!joins(a, b, options) || !joins(b, c, options)) continue;
      if (const std::optional<double> ratio = off_line(a, b, c)) scatter.add(b.camera_pixel, *ratio);
    }
  }

  /// Without the edges that alone are off the line that two neighbours on either side are on. Diffuse light of other surfaces
  /// moves the edges of wide stripes, and not those of fine ones.
  Edges without_moved(const Edges& edges, const StripeMapOptions& options, double inflation) const {
    constexpr double kMoved = 4, kOnLine = 3;
    Edges kept;
    for (std::size_t i = 0; i < edges.size(); ++i) {
      kept.push_back(edges[i]);
      if (i < 2 || i + 2 >= edges.size()) continue;
      const StripeEdge &a = *edges[i - 2], &b = *edges[i - 1], &c = *edges[i], &d = *edges[i + 1],
                       &e = *edges[i + 2];
      if (!joins(a, b, options) || !joins(b, c, options) || !joins(c, d, options) || !joins(d, e, options) ||
          !joins(b, d, options))
        continue;
      if (off_line(b, c, d).value_or(0) > kMoved * inflation &&
          off_line(a, b, d).value_or(kMoved) < kOnLine * inflation &&
          off_line(b, d, e).value_or(kMoved) < kOnLine * inflation)
        kept.pop_back();
    }
    return kept;
  }

  void fill(const Edges& edges, const StripeMapOptions& options, const internal::EdgeScatter& scatter) {
    for (std::size_t i = 0; i + 1 < edges.size(); ++i) {
      if (!joins(*edges[i], *edges[i + 1], options)) continue;
      const double inflation = scatter.factor(edges[i]->camera_pixel);
      const bool before = i > 0 && joins(*edges[i - 1], *edges[i], options);
      const bool after = i + 2 < edges.size() && joins(*edges[i + 1], *edges[i + 2], options);
      Line line = fit(edges, i - (before ? 1 : 0), i + (after ? 2 : 1), i, inflation);
      line.tolerance = std::max(double(decoded_.step), std::abs(edges[i + 1]->projector_coordinate -
                                                                edges[i]->projector_coordinate));
      draw(line, int(std::ceil(position(*edges[i]))), int(std::floor(position(*edges[i + 1]))), 1, true);
      // The surface's border: over one stripe past its last edge.
      const double reach = decoded_.step / std::abs(line.slope);
      if (!before) {
        const int first = int(std::ceil(position(*edges[i]))) - 1;
        draw(line, first, int(std::ceil(position(*edges[i]) - reach)), -1, false);
      }
      if (!after) {
        const int first = int(std::floor(position(*edges[i + 1]))) + 1;
        draw(line, first, int(std::floor(position(*edges[i + 1]) + reach)), 1, false);
      }
    }
  }

  /// Pixels that decoded, with neighbours that decoded to near stripes, but have no edges: the middle of their stripe. A pixel
  /// that spans g stripes may see any of them.
  void fill_by_codes(const StripeMapOptions& options) {
    for (int at = 1; at + 1 < length_; ++at) {
      const int x = along_x_ ? at : line_, y = along_x_ ? line_ : at;
      if (light_.sigma.at(x, y, channel_) > 0) continue;
      const int before = code(at - 1), here = code(at), after = code(at + 1);
      if (before == DecodedMap::kUndecoded || here == DecodedMap::kUndecoded ||
          after == DecodedMap::kUndecoded)
        continue;
      const int lower = here - before, upper = after - here;
      if (std::abs(lower) > options.max_stripes || std::abs(upper) > options.max_stripes || lower * upper < 0)
        continue;
      const double spanned = 0.5 * std::abs(after - before);
      set(at, decoded_.stripe_center(here), decoded_.step * std::sqrt((1 + spanned * spanned) / 12));
    }
  }

 private:
  /// How far b is off the line through a and c, over what the images' noise explains; nullopt without noise.
  std::optional<double> off_line(const StripeEdge& a, const StripeEdge& b, const StripeEdge& c) const {
    const double gap = position(c) - position(a), t = (position(b) - position(a)) / gap;
    const double slope = (c.projector_coordinate - a.projector_coordinate) / gap;
    const double off = b.projector_coordinate - (1 - t) * a.projector_coordinate - t * c.projector_coordinate;
    const double noise =
        std::abs(slope) * std::sqrt(b.sigma_px * b.sigma_px + (1 - t) * (1 - t) * a.sigma_px * a.sigma_px +
                                    t * t * c.sigma_px * c.sigma_px);
    if (!(noise > 0)) return std::nullopt;
    return std::abs(off) / noise;
  }

  double position(const StripeEdge& edge) const { return edge.camera_pixel[along_x_ ? 0 : 1]; }
  std::int16_t code(int at) const { return along_x_ ? codes_.at(at, line_) : codes_.at(line_, at); }

  bool joins(const StripeEdge& a, const StripeEdge& b, const StripeMapOptions& options) const {
    const double gap = position(b) - position(a);
    const double stripes = std::abs(b.projector_coordinate - a.projector_coordinate) / decoded_.step;
    return gap > 0.05 && gap <= options.max_gap_px && stripes > 0.5 && stripes < options.max_stripes + 0.5;
  }

  void set(int at, double coordinate, double sigma) {
    const int x = along_x_ ? at : line_, y = along_x_ ? line_ : at;
    light_.pixel.at(x, y, channel_) = float(coordinate);
    light_.sigma.at(x, y, channel_) = float(std::max(sigma, 1e-4));
  }

  /// c(p) = middle + slope (p - centre), with the variances of both, which are independent.
  struct Line {
    double centre = 0, middle = 0, slope = 0, middle_variance = 0, slope_variance = 0;
    /// Of a pixel's own stripe from the line: bits of stripes finer than its two edges are noise where their edges were not
    /// found.
    double tolerance = 0;
  };

  /// Is the pixel's own stripe the one of `coordinate`, as far as its bits can be read?
  bool agrees(int at, double coordinate, double tolerance) const {
    const std::int16_t stripe = code(at);
    return stripe != DecodedMap::kUndecoded &&
           std::abs(decoded_.stripe_center(stripe) - coordinate) <= tolerance;
  }

  /// The weighted line through the edges first .. last; through i and i + 1 alone where more do not lie on one line.
  Line fit(const Edges& edges, std::size_t first, std::size_t last, std::size_t i, double inflation) const {
    const double start = position(*edges[i]), end = position(*edges[i + 1]);
    const double rough =
        (edges[i + 1]->projector_coordinate - edges[i]->projector_coordinate) / (end - start);
    double weights = 0, p_sum = 0, c_sum = 0;
    const auto weight = [&](std::size_t k) {
      const double sigma = std::abs(rough) * inflation * std::max(edges[k]->sigma_px, 1e-3);
      return 1 / (sigma * sigma);
    };
    for (std::size_t k = first; k <= last; ++k) {
      weights += weight(k);
      p_sum += weight(k) * position(*edges[k]);
      c_sum += weight(k) * edges[k]->projector_coordinate;
    }
    Line line;
    line.centre = p_sum / weights;
    line.middle = c_sum / weights;
    double pp = 0, pc = 0;
    for (std::size_t k = first; k <= last; ++k) {
      const double p = position(*edges[k]) - line.centre;
      pp += weight(k) * p * p;
      pc += weight(k) * p * (edges[k]->projector_coordinate - line.middle);
    }
    line.slope = pc / pp;
    line.middle_variance = 1 / weights;
    line.slope_variance = 1 / pp;
    for (std::size_t k = first; k <= last && last > first + 1; ++k) {
      const double off =
          edges[k]->projector_coordinate - line.middle - line.slope * (position(*edges[k]) - line.centre);
      if (off * off * weight(k) > 9) return fit(edges, i, i + 1, i, inflation);
    }
    return line;
  }

  /// Pixels first .. last in steps of 1 or -1; with `bridge` also those without a decoded stripe, which have a weak bit at a
  /// stripe's border. Past the edges, the first that belongs to another stripe ends it.
  void draw(const Line& line, int first, int last, int step, bool bridge) {
    for (int at = first; step > 0 ? at <= last : at >= last; at += step) {
      if (at < 0 || at >= length_) return;
      const double p = at - line.centre, coordinate = line.middle + line.slope * p;
      const bool undecoded = code(at) == DecodedMap::kUndecoded;
      if (!(undecoded && bridge) && !agrees(at, coordinate, line.tolerance)) {
        if (bridge) continue;
        return;
      }
      set(at, coordinate, std::sqrt(line.middle_variance + p * p * line.slope_variance));
    }
  }

  const DecodedMap& decoded_;
  LightMap& light_;
  const Image<std::int16_t>& codes_;
  int channel_;
  bool along_x_;
  int line_, length_;
};

using EdgesByLine = std::vector<StripeLine::Edges>;

/// By camera line, in the order along it.
EdgesByLine edges_by_line(const DecodedMap& decoded, const std::vector<StripeEdge>& edges, StripeAxis axis,
                          ScanAxis scan) {
  const int along = scan == ScanAxis::kCameraX ? 0 : 1;
  const int lines = along == 0 ? decoded.camera_size().height : decoded.camera_size().width;
  EdgesByLine by_line(static_cast<std::size_t>(lines));
  for (const StripeEdge& edge : edges) {
    if (edge.axis != axis || edge.scan != scan) continue;
    const long line = std::lround(edge.camera_pixel[1 - along]);
    require(line >= 0 && line < lines, "light_map: an edge lies outside of the map");
    by_line[std::size_t(line)].push_back(&edge);
  }
  for (auto& of_line : by_line)
    std::stable_sort(of_line.begin(), of_line.end(), [&](const StripeEdge* a, const StripeEdge* b) {
      return a->camera_pixel[along] < b->camera_pixel[along];
    });
  return by_line;
}

}  // namespace

LightMap light_map(const DecodedMap& decoded, const std::vector<StripeEdge>& edges,
                   const StripeMapOptions& options) {
  LightMap light;
  light.projector_size = decoded.projector_size;
  light.pixel = ImageF(decoded.camera_size(), 2);
  light.sigma = ImageF(decoded.camera_size(), 2);
  light.diagnostics = decoded.diagnostics;
  for (const StripeAxis axis : {StripeAxis::kColumn, StripeAxis::kRow}) {
    // The direction in which stripe_edges() scanned this axis; without edges, that of an upright projector.
    ScanAxis scan = axis == StripeAxis::kColumn ? ScanAxis::kCameraX : ScanAxis::kCameraY;
    for (const StripeEdge& edge : edges)
      if (edge.axis == axis) scan = edge.scan;
    const EdgesByLine by_line = edges_by_line(decoded, edges, axis, scan);
    internal::EdgeScatter scatter(decoded.camera_size());
    for (std::size_t line = 0; line < by_line.size(); ++line)
      StripeLine(decoded, light, axis, scan, int(line)).measure(by_line[line], options, scatter);
    scatter.finish();
    for (std::size_t line = 0; line < by_line.size(); ++line) {
      StripeLine pixels(decoded, light, axis, scan, int(line));
      pixels.fill(pixels.without_moved(by_line[line], options, scatter.everywhere()), options, scatter);
      pixels.fill_by_codes(options);
    }
  }
  return light;
}

}  // namespace procam::pattern
