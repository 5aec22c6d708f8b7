#include "adjust.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "adjust_rows.hpp"
#include "procam/core/base/parallel.hpp"
#include "procam/core/base/stats.hpp"
#include "procam/core/geometry/se3.hpp"

namespace procam::room {
namespace {

constexpr double kScaleSigma = 1e-7;  // of the fixed distance: exact, and the system stays well conditioned
constexpr int kParts = 64;            // of the points; sums over them do not depend on the threads
constexpr int kTogether = 64;         // depths eliminated in one product

/// The step of Levenberg and Marquardt, the parameters scaled to a unit diagonal.
VecX damped_step(const Normal& system, double damping) {
  const VecX diagonal = system.information.diagonal().cwiseMax(1e-12);
  const VecX unit = diagonal.cwiseSqrt().cwiseInverse();
  MatX scaled = unit.asDiagonal() * system.information * unit.asDiagonal();
  scaled.diagonal().array() += damping;
  return -(unit.asDiagonal() * scaled.ldlt().solve(unit.asDiagonal() * system.gradient));
}

}  // namespace

Adjustment::Adjustment(const RoomPoints& points, const AdjustOptions& options)
    : used(points.points.size(), 1), points_(points), options_(options) {}

Layout Adjustment::layout(const RoomState& state) const {
  Layout out;
  out.lens.resize(state.lenses.size());
  for (std::size_t l = 0; l < state.lenses.size(); ++l) {
    bool in_use = false;
    for (std::size_t p = 0; p < points_.positions.size(); ++p)
      in_use |= state.solved[p] && std::size_t(camera_lens(int(p))) == l;
    for (std::size_t p = 0; p < points_.projectors.size(); ++p)
      in_use |= state.solved[std::size_t(projector_pose(int(p)))] && std::size_t(projector_lens(int(p))) == l;
    out.lens[l].assign(options_.free[l].size(), -1);
    for (std::size_t i = 0; in_use && i < out.lens[l].size(); ++i)
      if (options_.free[l][i]) out.lens[l][i] = out.size++;
  }
  out.pose.assign(state.rig_from_device.size(), -1);
  double farthest = 0;
  const auto first =
      std::size_t(std::find(state.solved.begin(), state.solved.end(), 1) - state.solved.begin());
  for (std::size_t i = first + 1; i < out.pose.size(); ++i) {
    if (!state.solved[i]) continue;
    out.pose[i] = out.size;
    out.size += 6;
    const double distance = state.rig_from_device[i].translation.norm();
    if (distance > farthest) farthest = distance, out.scale_pose = int(i);
  }
  return out;
}

double Adjustment::prior_cost(const RoomState& state, const Layout& layout, Normal* normal) const {
  double cost = 0;
  for (const LensKnowledge& known : options_.known) {
    const VecX values = parameters_of(state.lenses[std::size_t(known.lens)]);
    double off = -known.value;
    bool free = false;
    for (const auto& [index, weight] : known.terms) {
      off += weight * values[index];
      free |= layout.lens[std::size_t(known.lens)][std::size_t(index)] >= 0;
    }
    if (!free) continue;
    off /= known.sigma;
    cost += off * off;
    if (normal == nullptr) continue;
    for (const auto& [i, weight_i] : known.terms) {
      const int row = layout.lens[std::size_t(known.lens)][std::size_t(i)];
      if (row < 0) continue;
      normal->gradient[row] += weight_i / known.sigma * off;
      for (const auto& [j, weight_j] : known.terms)
        if (const int column = layout.lens[std::size_t(known.lens)][std::size_t(j)]; column >= 0)
          normal->prior(row, column) += weight_i * weight_j / (known.sigma * known.sigma);
    }
  }
  if (layout.scale_pose >= 0 && normal != nullptr) {
    const Vec3& t = state.rig_from_device[std::size_t(layout.scale_pose)].translation;
    const int first = layout.pose[std::size_t(layout.scale_pose)] + 3;
    const double sigma = kScaleSigma * t.norm();
    const Vec3 along = t.normalized() / sigma;
    normal->prior.block<3, 3>(first, first) += along * along.transpose();
  }
  return cost;
}

Normal Adjustment::normal(const RoomState& state, const Layout& layout, double loss_square) const {
  const int count = int(points_.points.size());
  std::vector<Normal> parts(kParts);
  parallel_each(kParts, options_.threads, [&](int part) {
    Normal& sum = parts[std::size_t(part)];
    sum.information = MatX::Zero(layout.size, layout.size);
    sum.gradient = VecX::Zero(layout.size);
    Rows rows;
    // What the depths take away, a matrix of rank one each, some at a time.
    MatX crosses(layout.size, kTogether);
    int filled = 0;
    const auto subtract = [&] {
      if (filled > 0)
        sum.information.selfadjointView<Eigen::Lower>().rankUpdate(crosses.leftCols(filled), -1);
      filled = 0;
    };
    for (int i = int(long(count) * part / kParts); i < int(long(count) * (part + 1) / kParts); ++i) {
      if (!used[std::size_t(i)] || !linearise(state, layout, i, rows)) continue;
      const DepthRows depth = rows.by_depth();
      const double weight = loss_square > 0 ? std::pow(loss_square / (loss_square + depth.square), 2) : 1;
      sum.cost += loss_square > 0 ? loss_square * depth.square / (loss_square + depth.square) : depth.square;
      if (!(depth.curvature > 0)) continue;
      rows.add_information(sum.information, weight);
      rows.add_gradient(sum.gradient, depth, weight);
      const double share = std::sqrt(weight / depth.curvature);
      crosses.col(filled).setZero();
      rows.add_product(crosses.col(filled), [&](const ReadingRows& r) { return Vec2(share * r.by_depth); });
      if (++filled == kTogether) subtract();
    }
    subtract();
  });
  Normal out;
  out.information = MatX::Zero(layout.size, layout.size);
  out.gradient = VecX::Zero(layout.size);
  out.prior = MatX::Zero(layout.size, layout.size);
  for (const Normal& part : parts) {
    out.information += part.information;
    out.gradient += part.gradient;
    out.cost += part.cost;
  }
  out.information = MatX(out.information.selfadjointView<Eigen::Lower>());
  out.cost += prior_cost(state, layout, &out);
  out.information += out.prior;
  return out;
}

double Adjustment::cost(const RoomState& state, const Layout& layout, double loss_square) const {
  const int count = int(points_.points.size());
  std::vector<double> parts(kParts);
  parallel_each(kParts, options_.threads, [&](int part) {
    for (int i = int(long(count) * part / kParts); i < int(long(count) * (part + 1) / kParts); ++i) {
      if (!used[std::size_t(i)] || !std::isfinite(state.inverse_depth[std::size_t(i)])) continue;
      const std::optional<DepthRows> seen = depth_rows(state, i);
      // A point that a device cannot see costs as much as any outlier: it never scores zero.
      const double square = seen ? seen->square : 1e12;
      parts[std::size_t(part)] += loss_square > 0 ? loss_square * square / (loss_square + square) : square;
    }
  });
  double sum = prior_cost(state, layout, nullptr);
  for (const double part : parts) sum += part;
  return sum;
}

double Adjustment::scatter(const RoomState& state) const {
  std::vector<double> values(points_.points.size(), -1);
  parallel_for(int(values.size()), options_.threads, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      if (!used[std::size_t(i)]) continue;
      const PointFit point = fit(state, i);
      if (point.freedom < 1) continue;
      const double k = point.freedom;
      // over the median of chi-square
      values[std::size_t(i)] = point.square / (k * std::pow(1 - 2 / (9 * k), 3));
    }
  });
  values.erase(std::remove_if(values.begin(), values.end(), [](double value) { return value < 0; }),
               values.end());
  return values.empty() ? 1 : std::sqrt(median(values));
}

