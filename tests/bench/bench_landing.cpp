/// Monte Carlo of landed light against cv::projectPoints, one core each: points a second through a full
/// Brown-Conrady lens. A landing is the harder way round (undistort, then meet the surface).
///
///   bench_landing                     the last line says the ratio
#include <benchmark/benchmark.h>

#include <opencv2/calib3d.hpp>
#include <opencv2/core/utility.hpp>

#include "procam/analyze/monte_carlo.hpp"
#include "procam/core/geometry/se3.hpp"

namespace {

using namespace procam;

constexpr int kColumns = 40, kRows = 25, kPoints = kColumns * kRows;

struct Fixture {
  Rig rig;
  Points2 points;
  analyze::ErrorSources sources;

  Fixture() {
    const Camera lens{
        {1024, 768}, {1880, 1891, 498, 846, 1.3}, BrownConrady{{-0.05, 0.03, -6e-4, 9e-4, 0.01}}};
    rig.projectors.push_back(
        {"projector", Projector{lens}, Pose(so3_exp(Vec3(0.1, -0.05, 0.02)), Vec3(0.2, 0, 0))});
    for (int j = 0; j < kRows; ++j)
      for (int i = 0; i < kColumns; ++i) points.emplace_back(0.02 * (i - 20), 0.02 * (j - 20));
    for (const std::string& name : parameter_names(lens)) rig.covariance.names.push_back("projector." + name);
    for (const std::string& name : pose_increment_names("rig_from_projector"))
      rig.covariance.names.push_back(name);
    VecX sigmas(16);
    sigmas << 2, 2, 3, 3, 0.5, 3e-3, 5e-3, 2e-4, 2e-4, 2e-3, 1e-3, 1e-3, 1e-3, 1e-3, 1e-3, 2e-3;
    rig.covariance.matrix = sigmas.cwiseAbs2().asDiagonal();
    sources.calibration = rig.covariance;
    sources.map = analyze::isotropic_pose_covariance(0.005, 0.003);
  }
  analyze::LightPath path() const {
    return analyze::light_path(rig.projector(), "rig", Pose(so3_exp(Vec3(0.4, -0.6, 0.1)), Vec3(0, 0, 2)));
  }
};

const Fixture& fixture() {
  static const Fixture one;
  return one;
}

void BM_MonteCarloLandings(benchmark::State& state) {
  analyze::MonteCarloOptions options;
  options.draws = 20000;
  options.threads = 1;
  for (auto _ : state)
    benchmark::DoNotOptimize(
        analyze::monte_carlo_landing(fixture().path(), fixture().sources, fixture().points, options));
  state.SetItemsProcessed(state.iterations() * options.draws * kPoints);
}
BENCHMARK(BM_MonteCarloLandings)->Unit(benchmark::kMillisecond);

void BM_CvProjectPoints(benchmark::State& state) {
  cv::setNumThreads(1);
  const Pose projector_from_surface =
      fixture().rig.projectors[0].rig_from_projector.inverse() * fixture().path().rig_from_surface;
  std::vector<cv::Point3d> points;
  for (const Vec2& p : fixture().points) points.emplace_back(p.x(), p.y(), 0);
  const Vec3 w = so3_log(projector_from_surface.rotation), t = projector_from_surface.translation;
  const cv::Vec3d rotation(w.x(), w.y(), w.z()), translation(t.x(), t.y(), t.z());
  const cv::Matx33d k(1880, 1.3, 498, 0, 1891, 846, 0, 0, 1);
  const std::vector<double> lens = {-0.05, 0.03, -6e-4, 9e-4, 0.01};
  std::vector<cv::Point2d> pixels;
  for (auto _ : state) {
    cv::projectPoints(points, rotation, translation, k, lens, pixels);
    benchmark::DoNotOptimize(pixels.data());
  }
  state.SetItemsProcessed(state.iterations() * kPoints);
}
BENCHMARK(BM_CvProjectPoints);

}  // namespace

BENCHMARK_MAIN();
