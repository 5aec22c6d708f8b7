/// Light follows the truth: what render() draws is measured in the frame, cast through the true projector
/// onto the true plane, and compared with the target in millimetres.
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "procam/core/base/closed_form.hpp"
#include "procam/render/cpu.hpp"
#include "render/rooms.hpp"

namespace procam {
namespace {

/// A line in the plane: points x with normal . x = offset.
struct Line {
  Vec2 normal;
  double offset;
};

Line fit_line(const Points2& points) {
  Vec2 mean = Vec2::Zero();
  for (const Vec2& p : points) mean += p / double(points.size());
  Mat2 scatter = Mat2::Zero();
  for (const Vec2& p : points) scatter += (p - mean) * (p - mean).transpose();
  const Vec2 normal = symmetric_eigen(scatter).vectors.col(1);
  return {normal, normal.dot(mean)};
}

Vec2 meet(const Line& a, const Line& b) {
  Mat2 m;
  m << a.normal.transpose(), b.normal.transpose();
  return m.inverse() * Vec2(a.offset, b.offset);
}

/// Sub-pixel position where a white area's border crosses the row (or column) of `near`, from the light
/// summed over a window: exact for a border that is straight within the pixel. `along` runs along the border,
/// `inwards` points to the white.
Vec2 border_crossing(const ImageU8& frame, const Vec2& near, const Vec2& along, const Vec2& inwards) {
  const int axis = std::abs(along.x()) < std::abs(along.y()) ? 0 : 1;
  constexpr int kReach = 5;
  const int from = int(std::lround(near[axis])) - kReach, fixed = int(std::lround(near[1 - axis]));
  double white = 0;
  for (int i = from; i <= from + 2 * kReach; ++i)
    white += light_of(axis == 0 ? frame.at(i, fixed) : frame.at(fixed, i));
  Vec2 crossing;
  crossing[1 - axis] = fixed;
  crossing[axis] = inwards[axis] > 0 ? from + 2 * kReach + 0.5 - white : from - 0.5 + white;
  return crossing;
}

/// Largest distance between a corner of the sheet and where the lit area's corner lands, in mm.
double corner_error_mm(const Projector& projector, const Sheet& sheet, const Projector& drawn_with) {
  const ImageU8 white(64, 48, 1, 255);
  Scene scene;
  scene.items.push_back({sheet.placement, white});
  const ImageU8 frame = render::render(scene, drawn_with);
  const std::array<Vec2, 4> corners{Vec2(0, 0), Vec2(1, 0), Vec2(1, 1), Vec2(0, 1)};
  std::array<Line, 4> sides;
  for (std::size_t k = 0; k < 4; ++k) {
    Points2 landed;
    for (int i = 3; i <= 37; ++i) {
      const Vec2 uv = corners[k] + (corners[(k + 1) % 4] - corners[k]) * (i / 40.0);
      const auto pixel_of = [&](const Vec2& p) {
        return *drawn_with.project(sheet.in_projector(p.x(), p.y()));
      };
      const Vec2 side = corners[(k + 1) % 4] - corners[k], near = pixel_of(uv);
      const Vec2 along = pixel_of(uv + 0.01 * side) - near;
      const Vec2 inwards = pixel_of(uv + 0.01 * Vec2(-side.y(), side.x())) - near;
      landed.push_back(*sheet.landed(projector, border_crossing(frame, near, along, inwards)));
    }
    sides[k] = fit_line(landed);
  }
  double worst = 0;
  for (std::size_t k = 0; k < 4; ++k) {
    const Vec2 corner = meet(sides[(k + 3) % 4], sides[k]);
    worst = std::max(worst, (corner - sheet.plane_point(corners[k].x(), corners[k].y())).norm());
  }
  return 1e3 * worst;
}

/// Largest distance between the centre of a disc on the sheet and the centroid of its light there, in mm.
double disc_error_mm(const Projector& projector, const Sheet& sheet) {
  const int n = 512;
  ImageU8 picture(n, n, 1, 0);
  const auto centre = [](int i) { return 0.14 + 0.36 * i; };
  const double radius = 0.07;
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x)
      for (int j = 0; j < 3; ++j)
        for (int i = 0; i < 3; ++i)
          if (Vec2((x + 0.5) / n - centre(i), (y + 0.5) / n - centre(j)).norm() < radius)
            picture.at(x, y) = 255;
  Scene scene;
  scene.items.push_back({sheet.placement, picture});
  const ImageU8 frame = render::render(scene, projector);

