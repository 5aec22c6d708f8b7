/// The figures of docs/watch-measured.md: long runs over contents and seeds. Every run prints a line.
///   PROCAM_WATCH_SEEDS=5 test_watch --gtest_filter='WatchFigures.*'
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <random>

#include "procam/watch/correction.hpp"
#include "watched_world.hpp"

namespace procam::watch {
namespace {

using test::Content;
using test::name_of;
using test::WatchedWorld;
using test::WorldOptions;

constexpr Content kTextured[] = {Content::kVideo, Content::kScroll, Content::kSlides, Content::kDarkGame};

int number_of(const char* variable, int usual) {
  const char* text = std::getenv(variable);
  return text != nullptr ? std::atoi(text) : usual;
}
/// All, or the one of PROCAM_WATCH_CONTENT.
std::vector<Content> contents() {
  const int one = number_of("PROCAM_WATCH_CONTENT", -1);
  if (one >= 0) return {Content(one)};
  return {std::begin(kTextured), std::end(kTextured)};
}
double cpu_s() {
  return double(std::clock()) / CLOCKS_PER_SEC;
}

struct LongRun {
  WorldOptions options;
  WatchedWorld world;
  Watch watch;
  double time = 0.013, watch_s = 0;
  int images = 0;
  bool prints = number_of("PROCAM_WATCH_PRINT", 0) != 0;

  explicit LongRun(const WorldOptions& given)
      : options(given), world(given), watch(world.rig().camera(), world.rig().projector()) {
    watch.place(world.surfaces());
  }
  WatchReport next() {
    const ImageU8 frame = world.frame(time), later = world.frame(time + 1 / 60.0);
    const ImageU8 image = world.image(options.late > 0 ? later : frame, time);
    const double begin = cpu_s();
    const WatchReport report = watch.add(time, {frame, later, 0, 1 / 60.0}, image);
    watch_s += cpu_s() - begin;
    ++images;
    time += 0.2;
    if (prints)
      std::printf("%6.2f,%s,%d,%d,%.3f,%.3f,%.3f,%.3f,%.3g,%.1f,%d,%.2f,%d\n", report.time,
                  to_string(report.state), report.textured, report.measured, report.median_shift.x(),
                  report.median_shift.y(), 1e3 * report.error, 1e3 * report.error_sigma, report.probability,
                  report.estimate ? report.estimate->chi2 : 0,
                  report.estimate ? report.estimate->degrees_of_freedom : 0,
                  report.estimate ? report.estimate->scatter : 0,
                  report.estimate ? report.estimate->rejected : 0);
    return report;
  }
};

WorldOptions world_of(Content content, int seed, bool corner, bool person) {
  WorldOptions options;
  options.content = content;
  options.seed = std::uint64_t(seed);
  options.person = person;
  if (corner) options.walls = test::corner();
  return options;
}

struct Tally {
  int runs = 0, found = 0, wrong = 0, inseparable = 0;

