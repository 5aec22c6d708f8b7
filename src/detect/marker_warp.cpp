#include "marker_warp.hpp"

#include <algorithm>
#include <cmath>

#include "edge_profile.hpp"
#include "procam/core/base/cholesky.hpp"
#include "procam/core/base/stats.hpp"
#include "procam/core/geometry/homography_fit.hpp"

namespace procam::detect {
namespace {

constexpr double kPieceLength = 8;  ///< pixels; shorter than the bend of any usable lens shows
constexpr double kShortestPiece = 3;
constexpr int kFewestOnSide = 3;  ///< two make a line, the third shows a misfit
/// How far one number may move all edges towards white, one standard deviation, pixels: holds the size where
/// no inner edge separates the two.
constexpr double kSpreadSigma = 0.3;

/// A border between black and white along a line of the grid: from cell `begin` to before `end`.
struct Run {
  bool vertical = false;  ///< a column's border: constant x
  int line = 0;           ///< 0 .. lines, counted from the black square's left or top side
  int begin = 0, end = 0;
  bool white_after = false;  ///< the white cells have the larger x (y)
};

/// All borders of the print, the four sides first.
std::vector<Run> runs_of(const MarkerCells& codes, int id) {
  const int n = codes.per_side + 2;
  std::vector<Run> sides, inner;
  for (const bool vertical : {true, false})
    for (int line = 0; line <= n; ++line) {
      // What lies before and after the line at position i along it: 0 no border, +1 white after, -1 before.
      const auto step = [&](int i) {
        const auto white = [&](int across) {
          return vertical ? codes.is_white(id, i - 1, across - 1) : codes.is_white(id, across - 1, i - 1);
        };
        return int(white(line)) - int(white(line - 1));
      };
      for (int i = 0; i < n;) {
        const int sign = step(i);
        int end = i + 1;
        while (end < n && step(end) == sign) ++end;
        if (sign != 0) (line == 0 || line == n ? sides : inner).push_back({vertical, line, i, end, sign > 0});
        i = end;
      }
    }
  sides.insert(sides.end(), inner.begin(), inner.end());
  return sides;
}

/// Where the image shows a run: its ends and, at the middle, the width of a cell across it.
struct SeenRun {
  Vec2 begin_on_marker, end_on_marker, towards_white;
  double length = 0, cell_px = 0;
};

std::optional<SeenRun> see(const Run& run, int lines, const MarkerWarp& warp) {
  const auto on_marker = [&](double along) {
    const double a = along / lines - 0.5, l = double(run.line) / lines - 0.5;
    return run.vertical ? Vec2(l, a) : Vec2(a, l);
  };
  const double sign = run.white_after ? 1 : -1;
  SeenRun seen{on_marker(run.begin), on_marker(run.end), run.vertical ? Vec2(sign, 0) : Vec2(0, sign), 0, 0};
  const Vec2 middle = 0.5 * (seen.begin_on_marker + seen.end_on_marker);
  const auto begin = warp(seen.begin_on_marker), end = warp(seen.end_on_marker), at = warp(middle),
             across = warp(middle + seen.towards_white / (2 * lines));
  if (!begin || !end || !at || !across) return std::nullopt;
  const Vec2 span = *end - *begin;
  seen.length = span.norm();
  if (!(seen.length > 0)) return std::nullopt;
  const Vec2 normal = Vec2(-span.y(), span.x()) / seen.length;
  seen.cell_px = 2 * std::abs(normal.dot(*across - *at));
  return seen;
}

struct Piece {
  MarkerEdge edge;
  EdgeProfile profile;
};

/// How a run is divided into pieces.
struct RunDivision {
  int min_pieces;  ///< where they are not too short for it
  double trim;     ///< pixels off the run's ends
};

/// What is known of the edges before they are fitted, as in EdgeBox.
struct KnownEdge {
  double reach;  ///< pixels to both sides
  double blur;
  Vec2 light_gradient;
};

/// Appends the pieces of one run.
void fit_run(const ViewU8& image, const SeenRun& run, const MarkerWarp& warp, const RunDivision& division,
             const KnownEdge& edge, std::vector<Piece>& pieces) {
  const double trim = division.trim;
  const double usable = run.length - 2 * trim;
  if (usable < kShortestPiece) return;
  const int count = std::max(std::min(division.min_pieces, int(usable / kShortestPiece)),
                             int(std::lround(usable / kPieceLength)));
  const double share = usable / run.length / count;
  for (int i = 0; i < count; ++i) {
    const double from = trim / run.length + i * share;
    const Vec2 span = run.end_on_marker - run.begin_on_marker;
    const Vec2 middle = run.begin_on_marker + (from + 0.5 * share) * span;
    const auto at = warp(middle), a = warp(run.begin_on_marker + from * span),
               b = warp(run.begin_on_marker + (from + share) * span),
               white = warp(middle + 1e-3 * run.towards_white);
    if (!at || !a || !b || !white) continue;
    const Vec2 tangent = (*b - *a).normalized();
    Vec2 normal(-tangent.y(), tangent.x());
    if (normal.dot(*white - *at) < 0) normal = -normal;
    const auto profile = fit_edge_profile(
        image, {*at, normal, 0.5 * (*b - *a).norm(), edge.reach, edge.blur, edge.light_gradient});
    if (!profile) continue;
    pieces.push_back({{middle, run.towards_white, *at + profile->offset * normal, 0}, *profile});
  }
}

template <typename Value>
double median_of_pieces(const std::vector<Piece>& pieces, const Value& value) {
  std::vector<double> values;
  for (const Piece& piece : pieces) values.push_back(value(piece));
  return median(std::move(values));
}

/// Share a pixel by which the white round the marker brightens: a plane through the pieces' light sides,
/// without those far from the median (a finger, a shadow's edge).
Vec2 light_gradient(const std::vector<Piece>& pieces) {
  const double light = median_of_pieces(pieces, [](const Piece& p) { return p.profile.light; });
  Mat3 normal = Mat3::Zero();
  Vec3 right = Vec3::Zero();
  for (const Piece& piece : pieces) {
    const double share = piece.profile.light / light - 1;
    if (std::abs(share) > 0.2) continue;
    const Vec2 d = piece.edge.pixel - pieces.front().edge.pixel;
    const Vec3 row(d.x(), d.y(), 1);
    normal += row * row.transpose();
    right += share * row;
  }
  const Vec2 gradient = Cholesky(normal).solve(right).head<2>();
  constexpr double kSteepest = 0.01;  // beyond that it is no lamp but a misfit, e.g. one side alone
  return gradient.allFinite() && gradient.norm() < kSteepest ? gradient : Vec2(Vec2::Zero());
}

}  // namespace

std::optional<MarkerWarp> MarkerWarp::through(const std::array<Vec2, 4>& corners, const Camera* lens) {
  Points2 on_marker, on_plane;
  for (std::size_t i = 0; i < 4; ++i) {
    on_marker.push_back(marker_corners()[i]);
    on_plane.push_back(corners[i]);
    if (lens == nullptr) continue;
    const std::optional<Vec3> bearing = lens->unproject(corners[i]);
    if (!bearing || !(bearing->z() > 0)) return std::nullopt;
    on_plane.back() = bearing->head<2>() / bearing->z();
  }
  try {
    return MarkerWarp{homography_dlt(on_marker, on_plane).matrix(), lens};
  } catch (const Error&) {  // corners on one line
    return std::nullopt;
  }
}

std::optional<Vec2> MarkerWarp::operator()(const Vec2& on_marker) const {
  const std::optional<Vec2> on_plane = Homography::trusted(plane_from_marker).apply(on_marker);
  if (!on_plane || lens == nullptr) return on_plane;
  return lens->project(Vec3(on_plane->x(), on_plane->y(), 1));
}

FoundEdges find_edges(const ViewU8& image, const MarkerCells& codes, int id, const MarkerWarp& warp) {
  const int lines = codes.per_side + 2;
  std::vector<SeenRun> runs;
  for (const Run& run : runs_of(codes, id))
    if (const auto seen = see(run, lines, warp)) runs.push_back(*seen);

  // The sides come first: from them the blur, which sets the distance from other edges, and the light.
  std::vector<Piece> pieces;
  for (std::size_t i = 0; i < std::min<std::size_t>(4, runs.size()); ++i)
    fit_run(image, runs[i], warp, {kFewestOnSide, runs[i].cell_px},
            {std::clamp(0.6 * runs[i].cell_px, 2.5, 8.0), 1, Vec2::Zero()}, pieces);
  if (pieces.empty()) return {};
  const double blur = median_of_pieces(pieces, [](const Piece& p) { return p.profile.blur; });
  const double contrast = median_of_pieces(pieces, [](const Piece& p) { return p.profile.contrast; });
  const Vec2 gradient = light_gradient(pieces);

  pieces.clear();
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const double reach = std::min(3 * blur + 1.5, runs[i].cell_px - 2 * blur);
    if (reach >= 1.5 * blur + 0.5)
      fit_run(image, runs[i], warp, {i < 4 ? kFewestOnSide : 1, 2.5 * blur + 0.7}, {reach, blur, gradient},
              pieces);
  }
  const auto is_odd = [&](const Piece& p) {
    return p.profile.contrast < 0.4 * contrast || p.profile.blur > 2 * blur;
  };
  pieces.erase(std::remove_if(pieces.begin(), pieces.end(), is_odd), pieces.end());
  if (pieces.empty()) return {};

