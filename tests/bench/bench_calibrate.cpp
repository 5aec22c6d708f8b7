/// procam's calibration against OpenCV's on the same points, in one run, on one thread: time, and the
/// reprojection RMS of both answers. Ends with a table of ratios (medians over --benchmark_repetitions);
/// exits with 1 when an answer is worse.
///
/// Both sides estimate fx fy cx cy k1 k2 p1 p2 a device and start from nothing. procam's time includes its
/// noise estimate, outlier search, covariance and jackknife; the board is held flat, as OpenCV holds it.
/// Where the light was read at corners, as from Gray code, procam counts a corner's error once, and its
/// projector's RMS is what is left of the light's own: another optimum than OpenCV's, which takes both as
/// independent.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <map>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/utility.hpp>
#include <vector>

#include "procam/calibrate/calibrate.hpp"
#include "support/numeric_world.hpp"

namespace {

using namespace procam;
using calibrate::BoardShape;
using calibrate::CalibrationResult;

struct Case {
  Correspondences data;
  std::vector<std::vector<cv::Point3f>> board;
  std::vector<std::vector<cv::Point2f>> camera, projector;
  cv::Size camera_size, projector_size;

  Case(int views, Chessboard layout, bool light_read_at_corners = false) {
    // The same sheet size whatever the number of corners.
    layout.square_size = 0.28 / (layout.columns - 1);
    const test::NumericWorld world = test::NumericWorld::make_with(layout, views, 17, 0.1, 0.1);
    data = light_read_at_corners ? world.with_light_read_at_corners(18) : world.correspondences(18);
    const Points3 points = points_in_board(data.board);
    const auto to_float = [](const Vec2& p) { return cv::Point2f(float(p.x()), float(p.y())); };
    for (View& view : data.views) {
      board.emplace_back();
      camera.emplace_back();
      projector.emplace_back();
      for (std::size_t i = 0; i < view.observations[0].size(); ++i) {
        Observation &seen = view.observations[0][i], &lit = view.observations[1][i];
        const Vec3& p = points[std::size_t(seen.point)];
        board.back().emplace_back(float(p.x()), float(p.y()), 0.f);
        camera.back().push_back(to_float(seen.pixel));
        projector.back().push_back(to_float(lit.pixel));
        // What a float holds, so that both libraries see the same numbers.
        seen.pixel = Vec2(camera.back().back().x, camera.back().back().y);
        lit.pixel = Vec2(projector.back().back().x, projector.back().back().y);
      }
    }
    camera_size = {data.devices[0].size.width, data.devices[0].size.height};
    projector_size = {data.devices[1].size.width, data.devices[1].size.height};
  }
};

calibrate::Options options() {
  calibrate::Options options;
  options.board_shape = BoardShape::kFlat;
  options.outlier_sigmas = 1e3;  // OpenCV keeps every point
  return options;
}

const Case& small() {
  static const Case instance(18, Chessboard{9, 6, 0});
  return instance;
}
const Case& large() {
  static const Case instance(100, Chessboard{11, 8, 0});
  return instance;
}
const Case& light_at_corners() {
  static const Case instance(18, Chessboard{9, 6, 0}, true);
  return instance;
}

/// RMS over all points.
constexpr char kRms[] = "rms_px";

void camera_procam(benchmark::State& state, const Case& (*of)()) {
  double value = 0;
  for (auto _ : state) value = calibrate::calibrate_camera(of().data, options()).rms_all_px[0];
  state.counters[kRms] = value;
}

double opencv_camera(const Case& c, const std::vector<std::vector<cv::Point2f>>& pixels, cv::Size size,
                     cv::Mat& k, cv::Mat& d) {
  std::vector<cv::Mat> r, t;
  k = cv::Mat(), d = cv::Mat();
  return cv::calibrateCamera(c.board, pixels, size, k, d, r, t, cv::CALIB_FIX_K3);
}

void camera_opencv(benchmark::State& state, const Case& (*of)()) {
  double value = 0;
  cv::Mat k, d;
  for (auto _ : state) value = opencv_camera(of(), of().camera, of().camera_size, k, d);
  state.counters[kRms] = value;
}

void rig_procam(benchmark::State& state, const Case& (*of)()) {
  double value = 0;
  const calibrate::Options how = options();
  for (auto _ : state) value = calibrate::calibrate_rig(of().data, how).joint_rms_all_px;
  state.counters[kRms] = value;
}

void rig_opencv(benchmark::State& state, const Case& (*of)()) {
  double value = 0;
  const Case& c = of();
  for (auto _ : state) {
    cv::Mat k1, d1, k2, d2, r, t, e, f;
    opencv_camera(c, c.camera, c.camera_size, k1, d1);
    opencv_camera(c, c.projector, c.projector_size, k2, d2);
    value = cv::stereoCalibrate(c.board, c.camera, c.projector, k1, d1, k2, d2, c.camera_size, r, t, e, f,
                                cv::CALIB_USE_INTRINSIC_GUESS | cv::CALIB_FIX_K3);
  }
  state.counters[kRms] = value;
}

BENCHMARK_CAPTURE(camera_procam, camera_18x54, small)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(camera_opencv, camera_18x54, small)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(camera_procam, camera_100x88, large)->Unit(benchmark::kMillisecond)->Iterations(2);
BENCHMARK_CAPTURE(camera_opencv, camera_100x88, large)->Unit(benchmark::kMillisecond)->Iterations(1);
BENCHMARK_CAPTURE(rig_procam, rig_18x54, small)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(rig_opencv, rig_18x54, small)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(rig_procam, rig_at_corners, light_at_corners)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(rig_opencv, rig_at_corners, light_at_corners)->Unit(benchmark::kMillisecond);

double median(std::vector<double> values) {
  const auto middle = values.begin() + long(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

class Collector : public benchmark::ConsoleReporter {
 public:
  void ReportRuns(const std::vector<Run>& runs) override {
    for (const Run& run : runs) {
      if (run.run_type != Run::RT_Iteration) continue;
      Result& result = results[run.run_name.function_name];
      result.milliseconds.push_back(run.GetAdjustedCPUTime());
      result.rms_px = run.counters.at(kRms);
    }
    ConsoleReporter::ReportRuns(runs);
  }
  struct Result {
    std::vector<double> milliseconds;  ///< by repetition
    double rms_px = 0;
  };
  std::map<std::string, Result> results;
};

}  // namespace

int main(int argc, char** argv) {
  cv::setNumThreads(1);
  benchmark::Initialize(&argc, argv);
  Collector collector;
  benchmark::RunSpecifiedBenchmarks(&collector);
  bool worse = false;
  std::printf("\n%-18s %12s %12s %8s %12s %12s\n", "case", "procam ms", "OpenCV ms", "ratio", "procam px",
              "OpenCV px");
  for (const auto& [name, ours, theirs] :
       {std::array{"camera 18x54", "camera_procam/camera_18x54", "camera_opencv/camera_18x54"},
        std::array{"camera 100x88", "camera_procam/camera_100x88", "camera_opencv/camera_100x88"},
        std::array{"rig 18x54", "rig_procam/rig_18x54", "rig_opencv/rig_18x54"},
        std::array{"rig, at corners", "rig_procam/rig_at_corners", "rig_opencv/rig_at_corners"}}) {
    const auto a = collector.results.find(ours), b = collector.results.find(theirs);
    if (a == collector.results.end() || b == collector.results.end()) continue;
    std::vector<double> ratios;
    const std::size_t runs = std::min(a->second.milliseconds.size(), b->second.milliseconds.size());
    for (std::size_t i = 0; i < runs; ++i)
      ratios.push_back(b->second.milliseconds[i] / a->second.milliseconds[i]);
    std::printf("%-18s %12.1f %12.1f %7.1fx %12.6f %12.6f\n", name, median(a->second.milliseconds),
                median(b->second.milliseconds), median(ratios), a->second.rms_px, b->second.rms_px);
    worse = worse || a->second.rms_px > b->second.rms_px * (1 + 1e-4);
  }
  return worse ? 1 : 0;
}
