/// Several projectors and cameras captured into one session, in made-up time: whose light is in which folder?
#include "procam/session/recorder.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <deque>
#include <memory>
#include <random>

#include "procam/core/base/words.hpp"
#include "procam/io/image/images.hpp"
#include "procam/session/files.hpp"
#include "recorder_devices.hpp"
#include "support/expect_error.hpp"

namespace procam::session {
namespace {

namespace fs = std::filesystem;

/// Where a camera sees a projector's picture: projector pixel = (camera pixel - corner) / scale; nothing where gain is 0.
struct Patch {
  Vec2 corner, scale;
  double gain = 0;  ///< grey levels of the camera a grey level of the picture
};

/// Two screens of different sizes in one room, and what each has shown when.
struct LitRoom {
  static constexpr double kDark = 18;

  double now = 0;
  std::vector<std::deque<std::pair<double, ImageU8>>> shown{2};

  const ImageU8* picture_at(std::size_t screen, double time) const {
    const ImageU8* picture = nullptr;
    for (const auto& [t, image] : shown[screen])
      if (t <= time) picture = &image;
    return picture;
  }
};

class RoomScreen : public device::FrameSink {
 public:
  RoomScreen(LitRoom& room, std::size_t index, ImageSize size) : room_(room), index_(index), size_(size) {}
  ImageSize size() const override { return size_; }
  double show(ViewU8 picture) override {
    ++shows;
    room_.now += 0.004;
    ImageU8 copy(picture.size());
    for (int y = 0; y < picture.height; ++y) std::copy_n(picture.row(y), picture.width, copy.row(y));
    room_.shown[index_].emplace_back(room_.now, copy);
    if (room_.shown[index_].size() > 60) room_.shown[index_].pop_front();
    return room_.now;
  }

  int shows = 0;

 private:
  LitRoom& room_;
  std::size_t index_;
  ImageSize size_;
};

std::vector<double> normal_numbers(std::mt19937& random) {
  std::normal_distribution<double> normal(0, 1);
  std::vector<double> numbers(8191);
  for (double& number : numbers) number = normal(random);
  return numbers;
}

/// A camera with noise of one grey level, that sees the room's light some time later.
class Eye : public device::FrameSource {
 public:
  Eye(LitRoom& room, ImageSize size, double delay_s, double interval_s, std::vector<Patch> patches)
      : room_(room), size_(size), delay_(delay_s), interval_(interval_s), patches_(std::move(patches)) {}

  std::optional<device::SeenFrame> next(double after_s, double) override {
    // As a device's thread: frames that came meanwhile are at hand, but no more than kNewest of them.
    while (next_ <= after_s || next_ + double(kNewest) * interval_ < room_.now) next_ += interval_;
    const double time = next_;
    next_ += interval_;
    room_.now = std::max(room_.now, time);
    return device::SeenFrame{expose(time - delay_), time};
  }
  Vec2 truth(std::size_t screen, int x, int y) const {
    return (Vec2(x, y) - patches_[screen].corner).cwiseQuotient(patches_[screen].scale);
  }
  std::vector<Patch>& patches() { return patches_; }

 private:
  ImageU8 expose(double time) {
    ImageU8 image(size_);
    const ImageU8* const pictures[] = {room_.picture_at(0, time), room_.picture_at(1, time)};
    for (int y = 0; y < size_.height; ++y)
      for (int x = 0; x < size_.width; ++x) {
        double grey = LitRoom::kDark + noise_[random_() % noise_.size()];
        for (std::size_t screen = 0; screen < 2; ++screen) {
          const ImageU8* picture = pictures[screen];
          const Vec2 pixel = truth(screen, x, y);
          const int u = int(std::floor(pixel.x() + 0.5)), v = int(std::floor(pixel.y() + 0.5));
          if (picture != nullptr && u >= 0 && v >= 0 && u < picture->width() && v < picture->height())
            grey += patches_[screen].gain * picture->at(u, v);
        }
        image.at(x, y) = std::uint8_t(std::min(255.0, std::max(0.0, grey + 0.5)));
      }
    return image;
  }

  LitRoom& room_;
  ImageSize size_;
  double delay_, interval_;
  std::vector<Patch> patches_;
  double next_ = 0.01;
  std::mt19937 random_{7};
  const std::vector<double> noise_ = normal_numbers(random_);
};

/// Nobody: the devices are in place at once.
class Silent : public RecorderDialog {
 public:
  void progress(const std::string& doing, int done, int) override {
    if (!ends_at.empty() && doing == ends_at && done == 3)
      throw Error(ErrorKind::kDevice, "test", "the plug was pulled", "go on");
  }
  void say(const std::string& line) override { lines += line + "\n"; }
  void report(const Diagnostics& remarks) override {
    for (const Diagnostic& remark : remarks.items) lines += remark.code + "\n";
  }
  bool wants_to_go_on() override { return true; }

