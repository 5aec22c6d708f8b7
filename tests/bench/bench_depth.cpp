/// Planes in a depth image of 640x480, on one core, against PCL's organised multi-plane segmentation (where
/// libpcl-dev is installed; see tests/bench/CMakeLists.txt) in the same run: normals by integral images and
/// OrganizedMultiPlaneSegmentation::segmentAndRefine, with the settings of its own example (3 degrees, 2 cm,
/// normals smoothed over 20 pixels) and with wider ones that suit a Kinect's noise (5 degrees, 3 cm, 30
/// pixels).
///
///   bench_depth                   a simulated room with Kinect noise, and real frames from PROCAM_TEST_DATA;
///                                 `quality` scores both on 20 simulated rooms by the rule of
///                                 tests/depth/rooms.hpp, in its counters
#include <benchmark/benchmark.h>

#include "depth/rooms.hpp"
#include "procam/depth/height_picture.hpp"
#include "procam/depth/surfaces.hpp"
#include "procam/io/image/depth_file.hpp"
#include "support/sand.hpp"
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

/// One image of a live shape. The peer is find_planes() of the same image, for the ratio.
struct Sand {
  procam::test::SandBox box{1};
  Image<std::uint16_t> units = box.seen(box.room(0, 0), 1);
  RayTable rays{box.sensor.camera};
  DepthImage image{units.view(), 0.001};
  ReferencePlane plane = fit_reference_plane(image, rays);
  HeightField field{plane.size};
  double time = 0;

  void update() { field.update(image, rays, plane.camera_from_reference.inverse(), time += 1.0 / 30); }
};

void fuse_heights(benchmark::State& state) {
  Sand sand;
  for (auto _ : state) sand.update();
  state.counters["cells"] = sand.field.columns() * sand.field.rows();
}
void planes_of_sand(benchmark::State& state) {
  const Sand sand;
  for (auto _ : state) benchmark::DoNotOptimize(find_planes(sand.image, sand.rays));
}
/// What a frame of the show needs of it besides drawing.
void mesh_of_heights(benchmark::State& state) {
  Sand sand;
  for (int i = 0; i < 5; ++i) sand.update();
  for (auto _ : state) benchmark::DoNotOptimize(mesh_of(sand.field.at(sand.time + 0.05)));
}
void colours_of_heights(benchmark::State& state) {
  Sand sand;
  for (int i = 0; i < 5; ++i) sand.update();
  const HeightMap map = sand.field.at(sand.time);
  ImageU8 picture(5 * map.height.width(), 5 * map.height.height(), 3);
  HeightColours colours;
  colours.contours = 0.02;
  for (auto _ : state) draw_heights(map, colours, picture.view());
}
BENCHMARK(fuse_heights)->Unit(benchmark::kMillisecond);
BENCHMARK(planes_of_sand)->Unit(benchmark::kMillisecond);
BENCHMARK(mesh_of_heights)->Unit(benchmark::kMillisecond);
BENCHMARK(colours_of_heights)->Unit(benchmark::kMillisecond);

void place(benchmark::State& state, const Frame& frame) {
  if (frame.units.empty()) return state.SkipWithError("no test data");
  const RayTable rays(frame.camera);
  const DepthImage image(frame.units.view(), frame.unit);
  const Planes planes = find_planes(image, rays);
  for (auto _ : state) benchmark::DoNotOptimize(surfaces_from_planes(planes, image, rays, {Vec3(0, -1, 0)}));
}

/// How well planes of simulated rooms are found; the rooms are not among those that served for tuning.
template <typename Find>
void score(benchmark::State& state, const Find& find) {
  depth::test::Score score;
  for (auto _ : state) {
    score = {};
    for (std::uint64_t seed = 101; seed <= 120; ++seed)
      depth::test::add_score(depth::test::random_room(seed), depth::test::lopsided_sensor(), seed, score,
                             find);
  }
  state.counters["found_%"] = 100.0 * score.found / score.there;
  state.counters["false_%"] = 100.0 * score.wrong / score.planes;
  state.counters["normal_deg"] = depth::test::Score::median(score.angles_deg);
  state.counters["offset_mm"] = 1e3 * depth::test::Score::median(score.offsets);
}
void quality(benchmark::State& state) {
  score(state, [](const DepthImage& image, const RayTable& rays) { return find_planes(image, rays); });
}

#ifdef PROCAM_BENCH_PCL
struct PclSettings {
  float smoothing;  ///< pixels
  double angle_deg, distance;
};
constexpr PclSettings kExample{20, 3, 0.02}, kWider{30, 5, 0.03};