  double moment[3][3][3] = {};  // light, light * X, light * Y
  for (int y = 1; y + 1 < frame.height(); ++y)
    for (int x = 1; x + 1 < frame.width(); ++x) {
      if (frame.at(x, y) == 0) continue;
      const Vec2 p = *sheet.landed(projector, Vec2(x, y));
      Mat2 spread;  // d (metres) / d (pixel)
      spread << *sheet.landed(projector, Vec2(x + 0.5, y)) - *sheet.landed(projector, Vec2(x - 0.5, y)),
          *sheet.landed(projector, Vec2(x, y + 0.5)) - *sheet.landed(projector, Vec2(x, y - 0.5));
      const double light = light_of(frame.at(x, y)) * std::abs(spread.determinant());
      const Vec3 uv = sheet.placement.plane_from_content.inverse() * Vec3(p.x(), p.y(), 1);
      const int i = int(std::lround((uv.x() - 0.14) / 0.36)), j = int(std::lround((uv.y() - 0.14) / 0.36));
      if (i < 0 || j < 0 || i > 2 || j > 2) continue;
      moment[j][i][0] += light;
      moment[j][i][1] += light * p.x();
      moment[j][i][2] += light * p.y();
    }
  double worst = 0;
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 3; ++i) {
      const Vec2 seen(moment[j][i][1] / moment[j][i][0], moment[j][i][2] / moment[j][i][0]);
      worst = std::max(worst, (seen - sheet.plane_point(centre(i), centre(j))).norm());
    }
  return 1e3 * worst;
}

struct Case {
  const char* name;
  Distortion distortion;
};

class Landing : public testing::TestWithParam<Case> {};

TEST_P(Landing, CornersAreWithinAFifthOfAMillimetre) {
  const Projector projector = lopsided_projector(GetParam().distortion);
  double worst = 0;
  for (const double distance : {1.2, 1.6, 2.2})
    for (const double incidence : {47.0, 60.0}) {
      const Sheet sheet =
          tilted_sheet(projector, incidence == 47 ? 0.202 : 0.1485, 0.211, distance, incidence);
      const double error = corner_error_mm(projector, sheet, projector);
      EXPECT_LT(error, 0.2) << "at " << distance << " m, " << incidence << " degrees";
      worst = std::max(worst, error);
    }
  RecordProperty("worst_mm", std::to_string(worst));
}

TEST_P(Landing, DiscsAreWithinAFifthOfAMillimetre) {
  const Projector projector = lopsided_projector(GetParam().distortion);
  double worst = 0;
  for (const double incidence : {47.0, 60.0}) {
    const Sheet sheet = tilted_sheet(projector, incidence == 47 ? 0.202 : 0.1485, 0.211, 1.6, incidence);
    const double error = disc_error_mm(projector, sheet);
    EXPECT_LT(error, 0.2) << "at " << incidence << " degrees";
    worst = std::max(worst, error);
  }
  RecordProperty("worst_mm", std::to_string(worst));
}

INSTANTIATE_TEST_SUITE_P(Lenses, Landing,
                         testing::Values(Case{"pinhole", NoDistortion{}}, Case{"barrel", brown(-0.2)},
                                         Case{"pincushion", brown(0.15)},
                                         Case{"rational", RationalDistortion{{0.11, -0.04, 0.0008, 0.0012,
                                                                              0.01, 0.3, 0.02, 0}}},
                                         Case{"fisheye", FisheyeDistortion{{0.02, -0.006, 0.001, 0}}}),
                         [](const auto& tested) { return tested.param.name; });

// Leaving the lens out, or the skew, or centring the principal point must be seen.
TEST(LandingWithAWrongProjector, IsFarOff) {
  const Projector projector = lopsided_projector(brown(-0.2));
  const Sheet sheet = tilted_sheet(projector, 0.202, 0.211, 1.6, 47);
  Projector no_lens = projector, no_skew = projector;
  no_lens.inverse_camera.distortion = NoDistortion{};
  no_skew.inverse_camera.intrinsics.skew = 0;
  EXPECT_GT(corner_error_mm(projector, sheet, no_lens), 5);
  EXPECT_GT(corner_error_mm(projector, sheet, no_skew), 0.4);
}

}  // namespace
}  // namespace procam
