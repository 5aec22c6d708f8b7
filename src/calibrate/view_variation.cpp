#include "view_variation.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "joined.hpp"
#include "linearisation.hpp"
#include "procam/calibrate/costs/flexed.hpp"
#include "residual_blocks.hpp"
#include "shape.hpp"

namespace procam::calibrate {
namespace {

/// What detectors do alike to all points of a view is less, pixels.
constexpr double kVisibleChangePx = 0.01;
constexpr double kUsualField = 0.3;  ///< of an image's width: how far from its middle its points are

/// The curvature of a sheet that rises over half the print's diagonal by this share of the diagonal.
double curvature_of(const Points3& printed, double share) {
  const double diagonal = (printed.back() - printed.front()).norm();
  return 8 * share / diagonal;
}

/// A symmetric positive matrix of which the lower triangle is given, scaled to a unit diagonal; nullopt where it is singular.
struct Factors {
  VecX scale;
  Eigen::LLT<MatX> of_scaled;

  double log_determinant() const {
    return 2 * (of_scaled.matrixLLT().diagonal().array().log().sum() - scale.array().log().sum());
  }
  /// L^-1 right, where the matrix is L L^T.
  MatX half_solve(const MatX& right) const {
    return of_scaled.matrixL().solve(MatX(scale.asDiagonal() * right));
  }
};
std::optional<Factors> factors_of(const Eigen::Ref<const MatX>& lower) {
  Factors factors{lower.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse(), {}};
  factors.of_scaled.compute(MatX(factors.scale.asDiagonal() * lower * factors.scale.asDiagonal()));
  if (factors.of_scaled.info() != Eigen::Success ||
      !(factors.of_scaled.matrixLLT().diagonal().cwiseAbs2().minCoeff() > 1e-14))
    return std::nullopt;
  return factors;
}

/// The squared residuals as a function of what the views have of their own beside their boards' poses, the flex and the cameras'
/// image changes: u^T information u + 2 gradient . u + squares. Poses and common parameters are eliminated. The sizes that are
/// tried change the prior of u alone, so that a trial factors a matrix over the components it has.
struct VariationEquations {
  MatX information;
  VecX gradient;
  double squares = 0;
  double log_determinant = 0;     ///< of the common parameters' information
  std::vector<double> weight;     ///< by view that takes part
  std::vector<ImageSize> images;  ///< of the cameras
  double rows = 0;                ///< without the unknowns that are eliminated

