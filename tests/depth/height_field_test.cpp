/// Uneven sand that moves before a Kinect's noise, and what the field says of it at the moment of the light.
#include "procam/depth/height_field.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "procam/core/base/error.hpp"
#include "procam/depth/height_picture.hpp"
#include "support/expect_error.hpp"
#include "support/sand.hpp"

namespace procam::depth {
namespace {

using procam::test::sand;
using procam::test::SandBox;

constexpr double kPeriod = 1.0 / 30, kDelay = 0.06;  // from an exposure to the light

struct Errors {
  double rms = 0, percentile_95 = 0, within_3_sigma = 0, known = 0;
};

/// Of the map at the light, a cell's border omitted, against the sand then.
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

/// Sand that moves sideways and up and down at the given speeds; the worst of the last 12 images of 30.
Errors follow(const SandBox& box, double sideways, double up) {
  std::optional<HeightField> field;
  ReferencePlane plane;
  const RayTable rays(box.sensor.camera);
  Errors worst{0, 0, 1, 1};
  for (int i = 0; i < 30; ++i) {
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
    if (i < 18) continue;
    const Errors now = errors_of(field->at(light), box.room_from_camera * plane.camera_from_reference,
                                 shift_at(light), rise_at(light));
    worst.rms = std::max(worst.rms, now.rms);
    worst.percentile_95 = std::max(worst.percentile_95, now.percentile_95);
    worst.within_3_sigma = std::min(worst.within_3_sigma, now.within_3_sigma);
    worst.known = std::min(worst.known, now.known);
  }
  std::printf(
      "%g m, sideways %g m/s, up %g m/s: RMS %.2f mm, 95 %% %.2f mm, within 3 sigma %.4f, known %.4f\n",
      box.distance, sideways, up, 1e3 * worst.rms, 1e3 * worst.percentile_95, worst.within_3_sigma,
      worst.known);
  return worst;
}

TEST(HeightField, MovingSandIsWhereItIsSaidToBeAtTheMomentOfTheLight) {
  struct Motion {
    double metres, sideways, up, largest;
  };
  for (const Motion& motion : {Motion{1, 0.2, 0, 0.003}, Motion{2, 0, 0.2, 0.005}}) {
    const Errors worst = follow(SandBox(motion.metres), motion.sideways, motion.up);
    EXPECT_LT(worst.percentile_95, motion.largest);
    EXPECT_GT(worst.within_3_sigma, 0.98);
    EXPECT_GT(worst.known, 0.99);
  }
}

/// Sand that lies still, and the field after some images of it.
struct StillSand {
  SandBox box{1};
  RayTable rays{box.sensor.camera};
  ReferencePlane plane;
  std::optional<HeightField> field;
  double time = 0;

