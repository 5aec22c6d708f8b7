#include "procam/analyze/monte_carlo.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "landing_lanes.hpp"
#include "light_chain.hpp"
#include "procam/core/base/parallel.hpp"
#include "procam/core/geometry/se3.hpp"

namespace procam::analyze {
namespace {

/// Draws in one piece of work: each has a generator of its own, so that no thread's share shows in the
/// result.
constexpr int kPiece = 2048;
/// Points and draws that are followed together, so that what a turn touches stays in the near caches: the
/// pixels' shifts above all.
constexpr std::size_t kBlock = 512;
constexpr int kAtOnce = 16;

/// Square roots of all covariances, so that a draw is root * (standard normal numbers).
struct Distribution {
  std::optional<CalibrationErrors> calibration;
  MatX calibration_root;
  MatX rig, surface, motion;
  Vec6 motion_mean = Vec6::Zero();
  double pixel_range = 0;  ///< uniform in +- half of it
};

Distribution distribution_of(const LightPath& path, const ErrorSources& sources) {
  require(sources.pixel_sigma >= 0 && std::isfinite(sources.pixel_sigma),
          "monte_carlo_landing: the pixel's sigma must be finite and not negative");
  Distribution d;
  if (!sources.calibration.empty()) {
    d.calibration.emplace(path, sources);
    d.calibration_root = square_root(d.calibration->covariance, "calibration");
  }
  d.surface = square_root(sources.map, "map");
  const MatX rig = square_root(sources.rig_pose, "rig pose");
  const MotionError motion = motion_error(sources.motion);
  if (path.through_pose) {
    d.rig = rig;
    d.motion = square_root(motion.covariance, "delay");
    d.motion_mean = motion.mean;
  }
  d.pixel_range = std::sqrt(12.0) * sources.pixel_sigma;
  return d;
}

/// Two independent standard normal numbers: Marsaglia's polar method. (std::normal_distribution is left open
/// by the standard, and in libstdc++ by Clang takes a logarithm of 80 bits for every number.)
Vec2 normal_pair(std::mt19937_64& random) {
  for (;;) {
    const auto uniform = [&] { return double(random() >> 11) * 0x1p-52 - 1; };  // [-1, 1)
    const double x = uniform(), y = uniform(), s = x * x + y * y;
    if (s > 0 && s < 1) return Vec2(x, y) * std::sqrt(-2 * std::log(s) / s);
  }
}

class Drawing {
 public:
  Drawing(const LightPath& path, const Distribution& distribution, const std::vector<LandingLanes>& blocks,
          std::uint64_t seed)
      : path_(path), distribution_(distribution), blocks_(blocks), seed_(seed) {}

  /// The sums of `count` draws of piece number `piece`, by block.
  std::vector<LandingSums> draw(int piece, int count) const {
    std::seed_seq seeds{std::uint32_t(seed_), std::uint32_t(seed_ >> 32), std::uint32_t(piece)};
    std::mt19937_64 random(seeds);
    std::vector<LandingSums> sums;
    std::vector<LandingDraw> draws;
    std::vector<PixelShift> shifts;
    for (const LandingLanes& lanes : blocks_) sums.emplace_back(lanes.groups.size());
    for (int first = 0; first < count; first += kAtOnce) {
      draws.resize(std::size_t(std::min(kAtOnce, count - first)));
      for (LandingDraw& one : draws) draw_chain(random, one);
      for (std::size_t block = 0; block < blocks_.size(); ++block) {
        if (distribution_.pixel_range > 0) {
          shifts.resize(draws.size() * blocks_[block].groups.size());
          shift_pixels(random, shifts);
        }
        sums[block].add(blocks_[block], draws, shifts);
      }
    }
    return sums;
  }

 private:
  void draw_chain(std::mt19937_64& random, LandingDraw& chain) const {
    const auto drawn = [&](const MatX& root) -> VecX {
      VecX z(root.cols());
      for (Eigen::Index i = 0; i < z.size(); i += 2) {
        const Eigen::Index size = std::min<Eigen::Index>(2, z.size() - i);
        z.segment(i, size) = normal_pair(random).head(size);
      }
      return root.lazyProduct(z);
    };
    chain.lens = path_.projector.projector.inverse_camera;
    Pose rig_from_projector = path_.projector.rig_from_projector, rig_from_surface = path_.rig_from_surface;
    if (distribution_.calibration) {
      const ChainErrors errors =
          distribution_.calibration->chain_errors(drawn(distribution_.calibration_root));
      chain.lens = wrong_lens(chain.lens, errors.lens);
      rig_from_projector = se3_exp(errors.mount) * rig_from_projector;
      rig_from_surface = se3_exp(Vec6(-errors.rig)) * rig_from_surface;
    }
    if (distribution_.rig.size() > 0) {
      const Vec6 moved = distribution_.motion_mean + drawn(distribution_.motion);
      rig_from_surface = se3_exp(Vec6(-moved)) * se3_exp(Vec6(-drawn(distribution_.rig))) * rig_from_surface;
    }
    rig_from_surface = rig_from_surface * se3_exp(Vec6(drawn(distribution_.surface)));
    chain.surface_from_projector = rig_from_surface.inverse() * rig_from_projector;
  }