  // Each piece's own residual is a poor estimate of the noise; only one that stands out is believed.
  const double noise =
      std::max(median_of_pieces(pieces, [](const Piece& p) { return p.profile.noise; }), 1. / 12);
  std::vector<MarkerEdge> edges;
  for (Piece& piece : pieces) {
    piece.edge.variance =
        piece.profile.variance_per_noise * (piece.profile.noise > 2.5 * noise ? piece.profile.noise : noise);
    edges.push_back(piece.edge);
  }
  return {edges, blur};
}

namespace {

constexpr int kUnknowns = 9;  ///< the corners' pixels, then what moves all edges towards white
using Normal = Eigen::Matrix<double, kUnknowns, kUnknowns>;
using Unknowns = Eigen::Matrix<double, kUnknowns, 1>;

std::optional<std::array<Vec2, 4>> corners_of(const MarkerWarp& warp) {
  std::array<Vec2, 4> corners;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto pixel = warp(marker_corners()[i]);
    if (!pixel) return std::nullopt;
    corners[i] = *pixel;
  }
  return corners;
}

/// Residuals and their derivatives at the current corners.
struct Linearised {
  std::vector<Unknowns> rows;
  std::vector<double> residuals;
};

std::optional<Linearised> linearise(const std::vector<MarkerEdge>& edges, const std::array<Vec2, 4>& corners,
                                    double spread, const Camera* lens) {
  const auto warp = MarkerWarp::through(corners, lens);
  if (!warp) return std::nullopt;
  constexpr double kStep = 1e-3;
  std::array<MarkerWarp, 8> moved;
  for (std::size_t k = 0; k < 8; ++k) {
    std::array<Vec2, 4> other = corners;
    other[k / 2][Eigen::Index(k % 2)] += kStep;
    const auto through = MarkerWarp::through(other, lens);
    if (!through) return std::nullopt;
    moved[k] = *through;
  }
  Linearised out;
  for (const MarkerEdge& edge : edges) {
    const auto foot = foot_of(edge, *warp);
    if (!foot) return std::nullopt;
    const auto at = (*warp)(foot->on_marker);
    Unknowns row;
    for (std::size_t k = 0; k < 8; ++k) {
      const auto pixel = moved[k](foot->on_marker);
      if (!at || !pixel) return std::nullopt;
      row[Eigen::Index(k)] = foot->normal.dot(*pixel - *at) / kStep;
    }
    row[8] = 1;
    out.rows.push_back(row);
    out.residuals.push_back(foot->distance - spread);
  }
  return out;
}

}  // namespace

