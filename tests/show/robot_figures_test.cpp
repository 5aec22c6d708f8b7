/// How well light stays on known walls while a localiser's pose is wrong: docs/watch.md. It takes minutes.
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <ctime>

#include "robot_world.hpp"

namespace procam::show {
namespace {

using test::RobotConditions;
using test::RobotRun;
using test::RobotWorld;
using watch::test::Content;

double number_of(const char* variable, double usual) {
  const char* text = std::getenv(variable);
  return text != nullptr ? std::atof(text) : usual;
}

/// The runs of the seeds together, with a line for people.
RobotRun runs_of(const char* what, RobotConditions conditions) {
  RobotRun all;
  double worst = 0;
  const double cpu = double(std::clock()) / CLOCKS_PER_SEC;
  conditions.camera_rate = number_of("ROBOT_CAMERA_RATE", conditions.camera_rate);
  conditions.odometry = number_of("ROBOT_ODOMETRY", 0) > 0;
  conditions.correlation = number_of("ROBOT_CORRELATION", conditions.correlation);
  const int first = int(number_of("ROBOT_FIRST", 1));
  for (int seed = first; seed < first + int(number_of("ROBOT_SEEDS", 5)); ++seed) {
    conditions.seed = std::uint64_t(seed);
    const RobotRun run = RobotWorld(conditions).run(number_of("ROBOT_SECONDS", 12));
    if (number_of("ROBOT_PRINT", 0) > 0)
      for (std::size_t i = 0; i < run.time.size(); ++i)
        std::printf("%d,%.3f,%.2f,%.2f\n", seed, run.time[i], run.without_mm[i], run.with_mm[i]);
    all.with_mm.insert(all.with_mm.end(), run.with_mm.begin(), run.with_mm.end());
    all.without_mm.insert(all.without_mm.end(), run.without_mm.begin(), run.without_mm.end());
    all.taken += run.taken, all.refused += run.refused, all.markers += run.markers;
    worst = std::max(worst, RobotRun::rms(run.with_mm));
  }
  std::vector<double> sorted = all.with_mm;
  std::sort(sorted.begin(), sorted.end());
  std::printf(
      "%-40s with %5.2f mm rms (worst run %5.2f, p95 %5.2f, largest %5.2f), without %5.2f; %llu sights, %llu refused, "
      "%llu images with markers; %.0f s\n",
      what, RobotRun::rms(all.with_mm), worst, sorted[sorted.size() * 95 / 100], sorted.back(),
      RobotRun::rms(all.without_mm), (unsigned long long)all.taken, (unsigned long long)all.refused,
      (unsigned long long)all.markers, double(std::clock()) / CLOCKS_PER_SEC - cpu);
  std::fflush(stdout);
  return all;
}

RobotConditions conditions_of(bool corner, bool markers, Content content, bool drives) {
  RobotConditions conditions;
  if (corner) conditions.walls = test::corner_walls();
  conditions.markers = markers;
  conditions.content = content;
  if (drives) conditions.speed = 0.5, conditions.turn = 30 * kDegree;
  return conditions;
}

TEST(RobotFigures, StandingBeforeACornerSlides) {
  runs_of("corner, slides, standing", conditions_of(true, false, Content::kSlides, false));
}
TEST(RobotFigures, StandingBeforeACornerFilm) {
  runs_of("corner, film, standing", conditions_of(true, false, Content::kVideo, false));
}
TEST(RobotFigures, DrivingBeforeACornerSlides) {
  runs_of("corner, slides, driving", conditions_of(true, false, Content::kSlides, true));
}
TEST(RobotFigures, DrivingBeforeACornerFilm) {
  runs_of("corner, film, driving", conditions_of(true, false, Content::kVideo, true));
}
TEST(RobotFigures, StandingBeforeAWallSlides) {
  runs_of("wall, slides, standing", conditions_of(false, false, Content::kSlides, false));
}
TEST(RobotFigures, StandingBeforeAWallFilm) {
  runs_of("wall, film, standing", conditions_of(false, false, Content::kVideo, false));
}
TEST(RobotFigures, DrivingBeforeAWallSlides) {
  runs_of("wall, slides, driving", conditions_of(false, false, Content::kSlides, true));
}
TEST(RobotFigures, DrivingBeforeAWallFilm) {
  runs_of("wall, film, driving", conditions_of(false, false, Content::kVideo, true));
}
TEST(RobotFigures, StandingBeforeAMarkedWallSlides) {
  runs_of("marked wall, slides, standing", conditions_of(false, true, Content::kSlides, false));
}
TEST(RobotFigures, StandingBeforeAMarkedWallFilm) {
  runs_of("marked wall, film, standing", conditions_of(false, true, Content::kVideo, false));
}
TEST(RobotFigures, DrivingBeforeAMarkedWallSlides) {
  runs_of("marked wall, slides, driving", conditions_of(false, true, Content::kSlides, true));
}
TEST(RobotFigures, DrivingBeforeAMarkedWallFilm) {
  runs_of("marked wall, film, driving", conditions_of(false, true, Content::kVideo, true));
}

}  // namespace
}  // namespace procam::show
