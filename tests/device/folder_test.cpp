/// Pictures that a separate camera writes into a folder.
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <thread>

#include "procam/device/depth_source.hpp"
#include "procam/device/frame_sink.hpp"
#include "procam/device/frame_source.hpp"
#include "procam/io/files.hpp"
#include "procam/io/image/depth_file.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/image/pfm.hpp"

namespace procam::device {
namespace {

namespace fs = std::filesystem;

class WatchedFolder : public ::testing::Test {
 protected:
  WatchedFolder() {
    std::string name = (fs::temp_directory_path() / "procam_device_XXXXXX").string();
    folder_ = mkdtemp(name.data());
  }
  ~WatchedFolder() override {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }

  static ImageU8 picture(int grey) {
    ImageU8 image(37, 23, 1, std::uint8_t(grey));
    image.at(3, 5) = 255;
    return image;
  }
  void append(const std::string& name, const std::string& bytes) const {
    std::ofstream(folder_ / name, std::ios::binary | std::ios::app) << bytes;
  }

  fs::path folder_;
};

TEST_F(WatchedFolder, HandsOutNewPicturesInOrderOnceEach) {
  io::save_image(folder_ / "old.png", picture(9));
  const auto source = watch_folder(folder_);
  const double begin = now_s();
  for (int i = 0; i < 3; ++i) {
    io::save_image(folder_ / ("b" + std::to_string(9 - i) + ".png"), picture(10 * i));
    append("notes.txt", "no picture");
    const auto frame = source->next(begin, 5);
    ASSERT_TRUE(frame) << i;
    EXPECT_EQ(frame->image.at(0, 0), 10 * i);
    EXPECT_GT(frame->time_s, begin);
    EXPECT_LE(frame->time_s, now_s());
  }
  EXPECT_FALSE(source->next(begin, 0.05)) << "a picture was handed out twice, or an old one";
}

/// Cameras that write one name again and again, and programs that clear the folder.
TEST_F(WatchedFolder, ANameThatWasRemovedMayComeAgain) {
  const auto source = watch_folder(folder_);
  const double begin = now_s();
  for (int i = 0; i < 3; ++i) {
    io::save_image(folder_ / "newest.png", picture(10 + i));
    const auto frame = source->next(begin, 5);
    ASSERT_TRUE(frame) << i;
    EXPECT_EQ(frame->image.at(0, 0), 10 + i);
    fs::remove(folder_ / "newest.png");
    std::this_thread::sleep_for(std::chrono::milliseconds(100));  // some looks of the source
  }
}

TEST_F(WatchedFolder, WaitsForAPictureThatIsStillWritten) {
  const auto source = watch_folder(folder_);
  const std::string bytes = io::encode_png(picture(77));
  const double begin = now_s();
  append("slow.png", bytes.substr(0, bytes.size() / 2));
  EXPECT_FALSE(source->next(begin, 0.1)) << "half a picture was taken";
  append("slow.png", bytes.substr(bytes.size() / 2));
  const double complete = now_s();
  const auto frame = source->next(begin, 5);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->image.at(0, 0), 77);
  EXPECT_LT(frame->time_s, complete) << "the light was there when the file began";
}

TEST_F(WatchedFolder, LeavesOutFramesThatArrivedTooEarly) {
  const auto source = watch_folder(folder_);
  io::save_image(folder_ / "a.png", picture(1));
  std::this_thread::sleep_for(std::chrono::milliseconds(60));
  const double later = now_s();
  io::save_image(folder_ / "b.png", picture(2));
  const auto frame = source->next(later, 5);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->image.at(0, 0), 2);
}

TEST_F(WatchedFolder, GivesUpOnAPictureThatStaysDamaged) {
  const auto source = watch_folder(folder_, 0.1);
  append("broken.png", io::encode_png(picture(77)).substr(0, 60));
  try {
    source->next(0, 5);
    FAIL() << "a damaged picture was taken";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kDevice);
    EXPECT_NE(error.subject().find("broken.png"), std::string::npos);
  }
}

TEST_F(WatchedFolder, MustExist) {
  EXPECT_THROW(watch_folder(folder_ / "nowhere"), Error);
  const auto source = watch_folder(folder_);
  fs::remove_all(folder_);
  EXPECT_THROW(source->next(0, 5), Error) << "the folder went away";
}

TEST_F(WatchedFolder, HoldsDepthInUnitsAndInMetres) {
  const auto metres = [&](const char* name) { io::save_pfm(folder_ / name, ImageF(4, 3, 1, 1.25f)); };
  metres("2.pfm");
  io::save_depth(folder_ / "10.png", Image<std::uint16_t>(4, 3).view());
  append("notes.txt", "p");
  const auto played = open_depth("folder:" + folder_.string() + "@1000");
  auto first = played->next(0, 5);
  ASSERT_TRUE(first);
  EXPECT_EQ(std::get<ImageF>(first->pixels).at(3, 2), 1.25f) << "2 comes before 10";
  const auto second = played->next(first->time_s, 5);
  ASSERT_TRUE(second);
  EXPECT_EQ(second->pixels.index(), 0u);
  EXPECT_FALSE(second->metres_per_unit);
  const auto watched = open_depth("watch:" + folder_.string());
  metres("11.pfm");
  const auto arrived = watched->next(0, 5);
  ASSERT_TRUE(arrived);
  EXPECT_EQ(arrived->pixels.index(), 1u);
}

}  // namespace
}  // namespace procam::device