  void print() const {
    std::printf("bumps: %d runs, %d found, %d with a wrong cause, %d inseparable\n", runs, found, wrong,
                inseparable);
  }
};

/// A bump of 0.2 degrees or 2 mm in the direction of a seed, after some seconds.
void bump(const std::string& name, const WorldOptions& options, double seconds, bool turned,
          unsigned direction_seed, Tally& tally) {
  LongRun run(options);
  WatchReport report;
  while (run.time < seconds) report = run.next();
  const bool early = report.is_alarm;
  const double before = report.error;
  std::mt19937 random{direction_seed};
  std::normal_distribution<double> normal(0, 1);
  const Vec3 direction = Vec3(normal(random), normal(random), normal(random)).normalized();
  const Vec3 centre = run.world.rig().projector().rig_from_projector.translation;
  if (turned)
    run.world.projector_moved << 0.2 * kDegree * direction, -0.2 * kDegree * direction.cross(centre);
  else
    run.world.projector_moved << Vec3::Zero(), 0.002 * direction;
  const double bumped = run.time, error = true_error(run.watch, run.world, run.options);
  while (!report.is_alarm && run.time < bumped + 10) report = run.next();
  std::string causes;
  double after = error;
  if (report.is_alarm) {
    ++tally.found;
    const auto plausible = report.estimate->plausible();
    for (const Explanation* one : plausible) causes += (causes.empty() ? "" : "|") + one->name;
    tally.inseparable += plausible.size() > 1;
    bool named = false;
    for (const Explanation* one : plausible) named = named || one->thing == MovedThing::kProjector;
    tally.wrong += !named;
    for (const Explanation& one : report.estimate->explanations)
      if (one.thing == MovedThing::kProjector) {
        RigProjector corrected = run.watch.projector();
        corrected.rig_from_projector = se3_exp(one.moved) * corrected.rig_from_projector;
        run.watch.correct(corrected);
        after = true_error(run.watch, run.world, run.options);
      }
  }
  ++tally.runs;
  std::printf(
      "bump,%s,%d,%s,%s,early %d,%.2f mm before,%.2f mm true,%.2f +- %.2f estimated,%.1f s,%s,%.2f mm after,%.1f ms\n",
      name.c_str(), int(options.seed), options.walls.size() > 1 ? "corner" : "wall",
      turned ? "0.2 deg" : "2 mm", early, 1e3 * before, 1e3 * error, 1e3 * report.error,
      1e3 * report.error_sigma, report.is_alarm ? run.time - bumped : -1, causes.c_str(), 1e3 * after,
      1e3 * run.watch_s / run.images);
  std::fflush(stdout);
}

TEST(WatchFigures, Bumps) {
  const int seeds = number_of("PROCAM_WATCH_SEEDS", 5), first = number_of("PROCAM_WATCH_FIRST", 0);
  Tally tally;
  for (const Content content : contents())
    for (int seed = first; seed < first + seeds; ++seed)
      for (const bool turned : {true, false})
        bump(name_of(content), world_of(content, seed, seed % 2 == 1, true), 4.5, turned,
             unsigned(100 * seed + 10 * int(content) + turned), tally);
  tally.print();
}

/// The same with marks, before plain colours and the dark game.
TEST(WatchFigures, MarkedBumps) {
  const int seeds = number_of("PROCAM_WATCH_SEEDS", 3), first = number_of("PROCAM_WATCH_FIRST", 0);
  const std::array<int, 3> colours[] = {{255, 255, 255}, {128, 128, 128}, {40, 90, 170}, {4, 4, 4}};
  Tally tally;
  for (int seed = first; seed < first + seeds; ++seed)
    for (const bool turned : {true, false}) {
      const auto run = [&](Content content, const std::array<int, 3>& colour) {
        WorldOptions options = world_of(content, seed + 1, seed % 2 == 1, true);
        options.plain = colour;
        options.marks = true;
        const std::string name =
            content == Content::kPlain ? "green " + std::to_string(colour[1]) : "dark game";
        bump(name, options, 6.5, turned, unsigned(100 * seed + 10 * colour[1] + turned), tally);
      };
      for (const auto& colour : colours) run(Content::kPlain, colour);
      run(Content::kDarkGame, {0, 0, 0});
    }
  tally.print();
}

/// A line for each image, for the picture of docs/watch.md: two bumps, each corrected six seconds after its alarm began.
TEST(WatchFigures, Timeline) {
  LongRun run(world_of(Content::kVideo, 6, false, true));
  const double bumps[] = {12, 32};
  double alarm = -1;
  std::printf("time,true_mm,error_mm,sigma_mm,state\n");
  while (run.time < 50) {
    if (std::abs(run.time - 0.013 - bumps[0]) < 0.05)
      run.world.projector_moved << 0.0012, 0.0031, 0.0008, 0, 0, 0;
    if (std::abs(run.time - 0.013 - bumps[1]) < 0.05)
      run.world.projector_moved.tail<3>() += Vec3(0.0015, -0.0012, 0.0005);
    const WatchReport report = run.next();
    std::printf("%.2f,%.3f,%.3f,%.3f,%s\n", report.time, 1e3 * true_error(run.watch, run.world, run.options),
                1e3 * report.error, 1e3 * report.error_sigma, to_string(report.state));
    if (!report.is_alarm) alarm = -1;
    if (report.is_alarm && alarm < 0) alarm = report.time;
    if (alarm < 0 || report.time < alarm + 6) continue;
    for (const Explanation& one : report.estimate->explanations)
      if (one.thing == MovedThing::kProjector) {
        RigProjector corrected = run.watch.projector();
        corrected.rig_from_projector = (se3_exp(one.moved) * corrected.rig_from_projector).normalized();
        run.watch.correct(corrected);
        run.world.believed_rig_from_projector = corrected.rig_from_projector;
      }
    alarm = -1;
  }
}

/// A lamp warms up: the projector rotates by PROCAM_WATCH_DRIFT thousandths of a pixel a minute (1000), and what is found is
/// corrected, of a rig that stands still. How far is the light off at worst?
TEST(WatchFigures, Drift) {
  const int seeds = number_of("PROCAM_WATCH_SEEDS", 3), first = number_of("PROCAM_WATCH_FIRST", 0);
  const double rate = 1e-3 * number_of("PROCAM_WATCH_DRIFT", 1000) / 1490 / 60;  // radians a second
  for (const Content content : contents())
    for (int seed = first; seed < first + seeds; ++seed) {
      LongRun run(world_of(content, seed, seed % 2 == 1, true));
      CorrectionOptions allowed;
      allowed.surfaces = true;
      int corrections = 0, of_surfaces = 0, alarms = 0, not_drift = 0;
      double worst = 0, stepped = 0;
      while (run.time < number_of("PROCAM_WATCH_SECONDS", 90)) {
        if (run.time - stepped > 4) {
          run.world.projector_moved.head<3>() += (run.time - stepped) * rate * Vec3(0.6, -0.8, 0);
          stepped = run.time;
        }
        const WatchReport report = run.next();
        worst = std::max(worst, true_error(run.watch, run.world, run.options));
        alarms += report.is_alarm, not_drift += report.is_alarm && !report.is_drift;
        const Correction correction = correction_of(report, run.watch.projector(), allowed);
        if (!correction.is_possible()) continue;
        ++corrections;
        if (!correction.surface.empty()) {
          ++of_surfaces;
          run.watch.correct(correction.surface, correction.moved);
          continue;
        }
        run.watch.correct(correction.projector, correction.covariance);
        run.world.believed_rig_from_projector = correction.projector.rig_from_projector;
      }
      std::printf(
          "drift,%s,%d,%s,%.1f s,%d corrections,%d of surfaces,%d alarm images,%d of them no drift,worst %.2f mm\n",
          name_of(content), seed, seed % 2 == 1 ? "corner" : "wall", run.time, corrections, of_surfaces,
          alarms, not_drift, 1e3 * worst);
      std::fflush(stdout);
    }
}

/// Nothing moves: probabilities of windows.
TEST(WatchFigures, Still) {
  const int seeds = number_of("PROCAM_WATCH_SEEDS", 5), first = number_of("PROCAM_WATCH_FIRST", 0);
  const double seconds = number_of("PROCAM_WATCH_SECONDS", 60);
  for (const Content content : contents())
    for (int seed = first; seed < first + seeds; ++seed) {
      LongRun run(world_of(content, seed, seed % 2 == 1, true));
      int windows = 0, below[4] = {0, 0, 0, 0}, alarms = 0;
      double last = 0, chi2 = 0, worst = 0, error = 0;
      int degrees = 0;
      while (run.time < seconds) {
        const WatchReport report = run.next();
        alarms += report.is_alarm;
        if (!(report.window_time > last)) continue;
        last = report.window_time;
        ++windows;
        chi2 += report.estimate->chi2;
        degrees += report.estimate->degrees_of_freedom;
        worst = std::max(worst, report.error);
        error += report.error;
        const double limits[4] = {0.1, 0.01, 1e-3, 1e-4};
        for (int k = 0; k < 4; ++k) below[k] += report.probability < limits[k];
      }
      std::printf(
          "still,%s,%d,%s,%d windows,chi2/dof %.2f,p<0.1 %d,<0.01 %d,<0.001 %d,<0.0001 %d,alarm images %d,mean %.2f worst %.2f mm,%.1f ms\n",
          name_of(content), seed, seed % 2 == 1 ? "corner" : "wall", windows,
          degrees > 0 ? chi2 / degrees : 0, below[0], below[1], below[2], below[3], alarms,
          windows > 0 ? 1e3 * error / windows : 0, 1e3 * worst, 1e3 * run.watch_s / run.images);
      std::fflush(stdout);
    }
}

}  // namespace
}  // namespace procam::watch