std::optional<Adjustment::DepthGradient> Adjustment::depth_gradient(const RoomState& state,
                                                                    const Layout& layout, int point,
                                                                    bool only_anchor) const {
  Rows rows;
  if (!linearise(state, layout, point, rows, only_anchor)) return std::nullopt;
  const double w = state.inverse_depth[std::size_t(point)], curvature = rows.by_depth().curvature;
  if (!(curvature > 0) || !(w > 0)) return std::nullopt;
  DepthGradient out{VecX::Zero(layout.size), 1 / (std::sqrt(curvature) * w)};
  // dw = -cross / curvature, dlog z = -dw / w
  rows.add_product(out.by_parameters,
                   [&](const ReadingRows& r) { return Vec2(r.by_depth / (curvature * w)); });
  return out;
}

RoomState Adjustment::moved(const RoomState& state, const Layout& layout, const VecX& step) const {
  RoomState out = state;
  for (std::size_t l = 0; l < layout.lens.size(); ++l) {
    VecX values = parameters_of(out.lenses[l]);
    for (std::size_t i = 0; i < layout.lens[l].size(); ++i)
      if (layout.lens[l][i] >= 0) values[Eigen::Index(i)] += step[layout.lens[l][i]];
    out.lenses[l] = with_parameters(out.lenses[l], values);
  }
  for (std::size_t p = 0; p < layout.pose.size(); ++p)
    if (layout.pose[p] >= 0)
      out.rig_from_device[p] =
          (se3_exp<double>(Vec6(step.segment<6>(layout.pose[p]))) * out.rig_from_device[p]).normalized();
  return out;
}

