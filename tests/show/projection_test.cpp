/// From poses to frames: are they the frames that the renderer draws for that pose?
#include "procam/show/projection.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <filesystem>
#include <fstream>
#include <thread>

#include "live_world.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/surface_file.hpp"
#include "procam/render/cpu.hpp"
#include "procam/show/metrics.hpp"
#include "procam/surface/solve.hpp"
#include "prometheus.hpp"
#include "run_log.hpp"
#include "show_loader.hpp"

namespace procam::show {
namespace {

namespace fs = std::filesystem;

bool same(ViewU8 a, ViewU8 b) {
  for (int y = 0; y < a.height; ++y)
    if (!std::equal(a.row(y), a.row(y) + a.width * a.channels, b.row(y))) return false;
  return a.size() == b.size();
}

bool is_black(ViewU8 frame) {
  for (int y = 0; y < frame.height; ++y)
    for (int x = 0; x < frame.width * frame.channels; ++x)
      if (frame.row(y)[x] != 0) return false;
  return true;
}

/// What the renderer makes of the show when the projector stands there.
ImageU8 reference(const Show& show, const RigProjector& projector, const Pose& projector_from_world) {
  const SolvedSurfaceSet solved = surface::solve_surfaces(show.surfaces, projector, projector_from_world);
  procam::Scene scene;
  for (std::size_t i = 0; i < solved.surfaces.size(); ++i)
    scene.items.push_back({solved.surfaces[i].placement, show.contents[i]->at(0).view});
  return render::render(scene, projector.projector);
}

ProjectionOptions newest_pose_counts() {
  ProjectionOptions options;
  options.track.prediction = track::Prediction::kNone;
  options.track.stale_after = 0.5;
  options.child_from_rig = Pose(so3_exp(Vec3(-0.05, 0.02, 0.09)), Vec3(0.04, 0.02, -0.1));
  return options;
}

/// A bump that is known: frames are those of a rig in which the projector stands there, wherever the surfaces are.
TEST(Projection, AMovedProjectorDrawsAsOneOfARigThatHasItThere) {
  Rig bumped = small_rig();
  const Pose moved(so3_exp(Vec3(0.01, -0.02, 0.015)), Vec3(0.02, -0.01, 0.03));
  bumped.projectors[0].rig_from_projector = moved * bumped.projectors[0].rig_from_projector;
  Show show = small_show();
  // A surface of the rig beside that of the world.
  Surface in_rig = show.surfaces.surfaces[0];
  in_rig.name += " of the rig";
  auto& plane = std::get<PlanarSurface>(in_rig.geometry);
  plane.frame = "rig";
  plane.frame_from_surface =
      small_rig().projector().rig_from_projector * Pose(so3_exp(Vec3(0.1, 0.2, 0)), Vec3(-0.3, -0.2, 2));
  show.surfaces.surfaces.push_back(in_rig);
  show.contents.push_back(show.contents[0]);
  for (const bool stands : {false, true}) {
    ProjectionOptions options = newest_pose_counts();
    const Pose world_from_child(so3_exp(Vec3(0.02, 0.1, -0.03)), Vec3(0.1, 0.05, -0.2));
    const auto standing = [&](const Rig& rig) {
      ProjectionOptions own = options;
      if (stands)
        own.projector_from_world =
            (world_from_child * options.child_from_rig * rig.projector().rig_from_projector).inverse();
      return own;
    };
    Projection projection(small_rig(), standing(small_rig())), expected(bumped, standing(bumped));
    projection.set_show(show);
    expected.set_show(show);
    ImageU8 before(projection.frame_size(), 3), frame(projection.frame_size(), 3),
        reference(projection.frame_size(), 3);
    for (Projection* one : {&projection, &expected}) one->add(message(10, world_from_child));
    projection.draw(10, 0, before);
    projection.move_projector(bumped.projector().rig_from_projector);
    projection.draw(10, 0, frame);
    expected.draw(10, 0, reference);
    EXPECT_FALSE(is_black(reference));
    EXPECT_FALSE(same(before, frame));
    EXPECT_TRUE(same(frame, reference)) << stands;
    // And back, bit for bit.
    projection.move_projector(small_rig().projector().rig_from_projector);
    projection.draw(10, 0, frame);
    EXPECT_TRUE(same(before, frame)) << stands;
  }
}

/// Marks are part of the content: masks over people are drawn over them, test patterns have none, and what is black stays so.
TEST(Projection, MarksAreOnContentAlone) {
  Show show = small_show();
  for (auto& content : show.contents) content = device::still_content(ImageU8(8, 6, 3, 100));
  ProjectionOptions options = newest_pose_counts();
  options.blank_on_stale = true;
  Projection plain(small_rig(), options);
  options.marks = true;
  bool masks = false;
  options.over = [&](const Projection&, double, ImageView<std::uint8_t> frame) {
    for (int y = 0; masks && y < frame.height; ++y)
      std::fill_n(frame.row(y), frame.width * frame.channels, std::uint8_t(0));
  };
  Projection marked(small_rig(), options);
  ImageU8 without(plain.frame_size(), 3), with(plain.frame_size(), 3);
  for (Projection* one : {&plain, &marked}) one->set_show(show);
  const auto draw = [&](double time) {
    plain.draw(time, 0, without);
    marked.draw(time, 0, with);
  };
  for (Projection* one : {&plain, &marked}) one->add(message(10, Pose()));
  draw(10);
  EXPECT_FALSE(is_black(without));
  EXPECT_FALSE(same(with, without));
  for (const TestPattern pattern : {TestPattern::kGrid, TestPattern::kMask}) {
    for (Projection* one : {&plain, &marked}) one->set_picture(pattern);
    draw(10);
    EXPECT_TRUE(same(with, without));
  }
  marked.set_picture(TestPattern::kContent);
  masks = true;
  draw(10.1);
  EXPECT_TRUE(is_black(with));
  masks = false;
  draw(30);
  EXPECT_TRUE(is_black(with));  // the pose is stale
}

TEST(Projection, DrawsFromWhereTheRobotIs) {
  const Rig rig = small_rig();
  const ProjectionOptions options = newest_pose_counts();
  Projection projection(rig, options);
  const Show show = small_show();
  projection.set_show(show);
  ImageU8 frame(projection.frame_size(), 3);
  for (int i = 0; i < 3; ++i) {
    const Pose world_from_child(so3_exp(Vec3(0.02 * i, -0.05 * i, 0.03)), Vec3(0.05 * i, -0.04, 0.02 * i));
    projection.add(message(10 + i, world_from_child));
    const DrawnFrame drawn = projection.draw(10 + i, 0, frame);
    EXPECT_EQ(drawn.pose.state, track::TrackState::kFresh);
    EXPECT_FALSE(drawn.blanked);
    // The pose as the track gives it back: through its clock and filter it is the message up to rounding.
    EXPECT_LT((drawn.pose.frame_from_child.translation - world_from_child.translation).norm(), 1e-9);
    const Pose projector_from_world =
        (drawn.pose.frame_from_child * options.child_from_rig * rig.projectors[0].rig_from_projector)
            .inverse()
            .normalized();
    EXPECT_TRUE(same(frame, reference(show, rig.projectors[0], projector_from_world))) << i;
    EXPECT_FALSE(is_black(frame));
  }
}

TEST(Projection, WhatStandsInTheWorldWaitsForAPose) {
  const Rig rig = small_rig();
  Projection projection(rig, newest_pose_counts());
  Show show = small_show();
  projection.set_show(show);
  ImageU8 frame(projection.frame_size(), 3, 77);
  const DrawnFrame drawn = projection.draw(1, 0, frame);
  EXPECT_EQ(drawn.pose.state, track::TrackState::kNone);
  EXPECT_EQ(frame.at(60, 20, 0), 0);   // where a wall would be
  EXPECT_NE(frame.at(70, 140, 2), 0);  // the sign is in the projector's own pixels
  show.surfaces.surfaces.pop_back();
  show.contents.pop_back();
  projection.set_show(show);
  EXPECT_TRUE(projection.draw(1, 0, frame).blanked);
  EXPECT_TRUE(is_black(frame));
}

TEST(Projection, AStalePoseTurnsBlackOrStays) {
  for (const bool blank : {true, false}) {
    ProjectionOptions options = newest_pose_counts();
    options.blank_on_stale = blank;
    Projection projection(small_rig(), options);
    projection.set_show(small_show());
    ImageU8 frame(projection.frame_size(), 3), fresh = frame;
    projection.add(message(10, Pose()));
    projection.draw(10.1, 0, fresh);
    const DrawnFrame stale = projection.draw(10.7, 0, frame);
    EXPECT_EQ(stale.pose.state, track::TrackState::kStale);
    EXPECT_EQ(stale.blanked, blank);
    EXPECT_EQ(is_black(frame), blank);
    if (!blank) EXPECT_TRUE(same(frame, fresh));
    projection.add(message(11, Pose()));
    EXPECT_FALSE(projection.draw(11.01, 0, frame).blanked);
    EXPECT_TRUE(same(frame, fresh));
  }
}

TEST(Projection, KeepsItsShowWhenTheNextCannotBeSolved) {
  Projection projection(small_rig(), newest_pose_counts());
  projection.set_show(small_show());
  projection.add(message(10, Pose()));
  ImageU8 before(projection.frame_size(), 3), after = before;
  projection.draw(10, 0, before);
  Show broken = small_show();
  std::get<PixelSurface>(broken.surfaces.surfaces[2].geometry).pixels = {{0, 0}, {1, 0}, {2, 0}, {3, 0}};
  EXPECT_THROW(projection.set_show(broken), Error);
  Show short_of_one = small_show();
  short_of_one.contents.pop_back();
  EXPECT_THROW(projection.set_show(short_of_one), std::invalid_argument);
  projection.draw(10, 0, after);
  EXPECT_TRUE(same(before, after));
}

/// Memory that comes again with other pixels must not be taken for the picture that was there.
TEST(Projection, ANewContentInTheSameMemoryIsSeen) {
  Projection projection(small_rig(), newest_pose_counts());
  projection.add(message(10, Pose()));
  ImageU8 pixels = colourful(61, 47, 1);
  const auto same_memory = [&] {
    return device::drawn_content({61, 47}, 3, [](double, ImageView<std::uint8_t>) { return false; });
  };
  Show show;
  show.surfaces.surfaces = {pixel_area("sign")};
  show.contents = {same_memory()};
  projection.set_show(show);
  ImageU8 frame(projection.frame_size(), 3);
  projection.draw(10, 0, frame);
  EXPECT_TRUE(is_black(frame));
  show.contents[0].reset();
  projection.set_show(show);  // frees the memory
  show.contents[0] = device::still_content(std::move(pixels));
  projection.set_show(show);
  projection.draw(10, 0, frame);
  EXPECT_FALSE(is_black(frame));
}

/// Monte Carlo with 4000 draws: the rms of 3-D shifts is known to about 1 %; 5 sigmas are allowed.
TEST(Projection, PredictsTheErrorOfTheLight) {
  const Rig rig = small_rig();
  ProjectionOptions options = newest_pose_counts();
  Projection projection(rig, options);
  Show show = small_show();
  show.surfaces.surfaces.resize(1);
  show.contents.resize(1);
  projection.set_show(show);
  Mat6 root;
  std::mt19937_64 random(3);
  for (int r = 0; r < 6; ++r)
    for (int c = 0; c < 6; ++c) root(r, c) = 1e-3 * test::uniform(random, -1, 1);
  track::StampedPose pose = message(10, Pose(so3_exp(Vec3(0.02, -0.05, 0.03)), Vec3(0.05, -0.04, 0.02)));
  pose.covariance = root * root.transpose();
  projection.add(pose);
  ImageU8 frame(projection.frame_size(), 3);
  const DrawnFrame drawn = projection.draw(10, 0, frame);

  const Pose world_from_child = drawn.pose.frame_from_child;
  const Pose projector_in_child = options.child_from_rig * rig.projectors[0].rig_from_projector;
  const auto& plane = std::get<PlacedPlane>(projection.solved().surfaces[0].placement);
  const auto& shape = std::get<PlanarSurface>(show.surfaces.surfaces[0].geometry);
  const Vec3 h = plane.plane_from_content * Vec3(0.5, 0.5, 1);
  const Vec3 place = shape.frame_from_surface * Vec3(h.x() / h.z(), h.y() / h.z(), 0);
  const Vec3 normal = shape.frame_from_surface.rotate(Vec3::UnitZ());
  const Vec3 bearing = (world_from_child * projector_in_child).inverse() * place;
  const Mat6 sigma = Eigen::LLT<Mat6>(drawn.pose.covariance).matrixL();
  std::normal_distribution<double> normal_draw;
  double squares = 0;
  constexpr int kDraws = 4000;
  for (int i = 0; i < kDraws; ++i) {
    Vec6 xi;
    for (int k = 0; k < 6; ++k) xi[k] = normal_draw(random);
    const Pose truly = se3_exp(Vec6(sigma * xi)) * world_from_child * projector_in_child;
    const Vec3 direction = truly.rotate(bearing);
    const double along = normal.dot(place - truly.translation) / normal.dot(direction);
    squares += (truly.translation + along * direction - place).squaredNorm();
  }
  EXPECT_NEAR(drawn.pose_error / std::sqrt(squares / kDraws), 1, 0.06);
  EXPECT_GT(drawn.pose_error, 1e-4);
}

class RunLog : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "procam_run_XXXXXX").string();
    folder_ = mkdtemp(name.data());
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path folder_;
};

