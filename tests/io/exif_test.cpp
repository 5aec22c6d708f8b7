#include "procam/io/image/exif.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "image/exif_bytes.hpp"
#include "image/image_check.hpp"
#include "procam/io/image/images.hpp"
#include "scratch.hpp"
#include "support/exif_picture.hpp"

namespace procam::io {
namespace {

using test::exif_block;
using test::ExifField;
using test::jpeg_with;

constexpr unsigned kFocal = 0x920a, kFilm = 0xa405, kResolution = 0xa20e, kUnit = 0xa210, kWidth = 0xa002,
                   kHeight = 0xa003, kZoom = 0xa404;

std::optional<ExifFocal> focal(const std::vector<ExifField>& fields, int width = 800, int height = 600) {
  return exif_focal_in(jpeg_with(exif_block(fields, true), width, height));
}

TEST(Exif, EquivalentFocalLengthIsByTheDiagonal) {
  for (const bool big_endian : {false, true}) {
    const auto found =
        exif_focal_in(jpeg_with(exif_block({{kFocal, 4.25, 5}, {kFilm, 28}}, big_endian), 800, 600));
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->focal_px, 1000 * 28 / std::hypot(36, 24), 1e-3);
    EXPECT_EQ(found->focal_mm, 4.25);
    EXPECT_EQ(found->description(), "28 mm equivalent");
  }
}

TEST(Exif, FocalLengthOverThePlaneResolution) {
  // 35 mm; 5000 pixels a centimetre of 4000 x 3000, the picture has 800 x 600 of them.
  const std::vector<ExifField> fields = {
      {kWidth, 4000, 4}, {kHeight, 3000}, {kFocal, 35, 5}, {kResolution, 2000, 5}, {kUnit, 3}};
  const auto found = focal(fields);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->focal_px, 35 * 200.0 / 5, 1e-6);
  EXPECT_EQ(found->description(), "35 mm");
  const auto turned = focal(fields, 600, 800);
  ASSERT_TRUE(turned);
  EXPECT_NEAR(turned->focal_px, found->focal_px, 1e-6);
  const auto inches = focal({{kFocal, 35, 5}, {kResolution, 5080, 5}});
  ASSERT_TRUE(inches);
  EXPECT_NEAR(inches->focal_px, 35 * 200.0, 1e-6);
}

TEST(Exif, NothingFromCropsZoomsAndNonsense) {
  EXPECT_FALSE(focal({}));
  EXPECT_FALSE(focal({{kFilm, 0}}));
  EXPECT_FALSE(focal({{kFilm, 28}, {kWidth, 4000}, {kHeight, 2000}}));
  EXPECT_TRUE(focal({{kFilm, 28}, {kWidth, 4000}, {kHeight, 3000}}));
  EXPECT_FALSE(focal({{kFilm, 28}, {kZoom, 2, 5}}));
  EXPECT_TRUE(focal({{kFilm, 28}, {kZoom, 1, 5}}));
  EXPECT_FALSE(focal({{kFilm, 28, 7}}));   // no number
  EXPECT_FALSE(focal({{kFilm, 65535}}));   // 1500 widths
  EXPECT_FALSE(focal({{kFocal, 35, 5}}));  // of an unknown sensor
  EXPECT_FALSE(focal({{kFocal, 35, 5}, {kResolution, 5080, 5}, {kUnit, 9}}));
}

TEST(Exif, PngAndFiles) {
  ImageU8 image(64, 48);
  const std::string png = test::png_with(exif_block({{kFilm, 40}}, false), encode_png(image.view()), crc32);
  const test::Scratch folder;
  const auto found = exif_focal(folder.write("a.png", png));
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->focal_px, 80 * 40 / std::hypot(36, 24), 1e-3);
  EXPECT_EQ(load_image(folder / "a.png").image.width(), 64);
  EXPECT_FALSE(exif_focal(folder.write("b.png", encode_png(image.view()))));
  EXPECT_FALSE(exif_focal(folder.write("c.png", "")));
  EXPECT_FALSE(exif_focal(folder / "none.png"));
}

/// Whatever the bytes are, nothing outside of them is read (with the address sanitizer), and a number is a length.
TEST(Exif, CutAndChangedBytesAreNothingOrALength) {
  const std::string block = exif_block({{kFocal, 35, 5}, {kResolution, 5080, 5}, {kFilm, 28}}, false);
  for (std::size_t size = 0; size < block.size(); ++size)
    exif_focal_in(jpeg_with(block.substr(0, size), 80, 60));
  std::mt19937 random(7);
  for (int i = 0; i < 20000; ++i) {
    std::string changed = jpeg_with(block, 80, 60);
    for (int k = 0; k < 3; ++k) changed[random() % changed.size()] = char(random());
    const auto found = exif_focal_in(changed);
    if (found) {
      EXPECT_GT(found->focal_px, 0);
      EXPECT_TRUE(std::isfinite(found->focal_px));
    }
  }
}

}  // namespace
}  // namespace procam::io
