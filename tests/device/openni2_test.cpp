/// Depth sensors through OpenNI2's own library: a driver of ours under it, and a recording that it wrote.
#include <OpenNI.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <thread>

#include "procam/device/depth_source.hpp"
#include "procam/device/frame_sink.hpp"
#include "support/expect_error.hpp"
#include "support/simulated_sensor.hpp"

/// OpenNI2 unloads its drivers. What their static variables point to then looks lost; without the unloading nothing is.
extern "C" const char* __asan_default_options() {  // NOLINT(bugprone-reserved-identifier)
  return "detect_leaks=0";
}

namespace procam::device {
namespace {

namespace fs = std::filesystem;

/// One for the process: OpenNI2 starts once.
const test::SimulatedSensor& sensor() {
  struct Folder {
    fs::path path = fs::temp_directory_path() / ("procam_sensor_" + std::to_string(getpid()));
    test::SimulatedSensor sensor{path};
    Folder() { sensor.announce(); }
    ~Folder() { fs::remove_all(path); }
  };
  static const Folder folder;
  return folder.sensor;
}

/// A slope, and a step so that left and right differ; tenths of a millimetre.
Image<std::uint16_t> slope(int more, ImageSize size = {320, 240}) {
  Image<std::uint16_t> picture(size.width, size.height);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x)
      picture.at(x, y) = x < 3 ? std::uint16_t(0) : std::uint16_t(20003 + 7 * x + 3 * y + more);
  return picture;
}

/// Shows pictures until the source has handed one out.
std::optional<SeenDepth> next_of(DepthSource& source, const Image<std::uint16_t>& picture,
                                 std::uint64_t stamp_us) {
  std::optional<SeenDepth> seen;
  for (int i = 0; i < 100 && !seen; ++i) {
    sensor().show(picture.view(), stamp_us);
    seen = source.next(0, 0.05);
  }
  return seen;
}

std::unique_ptr<DepthSource> open_plugged(const std::string& what, const DepthOptions& options) {
  sensor().plug();
  // A sensor that was just plugged in is there once its driver has seen it.
  for (int i = 0;; ++i) try {
      return open_depth(what, options);
    } catch (const Error&) {
      if (i == 100) throw;
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
}

TEST(Openni2, GivesWhatTheSensorSaw) {
  auto source = open_plugged("openni2:", {ImageSize{320, 240}});
  const Image<std::uint16_t> picture = slope(0);
  const double before = now_s();
  const auto seen = next_of(*source, picture, 5'250'000);
  ASSERT_TRUE(seen);
  // The finer unit of the two that this size has, told; not mirrored, though the driver begins so.
  EXPECT_EQ(seen->metres_per_unit, 1e-4);
  ASSERT_EQ(size_of(seen->pixels), picture.size());
  EXPECT_TRUE(std::equal(picture.data(), picture.data() + 320 * 240, std::get<0>(seen->pixels).data()));
  EXPECT_EQ(seen->stamp_s, 5.25);
  EXPECT_GE(seen->time_s, before);
  EXPECT_LE(seen->time_s, now_s());
  // By its own name as well, and in another of its sizes, where there is millimetres only.
  source.reset();
  const auto named = open_depth("openni2:simulated/depth", {ImageSize{160, 120}});
  const auto small = next_of(*named, slope(0, {160, 120}), 6'000'000);
  ASSERT_TRUE(small);
  EXPECT_EQ(small->metres_per_unit, 1e-3);
  EXPECT_EQ(std::get<0>(small->pixels).at(10, 20), 2013);  // 20133 tenths
}

TEST(Openni2, WhatIsWrongIsSaid) {
  sensor().unplug();
  EXPECT_ERROR(open_depth("openni2:no/such"), kDevice, "no/such");
  const auto source = open_plugged("openni2:", {});
  EXPECT_ERROR(open_depth("openni2:", {ImageSize{641, 480}}), kDevice, "320x240, 160x120");
}

TEST(Openni2, IsUnpluggedAndComesBack) {
  auto source = open_plugged("openni2:", {ImageSize{320, 240}});
  ASSERT_TRUE(next_of(*source, slope(1), 1'000'000));
  sensor().unplug();
  const auto read_on = [&] {
    for (int i = 0; i < 100; ++i) source->next(0, 0.05);
  };
  EXPECT_ERROR(read_on(), kDevice, "unplugged");
  source.reset();
  EXPECT_ERROR(open_depth("openni2:", {}), kDevice, "no sensor is there");
  source = open_plugged("openni2:", {ImageSize{320, 240}});
  const auto again = next_of(*source, slope(2), 50'000);  // its clock began anew
  ASSERT_TRUE(again);
  EXPECT_EQ(std::get<0>(again->pixels).at(100, 10), slope(2).at(100, 10));
}

TEST(Openni2, PlaysARecording) {
  open_plugged("openni2:", {ImageSize{320, 240}}).reset();  // starts OpenNI2
  const fs::path file = fs::temp_directory_path() / ("procam_" + std::to_string(getpid()) + ".oni");
  constexpr int kPictures = 6;
  {
    openni::Device device;
    openni::VideoStream stream;
    openni::Recorder recorder;
    ASSERT_EQ(device.open("simulated/depth"), openni::STATUS_OK);
    ASSERT_EQ(stream.create(device, openni::SENSOR_DEPTH), openni::STATUS_OK);
    openni::VideoMode mode = stream.getVideoMode();
    mode.setResolution(320, 240);
    mode.setPixelFormat(openni::PIXEL_FORMAT_DEPTH_1_MM);
    ASSERT_EQ(stream.setVideoMode(mode), openni::STATUS_OK);
    stream.setMirroringEnabled(false);
    ASSERT_EQ(recorder.create(file.c_str()), openni::STATUS_OK);
    ASSERT_EQ(recorder.attach(stream), openni::STATUS_OK);
    ASSERT_EQ(stream.start(), openni::STATUS_OK);
    ASSERT_EQ(recorder.start(), openni::STATUS_OK);
    for (int i = 0; i < kPictures; ++i) {
      sensor().show(slope(100 * i).view(), 1'000'000 + std::uint64_t(i) * 40'000);
      openni::VideoFrameRef frame;
      ASSERT_EQ(stream.readFrame(&frame), openni::STATUS_OK);
    }
    recorder.stop();
    recorder.destroy();
    stream.destroy();
  }
  for (int i = 0; i < 5; ++i) {  // closed while its pictures come
    const auto closed_early = open_depth("openni2:" + file.string(), {ImageSize{320, 240}});
    ASSERT_TRUE(closed_early->next(0, 5));
  }
  auto source = open_depth("openni2:" + file.string(), {ImageSize{320, 240}});
  int count = 0, first = 0;
  double after = 0, last_stamp = -1;
  const auto play = [&] {
    for (int i = 0; i < 100; ++i) {
      const auto seen = source->next(after, 0.05);
      if (!seen) continue;
      ++count;
      after = seen->time_s;
      EXPECT_EQ(seen->metres_per_unit, 1e-3);
      ASSERT_TRUE(seen->stamp_s);
      EXPECT_GT(*seen->stamp_s, last_stamp);
      last_stamp = *seen->stamp_s;
      // Stamps begin with the recording; pictures were taken every 40 ms, each 10 mm farther.
      const auto& units = std::get<0>(seen->pixels);
      if (count == 1) first = units.at(200, 100) - 10 * int(std::lround(*seen->stamp_s / 0.04));
      EXPECT_EQ(units.at(200, 100), first + 10 * int(std::lround(*seen->stamp_s / 0.04)));
      EXPECT_EQ(std::get<0>(seen->pixels).at(1, 100), 0);
    }
  };
  EXPECT_ERROR(play(), kDevice, "last picture");
  EXPECT_EQ(first % 10, (slope(0).at(200, 100) + 5) / 10 % 10);
  EXPECT_GE(count, kPictures - 1);
  for (int i = 0; i < 5; ++i) {  // closed at its end
    source.reset();
    source = open_depth("openni2:" + file.string(), {ImageSize{320, 240}});
    const auto to_end = [&] {
      for (int k = 0; k < 100; ++k) source->next(now_s(), 0.05);
    };
    EXPECT_ERROR(to_end(), kDevice, "last picture");
  }
  source.reset();
  fs::remove(file);
}

}  // namespace
}  // namespace procam::device