std::optional<WarpFit> fit_warp(std::vector<MarkerEdge>& edges, const MarkerWarp& start) {
  constexpr std::size_t kFewest = 12;
  auto corners = corners_of(start);
  if (!corners || edges.size() < kFewest) return std::nullopt;
  double spread = 0;
  Normal inverse;
  double chi2 = 1, scale2 = 1;
  constexpr int kRobust = 8, kPlain = 3;
  for (int iteration = 0; iteration < kRobust + kPlain; ++iteration) {
    const auto system = linearise(edges, *corners, spread, start.lens);
    if (!system) return std::nullopt;
    std::vector<double> sizes;
    for (std::size_t i = 0; i < edges.size(); ++i)
      sizes.push_back(std::abs(system->residuals[i]) / std::sqrt(edges[i].variance));
    const double robust_scale = std::max(1.0, 1.4826 * median(sizes));

    // Tukey's weight: nothing beyond 4.7 sigma counts. The last rounds take what is left as it is.
    Normal normal = Normal::Zero();
    Unknowns right = Unknowns::Zero();
    double cost = 0;
    for (std::size_t i = 0; i < edges.size(); ++i) {
      const double u = sizes[i] / (4.7 * robust_scale);
      const double weight = iteration >= kRobust ? 1 : u < 1 ? (1 - u * u) * (1 - u * u) : 0;
      const double w = weight / edges[i].variance;
      normal += w * system->rows[i] * system->rows[i].transpose();
      right += w * system->residuals[i] * system->rows[i];
      cost += w * system->residuals[i] * system->residuals[i];
    }
    normal(8, 8) += 1 / (kSpreadSigma * kSpreadSigma);
    right[8] -= spread / (kSpreadSigma * kSpreadSigma);
    const Cholesky factors(normal);
    const Unknowns step = factors.solve(right);
    if (!step.allFinite() || !(step.norm() < 1e3)) return std::nullopt;
    for (std::size_t k = 0; k < 8; ++k) (*corners)[k / 2][Eigen::Index(k % 2)] += step[Eigen::Index(k)];
    spread += step[8];
    inverse = factors.inverse();
    chi2 = cost / double(edges.size() - kUnknowns + 1);
    scale2 = std::max(1.0, chi2);

    if (iteration != kRobust - 1) continue;
    std::vector<MarkerEdge> kept;
    for (std::size_t i = 0; i < edges.size(); ++i)
      if (sizes[i] < 5 * robust_scale) kept.push_back(edges[i]);
    edges = kept;
    if (edges.size() < kFewest) return std::nullopt;
  }
  const auto warp = MarkerWarp::through(*corners, start.lens);
  constexpr double kLargestSigma = 1;  // pixels: a side that nothing shows
  if (!warp || !(inverse.diagonal().head<8>().maxCoeff() < kLargestSigma * kLargestSigma))
    return std::nullopt;
  return WarpFit{*warp, scale2 * inverse.topLeftCorner<8, 8>(), chi2};
}

void believe_misfit(const WarpFit& fit, double blur, std::vector<MarkerEdge>& edges) {
  // Measured on markers with gamma 2.2 and 4 % glare: 3.5 % of the blur where edges blur into each other.
  constexpr double kShareOfBlur = 0.05;
  const double dof = double(edges.size()) - kUnknowns + 1;
  if (!(fit.chi2_per_dof > 1 + 2 * std::sqrt(2 / std::max(dof, 1.0)))) return;  // chance
  double information = 0;
  for (const MarkerEdge& edge : edges) information += 1 / edge.variance;
  const double excess = (fit.chi2_per_dof - 1) * double(edges.size()) / information;
  for (MarkerEdge& edge : edges) edge.variance += std::min(excess, std::pow(kShareOfBlur * blur, 2));
}

}  // namespace procam::detect