pcl::PointCloud<pcl::PointXYZ>::Ptr cloud_of(const DepthImage& image, const RayTable& rays) {
  const int width = rays.size().width, height = rays.size().height;
  pcl::PointCloud<pcl::PointXYZ>::Ptr cloud(
      new pcl::PointCloud<pcl::PointXYZ>(std::uint32_t(width), std::uint32_t(height)));
  cloud->is_dense = false;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const float z = image.at(x, y), none = std::numeric_limits<float>::quiet_NaN();
      cloud->at(x, y) =
          z > 0 ? pcl::PointXYZ(z * rays.u(x, y), z * rays.v(x, y), z) : pcl::PointXYZ(none, none, none);
    }
  return cloud;
}

struct PclPlanes {
  std::vector<pcl::ModelCoefficients> planes;
  std::vector<pcl::PointIndices> pixels;
};
PclPlanes segment(const pcl::PointCloud<pcl::PointXYZ>::Ptr& cloud, const PclSettings& settings) {
  pcl::IntegralImageNormalEstimation<pcl::PointXYZ, pcl::Normal> normals;
  normals.setNormalEstimationMethod(normals.COVARIANCE_MATRIX);
  normals.setMaxDepthChangeFactor(0.02f);
  normals.setNormalSmoothingSize(settings.smoothing);
  normals.setInputCloud(cloud);
  pcl::PointCloud<pcl::Normal>::Ptr found(new pcl::PointCloud<pcl::Normal>);
  normals.compute(*found);
  pcl::OrganizedMultiPlaneSegmentation<pcl::PointXYZ, pcl::Normal, pcl::Label> segmentation;
  segmentation.setMinInliers(1000);
  segmentation.setAngularThreshold(settings.angle_deg * kDegree);
  segmentation.setDistanceThreshold(settings.distance);
  segmentation.setInputNormals(found);
  segmentation.setInputCloud(cloud);
  std::vector<pcl::PlanarRegion<pcl::PointXYZ>, Eigen::aligned_allocator<pcl::PlanarRegion<pcl::PointXYZ>>>
      regions;
  PclPlanes out;
  pcl::PointCloud<pcl::Label>::Ptr labels(new pcl::PointCloud<pcl::Label>);
  std::vector<pcl::PointIndices> of_label, borders;
  segmentation.segmentAndRefine(regions, out.planes, out.pixels, labels, of_label, borders);
  return out;
}

void pcl_planes(benchmark::State& state, const Frame& frame) {
  if (frame.units.empty()) return state.SkipWithError("no test data");
  const RayTable rays(frame.camera);
  const auto cloud = cloud_of(DepthImage(frame.units.view(), frame.unit), rays);
  std::size_t planes = 0;
  for (auto _ : state) planes = segment(cloud, kExample).planes.size();
  state.counters["planes"] = double(planes);
}

void pcl_quality(benchmark::State& state, const PclSettings& settings) {
  score(state, [&](const DepthImage& image, const RayTable& rays) {
    const auto cloud = cloud_of(image, rays);
    const PclPlanes found = segment(cloud, settings);
    Planes out;
    out.labels = Image<std::int16_t>(rays.size(), 1, Planes::kNone);
    for (std::size_t i = 0; i < found.planes.size(); ++i) {
      const std::vector<float>& c = found.planes[i].values;
      DetectedPlane plane;
      const Vec3 normal = Eigen::Vector3f(c[0], c[1], c[2]).cast<double>();
      const double side = c[3] < 0 ? -1 : 1;  // towards the camera
      plane.estimate.plane = {side * normal / normal.norm(), side * double(c[3]) / normal.norm()};
      plane.estimate.covariance.setIdentity();  // it states none
      plane.pixels = int(found.pixels[i].indices.size());
      for (const int at : found.pixels[i].indices) {
        out.labels.data()[at] = std::int16_t(i);
        plane.middle += (*cloud)[std::size_t(at)].getVector3fMap().cast<double>() / plane.pixels;
      }
      out.planes.push_back(plane);
    }
    return out;
  });
}
BENCHMARK_CAPTURE(pcl_quality, example, kExample)->Unit(benchmark::kMillisecond)->Iterations(1);
BENCHMARK_CAPTURE(pcl_quality, wider, kWider)->Unit(benchmark::kMillisecond)->Iterations(1);
BENCHMARK_CAPTURE(pcl_planes, simulated, simulated())->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(pcl_planes, redwood, real("rgbd/redwood/depth_00000.png", 0.001))
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(pcl_planes, tum, real("rgbd/tum/TUM_depth.png", 0.0002))->Unit(benchmark::kMillisecond);
#endif

BENCHMARK(quality)->Unit(benchmark::kMillisecond)->Iterations(1);
BENCHMARK_CAPTURE(find, simulated, simulated())->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(find, redwood, real("rgbd/redwood/depth_00000.png", 0.001))->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(find, tum, real("rgbd/tum/TUM_depth.png", 0.0002))->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(place, simulated, simulated())->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(place, redwood, real("rgbd/redwood/depth_00000.png", 0.001))->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