  explicit StillSand(int images) { add(box.room(0, 0), images); }
  void add(const simulate::Room& now, int images = 1) {
    simulate::DepthView seen = box.view(now, std::uint64_t(1000 * time) + 3);
    for (int i = 0; i < images; ++i) {
      if (i > 0) seen = read_again(std::move(seen), box.sensor, std::uint64_t(1000 * time) + 3);
      add(seen);
    }
  }
  void add(const simulate::DepthView& seen) {
    const DepthImage image(seen.mm.view(), 0.001);
    if (!field) {
      plane = fit_reference_plane(image, rays);
      field.emplace(plane.size);
    }
    field->update(image, rays, plane.camera_from_reference.inverse(), time += kPeriod);
  }
  /// The cell that is square under a point of the room.
  std::array<int, 2> cell_at(const Vec2& place, double above) const {
    const Vec3 seen =
        (box.room_from_camera * plane.camera_from_reference).inverse() * Vec3(place.x(), place.y(), -above);
    return {int(seen.x() / 0.01), int(seen.y() / 0.01)};
  }
  Errors errors() const {
    return errors_of(field->at(time + kDelay), box.room_from_camera * plane.camera_from_reference, 0, 0);
  }
};

TEST(HeightField, AHandIsNotFusedAndTheSandUnderItIsThereAgainWhenItIsGone) {
  StillSand sandbox(15);
  const double before = sandbox.errors().percentile_95;
  const Vec2 place(0.08, -0.05);
  for (int i = 0; i < 20; ++i)
    sandbox.add(SandBox::with_hand(sandbox.box.room(0, 0), place + Vec2(0.004 * i, 0), 0.15));
  const Vec2 last = place + Vec2(0.004 * 19, 0);
  const auto [column, row] = sandbox.cell_at(last, 0.15);
  EXPECT_TRUE(sandbox.field->is_covered(column, row));
  const HeightMap map = sandbox.field->at(sandbox.time + kDelay);
  EXPECT_FALSE(map.is_known(column, row)) << "content would be drawn on the hand";
  const Errors beside = sandbox.errors();
  EXPECT_LT(beside.percentile_95, 1.5 * before) << "the hand is in the surface";
  EXPECT_GT(beside.known, 0.85);
  sandbox.add(sandbox.box.room(0, 0), 10);
  EXPECT_GT(sandbox.errors().known, 0.999);
  EXPECT_LT(sandbox.errors().percentile_95, 1.5 * before);
}

TEST(HeightField, WhatIsPutDownIsPartOfTheSurfaceOnceItHasRested) {
  StillSand sandbox(10);
  const Vec2 place(-0.06, 0.07);
  const auto [column, row] = sandbox.cell_at(place, 0.1);
  const simulate::Room put = SandBox::with_hand(sandbox.box.room(0, 0), place, 0.06);
  sandbox.add(put, 50);
  EXPECT_FALSE(sandbox.field->at(sandbox.time).is_known(column, row)) << "after 1.7 s";
  sandbox.add(put, 25);
  const HeightMap map = sandbox.field->at(sandbox.time);
  ASSERT_TRUE(map.is_known(column, row)) << "after 2.5 s";
  EXPECT_GT(map.height.at(column, row), 0.08);
  // Taken away, the sand is there at once: nobody is below it.
  sandbox.add(sandbox.box.room(0, 0), 10);
  EXPECT_LT(sandbox.errors().percentile_95, 0.003);
}

TEST(HeightField, HolesWithoutReadingsStayUnlessTheyAreNarrow) {
  const SandBox box(1);
  const RayTable rays(box.sensor.camera);
  auto pixels = box.seen(box.room(0, 0), 5);
  const ReferencePlane plane = fit_reference_plane(DepthImage(pixels.view(), 0.001), rays);
  const auto blind = [&](int x0, int width) {
    for (int y = 0; y < 480; ++y)
      for (int x = x0; x < x0 + width; ++x) pixels.at(x, y) = 0;
  };
  blind(200, 12);  // 20 mm
  blind(400, 47);  // 80 mm
  HeightField field(plane.size);
  for (int i = 0; i < 5; ++i)
    field.update(DepthImage(pixels.view(), 0.001), rays, plane.camera_from_reference.inverse(), i * kPeriod);
  const HeightMap map = field.at(4 * kPeriod);
  const auto column_of = [&](int x) {
    const Vec3 ray(rays.u(x, 240), rays.v(x, 240), 1);
    return int((plane.camera_from_reference.inverse() * ray).x() / 0.01);
  };
  EXPECT_TRUE(map.is_known(column_of(206), 30));
  EXPECT_FALSE(map.is_known(column_of(424), 30));
  EXPECT_LT(errors_of(map, box.room_from_camera * plane.camera_from_reference, 0, 0).percentile_95, 0.006);
  const auto mesh = mesh_of(map);
  EXPECT_FALSE(fault_of(*mesh));
}

TEST(HeightField, RegionsAndImagesThatCannotBeAreRefusedWithTheirReason) {
  const SandBox box(1);
  const RayTable rays(box.sensor.camera);
  auto pixels = box.seen(box.room(0, 0), 5);
  const DepthImage image(pixels.view(), 0.001);
  EXPECT_ERROR((fit_reference_plane(image, rays, PixelRegion{500, 100, 200, 100})), kInput,
               "not inside of the depth image of 640x480");
  for (int y = 100; y < 300; ++y)
    for (int x = 100; x < 300; ++x) pixels.at(x, y) = 0;
  EXPECT_ERROR((fit_reference_plane(image, rays, PixelRegion{100, 100, 200, 200})), kNotEnoughData,
               "readings in 0 of");
  EXPECT_THROW(HeightField(Vec2(0.01, 1)), std::invalid_argument);
  HeightField field(Vec2(0.3, 0.2));
  const Pose nowhere(Eigen::Quaterniond::Identity(), Vec3(0, 0, std::nan("")));
  EXPECT_THROW(field.update(image, rays, nowhere, 0), std::invalid_argument);
  EXPECT_TRUE(mesh_of(field.at(0))->triangles.empty());
}

TEST(HeightPicture, OfANarrowRangeHasItsTwoEnds) {
  HeightMap map{0.01, ImageF(5, 3), ImageF(5, 3, 1, 0.001f)};
  for (int y = 0; y < 3; ++y)
    for (int x = 0; x < 5; ++x) map.height.at(x, y) = x < 2 ? -0.1f : 0.1f;
  HeightColours colours;
  colours.lowest = 0;
  colours.highest = 1e-12;
  ImageU8 picture(5, 3, 3);
  draw_heights(map, colours, picture.view());
  EXPECT_EQ(picture.at(0, 1, 0), colour_of(-0.1, colours)[0]);
  EXPECT_EQ(picture.at(4, 1, 0), colour_of(0.1, colours)[0]);
  EXPECT_NE(picture.at(0, 1, 0), picture.at(4, 1, 0));
}

TEST(HeightPicture, ContoursLieAtMultiplesAndHolesAreBlack) {
  // A ramp along x of 0.25, lopsided, with a hole.
  HeightMap map{0.01, ImageF(41, 23), ImageF(41, 23, 1, 0.001f)};
  for (int y = 0; y < 23; ++y)
    for (int x = 0; x < 41; ++x) map.height.at(x, y) = float(0.0025 * x - 0.03);
  map.sigma.at(30, 10) = 0;
  HeightColours colours;
  colours.contours = 0.02;
  colours.line_width = 0.004;
  ImageU8 picture(41 * 8, 23 * 8, 3);
  draw_heights(map, colours, picture.view());
  int lines = 0;
  for (int x = 4; x < 41 * 8 - 4; ++x) {
    const double height = 0.0025 * ((x + 0.5) / 8 - 0.5) - 0.03;
    const double off = std::abs(height / 0.02 - std::round(height / 0.02)) * 0.02;
    const bool is_black = picture.at(x, 30, 0) + picture.at(x, 30, 1) + picture.at(x, 30, 2) == 0;
    // Half a line is 2 mm, of a slope of a quarter 0.5 mm of height; a texel is 0.3 mm.
    if (off < 0.0003) EXPECT_TRUE(is_black) << x;
    if (off > 0.0007) EXPECT_FALSE(is_black) << x;
    lines += is_black;
  }
  EXPECT_GE(lines, 8);
  EXPECT_EQ(picture.at(30 * 8 + 4, 10 * 8 + 4, 1), 0);
  EXPECT_LT(colour_of(-0.1, colours)[0], colour_of(0.1, colours)[0]);
  colours.lowest = colours.highest;
  EXPECT_THROW(draw_heights(map, colours, picture.view()), std::invalid_argument);
}

}  // namespace
}  // namespace procam::depth
