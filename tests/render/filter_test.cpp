/// Filtering: against a 16 x 16 supersampled reference at grazing light and strong minification, and against
/// OpenCV's warp where the picture is about its own size.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <opencv2/imgproc.hpp>

#include "procam/render/cpu.hpp"
#include "render/rooms.hpp"

namespace procam {
namespace {

using render::RenderOptions;

/// Value at (u, v) of the content, 0..255, bilinear as in a textbook.
double bilinear(const ImageU8& image, const Vec2& uv) {
  const double x = std::min(std::max(uv.x() * image.width() - 0.5, 0.0), image.width() - 1.0);
  const double y = std::min(std::max(uv.y() * image.height() - 0.5, 0.0), image.height() - 1.0);
  const int x0 = std::min(int(x), image.width() - 2), y0 = std::min(int(y), image.height() - 2);
  const double a = x - x0, b = y - y0;
  return (1 - b) * ((1 - a) * image.at(x0, y0) + a * image.at(x0 + 1, y0)) +
         b * ((1 - a) * image.at(x0, y0 + 1) + a * image.at(x0 + 1, y0 + 1));
}

/// Mean over n x n points of the pixel, each cast onto the sheet; nullopt where the content does not fill it.
std::optional<double> supersampled(const Projector& projector, const Sheet& sheet, const ImageU8& content,
                                   int x, int y, int n) {
  double sum = 0;
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const auto p = sheet.landed(projector, Vec2(x + (i + 0.5) / n - 0.5, y + (j + 0.5) / n - 0.5));
      if (!p) return std::nullopt;
      const Vec2 uv(p->x() / sheet.width + 0.4, p->y() / sheet.height + 0.55);
      if (uv.minCoeff() < 0 || uv.maxCoeff() > 1) return std::nullopt;
      sum += bilinear(content, uv);
    }
  return sum / (n * n);
}

struct Psnr {
  double rendered, point_sampled;
};

Psnr psnr(const Projector& projector, const Sheet& sheet, const ImageU8& content) {
  Scene scene;
  scene.items.push_back({sheet.placement, content});
  const ImageU8 frame = render::render(scene, projector, options(false, 0));
  double error = 0, point_error = 0;
  int count = 0;
  for (int y = 0; y < frame.height(); ++y)
    for (int x = 0; x < frame.width(); ++x) {
      if (!supersampled(projector, sheet, content, x, y, 2)) continue;
      const auto truth = supersampled(projector, sheet, content, x, y, 16);
      if (!truth) continue;
      error += std::pow(frame.at(x, y) - *truth, 2);
      point_error += std::pow(*supersampled(projector, sheet, content, x, y, 1) - *truth, 2);
      ++count;
    }
  EXPECT_GT(count, 5000);
  return {10 * std::log10(65025.0 * count / error), 10 * std::log10(65025.0 * count / point_error)};
}

/// Frequency rises from the middle to half a cycle a texel at the middle of each side.
ImageU8 zone_plate(int width, int height) {
  ImageU8 image(width, height);
  const double pi = std::acos(-1.0);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const double dx = (x - 0.5 * width) / width, dy = (y - 0.5 * height) / height;
      image.at(x, y) =
          std::uint8_t(std::lround(127.5 + 127.5 * std::cos(pi * (width * dx * dx + height * dy * dy))));
    }
  return image;
}

ImageU8 stripes(int width, int height, int period) {
  ImageU8 image(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) image.at(x, y) = (x + y / 3) % period < period / 2 ? 255 : 0;
  return image;
}

struct FilterCase {
  const char* name;
  int size;  ///< of the content, texels a side
  double incidence_deg;
};

class Filter : public testing::TestWithParam<FilterCase> {};

