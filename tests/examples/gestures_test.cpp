// Repetitions and raised hands, on real recordings.
#include "exercise/gestures.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <sstream>

#include "procam/people/people.hpp"
#include "procam/people/skeleton_reader.hpp"
#include "support/test_data.hpp"

namespace exercise {
namespace {

using namespace procam;
using namespace procam::people;

TEST(Exercise, CountsATremblingArmOnce) {
  ExerciseCounter counter;
  for (const double deg : {85.0, 90.0, 20.0, 60.0, 79.0, 81.0, 79.0, 82.0, 50.0, 81.0, 30.0, 85.0})
    counter.update(deg * kDegree);
  // The first was never at rest; the third time above 80 came without a rest.
  EXPECT_EQ(counter.count(), 2);
  counter.update(std::nullopt);
  EXPECT_NEAR(counter.best(), 85 * kDegree, 1e-12);
}

/// An arm is raised sideways again and again. The frontal angle rises from 18..30 degrees to 93..113 and
/// back: ten times by the left arm, ten by the right, once in the third log, whose later bump ends at 42
/// degrees. The other arm stays below 40 throughout.
TEST(Rehab, RepetitionsAreCountedThroughTheTracker) {
  const struct {
    const char* file;
    Side side;
    std::size_t frames;
    int repetitions;
  } logs[] = {{"rehab_abduction_left.csv", Side::kLeft, 509, 10},
              {"rehab_abduction_right.csv", Side::kRight, 515, 10},
              {"rehab_skeletonplayer.csv", Side::kRight, 146, 1}};
  for (const auto& log : logs) {
    PROCAM_REQUIRE_TEST_DATA(std::filesystem::path("skeleton") / log.file);
    const auto file = test::test_data() / "skeleton" / log.file;
    const std::vector<SkeletonFrame> frames = read_skeleton_log(file);
    ASSERT_EQ(frames.size(), log.frames) << log.file;
    PeopleTrack track;
    ExerciseCounter exercised, other;
    for (const SkeletonFrame& frame : frames) {
      ASSERT_EQ(frame.people.size(), 1u);
      EXPECT_FALSE(frame.people[0][Joint::kLeftFoot]) << "stale in every frame";
      track.add(frame);
      const std::vector<TrackedPerson> people = track.at(*frame.stamp);
      ASSERT_EQ(people.size(), 1u);
      EXPECT_EQ(people[0].number, 1);
      for (const auto& seen : people[0].skeleton.joints) ASSERT_TRUE(!seen || seen->position.allFinite());
      exercised.update(abduction_angle(people[0].skeleton, log.side));
      other.update(abduction_angle(people[0].skeleton, log.side == Side::kLeft ? Side::kRight : Side::kLeft));
    }
    EXPECT_EQ(exercised.count(), log.repetitions) << log.file;
    EXPECT_EQ(other.count(), 0) << log.file;
    EXPECT_GT(exercised.best(), 85 * kDegree);
    EXPECT_EQ(track.faults().refused, 0u);
    RecordProperty(std::string(log.file) + " repeated", int(track.faults().repeated));
    RecordProperty(std::string(log.file) + " teleports", int(track.faults().teleports));
  }
}

TEST(OpenPose, GesturesAreToldApart) {
  PROCAM_REQUIRE_TEST_DATA("skeleton/openpose_body25_gestures.csv");
  // Each row becomes the JSON that OpenPose writes, and is read as such.
  std::ifstream in(test::test_data() / "skeleton/openpose_body25_gestures.csv");
  std::string line, cell;
  std::getline(in, line);
  std::map<std::string, std::vector<PixelSkeleton>> recordings;
  while (std::getline(in, line)) {
    std::istringstream cells(line);
    std::string gesture, instance;
    std::getline(cells, gesture, ',');
    std::getline(cells, instance, ',');
    std::getline(cells, cell, ',');
    std::string json = R"({"version":1.3,"people":[{"person_id":[-1],"pose_keypoints_2d":[)";
    for (int i = 0; i < 25; ++i) {
      json += i == 0 ? "" : ",";
      for (int axis = 0; axis < 2; ++axis) {
        std::getline(cells, cell, ',');
        json += cell + ",";
      }
      json += "0.8";
    }
    const PixelPeople read = parse_openpose(json + "]}]}");
    ASSERT_EQ(read.people.size(), 1u) << read.why;
    recordings[gesture + instance].push_back(read.people[0]);
  }
  ASSERT_EQ(recordings.size(), 8u);
  for (const auto& [name, frames] : recordings) {
    EXPECT_EQ(frames.size(), 92u);
    const RaisedHand right = read_hand(frames, Side::kRight), left = read_hand(frames, Side::kLeft);
    EXPECT_EQ(left.sign, HandSign::kNone) << name;  // everybody used the right
    EXPECT_EQ(right.sign, name[0] == 'h' ? HandSign::kWave : HandSign::kStill)
        << name << " sway " << right.sway;
    RecordProperty(name, std::to_string(right.sway));
  }
}

}  // namespace
}  // namespace exercise
