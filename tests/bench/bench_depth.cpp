/// Planes in a depth image of 640x480, on one core, against PCL's organised multi-plane segmentation (where
/// libpcl-dev is installed; see tests/bench/CMakeLists.txt) in the same run: normals by integral images and
/// OrganizedMultiPlaneSegmentation::segmentAndRefine, as its own example does.
///
///   bench_depth                   a simulated room with Kinect noise, and real frames from PROCAM_TEST_DATA
#include <benchmark/benchmark.h>

#include "depth/rooms.hpp"
#include "procam/depth/surfaces.hpp"
#include "procam/io/depth_file.hpp"
#include "support/test_data.hpp"

#ifdef PROCAM_BENCH_PCL
#include <pcl/features/integral_image_normal.h>
#include <pcl/point_types.h>
#include <pcl/segmentation/organized_multi_plane_segmentation.h>
#endif

namespace {

using namespace procam;
using namespace procam::depth;

struct Frame {
  Image<std::uint16_t> units;
  double unit = 0.001;
  Camera camera;
};

Frame simulated() {
  const auto sensor = depth::test::lopsided_sensor();
  const auto seen = depth::test::random_room(4);
  return {simulate::depth_view(seen.room, sensor, seen.room_from_camera, 4).mm, 0.001, sensor.camera};
}

Frame real(const char* file, double unit) {
  Frame frame{{}, unit, {{640, 480}, {525, 525, 319.5, 239.5, 0}, NoDistortion{}}};
  if (std::filesystem::exists(procam::test::test_data() / file))
    frame.units = io::load_depth(procam::test::test_data() / file);
  return frame;
}

void find(benchmark::State& state, const Frame& frame) {
  if (frame.units.empty()) return state.SkipWithError("no test data");
  const RayTable rays(frame.camera);
  const DepthImage image(frame.units.view(), frame.unit);
  std::size_t planes = 0;
  for (auto _ : state) planes = find_planes(image, rays).planes.size();
  state.counters["planes"] = double(planes);
}

void place(benchmark::State& state, const Frame& frame) {
  if (frame.units.empty()) return state.SkipWithError("no test data");
  const RayTable rays(frame.camera);
  const DepthImage image(frame.units.view(), frame.unit);
  const Planes planes = find_planes(image, rays);
  for (auto _ : state) benchmark::DoNotOptimize(surfaces_from_planes(planes, image, rays, {Vec3(0, -1, 0)}));
}

#ifdef PROCAM_BENCH_PCL
void pcl_planes(benchmark::State& state, const Frame& frame) {
  if (frame.units.empty()) return state.SkipWithError("no test data");
  const RayTable rays(frame.camera);
  const DepthImage image(frame.units.view(), frame.unit);
  pcl::PointCloud<pcl::PointXYZ>::Ptr cloud(new pcl::PointCloud<pcl::PointXYZ>(640, 480));
  cloud->is_dense = false;
  for (int y = 0; y < 480; ++y)
    for (int x = 0; x < 640; ++x) {
      const float z = image.at(x, y), none = std::numeric_limits<float>::quiet_NaN();
      pcl::PointXYZ& p = cloud->at(std::size_t(x), std::size_t(y));
      p = z > 0 ? pcl::PointXYZ(z * rays.u(x, y), z * rays.v(x, y), z) : pcl::PointXYZ(none, none, none);
    }
  std::size_t planes = 0;
  for (auto _ : state) {
    pcl::IntegralImageNormalEstimation<pcl::PointXYZ, pcl::Normal> normals;
    normals.setNormalEstimationMethod(normals.COVARIANCE_MATRIX);
    normals.setMaxDepthChangeFactor(0.02f);
    normals.setNormalSmoothingSize(20.0f);
    normals.setInputCloud(cloud);
    pcl::PointCloud<pcl::Normal>::Ptr found(new pcl::PointCloud<pcl::Normal>);
    normals.compute(*found);
    pcl::OrganizedMultiPlaneSegmentation<pcl::PointXYZ, pcl::Normal, pcl::Label> segmentation;
    segmentation.setMinInliers(1000);
    segmentation.setAngularThreshold(0.0524);
    segmentation.setDistanceThreshold(0.03);
    segmentation.setInputNormals(found);
    segmentation.setInputCloud(cloud);
    std::vector<pcl::PlanarRegion<pcl::PointXYZ>, Eigen::aligned_allocator<pcl::PlanarRegion<pcl::PointXYZ>>>
        regions;
    segmentation.segmentAndRefine(regions);
    planes = regions.size();
  }
  state.counters["planes"] = double(planes);
}
BENCHMARK_CAPTURE(pcl_planes, simulated, simulated())->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(pcl_planes, redwood, real("rgbd/redwood/depth_00000.png", 0.001))
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(pcl_planes, tum, real("rgbd/tum/TUM_depth.png", 0.0002))->Unit(benchmark::kMillisecond);
#endif

BENCHMARK_CAPTURE(find, simulated, simulated())->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(find, redwood, real("rgbd/redwood/depth_00000.png", 0.001))->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(find, tum, real("rgbd/tum/TUM_depth.png", 0.0002))->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(place, simulated, simulated())->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(place, redwood, real("rgbd/redwood/depth_00000.png", 0.001))->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