  void shift_pixels(std::mt19937_64& random, std::vector<PixelShift>& shifts) const {
    const double scale = distribution_.pixel_range / 4294967296.0;
    for (PixelShift& shift : shifts)
      for (std::size_t i = 0; i < Double4::kSize; ++i) {
        const std::uint64_t bits = random();
        shift.x[i] = (double(std::uint32_t(bits)) - 2147483647.5) * scale;
        shift.y[i] = (double(std::uint32_t(bits >> 32)) - 2147483647.5) * scale;
      }
  }

  const LightPath& path_;
  const Distribution& distribution_;
  const std::vector<LandingLanes>& blocks_;
  std::uint64_t seed_;
};

/// From the sums about zero. `draws` counts those that missed too.
LandingSpread spread_of(const LandingSums& sums, std::size_t i, int draws) {
  using Sum = LandingSums::Group;
  const auto sum = [&](Double4 Sum::*which) { return sums.of(which, i); };
  LandingSpread spread;
  const double landed = sum(&Sum::landed);
  spread.draws = draws;
  spread.missed = draws - int(landed);
  if (landed < 1) return spread;
  spread.mean = Vec2(sum(&Sum::x), sum(&Sum::y)) / landed;
  spread.worst = std::sqrt(sum(&Sum::worst2));
  if (landed < 2) return spread;
  spread.covariance << sum(&Sum::xx), sum(&Sum::xy), sum(&Sum::xy), sum(&Sum::yy);
  spread.covariance = (spread.covariance - landed * spread.mean * spread.mean.transpose()) / (landed - 1);
  return spread;
}

}  // namespace

LandingSpread merged(const std::vector<LandingSpread>& parts) {
  require(!parts.empty(), "merged: no part");
  LandingSpread all;
  Mat2 squares = Mat2::Zero();  // about the mean
  double landed = 0;
  for (const LandingSpread& part : parts) {
    all.draws += part.draws;
    all.missed += part.missed;
    all.worst = std::max(all.worst, part.worst);
    const double more = part.draws - part.missed;
    if (more < 1) continue;
    const Vec2 step = part.mean - all.mean;
    squares += (more - 1) * part.covariance + landed * more / (landed + more) * step * step.transpose();
    all.mean += more / (landed + more) * step;
    landed += more;
  }
  if (landed > 1) all.covariance = squares / (landed - 1);
  return all;
}

std::vector<std::optional<LandingSpread>> monte_carlo_landing(const LightPath& path,
                                                              const ErrorSources& sources,
                                                              const Points2& on_surface,
                                                              const MonteCarloOptions& options) {
  require(options.draws >= 2, "monte_carlo_landing: at least two draws");
  const int pieces = (options.draws + kPiece - 1) / kPiece;
  require(0 <= options.shard && options.shard < options.shards && options.shards <= pieces,
          "monte_carlo_landing: the shard is not one of as many as there are pieces of draws");
  const Distribution distribution = distribution_of(path, sources);
  const Projector& projector = path.projector.projector;
  const Pose projector_from_surface = path.projector.rig_from_projector.inverse() * path.rig_from_surface;
  std::vector<LandingLanes> blocks;
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < on_surface.size(); ++i) {
    const auto pixel =
        projector.project(projector_from_surface * Vec3(on_surface[i].x(), on_surface[i].y(), 0));
    const auto bearing = pixel ? projector.inverse_camera.unproject(*pixel) : std::nullopt;
    if (!bearing) continue;
    if (places.size() % kBlock == 0) blocks.emplace_back();
    blocks.back().add(on_surface[i], projector.inverse_camera, *pixel, *bearing);
    places.push_back(i);
  }

  const Drawing drawing(path, distribution, blocks, options.seed);
  const int own = (pieces - options.shard + options.shards - 1) / options.shards;
  std::vector<std::vector<LandingSums>> of_piece;
  of_piece.resize(std::size_t(own));
  const auto size_of = [&](int i) {
    return std::min(kPiece, options.draws - (options.shard + i * options.shards) * kPiece);
  };
  parallel_each(own, options.threads, [&](int i) {
    of_piece[std::size_t(i)] = drawing.draw(options.shard + i * options.shards, size_of(i));
  });
  int draws = 0;
  for (int i = 0; i < own; ++i) draws += size_of(i);

  // In the order of the pieces, so that rounding is the same whoever drew them.
  std::vector<std::optional<LandingSpread>> spreads(on_surface.size());
  std::size_t point = 0;
  for (std::size_t block = 0; block < blocks.size(); ++block) {
    LandingSums sums(blocks[block].groups.size());
    for (const std::vector<LandingSums>& piece : of_piece) sums.add(piece[block]);
    for (std::size_t i = 0; i < blocks[block].size(); ++i)
      spreads[places[point++]] = spread_of(sums, i, draws);
  }
  return spreads;
}

}  // namespace procam::analyze
