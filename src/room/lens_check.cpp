#include "lens_check.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "procam/core/geometry/se3.hpp"

namespace procam::room {
namespace {

/// Covariance of a lens' free parameters by its priors alone, zero for those that are fixed.
MatX prior_covariance(const LensPlan& plan, int lens) {
  const std::vector<char>& free = plan.free[std::size_t(lens)];
  std::vector<int> at(free.size(), -1);
  int size = 0;
  for (std::size_t i = 0; i < free.size(); ++i)
    if (free[i]) at[i] = size++;
  MatX information = MatX::Zero(size, size);
  for (const LensKnowledge& known : plan.known) {
    if (known.lens != lens) continue;
    for (const auto& [i, a] : known.terms)
      for (const auto& [j, b] : known.terms)
        if (at[std::size_t(i)] >= 0 && at[std::size_t(j)] >= 0)
          information(at[std::size_t(i)], at[std::size_t(j)]) += a * b / (known.sigma * known.sigma);
  }
  MatX out = MatX::Zero(Eigen::Index(free.size()), Eigen::Index(free.size()));
  if (size == 0) return out;
  const VecX unit = information.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const MatX inverse =
      unit.asDiagonal() *
      MatX(unit.asDiagonal() * information * unit.asDiagonal()).ldlt().solve(MatX::Identity(size, size)) *
      unit.asDiagonal();
  for (std::size_t i = 0; i < free.size(); ++i)
    for (std::size_t j = 0; j < free.size(); ++j)
      if (at[i] >= 0 && at[j] >= 0) out(Eigen::Index(i), Eigen::Index(j)) = inverse(at[i], at[j]);
  return out;
}

AdjustOptions freed_options(const LensPlan& plan, const RoomState& state, int threads) {
  AdjustOptions options;
  options.free = plan.free;
  options.known = knowledge_at(plan, state);
  options.threads = threads;
  options.robust_sigmas = 0;
  options.max_iterations = 80;
  return options;
}

void linearise(const Adjustment& adjustment, const PointsInUse& in_use, FreedRig& rig) {
  const double scale = std::max(1e-6, in_use.scatter);
  rig.layout = adjustment.layout(rig.state);
  rig.covariance = adjustment.covariance(rig.state, rig.layout, scale);
  const Normal normal = adjustment.normal(rig.state, rig.layout, 0);
  rig.information = (normal.information - normal.prior) / (scale * scale) + normal.prior;
}

/// Of what is in use one in `stride`, the first of all included.
std::vector<char> every_one_in(std::size_t stride, const std::vector<char>& used) {
  std::vector<char> few(used.size(), 0);
  std::size_t seen = 0;
  for (std::size_t i = 0; i < used.size(); ++i)
    if (used[i] && seen++ % stride == 0) few[i] = 1;
  return few;
}

}  // namespace

RoomState along_focal_length(const RoomPoints& points, const LensPlan& plan, const std::vector<char>& chosen,
                             const RoomState& given, const std::vector<char>& used, int threads) {
  constexpr std::size_t kPoints = 1500;
  constexpr double kStep = 0.05;
  constexpr int kSteps = 10, kFewest = 4;
  AdjustOptions options;
  options.free = plan.free;
  options.threads = threads;
  options.max_iterations = 25;
  options.robust_sigmas = 0;
  for (std::size_t lens = 0; lens < chosen.size(); ++lens)
    if (chosen[lens]) options.free[lens][0] = options.free[lens][1] = 0;
  const auto count = std::size_t(std::count_if(used.begin(), used.end(), [](char use) { return use != 0; }));
  const std::size_t stride = std::max<std::size_t>(1, count / kPoints);
  const std::vector<char> few = every_one_in(stride, used);

  struct Trial {
    RoomState state;
    double cost = 0;
  };
  const auto try_at = [&](const RoomState& from, double factor) {
    Trial out{from, 0};
    for (std::size_t lens = 0; lens < chosen.size(); ++lens) {
      if (!chosen[lens]) continue;
      Intrinsics& k = out.state.lenses[lens].intrinsics;
      k.fx *= factor;
      k.fy *= factor;
      const double sigma = std::sqrt(std::max(prior_covariance(plan, int(lens))(0, 0), 1e-300));
      out.cost += std::pow((k.fx - plan.lenses[lens].intrinsics.fx) / sigma, 2);
    }
    options.known = knowledge_at(plan, out.state);
    Adjustment adjustment(points, options);
    adjustment.used = few;
    adjustment.solve(out.state);
    out.cost += adjustment.cost(out.state) * double(count) /
                double(std::max<std::size_t>(1, (count + stride - 1) / stride));
    return out;
  };
  // Some steps to both sides in any case: where bundle adjustment follows the valley slowly, the cost of the next step may seem
  // higher though the minimum is beyond it.
  const double up = 1 + kStep;
  std::vector<Trial> line{try_at(given, 1)};
  std::size_t least = 0;
  for (const bool grow : {true, false}) {
    for (int step = 1; step <= kSteps; ++step) {
      const std::size_t end = grow ? line.size() - 1 : 0;
      if (step > kFewest && least != end) break;
      Trial next = try_at(line[end].state, grow ? up : 1 / up);
      line.insert(grow ? line.end() : line.begin(), std::move(next));
      if (!grow) ++least;
      const std::size_t added = grow ? line.size() - 1 : 0;
      if (line[added].cost < line[least].cost) least = added;
    }
  }
  const Trial& best = line[least];
  // The minimum of the parabola through three, in steps of log(focal length).
  double at = 0;
  if (least > 0 && least + 1 < line.size()) {
    const double shorter = line[least - 1].cost, longer = line[least + 1].cost,
                 bend = longer + shorter - 2 * best.cost;
    if (bend > 0) at = std::clamp(0.5 * (shorter - longer) / bend, -1.0, 1.0);
  }
  Trial last = try_at(best.state, std::pow(up, at));
  RoomState state = last.cost < best.cost ? std::move(last.state) : best.state;
  const Adjustment adjustment(points, options);
  for (std::size_t i = 0; i < used.size(); ++i)
    if (!few[i] && std::isfinite(state.inverse_depth[i]) && !adjustment.refine_depth(state, int(i)))
      adjustment.start_depth(state, int(i));
  return state;
}

FreedRig free_lenses(const RoomPoints& points, const LensPlan& plan, const std::vector<char>& chosen,
                     const RoomState& given, const PointsInUse& in_use, int threads) {
  FreedRig out = open_lenses(points, plan, given, in_use, threads);
  out.state = along_focal_length(points, plan, chosen, out.state, in_use.used, threads);
  AdjustOptions options = freed_options(plan, out.state, threads);
  Adjustment adjustment(points, options);
  adjustment.used = in_use.used;
  adjustment.solve(out.state);
  linearise(adjustment, in_use, out);
  return out;
}

FreedRig open_lenses(const RoomPoints& points, const LensPlan& plan, const RoomState& given,
                     const PointsInUse& in_use, int threads) {
  FreedRig out{given, {}, {}, {}};
  for (std::size_t lens = 0; lens < plan.lenses.size(); ++lens)
    if (!plan.guess[lens]) out.state.lenses[lens] = with_distortion(given.lenses[lens]);
  Adjustment adjustment(points, freed_options(plan, out.state, threads));
  adjustment.used = in_use.used;
  linearise(adjustment, in_use, out);
  return out;
}

std::optional<LensDisagreement> disagreement(const LensPlan& plan, const FreedRig& freed,
                                             const std::vector<char>& chosen) {
  constexpr double kDoubt = 3, kMaterial = 0.005;
  std::optional<LensDisagreement> worst;
  for (std::size_t lens = 0; lens < chosen.size(); ++lens) {
    if (!chosen[lens] || plan.guess[lens]) continue;
    const Camera known = with_distortion(plan.lenses[lens]);
    const VecX off = parameters_of(freed.state.lenses[lens]) - parameters_of(known);
    const MatX stated = prior_covariance(plan, int(lens));
    const Intrinsics& k = known.intrinsics;
    const double corner = k.normalized_from_pixel(Vec2(-0.5, -0.5)).squaredNorm();
    const auto material = [&](int i) {
      if (i < 2) return std::abs(off[i]) > kMaterial * k.fx;
      if (i < 4) return std::abs(off[i]) > kMaterial * known.size.width;
      if (i == 5) return std::abs(off[i]) * corner > kMaterial;
      if (i == 6) return std::abs(off[i]) * corner * corner > kMaterial;
      return false;
    };
    for (int i = 0; i < int(off.size()); ++i) {
      const int column = freed.layout.lens[lens][std::size_t(i)];
      if (column < 0 || i == 1 || !material(i)) continue;
      const double variance = freed.covariance(column, column) + (i < stated.rows() ? stated(i, i) : 0.0);
      const double sigma = std::sqrt(std::max(variance, 1e-300));
      if (std::abs(off[i]) > kDoubt * sigma &&
          (!worst || std::abs(off[i]) / sigma > std::abs(worst->off) / worst->sigma))
        worst = LensDisagreement{int(lens), i, off[i], sigma};
    }
  }
  return worst;
}

std::optional<LensDisagreement> departure(const LensPlan& plan, const RoomState& state,
                                          const std::vector<char>& chosen) {
  constexpr double kDoubt = 4.5;
  std::optional<LensDisagreement> worst;
  for (std::size_t lens = 0; lens < chosen.size(); ++lens) {
    if (!chosen[lens]) continue;
    const VecX off = parameters_of(state.lenses[lens]) - parameters_of(plan.lenses[lens]);
    const MatX stated = prior_covariance(plan, int(lens));
    for (const int i : {0, 2, 3, 5, 6}) {
      if (i >= int(off.size()) || !plan.free[lens][std::size_t(i)]) continue;
      const double sigma = std::sqrt(stated(i, i));
      if (std::abs(off[i]) > kDoubt * sigma &&
          (!worst || std::abs(off[i]) / sigma > std::abs(worst->off) / worst->sigma))
        worst = LensDisagreement{int(lens), i, off[i], sigma};
    }
  }
  return worst;
}

MatX kept_covariance(const FreedRig& freed, const RoomState& given) {
  VecX off = VecX::Zero(freed.layout.size);
  for (std::size_t lens = 0; lens < freed.layout.lens.size(); ++lens) {
    const VecX difference =
        parameters_of(with_distortion(given.lenses[lens])) - parameters_of(freed.state.lenses[lens]);
    for (std::size_t i = 0; i < freed.layout.lens[lens].size(); ++i)
      if (const int column = freed.layout.lens[lens][i]; column >= 0)
        off[column] = difference[Eigen::Index(i)];
  }
  for (std::size_t pose = 0; pose < freed.layout.pose.size(); ++pose)
    if (const int column = freed.layout.pose[pose]; column >= 0)
      off.segment<6>(column) =
          se3_log(given.rig_from_device[pose] * freed.state.rig_from_device[pose].inverse());
  return freed.covariance + off * off.transpose();
}

MatX considered_covariance(const LensPlan& wide, const FreedRig& freed, const Layout& given_layout,
                           const MatX& given_covariance) {
  // Columns of the freed layout: those that the given layout has as well, and those of the considered lenses.
  std::vector<int> common, common_given, considered;
  MatX prior = MatX::Zero(freed.layout.size, freed.layout.size);
  for (std::size_t lens = 0; lens < freed.layout.lens.size(); ++lens) {
    const std::vector<int>& columns = freed.layout.lens[lens];
    std::vector<int> own;
    for (std::size_t i = 0; i < columns.size(); ++i) {
      if (columns[i] < 0) continue;
      const int before = i < given_layout.lens[lens].size() ? given_layout.lens[lens][i] : -1;
      if (before >= 0) {
        common.push_back(columns[i]);
        common_given.push_back(before);
      } else {
        considered.push_back(columns[i]);
        own.push_back(int(i));
      }
    }
    if (own.empty()) continue;
    const MatX covariance = prior_covariance(wide, int(lens));
    for (const int i : own)
      for (const int j : own) prior(columns[std::size_t(i)], columns[std::size_t(j)]) = covariance(i, j);
  }
  for (std::size_t pose = 0; pose < freed.layout.pose.size(); ++pose)
    for (int i = 0; i < 6 && freed.layout.pose[pose] >= 0; ++i) {
      common.push_back(freed.layout.pose[pose] + i);
      common_given.push_back(given_layout.pose[pose] + i);
    }
  const Eigen::Index n = Eigen::Index(common.size()), m = Eigen::Index(considered.size());
  MatX h_pp(n, n), h_pl(n, m), p(m, m), c(n, n);
  for (Eigen::Index r = 0; r < n; ++r) {
    for (Eigen::Index k = 0; k < n; ++k) {
      h_pp(r, k) = freed.information(common[std::size_t(r)], common[std::size_t(k)]);
      c(r, k) = given_covariance(common_given[std::size_t(r)], common_given[std::size_t(k)]);
    }
    for (Eigen::Index k = 0; k < m; ++k)
      h_pl(r, k) = freed.information(common[std::size_t(r)], considered[std::size_t(k)]);
  }
  for (Eigen::Index r = 0; r < m; ++r)
    for (Eigen::Index k = 0; k < m; ++k)
      p(r, k) = prior(considered[std::size_t(r)], considered[std::size_t(k)]);
  const VecX unit = h_pp.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const MatX sensitivity =
      -(unit.asDiagonal() *
        MatX(unit.asDiagonal() * h_pp * unit.asDiagonal()).ldlt().solve(MatX(unit.asDiagonal() * h_pl)));
  MatX out = MatX::Zero(freed.layout.size, freed.layout.size);
  const MatX common_part = c + sensitivity * p * sensitivity.transpose(), cross = sensitivity * p;
  for (Eigen::Index r = 0; r < n; ++r) {
    for (Eigen::Index k = 0; k < n; ++k)
      out(common[std::size_t(r)], common[std::size_t(k)]) = common_part(r, k);
    for (Eigen::Index k = 0; k < m; ++k)
      out(common[std::size_t(r)], considered[std::size_t(k)]) =
          out(considered[std::size_t(k)], common[std::size_t(r)]) = cross(r, k);
  }
  for (Eigen::Index r = 0; r < m; ++r)
    for (Eigen::Index k = 0; k < m; ++k)
      out(considered[std::size_t(r)], considered[std::size_t(k)]) = p(r, k);
  return out;
}

}  // namespace procam::room