// At 1.6 m a pixel is 0.85 mm across the light: 512 texels on the sheet are two a pixel (four along the
// grazing direction at 60 degrees), 3000 twelve (24).
TEST_P(Filter, HasNoAliasing) {
  const Projector projector = lopsided_projector();
  const Sheet sheet = tilted_sheet(projector, 0.2, 0.211, 1.6, GetParam().incidence_deg);
  const int n = GetParam().size;
  for (const std::string name : {"zone_plate", "stripes"}) {
    const ImageU8 content = name == "stripes" ? stripes(n, n - 12, 6) : zone_plate(n, n - 12);
    const Psnr measured = psnr(projector, sheet, content);
    RecordProperty(name + "_psnr_db", std::to_string(measured.rendered));
    RecordProperty(name + "_point_sampled_db", std::to_string(measured.point_sampled));
    EXPECT_GE(measured.rendered, 38) << name;
    EXPECT_LE(measured.point_sampled, measured.rendered - 12);  // the same picture without filtering
  }
}

INSTANTIATE_TEST_SUITE_P(Scales, Filter,
                         testing::Values(FilterCase{"two_texels_47", 512, 47},
                                         FilterCase{"two_texels_60", 512, 60},
                                         FilterCase{"five_texels_60", 1200, 60},
                                         FilterCase{"twelve_texels_60", 3000, 60},
                                         FilterCase{"five_texels_75", 1200, 75}),
                         [](const auto& tested) { return tested.param.name; });

// What Filter::kBilinear promises: values as they stand, one sample at the pixel's centre.
TEST(Filtering, BilinearIsOneSampleAtThePixelsCentre) {
  const Projector projector = lopsided_projector();
  const Sheet sheet = tilted_sheet(projector, 0.2, 0.211, 1.6, 60);
  const ImageU8 content = zone_plate(900, 888);
  Scene scene;
  scene.items.push_back({sheet.placement, content});
  RenderOptions bilinear_values = options(false, 0);
  bilinear_values.filter = render::Filter::kBilinear;
  const ImageU8 frame = render::render(scene, projector, bilinear_values);
  int count = 0;
  for (int y = 0; y < frame.height(); ++y)
    for (int x = 0; x < frame.width(); ++x) {
      const auto filled = [&](int dx, int dy) {
        return supersampled(projector, sheet, content, x + dx, y + dy, 1).has_value();
      };
      if (!filled(-1, -1) || !filled(1, -1) || !filled(-1, 1) || !filled(1, 1)) continue;
      const auto truth = supersampled(projector, sheet, content, x, y, 1);
      // Half a value of rounding, and positions in 1/128 texel: half of that times 255 at the steepest.
      ASSERT_NEAR(frame.at(x, y), *truth, 0.5 + 1.0 + 0.1) << x << " " << y;
      ++count;
    }
  EXPECT_GT(count, 5000);
}

// Black and white lines finer than a pixel give half the light, which is value 188, as on the wall from afar.
TEST(Filtering, AveragesLightNotNumbers) {
  const Projector projector = lopsided_projector();
  const Sheet sheet = tilted_sheet(projector, 0.2, 0.211, 1.6, 47);
  const ImageU8 content = stripes(2400, 2400, 2);
  Scene scene;
  scene.items.push_back({sheet.placement, content});
  const ImageU8 frame = render::render(scene, projector);
  EXPECT_NEAR(frame.at(540, 361), 188, 2);
  EXPECT_NEAR(render::render(scene, projector, options(false, 0)).at(540, 361), 128, 2);
}

