/// Uneven sand that moves before a Kinect's noise, and what the field says of it at the moment of the light.
#include "procam/depth/height_field.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "procam/core/base/error.hpp"
#include "procam/core/geometry/se3.hpp"
#include "procam/depth/height_picture.hpp"
#include "procam/simulate/depth_view.hpp"

namespace procam::depth {
namespace {

constexpr double kPeriod = 1.0 / 30, kDelay = 0.06;  // from an exposure to the light

/// Bumps of several widths, in metres; they move along x by `shift` and up by `rise`.
double sand(double x, double y, double shift) {
  x -= shift;
  return 0.022 * std::sin(9.1 * x + 1.3) * std::cos(7.3 * y + 0.4) + 0.015 * std::sin(17 * y + 5 * x) +
         0.02 * std::exp(-((x - 0.4) * (x - 0.4) + (y - 0.35) * (y - 0.35)) / (2 * 0.06 * 0.06));
}

struct SandBox {
  double distance = 1;
  simulate::DepthSensor sensor;
  Pose room_from_camera;  ///< the room's x right, y down, z away; sand at z = -height
  double wide = 1.3;

  explicit SandBox(double metres) : distance(metres) {
    sensor.camera = {{640, 480}, {585, 581, 316.2, 243.7, 0.3}, NoDistortion{}};
    wide = 1.3 * metres;
    room_from_camera = Pose(so3_exp(Vec3(0.06, -0.05, 0.02)), Vec3(0.02, -0.01, -metres));
  }
  simulate::Room room(double shift, double rise) const {
    constexpr int kSide = 160;
    auto mesh = std::make_shared<Mesh>();
    for (int j = 0; j <= kSide; ++j)
      for (int i = 0; i <= kSide; ++i) {
        const double x = wide * (double(i) / kSide - 0.5), y = wide * (double(j) / kSide - 0.5);
        mesh->vertices.emplace_back(x, y, -sand(x, y, shift) - rise);
        mesh->uv.emplace_back(double(i) / kSide, double(j) / kSide);
      }
    for (int j = 0; j < kSide; ++j)
      for (int i = 0; i < kSide; ++i) {
        const int a = j * (kSide + 1) + i, d = a + kSide + 1;
        mesh->triangles.push_back({a, a + 1, d + 1});
        mesh->triangles.push_back({a, d + 1, d});
      }
    simulate::Room made;
    made.bodies.push_back({"sand", simulate::TriangleMesh(mesh), Pose()});
    return made;
  }
  Image<std::uint16_t> seen(const simulate::Room& now, std::uint64_t seed) const {
    return simulate::depth_view(now, sensor, room_from_camera, seed, 2).mm;
  }
};

struct Errors {
  double rms = 0, percentile_95 = 0, within_3_sigma = 0, known = 0;
};

/// Of the map at the light, a cell's border left out, against the sand then.
Errors errors_of(const HeightMap& map, const Pose& room_from_reference, double shift, double rise) {
  std::vector<double> errors;
  double squares = 0;
  int within = 0, cells = 0;
  for (int row = 2; row + 2 < map.height.height(); ++row)
    for (int column = 2; column + 2 < map.height.width(); ++column) {
      ++cells;
      if (!map.is_known(column, row)) continue;
      const Vec3 point = room_from_reference * Vec3((column + 0.5) * map.cell, (row + 0.5) * map.cell,
                                                    -double(map.height.at(column, row)));
      const double error = -point.z() - sand(point.x(), point.y(), shift) - rise;
      errors.push_back(std::abs(error));
      squares += error * error;
      within += std::abs(error) <= 3 * double(map.sigma.at(column, row));
    }
  if (errors.empty()) return {};
  std::sort(errors.begin(), errors.end());
  return {std::sqrt(squares / double(errors.size())), errors[errors.size() * 95 / 100],
          double(within) / double(errors.size()), double(errors.size()) / cells};
}

/// Sand that moves sideways and up and down at the given speeds; the worst of the last 20 images of 40.
Errors follow(const SandBox& box, double sideways, double up) {
  std::optional<HeightField> field;
  ReferencePlane plane;
  const RayTable rays(box.sensor.camera);
  Errors worst{0, 0, 1, 1};
  for (int i = 0; i < 40; ++i) {
    const double time = i * kPeriod, light = time + kDelay;
    const auto shift_at = [&](double t) { return sideways * t; };
    const auto rise_at = [&](double t) { return up * t - (up > 0 ? 0.13 : 0.0); };
    const auto pixels = box.seen(box.room(shift_at(time), rise_at(time)), std::uint64_t(i + 1));
    const DepthImage image(pixels.view(), 0.001);
    if (!field) {
      plane = fit_reference_plane(image, rays);
      HeightFieldOptions options;
      options.max_height = 0.5;
      field.emplace(plane.size, options);
    }
    field->update(image, rays, plane.camera_from_reference.inverse(), time);
    if (i < 20) continue;
    const Errors now = errors_of(field->at(light), box.room_from_camera * plane.camera_from_reference,
                                 shift_at(light), rise_at(light));
    worst.rms = std::max(worst.rms, now.rms);
    worst.percentile_95 = std::max(worst.percentile_95, now.percentile_95);
    worst.within_3_sigma = std::min(worst.within_3_sigma, now.within_3_sigma);
    worst.known = std::min(worst.known, now.known);
  }
  std::printf("%g m, sideways %g m/s, up %g m/s: RMS %.2f mm, 95 %% %.2f mm, within 3 sigma %.4f, known %.4f\n",
              box.distance, sideways, up, 1e3 * worst.rms, 1e3 * worst.percentile_95, worst.within_3_sigma,
              worst.known);
  return worst;
}

TEST(HeightField, MovingSandIsWhereItIsSaidToBeAtTheMomentOfTheLight) {
  for (const double metres : {1.0, 2.0})
    for (const double sideways : {0.2, 0.0}) {
      const Errors worst = follow(SandBox(metres), sideways, sideways > 0 ? 0 : 0.2);
      EXPECT_LT(worst.percentile_95, metres < 1.5 ? 0.003 : 0.005);
      EXPECT_GT(worst.within_3_sigma, 0.98);
      EXPECT_GT(worst.known, 0.99);
    }
}

}  // namespace
}  // namespace procam::depth
