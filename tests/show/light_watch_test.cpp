/// The light of a running show, watched by a camera on a thread of its own.
#include "light_watch.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <fstream>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>

#include "control_messages.hpp"
#include "io/scratch.hpp"
#include "procam/device/frame_sink.hpp"
#include "procam/surface/solve.hpp"
#include "prometheus.hpp"
#include "support/expect_error.hpp"
#include "watch/watched_world.hpp"

namespace procam::show {
namespace {

using watch::test::WatchedWorld;

/// Sees the world as it is lit at present, some 30 times a second.
struct Stage {
  WatchedWorld world{watch::test::WorldOptions{}};
  const ImageU8 frame = world.frame(0.5);
  const ImageU8 dark = ImageU8(frame.size(), 3);
  std::mutex mutex;
  bool is_gone = false;

  SolvedSurfaceSet solved() const {
    SurfaceSet set;
    for (const watch::test::Wall& wall : watch::test::one_wall()) {
      PlanarSurface plane;
      plane.frame = "rig";
      plane.frame_from_surface = wall.rig_from_surface;
      plane.content = {Vec2(0, 0), Vec2(1, 0), Vec2(1, 1), Vec2(0, 1)};
      plane.points = {Vec2(0, 0), Vec2(wall.size.x(), 0), wall.size, Vec2(0, wall.size.y())};
      set.surfaces.push_back({wall.name, plane, {}, ""});
    }
    return surface::solve_surfaces(set, world.rig().projector());
  }
};

class StageCamera : public device::FrameSource {
 public:
  explicit StageCamera(Stage& stage) : stage_(stage) {}
  std::optional<device::SeenFrame> next(double after_s, double) override {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    const std::lock_guard<std::mutex> lock(stage_.mutex);
    if (stage_.is_gone) throw Error(ErrorKind::kDevice, "camera", "it is gone", "plug it in");
    return device::SeenFrame{stage_.world.image(stage_.frame, 0.5), after_s + 0.01};
  }

 private:
  Stage& stage_;
};

LightWatchOptions quick(const Stage& stage, const std::string& log) {
  LightWatchOptions options;
  options.camera = stage.world.rig().camera();
  options.projector = stage.world.rig().projector();
  options.watch.window = 0.4;
  options.period = 0.05;
  options.log = log;
  return options;
}

/// A show of that frame until something holds, at most for a minute.
template <typename Holds>
bool show_until(LightWatch& watch, const Stage& stage, std::vector<std::string>& sentences,
                const Holds& holds) {
  const SolvedSurfaceSet solved = stage.solved();
  const auto frame = std::make_shared<const ImageU8>(stage.frame);
  WatchStatus status;
  for (const double begin = device::now_s(); device::now_s() < begin + 60;) {
    watch.shown(frame, device::now_s(), solved);
    std::this_thread::sleep_for(std::chrono::milliseconds(16));
    const auto news = watch.take();
    if (!news) continue;
    sentences.insert(sentences.end(), news->sentences.begin(), news->sentences.end());
    status = news->status;
    if (holds(status)) return true;
  }
  ADD_FAILURE() << status.state << ": " << status.sentence << ", " << status.checks << " checks";
  return false;
}

TEST(LightWatch, ABumpIsReportedAndLogged) {
  test::Scratch folder;
  Stage stage;
  std::vector<std::string> sentences;
  {
    LightWatch watch([&] { return std::make_unique<StageCamera>(stage); },
                     quick(stage, (folder / "watch.csv").string()));
    ASSERT_TRUE(show_until(watch, stage, sentences, [](const WatchStatus& s) { return s.state == "ok"; }));
    {
      const std::lock_guard<std::mutex> lock(stage.mutex);
      stage.world.projector_moved << 0.001, 0.004, 0, 0, 0, 0;
    }
    ASSERT_TRUE(show_until(watch, stage, sentences, [](const WatchStatus& s) {
      return s.is_alarm && s.alarms == 1 && s.error_mm > 5 && s.error_mm < 13 && s.history_mm.size() > 2;
    }));
  }
  EXPECT_FALSE(sentences.empty());
  EXPECT_NE(sentences.back().find("watch: the light is off by"), std::string::npos) << sentences.back();
  std::ifstream log(folder / "watch.csv");
  std::string header, line, last;
  std::getline(log, header);
  EXPECT_EQ(header.rfind("time_s,state,alarm,", 0), 0u);
  while (std::getline(log, line)) last = line;
  EXPECT_EQ(std::count(last.begin(), last.end(), ','), std::count(header.begin(), header.end(), ','));
  EXPECT_NE(last.find(",1,"), std::string::npos);
}

TEST(LightWatch, ACameraThatIsGoneIsCountedAndComesBack) {
  Stage stage;
  stage.is_gone = true;
  std::vector<std::string> sentences;
  LightWatch watch([&] { return std::make_unique<StageCamera>(stage); }, quick(stage, ""));
  ASSERT_TRUE(show_until(watch, stage, sentences, [](const WatchStatus& s) { return s.faults > 0; }));
  EXPECT_NE(sentences.front().find("it is gone"), std::string::npos);
  {
    const std::lock_guard<std::mutex> lock(stage.mutex);
    stage.is_gone = false;
  }
  EXPECT_TRUE(show_until(watch, stage, sentences, [](const WatchStatus& s) { return s.checks > 0; }));
}

TEST(LightWatch, StatusAndMetricsShowIt) {
  PageStatus page;
  EXPECT_TRUE(nlohmann::json::parse(to_json_text(page)).at("watch").is_null());
  WatchStatus status;
  status.state = "moved";
  status.sentence = "the light is off by 7.4 mm";
  status.is_alarm = true;
  status.checks = 31;
  status.alarms = 2;
  status.error_mm = 7.375;
  status.error_sigma_mm = 0.125;
  status.history_mm = {0.0625, NAN};
  page.watch = status;
  const nlohmann::json watch = nlohmann::json::parse(to_json_text(page)).at("watch");
  EXPECT_EQ(watch.at("state"), "moved");
  EXPECT_EQ(watch.at("alarm"), true);
  EXPECT_EQ(watch.at("error_mm"), 7.375);
  EXPECT_EQ(watch.at("history_mm"), nlohmann::json::parse("[0.0625, null]"));
  Metrics metrics;
  EXPECT_EQ(to_prometheus(metrics, {}).find("procam_watch"), std::string::npos);
  metrics.watch = status;
  const std::string text = to_prometheus(metrics, {});
  for (const char* line :
       {"procam_watch_checks_total 31\n", "procam_watch_alarms_total 2\n", "procam_watch_alarm 1\n",
        "procam_watch_error_metres 0.007375\n", "procam_watch_error_sigma_metres 0.000125\n",
        "procam_watch_state{state=\"moved\"} 1\n"})
    EXPECT_NE(text.find(line), std::string::npos) << line;
}

TEST(LightWatch, ALogThatCannotBeWrittenIsRefused) {
  Stage stage;
  EXPECT_ERROR(
      LightWatch([&] { return std::make_unique<StageCamera>(stage); }, quick(stage, "/nowhere/watch.csv")),
      kIo, "/nowhere/watch.csv");
}

}  // namespace
}  // namespace procam::show