TEST_F(RunLog, ShowsTheSameFramesAgain) {
  const fs::path file = folder_ / "run.log";
  ProjectionOptions options;
  options.track.prediction = track::Prediction::kAuto;
  std::mt19937_64 random(8);
  std::vector<std::uint64_t> shown;
  {
    Projection projection(small_rig(), options);
    projection.set_show(small_show());
    RunRecorder recorder(file, "said \"so\"\n");
    recorder.record(projection.show().surfaces);
    ImageU8 frame(projection.frame_size(), 3);
    for (int i = 0; i < 60; ++i) {
      const double time = 1234.5 + i / 60.0;
      if (i % 2 == 0) {
        const track::StampedPose pose = message(
            time - 0.01,
            Pose(so3_exp(Vec3(1e-3 * i, -2e-3 * i, test::uniform(random, 0, 1e-3))), Vec3(0.004 * i, 0, 0)));
        recorder.record(pose);
        projection.add(pose);
      }
      if (i == 30) {
        projection.set_picture(TestPattern::kGrid);
        recorder.record(TestPattern::kGrid);
      }
      projection.draw(time + 0.1, i / 60.0, frame);
      shown.push_back(fingerprint(frame));
      recorder.record(RecordedFrame{i, time + 0.1, i / 60.0, shown.back()});
    }
  }
  Projection projection(small_rig(), options);
  ImageU8 frame(projection.frame_size(), 3);
  std::size_t frames = 0;
  std::string conditions;
  const auto play = [&] {
    RunReader reader(file);
    while (std::optional<RunRecord> record = reader.next()) {
      if (const auto* said = std::get_if<RunConditions>(&*record)) conditions = said->text;
      if (auto* set = std::get_if<SurfaceSet>(&*record)) {
        Show show = small_show();
        show.surfaces = std::move(*set);
        projection.set_show(std::move(show));
      }
      if (const auto* picture = std::get_if<TestPattern>(&*record)) projection.set_picture(*picture);
      if (const auto* pose = std::get_if<track::StampedPose>(&*record)) projection.add(*pose);
      if (const auto* recorded = std::get_if<RecordedFrame>(&*record)) {
        projection.draw(recorded->light_time, recorded->content_time, frame);
        EXPECT_EQ(fingerprint(frame), recorded->fingerprint) << frames;
        EXPECT_EQ(recorded->fingerprint, shown.at(frames));
        EXPECT_EQ(recorded->number, (long long)frames);
        ++frames;
      }
    }
  };
  play();
  EXPECT_EQ(frames, 60u);
  EXPECT_EQ(conditions, "said _so__");
  EXPECT_LE(std::count(shown.begin(), shown.end(), shown[0]), 2) << "the robot moves: frames differ";

  // Cut in its last line: the rest is read. Damaged before: the line is named.
  const auto size = fs::file_size(file);
  fs::resize_file(file, size - 5);
  frames = 0;
  Projection second(small_rig(), options);
  projection = std::move(second);
  play();
  EXPECT_EQ(frames, 59u);
  frames = 0;
  Projection third(small_rig(), options);
  projection = std::move(third);
  std::ofstream(file, std::ios::app) << "\n{\"frame\":nan}\n";
  try {
    play();
    ADD_FAILURE() << "it was read";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("line 9"), std::string::npos) << error.what();
  }
}

