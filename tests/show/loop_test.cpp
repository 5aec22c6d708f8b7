/// The loop when its parts fail: only the sink and the listener end a show.
#include "loop.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "io/scratch.hpp"
#include "live_world.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/surface_file.hpp"
#include "procam/render/cpu.hpp"
#include "procam/show/run.hpp"
#include "support/file_size_limit.hpp"

namespace procam::show {
namespace {

/// Fails at every second call, with what is no procam::Error.
class FailingSource : public track::PoseSource {
 public:
  void poll(std::vector<track::StampedPose>& arrived) override {
    arrived.clear();
    if (++calls_ % 2 == 0) throw std::length_error("a message that nobody foresaw");
    arrived.push_back(message(100 + calls_ / 60.0, Pose()));
  }
  track::SourceStatus status() const override { return {}; }

 private:
  int calls_ = 0;
};

class BrokenSink : public KeptFrames {
 public:
  using KeptFrames::KeptFrames;
  double show(ViewU8 picture) override {
    if (count() == 3) throw Error(ErrorKind::kDevice, "projector", "it is gone", "connect it");
    return KeptFrames::show(picture);
  }
};

/// A loop that ends after so many frames.
struct ShortLoop {
  explicit ShortLoop(const ProjectionOptions& options = standing())
      : projection(small_rig(), options), sink(projection.frame_size()) {
    projection.set_show(small_show());
    parts.say = [this](const std::string& sentence) { said += sentence + "\n"; };
  }
  static ProjectionOptions standing() {
    ProjectionOptions options;
    options.projector_from_world = Pose();
    return options;
  }
  /// ... and when the light was checked so often, once a second.
  Metrics run(std::uint64_t frames, std::uint64_t checks = 0) {
    parts.tick = [=](const Metrics& metrics) {
      if (metrics.frames >= frames && metrics.checked >= checks) sink.wish(device::WindowEvent::kClose);
    };
    LoopOptions options;
    options.fps = 0;
    return run_loop(parts, options);
  }
  Projection projection;
  KeptFrames sink;
  LoopParts parts{projection, sink};
  std::string said;
};

bool has_no_light(const ImageU8& frame) {
  return std::all_of(frame.data(), frame.data() + std::ptrdiff_t(frame.width()) * frame.height() * 3,
                     [](std::uint8_t value) { return value == 0; });
}

TEST(Loop, AMessageThatFailsIsCountedAndTheShowContinues) {
  ShortLoop loop{ProjectionOptions()};
  FailingSource source;
  loop.parts.sources = {&source};
  const Metrics metrics = loop.run(10);
  EXPECT_GE(metrics.frames, 10u);
  EXPECT_GE(metrics.poses, 5u);
  EXPECT_GE(metrics.faults.at("pose_source"), 4u);
  // The same sentence once in ten seconds.
  EXPECT_EQ(loop.said.find("nobody foresaw"), loop.said.rfind("nobody foresaw")) << loop.said;
}

/// Draws as the processor does, until it fails.
class FailingRenderer : public render::CpuRenderer {
 public:
  using render::CpuRenderer::render;
  render::RenderWork render(const Scene& scene, const Projector& projector,
                            ImageView<std::uint8_t> frame) override {
    if (fails) throw std::runtime_error("the graphics driver is gone");
    return CpuRenderer::render(scene, projector, frame);
  }
  bool fails = false;
};

TEST(Loop, AFrameThatCannotBeDrawnIsBlackAndTheShowContinues) {
  ProjectionOptions options = ShortLoop::standing();
  const auto renderer = std::make_shared<FailingRenderer>();
  options.renderer = renderer;
  ShortLoop loop{options};
  EXPECT_TRUE(loop.run(3).faults.empty());
  EXPECT_FALSE(has_no_light(loop.sink.last()));
  renderer->fails = true;
  const Metrics metrics = loop.run(5);
  EXPECT_GE(metrics.faults.at("frame"), 5u);
  EXPECT_TRUE(has_no_light(loop.sink.last()));
  EXPECT_NE(loop.said.find("the graphics driver is gone"), std::string::npos) << loop.said;
}

TEST(Loop, AContentThatFailsLeavesTheOthersLit) {
  ShortLoop loop;
  Show show = small_show();
  show.contents[1] = device::drawn_content({31, 21}, 3, [](double, ImageView<std::uint8_t>) -> bool {
    throw std::runtime_error("the content is broken");
  });
  loop.projection.set_show(show);
  const Metrics metrics = loop.run(5);
  EXPECT_GE(metrics.faults.at("content"), 5u);
  EXPECT_EQ(metrics.faults.count("frame"), 0u);
  EXPECT_FALSE(has_no_light(loop.sink.last()));
  EXPECT_NE(loop.said.find("'right' is dark: the content is broken"), std::string::npos) << loop.said;
}

/// A content whose images may stop, and that remembers which thread ended it.
class StoppingContent : public device::ContentSource {
 public:
  struct Seen {
    std::atomic<bool> stopped{false};
    std::atomic<std::thread::id> ended_by{};
  };
  explicit StoppingContent(Seen& seen) : seen_(seen) {}
  ~StoppingContent() override { seen_.ended_by = std::this_thread::get_id(); }
  device::ContentFrame at(double) override { return {image_.view(), 0}; }
  std::optional<Error> fault() const override {
    if (!seen_.stopped) return std::nullopt;
    return Error(ErrorKind::kDevice, "camera 3", "no more images come from it", "check its cable");
  }