  Eigen::Index own_size() const { return 3 + 3 * Eigen::Index(images.size()); }
};

/// rows^T rows over [common parameters, a view's own, residual], the poses eliminated.
struct ViewRows {
  MatX common;            ///< of all views and the priors, over [common parameters, residual]
  std::vector<MatX> own;  ///< by view that takes part: the own's rows over [common, own, residual]
  std::vector<VecX> value;
};

/// Fills in the quadratic function; false where the common parameters are not determined.
bool eliminate_common(const ViewRows& rows, VariationEquations& out) {
  const Eigen::Index n = rows.common.rows() - 1, own = out.own_size(),
                     all = own * Eigen::Index(rows.own.size());
  const auto factors = factors_of(rows.common.topLeftCorner(n, n));
  if (!factors) return false;
  out.log_determinant = factors->log_determinant();
  out.information = MatX::Zero(all, all);
  out.gradient = VecX(all);
  out.squares = rows.common(n, n);
  // Over [own of all views, residual], about own of zero instead of the solution's.
  MatX by_common(n, all + 1);
  by_common.col(all) = rows.common.col(n).head(n);
  for (std::size_t v = 0; v < rows.own.size(); ++v) {
    const Eigen::Index at = own * Eigen::Index(v);
    const auto of_common = rows.own[v].leftCols(n), of_own = rows.own[v].middleCols(n, own);
    const auto of_residual = rows.own[v].rightCols<1>();
    const VecX &value = rows.value[v], moved = of_own * value;
    by_common.middleCols(at, own) = of_common.transpose();
    by_common.col(all) -= of_common.transpose() * value;
    out.information.block(at, at, own, own) = of_own;
    out.gradient.segment(at, own) = of_residual - moved;
    out.squares += value.dot(moved - 2 * of_residual);
  }
  const MatX explained = factors->half_solve(by_common);
  out.information.selfadjointView<Eigen::Lower>().rankUpdate(explained.leftCols(all).transpose(), -1);
  out.gradient -= explained.leftCols(all).transpose() * explained.col(all);
  out.squares -= explained.col(all).squaredNorm();
  return true;
}

/// Two rows over [common parameters, own, residual]: which columns they have, and what is there.
std::pair<std::vector<Eigen::Index>, Eigen::Matrix2Xd> row_of(const Linearised& measured,
                                                              const std::vector<Eigen::Index>& taken,
                                                              Eigen::Index n) {
  const Eigen::Index common = Eigen::Index(measured.columns.size()), own = 3 * Eigen::Index(taken.size());
  std::vector<Eigen::Index> columns(measured.columns.begin(), measured.columns.end());
  for (Eigen::Index i = 0; i <= own; ++i) columns.push_back(n + i);
  Eigen::Matrix2Xd values(2, common + own + 1);
  values.leftCols(common) = measured.by_common;
  for (std::size_t i = 0; i < taken.size(); ++i)
    values.middleCols<3>(common + 3 * Eigen::Index(i)) = measured.by_view.middleCols<3>(taken[i]);
  values.rightCols<1>() = measured.residual;
  return {std::move(columns), std::move(values)};
}

/// `solution` with everything free that may vary.
std::optional<VariationEquations> equations_of(const Correspondences& data, const Solution& solution) {
  const BundleState& state = solution.state();
  const BundleOptions options = with_few_unknowns(data, solution.options);
  const CommonParameters common(data, solution.used, state, options);
  const Linearisation linearise(state, common);
  const Eigen::Index n = common.size();
  const std::vector<double> weights = view_weights(solution.used, options);
  const OwnOfView layout = own_of_view(options, data.devices.size());
  VariationEquations out;
  ViewRows rows;
  std::vector<Eigen::Index> taken{layout.flex_at};  // of the own: where three that count begin
  for (std::size_t d = 0; d < data.devices.size(); ++d)
    if (data.devices[d].kind == DeviceKind::kCamera) {
      taken.push_back(layout.images_at + 3 * Eigen::Index(d));
      out.images.push_back(state.lenses[d].size);
    }
  const Eigen::Index own = 3 * Eigen::Index(taken.size());
  rows.common = MatX::Zero(n + 1, n + 1);
  for (std::size_t v = 0; v < data.views.size(); ++v) {
    std::vector<Linearised> measured;
    for (std::size_t d = 0; d < data.devices.size(); ++d)
      for (const Measurement& m : measurements_of(data, int(v), int(d))) {
        if (!solution.used[v][d][std::size_t(m.index)]) continue;
        auto one = linearise(m, options);
        if (!one) return std::nullopt;
        measured.push_back(*std::move(one));
      }
    if (measured.size() < 5) continue;
    // Sum of row^T row, less the part within the span of the pose's columns, of which `within` is a basis. A row has few columns.
    MatX by_pose(Eigen::Index(2 * measured.size()), 6);
    for (std::size_t k = 0; k < measured.size(); ++k)
      by_pose.middleRows<2>(Eigen::Index(2 * k)) = measured[k].by_view.leftCols<6>();
    const MatX within =
        Eigen::HouseholderQR<MatX>(by_pose).householderQ() * MatX::Identity(by_pose.rows(), 6);
    MatX squares = MatX::Zero(n + own + 1, n + own + 1), spanned = MatX::Zero(6, n + own + 1);
    for (std::size_t k = 0; k < measured.size(); ++k) {
      const auto [columns, values] = row_of(measured[k], taken, n);
      const auto basis = within.middleRows<2>(Eigen::Index(2 * k));
      for (std::size_t i = 0; i < columns.size(); ++i) {
        spanned.col(columns[i]) += basis.transpose() * values.col(Eigen::Index(i));
        for (std::size_t j = 0; j < columns.size(); ++j)
          squares(columns[i], columns[j]) += values.col(Eigen::Index(i)).dot(values.col(Eigen::Index(j)));
      }
    }
    squares.noalias() -= spanned.transpose() * spanned;
    squares *= weights[v];
    rows.common.topLeftCorner(n, n) += squares.topLeftCorner(n, n);
    rows.common.topRightCorner(n, 1) += squares.topRightCorner(n, 1);
    rows.common.bottomLeftCorner(1, n) += squares.bottomLeftCorner(1, n);
    rows.common(n, n) += squares(n + own, n + own);
    rows.own.push_back(squares.middleRows(n, own));
    VecX value(own);
    for (std::size_t i = 0; i < taken.size(); ++i)
      value.segment<3>(3 * Eigen::Index(i)) = own_prior(state, options, v).value.segment<3>(taken[i] - 6);
    rows.value.push_back(std::move(value));
    out.weight.push_back(weights[v]);
    out.rows += weights[v] * double(by_pose.rows() - 6);
  }
  for (const PriorRow& prior : prior_rows(data, state, options, common)) {
    VecX row = VecX::Zero(n + 1);
    for (const auto& [column, derivative] : prior.by_common) row[column] = derivative;
    row[n] = prior.residual;
    rows.common += row * row.transpose();
  }
  out.rows -= double(common.devices_size);
  if (!eliminate_common(rows, out)) return std::nullopt;
  return out;
}

/// -2 ln of the restricted likelihood with the noise's size profiled out.
struct VariationTrial {
  double cost = std::numeric_limits<double>::infinity();
  double noise = 1;
};

/// `sizes` in units of the noise.
VariationTrial try_sizes(const VariationEquations& equations, const ViewVariation& sizes) {
  const Eigen::Index own = equations.own_size();
  std::vector<Eigen::Index> varies;  // of a view's own; the others are zero
  MatX whitening = MatX::Zero(own, own);
  if (sizes.flex > 0) {
    whitening.topLeftCorner<3, 3>() = flex_whitening(sizes.flex);
    varies = {0, 1, 2};
  }
  for (std::size_t camera = 0; camera < equations.images.size() && sizes.of_image(); ++camera) {
    const Eigen::Index at = 3 + 3 * Eigen::Index(camera);
    whitening.diagonal().segment<3>(at) = image_change_weights(sizes, equations.images[camera]);
    if (sizes.focus > 0) varies.push_back(at);
    varies.insert(varies.end(), {at + 1, at + 2});
  }
  const MatX of_own = whitening(varies, varies), prior = of_own.transpose() * of_own;
  const Eigen::Index each = Eigen::Index(varies.size());
  double log_determinant = equations.log_determinant, squares = equations.squares;
  if (each > 0) {
    std::vector<Eigen::Index> all;
    for (std::size_t v = 0; v < equations.weight.size(); ++v)
      for (const Eigen::Index i : varies) all.push_back(own * Eigen::Index(v) + i);
    MatX left = equations.information(all, all);
    // As a sum of logarithms: of thirty cameras, the determinant is beyond the largest number.
    const double of_prior = 2 * of_own.partialPivLu().matrixLU().diagonal().array().abs().log().sum();
    for (std::size_t v = 0; v < equations.weight.size(); ++v) {
      left.block(each * Eigen::Index(v), each * Eigen::Index(v), each, each) += equations.weight[v] * prior;
      log_determinant -= of_prior + double(each) * std::log(equations.weight[v]);
    }
    const auto factors = factors_of(left);
    if (!factors) return {};
    log_determinant += factors->log_determinant();
    squares -= factors->half_solve(VecX(equations.gradient(all))).squaredNorm();
  }
  if (!(squares > 0)) return {};
  return {equations.rows * std::log(squares) + log_determinant, std::sqrt(squares / equations.rows)};
}

/// One of the sizes and where it is looked for.
struct Component {
  double ViewVariation::*size;
  double low, high;
  double smallest;  ///< to be taken, in the data's units
};

class SizeSearch {
 public:
  explicit SizeSearch(const VariationEquations& equations) : equations_(equations) {}

