#include "exchanged_steps.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace procam::pattern::internal {
namespace {

/// A wave's frames, and projectors onto the plane of its cosines.
struct Basis {
  std::vector<int> frames;
  Eigen::MatrixX3f model;  ///< orthonormal; the first column is constant for equal steps only
};

Basis basis_of(const Wave& wave) {
  Basis basis;
  basis.frames = wave.frames;
  const Eigen::Index n = Eigen::Index(wave.frames.size());
  Eigen::MatrixX3d weights(n, 3);
  for (Eigen::Index k = 0; k < n; ++k)
    weights.row(k) << double(wave.mean[std::size_t(k)]), double(wave.cosine[std::size_t(k)]),
        double(wave.sine[std::size_t(k)]);
  // The weights of a least-squares fit span the same space as its model.
  const Eigen::HouseholderQR<Eigen::MatrixX3d> qr(weights);
  basis.model = (qr.householderQ() * Eigen::MatrixX3d::Identity(n, 3)).cast<float>();
  return basis;
}

/// Grey levels of some lit pixels, a column each.
Eigen::MatrixXf samples_of(const std::vector<ViewU8>& captures, const std::vector<Basis>& waves,
                           const PhaseOptions& options) {
  constexpr int kRows = 30, kColumns = 40;
  const ImageSize size = captures[0].size();
  const int stride_y = std::max(1, size.height / kRows), stride_x = std::max(1, size.width / kColumns);
  std::vector<int> phases;
  for (const Basis& wave : waves) phases.insert(phases.end(), wave.frames.begin(), wave.frames.end());
  Eigen::MatrixXf samples(Eigen::Index(captures.size()), kRows * kColumns * 4);
  Eigen::Index count = 0;
  for (int y = stride_y / 2; y < size.height; y += stride_y)
    for (int x = stride_x / 2; x < size.width && count < samples.cols(); x += stride_x) {
      int low = 255, high = 0;
      for (const int frame : phases) {
        const int grey = captures[std::size_t(frame)].row(y)[x];
        low = std::min(low, grey), high = std::max(high, grey);
        samples(frame, count) = float(grey);
      }
      if (high < options.saturated && high - low > 8 * options.min_modulation) ++count;
    }
  return samples.leftCols(count);
}

/// Residual over variance with the captures `a` and `b` exchanged; both -1: as given.
double residual(const Basis& wave, const Eigen::MatrixXf& samples, int a, int b) {
  Eigen::MatrixXf shown(Eigen::Index(wave.frames.size()), samples.cols());
  for (std::size_t k = 0; k < wave.frames.size(); ++k) {
    const int frame = wave.frames[k] == a ? b : wave.frames[k] == b ? a : wave.frames[k];
    shown.row(Eigen::Index(k)) = samples.row(frame);
  }
  shown.rowwise() -= shown.colwise().mean().eval();
  const double all = double(shown.squaredNorm());
  return (all - double((wave.model.transpose() * shown).squaredNorm())) / std::max(all, 1.0);
}

}  // namespace

std::vector<std::pair<int, int>> find_exchanged_steps(const std::vector<ViewU8>& captures,
                                                      const std::vector<AxisWaves>& axes,
                                                      const PhaseOptions& options) {
  constexpr Eigen::Index kFew = 100;
  constexpr double kFarLess = 0.5;  // of T of the waves concerned
  constexpr double kMuch = 0.03;    // that T falls by: noise alone has no order
  constexpr double kAlike = 0.1;    // of what T falls by
  std::vector<Basis> waves;
  for (const AxisWaves& axis : axes)
    for (const Wave& wave : axis.waves) waves.push_back(basis_of(wave));
  const Eigen::MatrixXf samples = samples_of(captures, waves, options);
  if (samples.cols() < kFew) return {};
  std::vector<double> as_given;
  for (const Basis& wave : waves) as_given.push_back(residual(wave, samples, -1, -1));

  struct Exchange {
    int a, b;
    double gain;
  };
  std::vector<Exchange> exchanges;
  const auto consider = [&](int a, int b) {
    double given = 0, exchanged = 0;
    for (std::size_t w = 0; w < waves.size(); ++w) {
      const std::vector<int>& frames = waves[w].frames;
      if (std::none_of(frames.begin(), frames.end(), [&](int frame) { return frame == a || frame == b; }))
        continue;
      given += as_given[w], exchanged += residual(waves[w], samples, a, b);
    }
    if (exchanged < kFarLess * given && given - exchanged > kMuch)
      exchanges.push_back({std::min(a, b), std::max(a, b), given - exchanged});
  };
  for (std::size_t w = 0; w < waves.size(); ++w) {
    // A wave that is as it should be had no exchange.
    if (as_given[w] < kMuch) continue;
    for (std::size_t v = 0; v < waves.size(); ++v)
      for (const int a : waves[w].frames)
        for (const int b : waves[v].frames)
          if (v > w || as_given[v] < kMuch ? v != w : v == w && a < b) consider(a, b);
  }
  double most = 0;
  for (const Exchange& one : exchanges) most = std::max(most, one.gain);
  std::vector<std::pair<int, int>> found;
  for (const Exchange& one : exchanges)
    if (one.gain > (1 - kAlike) * most) found.emplace_back(one.a, one.b);
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

}  // namespace procam::pattern::internal
