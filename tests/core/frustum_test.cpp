#include "procam/core/lens/frustum.hpp"

#include <gtest/gtest.h>

#include "procam/core/lens/camera.hpp"
#include "support/lopsided.hpp"

namespace procam {
namespace {

constexpr double kNear = 0.13, kFar = 27;
const ImageSize kSize{1024, 768};
const Intrinsics kSkewed{1210.0, 1175.0, 517.3, 860.9, 2.7};  // cy below the picture
const GraphicsApi kApis[] = {GraphicsApi::kOpenGL, GraphicsApi::kVulkan, GraphicsApi::kDirect3D};

Intrinsics without_skew() {
  Intrinsics k = kSkewed;
  k.skew = 0;
  return k;
}

/// The pixel that the graphics pipeline fills for a point: perspective division, then the viewport's map from
/// [-1, 1] to [0, W], whose integer + 1/2 is a pixel's centre.
Vec2 pixel_by_pipeline(const Mat4& clip_from_optical, const Vec3& point, GraphicsApi api) {
  const Vec4 clip = clip_from_optical * point.homogeneous();
  const Vec3 ndc = clip.head<3>() / clip[3];
  const double down = api == GraphicsApi::kVulkan ? ndc.y() : -ndc.y();
  return Vec2((ndc.x() + 1) / 2 * kSize.width - 0.5, (down + 1) / 2 * kSize.height - 0.5);
}

double worst_pixel_error(const Intrinsics& for_matrix, const Intrinsics& truth, GraphicsApi api) {
  const Camera camera{kSize, truth, NoDistortion{}};
  const Mat4 clip = clip_from_optical(for_matrix, kSize, kNear, kFar, api);
  double worst = 0;
  for (const Vec3& point : {Vec3(0.1, -0.6, 1.9), Vec3(-0.7, -0.3, 2.2), Vec3(0.01, -0.02, 0.2)})
    worst = std::max(worst, (pixel_by_pipeline(clip, point, api) - *camera.project(point)).norm());
  return worst;
}

TEST(Frustum, EveryApiFillsThePixelThatTheCameraProjectsTo) {
  for (const GraphicsApi api : kApis) EXPECT_LT(worst_pixel_error(kSkewed, kSkewed, api), 1e-9);
}

TEST(Frustum, DroppingTheHalfPixelOrTheSkewWouldShow) {
  Intrinsics half_dropped = kSkewed;
  half_dropped.cx -= 0.5;
  half_dropped.cy -= 0.5;
  for (const GraphicsApi api : kApis) {
    EXPECT_NEAR(worst_pixel_error(half_dropped, kSkewed, api), std::sqrt(0.5), 1e-9);
    EXPECT_GT(worst_pixel_error(without_skew(), kSkewed, api), 0.3);
  }
}

TEST(Frustum, DepthRunsFromNearToFar) {
  for (const GraphicsApi api : kApis) {
    const Mat4 clip = clip_from_optical(kSkewed, kSize, kNear, kFar, api);
    const auto depth = [&](double z) {
      const Vec4 c = clip * Vec4(0.3 * z, -0.2 * z, z, 1);
      return c[2] / c[3];
    };
    EXPECT_NEAR(depth(kNear), api == GraphicsApi::kOpenGL ? -1 : 0, 1e-12);
    EXPECT_NEAR(depth(kFar), 1, 1e-12);
    EXPECT_LT(depth(1), depth(2));
  }
}

/// glFrustum(l, r, b, t, n, f), OpenGL 2.1 specification, section 2.11.2:
///   | 2n/(r-l)     0      (r+l)/(r-l)       0      |
///   |    0      2n/(t-b)  (t+b)/(t-b)       0      |
///   |    0         0     -(f+n)/(f-n)  -2fn/(f-n)  |
///   |    0         0          -1            0      |
Mat4 gl_frustum(const Frustum& g) {
  Mat4 m;
  m << 2 * g.near / (g.right - g.left), 0, (g.right + g.left) / (g.right - g.left), 0,     //
      0, 2 * g.near / (g.top - g.bottom), (g.top + g.bottom) / (g.top - g.bottom), 0,      //
      0, 0, -(g.far + g.near) / (g.far - g.near), -2 * g.far * g.near / (g.far - g.near),  //
      0, 0, -1, 0;
  return m;
}

TEST(Frustum, TheSixNumbersAreTheMatrixWithoutSkew) {
  const Frustum six = frustum(without_skew(), kSize, kNear, kFar);
  EXPECT_LT(
      (gl_frustum(six) - clip_from_eye(without_skew(), kSize, kNear, kFar, GraphicsApi::kOpenGL)).norm(),
      1e-13);
  EXPECT_NEAR(six.left, -kNear * 517.8 / 1210, 1e-15);
  EXPECT_NEAR(six.right, kNear * (1024 - 517.8) / 1210, 1e-15);
  EXPECT_NEAR(six.top, kNear * 861.4 / 1175, 1e-15);
  EXPECT_NEAR(six.bottom, -kNear * (768 - 861.4) / 1175, 1e-15);
  EXPECT_GT(six.bottom, 0);  // lens shift: the whole picture lies above the axis
}

TEST(Frustum, TheSixNumbersAreTheImagesEdgesAtNear) {
  const Frustum six = frustum(without_skew(), kSize, kNear, kFar);
  const Vec2 top_left = without_skew().normalized_from_pixel(Vec2(-0.5, -0.5)) * kNear;
  const Vec2 bottom_right = without_skew().normalized_from_pixel(Vec2(1023.5, 767.5)) * kNear;
  EXPECT_NEAR(six.left, top_left.x(), 1e-15);
  EXPECT_NEAR(six.top, -top_left.y(), 1e-15);
  EXPECT_NEAR(six.right, bottom_right.x(), 1e-15);
  EXPECT_NEAR(six.bottom, -bottom_right.y(), 1e-15);
}

TEST(Frustum, SkewAddsOneNumberToOpenGlsMatrix) {
  const Mat4 difference = clip_from_eye(kSkewed, kSize, kNear, kFar, GraphicsApi::kOpenGL) -
                          clip_from_eye(without_skew(), kSize, kNear, kFar, GraphicsApi::kOpenGL);
  Mat4 expected = Mat4::Zero();
  expected(0, 1) = -2 * kSkewed.skew / kSize.width;
  EXPECT_LT((difference - expected).norm(), 1e-15);
  EXPECT_THROW(frustum(kSkewed, kSize, kNear, kFar), std::invalid_argument);
}

TEST(Frustum, EyeFramesAreTheApisOwn) {
  const Vec4 right_down_ahead(1, 2, 3, 1);
  EXPECT_EQ(Vec4(eye_from_optical(GraphicsApi::kOpenGL) * right_down_ahead), Vec4(1, -2, -3, 1));
  EXPECT_EQ(Vec4(eye_from_optical(GraphicsApi::kVulkan) * right_down_ahead), Vec4(1, 2, 3, 1));
  EXPECT_EQ(Vec4(eye_from_optical(GraphicsApi::kDirect3D) * right_down_ahead), Vec4(1, -2, 3, 1));
  for (const GraphicsApi api : kApis)
    EXPECT_LT((clip_from_eye(kSkewed, kSize, kNear, kFar, api) * eye_from_optical(api) -
               clip_from_optical(kSkewed, kSize, kNear, kFar, api))
                  .norm(),
              1e-15);
}

TEST(Frustum, RefusesWhatHasNoMatrix) {
  const auto clip = [](Intrinsics k, ImageSize size, double near, double far) {
    return clip_from_optical(k, size, near, far, GraphicsApi::kOpenGL);
  };
  EXPECT_THROW(clip(kSkewed, {0, 768}, kNear, kFar), std::invalid_argument);
  EXPECT_THROW(clip(kSkewed, kSize, 0, kFar), std::invalid_argument);
  EXPECT_THROW(clip(kSkewed, kSize, 2, 1), std::invalid_argument);
  EXPECT_THROW(clip(kSkewed, kSize, kNear, INFINITY), std::invalid_argument);
  Intrinsics bad = kSkewed;
  bad.cx = std::nan("");
  EXPECT_THROW(clip(bad, kSize, kNear, kFar), std::invalid_argument);
  bad = kSkewed;
  bad.fy = -1;
  EXPECT_THROW(clip(bad, kSize, kNear, kFar), std::invalid_argument);
}

}  // namespace
}  // namespace procam