  std::string lines, ends_at;
};

class SeveralDevices : public ::testing::Test {
 protected:
  SeveralDevices() {
    std::string name = (fs::temp_directory_path() / "procam_recorder_XXXXXX").string();
    options_.folder = mkdtemp(name.data());
    options_.views = 1;
  }
  ~SeveralDevices() override {
    std::error_code ignored;
    fs::remove_all(options_.folder, ignored);
  }

  RecorderDevices both() {
    return {{{"lamp", *near_pattern_, near_}, {"beamer", *far_pattern_, far_}},
            {{"left", left_}, {"right", right_}}};
  }
  /// Both projectors with the camera that sees both; quicker.
  RecorderDevices with_one_camera() {
    return {{{"lamp", *near_pattern_, near_}, {"beamer", *far_pattern_, far_}}, {{"right", right_}}};
  }
  RecorderReport record(const RecorderDevices& devices) {
    return record_session(devices, {}, options_, dialog_);
  }

  /// Shares of the camera's pixels whose light was read, and read as the wrong pixel (by more than one).
  std::pair<double, double> read_share(const std::string& stack, const SessionPattern& pattern,
                                       const Eye& eye, std::size_t screen) {
    const auto captured = io::load_capture_folder(options_.folder / "view_00" / stack, pattern.frame_count());
    const std::vector<ViewU8> views(captured.frames.begin(), captured.frames.end());
    const LightMap light = pattern.read_light_map(views)->light;
    double read = 0, wrong = 0;
    for (int y = 0; y < light.camera_size().height; ++y)
      for (int x = 0; x < light.camera_size().width; ++x)
        if (const auto pixel = light.projector_pixel(x, y)) {
          ++read;
          wrong += (*pixel - eye.truth(screen, x, y)).norm() > 1;
        }
    const double all = double(light.camera_size().width) * light.camera_size().height;
    return {read / all, wrong / all};
  }

