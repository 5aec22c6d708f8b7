/// Frames that go elsewhere than to a window: do all of them arrive, whole?
#include <gtest/gtest.h>

#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <random>
#include <thread>

#include "procam/device/frame_sink.hpp"
#include "procam/device/shared_frame.hpp"
#include "procam/io/image/images.hpp"

namespace procam::device {
namespace {

namespace fs = std::filesystem;

class Sink : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "procam_sink_XXXXXX").string();
    folder_ = mkdtemp(name.data());
    options_.size = {323, 241};
    options_.fps = 25;
  }
  void TearDown() override { fs::remove_all(folder_); }
  std::string at(const std::string& name) const { return (folder_ / name).string(); }

  static ImageU8 noise(ImageSize size, int channels, unsigned seed) {
    std::mt19937 random(seed);
    ImageU8 picture(size, channels);
    for (int i = 0; i < size.width * size.height * channels; ++i) picture.data()[i] = std::uint8_t(random());
    return picture;
  }
  static bool same(ViewU8 a, ViewU8 b) {
    for (int y = 0; y < a.height; ++y)
      if (!std::equal(a.row(y), a.row(y) + a.width * a.channels, b.row(y))) return false;
    return a.size() == b.size() && a.channels == b.channels;
  }

  fs::path folder_;
  SinkOptions options_;
};

TEST_F(Sink, FramesBecomeFiles) {
  const auto sink = open_sink("frames:" + at("made/for/them"), options_);
  const ImageU8 colour = noise(options_.size, 3, 1), grey = noise(options_.size, 1, 2);
  sink->show(colour);
  sink->show_next(grey);
  EXPECT_TRUE(same(io::load_image(at("made/for/them/frame_000000.png")).image, colour));
  EXPECT_TRUE(same(io::load_image(at("made/for/them/frame_000001.png")).image, grey));
  EXPECT_THROW(sink->show(ImageU8(322, 241, 3)), std::invalid_argument);
  EXPECT_THROW(sink->show(ImageU8(323, 241, 4)), std::invalid_argument);
}

/// FFV1 loses nothing but what colour spaces round: three grey levels.
TEST_F(Sink, AVideoHasAllFramesOrDoesNotExist) {
  ImageU8 picture(320, 240, 3);
  options_.size = picture.size();
  {
    const auto sink = open_sink("video:" + at("run.mkv"), options_);
    for (int i = 0; i < 7; ++i) {
      for (int y = 0; y < 240; ++y)
        for (int x = 0; x < 320; ++x) {
          picture.at(x, y, 0) = std::uint8_t(20 + 30 * i);
          picture.at(x, y, 1) = std::uint8_t(x * 200 / 320);
          picture.at(x, y, 2) = std::uint8_t(y);
        }
      sink->show_next(picture);
      EXPECT_FALSE(fs::exists(at("run.mkv"))) << "not under its name before it is whole";
    }
    sink->finish();
  }
  cv::VideoCapture video(at("run.mkv"));
  EXPECT_NEAR(video.get(cv::CAP_PROP_FPS), 25, 0.1);
  cv::Mat frame;
  int frames = 0;
  for (; video.read(frame); ++frames) {
    const cv::Vec3b pixel = frame.at<cv::Vec3b>(200, 160);  // B G R
    EXPECT_NEAR(pixel[2], 20 + 30 * frames, 3);
    EXPECT_NEAR(pixel[1], 100, 3);
    EXPECT_NEAR(pixel[0], 200, 3);
  }
  EXPECT_EQ(frames, 7);
  open_sink("video:" + at("none.mp4"), options_);
  EXPECT_TRUE(fs::exists(at("run.mkv")));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 1) << "not finished, no file";
}

TEST_F(Sink, SharedMemoryHasTheNewestFrame) {
  const std::string name = "procam_test_" + std::to_string(getpid());
  EXPECT_THROW(SharedFrameReader{name}, Error);
  {
    const auto sink = open_sink("shm:" + name, options_);
    const SharedFrameReader reader(name);
    EXPECT_EQ(reader.size(), options_.size);
    EXPECT_FALSE(reader.newest());
    for (unsigned i = 1; i < 6; ++i) {
      const ImageU8 picture = noise(options_.size, 3, i);
      const double time = sink->show(picture);
      const auto seen = reader.newest(i - 1);
      ASSERT_TRUE(seen);
      EXPECT_EQ(seen->number, i);
      EXPECT_EQ(seen->time_s, time);
      EXPECT_TRUE(same(seen->image, picture));
      EXPECT_FALSE(reader.newest(i)) << "nothing newer";
    }
    const ImageU8 grey = noise(options_.size, 1, 9);
    sink->show(grey);
    const auto seen = reader.newest();
    for (int c = 0; c < 3; ++c) EXPECT_EQ(seen->image.at(7, 5, c), grey.at(7, 5));
  }
  EXPECT_THROW(SharedFrameReader{name}, Error) << "it is gone with its writer";
}

/// The memory's owner may do with it what it wants: the reader sees no frame, and lives.
TEST_F(Sink, SharedMemoryThatIsCutShortEndsNobody) {
  const std::string name = "procam_cut_" + std::to_string(getpid()), file = "/dev/shm/" + name;
  const auto sink = open_sink("shm:" + name, options_);
  sink->show(noise(options_.size, 3, 1));
  const SharedFrameReader reader(name);
  ASSERT_TRUE(reader.newest());
  EXPECT_FALSE(reader.is_orphan());
  for (const std::uintmax_t size : {std::uintmax_t(100000), std::uintmax_t(70), std::uintmax_t(0)}) {
    fs::resize_file(file, size);
    EXPECT_FALSE(reader.newest());
    EXPECT_TRUE(reader.is_orphan());
    EXPECT_THROW(SharedFrameReader{name}, Error);
  }
  sink->show(noise(options_.size, 3, 2));  // nor does it end the writer
}

