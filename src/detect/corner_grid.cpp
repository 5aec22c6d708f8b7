#include "corner_grid.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <queue>

#include "procam/core/base/detail/four.hpp"

namespace procam::detect {
namespace {

constexpr int kRadius = 5;          ///< of the ring, pixels
constexpr int kRingSamples = 16;    ///< of the response
constexpr double kMinContrast = 5;  ///< grey levels between the ring's light and dark samples
constexpr std::size_t kMaxCandidates = 3000;

struct Candidate {
  Vec2 position;
  float response = 0;
  /// Directions from the corner along its edges: +, - along the line where the ring becomes light, then +, -
  /// along the one where it becomes dark.
  std::array<Vec2, 4> directions;
  std::array<int, 4> links{-1, -1, -1, -1};
};

double cross(const Vec2& a, const Vec2& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// Sixteen pixels beside each other. All sums of the response fit into 16 bits.
using Short16 = procam::detail::Lanes<std::int16_t>;
constexpr int kAtOnce = int(Short16::kSize);
using Ring = std::array<const std::uint8_t*, kRingSamples>;

PROCAM_ALWAYS_INLINE Short16 sixteen(const std::uint8_t* from) {
  std::uint8_t __attribute__((vector_size(16))) greys;
  std::memcpy(&greys, from, sizeof greys);
  return Short16(__builtin_convertvector(greys, Short16::Native));
}
PROCAM_ALWAYS_INLINE Short16 size_of(const Short16& v) {
  return larger(v, Short16(0) - v);
}

/// Of sixteen pixels from `x` on. `ring`: the samples of a row's first pixel.
PROCAM_ALWAYS_INLINE void respond(const Ring& ring, const std::uint8_t* centre, int x, std::int16_t* out) {
  Short16 sum(0), mean(0);
  for (std::size_t n = 0; n < 4; ++n) {
    const Short16 a = sixteen(ring[n] + x), b = sixteen(ring[n + 4] + x), c = sixteen(ring[n + 8] + x),
                  d = sixteen(ring[n + 12] + x);
    sum += size_of(a + c - b - d) - size_of(a - c) - size_of(b - d);
    mean += a + b + c + d;
  }
  // The middle of a crossing is as bright as its ring; a stripe's is not.
  const Short16 beside = size_of(mean - Short16(kRingSamples) * sixteen(centre + x));
  sum = larger(sum - Short16(beside.lanes >> 1), Short16(0));
  std::memcpy(out + x, &sum, sizeof sum);
}
/// Of a row, but for its ends.
PROCAM_ALWAYS_INLINE void respond_in_row(const Ring& ring, const std::uint8_t* centre, int width,
                                         std::int16_t* out) {
  const int last = width - kRadius - kAtOnce;
  for (int x = kRadius; x < last; x += kAtOnce) respond(ring, centre, x, out);
  respond(ring, centre, last, out);
}
void respond_plain(const Ring& ring, const std::uint8_t* centre, int width, std::int16_t* out) {
  respond_in_row(ring, centre, width, out);
}
#ifdef PROCAM_WIDE_VECTORS
PROCAM_WIDE_VECTORS void respond_wide(const Ring& ring, const std::uint8_t* centre, int width,
                                      std::int16_t* out) {
  respond_in_row(ring, centre, width, out);
}
void respond_all(const Ring& ring, const std::uint8_t* centre, int width, std::int16_t* out) {
  static const bool wide = PROCAM_HAS_WIDE_VECTORS;
  wide ? respond_wide(ring, centre, width, out) : respond_plain(ring, centre, width, out);
}
#else
void respond_all(const Ring& ring, const std::uint8_t* centre, int width, std::int16_t* out) {
  respond_plain(ring, centre, width, out);
}
#endif

/// The ring response; zero where it is negative, and in pictures that are too small for a board.
cv::Mat ring_response(const cv::Mat& smooth) {
  cv::Mat response = cv::Mat::zeros(smooth.size(), CV_16S);
  if (smooth.cols < 2 * kRadius + kAtOnce) return response;
  std::array<std::ptrdiff_t, kRingSamples> offset;
  for (int n = 0; n < kRingSamples; ++n) {
    const double angle = 2 * M_PI * n / kRingSamples;
    offset[std::size_t(n)] = std::lround(kRadius * std::sin(angle)) * std::ptrdiff_t(smooth.step[0]) +
                             std::lround(kRadius * std::cos(angle));
  }
  for (int y = kRadius; y < smooth.rows - kRadius; ++y) {
    Ring ring;
    for (std::size_t n = 0; n < ring.size(); ++n) ring[n] = smooth.ptr(y) + offset[n];
    respond_all(ring, smooth.ptr(y), smooth.cols, response.ptr<std::int16_t>(y));
  }
  return response;
}

double bilinear(const cv::Mat& image, const Vec2& at) {
  const int x = int(at.x()), y = int(at.y());
  const double u = at.x() - x, v = at.y() - y;
  const std::uint8_t *upper = image.ptr(y), *lower = image.ptr(y + 1);
  return (1 - v) * ((1 - u) * upper[x] + u * upper[x + 1]) + v * ((1 - u) * lower[x] + u * lower[x + 1]);
}

/// Fills in the directions of the edges; false where the ring does not change four times, or its ends do not
/// lie opposite.
bool find_edges(const cv::Mat& smooth, Candidate& candidate) {
  constexpr int kSamples = 32;
  constexpr double kMaxBend = 0.5, kMinAngle = 0.3;  // radians
  std::array<double, kSamples> ring;
  const Vec2& p = candidate.position;
  if (p.x() < kRadius + 1 || p.y() < kRadius + 1 || p.x() >= smooth.cols - kRadius - 2 ||
      p.y() >= smooth.rows - kRadius - 2)
    return false;
  static const std::array<Vec2, kSamples> places = [] {
    std::array<Vec2, kSamples> around;
    for (int n = 0; n < kSamples; ++n) {
      const double angle = 2 * M_PI * n / kSamples;
      around[std::size_t(n)] = kRadius * Vec2(std::cos(angle), std::sin(angle));
    }
    return around;
  }();
  for (std::size_t n = 0; n < kSamples; ++n) ring[n] = bilinear(smooth, p + places[n]);
  std::array<double, kSamples> sorted = ring;
  std::sort(sorted.begin(), sorted.end());
  const double dark = sorted[kSamples / 8], light = sorted[kSamples - 1 - kSamples / 8];
  if (light - dark < kMinContrast) return false;
  const double middle = 0.5 * (light + dark);
  std::vector<double> rises, falls;
  for (int n = 0; n < kSamples; ++n) {
    const double here = ring[std::size_t(n)] - middle, next = ring[std::size_t((n + 1) % kSamples)] - middle;
    if ((here < 0) == (next < 0)) continue;
    (here < 0 ? rises : falls).push_back(2 * M_PI * (n + here / (here - next)) / kSamples);
  }
  if (rises.size() != 2 || falls.size() != 2) return false;
  int k = 0;
  for (const std::vector<double>& ends : {rises, falls}) {
    const Vec2 a(std::cos(ends[0]), std::sin(ends[0])), b(std::cos(ends[1]), std::sin(ends[1]));
    if (std::abs(cross(a, b)) > std::sin(kMaxBend) || a.dot(b) > 0) return false;
    const Vec2 along = (a - b).normalized();
    candidate.directions[std::size_t(k++)] = along;
    candidate.directions[std::size_t(k++)] = -along;
  }
  return std::abs(cross(candidate.directions[0], candidate.directions[2])) > std::sin(kMinAngle);
}

/// Does one of sixteen respond by `min_response` or more?
PROCAM_ALWAYS_INLINE bool any_responds(const std::int16_t* sixteen_from, int min_response) {
  Short16 responses;
  std::memcpy(&responses, sixteen_from, sizeof responses);
  const auto found = responses.lanes >= std::int16_t(min_response);
  std::uint64_t words[4];
  static_assert(sizeof words == sizeof found);
  std::memcpy(words, &found, sizeof words);
  return (words[0] | words[1] | words[2] | words[3]) != 0;
}

std::vector<Candidate> find_candidates(const cv::Mat& smooth) {
  const cv::Mat response = ring_response(smooth);
  cv::Mat highest;
  cv::dilate(response, highest, cv::getStructuringElement(cv::MORPH_RECT, cv::Size(7, 7)));
  // A crossing of contrast c answers with about 6 c.
  constexpr int kMinResponse = int(3 * kMinContrast);
  std::vector<Candidate> candidates;
  for (int y = kRadius; y < smooth.rows - kRadius; ++y) {
    const std::int16_t *here = response.ptr<std::int16_t>(y), *best = highest.ptr<std::int16_t>(y);
    for (int x = kRadius; x < smooth.cols - kRadius; ++x) {
      if (x + kAtOnce <= smooth.cols && !any_responds(here + x, kMinResponse)) {
        x += kAtOnce - 1;
        continue;
      }
      if (here[x] < kMinResponse || here[x] != best[x]) continue;
      Vec2 sum = Vec2::Zero();
      double weights = 0;
      for (int j = -2; j <= 2; ++j)
        for (int i = -2; i <= 2; ++i) {
          const double weight = response.at<std::int16_t>(y + j, x + i);
          sum += weight * Vec2(i, j);
          weights += weight;
        }
      Candidate candidate;
      candidate.position = Vec2(x, y) + sum / weights;
      candidate.response = here[x];
      if (find_edges(smooth, candidate)) candidates.push_back(candidate);
    }
  }
  if (candidates.size() > kMaxCandidates) {
    std::nth_element(candidates.begin(), candidates.begin() + kMaxCandidates, candidates.end(),
                     [](const Candidate& a, const Candidate& b) { return a.response > b.response; });
    candidates.resize(kMaxCandidates);
  }
  return candidates;
}

/// The nearest candidate along each direction that may be the next corner on the line.
void link_candidates(std::vector<Candidate>& candidates) {
  const double kAlong = std::sin(15 * M_PI / 180), kParallel = std::sin(20 * M_PI / 180);
  for (Candidate& from : candidates) {
    std::array<double, 4> nearest;
    nearest.fill(1e30);
    for (std::size_t other = 0; other < candidates.size(); ++other) {
      const Candidate& to = candidates[other];
      const Vec2 step = to.position - from.position;
      const double squared = step.squaredNorm();
      if (squared < kRadius * kRadius || squared >= *std::max_element(nearest.begin(), nearest.end()))
        continue;
      const Vec2 along = step / std::sqrt(squared);
      for (std::size_t d = 0; d < 4; ++d) {
        if (squared >= nearest[d] || along.dot(from.directions[d]) < 0 ||
            std::abs(cross(along, from.directions[d])) > kAlong)
          continue;
        const Vec2 &same_line = to.directions[d < 2 ? 2 : 0], &other_line = to.directions[d < 2 ? 0 : 2];
        if (std::abs(cross(along, same_line)) > kAlong ||
            std::abs(cross(from.directions[d < 2 ? 2 : 0], other_line)) > kParallel)
          continue;
        nearest[d] = squared;
        from.links[d] = int(other);
      }
    }
  }
}

/// The direction of a candidate that is nearest to `along`.
std::size_t direction_along(const Candidate& candidate, const Vec2& along) {
  std::size_t best = 0;
  for (std::size_t d = 1; d < 4; ++d)
    if (candidate.directions[d].dot(along) > candidate.directions[best].dot(along)) best = d;
  return best;
}

/// Drops links that are not mutual, and those that are much longer or shorter than the next ones on their
/// line: they lead to another board.
void prune_links(std::vector<Candidate>& candidates) {
  constexpr double kMaxRatio = 1.6;
  const std::vector<Candidate> before = candidates;
  const auto back = [&](const std::vector<Candidate>& all, std::size_t from, std::size_t d) -> int {
    const int to = all[from].links[d];
    if (to < 0) return -1;
    const std::size_t reverse = direction_along(all[std::size_t(to)], -all[from].directions[d]);
    return all[std::size_t(to)].links[reverse] == int(from) ? int(reverse) : -1;
  };
  for (std::size_t c = 0; c < candidates.size(); ++c)
    for (std::size_t d = 0; d < 4; ++d)
      if (back(before, c, d) < 0) candidates[c].links[d] = -1;
  const std::vector<Candidate> mutual = candidates;
  const auto length = [&](std::size_t from, std::size_t d) -> double {
    const int to = mutual[from].links[d];
    return to < 0 ? 0 : (mutual[std::size_t(to)].position - mutual[from].position).norm();
  };
  for (std::size_t c = 0; c < candidates.size(); ++c)
    for (std::size_t d = 0; d < 4; ++d) {
      const double here = length(c, d);
      if (here == 0) continue;
      const auto to = std::size_t(mutual[c].links[d]);
      const double behind = length(c, d ^ 1), beyond = length(to, std::size_t(back(mutual, c, d)) ^ 1);
      for (const double next : {behind, beyond})
        if (next > 0 && (here > kMaxRatio * next || next > kMaxRatio * here)) {
          // Of two unequal links the longer one leaves the board.
          if (here > next) candidates[c].links[d] = -1;
        }
    }
  const std::vector<Candidate> pruned = candidates;
  for (std::size_t c = 0; c < candidates.size(); ++c)
    for (std::size_t d = 0; d < 4; ++d)
      if (back(pruned, c, d) < 0) candidates[c].links[d] = -1;
}

using Cell = std::pair<int, int>;  ///< column, row
using Cells = std::map<Cell, Vec2>;

/// Numbers everything that is linked with the first candidate.
Cells number_linked(const std::vector<Candidate>& candidates, std::size_t first, std::vector<char>& taken) {
  struct Entry {
    std::size_t candidate;
    Cell cell;
    Vec2 along_row;
  };
  Cells cells;
  std::queue<Entry> open;
  open.push({first, {0, 0}, candidates[first].directions[0]});
  taken[first] = 1;
  cells[{0, 0}] = candidates[first].position;
  while (!open.empty()) {
    const Entry entry = open.front();
    open.pop();
    const Candidate& here = candidates[entry.candidate];
    const std::size_t right = direction_along(here, entry.along_row);
    // Down is the direction of the other line that makes the order right-handed.
    std::size_t down = right < 2 ? 2 : 0;
    if (cross(here.directions[right], here.directions[down]) < 0) down ^= 1;
    const std::pair<std::size_t, Cell> steps[] = {
        {right, {1, 0}}, {right ^ 1, {-1, 0}}, {down, {0, 1}}, {down ^ 1, {0, -1}}};
    for (const auto& [d, step] : steps) {
      const int to = here.links[d];
      if (to < 0 || taken[std::size_t(to)]) continue;
      const Cell cell{entry.cell.first + step.first, entry.cell.second + step.second};
      if (cells.count(cell) > 0) continue;
      taken[std::size_t(to)] = 1;
      cells[cell] = candidates[std::size_t(to)].position;
      open.push({std::size_t(to), cell, here.directions[right]});
    }
  }
  return cells;
}

struct Extent {
  int left, right, top, bottom;

  int columns() const { return right - left + 1; }
  int rows() const { return bottom - top + 1; }
};

/// The bounding rectangle without outer lines of which less than half is there.
Extent trimmed_extent(const Cells& cells) {
  Extent e{1 << 30, -(1 << 30), 1 << 30, -(1 << 30)};
  for (const auto& [cell, position] : cells) {
    e.left = std::min(e.left, cell.first), e.right = std::max(e.right, cell.first);
    e.top = std::min(e.top, cell.second), e.bottom = std::max(e.bottom, cell.second);
  }
  const auto count = [&](int left, int right, int top, int bottom) {
    int sum = 0;
    for (int r = top; r <= bottom; ++r)
      for (int c = left; c <= right; ++c) sum += int(cells.count({c, r}));
    return sum;
  };
  while (e.columns() >= 3 && e.rows() >= 3) {
    const double shares[] = {double(count(e.left, e.left, e.top, e.bottom)) / e.rows(),
                             double(count(e.right, e.right, e.top, e.bottom)) / e.rows(),
                             double(count(e.left, e.right, e.top, e.top)) / e.columns(),
                             double(count(e.left, e.right, e.bottom, e.bottom)) / e.columns()};
    const auto least = std::min_element(std::begin(shares), std::end(shares)) - std::begin(shares);
    if (shares[least] >= 0.5) break;
    if (least == 0) ++e.left;
    if (least == 1) --e.right;
    if (least == 2) ++e.top;
    if (least == 3) --e.bottom;
  }
  return e;
}

/// Where its neighbours predict a missing corner.
std::optional<Vec2> predict(const Cells& cells, const Cell& cell) {
  const auto at = [&](int dc, int dr) -> const Vec2* {
    const auto found = cells.find({cell.first + dc, cell.second + dr});
    return found == cells.end() ? nullptr : &found->second;
  };
  Vec2 sum = Vec2::Zero();
  double weights = 0;
  for (const auto& [dc, dr] : {Cell{1, 0}, Cell{0, 1}})
    if (at(-dc, -dr) != nullptr && at(dc, dr) != nullptr)
      sum += 2 * (*at(-dc, -dr) + *at(dc, dr)), weights += 4;
  for (const auto& [dc, dr] : {Cell{1, 0}, Cell{-1, 0}, Cell{0, 1}, Cell{0, -1}})
    if (at(dc, dr) != nullptr && at(2 * dc, 2 * dr) != nullptr)
      sum += 2 * *at(dc, dr) - *at(2 * dc, 2 * dr), weights += 1;
  if (weights == 0) return std::nullopt;
  return sum / weights;
}

std::optional<CornerGrid> complete_grid(Cells cells) {
  constexpr double kMinFound = 0.8;
  const Extent e = trimmed_extent(cells);
  if (e.columns() < 3 || e.rows() < 3) return std::nullopt;
  int found = 0;
  for (auto it = cells.begin(); it != cells.end();) {
    const bool inside = it->first.first >= e.left && it->first.first <= e.right &&
                        it->first.second >= e.top && it->first.second <= e.bottom;
    found += inside;
    it = inside ? std::next(it) : cells.erase(it);
  }
  if (found < kMinFound * e.columns() * e.rows()) return std::nullopt;
  for (bool added = true; added && int(cells.size()) < e.columns() * e.rows();) {
    Cells predicted;
    for (int r = e.top; r <= e.bottom; ++r)
      for (int c = e.left; c <= e.right; ++c)
        if (cells.count({c, r}) == 0)
          if (const auto p = predict(cells, {c, r})) predicted[{c, r}] = *p;
    cells.insert(predicted.begin(), predicted.end());
    added = !predicted.empty();
  }
  if (int(cells.size()) < e.columns() * e.rows()) return std::nullopt;
  CornerGrid grid{e.columns(), e.rows(), {}};
  for (int r = e.top; r <= e.bottom; ++r)
    for (int c = e.left; c <= e.right; ++c) grid.points.push_back(cells.at({c, r}));
  return grid;
}

}  // namespace

std::vector<CornerGrid> find_corner_grids(const cv::Mat& image) {
  cv::Mat smooth;
  cv::GaussianBlur(image, smooth, cv::Size(5, 5), 1);
  std::vector<Candidate> candidates = find_candidates(smooth);
  link_candidates(candidates);
  prune_links(candidates);
  std::vector<CornerGrid> grids;
  std::vector<char> taken(candidates.size(), 0);
  for (std::size_t c = 0; c < candidates.size(); ++c) {
    if (taken[c]) continue;
    const Cells cells = number_linked(candidates, c, taken);
    if (cells.size() < 9) continue;
    if (auto grid = complete_grid(cells)) grids.push_back(std::move(*grid));
  }
  return grids;
}

}  // namespace procam::detect