TEST(Fingerprint, TellsFramesApart) {
  ImageU8 frame = colourful(67, 31, 3);
  const std::uint64_t first = fingerprint(frame);
  for (int i = 0; i < 67 * 31 * 3; i += 11) {
    ImageU8 other = frame;
    other.data()[i] ^= 1;
    EXPECT_NE(fingerprint(other), first) << i;
  }
  std::swap_ranges(frame.row(3), frame.row(4), frame.row(10));
  EXPECT_NE(fingerprint(frame), first);
  // A view into a larger picture has the same pixels.
  ImageU8 large(80, 31, 3);
  for (int y = 0; y < 31; ++y) std::copy(frame.row(y), frame.row(y) + 67 * 3, large.row(y));
  EXPECT_EQ(fingerprint(ViewU8(large.data(), 67, 31, 3, 240)), fingerprint(frame));
}

class Loader : public RunLog {
 protected:
  ShowLoaderOptions options() {
    ShowLoaderOptions options;
    options.surfaces = folder_ / "surfaces.json";
    options.period_s = 0.02;
    return options;
  }
  /// All but the content of "dark" is there.
  void write(const std::string& name) {
    io::save_image(folder_ / "first.png", colourful(9, 9, 1));
    for (const char* other : {"second.png", "third.png", "a.png"})
      if (!fs::exists(folder_ / other)) fs::copy_file(folder_ / "first.png", folder_ / other);
    if (name == "broken")
      std::ofstream(folder_ / "surfaces.json") << name;
    else
      io::save_surfaces(folder_ / "surfaces.json", {{pixel_area(name)}});
  }
  static std::optional<LoadedShow> wait(ShowLoader& loader) {
    for (int i = 0; i < 500; ++i) {
      if (auto loaded = loader.take()) return loaded;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return std::nullopt;
  }
};

TEST_F(Loader, ReadsAgainWhatChangedAndToldWhatFailed) {
  write("first");
  ShowLoader loader(options());
  EXPECT_EQ(loader.load_now().show->surfaces.surfaces[0].name, "first");
  EXPECT_FALSE(loader.take());
  write("second");
  auto loaded = wait(loader);
  ASSERT_TRUE(loaded && loaded->show);
  EXPECT_TRUE(loaded->from_file);
  EXPECT_EQ(loaded->show->surfaces.surfaces[0].name, "second");
  write("broken");
  loaded = wait(loader);
  ASSERT_TRUE(loaded);
  EXPECT_FALSE(loaded->show);
  ASSERT_EQ(loaded->faults.size(), 1u);
  fs::remove(folder_ / "surfaces.json");
  loaded = wait(loader);
  ASSERT_TRUE(loaded && loaded->from_file);
  EXPECT_FALSE(loaded->show);
  ASSERT_EQ(loaded->faults.size(), 1u);
  EXPECT_NE(loaded->faults[0].find("it was removed"), std::string::npos) << loaded->faults[0];
  write("dark");
  loaded = wait(loader);
  ASSERT_TRUE(loaded && loaded->show);
  EXPECT_EQ(loaded->show->contents[0], nullptr);
  ASSERT_EQ(loaded->faults.size(), 1u);
  EXPECT_NE(loaded->faults[0].find("'dark' stays dark"), std::string::npos) << loaded->faults[0];
  // What this program writes is no news.
  loader.save({{pixel_area("third")}});
  std::this_thread::sleep_for(std::chrono::milliseconds(150));
  EXPECT_FALSE(loader.take());
  SurfaceSet asked;
  asked.surfaces = {pixel_area("a"), pixel_area("a")};
  loader.request(asked);
  loaded = wait(loader);
  ASSERT_TRUE(loaded && loaded->show);
  EXPECT_FALSE(loaded->from_file);
  EXPECT_EQ(loaded->show->contents[0], loaded->show->contents[1]) << "one file is opened once";
}

TEST(Metrics, PercentilesOfWhatCame) {
  Durations durations;
  EXPECT_EQ(durations.quantile(0.99), 0);
  for (int i = 1; i <= 1000; ++i) durations.add(1e-5 * i);
  EXPECT_NEAR(durations.quantile(0.5), 5e-3, 0.018 * 5e-3);
  EXPECT_NEAR(durations.quantile(0.99), 9.9e-3, 0.018 * 9.9e-3);
  EXPECT_EQ(durations.quantile(1), durations.largest());
  EXPECT_NEAR(durations.mean(), 5.005e-3, 1e-12);
  for (const double odd : {-1.0, 0.0, 1e9, std::nan("")}) durations.add(odd);
  EXPECT_EQ(durations.count(), 1004u);
  Metrics metrics;
  metrics.frames = 12;
  metrics.draw.add(0.004);
  track::Faults poses;
  poses.lost = 7;
  const std::string text = to_prometheus(metrics, poses);
  EXPECT_NE(text.find("\nprocam_frames_total 12\n"), std::string::npos);
  EXPECT_NE(text.find("\nprocam_draw_seconds_count 1\n"), std::string::npos);
  EXPECT_NE(text.find("\nprocam_pose_faults_total{name=\"lost\"} 7\n"), std::string::npos);
}

}  // namespace
}  // namespace procam::show
