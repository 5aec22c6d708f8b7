#include "procam/simulate/lens_deviation.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "draw.hpp"
#include "procam/core/lens/lens_change.hpp"

namespace procam::simulate {
namespace {

constexpr int kNodeStep = 16;  // pixels; the shortest wave is twenty times as long
constexpr int kWaves = 6;

struct Wave {
  Vec2 amplitude, by_pixel;
  double phase;
};

std::vector<Wave> draw_waves(int width, Draw& random) {
  std::vector<Wave> waves;
  for (int axis = 0; axis < 2; ++axis)
    for (int i = 0; i < kWaves; ++i) {
      const double direction = random.uniform(0, 2 * kPi), across = random.uniform(0.5, 3);
      Wave wave{Vec2::Zero(), 2 * kPi * across / width * Vec2(std::cos(direction), std::sin(direction)),
                random.uniform(0, 2 * kPi)};
      wave.amplitude[axis] = random.uniform(-1, 1);
      waves.push_back(wave);
    }
  return waves;
}

}  // namespace

LensDeviation::LensDeviation(const Camera& lens, double rms_px, std::uint64_t seed) {
  require(rms_px >= 0, "LensDeviation: rms_px is a length, zero or more");
  if (rms_px == 0) return;
  Draw random(seed, 13);
  const std::vector<Wave> waves = draw_waves(lens.size.width, random);
  const auto sum = [&](const Vec2& pixel) {
    Vec2 all = Vec2::Zero();
    for (const Wave& wave : waves) all += wave.amplitude * std::sin(wave.by_pixel.dot(pixel) + wave.phase);
    return Vec2(0.1 * all);  // small, for the lens's change to be linear
  };
  const Points2 grid = grid_over(lens.size, 24, 18);
  MatX wanted(Eigen::Index(2 * grid.size()), 1);
  for (std::size_t i = 0; i < grid.size(); ++i) wanted.block<2, 1>(Eigen::Index(2 * i), 0) = sum(grid[i]);
  std::vector<int> free(static_cast<std::size_t>(parameters_of(lens).size()));
  std::iota(free.begin(), free.end(), 0);
  const Camera nearest = with_lens_change(lens, free, lens_change(lens, free, grid, wanted).col(0));
  const auto remainder = [&](const Vec2& pixel) {
    const std::optional<Vec3> bearing = lens.unproject(pixel);
    const std::optional<Vec2> taken = bearing ? nearest.project(*bearing) : std::nullopt;
    return taken ? Vec2(sum(pixel) - (*taken - pixel)) : Vec2(Vec2::Zero());
  };
  double squares = 0;
  for (const Vec2& pixel : grid) squares += remainder(pixel).squaredNorm() / double(grid.size());
  const double factor = rms_px / std::sqrt(squares);
  nodes_ = ImageF({lens.size.width / kNodeStep + 2, lens.size.height / kNodeStep + 2}, 2);
  for (int y = 0; y < nodes_.size().height; ++y)
    for (int x = 0; x < nodes_.size().width; ++x) {
      const Vec2 d = factor * remainder(Vec2(kNodeStep * x, kNodeStep * y));
      nodes_.at(x, y, 0) = float(d.x()), nodes_.at(x, y, 1) = float(d.y());
    }
}

Vec2 LensDeviation::at(const Vec2& pixel) const {
  if (empty()) return Vec2::Zero();
  const Vec2 at = (pixel / kNodeStep)
                      .cwiseMax(0)
                      .cwiseMin(Vec2(nodes_.size().width - 1.001, nodes_.size().height - 1.001));
  const int x = int(at.x()), y = int(at.y());
  const double s = at.x() - x, t = at.y() - y;
  const auto node = [&](int i, int j) {
    return Vec2(nodes_.at(x + i, y + j, 0), nodes_.at(x + i, y + j, 1));
  };
  return (1 - t) * ((1 - s) * node(0, 0) + s * node(1, 0)) + t * ((1 - s) * node(0, 1) + s * node(1, 1));
}

}  // namespace procam::simulate