 private:
  Seen& seen_;
  ImageU8 image_ = colourful(20, 10, 2);
};

TEST(Loop, AContentThatStopsIsCountedOnceAndItsReturnReported) {
  StoppingContent::Seen seen;  // the loop's projection ends the content
  ShortLoop loop;
  Show show = small_show();
  show.contents[0] = std::make_shared<StoppingContent>(seen);
  loop.projection.set_show(show);
  seen.stopped = true;
  int checks = 0;
  loop.parts.tick = [&](const Metrics& metrics) {
    if (metrics.faults.count("content") != 0 && seen.stopped) EXPECT_EQ(metrics.contents_stopped, 1u);
    if (metrics.faults.count("content") != 0) checks += 1;
    if (checks > 80) seen.stopped = false;  // two checks later, at 60 frames a second
    if (loop.said.find("'left' shows new images again") != std::string::npos)
      loop.sink.wish(device::WindowEvent::kClose);
  };
  LoopOptions options;
  options.duration_s = 60;
  const Metrics metrics = run_loop(loop.parts, options);
  EXPECT_EQ(metrics.faults.at("content"), 1u);
  EXPECT_EQ(metrics.contents_stopped, 0u);
  EXPECT_NE(loop.said.find("surface 'left' shows its last image: camera 3"), std::string::npos) << loop.said;
  EXPECT_NE(loop.said.find("again"), std::string::npos) << loop.said;
}

/// A camera that has stopped sending takes seconds to end, in which the loop goes on.
TEST(Loop, ContentsAreEndedInTheBackground) {
  test::Scratch folder;
  io::save_surfaces(folder / "surfaces.json", small_show().surfaces);
  StoppingContent::Seen seen;  // the loop's projection ends the content
  ShortLoop loop;
  {
    Show show = small_show();
    show.contents[0] = std::make_shared<StoppingContent>(seen);
    loop.projection.set_show(std::move(show));
  }
  ShowLoaderOptions loading;
  loading.surfaces = folder / "surfaces.json";
  loading.period_s = 0.01;
  ShowLoader loader(loading);
  loop.parts.loader = &loader;
  io::save_surfaces(folder / "surfaces.json", {{pixel_area("another")}});
  loop.parts.tick = [&](const Metrics&) {
    if (seen.ended_by.load() != std::thread::id()) loop.sink.wish(device::WindowEvent::kClose);
  };
  LoopOptions options;
  options.duration_s = 60;
  EXPECT_EQ(run_loop(loop.parts, options).reloads, 1u);
  EXPECT_NE(seen.ended_by.load(), std::thread::id());
  EXPECT_NE(seen.ended_by.load(), std::this_thread::get_id());
}

/// What parts of the show count by themselves is in the statistics also when the listener ends it without a page.
TEST(Loop, FaultsOfOtherPartsAreThereWhenTheShowIsEnded) {
  ShortLoop loop;
  struct Ended {};
  std::uint64_t people = 0;
  loop.parts.other_faults = [](std::map<std::string, std::uint64_t>& faults) { faults["people"] = 5; };
  loop.parts.tick = [&](const Metrics& metrics) {
    if (metrics.faults.count("people") != 0) people = metrics.faults.at("people");
    if (metrics.frames == 3) throw Ended();
  };
  EXPECT_THROW(run_loop(loop.parts, {}), Ended);
  EXPECT_EQ(people, 5u);
}

/// A sender or a camera that goes.
class LeavingSource : public track::PoseSource {
 public:
  void poll(std::vector<track::StampedPose>& arrived) override { arrived.clear(); }
  track::SourceStatus status() const override {
    track::SourceStatus status;
    status.connected = ++asked_ < 2;
    if (!status.connected && has_reason) status.last_error = "the sender has closed the connection";
    return status;
  }
  bool has_reason = true;

