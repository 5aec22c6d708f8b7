/// The blend of a frame of 1920x1080 against its rendering, and against OpenCV's multiplication of the whole frame by a
/// table; and the maps of two and four projectors in a row, each of which overlaps its neighbours by a fifth of its frame.
///
///   bench_blend --benchmark_repetitions=5 --benchmark_enable_random_interleaving=true
#include <benchmark/benchmark.h>

#include <opencv2/core.hpp>

#include "procam/core/geometry/se3.hpp"
#include "procam/render/cpu.hpp"
#include "procam/surface/blend.hpp"
#include "procam/surface/solve.hpp"

namespace {

using namespace procam;

constexpr ImageSize kFrame{1920, 1080};

/// A wall of two planes in a corner and projectors in a row before it, with lens distortion.
struct Row {
  std::vector<SolvedSurfaceSet> solved;
  std::vector<surface::BlendInput> lit;

  explicit Row(int count, double black = 0) {
    solved.reserve(std::size_t(count));
    SurfaceSet set;
    for (int i = 0; i < 2; ++i) {
      PlanarSurface plane;
      plane.frame = "rig";
      plane.frame_from_surface =
          Pose(so3_exp(Vec3(0, i == 0 ? -0.1 : 0.1, 0)), Vec3(i == 0 ? -5.0 : 0.0, -1.5, i == 0 ? 2.0 : 2.5));
      plane.content = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
      plane.points = {{0, 0}, {5.02, 0}, {5.02, 3}, {0, 3}};
      set.surfaces.push_back({i == 0 ? "left" : "right", plane, {}, ""});
    }
    for (int i = 0; i < count; ++i) {
      RigProjector projector;
      projector.name = std::to_string(i);
      projector.projector.inverse_camera =
          Camera{kFrame, {2400, 2380, 950, 600, 2}, BrownConrady{{-0.1, 0.02, 1e-3, -5e-4, 0}}};
      projector.rig_from_projector =
          Pose(so3_exp(Vec3(0, 0, 0.01 * i)), Vec3(1.5 * (i - 0.5 * (count - 1)), 0.02 * i, 0));
      solved.push_back(surface::solve_surfaces(set, projector));
      lit.push_back({projector.projector, &solved.back(), 1, black});
    }
  }
};

surface::BlendMap map_of_two() {
  const Row row(2);
  return surface::blend_maps(row.lit).maps[0];
}

ImageU8 some_frame() {
  ImageU8 frame(kFrame, 3);
  for (int i = 0; i < kFrame.width * kFrame.height * 3; ++i) frame.data()[i] = std::uint8_t(i * 31 % 251);
  return frame;
}

void BM_BlendFrame(benchmark::State& state) {
  const surface::FrameBlend blend(map_of_two());
  ImageU8 frame = some_frame();
  for (auto _ : state) {
    blend.apply(frame, 0, kFrame.height);
    benchmark::ClobberMemory();
  }
  state.counters["changed_percent"] = 100 * blend.changed_share();
}
BENCHMARK(BM_BlendFrame)->Unit(benchmark::kMillisecond);

/// All of its pixels, as with black that is lifted.
void BM_BlendWholeFrame(benchmark::State& state) {
  const surface::FrameBlend blend(
      surface::BlendMap{ImageF(kFrame, 1, 0.5F), ImageF(kFrame, 1, 0.7F), ImageF(kFrame, 1, 0.001F)});
  ImageU8 frame = some_frame();
  for (auto _ : state) {
    blend.apply(frame, 0, kFrame.height);
    benchmark::ClobberMemory();
  }
}
BENCHMARK(BM_BlendWholeFrame)->Unit(benchmark::kMillisecond);

/// The least that OpenCV can do: values multiplied as they are, without their light.
void BM_CvMultiply(benchmark::State& state) {
  cv::setNumThreads(1);
  ImageU8 frame = some_frame();
  cv::Mat values(kFrame.height, kFrame.width, CV_8UC3, frame.data());
  const cv::Mat gain(kFrame.height, kFrame.width, CV_32FC3, cv::Scalar::all(0.7));
  for (auto _ : state) {
    cv::multiply(values, gain, values, 1, CV_8UC3);
    benchmark::ClobberMemory();
  }
}
BENCHMARK(BM_CvMultiply)->Unit(benchmark::kMillisecond);

void BM_RenderFrame(benchmark::State& state) {
  const Row row(2);
  const ImageU8 content = some_frame();
  Scene scene;
  for (const SolvedSurface& surface : row.solved[0].surfaces) {
    SceneItem& item = scene.items.emplace_back();
    item.placement = surface.placement;
    item.content = content.view();
  }
  render::RenderOptions options;
  options.threads = 1;
  render::CpuRenderer renderer(options);
  ImageU8 frame(kFrame, 3);
  std::uint64_t revision = 0;
  for (auto _ : state) {
    ++revision;
    for (SceneItem& item : scene.items) item.content_revision = revision;
    renderer.render(scene, row.lit[0].projector, frame);
    benchmark::ClobberMemory();
  }
}
BENCHMARK(BM_RenderFrame)->Unit(benchmark::kMillisecond);

/// {projectors, threads, black}: the map of one of them, as a show makes it.
void BM_OneMap(benchmark::State& state) {
  const Row row(int(state.range(0)), state.range(2) != 0 ? 0.001 : 0);
  surface::BlendOptions options;
  options.only = std::size_t(state.range(0) / 2);
  options.threads = int(state.range(1));
  for (auto _ : state) benchmark::DoNotOptimize(surface::blend_maps(row.lit, options));
}
BENCHMARK(BM_OneMap)
    ->Args({2, 1, 0})
    ->Args({2, 2, 0})
    ->Args({4, 1, 0})
    ->Args({4, 2, 0})
    ->Args({4, 2, 1})
    ->MeasureProcessCPUTime()
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

/// {projectors, threads}
void BM_AllMaps(benchmark::State& state) {
  const Row row(int(state.range(0)));
  surface::BlendOptions options;
  options.threads = int(state.range(1));
  for (auto _ : state) benchmark::DoNotOptimize(surface::blend_maps(row.lit, options));
}
BENCHMARK(BM_AllMaps)
    ->Args({2, 1})
    ->Args({2, 2})
    ->Args({4, 2})
    ->MeasureProcessCPUTime()
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
