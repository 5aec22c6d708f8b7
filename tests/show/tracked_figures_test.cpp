/// How well light stays on a cart that moves on its own: docs/tracked-surfaces-measured.md. A program of its own, since it takes minutes.
#include <gtest/gtest.h>

#include <cstdio>
#include <ctime>

#include "cart_world.hpp"
#include "watch/watched_world.hpp"

namespace procam::show {
namespace {

using test::CartConditions;
using test::CartRun;
using test::CartWorld;
using test::drawn;

/// The board faces the rig, 2.2 m ahead, turned by `yaw` about its vertical middle.
Pose board_at(const Vec3& middle, double yaw, const Vec3& tilt) {
  const Pose rig_from_middle(so3_exp(tilt) * so3_exp(Vec3(0, yaw, 0)), middle);
  return rig_from_middle * Pose(Eigen::Quaterniond::Identity(), Vec3(-0.3, -0.2, 0));
}

enum class Drive { kStanding, kStraight, kToAndFro, kTurn, kStops, kDoor };
const char* name_of(Drive drive) {
  static const char* const names[] = {"standing", "straight", "to and fro", "turn", "stops", "door"};
  return names[int(drive)];
}

/// From rest to rest, share of the way (simulate/drive.hpp).
double eased(double x) {
  x = std::clamp(x, 0.0, 1.0);
  return x * x * x * (10 - 15 * x + 6 * x * x);
}

double phase_of(std::uint64_t seed) {
  return 2 * M_PI * drawn(seed, 15);
}
/// A time at which the door of a seed is closed.
double door_closed_at(std::uint64_t seed) {
  return -phase_of(seed) / 1.2;
}

CartWorld::Path path_of(Drive drive, std::uint64_t seed) {
  const double side = drawn(seed, 11) < 0.5 ? -1 : 1, far = 2.1 + 0.3 * drawn(seed, 12),
               up = 0.1 * (drawn(seed, 13) - 0.5), yaw = 0.5 * (drawn(seed, 14) - 0.5),
               phase = phase_of(seed);
  const Vec3 tilt(0.1 * (drawn(seed, 16) - 0.5), 0, 0.1 * (drawn(seed, 17) - 0.5));
  return [=](double t) {
    Vec3 middle(0.1 * side, up, far);
    double turn = yaw;
    switch (drive) {
      case Drive::kStanding:
      case Drive::kDoor:
        break;
      case Drive::kStraight:  // 0.3 m/s, nearly along the wall
        middle += side * (t - 2.5) * 0.3 * Vec3(0.98, 0, 0.2);
        break;
      case Drive::kToAndFro:  // up to 0.3 m/s and 0.22 m/s^2
        middle += 0.4 * std::sin(0.75 * t + phase) * Vec3(0.97, 0, 0.25);
        break;
      case Drive::kTurn: {  // 0.3 m/s on an arc of 0.6 m: 0.5 rad/s, to and fro
        const double angle = 0.7 * std::sin(0.5 / 0.7 * t + phase);
        middle += 0.6 * Vec3(std::sin(angle), 0, 1 - std::cos(angle));
        turn += -angle;
        break;
      }
      case Drive::
          kStops: {  // from rest to rest: 0.4 m in 2.5 s, up to 0.3 m/s and 0.37 m/s^2; stands for a second
        const double cycle = t / 3.5, leg = std::floor(cycle), x = eased((cycle - leg) * 3.5 / 2.5);
        middle += side * (int(leg) % 2 == 0 ? x - 0.5 : 0.5 - x) * 0.4 * Vec3(0.97, 0, 0.25);
        break;
      }
    }
    const Pose place = board_at(middle, turn, tilt);
    if (drive != Drive::kDoor) return place;
    // About its left edge: up to 0.5 rad and 0.6 rad/s.
    return place * Pose(so3_exp(Vec3(0, 0.5 * std::sin(1.2 * t + phase), 0)), Vec3::Zero());
  };
}

/// That of a door whose closed place and axis are known exactly.
track::Hinge hinge_of_door(std::uint64_t seed) {
  track::Hinge hinge;
  hinge.rig_from_closed = path_of(Drive::kDoor, seed)(door_closed_at(seed));
  return hinge;
}

void print(const char* what, const std::vector<CartRun>& runs) {
  CartRun all;
  double noise2 = 0;
  std::uint64_t images = 0, sightings = 0, refused = 0;
  int wrong = 0, frames = 0, fresh = 0;
  double look = 0, worst = 0, predicted2 = 0;
  std::string why;
  for (const CartRun& run : runs) {
    all.errors_mm.insert(all.errors_mm.end(), run.errors_mm.begin(), run.errors_mm.end());
    worst = std::max(worst, run.rms());
    images += run.images, sightings += run.sightings, refused += run.refused;
    wrong += run.wrong, frames += run.frames, fresh += run.fresh, look += run.look_s;
    noise2 += run.noise_mm * run.noise_mm * double(run.sightings);
    predicted2 += run.predicted2;
    if (!run.why.empty()) why = run.why;
  }
  std::printf(
      "%-34s rms %5.2f mm (worst run %5.2f), p95 %5.2f, largest %5.2f; predicted %5.2f; fresh %.1f %%; %llu images, %llu "
      "sightings, %llu refused, %d wrong, noise %.2f mm; %.1f ms of the processor an image %s\n",
      what, all.rms(), worst, all.quantile(0.95), all.quantile(1),
      1e3 * std::sqrt(predicted2 / std::max(1, frames)), 100.0 * fresh / std::max(1, frames),
      (unsigned long long)images, (unsigned long long)sightings, (unsigned long long)refused, wrong,
      std::sqrt(noise2 / double(std::max<std::uint64_t>(1, sightings))), 1e3 * look / double(images),
      why.substr(0, 90).c_str());
  std::fflush(stdout);
}

ImageU8 film() {
  return watch::test::picture(watch::test::Content::kVideo, 0.5, 1);
}

int first_seed() {
  const char* text = std::getenv("CART_FIRST");
  return text != nullptr ? std::atoi(text) : 1;
}

std::vector<CartRun> runs_of(Drive drive, const CartConditions& conditions, int seeds, double seconds) {
  std::vector<CartRun> runs;
  for (int seed = first_seed(); seed < first_seed() + seeds; ++seed) {
    CartConditions of_seed = conditions;
    if (drive == Drive::kDoor && conditions.hinge) of_seed.hinge = hinge_of_door(std::uint64_t(seed));
    runs.push_back(
        CartWorld(of_seed, path_of(drive, std::uint64_t(seed)), std::uint64_t(seed)).run(seconds, film()));
  }
  return runs;
}

int seeds_asked() {
  const char* text = std::getenv("CART_SEEDS");
  return text != nullptr ? std::atoi(text) : 5;
}

/// Is it one of those asked for (CART_ONLY, part of the name)?
bool is_asked(const char* what) {
  const char* text = std::getenv("CART_ONLY");
  return text == nullptr || std::string(what).find(text) != std::string::npos;
}

TEST(TrackedFigures, CartAtThirtyCentimetresASecond) {
  CartConditions conditions;
  conditions.map = test::two_markers();
  for (const Drive drive :
       {Drive::kStanding, Drive::kStraight, Drive::kToAndFro, Drive::kTurn, Drive::kStops}) {
    if (!is_asked(name_of(drive))) continue;
    const std::vector<CartRun> runs = runs_of(drive, conditions, seeds_asked(), 6);
    print(name_of(drive), runs);
    for (const CartRun& run : runs) {
      EXPECT_LT(run.rms(), 5) << name_of(drive);
      EXPECT_EQ(run.wrong, 0) << name_of(drive);
    }
  }
}

TEST(TrackedFigures, LightOnTheMarkers) {
  for (const double ambient : {0.05, 0.01, 0.002})
    for (const int light : {-1, 0, 128, 255}) {
      CartConditions conditions;
      conditions.map = test::two_markers();
      conditions.ambient = ambient;
      conditions.marker_light = light;
      char what[80];
      std::snprintf(what, sizeof what, "to and fro, ambient %g, light %d", ambient, light);
      print(what, runs_of(Drive::kToAndFro, conditions, std::min(2, seeds_asked()), 5));
    }
}

TEST(TrackedFigures, Variants) {
  const auto look = [](const char* what, Drive drive, const auto& change) {
    if (!is_asked(what)) return;
    CartConditions conditions;
    conditions.map = test::two_markers();
    change(conditions);
    print(what, runs_of(drive, conditions, std::min(3, seeds_asked()), 5));
  };
  look("no prediction, to and fro", Drive::kToAndFro,
       [](CartConditions& c) { c.prediction = track::Prediction::kNone; });
  look("one marker of 120 mm, to and fro", Drive::kToAndFro,
       [](CartConditions& c) { c.map = test::one_marker(0.12); });
  look("one marker of 120 mm, turn", Drive::kTurn, [](CartConditions& c) { c.map = test::one_marker(0.12); });
  look("one marker of 60 mm, to and fro", Drive::kToAndFro,
       [](CartConditions& c) { c.map = test::one_marker(0.06); });
  for (const Drive drive : {Drive::kStanding, Drive::kStraight, Drive::kTurn})
    for (const int light : {-1, 200}) {
      const std::string what =
          std::string("one marker of 60 mm, ") + name_of(drive) + ", light " + std::to_string(light);
      look(what.c_str(), drive,
           [light](CartConditions& c) { c.map = test::one_marker(0.06), c.marker_light = light; });
    }
  look("one marker of 60 mm, to and fro, light 200", Drive::kToAndFro,
       [](CartConditions& c) { c.map = test::one_marker(0.06), c.marker_light = 200; });
  for (const double size : {0.06, 0.12})
    for (const bool is_hinged : {false, true}) {
      const std::string what =
          "door, one marker of " + std::to_string(int(1e3 * size)) + " mm" + (is_hinged ? ", hinge" : "");
      look(what.c_str(), Drive::kDoor, [=](CartConditions& c) {
        c.map = test::one_marker(size);
        if (is_hinged) c.hinge.emplace();
      });
    }
  look("rolling shutter of 20 ms, to and fro", Drive::kToAndFro, [](CartConditions& c) { c.readout = 0.02; });
  look("exposure of 16 ms, to and fro", Drive::kToAndFro, [](CartConditions& c) { c.exposure = 0.016; });
  look("covered for 0.4 s, to and fro", Drive::kToAndFro,
       [](CartConditions& c) { c.covered = [](double t) { return t > 2 && t < 2.4; }; });
}

/// In the dark, with and without a light that looks for the markers.
TEST(TrackedFigures, BeginInTheDark) {
  for (const double ambient : {0.01, 0.002, 0.0})
    for (const int light : {0, 30, 90, 200}) {
      CartConditions conditions;
      conditions.map = test::two_markers();
      conditions.ambient = ambient;
      conditions.search_light = light;
      char what[80];
      std::snprintf(what, sizeof what, "to and fro, ambient %g, search light %d", ambient, light);
      if (!is_asked(what)) continue;
      print(what, runs_of(Drive::kToAndFro, conditions, std::min(2, seeds_asked()), 5));
    }
}

/// Images of shows without any marker: how often is one seen, of any id?
TEST(TrackedFigures, MarkersThatAreNotThere) {
  watch::test::WatchedWorld world{watch::test::WorldOptions{}};
  std::vector<ImageU8> images;
  const int count = 60 * seeds_asked();
  for (int i = 0; i < count; ++i) images.push_back(world.image(world.frame(0.37 * i), 0.37 * i));
  for (const MarkerDictionary dictionary :
       {MarkerDictionary::kAprilTag36h11, MarkerDictionary::k6x6_250, MarkerDictionary::k4x4_50}) {
    const MarkerCells cells = detect::marker_cells(dictionary);
    int seen = 0;
    const std::clock_t begin = std::clock();
    for (const ImageU8& image : images) seen += int(detect::detect_marker_edges(image, cells).markers.size());
    std::printf("%s: %d markers in %d images without one, %.1f ms of the processor an image\n",
                info_of(dictionary).name, seen, count,
                1e3 * double(std::clock() - begin) / CLOCKS_PER_SEC / count);
    if (dictionary == MarkerDictionary::kAprilTag36h11) EXPECT_EQ(seen, 0);
  }
}

}  // namespace
}  // namespace procam::show