 private:
  mutable int asked_ = 0;
};

TEST(Loop, ASourceThatDisconnectsIsCountedUnlessItIsAtItsEnd) {
  ShortLoop loop{ProjectionOptions()};
  LeavingSource sender, log;
  log.has_reason = false;
  loop.parts.sources = {&sender, &log};
  loop.parts.source_names = "a";
  LoopOptions options;
  options.duration_s = 60;
  loop.parts.tick = [&](const Metrics& metrics) {
    if (metrics.faults.count("pose_source") != 0) loop.sink.wish(device::WindowEvent::kClose);
  };
  const Metrics metrics = run_loop(loop.parts, options);
  EXPECT_EQ(metrics.faults.at("pose_source"), 1u);
  EXPECT_NE(loop.said.find("closed the connection"), std::string::npos) << loop.said;
}

TEST(Loop, ASinkThatFailsEndsTheShow) {
  ShortLoop loop;
  BrokenSink broken(loop.projection.frame_size());
  LoopParts parts{loop.projection, broken};
  EXPECT_ERROR(run_loop(parts, {}), kDevice, "projector");
}

/// The listener is asked while a slow frame is awaited, so that Ctrl-C does not wait for it.
TEST(Loop, ASlowShowIsEndedBeforeItsNextFrame) {
  ShortLoop loop;
  int ticks = 0;
  loop.parts.tick = [&](const Metrics& metrics) {
    EXPECT_LE(metrics.frames, 1u) << "the next frame is due in a quarter of an hour";
    if (++ticks == 4) throw std::runtime_error("ended");
  };
  LoopOptions options;
  options.fps = 1e-3;
  EXPECT_THROW(run_loop(loop.parts, options), std::runtime_error);
}

TEST(Loop, AFullDiskEndsTheRecordingAndNotTheShow) {
  test::Scratch folder;
  ShortLoop loop;
  RunRecorder recorder(folder / "run.log", "now");
  loop.parts.recorder = &recorder;
  const test::FileSizeLimit limit(1000);  // less than the surfaces take
  const Metrics metrics = loop.run(400);
  EXPECT_GE(metrics.frames, 400u);
  EXPECT_EQ(metrics.faults.at("record"), 1u);
  EXPECT_NE(loop.said.find("run.log"), std::string::npos) << loop.said;
  EXPECT_NE(loop.said.find("recording has stopped; the show continues"), std::string::npos) << loop.said;
}

/// A file that is read and cannot be shown is no successful reload.
TEST(Loop, ARejectedFileIsAFailedReload) {
  test::Scratch folder;
  io::save_surfaces(folder / "surfaces.json", small_show().surfaces);
  ShortLoop loop;
  ShowLoaderOptions loading;
  loading.surfaces = folder / "surfaces.json";
  loading.period_s = 0.01;
  ShowLoader loader(loading);
  Editor editor(small_show().surfaces);
  loop.parts.loader = &loader;
  loop.parts.editor = &editor;
  SurfaceSet collinear = small_show().surfaces;
  std::get<PixelSurface>(collinear.surfaces[2].geometry).pixels = {{0, 0}, {1, 0}, {2, 0}, {3, 0}};
  io::save_surfaces(folder / "surfaces.json", collinear);
  loop.parts.tick = [&](const Metrics& metrics) {
    if (metrics.failed_reloads + metrics.reloads > 0) loop.sink.wish(device::WindowEvent::kClose);
  };
  LoopOptions options;
  options.fps = 100;
  options.duration_s = 60;
  const Metrics metrics = run_loop(loop.parts, options);
  EXPECT_EQ(metrics.reloads, 0u);
  EXPECT_EQ(metrics.failed_reloads, 1u);
  EXPECT_EQ(metrics.faults.at("surfaces"), 1u);
}

/// What is edited is in the file though nobody saves.
TEST(Loop, EditsAreSavedAutomatically) {
  test::Scratch folder;
  ShortLoop loop;
  ShowLoaderOptions loading;
  loading.surfaces = folder / "surfaces.json";
  ShowLoader loader(loading);
  Editor editor(small_show().surfaces);
  editor.apply({"rename", "sign", -1, {}, "edited", ""}, loop.projection.projector(),
               loop.projection.solved());
  loop.parts.loader = &loader;
  loop.parts.editor = &editor;
  loop.run(3);
  EXPECT_FALSE(std::filesystem::exists(folder / "surfaces.json")) << "only when it is wanted";
  loop.parts.tick = [&](const Metrics&) {
    if (!editor.is_unsaved()) loop.sink.wish(device::WindowEvent::kClose);
  };
  LoopOptions options;
  options.autosave = true;
  options.duration_s = 60;
  run_loop(loop.parts, options);
  EXPECT_EQ(io::load_surfaces(folder / "surfaces.json").surfaces.back().name, "edited");

  // An edit of the last frame, whether the window is closed or the listener ends the show.
  const auto rename = [&](const char* name) {
    editor.apply({"rename", editor.surfaces().surfaces.back().name, -1, {}, name, ""},
                 loop.projection.projector(), loop.projection.solved());
  };
  loop.parts.tick = [&](const Metrics&) {
    rename("edited last");
    loop.sink.wish(device::WindowEvent::kClose);
  };
  run_loop(loop.parts, options);
  EXPECT_EQ(io::load_surfaces(folder / "surfaces.json").surfaces.back().name, "edited last");
  struct Ended {};
  loop.parts.tick = [&](const Metrics&) {
    rename("edited at the end");
    throw Ended();
  };
  EXPECT_THROW(run_loop(loop.parts, options), Ended);
  EXPECT_EQ(io::load_surfaces(folder / "surfaces.json").surfaces.back().name, "edited at the end");
}

TEST(Loop, WhatAWorldSurfaceWaitsForIsNamed) {
  ShortLoop without{ProjectionOptions()};
  const Metrics alone = without.run(3);
  EXPECT_EQ(alone.waiting, alone.frames);
  EXPECT_NE(without.said.find("no pose is given"), std::string::npos) << without.said;

  ShortLoop silent{ProjectionOptions()};
  track::PoseQueue queue;
  silent.parts.sources = {&queue};
  silent.parts.source_names = "udp:9000";
  silent.run(3);
  EXPECT_NE(silent.said.find("waiting for a pose from udp:9000"), std::string::npos) << silent.said;
  queue.push(message(100, Pose()));
  EXPECT_EQ(silent.run(3).waiting, 0u);
}

TEST(Loop, AShowWithoutLightNamesTheLikelyCause) {
  ShortLoop loop;
  EXPECT_EQ(loop.run(2, 1).dark, 0u);
  EXPECT_EQ(loop.said, "");
  Show show = small_show();
  show.surfaces.surfaces.resize(2);
  show.contents.resize(2);
  for (Surface& surface : show.surfaces.surfaces) {  // placed in millimetres, beside the projector's picture
    auto& plane = std::get<PlanarSurface>(surface.geometry);
    plane.frame_from_surface.translation = {4000, -300, 2100};
  }
  loop.projection.set_show(show);
  const Metrics metrics = loop.run(3, 1);
  EXPECT_EQ(metrics.dark, metrics.checked);
  EXPECT_EQ(metrics.checked, 1u);
  EXPECT_NE(loop.said.find("no light on any surface"), std::string::npos) << loop.said;
  EXPECT_NE(loop.said.find("millimetres"), std::string::npos) << loop.said;
  loop.said.clear();
  show = small_show();
  for (auto& content : show.contents) content = device::still_content(ImageU8(5, 5, 3));
  loop.projection.set_show(show);
  loop.run(3, 1);
  EXPECT_NE(loop.said.find("content is black"), std::string::npos) << loop.said;
}

/// Ends the loading of a show, as Ctrl-C does.
struct EndsLoading : ShowListener {
  struct Ended {};
  void on_load(int done, int) override {
    if (done == 1) throw Ended();
  }
  void on_frame(const ShowReport&) override { ADD_FAILURE() << "a frame was shown"; }
};

TEST(Run, IsEndedWhileItLoads) {
  test::Scratch folder;
  SurfaceSet set;
  for (int i = 0; i < 3; ++i) set.surfaces.push_back(pixel_area("sign " + std::to_string(i)));
  io::save_surfaces(folder / "surfaces.json", set);
  ShowOptions options;
  options.surfaces = (folder / "surfaces.json").string();
  options.output = "none";
  options.control = "off";
  options.duration_s = 60;
  EndsLoading listener;
  EXPECT_THROW(run(small_rig(), options, &listener), EndsLoading::Ended);
}

}  // namespace
}  // namespace procam::show