// cv::warpPerspective quantises positions to 1/32 pixel, so a steep picture differs by some values.
TEST(Filtering, AgreesWithOpenCVForAMildHomography) {
  const ImageU8 content = [] {
    ImageU8 image(320, 240, 3);
    for (int y = 0; y < 240; ++y)
      for (int x = 0; x < 320; ++x) {
        image.at(x, y, 0) = std::uint8_t(std::lround(127 + 120 * std::sin(x / 9.0 + y / 17.0)));
        image.at(x, y, 1) = std::uint8_t(x * 255 / 319);
        image.at(x, y, 2) = std::uint8_t(std::lround(127 + 120 * std::cos(x / 31.0) * std::sin(y / 11.0)));
      }
    return image;
  }();
  PlacedPixels placed;
  placed.pixel_from_content << 560, 40, 210.3, -25, 470, 160.8, 0.11, 0.06, 1;
  Mat3 content_from_texel;
  content_from_texel << 1.0 / 320, 0, 0.5 / 320, 0, 1.0 / 240, 0.5 / 240, 0, 0, 1;
  const Mat3 pixel_from_texel = placed.pixel_from_content * content_from_texel;

  const Projector projector = lopsided_projector();
  Scene scene;
  scene.items.push_back({placed, content});
  const ImageU8 frame = render::render(scene, projector, options(false, 0));

  const cv::Mat source(240, 320, CV_8UC3, const_cast<std::uint8_t*>(content.data()));
  const cv::Matx33d matrix(pixel_from_texel(0, 0), pixel_from_texel(0, 1), pixel_from_texel(0, 2),
                           pixel_from_texel(1, 0), pixel_from_texel(1, 1), pixel_from_texel(1, 2),
                           pixel_from_texel(2, 0), pixel_from_texel(2, 1), pixel_from_texel(2, 2));
  cv::Mat warped;
  cv::warpPerspective(source, warped, matrix, cv::Size(1024, 768), cv::INTER_LINEAR, cv::BORDER_REPLICATE);

  double sum = 0;
  int worst = 0, count = 0;
  const Mat3 content_from_pixel = placed.pixel_from_content.inverse();
  for (int y = 0; y < 768; ++y)
    for (int x = 0; x < 1024; ++x) {
      const Vec2 uv = (content_from_pixel * Vec3(x, y, 1)).hnormalized();
      if (uv.minCoeff() < 0.01 || uv.maxCoeff() > 0.99) continue;
      for (int c = 0; c < 3; ++c) {
        const int difference = std::abs(int(frame.at(x, y, c)) - int(warped.at<cv::Vec3b>(y, x)[c]));
        worst = std::max(worst, difference);
        sum += difference;
        ++count;
      }
    }
  ASSERT_GT(count, 300000);
  EXPECT_LE(worst, 2);
  EXPECT_LT(sum / count, 0.3);
}

// Light is what 8-bit frames are made of, finer; numbers come out as they went in.
TEST(RenderLight, IsTheFramesLightBeforeItIsRounded) {
  const Projector projector = lopsided_projector(brown(-0.19));
  ImageU8 picture(256, 16, 3);
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 256; ++x)
      for (int c = 0; c < 3; ++c) picture.at(x, y, c) = std::uint8_t((x + 50 * c) % 256);
  for (const bool linear_light : {true, false})
    for (const render::Filter filter : {render::Filter::kArea, render::Filter::kBilinear}) {
      render::RenderOptions chosen = options(linear_light, 1);
      chosen.filter = filter;
      Scene scene;
      scene.items.push_back({tilted_sheet(projector, 0.6, 0.4, 1.6, 30).placement, picture});
      scene.background[1] = 77;
      const ImageU8 values = render::render(scene, projector, chosen);
      ImageF light(projector.size(), 3, -1.0f);
      render::CpuRenderer(chosen).render(scene, projector, light);
      const auto encoded = [](double l) {
        return 255 * (l <= 0.0031308 ? 12.92 * l : 1.055 * std::pow(l, 1 / 2.4) - 0.055);
      };
      double worst = 0;
      bool finer = false;
      for (int y = 0; y < values.height(); ++y)
        for (int x = 0; x < values.width(); ++x)
          for (int c = 0; c < 3; ++c) {
            const double l = double(light.at(x, y, c)), value = linear_light ? encoded(l) : 255 * l;
            worst = std::max(worst, std::abs(value - values.at(x, y, c)));
            finer = finer || std::abs(value - std::round(value)) > 0.2;
          }
      EXPECT_LT(worst, linear_light ? 0.71 : 0.52) << "rounded to 8 bits, by steps of 1/8160 of the light";
      EXPECT_EQ(finer, linear_light || filter == render::Filter::kArea);
      EXPECT_NEAR(double(light.at(3, 3, 1)), linear_light ? light_of(77) : 77 / 255.0, 4e-5);
    }
}

}  // namespace
}  // namespace procam
