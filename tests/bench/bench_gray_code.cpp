// Decoding 42 Gray-code frames of 1280x1024: OpenCV's getProjPixel per pixel against procam's decode() and
// stripe_edges(), single thread, same frames. Real captures if present, else projector frames stretched to
// the camera.
#include <benchmark/benchmark.h>

#include <opencv2/imgproc.hpp>
#include <opencv2/structured_light.hpp>
#include <utility>
#include <vector>

#include "procam/pattern/gray_code.hpp"
#include "procam/pattern/stripe_edges.hpp"
#include "support/gray_code_data.hpp"

namespace {

const procam::pattern::GrayCode kGrayCode{{1024, 768}, 1};

const std::vector<cv::Mat>& captures() {
  static const std::vector<cv::Mat> frames = [] {
    std::vector<cv::Mat> found = procam::test::real_gray_code(0);
    if (!found.empty()) return found;
    for (procam::ImageU8& frame : procam::pattern::frames(kGrayCode)) {
      const cv::Mat shown(frame.height(), frame.width(), CV_8U, frame.data());
      cv::Mat seen;
      cv::resize(shown, seen, {1280, 1024}, 0, 0, cv::INTER_LINEAR);
      found.push_back(0.5 * seen + 10);
    }
    return found;
  }();
  return frames;
}

void OpencvGetProjPixel(benchmark::State& state) {
  cv::setNumThreads(1);
  const auto pattern = cv::structured_light::GrayCodePattern::create(1024, 768);
  pattern->setWhiteThreshold(5);
  const std::vector<cv::Mat> bits(captures().begin(), captures().begin() + 40);
  cv::Mat_<cv::Vec2s> codes(bits[0].size());
  for (auto _ : state) {
    for (int y = 0; y < codes.rows; ++y) {
      for (int x = 0; x < codes.cols; ++x) {
        cv::Point point;
        const bool failed = pattern->getProjPixel(bits, x, y, point);
        codes(y, x) = failed ? cv::Vec2s(-1, -1) : cv::Vec2s(short(point.x), short(point.y));
      }
    }
    benchmark::DoNotOptimize(codes.data);
  }
}

void ProcamDecode(benchmark::State& state) {
  const std::vector<procam::ViewU8> views = procam::test::views_of(captures());
  for (auto _ : state) benchmark::DoNotOptimize(procam::pattern::decode(views, kGrayCode));
}

/// As OpencvGetProjPixel, into memory that is there already.
void ProcamDecodeReusing(benchmark::State& state) {
  const std::vector<procam::ViewU8> views = procam::test::views_of(captures());
  procam::DecodedMap map;
  for (auto _ : state) {
    map = procam::pattern::decode(views, kGrayCode, {}, std::move(map));
    benchmark::DoNotOptimize(map.columns.data());
  }
}

void ProcamStripeEdges(benchmark::State& state) {
  const std::vector<procam::ViewU8> views = procam::test::views_of(captures());
  const procam::DecodedMap map = procam::pattern::decode(views, kGrayCode);
  std::size_t edges = 0;
  for (auto _ : state) edges = procam::pattern::stripe_edges(views, map, kGrayCode).size();
  state.counters["edges"] = double(edges);
}

BENCHMARK(OpencvGetProjPixel)->Unit(benchmark::kMillisecond)->MinTime(2.0);
BENCHMARK(ProcamDecode)->Unit(benchmark::kMillisecond)->MinTime(2.0);
BENCHMARK(ProcamDecodeReusing)->Unit(benchmark::kMillisecond)->MinTime(2.0);
BENCHMARK(ProcamStripeEdges)->Unit(benchmark::kMillisecond);

}  // namespace
