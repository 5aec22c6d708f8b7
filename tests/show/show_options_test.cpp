/// A show from a file: what is written is read again, and a show runs by one call.
#include <gtest/gtest.h>

#include "io/scratch.hpp"
#include "live_world.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/surface_file.hpp"
#include "procam/show/run.hpp"
#include "support/json_schema.hpp"

namespace procam::show {
namespace {

ShowOptions everything() {
  ShowOptions o;
  o.projector = "lamp";
  o.surfaces = "depth:watch:somewhere";
  o.contents = {{"wall", "clip.mp4@25"}, {"floor", "#ff8000"}, {"door", "video:sub/clip.bin"}};
  o.marker = MarkerInput{};
  o.marker->camera = "0";
  o.marker->markers = "markers.json";
  o.pose = "pose.json";
  o.mount = "mount.json";
  o.frame = "map";
  o.child = "base";
  o.prediction = "twist";
  o.source_delay_s = 0.04;
  o.blank_on_stale_s = 0.25;
  o.display = "EPSON";
  o.output = "none";
  o.size = ImageSize{1280, 800};
  o.fps = 30;
  o.duration_s = 2.5;
  o.delay_s = 0.0351;
  o.camera_delay_s = 0.01;
  o.depth.camera = "depth";
  o.depth.metres_per_unit = 2e-4;
  o.depth.up = Vec3(0, -1, 0.1);
  o.depth.silhouettes = true;
  o.people = PeopleInput{};
  o.people->source = "udp:9100";
  o.people->sensor = "sensor.json";
  o.people->destinations = {"wall=udp:127.0.0.1:9101"};
  o.watch = WatchInput{};
  o.watch->camera = "camera:1";
  o.watch->name = "left";
  o.watch->delay_s = 0.03;
  o.watch->only = true;
  o.watch->marks = true;
  o.watch->save = "corrected.json";
  o.watch->pose_m = 0.03;
  o.watch->pose_rad = 0.01;
  o.watch->pose_time_s = 5;
  o.watch->markers = "wall_markers.json";
  o.track = TrackInput{};
  o.track->camera = "camera:2";
  o.track->name = "right";
  o.track->delay_s = 0.04;
  o.track->readout_s = 0.02;
  o.track->surfaces = {{"cart,sign", "apriltag_36h11:5:120mm"}, {"door", "door_markers.json"}};
  o.track->hinges = {{"door", "left"}};
  o.track->marker_light = 200;
  o.screens = {{"left", "1", ""}, {"right", std::nullopt, "shm:right"}};
  o.blend = BlendSettings{};
  o.blend->projectors = {"left", "right"};
  o.blend->black = {{"left", 0.001}, {"right", 0.0025}};
  o.blend->brightness = {{"left", 2200}};
  o.blend->compensate = 0.3;
  o.blend->one_level = true;
  o.group = "foyer";
  o.group_strength = 12;
  o.fleet = "hall";
  o.robot = "spot";
  o.fleet_priority = -3;
  o.fleet_blend = true;
  o.autosave = true;
  o.control = "off";
  o.token = "secret";
  o.threads = 3;
  o.bilinear = true;
  return o;
}

TEST(ShowOptions, TheSchemaDescribesExactlyWhatIsWritten) {
  test::Scratch folder;
  save_options(folder / "one.json", everything());
  ShowOptions other;
  other.surfaces = "depth:folder:seen";
  other.poses = {"udp:9000"};
  other.freeze_on_stale_s = 0.75;
  other.delay_camera = "1";
  other.depth.delay_s = 0.03;
  other.people.emplace();
  other.people->source = "udp:9100";
  other.people->sensor = "sensor.json";
  other.people->delay_s = 0.02;
  other.record = "run.log";
  other.publish = "ros2:/procam";
  other.dds_security = "enclaves/projector";
  other.group = "foyer";
  other.group_strength = -7;
  other.renderer = "gl";
  other.average_numbers = true;
  other.autosave = true;
  save_options(folder / "other.json", other);
  ShowOptions one_marker = everything();
  one_marker.marker->name = "left";
  one_marker.marker->markers.clear();
  one_marker.marker->marker = "apriltag_36h11:3:160mm";
  save_options(folder / "one_marker.json", one_marker);
  const test::json schema = test::schema_of("show");
  test::Validator validator(schema);
  for (const char* file : {"one.json", "other.json", "one_marker.json"})
    EXPECT_EQ(validator.disagreement(test::parse(folder / file)), "") << file;
  for (const std::string& field : validator.never_met()) ADD_FAILURE() << "never written: " << field;
}

TEST(ShowOptions, WhatIsWrittenIsReadAgain) {
  test::Scratch folder;
  save_options(folder / "show.json", everything());
  const ShowOptions read = load_options(folder / "show.json");
  save_options(folder / "again.json", read);  // its files are absolute, as the folder is
  save_options(folder / "third.json", load_options(folder / "again.json"));
  std::ifstream shown(folder / "show.json"), one(folder / "again.json"), two(folder / "third.json");
  const std::string written{std::istreambuf_iterator<char>(shown), {}};
  const std::string first{std::istreambuf_iterator<char>(one), {}},
      second{std::istreambuf_iterator<char>(two), {}};
  EXPECT_EQ(first, second);
  for (const char* field : {"projector",
                            "surfaces",
                            "contents",
                            "marker",
                            "pose",
                            "mount",
                            "frame",
                            "child",
                            "prediction",
                            "source_delay_s",
                            "blank_on_stale_s",
                            "display",
                            "output",
                            "fps",
                            "duration_s",
                            "delay_s",
                            "camera_delay_s",
                            "depth",
                            "people",
                            "autosave",
                            "control",
                            "token",
                            "threads",
                            "bilinear"})
    EXPECT_NE(written.find("\"" + std::string(field) + "\""), std::string::npos) << field;
  EXPECT_EQ(read.mount, std::filesystem::absolute("mount.json").string());
  EXPECT_EQ(read.blank_on_stale_s, 0.25);
  EXPECT_EQ(read.track->surfaces.at("cart,sign"), "apriltag_36h11:5:120mm");
  EXPECT_EQ(read.track->surfaces.at("door"), std::filesystem::absolute("door_markers.json").string());
  EXPECT_EQ(read.track->hinges.at("door"), "left");
  EXPECT_EQ(read.track->marker_light, 200);
  EXPECT_EQ(read.depth.up, Vec3(0, -1, 0.1));
  EXPECT_EQ(read.blend->black.at("right"), 0.0025);
  EXPECT_EQ(read.contents.at("floor"), "#ff8000");
  // Fields with their default are not written.
  ShowOptions plain;
  plain.surfaces = "surfaces.json";
  save_options(folder / "plain.json", plain);
  EXPECT_LT(std::filesystem::file_size(folder / "plain.json"), 130u);
}

TEST(ShowOptions, FilesAreRelativeToTheShowFile) {
  test::Scratch folder;
  folder.write("sub/show.json",
               R"({"format": "procam-show", "version": 1, "surfaces": "surfaces.json", "pose": "../pose.json",
 "contents": {"wall": "video:clip.bin@30", "floor": "camera:0", "door": "#00ff00"}})");
  const ShowOptions read = load_options(folder / "sub/show.json");
  EXPECT_EQ(read.surfaces, (folder / "sub/surfaces.json").string());
  EXPECT_EQ(read.pose, (folder / "pose.json").string());
  EXPECT_EQ(read.contents.at("wall"), "video:" + (folder / "sub/clip.bin@30").string());
  EXPECT_EQ(read.contents.at("floor"), "camera:0");
  EXPECT_EQ(read.contents.at("door"), "#00ff00");
}

TEST(ShowOptions, WhatIsWrongIsNamedWithItsLine) {
  test::Scratch folder;
  const auto load = [&](const std::string& rest) {
    folder.write("show.json",
                 "{\"format\": \"procam-show\", \"version\": 1,\n \"surfaces\": \"s.json\",\n " + rest + "}");
    return load_options(folder / "show.json");
  };
  EXPECT_ERROR(load("\"pose\": \"p.json\", \"suface\": 3"), kInput, "show.json:3");
  EXPECT_ERROR(load("\"pose\": \"p.json\", \"suface\": 3"), kInput, "surfaces");
  EXPECT_ERROR(load("\"fps\": -3"), kInput, "fps");
  EXPECT_ERROR(load("\"threads\": 1025"), kInput, "it is not from 0 to 1024");
  for (const char* field : {"source_delay_s", "delay_s", "camera_delay_s"})
    for (const char* value : {"-0.1", "10.1", "1e308"})
      EXPECT_ERROR(load("\"" + std::string(field) + "\": " + value), kInput,
                   std::string(field) + ": it is not from 0 to 10");
  for (const char* field : {"blank_on_stale_s", "freeze_on_stale_s", "duration_s"})
    for (const char* value : {"-0.1", "1e308"})
      EXPECT_ERROR(load("\"" + std::string(field) + "\": " + value), kInput,
                   std::string(field) + ": it is not from 0 to 1000000000");
  EXPECT_EQ(load("\"threads\": 1024, \"delay_s\": 10, \"duration_s\": 1e9").delay_s, 10);
  EXPECT_ERROR(load("\"renderer\": \"ray\""), kInput, "renderer");
  EXPECT_ERROR(load("\"people\": {\"source\": \"udp:1\"}"), kInput, "sensor");
  EXPECT_ERROR(load("\"marker\": {\"camera\": \"0\"}"), kInput, "marker");
  EXPECT_ERROR(load("\"blend\": {\"black\": {\"left\": 0.6}}"), kInput,
               "that of 'left' is not from 0 to 0.5");
  EXPECT_ERROR(load("\"blend\": {\"compensate\": 0.01}"), kInput, "it is not from 0.05 to 1");
  EXPECT_ERROR(load("\"blend\": {\"one_level\": true}"), kInput, "need it");
  EXPECT_ERROR(load_options(folder / "nothing.json"), kIo, "nothing.json");
}

struct Counting : ShowListener {
  void on_start(const std::string& sentence) override { started += sentence; }
  void on_event(const std::string& sentence) override { events += sentence; }
  void on_frame(const ShowReport& report) override {
    last = report.metrics.frames;
    if (ends_at > 0 && last >= ends_at) throw std::runtime_error("ended");
  }
  std::string started, events;
  std::uint64_t last = 0, ends_at = 0;
};

/// One call; recorded, shown again, and ended by its listener.
TEST(Run, ShowsRecordsAndShowsAgain) {
  test::Scratch folder;
  SurfaceSet set;
  set.surfaces = {pixel_area("sign")};
  io::save_surfaces(folder / "surfaces.json", set);
  io::save_image(folder / "sign.png", colourful(611, 470, 2));
  ShowOptions options;
  options.surfaces = (folder / "surfaces.json").string();
  options.output = "frames:" + (folder / "frames").string();
  options.fps = 100;
  options.duration_s = 0.3;
  options.control = "127.0.0.1:0";
  options.record = (folder / "run.log").string();
  Counting listener;
  const ShowReport report = run(small_rig(), options, &listener);
  EXPECT_GE(report.metrics.frames, 3u);
  EXPECT_EQ(listener.last, report.metrics.frames);
  EXPECT_NE(listener.started.find("control page: http://127.0.0.1:"), std::string::npos);
  EXPECT_EQ(listener.events, "");
  const ImageU8 frame = io::load_image(folder / "frames/frame_000000.png").image;
  EXPECT_NE(frame.at(70, 140, 0), 0) << "the sign is lit";
  options.output = "none";
  const ReplayReport again = replay(small_rig(), options, options.record, &listener);
  EXPECT_EQ(again.frames, report.metrics.frames);
  EXPECT_EQ(again.equal, again.frames);
  EXPECT_EQ(listener.events, "");
  // A log without a frame compares nothing.
  folder.write("empty.log", "");
  EXPECT_ERROR(replay(small_rig(), options, folder / "empty.log"), kInput, "is empty");
  folder.write("short.log", "{\"format\":\"procam-run\",\"version\":1,\"conditions\":\"none\"}\n");
  EXPECT_ERROR(replay(small_rig(), options, folder / "short.log"), kInput, "no frame");
  // Another filter: told, and frames that differ are counted.
  options.bilinear = true;
  EXPECT_LT(replay(small_rig(), options, options.record, &listener).equal, again.frames);
  EXPECT_NE(listener.events.find("other conditions"), std::string::npos);
  options.record.clear();
  options.duration_s = 60;
  listener.ends_at = 5;
  EXPECT_THROW(run(small_rig(), options, &listener), std::runtime_error);
  EXPECT_EQ(listener.last, 5u);
}

TEST(Run, RefusesWhatCannotBe) {
  ShowOptions options;
  EXPECT_ERROR(run(small_rig(), options), kInput, "surfaces");
  options.surfaces = "surfaces.json";
  options.watch.emplace().camera = "camera:0";
  options.watch->only = true;
  options.watch->save = "corrected.json";
  EXPECT_ERROR(run(small_rig(), options), kInput, "--watch-save");
  options.watch->only = false;
  options.watch->save = "no such folder/corrected.json";
  EXPECT_ERROR(run(small_rig(), options), kIo, "no such folder");
  options.watch.reset();
  options.surfaces = "depth:watch:nowhere";
  options.depth.silhouettes = true;
  options.record = "run.log";
  EXPECT_ERROR(run(small_rig(), options), kInput, "silhouettes");
  options.record.clear();
  options.surfaces = "surfaces.json";
  EXPECT_ERROR(run(small_rig(), options), kInput, "depth");
}

}  // namespace
}  // namespace procam::show