TEST_F(Sink, SharedMemoryOfNonsenseIsRefused) {
  const std::string name = "procam_nonsense_" + std::to_string(getpid()), file = "/dev/shm/" + name;
  const auto header = [&](std::uint32_t width, std::uint32_t height) {
    std::string bytes("PROCAMF1");
    for (const std::uint32_t number : {width, height, 3u, 3u})
      bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
    bytes.resize(64);
    std::ofstream(file, std::ios::binary) << bytes;
    const std::uintmax_t slot = (64 + std::uintmax_t(width) * height * 3 + 63) / 64 * 64;
    fs::resize_file(file, 64 + 3 * slot);  // sparse: it takes no memory
    std::string why;
    try {
      const SharedFrameReader reader(name);
    } catch (const Error& error) {
      why = error.what();
    }
    fs::remove(file);
    return why;
  };
  EXPECT_EQ(header(40, 30), "");
  for (const auto& [width, height] : {std::pair(0u, 0u), std::pair(0u, 30u), std::pair(16384u, 8193u),
                                      std::pair(65535u, 65535u), std::pair(1u << 31, 1u)})
    EXPECT_NE(header(width, height).find("it does not hold frames of procam"), std::string::npos)
        << width << " x " << height;
}

TEST_F(Sink, SharedMemoryHasOneWriterAndANameKeepsItsOwner) {
  const std::string name = "procam_owner_" + std::to_string(getpid()), file = "/dev/shm/" + name;
  auto first = open_sink("shm:" + name, options_);
  try {
    open_sink("shm:" + name, options_);
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kDevice);
    EXPECT_NE(std::string(error.what()).find("another program writes frames to it"), std::string::npos);
  }
  first->show(noise(options_.size, 3, 1));
  EXPECT_TRUE(SharedFrameReader(name).newest()) << "the second left the first alone";
  fs::remove(file);
  std::ofstream(file) << "of another program";
  first.reset();
  EXPECT_TRUE(fs::exists(file)) << "only its own memory is removed";
  first = open_sink("shm:" + name, options_);  // what a killed program left
  first->show(noise(options_.size, 3, 1));
  EXPECT_TRUE(SharedFrameReader(name).newest());
}

/// A reader beside a writer that does not wait: every frame that it gets is of one number.
TEST_F(Sink, SharedFramesAreNeverTorn) {
  const std::string name = "procam_torn_" + std::to_string(getpid());
  const auto sink = open_sink("shm:" + name, options_);
  std::atomic<bool> ends{false};
  std::thread writer([&] {
    ImageU8 picture(options_.size, 3);
    for (unsigned i = 1; !ends; ++i) {
      std::fill(picture.data(), picture.data() + 323 * 241 * 3, std::uint8_t(i));
      sink->show(picture);
    }
  });
  const SharedFrameReader reader(name);
  std::uint64_t last = 0;
  int frames = 0;
  for (int i = 0; i < 100000 && frames < 300; ++i)
    if (const auto seen = reader.newest(last)) {
      ++frames;
      ASSERT_GT(seen->number, last);
      last = seen->number;
      const std::uint8_t value = std::uint8_t(seen->number);
      ASSERT_TRUE(std::all_of(seen->image.data(), seen->image.data() + 323 * 241 * 3,
                              [&](std::uint8_t pixel) { return pixel == value; }))
          << "frame " << last;
    }
  ends = true;
  writer.join();
  EXPECT_GT(frames, 10);
}

TEST_F(Sink, WhatCannotBeOpenedIsSaid) {
  for (const char* text : {"", "frames", "frames:", "video:", "tape:x", "shm:", "shm:a/b", "none:x"})
    EXPECT_THROW(open_sink(text, options_), Error) << text;
  EXPECT_THROW(open_sink("video:" + at("run.gif"), options_), Error);
  EXPECT_THROW(open_sink("video:" + at("nowhere/run.mkv"), options_), Error);
  EXPECT_THROW(open_sink("frames:/proc/frames", options_), Error);
  options_.size = {};
  EXPECT_THROW(open_sink("none", options_), std::invalid_argument);
}

TEST(FindDisplay, ByNumberNameOrPlace) {
  std::vector<Display> list(3);
  for (int i = 0; i < 3; ++i) list[std::size_t(i)].number = i, list[std::size_t(i)].size = {1280 + i, 720};
  list[0].name = "DELL U2414";
  list[1].name = "EPSON PJ";
  list[2].name = "EPSON PJ 2";
  list[1].x = 1280;
  list[2].x = 1280, list[2].y = -720;
  EXPECT_EQ(find_display(list, "2").number, 2);
  EXPECT_EQ(find_display(list, "DELL").number, 0);
  EXPECT_EQ(find_display(list, "EPSON PJ").number, 1) << "its whole name goes before a part of another's";
  EXPECT_EQ(find_display(list, "1280,0").number, 1);
  EXPECT_EQ(find_display(list, "1400,-1").number, 2);
  for (const char* text : {"", "3", "EPSON", "BENQ", "5000,0", "99999999999999999999"})
    EXPECT_THROW(find_display(list, text), Error) << text;
  EXPECT_THROW(find_display({}, "0"), Error);
}

}  // namespace
}  // namespace procam::device