void Adjustment::settle_depths(RoomState& state) const {
  parallel_for(int(points_.points.size()), options_.threads, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      if (!used[std::size_t(i)] || !std::isfinite(state.inverse_depth[std::size_t(i)])) continue;
      for (int k = 0; k < 2; ++k) {
        const std::optional<DepthRows> rows = depth_rows(state, i);
        if (!rows || !(rows->curvature > 0)) break;
        double& w = state.inverse_depth[std::size_t(i)];
        w = std::clamp(w - rows->slope / rows->curvature, 0.3 * w, 3 * w);
      }
    }
  });
}

double Adjustment::solve(RoomState& state) const {
  const Layout layout = this->layout(state);
  double scale = std::max(scatter(state), 1e-6);
  const auto loss_of = [&](double s) {
    return options_.robust_sigmas > 0 ? std::pow(options_.robust_sigmas * s, 2) : 0;
  };
  double loss = loss_of(scale), damping = 1e-3;
  double current = cost(state, layout, loss);
  int still = 0;
  for (int iteration = 0; iteration < options_.max_iterations; ++iteration) {
    const Normal system = normal(state, layout, loss);
    bool improved = false;
    for (int attempt = 0; attempt < 8 && !improved; ++attempt) {
      const VecX step = damped_step(system, damping);
      if (!step.allFinite()) {
        damping *= 10;
        continue;
      }
      RoomState next = moved(state, layout, step);
      settle_depths(next);
      const double trial = cost(next, layout, loss);
      if (trial < current) {
        improved = true;
        still = trial > current * (1 - 1e-7) ? still + 1 : 0;
        current = trial;
        state = std::move(next);
        damping = std::max(damping * 0.2, 1e-12);
      } else {
        damping *= 8;
      }
    }
    const double now = std::max(scatter(state), 1e-6);
    if (!improved || still >= 2) {
      if (std::abs(now / scale - 1) < 0.02 || !(options_.robust_sigmas > 0)) break;
      still = 0;
      damping = 1e-4;
    }
    if (options_.robust_sigmas > 0 && now < scale) {
      scale = now;
      loss = loss_of(scale);
      current = cost(state, layout, loss);
    } else if (!improved) {
      break;
    }
  }
  return scatter(state);
}

int Adjustment::region(const LightReading& reading) const {
  const int position = points_.maps[std::size_t(reading.map)].position;
  const ImageSize size = points_.cameras[std::size_t(points_.positions[std::size_t(position)].camera)].size;
  const auto cell = [](double at, int pixels, int cells) {
    return std::clamp(int(cells * at / pixels), 0, cells - 1);
  };
  return (reading.map * kRegionRows + cell(reading.camera_pixel.y(), size.height, kRegionRows)) *
             kRegionColumns +
         cell(reading.camera_pixel.x(), size.width, kRegionColumns);
}

MatX Adjustment::covariance(const RoomState& state, const Layout& layout, double scale) const {
  const Normal system = normal(state, layout, 0);
  const MatX data = (system.information - system.prior) / (scale * scale);
  const MatX bread = data + system.prior;
  const VecX unit = bread.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const MatX inverse = unit.asDiagonal() *
                       MatX(unit.asDiagonal() * bread * unit.asDiagonal())
                           .ldlt()
                           .solve(MatX::Identity(layout.size, layout.size)) *
                       unit.asDiagonal();
  MatX pulls = MatX::Zero(layout.size, Eigen::Index(points_.maps.size()) * kRegionColumns * kRegionRows);
  Rows rows;
  for (int i = 0; i < int(points_.points.size()); ++i) {
    if (!used[std::size_t(i)] || !linearise(state, layout, i, rows)) continue;
    const DepthRows depth = rows.by_depth();
    if (depth.curvature > 0) rows.add_gradient_by_region(pulls, depth, 1 / (scale * scale));
  }
  // The fit has taken part of the pull away: as many regions' worth as it has parameters.
  const double regions = double((pulls.colwise().squaredNorm().array() > 0).count());
  const double left = std::max(1.0, regions - layout.size);
  const MatX meat = pulls * pulls.transpose() * (regions / left) + system.prior;
  const MatX robust = inverse * meat * inverse;
  // By parameter the larger of both, correlations as the robust one has them.
  VecX stretch = VecX::Ones(layout.size);
  for (int i = 0; i < layout.size; ++i)
    if (robust(i, i) > 0) stretch[i] = std::sqrt(std::max(1.0, inverse(i, i) / robust(i, i)));
  return stretch.asDiagonal() * robust * stretch.asDiagonal();
}

}  // namespace procam::room
