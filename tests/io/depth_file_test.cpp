/// Depth images in files: 16 bits as they are, floats in metres, and nothing else.
#include "procam/io/image/depth_file.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <limits>
#include <opencv2/imgcodecs.hpp>

#include "image/pfm_bytes.hpp"
#include "procam/io/files.hpp"
#include "procam/io/image/pfm.hpp"
#include "support/expect_error.hpp"

namespace procam::io {
namespace {

class DepthFile : public ::testing::Test {
 protected:
  DepthFile() {
    std::string name = (std::filesystem::temp_directory_path() / "procam_depth_XXXXXX").string();
    folder_ = mkdtemp(name.data());
  }
  ~DepthFile() override {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  std::filesystem::path folder_;
};

TEST_F(DepthFile, HoldsUnitsOrMetres) {
  Image<std::uint16_t> units(7, 5);
  ImageF metres(7, 5);
  cv::Mat tiff(5, 7, CV_32FC1);
  for (int y = 0; y < 5; ++y)
    for (int x = 0; x < 7; ++x) {
      units.at(x, y) = std::uint16_t(1000 * x + 9000 * y);
      tiff.at<float>(y, x) = metres.at(x, y) = 0.5f + 0.31f * float(x) + 0.07f * float(y);
    }
  tiff.at<float>(2, 3) = metres.at(3, 2) = std::numeric_limits<float>::quiet_NaN();
  save_depth(folder_ / "units.png", units.view());
  save_pfm(folder_ / "metres.pfm", metres.view());
  ASSERT_TRUE(cv::imwrite((folder_ / "metres.tif").string(), tiff));
  const auto read_units = std::get<Image<std::uint16_t>>(load_depth_pixels(folder_ / "units.png"));
  EXPECT_TRUE(std::equal(units.data(), units.data() + 35, read_units.data()));
  for (const char* name : {"metres.pfm", "metres.tif"}) {
    const auto read = std::get<ImageF>(load_depth_pixels(folder_ / name));
    ASSERT_EQ(read.size(), metres.size()) << name;
    for (int i = 0; i < 35; ++i)
      EXPECT_TRUE(read.data()[i] == metres.data()[i] ||
                  (std::isnan(read.data()[i]) && std::isnan(metres.data()[i])))
          << name << " " << i;
  }
  EXPECT_ERROR(load_depth(folder_ / "metres.tif"), kUnsupported, "16 bits");
}

TEST_F(DepthFile, RefusesWhatIsNoDepth) {
  ASSERT_TRUE(cv::imwrite((folder_ / "colour.tif").string(), cv::Mat(5, 7, CV_32FC3, cv::Scalar::all(1))));
  ASSERT_TRUE(cv::imwrite((folder_ / "grey.png").string(), cv::Mat(5, 7, CV_8UC1, cv::Scalar::all(1))));
  save_pfm(folder_ / "colour.pfm", ImageF(7, 5, 3).view());
  for (const char* name : {"colour.tif", "grey.png", "colour.pfm"})
    EXPECT_ERROR(load_depth_pixels(folder_ / name), kUnsupported, "one channel");
  const std::string whole = encode_pfm(ImageF(7, 5).view());
  write_file_atomically(folder_ / "cut.pfm", std::string_view(whole).substr(0, whole.size() / 2));
  EXPECT_ERROR(load_depth_pixels(folder_ / "cut.pfm"), kInput, "cut.pfm");
}

}  // namespace
}  // namespace procam::io
