/// Content sources: every picture is grey with its own brightness, so that it says which one it is.
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <thread>

#include "procam/device/content_source.hpp"
#include "procam/device/frame_sink.hpp"
#include "procam/device/video_file.hpp"
#include "procam/io/image/images.hpp"
#include "support/counted_allocations.hpp"

namespace procam::device {
namespace {

namespace fs = std::filesystem;

constexpr int kStep = 10;  ///< between the brightness of two pictures; MJPEG keeps it to 4

class Content : public ::testing::Test {
 protected:
  Content() {
    std::string name = (fs::temp_directory_path() / "procam_content_XXXXXX").string();
    folder_ = mkdtemp(name.data());
    options_.pace = Pace::kExact;
  }
  ~Content() override {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }

  std::string picture(const std::string& name, int number, ImageSize size = {13, 7}) const {
    io::save_image(folder_ / name, ImageU8(size, 3, std::uint8_t(kStep * number)));
    return (folder_ / name).string();
  }
  std::string video(int frames, double rate) const {
    const std::string file = (folder_ / "clip.avi").string();
    cv::VideoWriter writer(file, cv::CAP_OPENCV_MJPEG, cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), rate,
                           {64, 48});
    EXPECT_TRUE(writer.isOpened());
    for (int i = 0; i < frames; ++i)  // blue and red differ: their order is tested as well
      writer.write(cv::Mat(48, 64, CV_8UC3, cv::Scalar(0, kStep * i % 250, 200)));
    return file;
  }
  static int number(const ContentFrame& frame) { return (frame.view.at(5, 5, 1) + kStep / 2) / kStep; }
  std::string why(const std::string& what) const {
    try {
      const auto content = open_content(what, options_);
      content->at(0);
      return "it was taken";
    } catch (const Error& error) {
      return error.what();
    }
  }