  /// Sizes in the data's units, and how likely they are: the cost, with what each must gain.
  struct Found {
    ViewVariation sizes;
    double cost = std::numeric_limits<double>::infinity();
  };

  /// One after the other, the most likely first; those of a later stage after all others.
  Found most_likely(const std::vector<std::vector<Component>>& stages) const {
    Sized best = tried({});
    std::vector<Component> taken;
    for (std::vector<Component> candidates : stages)
      while (!candidates.empty() && std::isfinite(best.trial.cost)) {
        std::optional<Sized> next;
        std::size_t which = 0;
        for (std::size_t i = 0; i < candidates.size(); ++i) {
          const Sized sized = refined(searched(best, candidates[i]), candidates[i]);
          if (next && !(sized.trial.cost < next->trial.cost)) continue;
          next = sized;
          which = i;
        }
        if (!(best.trial.cost - next->trial.cost >= kGain)) break;
        const Component component = candidates[which];
        candidates.erase(candidates.begin() + long(which));
        // Beside a change that is visible, a smaller one of the other kind counts as well.
        if (!best.sizes.of_image() && next->trial.noise * next->sizes.*component.size < component.smallest)
          continue;
        best = *next;
        taken.push_back(component);
        for (int round = 0; round < 2 && taken.size() > 1; ++round)
          for (const Component& one : taken) best = refined(best, one);
      }
    // One that was taken for another.
    for (const Component& component : taken) {
      ViewVariation without = best.sizes;
      without.*component.size = 0;
      Sized rest = tried(without);
      for (const Component& other : taken) rest = refined(rest, other);
      if (rest.trial.cost - best.trial.cost < kGain) best = rest;
    }
    Found found{best.sizes, best.trial.cost};
    for (const Component& component : taken) {
      if (found.sizes.*component.size > 0) found.cost += kGain;
      found.sizes.*component.size *= best.trial.noise;
    }
    return found;
  }

