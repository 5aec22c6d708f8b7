#pragma once
/// The same question as landing_error.hpp, answered by drawing: every error of the chain is drawn from its
/// distribution, and the light is followed through the wrong chain, exactly. What it finds beside the closed
/// form is the error of first order.
///
/// Gaussian throughout, but for the pixel's offset, which is uniform: whole pixels.
#include <cstdint>
#include <vector>

#include "procam/analyze/error_sources.hpp"
#include "procam/core/base/export.hpp"

namespace procam::analyze {

struct MonteCarloOptions {
  int draws = 100000;  ///< relative error of a sigma: 1 / sqrt(2 draws)
  std::uint64_t seed = 1;
  int threads = 0;  ///< 0: as many as the machine has. The numbers do not depend on it
  /// The part that is drawn here, for several processes or machines: of the draws, in pieces of 2048, every
  /// `shards`-th piece from number `shard` on, 0 <= shard < shards. merged() joins the parts.
  int shard = 0, shards = 1;
};

/// Where the light for one point lands, over all draws. Offsets from the intended place, on the surface along
/// its x and y, metres.
struct LandingSpread {
  Vec2 mean = Vec2::Zero();
  Mat2 covariance = Mat2::Zero();
  double worst = 0;  ///< the largest distance drawn, metres
  int draws = 0;     ///< how many were made
  int missed = 0;    ///< draws in which the light never meets the surface; not in the numbers above

  double rms() const { return std::sqrt(mean.squaredNorm() + covariance.trace()); }
};

/// The spread over the draws of all parts; at least one part. Means and covariances are joined by the updating formulae
/// of T. F. Chan, G. H. Golub and R. J. LeVeque, "Algorithms for computing the sample variance", The American
/// Statistician 37(3), 1983: equal to those of all draws in one run but for rounding.
PROCAM_EXPORT LandingSpread merged(const std::vector<LandingSpread>& parts);

/// One spread a point of the surface, from the same draws: they correlate as they do in the room. nullopt for
/// a point that no light reaches in the chain as it is believed to be. Throws as landing_error() does, and
/// std::invalid_argument unless draws >= 2 and there is a piece for each shard.
PROCAM_EXPORT std::vector<std::optional<LandingSpread>> monte_carlo_landing(
    const LightPath& path, const ErrorSources& sources, const Points2& on_surface,
    const MonteCarloOptions& options = {});

}  // namespace procam::analyze
