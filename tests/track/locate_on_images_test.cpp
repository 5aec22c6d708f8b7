// From rendered images of markers to light on the wall.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <opencv2/imgproc.hpp>

#include "marker_sightings.hpp"
#include "procam/core/geometry/planar_pose.hpp"
#include "procam/core/geometry/plane.hpp"
#include "procam/core/lens/projector.hpp"
#include "procam/detect/marker_edges.hpp"
#include "procam/simulate/marker_view.hpp"
#include "procam/track/locate.hpp"
#include "support/lopsided.hpp"

namespace procam::track {
namespace {

MarkerMap one_marker() {
  MarkerMap map;
  map.dictionary = MarkerDictionary::kAprilTag36h11;
  map.markers = {{3, 0.16, Pose()}};
  return map;
}

const MarkerCells& codes() {
  static const MarkerCells value = detect::marker_cells(MarkerDictionary::kAprilTag36h11);
  return value;
}

/// What most programs do: corners by cornerSubPix, then the pose of the plane.
Pose pose_by_corner_subpix(ImageU8& image, const Camera& camera, const SeenMarker& start) {
  std::vector<cv::Point2f> corners;
  for (const Vec2& corner : start.corners) corners.push_back({float(corner.x()), float(corner.y())});
  cv::cornerSubPix(cv::Mat(image.height(), image.width(), CV_8U, image.row(0)), corners, {5, 5}, {-1, -1},
                   {cv::TermCriteria::EPS + cv::TermCriteria::COUNT, 50, 1e-4});
  Points2 on_plane, normalised;
  for (std::size_t i = 0; i < 4; ++i) {
    on_plane.push_back(marker_corners()[i] * 0.16);
    const Vec3 bearing = *camera.unproject(Vec2(corners[i].x, corners[i].y));
    normalised.push_back(bearing.head<2>() / bearing.z());
  }
  return planar_pose(on_plane, normalised).best().camera_from_plane;
}

/// A grid of points on the wall (the marker's plane) is lit as the estimated pose says: squared distance of
/// the true light from it, mm^2, mean.
double light_error2(const Projector& projector, const Pose& truth, const Pose& estimated) {
  const Plane wall_in_projector = Plane::of_xy(truth);
  double sum = 0;
  int count = 0;
  for (int v = 40; v < 768; v += 229)
    for (int u = 40; u < 1024; u += 236) {
      const Vec3 wanted = *projector.intersect(Vec2(u, v), wall_in_projector);
      const Vec3 wanted_in_world = truth.inverse() * wanted;
      const auto pixel = projector.project(estimated * wanted_in_world);
      sum += (*projector.intersect(*pixel, wall_in_projector) - wanted).squaredNorm() * 1e6;
      ++count;
    }
  return sum / count;
}

TEST(LocateOnImages, LightLandsWithinHalfAMillimetreAtTwoMetres) {
  const Camera camera = test::wall_camera();
  const Projector projector{Camera{{1024, 768}, {1880.0, 1891.0, 498.0, 846.0, 0.0}, NoDistortion{}}};
  const Pose projector_from_camera(so3_exp(Vec3(0.07, -0.11, 0.02)), Vec3(0.19, -0.31, -0.08));
  const MarkerMap map = one_marker();
  double edges2 = 0, corners2 = 0;
  constexpr int kImages = 6;
  for (int i = 0; i < kImages; ++i) {
    // As a rig on a robot sees a wall two metres off, from the left or from the right.
    const Pose truth(so3_exp(Vec3(0.1 + 0.05 * i, (i % 2 ? 0.45 : -0.38) + 0.03 * i, 0.2 * i - 0.4)),
                     Vec3(-0.3 + 0.1 * i, 0.12 - 0.05 * i, 2));
    simulate::MarkerViewOptions options;
    options.blur_px = 0.7 + 0.05 * i;
    options.noise = {4.0, 0};  // two grey levels
    options.seed = std::uint64_t(i);
    ImageU8 image = simulate::marker_view(camera, truth, map.markers, codes(), options);
    const MarkerDetections found = detect::detect_marker_edges(image, codes(), {camera});
    const LocateResult seen = locate(found, camera, map);
    const Pose projector_from_world = projector_from_camera * truth;
    edges2 += light_error2(projector, projector_from_world, projector_from_camera * seen.camera_from_world);
    corners2 += light_error2(projector, projector_from_world,
                             projector_from_camera * pose_by_corner_subpix(image, camera, found.markers[0]));
  }
  const double edges = std::sqrt(edges2 / kImages), corners = std::sqrt(corners2 / kImages);
  std::cout << "light on the wall: by edges " << edges << " mm rms, by cornerSubPix " << corners << " mm\n";
  EXPECT_LT(edges, 0.5);
  EXPECT_GT(corners, 5 * edges);
}

/// Cells of 2.2 to 3.2 pixels, tilted by 20 to 57 degrees: which way shows in the pixels, though in no cell's
/// edge.
TEST(LocateOnImages, SmallMarkersHaveOnePose) {
  const Camera camera{{360, 300}, {905, 893, 171, 166, 0.7}, BrownConrady{{-0.18, 0.07, 0.0011, -0.0008, 0}}};
  const MarkerMap map = one_marker();
  std::mt19937_64 random(23);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  int located = 0;
  double chi2 = 0;
  for (int i = 0; i < 12; ++i) {
    const double tilt = uniform(0.35, 1), way = uniform(0, 2 * kPi);
    const Pose truth(
        so3_exp(Vec3(tilt * std::cos(way), tilt * std::sin(way), 0)) * so3_exp(Vec3(0, 0, uniform(-3, 3))),
        Vec3(uniform(-0.3, 0.3), uniform(-0.3, 0.3), 900 * 0.16 / 8 / uniform(2.2, 3.2)));
    simulate::MarkerViewOptions options;
    options.blur_px = uniform(0.6, 1.0);
    options.seed = std::uint64_t(i);
    const ImageU8 image = simulate::marker_view(camera, truth, map.markers, codes(), options);
    const MarkerDetections found = detect::detect_marker_edges(image, codes(), {camera});
    if (found.markers.empty()) continue;  // the installed detector does not read every one
    EXPECT_TRUE(found.markers[0].edges.empty());
    const LocateResult seen = locate(found, camera, map);
    EXPECT_EQ(seen.diagnostics.find("marker_coarse"), nullptr);
    const Vec6 xi = se3_log(truth * seen.camera_from_world.inverse());
    EXPECT_LT(xi.head<3>().norm(), 0.05);
    chi2 += xi.dot(seen.covariance.ldlt().solve(xi));
    ++located;
  }
  ASSERT_GE(located, 6);
  // 6 numbers each: sigma sqrt(12) a pose; 5 sigma (false alarm 1e-5 with the skew).
  EXPECT_LT(chi2, 6 * located + 5 * std::sqrt(12.0 * located));
}

/// Gamma, glare and blurred neighbours give every edge an offset of its own, which is no fault of the map.
/// With the edges' noise alone, half of these exact maps were said to disagree. Over 100 such images:
/// docs/locate.md.
TEST(LocateOnImages, AnExactMapAgreesUnderGammaGlareAndBlur) {
  const Camera camera = test::wall_camera();
  const MarkerMap map = test::room_map();
  std::mt19937_64 random(77);
  for (int i = 0; i < 6; ++i) {
    const Pose truth(so3_exp(Vec3(test::uniform(random, -0.3, 0.3), test::uniform(random, -0.4, 0.4),
                                  test::uniform(random, -0.3, 0.3))),
                     Vec3(test::uniform(random, -0.2, 0.1), test::uniform(random, -0.25, 0.05),
                          test::uniform(random, 2.4, 4)));
    simulate::MarkerViewOptions options;
    options.gamma = 2.2;
    options.glare = 0.04;
    options.noise = {0.3, 0.01};
    options.blur_px = test::uniform(random, 2, 2.6);
    options.seed = std::uint64_t(i);
    const ImageU8 image = simulate::marker_view(camera, truth, map.markers, codes(), options);
    const LocateResult seen = locate(detect::detect_marker_edges(image, codes(), {camera}), camera, map);
    EXPECT_EQ(seen.diagnostics.find("map_disagrees"), nullptr) << i << ": " << seen.chi2_per_dof;
    EXPECT_EQ(seen.diagnostics.find("marker_left_out"), nullptr) << i;
  }
}

/// One of four markers hangs 1.5 mm off its position in the map, at 1.5 to 2.4 m: every image shows it, by
/// the same camera with gamma and glare.
TEST(LocateOnImages, AMarkerOffByMillimetresIsReported) {
  const Camera camera = test::wall_camera();
  const MarkerMap map = test::room_map();
  std::vector<PlacedMarker> hung = map.markers;
  hung[1].world_from_marker =
      Pose(Eigen::Quaterniond::Identity(), Vec3(0.0012, 0.0009, 0)) * hung[1].world_from_marker;
  std::mt19937_64 random(78);
  for (int i = 0; i < 6; ++i) {
    const Pose truth(so3_exp(Vec3(test::uniform(random, -0.2, 0.2), test::uniform(random, -0.3, 0.1),
                                  test::uniform(random, -0.3, 0.3))),
                     Vec3(test::uniform(random, -0.2, 0.1), test::uniform(random, -0.25, 0.05),
                          test::uniform(random, 1.5, 2.4)));
    simulate::MarkerViewOptions options;
    options.gamma = 2.2;
    options.glare = 0.04;
    options.blur_px = test::uniform(random, 0.8, 1.8);
    options.seed = std::uint64_t(i);
    const ImageU8 image = simulate::marker_view(camera, truth, hung, codes(), options);
    const LocateResult seen = locate(detect::detect_marker_edges(image, codes(), {camera}), camera, map);
    EXPECT_TRUE(seen.diagnostics.find("map_disagrees") != nullptr ||
                seen.diagnostics.find("marker_left_out") != nullptr)
        << i << ": " << seen.chi2_per_dof;
  }
}

TEST(LocateOnImages, CovarianceIsHonest) {
  const Camera camera{{360, 300}, {905, 893, 171, 166, 0.7}, BrownConrady{{-0.18, 0.07, 0.0011, -0.0008, 0}}};
  const MarkerMap map = one_marker();
  std::mt19937_64 random(11);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  constexpr int kImages = 64;
  double chi2 = 0;
  for (int i = 0; i < kImages; ++i) {
    const Pose truth(so3_exp(Vec3(uniform(-0.6, 0.6), uniform(0.2, 0.6), uniform(-3, 3))),
                     Vec3(uniform(-0.05, 0.05), uniform(-0.05, 0.03), uniform(1.1, 1.5)));
    simulate::MarkerViewOptions options;
    options.blur_px = uniform(0.5, 1.0);
    options.seed = std::uint64_t(i);
    const ImageU8 image = simulate::marker_view(camera, truth, map.markers, codes(), options);
    const LocateResult seen = locate(detect::detect_marker_edges(image, codes(), {camera}), camera, map);
    const Vec6 xi = se3_log(truth * seen.camera_from_world.inverse());
    chi2 += xi.dot(seen.covariance.ldlt().solve(xi));
  }
  std::cout << "chi-square over " << 6 * kImages << " degrees of freedom: " << chi2 << '\n';
  // 384 degrees of freedom, sigma 27.7. Above: 4 sigma, false alarm 6e-5. Below: 5 sigma, since a variance
  // that is enlarged where residuals exceed it is a few percent large on average.
  EXPECT_LT(chi2, 384 + 4 * 27.7);
  EXPECT_GT(chi2, 384 - 5 * 27.7);
}

}  // namespace
}  // namespace procam::track