  static constexpr ImageSize kNear{64, 48}, kFar{32, 40};
  LitRoom room_;
  RoomScreen near_{room_, 0, kNear}, far_{room_, 1, kFar};
  /// The far screen's light does not reach what the left camera sees.
  Eye left_{room_, {120, 90}, 0.11, 1 / 30.0, {{{11, 7}, {1.5, 1.7}, 0.5}, {{0, 0}, {1, 1}, 0}}};
  Eye right_{room_, {110, 100}, 0.07, 1 / 24.0, {{{-20, 9}, {1.9, 1.6}, 0.45}, {{52, 31}, {1.3, 1.4}, 0.3}}};
  std::unique_ptr<SessionPattern> near_pattern_ = make_pattern("gray", kNear),
                                  far_pattern_ = make_pattern("gray", kFar);
  RecorderOptions options_;
  Silent dialog_;
};

TEST_F(SeveralDevices, AreCapturedPairByPair) {
  const RecorderReport report = record(both());
  ASSERT_TRUE(report.captured) << dialog_.lines;
  ASSERT_EQ(report.pairs.size(), 4u);
  EXPECT_EQ(report.pairs[2].projector, "beamer");
  EXPECT_EQ(report.pairs[2].camera, "left");
  EXPECT_FALSE(report.pairs[2].seen);
  EXPECT_TRUE(report.pairs[0].seen && report.pairs[1].seen && report.pairs[3].seen) << dialog_.lines;
  EXPECT_NEAR(report.pairs[0].delay->delay_s, 0.11, 0.02);
  EXPECT_NEAR(report.pairs[3].delay->delay_s, 0.07, 0.02);

  const auto session = io::load_session(options_.folder);
  ASSERT_TRUE(session);
  EXPECT_FALSE(session->projector_size);
  EXPECT_EQ(session->projectors, (std::map<std::string, ImageSize>{{"lamp", kNear}, {"beamer", kFar}}));
  std::string stacks;
  for (const io::Stack& stack : io::list_stacks(options_.folder / "view_00", {"lamp", "beamer"}))
    stacks += stack.projector + "/" + stack.camera + " ";
  EXPECT_EQ(stacks, "beamer/right lamp/left lamp/right ");

  // At the edge of two pixels' light a camera pixel may be read as either.
  for (const auto& [stack, pattern, eye, screen] :
       {std::tuple("lamp/left", near_pattern_.get(), &left_, 0),
        std::tuple("lamp/right", near_pattern_.get(), &right_, 0),
        std::tuple("beamer/right", far_pattern_.get(), &right_, 1)}) {
    const auto [read, wrong] = read_share(stack, *pattern, *eye, std::size_t(screen));
    EXPECT_GT(read, 0.1) << stack;
    EXPECT_LT(wrong, 0.002) << stack;
  }
  // While one projector shows its black picture, the other is dark too.
  const ImageU8 black =
      io::load_image(options_.folder / "view_00/lamp/right" /
                     numbered("frame", std::size_t(near_pattern_->frame_count()) - 1, ".png"))
          .image;
  EXPECT_LT(black.at(70, 60), LitRoom::kDark + 8) << "the other projector's light is in it";
  EXPECT_GT(report.projector_coverage.at(0), 0.5);
  EXPECT_GT(report.camera_coverage.at(1), 0.3);
  EXPECT_TRUE(fs::exists(options_.folder / "coverage.png"));
}

TEST_F(SeveralDevices, ShareEachPicture) {
  const RecorderDevices devices = both();
  DeviceTable table(devices, [] {});
  ASSERT_EQ(table.pairs().size(), 4u);
  const ImageU8 picture(kNear, 1, 90), other(kNear, 1, 91), beamed(kFar, 1, 200);
  SharedScreen &for_left = table.pairs()[0].screen, &for_right = table.pairs()[1].screen;
  const double shown_s = for_left.show(picture);
  EXPECT_EQ(for_right.show(picture), shown_s) << "the second camera has frames of the same picture";
  EXPECT_EQ(near_.shows, 1);
  EXPECT_EQ(far_.shows, 1) << "made black, once";
  EXPECT_GT(for_right.show(other), shown_s);
  table.pairs()[3].screen.show(beamed);
  EXPECT_EQ(room_.shown[0].back().second.at(5, 5), 0) << "dark, while the other shows";
  const double again_s = for_left.show(other);
  EXPECT_GT(again_s, shown_s) << "the other's light was in the frames before";
  EXPECT_EQ(room_.shown[0].back().second.at(5, 5), 91);
  EXPECT_EQ(room_.shown[1].back().second.at(5, 5), 0);
}

TEST_F(SeveralDevices, MustEachSeeLight) {
  right_.patches()[1].gain = 0;
  EXPECT_ERROR(record(with_one_camera()), kDevice, "projector beamer");
  EXPECT_FALSE(fs::exists(options_.folder / "view_00"));
}

TEST_F(SeveralDevices, NeedNames) {
  const auto refused = [&](const std::string& first, const std::string& second, const std::string& camera,
                           const std::string& says) {
    const RecorderDevices devices{{{first, *near_pattern_, near_}, {second, *far_pattern_, far_}},
                                  {{camera, left_}, {"right", right_}}};
    EXPECT_ERROR(record(devices), kInput, says);
  };
  refused("lamp", "", "left", "no name");
  refused("lamp", "lamp", "left", "two have this name");
  refused("lamp", "../beamer", "left", "folder");
  refused("lamp", "rejected", "left", "folder");
  refused("lamp", "beamer", "lamp", "a projector has the same name");
}

TEST_F(SeveralDevices, GoOnWhereTheyWere) {
  dialog_.ends_at = "view_00 beamer: frame";
  EXPECT_ERROR(record(with_one_camera()), kDevice, "plug");
  const fs::path first = options_.folder / ".view_00.partial/lamp/frame_00.png";
  ASSERT_TRUE(fs::exists(first)) << dialog_.lines;
  const auto written = fs::last_write_time(first);
  dialog_.ends_at.clear();
  const RecorderReport report = record(with_one_camera());
  ASSERT_TRUE(report.captured);
  EXPECT_NE(dialog_.lines.find(format("going on after %d frames", near_pattern_->frame_count() + 3)),
            std::string::npos)
      << dialog_.lines;
  EXPECT_EQ(fs::last_write_time(options_.folder / "view_00/lamp/frame_00.png"), written) << "captured again";
  EXPECT_LT(read_share("beamer", *far_pattern_, right_, 1).second, 0.002);
}

TEST_F(SeveralDevices, AreNotMixedWithOthers) {
  io::save_session(options_.folder, with_one_camera().session({}, 1));
  for (const char* lamp : {"lamp", "beamer"}) {
    make_folder(options_.folder / "view_00" / lamp);
    io::save_image(options_.folder / "view_00" / lamp / "frame_00.png", ImageU8(9, 7));
  }
  const RecorderDevices renamed{{{"lamp", *near_pattern_, near_}, {"other", *far_pattern_, far_}},
                                {{"right", right_}}};
  EXPECT_ERROR(record(renamed), kInput, "projectors");
  EXPECT_ERROR(record(both()), kInput, "other cameras");
}

}  // namespace
}  // namespace procam::session