 private:
  static constexpr double kGain = 16;  ///< of 2 ln of the likelihood

  struct Sized {
    ViewVariation sizes;
    VariationTrial trial;
  };

  Sized tried(const ViewVariation& sizes) const { return {sizes, try_sizes(equations_, sizes)}; }

  Sized with(const Sized& others, const Component& component, double size) const {
    ViewVariation sizes = others.sizes;
    sizes.*component.size = size;
    return tried(sizes);
  }

  Sized searched(const Sized& others, const Component& component) const {
    Sized best = others;
    for (double size = component.low; size < component.high; size *= 3) {
      const Sized sized = with(others, component, size);
      if (sized.trial.cost < best.trial.cost) best = sized;
    }
    return best;
  }

  /// By smaller and smaller factors.
  Sized refined(Sized best, const Component& component) const {
    for (double factor = 1.8; factor > 1.05; factor = std::sqrt(factor))
      for (const double by : {factor, 1 / factor}) {
        if (!(best.sizes.*component.size > 0)) continue;
        const Sized sized = with(best, component, by * best.sizes.*component.size);
        if (sized.trial.cost < best.trial.cost) best = sized;
      }
    return best;
  }

  const VariationEquations& equations_;
};

}  // namespace

ViewVariation loose_variation(const Points3& printed) {
  return {curvature_of(printed, 0.005), 1e-3, 1};
}

void free_variation(const ViewVariation& sizes, BundleState& state, BundleOptions& options) {
  options.variation = sizes;
  const std::size_t views = state.rig_from_board.size();
  if (sizes.flex > 0 && state.flex.empty()) state.flex.assign(views, Vec3::Zero());
  if (sizes.of_image() && state.image_changes.empty())
    state.image_changes.assign(views, std::vector<Vec3>(state.lenses.size(), Vec3::Zero()));
}

ViewVariation most_likely_variation(const Correspondences& data, const Solution& solution, MayVary may) {
  const Points3 printed = points_in_board(data.board);
  Solution free = solution;
  ViewVariation sizes = loose_variation(printed);
  for (double ViewVariation::*size : {&ViewVariation::flex, &ViewVariation::focus, &ViewVariation::shift_px})
    if (solution.options.variation.*size > 0) sizes.*size = solution.options.variation.*size;
  free_variation(sizes, free.bundle.state, free.options);
  for (std::size_t v = 0; v < free.rejected.size(); ++v)
    if (std::count(free.rejected[v].begin(), free.rejected[v].end(), char(1)) > 0)
      for (std::vector<char>& of_device : free.used[v])
        std::fill(of_device.begin(), of_device.end(), char(0));
  free.options.board_sigma = std::max(free.options.board_sigma, sheet_sigma(printed));
  const auto equations = equations_of(data, free);
  if (!equations || !(equations->rows > 0) || equations->weight.empty()) return {};
  const double width = data.devices.front().size.width;
  const Component flex{&ViewVariation::flex, curvature_of(printed, 1e-6), curvature_of(printed, 0.1), 0};
  const Component focus{&ViewVariation::focus, 1e-6, 0.05, kVisibleChangePx / (kUsualField * width)};
  const Component shift{&ViewVariation::shift_px, 1e-3, 100, kVisibleChangePx};
  const std::vector<Component> sheet = may.sheet ? std::vector<Component>{flex} : std::vector<Component>{};
  const auto first = [&](const Component& one, const Component& last) {
    std::vector<Component> together = sheet;
    together.push_back(one);
    return std::vector<std::vector<Component>>{together, {last}};
  };
  const SizeSearch search(*equations);
  if (!may.images) return search.most_likely({sheet}).sizes;
  // A change of focus displaces images as well, and explains a displacement.
  const SizeSearch::Found displaced = search.most_likely(first(shift, focus));
  if (!displaced.sizes.of_image()) return displaced.sizes;
  const SizeSearch::Found focused = search.most_likely(first(focus, shift));
  return focused.cost < displaced.cost ? focused.sizes : displaced.sizes;
}

double flex_rms(const Correspondences& data, const Solution& solution) {
  const BundleState& state = solution.state();
  double squares = 0, count = 0;
  for (std::size_t v = 0; v < data.views.size() && !state.flex.empty(); ++v) {
    const BentSheet flex{state.flex[v], state.sheet.centre};
    double sum = 0, of_squares = 0, points = 0;
    for (std::size_t d = 0; d < data.devices.size(); ++d)
      for (const Measurement& m : measurements_of(data, int(v), int(d))) {
        if (!solution.used[v][d][std::size_t(m.index)]) continue;
        Vec3 place;
        if (m.light != nullptr) {
          const auto in_rig = place_in_rig(state, int(v), *m.light);
          if (!in_rig) continue;
          place = state.rig_from_board[v].inverse() * *in_rig;
        } else {
          place = state.points_in_board[std::size_t(m.observation->point)];
        }
        const double height = flex.height(place.head<2>());
        sum += height, of_squares += height * height, ++points;
      }
    if (points > 0) squares += of_squares - sum * sum / points;
    count += points;
  }
  return count > 0 ? std::sqrt(squares / count) : 0;
}

std::vector<ImageChange> image_change_rms(const Correspondences& data, const Solution& solution) {
  std::vector<ImageChange> all(data.devices.size());
  const BundleState& state = solution.state();
  for (std::size_t d = 0; d < data.devices.size() && !state.image_changes.empty(); ++d) {
    Vec3 sum = Vec3::Zero(), squares = Vec3::Zero();
    double views = 0;
    for (std::size_t v = 0; v < data.views.size(); ++v) {
      if (count_used(solution.used, v, d) == 0) continue;
      const Vec3& change = state.image_changes[v][d];
      sum += change, squares += change.cwiseAbs2(), ++views;
    }
    if (views == 0) continue;
    const Vec3 variance = (squares / views - (sum / views).cwiseAbs2()).cwiseMax(0);
    if (solution.options.variation.focus > 0) all[d].focus_rms = std::sqrt(variance[0]);
    if (solution.options.variation.shift_px > 0)
      all[d].shift_rms_px = std::sqrt(0.5 * (variance[1] + variance[2]));
  }
  return all;
}

double displacement_px(const ImageChange& change, ImageSize image) {
  return std::hypot(change.shift_rms_px, kUsualField * image.width * change.focus_rms);
}

}  // namespace procam::calibrate