  fs::path folder_;
  ContentOptions options_;
};

TEST_F(Content, AColourIsOnePixel) {
  const auto plain = open_content("#ff8001", options_);
  EXPECT_EQ(plain->at(3).view.channels, 3);
  EXPECT_EQ(plain->at(3).view.at(0, 0, 1), 0x80);
  const auto glass = open_content("color:#FF800140", options_);
  EXPECT_EQ(glass->at(0).view.channels, 4);
  EXPECT_EQ(glass->at(0).view.at(0, 0, 3), 0x40);
  for (const char* bad : {"#", "#ff80", "#ff80zz", "#ff80 1", "#+f8001", "#ff8001401", "color:red"})
    EXPECT_NE(why(bad).find("colour"), std::string::npos) << bad << " -> " << why(bad);
}

TEST_F(Content, APictureKeepsItsAlphaAndStaysTheSame) {
  ImageU8 image(9, 5, 4, 77);
  image.at(2, 3, 3) = 12;
  io::save_image(folder_ / "a@2x.png", image);
  const auto content = open_content((folder_ / "a@2x.png").string(), options_);
  const ContentFrame first = content->at(0), later = content->at(1e6);
  EXPECT_EQ(first.view.channels, 4);
  EXPECT_EQ(first.view.at(2, 3, 3), 12);
  EXPECT_EQ(first.view.data, later.view.data);
  EXPECT_EQ(first.revision, later.revision);
}

TEST_F(Content, SequencesComeInNaturalOrder) {
  for (int i : {1, 2, 9, 10, 11}) picture("shot_" + std::to_string(i) + ".png", i);
  picture("other.png", 20);
  std::ofstream(folder_ / "notes.txt") << "no picture";
  const auto shown = [&](const std::string& what, int count) {
    const auto content = open_content(what, options_);
    std::vector<int> numbers;
    for (int i = 0; i < count; ++i) numbers.push_back(number(content->at((i + 0.5) / content->rate_hz())));
    return numbers;
  };
  EXPECT_EQ(shown((folder_ / "shot_*.png").string(), 6), (std::vector<int>{1, 2, 9, 10, 11, 1}));
  EXPECT_EQ(shown((folder_ / "shot_??.png").string() + "@5", 3), (std::vector<int>{10, 11, 10}));
  EXPECT_EQ(shown(folder_.string() + "@12.5", 6), (std::vector<int>{20, 1, 2, 9, 10, 11}));
  EXPECT_DOUBLE_EQ(open_content(folder_.string() + "@12.5", options_)->rate_hz(), 12.5);
  EXPECT_NE(why((folder_ / "shot_%d.png").string()).find("shot_2.png: the next picture"), std::string::npos);
  EXPECT_NE(why((folder_ / "shot_%d.png").string()).find("number 9"), std::string::npos);
  EXPECT_NE(why((folder_ / "none_%04d.png").string()).find("there is no picture"), std::string::npos);
  EXPECT_NE(why((folder_ / "no" / "*.png").string()).find("cannot read"), std::string::npos);
  EXPECT_NE(why(folder_.string() + "@0").find("rate"), std::string::npos);
}

TEST_F(Content, NumberedSequencesBeginWithTheLowestNumber) {
  for (int i : {8, 9, 10}) picture("f" + std::string(i < 10 ? "00" : "0") + std::to_string(i) + ".png", i);
  picture("f9.png", 3);  // not of three digits
  const auto content = open_content((folder_ / "f%03d.png").string(), options_);
  EXPECT_EQ(number(content->at(0)), 8);
  EXPECT_EQ(number(content->at(2.5 / 25)), 10);
}

/// The law of what is recorded, on a sequence and a video: the time says which picture, in any order of
/// times.
TEST_F(Content, WhatIsRecordedDependsOnTheTimeAlone) {
  for (int i = 0; i < 7; ++i) picture("p" + std::to_string(i) + ".png", i);
  for (const std::string& what : {(folder_ / "p%d.png").string() + "@20", video(7, 20)}) {
    for (const bool loop : {true, false}) {
      options_.loop = loop;
      const auto content = open_content(what, options_);
      EXPECT_NEAR(content->rate_hz(), 20, 1e-9);
      std::map<std::pair<const std::uint8_t*, std::uint64_t>, int> seen;
      for (const int n : {0, 1, 2, 2, 3, 6, 7, 8, 5, 4, 40, 41, 0, 700, 3, 20}) {
        const ContentFrame frame = content->at(n / 20.0);
        EXPECT_EQ(number(frame), loop ? n % 7 : std::min(n, 6)) << what << " " << loop << " " << n;
        const auto known = seen.emplace(std::pair(frame.view.data, frame.revision), number(frame));
        EXPECT_EQ(known.first->second, number(frame)) << "same view and revision, other pixels";
      }
      EXPECT_EQ(number(content->at(-3)), 0);
      EXPECT_EQ(number(content->at(std::numeric_limits<double>::quiet_NaN())), 0);
      content->at(1e300);  // a picture of it, and an end
    }
  }
}

TEST_F(Content, VideosAreRgb) {
  const auto content = open_content(video(2, 25), options_);
  const ContentFrame frame = content->at(0);
  EXPECT_EQ(frame.view.size(), (ImageSize{64, 48}));
  ASSERT_EQ(frame.view.channels, 3);
  EXPECT_NEAR(frame.view.at(5, 5, 0), 200, 8);
  EXPECT_NEAR(frame.view.at(5, 5, 2), 0, 8);
}

TEST_F(Content, ALiveVideoNeverShowsWhatIsToCome) {
  options_.pace = Pace::kLive;
  const auto content = open_content(video(25, 500), options_);
  int last = 0, seen = 0;
  for (int n = 0; n < 25; ++n) {
    const int got = number(content->at(n / 500.0));
    EXPECT_LE(got, n);
    EXPECT_GE(got, last);
    seen += got != last;
    last = got;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  EXPECT_GT(seen, 3) << "it does not move";
  // A long way, and back: it arrives.
  for (const double time : {1024.0 / 500, 2.0 / 500}) {
    const double deadline = now_s() + 10;
    const int wanted = int(time * 500) % 25;
    while (number(content->at(time)) != wanted && now_s() < deadline)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    EXPECT_EQ(number(content->at(time)), wanted);
  }
}

TEST_F(Content, ADamagedPictureIsToldAndTheShowGoesOn) {
  for (int i = 0; i < 4; ++i) picture("p" + std::to_string(i) + ".png", i);
  picture("p2.png", 2, {12, 7});
  const std::string what = (folder_ / "p%d.png").string();
  const auto exact = open_content(what, options_);
  EXPECT_EQ(number(exact->at(0.04)), 1);
  EXPECT_THROW(exact->at(0.08), Error);
  options_.pace = Pace::kLive;
  const auto live = open_content(what, options_);
  const double deadline = now_s() + 10;
  while (!(live->fault() && number(live->at(0.12)) == 1) && now_s() < deadline)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  EXPECT_EQ(number(live->at(0.12)), 1);
  ASSERT_TRUE(live->fault());
  EXPECT_NE(live->fault()->subject().find("picture 2"), std::string::npos) << live->fault()->what();
}

TEST_F(Content, FilesThatAreNoVideosAreRefused) {
  std::ofstream(folder_ / "text.mp4") << "no video at all";
  std::ofstream(folder_ / "empty.avi") << "";
  EXPECT_NE(why((folder_ / "text.mp4").string()).find("cannot open it as a video"), std::string::npos);
  EXPECT_NE(why((folder_ / "empty.avi").string()).find("cannot open"), std::string::npos);
  EXPECT_NE(why((folder_ / "none.mp4").string()).find("there is no such file"), std::string::npos);
  EXPECT_NE(why((folder_ / "none.png").string()).find("none.png"), std::string::npos);
  EXPECT_NE(why("").find("empty"), std::string::npos);
}

TEST_F(Content, AVideoCutShortRepeatsWhatThereIs) {
  const std::string file = video(20, 25);
  fs::resize_file(file, fs::file_size(file) / 2);
  const auto content = open_content(file, options_);
  for (int n = 0; n < 60; n += 7) content->at(n / 25.0);  // no end, no fault
  EXPECT_FALSE(content->fault());
}

/// Files are replaced while they are shown: the content comes back with them.
TEST_F(Content, AVideoThatIsBrokenForAWhileComesBack) {
  options_.pace = Pace::kLive;
  const std::string file = video(3, 25), good = file + ".good";
  fs::copy_file(file, good);
  const auto content = open_content(file, options_);
  const double begin = now_s();
  const auto plays_until = [&](auto holds) {
    for (const double end = now_s() + 20; now_s() < end && !holds();) {
      content->at(now_s() - begin);
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return holds();
  };
  EXPECT_TRUE(plays_until([&] { return content->at(now_s() - begin).revision == 3; }));
  fs::remove(file);
  ASSERT_EQ(mkfifo(file.c_str(), 0600), 0);  // opening it would wait for its writer
  ASSERT_TRUE(plays_until([&] { return content->fault().has_value(); }));
  EXPECT_NE(content->fault()->why().find("named pipe"), std::string::npos) << content->fault()->what();
  fs::rename(good, file);
  EXPECT_TRUE(plays_until([&] { return !content->fault(); })) << "it did not come back";
  // Without a file, its name is not tried as a device.
  fs::rename(file, good);
  ASSERT_TRUE(plays_until([&] { return content->fault().has_value(); }));
  EXPECT_EQ(content->fault()->why(), "there is no such file");
  fs::rename(good, file);
  EXPECT_TRUE(plays_until([&] { return !content->fault(); })) << "it did not come back";
  const std::uint64_t revision = content->at(now_s() - begin).revision;
  EXPECT_TRUE(plays_until([&] { return content->at(now_s() - begin).revision != revision; }));
}

/// A video file stands for the camera: it ends, as a camera that is unplugged, and comes back when opened
/// again.
TEST_F(Content, ACameraThatVanishesKeepsItsLastPictureAndComesBack) {
  options_.pace = Pace::kLive;
  const std::string file = video(5, 25);
  const auto camera = open_content("camera:" + file, options_);
  const auto wait_for = [&](auto holds) {
    const double deadline = now_s() + 10;
    while (!holds() && now_s() < deadline) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    return holds();
  };
  ASSERT_TRUE(wait_for([&] { return camera->fault().has_value(); }));
  EXPECT_EQ(camera->fault()->kind(), ErrorKind::kDevice);
  const ContentFrame last = camera->at(0);
  EXPECT_EQ(number(last), 4);
  EXPECT_TRUE(wait_for([&] { return camera->at(0).revision > last.revision; })) << "it did not come back";
}

TEST_F(Content, ACameraThatIsNotThereIsADeviceError) {
  try {
    const auto camera = open_content("camera:97", options_);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kDevice);
  }
}

/// Another program's frames: the newest, one that was started again, and one that is gone.
TEST_F(Content, SharedMemoryIsTheNewestFrameOfAnotherProgram) {
  const std::string name = "procam_content_" + std::to_string(getpid());
  EXPECT_EQ(why("shm:" + name).find("it was taken"), std::string::npos) << "nobody writes";
  SinkOptions writing;
  writing.size = {33, 21};
  auto writer = open_sink("shm:" + name, writing);
  options_.camera_patience_s = 0.05;
  EXPECT_NE(why("shm:" + name).find("no frame has been written"), std::string::npos);
  writer->show(ImageU8(writing.size, 3, 7));
  const auto content = open_content("shm:" + name, options_);
  const ContentFrame first = content->at(0), same = content->at(5);
  EXPECT_EQ(first.view.at(32, 20, 2), 7);
  EXPECT_EQ(first.revision, same.revision);
  for (std::uint8_t value = 8; value < 13; ++value) writer->show(ImageU8(writing.size, 3, value));
  const long before = test::allocations_of_this;  // sources have threads of their own
  const ContentFrame newest = content->at(0);
  EXPECT_EQ(test::allocations_of_this, before);
  EXPECT_EQ(newest.view.at(32, 20, 2), 12);
  EXPECT_NE(newest.revision, first.revision);
  EXPECT_FALSE(content->fault());

  const auto wait_for = [&](auto holds) {
    const double deadline = now_s() + 5;
    while (!holds() && now_s() < deadline) std::this_thread::sleep_for(std::chrono::milliseconds(20));
    return holds();
  };
  writer.reset();
  EXPECT_TRUE(wait_for([&] { return content->at(0).view.at(0, 0, 0) == 12 && content->fault(); }));
  writer = open_sink("shm:" + name, writing);
  writer->show(ImageU8(writing.size, 3, 200));
  EXPECT_TRUE(wait_for([&] { return content->at(0).view.at(0, 0, 0) == 200; })) << "it was not found again";
  EXPECT_FALSE(content->fault());
  writer.reset();
  writing.size = {40, 21};
  writer = open_sink("shm:" + name, writing);
  writer->show(ImageU8(writing.size, 3, 90));
  EXPECT_TRUE(wait_for([&] {
    return content->at(0).view.size() == ImageSize{33, 21} && content->fault() &&
           std::string(content->fault()->what()).find("another size") != std::string::npos;
  }));
}

/// The memory could not be looked at for a while (no descriptors, say), or its owner cut it and made it whole again.
TEST_F(Content, SharedMemoryThatIsWholeAgainIsNoFault) {
  const std::string name = "procam_content_whole_" + std::to_string(getpid()), file = "/dev/shm/" + name;
  SinkOptions writing;
  writing.size = {33, 21};
  const auto writer = open_sink("shm:" + name, writing);
  writer->show(ImageU8(writing.size, 3, 7));
  const auto content = open_content("shm:" + name, options_);
  const auto wait_for = [&](auto holds) {
    for (const double end = now_s() + 10; now_s() < end && !holds();) {
      content->at(0);
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    return holds();
  };
  const auto size = fs::file_size(file);
  fs::resize_file(file, 100);
  ASSERT_TRUE(wait_for([&] { return content->fault().has_value(); }));
  fs::resize_file(file, size);
  writer->show(ImageU8(writing.size, 3, 90));
  EXPECT_TRUE(wait_for([&] { return !content->fault(); }));
  EXPECT_EQ(content->at(0).view.at(0, 0, 0), 90);
}

TEST_F(Content, AFunctionSaysWhenItsPictureChanges) {
  const auto content = drawn_content({6, 4}, 3, [](double time, ImageView<std::uint8_t> picture) {
    const auto value = std::uint8_t(time);
    const bool is_new = picture.at(5, 3) != value;
    picture.at(5, 3) = value;
    return is_new;
  });
  const ContentFrame first = content->at(3.7), same = content->at(3.9), other = content->at(5);
  EXPECT_EQ(first.revision, same.revision);
  EXPECT_NE(same.revision, other.revision);
  EXPECT_EQ(other.view.at(5, 3), 5);
  EXPECT_THROW(drawn_content({6, 0}, 3, nullptr), std::invalid_argument);
}

TEST_F(Content, EveryKindHasAName) {
  for (const ContentKind& kind : content_kinds()) {
    EXPECT_FALSE(kind.example.empty());
    EXPECT_NE(why(kind.name + ":/nowhere/at/all"), "it was taken") << kind.name;
  }
}

/// What is written is content again; a lossless file holds the very values.
TEST_F(Content, VideosThatAreWrittenAreReadBack) {
  ImageU8 frame(66, 38, 3);
  for (const auto& [extension, tolerance] :
       {std::pair(".mkv", 0), std::pair(".mp4", 12), std::pair(".avi", 12)}) {
    const fs::path file = folder_ / (std::string("written") + extension);
    VideoFile video(file, frame.size(), 20);
    for (int n = 0; n < 5; ++n) {
      for (int y = 0; y < frame.height(); ++y)
        for (int x = 0; x < frame.width(); ++x) {
          frame.at(x, y, 0) = std::uint8_t(40 * n);
          frame.at(x, y, 1) = std::uint8_t(2 * x);
          frame.at(x, y, 2) = std::uint8_t(3 * y + 20);
        }
      video.add(frame);
    }
    EXPECT_FALSE(fs::exists(file)) << "it is not finished";
    video.finish();
    const auto content = open_content(file.string(), options_);
    EXPECT_NEAR(content->rate_hz(), 20, 1e-6) << extension;
    const ContentFrame third = content->at(3 / 20.0);
    ASSERT_EQ(third.view.size(), frame.size());
    EXPECT_NEAR(third.view.at(33, 20, 0), 120, tolerance) << extension;
    EXPECT_NEAR(third.view.at(33, 20, 1), 66, tolerance) << extension;
    EXPECT_NEAR(third.view.at(33, 20, 2), 80, tolerance) << extension;
    EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 1) << "something is left behind";
    fs::remove(file);
  }
  EXPECT_THROW(const VideoFile refused(folder_ / "a.mp4", {65, 38}, 20), Error);
  EXPECT_THROW(const VideoFile refused(folder_ / "a.webm", {64, 38}, 20), Error);
  EXPECT_THROW(const VideoFile refused(folder_ / "no" / "a.mp4", {64, 38}, 20), Error);
  EXPECT_THROW(const VideoFile refused(folder_ / "a.mp4", {64, 38}, 0), std::invalid_argument);
}

TEST_F(Content, AskingForAPictureAllocatesNothing) {
  for (int i = 0; i < 7; ++i) picture("p" + std::to_string(i) + ".png", i);
  const std::string file = video(7, 20);
  for (const std::string& what : {std::string("#102030"), (folder_ / "p1.png").string(),
                                  (folder_ / "p%d.png").string(), file, "camera:" + file}) {
    options_.pace = what.rfind("camera", 0) == 0 ? Pace::kLive : Pace::kExact;
    const auto content = open_content(what, options_);
    const long before = test::allocations_of_this;  // sources have threads of their own
    for (int n = 0; n < 30; ++n) content->at(n / 20.0);
    EXPECT_EQ(test::allocations_of_this, before) << what;
  }
}

}  // namespace
}  // namespace procam::device
