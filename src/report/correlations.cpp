#include <algorithm>
#include <cmath>
#include <vector>

#include "heat.hpp"
#include "html.hpp"
#include "pictures.hpp"

namespace procam::report {
namespace {

constexpr double kCorrelationCell = 16;
constexpr double kVisibleCorrelation = 0.05;  // smaller ones stay blank
constexpr std::size_t kMaxParameters = 80, kStrongestPairs = 3;
constexpr char kPositive[] = "#c8402f", kNegative[] = "#3b6fd4";

struct Pair {
  std::size_t row = 0, column = 0;
  double correlation = 0;
};

/// Rows of the matrix with a finite variance above zero.
std::vector<Eigen::Index> known_rows(const NamedCovariance& covariance) {
  std::vector<Eigen::Index> rows;
  for (Eigen::Index i = 0; i < covariance.matrix.rows(); ++i)
    if (std::isfinite(covariance.matrix(i, i)) && covariance.matrix(i, i) > 0) rows.push_back(i);
  return rows;
}

std::vector<Pair> lower_triangle(const NamedCovariance& covariance, const std::vector<Eigen::Index>& rows) {
  const MatX& c = covariance.matrix;
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      const double r = c(rows[i], rows[j]) / std::sqrt(c(rows[i], rows[i]) * c(rows[j], rows[j]));
      if (std::isfinite(r)) pairs.push_back({i, j, r});
    }
  return pairs;
}

std::string correlation_color(double correlation) {
  return std::string(correlation > 0 ? kPositive : kNegative) + "\" fill-opacity=\"" +
         fixed(std::min(std::abs(correlation), 1.0), 2);
}

std::string in_words(const Pair& pair, const std::vector<std::string>& names) {
  return names[pair.row] + ", " + names[pair.column] + ": " + fixed(pair.correlation, 2);
}

/// -1 to 1, as a bar of cells.
std::string correlation_scale(const Vec2& corner) {
  constexpr int kSteps = 20;
  constexpr double kStep = 8;
  std::string content;
  for (int i = 0; i < kSteps; ++i)
    content += filled(corner + Vec2(i * kStep, 0), Vec2(kStep, 12),
                      correlation_color(2 * (i + 0.5) / kSteps - 1), "");
  for (const double value : {-1.0, 0.0, 1.0})
    content += label(corner + Vec2(0.5 * (value + 1) * kSteps * kStep, 26),
                     "class=\"tick\" text-anchor=\"middle\"", shortest(value));
  return content;
}

}  // namespace

std::string correlation_matrix(const NamedCovariance& covariance) {
  const std::vector<Eigen::Index> rows = known_rows(covariance);
  if (rows.size() < 2 || rows.size() > kMaxParameters) return "";
  std::vector<std::string> names;
  for (const Eigen::Index i : rows) names.push_back(covariance.names[std::size_t(i)]);
  std::vector<Pair> pairs = lower_triangle(covariance, rows);

  const double side = kCorrelationCell * double(rows.size());
  const Vec2 cell(kCorrelationCell, kCorrelationCell);
  std::string content;
  for (const Pair& pair : pairs)
    if (std::abs(pair.correlation) >= kVisibleCorrelation)
      content += filled(kCorrelationCell * Vec2(pair.column, pair.row), cell,
                        correlation_color(pair.correlation), in_words(pair, names));
  Marks lines;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const double at = kCorrelationCell * double(i);
    lines.line(Vec2(0, at + kCorrelationCell), Vec2(at + kCorrelationCell, at + kCorrelationCell));
    lines.line(Vec2(at, at), Vec2(at, side));
    content += label(Vec2(at + 5, at + 12), "class=\"tick\"", names[i]);
  }
  content += lines.path("class=\"axis\"") + correlation_scale(Vec2(0.62 * side, 8));

  const auto strongest = pairs.begin() + std::ptrdiff_t(std::min(pairs.size(), kStrongestPairs));
  std::partial_sort(pairs.begin(), strongest, pairs.end(), [](const Pair& a, const Pair& b) {
    return std::abs(a.correlation) > std::abs(b.correlation);
  });
  std::string list;
  for (auto pair = pairs.begin(); pair != strongest; ++pair)
    list += (list.empty() ? "" : "; ") + in_words(*pair, names);
  const std::string drawing =
      svg(box(Vec2(-6, -4), Vec2(side + 150, side + 10)), "Correlation of the parameters", content);
  return figure(
      element("div", "class=\"scroll\"", "\n" + drawing) + "\n",
      "Correlation of the estimated parameters. A parameter's name stands at the end of its row and at the top "
      "of its column. Near 1 or −1 the views barely separate the two, and one sigma alone overstates what is "
      "unknown. Strongest: " +
          escaped(list) + ".",
      "class=\"matrix\"");
}

}  // namespace procam::report
