/// The light of a running show, watched by a camera on a thread of its own.
#include "light_watch.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <fstream>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>

#include "control_messages.hpp"
#include "io/scratch.hpp"
#include "live_world.hpp"
#include "procam/core/base/clock.hpp"
#include "procam/core/geometry/se3.hpp"
#include "procam/dds/fleet.hpp"
#include "procam/dds/pose_source.hpp"
#include "procam/detect/marker_edges.hpp"
#include "procam/device/frame_sink.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/surface_file.hpp"
#include "procam/show/run.hpp"
#include "procam/surface/solve.hpp"
#include "prometheus.hpp"
#include "run_log.hpp"
#include "support/expect_error.hpp"
#include "watch/watched_world.hpp"

namespace procam::show {
namespace {

using watch::test::WatchedWorld;

/// Sees the world as it is lit at present, some 30 times a second.
struct Stage {
  explicit Stage(const watch::test::WorldOptions& options = {}) : walls(options.walls), world(options) {}
  std::vector<watch::test::Wall> walls;
  WatchedWorld world;
  const ImageU8 frame = world.frame(0.5);
  const ImageU8 dark = ImageU8(frame.size(), 3);
  std::mutex mutex;
  bool is_gone = false;

  SolvedSurfaceSet solved() const {
    SurfaceSet set;
    for (const watch::test::Wall& wall : walls) {
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
    watch.shown(frame, device::now_s(), solved, stage.world.rig().projector().rig_from_projector);
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

/// Largest distance on the wall between the light of two projectors, millimetres.
double apart_mm(const Stage& stage, const Pose& one, const Pose& other) {
  const Plane wall = Plane::of_xy(stage.walls.front().rig_from_surface);
  double largest = 0;
  for (const Vec2& pixel : {Vec2(250, 150), Vec2(800, 150), Vec2(800, 650), Vec2(250, 650), Vec2(520, 400)}) {
    const Ray ray = *stage.world.rig().projector().projector.emit(pixel);
    largest = std::max(largest, (*intersect(one * ray, wall) - *intersect(other * ray, wall)).norm());
  }
  return 1e3 * largest;
}

TEST(LightWatch, ABumpIsCorrectedSavedAndUndone) {
  test::Scratch folder;
  Stage stage;
  const Pose before = stage.world.rig().projector().rig_from_projector;
  std::vector<std::string> sentences;
  LightWatchOptions options = quick(stage, "");
  options.corrects = true;
  options.rig = stage.world.rig();
  options.save = (folder / "corrected.json").string();
  LightWatch watch([&] { return std::make_unique<StageCamera>(stage); }, options);
  ASSERT_TRUE(show_until(watch, stage, sentences, [](const WatchStatus& s) { return s.state == "ok"; }));
  {
    const std::lock_guard<std::mutex> lock(stage.mutex);
    stage.world.projector_moved << 0.001, 0.004, 0, 0, 0, 0;
  }
  const Pose truth = se3_exp(stage.world.projector_moved) * before;
  EXPECT_GT(apart_mm(stage, before, truth), 5);
  ASSERT_TRUE(show_until(watch, stage, sentences, [](const WatchStatus& s) {
    return s.corrections > 0 && s.is_corrected && !s.is_alarm && s.state == "ok";
  }));
  EXPECT_NE(std::find_if(sentences.begin(), sentences.end(),
                         [](const std::string& one) {
                           return one.rfind("watch: corrected: projector rotated by", 0) == 0;
                         }),
            sentences.end());
  const Rig saved = io::load_rig(options.save);
  EXPECT_LT(apart_mm(stage, saved.projector().rig_from_projector, truth), 0.8);
  EXPECT_NE(saved.provenance.options.at("corrected").find("rotated by"), std::string::npos);

  watch.undo();
  ASSERT_TRUE(show_until(watch, stage, sentences, [](const WatchStatus& s) {
    return !s.corrects && !s.is_corrected && s.is_alarm;  // it is off again, and stays so
  }));
  const std::uint64_t corrections = 1;
  watch.resume();
  ASSERT_TRUE(show_until(watch, stage, sentences,
                         [](const WatchStatus& s) { return s.corrects && s.corrections > corrections; }));
}

/// A show as a user starts it: frames into a screen, a camera's images in a folder, a bump in the middle.
class BumpedShow : public ShowListener {
 public:
  BumpedShow(Stage& stage, KeptFrames& screen, std::function<void(WatchedWorld&)> bump)
      : stage_(stage), screen_(screen), bump_(std::move(bump)) {}
  void on_event(const std::string& sentence) override { events += sentence + "\n"; }
  void on_frame(const ShowReport& report) override {
    if (!report.metrics.watch) return;
    const WatchStatus& watch = *report.metrics.watch;
    if (watch.state == "ok" && watch.corrections == 0) {
      const std::lock_guard<std::mutex> lock(stage_.mutex);
      bump_(stage_.world);
    }
    if (watch.corrections > 0 && watch.state == "ok" && corrected_at == 0) corrected_at = device::now_s();
    if (corrected_at > 0 && device::now_s() > corrected_at + 3) screen_.wish(device::WindowEvent::kClose);
  }
  std::string events;
  double corrected_at = 0;

 private:
  Stage& stage_;
  KeptFrames& screen_;
  std::function<void(WatchedWorld&)> bump_;
};

/// A show of one picture on the wall, with a camera that sees the stage as the screen lights it.
struct WatchedShow {
  test::Scratch folder;
  Stage stage;
  Rig rig = stage.world.rig();
  KeptFrames screen{rig.projector().projector.size()};
  ShowOptions options;
  ShowReport report;

  explicit WatchedShow(const watch::test::WorldOptions& world = {});
  /// What the listener saw, when something has moved and three seconds have passed after its correction.
  BumpedShow run(std::function<void(WatchedWorld&)> bump);
};

WatchedShow::WatchedShow(const watch::test::WorldOptions& world) : stage(world) {
  io::save_image(folder / "content.png", watch::test::picture(watch::test::Content::kVideo, 0.5, 1));
  SurfaceSet set;
  for (const SolvedSurface& surface : stage.solved().surfaces) set.surfaces.push_back(surface.surface);
  for (Surface& surface : set.surfaces) surface.content = "content.png";
  io::save_surfaces(folder / "surfaces.json", set);
  std::filesystem::create_directory(folder / "camera");
  options.surfaces = (folder / "surfaces.json").string();
  options.control = "off";
  options.fps = 20;
  options.duration_s = 90;
  options.record = (folder / "run.log").string();
  options.watch.emplace().camera = "watch:" + (folder / "camera").string();
}

BumpedShow WatchedShow::run(std::function<void(WatchedWorld&)> bump) {
  std::atomic<bool> ends{false};
  std::thread camera([&] {
    for (int i = 0; !ends; ++i) {
      const ImageU8 frame = screen.last();
      if (frame.width() == 0) continue;
      ImageU8 seen;
      {
        const std::lock_guard<std::mutex> lock(stage.mutex);
        seen = stage.world.image(frame, 0.5);
      }
      const auto part = folder / "camera.part.png";
      io::save_image(part, seen);
      std::filesystem::rename(part, folder / "camera" / ("image_" + std::to_string(100000 + i) + ".png"));
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
  });
  BumpedShow listener(stage, screen, std::move(bump));
  report = show::run(rig, options, screen, &listener);
  ends = true;
  camera.join();
  return listener;
}

TEST(LightWatch, AShowCorrectsItsPictureAndReplays) {
  WatchedShow show;
  auto& [folder, stage, rig, screen, options, report] = show;
  WatchInput& watching = *options.watch;
  watching.save = (folder / "corrected.json").string();
  const BumpedShow listener =
      show.run([](WatchedWorld& world) { world.projector_moved << 0.001, 0.004, 0, 0, 0, 0; });
  EXPECT_GT(listener.corrected_at, 0) << listener.events;
  ASSERT_TRUE(report.metrics.watch && report.metrics.watch->corrections > 0) << listener.events;

  // The last frame is the one that is drawn for the projector where it truly is, but for what the estimate is off.
  const Pose truth = se3_exp(stage.world.projector_moved) * rig.projector().rig_from_projector;
  const Rig corrected = io::load_rig(watching.save);
  EXPECT_LT(apart_mm(stage, corrected.projector().rig_from_projector, truth), 0.8);
  ShowOptions again = options;
  again.watch.reset();
  again.record.clear();
  again.duration_s = 0.3;
  KeptFrames fresh(screen.size());
  show::run(corrected, again, fresh);
  const ImageU8 last = screen.last(), expected = fresh.last();
  long differing = 0;
  for (int y = 0; y < last.height(); ++y)
    for (int x = 0; x < last.width(); ++x)
      differing += std::abs(int(last.at(x, y)) - int(expected.at(x, y))) > 1;
  EXPECT_LT(differing, 20);

  again.output = "none";
  const ReplayReport replayed = replay(rig, again, options.record);
  EXPECT_EQ(replayed.equal, replayed.frames);
  EXPECT_GT(replayed.frames, 40u);
}

/// A robot that lights one wall of a corner while another robot of the fleet lights the other one with a film.
TEST(LightWatch, ARobotOfAFleetCorrectsItsPictureBesideAnother) {
  if (!dds::is_available()) GTEST_SKIP() << "built without DDS";
  ::setenv("ROS_LOCALHOST_ONLY", "1", 1);
  const std::string fleet = "watched_" + std::to_string(::getpid());
  dds::RobotFleet spot({fleet, "spot"});
  watch::test::WorldOptions world;
  world.walls = watch::test::corner();
  world.of_another = 1;
  WatchedShow show(world);
  show.options.record.clear();  // not of a fleet
  show.options.fleet = fleet;
  show.options.robot = "rover";
  std::atomic<bool> ends{false};
  std::thread other([&] {
    for (; !ends; std::this_thread::sleep_for(std::chrono::milliseconds(20))) {
      spot.claim({{show.stage.walls[1].name, 5, false, true}});
      spot.shown(spot.lit(), steady_now());
    }
  });
  const BumpedShow listener =
      show.run([](WatchedWorld& of) { of.projector_moved << 0.001, 0.004, 0.001, 0, 0, 0; });
  ends = true;
  other.join();
  ::unsetenv("ROS_LOCALHOST_ONLY");
  EXPECT_NE(listener.events.find("spot lights '" + show.stage.walls[1].name + "'"), std::string::npos)
      << listener.events;
  EXPECT_GT(listener.corrected_at, 0) << listener.events;
  // The last frame is the one that is drawn where the projector truly is, and dark on the other wall.
  Rig moved = show.rig;
  moved.projectors[0].rig_from_projector =
      (se3_exp(show.stage.world.projector_moved) * moved.projectors[0].rig_from_projector).normalized();
  ShowOptions again = show.options;
  again.watch.reset();
  again.fleet.clear(), again.robot.clear();
  again.duration_s = 0.3;
  SurfaceSet own = io::load_surfaces(again.surfaces);
  own.surfaces.resize(1);
  io::save_surfaces(again.surfaces, own);
  KeptFrames fresh(show.screen.size());
  show::run(moved, again, fresh);
  const ImageU8 last = show.screen.last(), expected = fresh.last();
  double difference = 0, sum = 0;
  for (int y = 0; y < last.height(); ++y)
    for (int x = 0; x < last.width(); ++x) {
      difference += std::abs(int(last.at(x, y)) - int(expected.at(x, y)));
      sum += expected.at(x, y);
    }
  EXPECT_GT(sum, 1e6);
  EXPECT_LT(difference, 0.05 * sum) << listener.events;
}

/// A sheet that is tilted and pushed back during the show: the picture is a rectangle again, and the replay is the same.
TEST(LightWatch, AShowFollowsASheetThatWasMoved) {
  WatchedShow show;
  const watch::test::Wall wall = watch::test::one_wall().front();
  const Vec3 centre = wall.rig_from_surface * Vec3(wall.size.x() / 2, wall.size.y() / 2, 0);
  const Vec3 turn(0.015, 0.035, 0), way = 0.03 * (wall.rig_from_surface.rotation * Vec3::UnitZ());
  const BumpedShow listener =
      show.run([&](WatchedWorld& world) { world.walls_moved[0] << turn, way - turn.cross(centre); });
  EXPECT_GT(listener.corrected_at, 0) << listener.events;
  EXPECT_NE(listener.events.find("watch: corrected: wall rotated by"), std::string::npos) << listener.events;

  // The last surfaces of the log are those that were drawn last.
  RunReader log(show.options.record, show.options.surfaces);
  Pose believed;
  while (const auto record = log.next())
    if (const auto* surfaces = std::get_if<SurfaceSet>(&*record))
      believed = place_of(surfaces->surfaces[0].geometry)->frame_from_surface;
  const Pose truth = se3_exp(show.stage.world.walls_moved[0]) * wall.rig_from_surface;
  // Three of six movements move light: the distance and the two tilts. Here of the plane at its centre.
  const Vec3 normal = truth.rotation * Vec3::UnitZ(), found = believed.rotation * Vec3::UnitZ();
  EXPECT_LT(std::acos(std::min(1.0, normal.dot(found))), 0.006);  // of 0.038
  const Vec3 middle = truth * Vec3(wall.size.x() / 2, wall.size.y() / 2, 0);
  EXPECT_LT(std::abs(found.dot(middle - believed.translation)), 0.005);  // of 0.03

  ShowOptions again = show.options;
  again.watch.reset();
  again.record.clear();
  again.output = "none";
  const ReplayReport replayed = replay(show.rig, again, show.options.record);
  EXPECT_EQ(replayed.equal, replayed.frames);
  EXPECT_GT(replayed.frames, 40u);
}

/// A rig whose pose is wrong: the images tell by how much, along the ray to the wall; the log has what became of it.
TEST(LightWatch, ImagesTellWhereTheRigIs) {
  test::Scratch folder;
  Stage stage;
  const Vec3 away(0, 0, 0.015);
  for (Vec6& wall : stage.world.walls_moved) wall.tail<3>() = away;
  LightWatchOptions options = quick(stage, (folder / "watch.csv").string());
  options.watch.locates_rig = true;
  options.corrects = true;
  std::vector<track::PoseSight> sights;
  {
    LightWatch watch([&] { return std::make_unique<StageCamera>(stage); }, options);
    SolvedSurfaceSet solved = stage.solved();
    solved.projector_from_world = stage.world.rig().projector().rig_from_projector.inverse();
    for (SolvedSurface& surface : solved.surfaces)
      std::get<PlanarSurface>(surface.surface.geometry).frame = "world";
    const auto frame = std::make_shared<const ImageU8>(stage.frame);
    track::PoseCorrectionStatus became;
    became.error[3] = 0.0125;
    for (const double begin = device::now_s(); sights.size() < 3 && device::now_s() < begin + 60;) {
      watch.shown(frame, device::now_s(), solved, stage.world.rig().projector().rig_from_projector);
      std::this_thread::sleep_for(std::chrono::milliseconds(16));
      if (const auto news = watch.take())
        sights.insert(sights.end(), news->sights.begin(), news->sights.end());
      if (!sights.empty()) watch.tell(became);
    }
  }
  ASSERT_GE(sights.size(), 3u);
  EXPECT_TRUE(sights[0].world_from_rig.matrix().isIdentity(1e-9));
  Mat6 information = sights[0].information;
  information.diagonal() +=
      Vec6::Constant(1e-4 * information(5, 5));  // what no light shows stays where it is
  const Vec6 moved = information.llt().solve(sights[0].score);
  const Vec3 centre(0, 0, 2.15);
  EXPECT_NEAR((moved.head<3>().cross(centre) + moved.tail<3>()).z(), 0.015, 0.003);
  std::ifstream log(folder / "watch.csv");
  std::string header, line, last;
  std::getline(log, header);
  while (std::getline(log, line)) last = line;
  EXPECT_NE(header.find(",pose_x_mm,pose_y_mm,pose_yaw_deg"), std::string::npos) << header;
  EXPECT_EQ(std::count(last.begin(), last.end(), ','), std::count(header.begin(), header.end(), ','));
  EXPECT_NE(last.find(",12.5,"), std::string::npos) << last;
}

TEST(LightWatch, AMapOfOtherMarkersIsReportedOnce) {
  /// Marker 9 in the middle of the image.
  class Marked : public StageCamera {
   public:
    using StageCamera::StageCamera;
    std::optional<device::SeenFrame> next(double after_s, double timeout) override {
      std::optional<device::SeenFrame> seen = StageCamera::next(after_s, timeout);
      const MarkerCells cells = detect::marker_cells(MarkerDictionary::kAprilTag36h11);
      constexpr int kSide = 12, kOf = 9;
      const auto level = [&](int x, int y) {  // with the blur of a lens
        int white = 0;
        for (int k = 0; k < kOf; ++k)
          white += cells.is_white(9, (y + k / 3 - 1) / kSide - 2, (x + k % 3 - 1) / kSide - 2) ? 1 : 0;
        return std::uint8_t(20 + 200 * white / kOf);
      };
      for (int y = 0; y < kSide * (cells.per_side + 4); ++y)
        for (int x = 0; x < kSide * (cells.per_side + 4); ++x)
          seen->image.view().row(y + 180)[x + 260] = level(x, y);
      return seen;
    }
  };
  const auto sentences_with = [](int placed) {
    Stage stage;
    LightWatchOptions options = quick(stage, "");
    options.watch.locates_rig = true;
    options.corrects = true;
    options.markers.dictionary = MarkerDictionary::kAprilTag36h11;
    options.markers.markers = {{placed, 0.1, Pose(Eigen::Quaterniond::Identity(), Vec3(0, 0, 2))}};
    options.map_patience = 0.3;
    std::vector<std::string> sentences, of_map;
    LightWatch watch([&] { return std::make_unique<Marked>(stage); }, options);
    show_until(watch, stage, sentences, [](const WatchStatus& s) { return s.checks >= 20; });
    for (const std::string& sentence : sentences)
      if (sentence.find("of the map") != std::string::npos) of_map.push_back(sentence);
    return of_map;
  };
  const std::vector<std::string> said = sentences_with(4);
  ASSERT_EQ(said.size(), 1u);
  EXPECT_NE(said[0].find("; 9, which"), std::string::npos) << said[0];
  EXPECT_TRUE(sentences_with(9).empty());
}

TEST(LightWatch, ACameraWithoutImagesIsReported) {
  class Silent : public device::FrameSource {
    std::optional<device::SeenFrame> next(double, double timeout) override {
      std::this_thread::sleep_for(std::chrono::duration<double>(timeout));
      return std::nullopt;
    }
  };
  Stage stage;
  std::vector<std::string> sentences;
  LightWatch watch([] { return std::make_unique<Silent>(); }, quick(stage, ""));
  const std::optional<LightWatch::News> first = watch.take();
  ASSERT_TRUE(first);
  EXPECT_EQ(first->status.state, "starting");
  ASSERT_TRUE(
      show_until(watch, stage, sentences, [](const WatchStatus& s) { return s.state == "no_images"; }));
  EXPECT_EQ(sentences, std::vector<std::string>{"watch: the camera gives no images"});
}

TEST(LightWatch, ACameraOfAnotherSizeIsAStateAndSaidOnce) {
  class Small : public device::FrameSource {
    std::optional<device::SeenFrame> next(double after_s, double) override {
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
      return device::SeenFrame{ImageU8({320, 240}, 1), after_s + 0.01};
    }
  };
  Stage stage;
  std::vector<std::string> sentences;
  LightWatch watch([] { return std::make_unique<Small>(); }, quick(stage, ""));
  WatchStatus last;
  ASSERT_TRUE(show_until(watch, stage, sentences, [&](const WatchStatus& s) {
    last = s;
    return s.faults >= 4;
  }));
  EXPECT_EQ(last.state, "no_images");
  EXPECT_NE(last.sentence.find("not of the size"), std::string::npos) << last.sentence;
  EXPECT_EQ(sentences, std::vector<std::string>{"watch: " + last.sentence});
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
  status.corrections = 3;
  status.corrects = true;
  status.error_mm = 7.375;
  status.error_sigma_mm = 0.125;
  status.history_mm = {0.0625, NAN};
  status.corrects_pose = true;
  status.pose_off_mm = 21.5;
  status.pose_refused = 4;
  page.watch = status;
  const nlohmann::json watch = nlohmann::json::parse(to_json_text(page)).at("watch");
  EXPECT_EQ(watch.at("state"), "moved");
  EXPECT_EQ(watch.at("alarm"), true);
  EXPECT_EQ(watch.at("corrections"), 3);
  EXPECT_EQ(watch.at("corrects"), true);
  EXPECT_EQ(watch.at("corrected"), false);
  EXPECT_EQ(watch.at("error_mm"), 7.375);
  EXPECT_EQ(watch.at("pose_off_mm"), 21.5);
  EXPECT_EQ(watch.at("history_mm"), nlohmann::json::parse("[0.0625, null]"));
  Metrics metrics;
  EXPECT_EQ(to_prometheus(metrics, {}).find("procam_watch"), std::string::npos);
  metrics.watch = status;
  const std::string text = to_prometheus(metrics, {});
  for (const char* line :
       {"procam_watch_checks_total 31\n", "procam_watch_alarms_total 2\n",
        "procam_watch_corrections_total 3\n", "procam_watch_alarm 1\n",
        "procam_watch_error_metres 0.007375\n", "procam_watch_error_sigma_metres 0.000125\n",
        "procam_watch_pose_off_metres 0.0215\n", "procam_watch_pose_refused_total 4\n",
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
