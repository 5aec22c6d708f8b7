/// A view of a room (24 bodies, one projector, every effect of the camera) of 1280x1024 pixels with 4 rays
/// each, against the least that any renderer must do for it: cv::remap of the projector's frame onto the four
/// times as many samples, and their means. The room view finds that map, hides what is hidden, and says the
/// truth as well.
///
///   bench_room_view                   CPU and wall time of each; two threads where it says so
#include <benchmark/benchmark.h>

#include <opencv2/core/utility.hpp>
#include <opencv2/imgproc.hpp>

#include "simulate/rooms.hpp"

namespace {

using namespace procam;
using namespace procam::simulate;

constexpr ImageSize kView{1280, 1024};

const RoomLight& light() {
  static const RoomLight one = [] {
    ImageU8 frame(512, 390);
    for (int y = 0; y < frame.height(); ++y)
      for (int x = 0; x < frame.width(); ++x)
        frame.at(x, y) = std::uint8_t(((x / 16 + y / 16) % 2 ? 200 : 40) + x % 16);
    return test::room_light(frame);
  }();
  return one;
}

/// {threads, frames}
void BM_RoomView(benchmark::State& state) {
  const Room room = test::lopsided_room();
  const Camera camera = test::room_camera(kView);
  RoomLight shown = light();
  shown.frames.resize(std::size_t(state.range(1)), shown.frames[0]);
  shown.blur_px = 0.5;
  shown.gamma = 2.2;
  RoomViewOptions options;
  options.threads = int(state.range(0));
  options.camera_blur_px = 0.7;
  options.vignetting = 4;
  options.gamma = 2.2;
  options.noise = {2, 0.01};
  for (auto _ : state)
    benchmark::DoNotOptimize(room_view(room, camera, test::room_from_camera(), {shown}, options));
}
BENCHMARK(BM_RoomView)
    ->Args({1, 1})
    ->Args({2, 1})
    ->Args({2, 42})
    ->MeasureProcessCPUTime()
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

void BM_CvRemap(benchmark::State& state) {
  cv::setNumThreads(int(state.range(0)));
  const ImageU8& frame = light().frames[0];
  const cv::Mat picture(frame.height(), frame.width(), CV_8U, const_cast<std::uint8_t*>(frame.data()));
  cv::Mat map(2 * kView.height, 2 * kView.width, CV_32FC2);
  for (int y = 0; y < map.rows; ++y)
    for (int x = 0; x < map.cols; ++x)
      map.at<cv::Vec2f>(y, x) =
          cv::Vec2f(0.19f * float(x) + 0.01f * float(y), 0.18f * float(y) - 0.01f * float(x));
  cv::Mat samples, view;
  for (auto _ : state) {
    cv::remap(picture, samples, map, cv::noArray(), cv::INTER_LINEAR);
    cv::resize(samples, view, cv::Size(kView.width, kView.height), 0, 0, cv::INTER_AREA);
    benchmark::DoNotOptimize(view.data);
  }
}
BENCHMARK(BM_CvRemap)->Arg(1)->Arg(2)->MeasureProcessCPUTime()->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace
