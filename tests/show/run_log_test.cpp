/// A run's log on a long evening: bounded, in parts, and on a disk that is full.
#include "run_log.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "io/scratch.hpp"
#include "live_world.hpp"
#include "procam/core/base/limits.hpp"
#include "procam/core/geometry/se3.hpp"
#include "procam/dds/pose_source.hpp"
#include "procam/track/wire.hpp"
#include "support/expect_error.hpp"
#include "support/file_size_limit.hpp"

namespace procam::show {
namespace {

namespace fs = std::filesystem;

struct ReadRun {
  std::vector<long long> frames;
  int surfaces = 0, pictures = 0;
  std::vector<MissingParts> missing;
};

ReadRun read_all(const fs::path& log) {
  ReadRun run;
  RunReader reader(log);
  while (const std::optional<RunRecord> record = reader.next()) {
    if (const auto* frame = std::get_if<RecordedFrame>(&*record)) run.frames.push_back(frame->number);
    if (const auto* parts = std::get_if<MissingParts>(&*record)) run.missing.push_back(*parts);
    run.surfaces += std::holds_alternative<SurfaceSet>(*record) ? 1 : 0;
    run.pictures += std::holds_alternative<TestPattern>(*record) ? 1 : 0;
  }
  return run;
}

/// A hundred bytes a frame, more or less, and 2 KB of surfaces at the begin of each part.
void record_frames(RunRecorder& recorder, int begin, int end) {
  for (int i = begin; i < end; ++i) recorder.record(RecordedFrame{i, 100 + i / 60.0, i / 60.0, 7});
}

TEST(RunParts, ALogInPartsIsReadAsOne) {
  test::Scratch folder;
  {
    RunRecorder recorder(folder / "run.log", "now", {10000, 4});
    recorder.record(small_show().surfaces);
    recorder.record(TestPattern::kContent);
    record_frames(recorder, 0, 150);
    recorder.record(TestPattern::kGrid);
    record_frames(recorder, 150, 250);
  }
  ASSERT_TRUE(fs::exists(folder / "run.log.1"));
  const ReadRun run = read_all(folder / "run.log");
  EXPECT_EQ(run.frames.size(), 250u);
  for (std::size_t i = 0; i < run.frames.size(); ++i) EXPECT_EQ(run.frames[i], (long long)i);
  EXPECT_TRUE(run.missing.empty());
  EXPECT_EQ(run.surfaces, 1) << "what a part repeats is not read twice";
  EXPECT_EQ(run.pictures, 2);
}

/// What a replay needs to draw the same frames: the pose as it was, to the last bit, also in a later part.
TEST(RunParts, AMovedProjectorIsReadAsItWasWritten) {
  test::Scratch folder;
  const Pose pose = (se3_exp(Vec6((Vec6() << 0.1, -0.7, 0.2, 1.0 / 3, -0.1, 2.7).finished()))).normalized();
  {
    RunRecorder recorder(folder / "run.log", "now", {10000, 4});
    recorder.record(small_show().surfaces);
    recorder.record(TestPattern::kContent);
    recorder.record(MovedProjector{pose});
    record_frames(recorder, 0, 150);
  }
  ASSERT_TRUE(fs::exists(folder / "run.log.1"));
  int moved = 0;
  RunReader reader(folder / "run.log");
  while (const std::optional<RunRecord> record = reader.next())
    if (const auto* one = std::get_if<MovedProjector>(&*record)) {
      ++moved;
      EXPECT_TRUE(one->rig_from_projector.rotation.coeffs() == pose.rotation.coeffs());
      EXPECT_TRUE(one->rig_from_projector.translation == pose.translation);
    }
  EXPECT_GE(moved, 2) << "each part begins with it";
  for (const char* line : {"{\"projector\":[1,0,0,0,0,0]}", "{\"projector\":[2,0,0,0,0,0,0]}",
                           "{\"projector\":[nan,0,0,0,0,0,0]}", "{\"projector\":[1,0,0,0,0,0,inf]}"}) {
    std::ofstream(folder / "bad.log") << "{\"format\":\"procam-run\",\"version\":1,\"conditions\":\"x\"}\n"
                                      << line << "\n";
    RunReader bad(folder / "bad.log");
    bad.next();
    EXPECT_ERROR(bad.next(), kInput, "line 2");
  }
}

track::StampedPose some_message(double arrival) {
  track::StampedPose message;
  message.stamp = 1.7e9 + arrival / 3;
  message.arrival = arrival;
  message.frame = "map";
  message.child = "base";
  message.frame_from_child =
      se3_exp(Vec6((Vec6() << 0.1, -0.7, 0.2, arrival / 3, -0.1, 2.7).finished())).normalized();
  message.covariance = Mat6(Vec6(1e-4, 2e-4, 3e-4, 4e-4, 5e-4, 6e-4).asDiagonal());
  return message;
}

/// As messages of ROS 2: shown again from the same records, and its poses are a source, both to the last digit.
TEST(RunMcap, HoldsWhatALogHoldsAndItsPosesAreASource) {
  if (!dds::is_available()) GTEST_SKIP() << "built without DDS";
  test::Scratch folder;
  for (const char* name : {"run.log", "run.mcap"}) {
    RunRecorder recorder(folder / name, "now", {4000000, 4});
    recorder.record(small_show().surfaces);
    recorder.record(TestPattern::kGrid);
    for (int i = 0; i < 300; ++i) {
      recorder.record(some_message(100 + i / 30.0));
      recorder.record(RecordedFrame{i, 100.02 + i / 30.0, i / 30.0, 7});
    }
  }
  RunReader log(folder / "run.log"), mcap(folder / "run.mcap");
  int poses = 0, frames = 0;
  for (;;) {
    const std::optional<RunRecord> expected = log.next(), found = mcap.next();
    ASSERT_EQ(expected.has_value(), found.has_value());
    if (!expected) break;
    ASSERT_EQ(expected->index(), found->index());
    if (const auto* frame = std::get_if<RecordedFrame>(&*found)) {
      EXPECT_EQ(frame->light_time, std::get<RecordedFrame>(*expected).light_time);
      ++frames;
    }
    if (const auto* pose = std::get_if<track::StampedPose>(&*found)) {
      EXPECT_EQ(track::to_json_line(*pose), track::to_json_line(std::get<track::StampedPose>(*expected)));
      EXPECT_EQ(pose->arrival, std::get<track::StampedPose>(*expected).arrival);
      ++poses;
    }
  }
  EXPECT_EQ(poses, 300);
  EXPECT_EQ(frames, 300);

  std::vector<track::StampedPose> from_lines, from_odometry;
  const std::string source = "log:" + (folder / "run.mcap").string();
  dds::open_pose_source(source + "@0")->poll(from_lines);
  dds::open_pose_source(source + "+/procam/poses@0")->poll(from_odometry);
  ASSERT_EQ(from_lines.size(), 300u);
  ASSERT_EQ(from_odometry.size(), 300u);
  const track::StampedPose truth = some_message(100 + 7 / 30.0);
  EXPECT_EQ(track::to_json_line(from_lines[7]), track::to_json_line(truth));
  EXPECT_NEAR(from_lines[7].arrival - from_lines[0].arrival, 7 / 30.0, 1e-6);
  const track::StampedPose& other = from_odometry[7];
  EXPECT_EQ(other.frame + " " + other.child, "map base");
  EXPECT_NEAR(*other.stamp, *truth.stamp, 1e-6);
  EXPECT_LT((other.frame_from_child.matrix() - truth.frame_from_child.matrix()).cwiseAbs().maxCoeff(), 1e-12);
  ASSERT_TRUE(other.covariance);
  EXPECT_LT((*other.covariance - *truth.covariance).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_FALSE(other.twist) << "an unknown twist is not a standstill";
}

TEST(RunMcap, InPartsAndOfAKilledShow) {
  if (!dds::is_available()) GTEST_SKIP() << "built without DDS";
  test::Scratch folder;
  {
    RunRecorder recorder(folder / "run.mcap", "now", {10000, 4});
    recorder.record(small_show().surfaces);
    recorder.record(TestPattern::kContent);
    record_frames(recorder, 0, 250);
  }
  ASSERT_TRUE(fs::exists(folder / "run.mcap.1"));
  EXPECT_EQ(read_all(folder / "run.mcap").frames.size(), 250u);
  // Killed: what was flushed each second is there, the end is not.
  RunRecorder recorder(folder / "killed.mcap", "now");
  recorder.record(small_show().surfaces);
  record_frames(recorder, 0, 300);
  fs::copy_file(folder / "killed.mcap", folder / "copy.mcap");
  EXPECT_GE(read_all(folder / "copy.mcap").frames.size(), 230u);
}

TEST(RunParts, TheLogIsBoundedAndTheNewestStays) {
  test::Scratch folder;
  {
    RunRecorder recorder(folder / "run.log", "now", {10000, 3});
    recorder.record(small_show().surfaces);
    recorder.record(TestPattern::kMask);
    record_frames(recorder, 0, 2000);
  }
  EXPECT_FALSE(fs::exists(folder / "run.log.3"));
  std::uintmax_t bytes = 0;
  for (const auto& entry : fs::directory_iterator(folder / "")) bytes += entry.file_size();
  EXPECT_LT(bytes, 3 * 10200u);
  const ReadRun run = read_all(folder / "run.log");
  ASSERT_EQ(run.missing.size(), 1u);
  EXPECT_EQ(run.missing[0].first, 1);
  EXPECT_GT(run.missing[0].last, 10);
  EXPECT_EQ(run.surfaces, 1);
  EXPECT_EQ(run.pictures, 1);
  ASSERT_GT(run.frames.size(), 100u);
  EXPECT_EQ(run.frames.back(), 1999);
  EXPECT_EQ(run.frames.back() - run.frames.front() + 1, (long long)run.frames.size());

  // The next run of this name does not continue the old one.
  { RunRecorder recorder(folder / "run.log", "then"); }
  EXPECT_FALSE(fs::exists(folder / "run.log.1"));
  EXPECT_TRUE(read_all(folder / "run.log").frames.empty());
}

TEST(RunParts, AMissingPartIsNamed) {
  test::Scratch folder;
  {
    RunRecorder recorder(folder / "run.log", "now", {10000, 8});
    recorder.record(small_show().surfaces);
    recorder.record(TestPattern::kContent);
    record_frames(recorder, 0, 400);
  }
  // One in the middle is lost, and the older ones are renamed.
  ASSERT_TRUE(fs::exists(folder / "run.log.3"));
  for (int age = 3; fs::exists(folder / ("run.log." + std::to_string(age))); ++age)
    fs::rename(folder / ("run.log." + std::to_string(age)), folder / ("run.log." + std::to_string(age - 1)));
  const ReadRun run = read_all(folder / "run.log");
  ASSERT_EQ(run.missing.size(), 1u);
  EXPECT_EQ(run.missing[0].first, run.missing[0].last);
  EXPECT_LT(run.frames.size(), 400u);
}

/// kill -9 in the middle of a change of parts.
TEST(RunParts, AChangeOfPartsThatWasCutEndsTheLog) {
  test::Scratch folder;
  {
    RunRecorder recorder(folder / "run.log", "now", {10000, 8});
    recorder.record(small_show().surfaces);
    recorder.record(TestPattern::kContent);
    record_frames(recorder, 0, 100);
  }
  ASSERT_TRUE(fs::exists(folder / "run.log.1"));
  const std::size_t all = read_all(folder / "run.log").frames.size();
  fs::resize_file(folder / "run.log", 20);
  const std::size_t without_newest = read_all(folder / "run.log").frames.size();
  EXPECT_GT(without_newest, 50u);
  EXPECT_LT(without_newest, all);
  fs::remove(folder / "run.log");
  EXPECT_EQ(read_all(folder / "run.log").frames.size(), without_newest);
}

TEST(RunParts, AFullDiskIsAnErrorAndWhatWasWrittenIsALog) {
  test::Scratch folder;
  {
    RunRecorder recorder(folder / "run.log", "now");
    recorder.record(small_show().surfaces);
    recorder.record(TestPattern::kContent);
    {
      const test::FileSizeLimit limit(20000);
      EXPECT_ERROR(record_frames(recorder, 0, 1000), kIo, "run.log");
    }
    // There is room again: a log with a hole would be no log.
    EXPECT_ERROR(record_frames(recorder, 1000, 1100), kIo, "run.log");
  }
  EXPECT_GT(read_all(folder / "run.log").frames.size(), 100u);
}

TEST(RunParts, AnEmptyLogAndAnEndlessLineAreErrors) {
  test::Scratch folder;
  folder.write("empty.log", "");
  EXPECT_ERROR(read_all(folder / "empty.log"), kInput, "is empty");
  folder.write("cut.log", "{\"format\":\"procam-run\",");
  EXPECT_ERROR(read_all(folder / "cut.log"), kInput, "ends in its first line");
  const std::string header = "{\"format\":\"procam-run\",\"version\":1,\"conditions\":\"\"}\n";
  const auto endless = folder.write("endless.log", header);
  std::filesystem::resize_file(endless, header.size() + limits::kLogLineBytes);
  EXPECT_EQ(read_all(endless).frames.size(), 0u) << "a line that was cut";
  std::filesystem::resize_file(endless, header.size() + limits::kLogLineBytes + 1);
  EXPECT_ERROR(read_all(endless), kInput, "line 2: it is longer than 64 MiB");
  EXPECT_ERROR(read_all("/dev/zero"), kIo, "a device");
  EXPECT_ERROR(read_all(folder / "."), kIo, "a folder");
}

}  // namespace
}  // namespace procam::show
