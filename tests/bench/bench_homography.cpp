/// procam's homographies against OpenCV's, in one run, on one thread: time, and the geometric RMSE of both
/// answers. Ends with a table of ratios; exits with 1 when an RMSE exceeds OpenCV's.
#include <benchmark/benchmark.h>

#include <cstdio>
#include <map>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <random>

#include "procam/core/geometry/homography_fit.hpp"

namespace {

using namespace procam;

/// N noisy pairs in coordinates that a float holds exactly, so both libraries see the same numbers.
struct Pairs {
  Points2 source, destination;
  std::vector<cv::Point2f> cv_source, cv_destination;

  explicit Pairs(int count) {
    std::mt19937 random(unsigned(count) * 7919u + 1u);
    std::uniform_real_distribution<double> uniform;
    std::normal_distribution<double> noise(0.0, 0.3);
    Mat3 matrix;
    matrix << 1.1, 0.08, 30.0, -0.05, 0.93, 12.0, 1.2e-4, -2e-4, 1.0;
    const Homography truth(matrix);
    for (int i = 0; i < count; ++i) {
      cv_source.emplace_back(float(1280 * uniform(random)), float(800 * uniform(random)));
      source.emplace_back(cv_source.back().x, cv_source.back().y);
      const Vec2 mapped = truth.apply_unchecked(source.back()) + Vec2{noise(random), noise(random)};
      cv_destination.emplace_back(float(mapped.x()), float(mapped.y()));
      destination.emplace_back(cv_destination.back().x, cv_destination.back().y);
    }
  }
};

/// Four corners of a tilted screen.
struct Corners {
  std::array<Vec2, 4> source{Vec2(10, 20), Vec2(900, 35), Vec2(870, 700), Vec2(30, 650)};
  std::array<Vec2, 4> destination{Vec2(110, 60), Vec2(800, 15), Vec2(770, 600), Vec2(90, 690)};
  std::vector<cv::Point2f> cv_source, cv_destination;

  Corners() {
    for (int i = 0; i < 4; ++i) {
      cv_source.emplace_back(float(source[i].x()), float(source[i].y()));
      cv_destination.emplace_back(float(destination[i].x()), float(destination[i].y()));
    }
  }
};

double rmse(const Mat3& matrix, const Pairs& pairs) {
  double sum = 0.0;
  const Homography map(matrix);
  for (std::size_t i = 0; i < pairs.source.size(); ++i)
    sum += (map.apply_unchecked(pairs.source[i]) - pairs.destination[i]).squaredNorm();
  return std::sqrt(sum / double(pairs.source.size()));
}

Mat3 to_eigen(const cv::Mat& m) {
  Mat3 matrix;
  for (int i = 0; i < 9; ++i) matrix(i / 3, i % 3) = m.at<double>(i / 3, i % 3);
  return matrix;
}

void procam_four(benchmark::State& state) {
  Corners corners;
  for (auto _ : state) {
    benchmark::DoNotOptimize(corners);
    Homography h = homography_from_four_points(corners.source, corners.destination);
    benchmark::DoNotOptimize(h);
  }
}
void opencv_four(benchmark::State& state) {
  Corners corners;
  for (auto _ : state) {
    cv::Mat h = cv::getPerspectiveTransform(corners.cv_source, corners.cv_destination);
    benchmark::DoNotOptimize(h);
  }
}
void procam_fit(benchmark::State& state) {
  const Pairs pairs{int(state.range(0))};
  for (auto _ : state) {
    HomographyFit fit = fit_homography(pairs.source, pairs.destination);
    benchmark::DoNotOptimize(fit);
  }
  state.counters["rmse"] =
      rmse(fit_homography(pairs.source, pairs.destination).destination_from_source.matrix(), pairs);
}
void opencv_fit(benchmark::State& state) {
  const Pairs pairs{int(state.range(0))};
  for (auto _ : state) {
    cv::Mat h = cv::findHomography(pairs.cv_source, pairs.cv_destination, 0);
    benchmark::DoNotOptimize(h);
  }
  state.counters["rmse"] =
      rmse(to_eigen(cv::findHomography(pairs.cv_source, pairs.cv_destination, 0)), pairs);
}

/// Keeps the fastest repetition of each benchmark: what else runs on the machine only ever adds time.
class BestOf : public benchmark::ConsoleReporter {
 public:
  struct Best {
    double nanoseconds = 1e30, rmse = 0.0;
  };
  std::map<std::string, Best> best;

  void ReportRuns(const std::vector<Run>& runs) override {
    for (const Run& run : runs) {
      if (run.run_type != Run::RT_Iteration) continue;
      Best& b = best[run.run_name.function_name + (run.run_name.args.empty() ? "" : "/" + run.run_name.args)];
      b.nanoseconds = std::min(b.nanoseconds, run.GetAdjustedCPUTime());
      const auto counter = run.counters.find("rmse");
      if (counter != run.counters.end()) b.rmse = counter->second.value;
    }
    ConsoleReporter::ReportRuns(runs);
  }
};

}  // namespace

// The peers take turns, five times, so that a change of clock speed meets both.
BENCHMARK(procam_four)->Repetitions(5);
BENCHMARK(opencv_four)->Repetitions(5);
BENCHMARK(procam_fit)->Arg(100)->Arg(1000)->Repetitions(5);
BENCHMARK(opencv_fit)->Arg(100)->Arg(1000)->Repetitions(5);

int main(int argc, char** argv) {
  cv::setNumThreads(1);
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  BestOf reporter;
  benchmark::RunSpecifiedBenchmarks(&reporter);

  bool good = true;
  std::printf("\nprocam vs OpenCV %s, best of the repetitions\n", CV_VERSION);
  const auto row = [&](const char* name, const char* ours, const char* theirs) {
    if (!reporter.best.count(ours) || !reporter.best.count(theirs)) return;  // filtered out
    const BestOf::Best &a = reporter.best[ours], &b = reporter.best[theirs];
    std::printf("  %-12s ratio %5.1f  (%.1f ns vs %.1f ns)", name, b.nanoseconds / a.nanoseconds,
                a.nanoseconds, b.nanoseconds);
    if (b.rmse > 0.0) {
      // Equal means equal to 1e-9: both stop their iterations somewhere.
      const bool no_worse = a.rmse <= b.rmse * (1.0 + 1e-9);
      std::printf("  rmse %.12f vs %.12f px %s", a.rmse, b.rmse, no_worse ? "ok" : "WORSE");
      good = good && no_worse;
    }
    std::printf("\n");
  };
  row("4 points", "procam_four", "opencv_four");
  row("N = 100", "procam_fit/100", "opencv_fit/100");
  row("N = 1000", "procam_fit/1000", "opencv_fit/1000");
  return good ? 0 : 1;
}
