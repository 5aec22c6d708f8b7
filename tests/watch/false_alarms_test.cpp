/// How often a window of the watch is beyond a limit although nothing moves: many installations, each with errors as large
/// as MovementOptions states them. A camera of a few milliseconds an image, so that thousands of windows can be had:
///   test_watch --gtest_filter=WatchFigures.Windows | scripts/watch_tail.py
/// PROCAM_WATCH_INSTALLATIONS, PROCAM_WATCH_FIRST: how many, and the first seed. A line for each window.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <random>

#include "people_before_wall.hpp"
#include "watched_world.hpp"

namespace procam::watch {
namespace {

using Normal = std::normal_distribution<double>;

constexpr ImageSize kFrame = {1024, 768};

enum class Shown { kFilm, kSlides, kDarkGame, kPausedGame, kMarks };
constexpr const char* kShownNames[] = {"film", "slides", "dark game", "paused game", "marks on a colour"};

Vec6 drawn(std::mt19937& random, double rotation, double translation, const Vec3& centre) {
  Normal normal(0, 1);
  const Vec3 w = rotation * Vec3(normal(random), normal(random), normal(random));
  const Vec3 v = translation * Vec3(normal(random), normal(random), normal(random));
  Vec6 moved;
  moved << w, v - w.cross(centre);
  return moved;
}

/// Large pictures that frames are parts of.
class Pictures {
 public:
  Pictures() {
    for (std::uint64_t k = 0; k < 6; ++k) {
      ImageU8& film = films_.emplace_back(kFrame.width + 240, kFrame.height + 120, 1);
      ImageU8& page = pages_.emplace_back(kFrame.width + 240, kFrame.height + 120, 1);
      for (int y = 0; y < film.height(); ++y)
        for (int x = 0; x < film.width(); ++x) {
          const double v = test::octaves(x / 58.0, y / 58.0, 31 * k);
          film.at(x, y) = std::uint8_t(255 * std::clamp(1.7 * (v - 0.22), 0.0, 1.0));
          const int line = y / 45;
          const bool ink = y % 45 < 21 && x % 13 != 0 && line % 7 != 6 &&
                           x < 500 + 700 * test::field(line, 0.5, k) &&
                           test::field(std::floor(x / 13.0), line * 3.0, k + 3) > 0.45;
          page.at(x, y) = ink ? 25 : 235;
        }
    }
  }
  ViewU8 film(std::uint64_t number, double time) const {
    const ImageU8& picture = films_[std::size_t(number % films_.size())];
    return part(picture, int(120 + 110 * std::sin(0.25 * time)), int(60 + 50 * std::cos(0.16 * time)));
  }
  ViewU8 page(std::uint64_t number) const {
    return part(pages_[std::size_t(number % pages_.size())], int(number * 37 % 240), int(number * 23 % 120));
  }

 private:
  static ViewU8 part(const ImageU8& picture, int x, int y) {
    return {&picture.at(x, y), kFrame.width, kFrame.height, 1, picture.view().stride};
  }
  std::vector<ImageU8> films_, pages_;
};

ImageU8 dark_game(double time, std::uint64_t seed) {
  ImageU8 frame(kFrame, 1, 3);
  for (int k = 0; k < 12; ++k) {
    const int cx = int(512 + 460 * std::sin(0.31 * time * (1 + 0.13 * k) + 2.4 * k + double(seed))),
              cy = int(384 + 330 * std::cos(0.27 * time * (1 + 0.21 * k) + 1.7 * k)), half = 14 + k % 4 * 11;
    for (int y = std::max(0, cy - half); y < std::min(kFrame.height, cy + half); ++y)
      for (int x = std::max(0, cx - half); x < std::min(kFrame.width, cx + half); ++x)
        frame.at(x, y) = std::uint8_t(120 + 20 * (k % 5));
  }
  return frame;
}

/// A wall, a rig and a camera with errors of their own, all drawn from what MovementOptions states.
class Installation {
 public:
  Installation(std::uint64_t seed, const Pictures& pictures)
      : seed_(seed),
        pictures_(pictures),
        random_(unsigned(seed * 7919 + 5)),
        noise_(1 << 16),
        people_(random_, seed % 4 == 3) {
    const MovementOptions known;
    Normal normal(0, 1);
    for (float& value : noise_) value = float(normal(random_));
    const test::Wall wall = test::one_wall().front();
    const Vec3 centre = wall.rig_from_surface * Vec3(wall.size.x() / 2, wall.size.y() / 2, 0);
    const RigProjector projector = rig.projector();
    const Pose rig_from_wall =
        se3_exp(drawn(random_, known.surface_rotation, known.surface_translation, centre)) *
        wall.rig_from_surface;
    Projector true_projector = projector.projector;
    Camera camera = rig.camera().camera;
    std::get<BrownConrady>(true_projector.inverse_camera.distortion).coefficients[0] +=
        2e-4 * normal(random_);
    std::get<BrownConrady>(camera.distortion).coefficients[0] += 2e-4 * normal(random_);
    const Pose rig_from_projector = se3_exp(drawn(random_, known.model_rotation, known.model_translation,
                                                  projector.rig_from_projector.translation)) *
                                    projector.rig_from_projector;
    delay_ = known.delay_sigma * normal(random_);
    const double gammas[] = {1, 1.8, 2.2, 2.4};
    gamma_ = gammas[random_() % 4];
    ambient_ = 0.02 + 0.1 * uniform();
    blur_ = 0.05 + 0.15 * uniform();
    texture_ = 0.1 * uniform();
    vignetting_ = 0.3 * uniform();
    // RMS of half of cell_sigma: neighbours are alike, so that movements are disturbed as by independent errors of cell_sigma.
    displacement_ = 0.5 * known.cell_sigma / 0.215;
    trace(camera, {true_projector.inverse_camera}, rig_from_projector, rig_from_wall, wall);
    surfaces.push_back({wall.name,
                        wall.rig_from_surface,
                        {Vec2(0, 0), Vec2(wall.size.x(), 0), wall.size, Vec2(0, wall.size.y())}});
  }

  Rig rig = test::watched_rig();
  std::vector<WatchedSurface> surfaces;

  /// The frame at a time, and the next one a sixtieth of a second later.
  ShownLight light(Shown shown, double time) {
    ShownLight light;
    light.share = 0.5;
    light.interval = 1 / 60.0;
    const auto scene = seed_ * 13 + std::uint64_t(time / 7);
    if (shown == Shown::kFilm) {
      light.frame = pictures_.film(scene, time);
      light.next = pictures_.film(scene, time + light.interval);
      return light;
    }
    if (shown == Shown::kSlides) {
      light.frame = light.next = pictures_.page(seed_ * 11 + std::uint64_t(time / 20));
      return light;
    }
    if (shown == Shown::kPausedGame) {
      game_[0] = dark_game(11.363 + 1.7 * double(seed_ % 12), seed_);
      light.frame = light.next = game_[0];
      return light;
    }
    if (shown == Shown::kDarkGame) {
      game_[0] = dark_game(time, seed_);
      game_[1] = dark_game(time + light.interval, seed_);
      light.frame = game_[0];
      light.next = game_[1];
      return light;
    }
    if (marked_.width() == 0) marked_ = marked_colour();
    light.frame = light.next = marked_;
    return light;
  }

  ImageU8 image(const ShownLight& light, double time) {
    const double share = std::clamp(light.share + delay_ / light.interval, 0.0, 1.0);
    mix(light, float(share));
    const ImageSize size = rig.camera().camera.size;
    grey_.resize(std::size_t(size.width) * std::size_t(size.height));
    people_.move_to(time);
    for (std::size_t i = 0; i < grey_.size(); ++i) {
      if (const auto hit = people_.first(on_wall_[i], eye_)) {
        grey_[i] = toned(hit->albedo * (float(ambient_) + light_at(lit_through(*hit))));
        continue;
      }
      const bool is_shadow = people_.first(on_wall_[i], lamp_).has_value();
      grey_[i] = toned(albedo_[i] * (float(ambient_) + (is_shadow ? 0 : light_at(place_[i]))));
    }
    return recorded(size);
  }

 private:
  double uniform() { return std::uniform_real_distribution<double>(0, 1)(random_); }

  ImageU8 marked_colour() {
    const test::Wall wall = test::one_wall().front();
    PlacedPlane placed;
    placed.plane_from_content = Vec3(wall.size.x(), wall.size.y(), 1).asDiagonal();
    placed.projector_from_surface = rig.projector().rig_from_projector.inverse() * wall.rig_from_surface;
    Scene scene;
    scene.items.push_back({placed, {}});
    const int greys[] = {255, 180, 120, 60, 4};
    ImageU8 frame(kFrame, 1, std::uint8_t(greys[seed_ % 5]));
    Marks().draw(0, scene, rig.projector().projector, frame);
    return frame;
  }

  /// Of each camera pixel: its point on the wall, the projector pixel (halved) that lights it, and the albedo. Every fourth pixel
  /// is traced. The wall is not flat, and the lenses have rests: a smooth displacement of kDisplacement.
  void trace(const Camera& camera, const Projector& projector, const Pose& rig_from_projector,
             const Pose& rig_from_wall, const test::Wall& wall) {
    constexpr int kStep = 4;
    const int columns = camera.size.width / kStep + 8, rows = camera.size.height / kStep + 8;
    const Pose wall_from_rig = rig_from_wall.inverse(),
               projector_from_wall = rig_from_projector.inverse() * rig_from_wall;
    const auto by_depth = [&](const Vec3& on_wall) {
      return Eigen::Vector3f(Vec3(on_wall.x(), on_wall.y(), std::abs(on_wall.z())).cast<float>());
    };
    eye_ = by_depth(wall_from_rig.translation);
    lamp_ = by_depth((wall_from_rig * rig_from_projector).translation);
    size_ = wall.size.cast<float>();
    const auto pixel_of = [&](const Vec2& at) -> Eigen::Vector2f {
      const Vec3 on_wall(at.x(), at.y(), 0);
      const Vec2 pixel = projector.project(projector_from_wall * on_wall).value_or(Vec2(-1e4, -1e4));
      return (pixel / 2 - Vec2(0.25, 0.25)).cast<float>();
    };
    for (int j = 0; j <= kLattice; ++j)
      for (int i = 0; i <= kLattice; ++i)
        lattice_.push_back(pixel_of(Vec2(i, j).cwiseProduct(wall.size) / kLattice));
    std::vector<Eigen::Vector4f> nodes;
    for (int j = 0; j < rows; ++j)
      for (int i = 0; i < columns; ++i) {
        const Vec3 along =
            wall_from_rig.rotation * camera.unproject(Vec2(i - 2, j - 2) * kStep).value_or(Vec3::UnitZ());
        const Vec3& eye = wall_from_rig.translation;
        const Vec2 on_wall = (eye - eye.z() / along.z() * along).head<2>();
        Eigen::Vector4f& node = nodes.emplace_back();
        node << pixel_of(on_wall), on_wall.cast<float>();
      }
    for (int y = 0; y < camera.size.height; ++y)
      for (int x = 0; x < camera.size.width; ++x) {
        const auto displaced = [&](double at, std::uint64_t axis) {
          return (at + displacement_ * (test::field(x / 25.0, y / 25.0, 977 * seed_ + axis) - 0.5)) / kStep +
                 2;
        };
        const double column = displaced(x, 1), row = displaced(y, 2);
        const auto node = std::size_t(int(row) * columns + int(column)), below = node + std::size_t(columns);
        const float fx = float(column - std::floor(column)), fy = float(row - std::floor(row));
        const Eigen::Vector4f value = (1 - fy) * ((1 - fx) * nodes[node] + fx * nodes[node + 1]) +
                                      fy * ((1 - fx) * nodes[below] + fx * nodes[below + 1]);
        on_wall_.emplace_back(value.tail<2>());
        place_.push_back(is_on(on_wall_.back()) ? Eigen::Vector2f(value.head<2>()) : kUnlit);
        const double paint =
            1 - texture_ * test::octaves(33 * double(value[2]), 33 * double(value[3]), seed_);
        const double r2 = (Vec2(x, y) - Vec2(320, 240)).squaredNorm() / 160000;
        albedo_.push_back(float(paint * (1 - vignetting_ * r2)));
      }
    for (int k = 0; k <= 2048; ++k) tones_.push_back(float(std::pow(k / 2048.0, 1 / gamma_)));
  }
  /// 0 .. 1.3 times full light to grey levels.
  float toned(float light) const {
    return 205 * tones_[std::size_t(std::min(2047.f, light * (2048 / 1.3f)))];
  }
  /// Linear light of both frames, averaged over 2 x 2 pixels.
  void mix(const ShownLight& light, float share) {
    static const std::array<float, 256> linear = [] {
      std::array<float, 256> table{};
      for (std::size_t k = 0; k < 256; ++k) {
        const double v = double(k) / 255;
        table[k] = float(v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4));
      }
      return table;
    }();
    light_.resize(std::size_t(kFrame.width / 2) * std::size_t(kFrame.height / 2));
    const bool is_still = light.frame.data == light.next.data;
    for (int y = 0; y < kFrame.height / 2; ++y) {
      float* out = &light_[std::size_t(y) * std::size_t(kFrame.width / 2)];
      const auto add = [&](ViewU8 frame, float weight, bool first) {
        const std::uint8_t *upper = frame.row(2 * y), *lower = frame.row(2 * y + 1);
        for (int x = 0; x < kFrame.width / 2; ++x) {
          const float sum = linear[upper[2 * x]] + linear[upper[2 * x + 1]] + linear[lower[2 * x]] +
                            linear[lower[2 * x + 1]];
          out[x] = (first ? 0 : out[x]) + 0.25f * weight * sum;
        }
      };
      add(light.frame, is_still ? 1 : 1 - share, true);
      if (!is_still) add(light.next, share, false);
    }
  }
  bool is_on(const Eigen::Vector2f& on_wall) const {
    return on_wall.minCoeff() > 0 && on_wall.x() < size_.x() && on_wall.y() < size_.y();
  }
  /// The projector pixel (halved) whose light a person stops there.
  Eigen::Vector2f lit_through(const test::Touched& hit) const {
    const Eigen::Vector2f lamp = lamp_.head<2>();
    const Eigen::Vector2f on_wall = lamp + lamp_.z() / (lamp_.z() - hit.depth) * (hit.point - lamp);
    if (!is_on(on_wall)) return kUnlit;
    const Eigen::Vector2f at = float(kLattice) * on_wall.cwiseQuotient(size_);
    const float fx = at.x() - std::floor(at.x()), fy = at.y() - std::floor(at.y());
    const Eigen::Vector2f* node = &lattice_[std::size_t(int(at.y()) * (kLattice + 1) + int(at.x()))];
    return (1 - fy) * ((1 - fx) * node[0] + fx * node[1]) +
           fy * ((1 - fx) * node[kLattice + 1] + fx * node[kLattice + 2]);
  }
  float light_at(const Eigen::Vector2f& place) const {
    const float x = place.x(), y = place.y();
    if (!(x >= 0 && y >= 0 && x < kFrame.width / 2 - 1 && y < kFrame.height / 2 - 1)) return 0;
    const int column = int(x), row = int(y);
    const float fx = x - float(column), fy = y - float(row);
    const float* above = &light_[std::size_t(row) * std::size_t(kFrame.width / 2) + std::size_t(column)];
    const float* below = above + kFrame.width / 2;
    return (1 - fy) * ((1 - fx) * above[0] + fx * above[1]) + fy * ((1 - fx) * below[0] + fx * below[1]);
  }
  /// Blur by (b, 1 - 2 b, b) along both axes, then noise.
  ImageU8 recorded(ImageSize size) {
    const float b = float(blur_);
    ImageU8 image(size, 1);
    const auto at = [&](int x, int y) {
      return grey_[std::size_t(y) * std::size_t(size.width) + std::size_t(x)];
    };
    for (int y = 1; y + 1 < size.height; ++y) {
      std::size_t n = random_() % noise_.size();
      for (int x = 1; x + 1 < size.width; ++x) {
        const float cross = at(x - 1, y) + at(x + 1, y) + at(x, y - 1) + at(x, y + 1);
        const float value = (1 - 4 * b) * at(x, y) + b * cross;
        n = (n + 1) & (noise_.size() - 1);
        const float grey = value + std::sqrt(2 + 0.02f * value) * noise_[n];
        image.at(x, y) = std::uint8_t(std::clamp(grey + 0.5f, 0.f, 255.f));
      }
    }
    return image;
  }

  std::uint64_t seed_;
  const Pictures& pictures_;
  std::mt19937 random_;
  std::vector<float> noise_;
  double delay_ = 0, gamma_ = 2.2, ambient_ = 0.06, blur_ = 0.1, texture_ = 0.1, vignetting_ = 0.2,
         displacement_ = 0;
  static constexpr int kLattice = 60;
  inline static const Eigen::Vector2f kUnlit{-1e4f, -1e4f};
  test::PeopleBeforeWall people_;
  Eigen::Vector3f eye_, lamp_;            ///< of the camera and of the projector, by the wall
  Eigen::Vector2f size_;                  ///< of the content
  std::vector<Eigen::Vector2f> lattice_;  ///< projector pixels (halved) over the content
  std::vector<Eigen::Vector2f> place_, on_wall_;
  std::vector<float> albedo_, tones_, light_, grey_;
  ImageU8 game_[2], marked_;
};

struct PeopleCase {
  const char* name;
  std::uint64_t seed;
  Shown shown;
  double from, to;
  bool hides_all;
};
void PrintTo(const PeopleCase& c, std::ostream* out) {
  *out << c.name;
}
class PeopleWhoStand : public ::testing::TestWithParam<PeopleCase> {};

/// A group that hides all of the content shows it as a nearer wall would; the outline of one person disturbs some of few cells.
TEST_P(PeopleWhoStand, AreNoMovement) {
  const PeopleCase& c = GetParam();
  const Pictures pictures;
  Installation installation(c.seed, pictures);
  Watch watch(installation.rig.camera(), installation.rig.projector());
  watch.place(installation.surfaces);
  double farthest = 0, last = 0;
  int windows = 0;
  for (double time = c.from; time < c.to; time += 2 / 3.0 + 1e-3) {
    const ShownLight light = installation.light(c.shown, time);
    const WatchReport report = watch.add(time, light, installation.image(light, time));
    EXPECT_FALSE(report.is_alarm) << report.sentence;
    farthest = std::max(farthest, report.median_shift.norm());
    windows += report.window_time > last;
    last = report.window_time;
  }
  EXPECT_GE(windows, 1);
  EXPECT_EQ(farthest > 10, c.hides_all) << "median shift in camera pixels";
}
INSTANTIATE_TEST_SUITE_P(Watch, PeopleWhoStand,
                         ::testing::Values(PeopleCase{"group", 59, Shown::kDarkGame, 18.713, 30.5, true},
                                           PeopleCase{"outline", 9, Shown::kPausedGame, 15.3, 22.8, false}),
                         [](const auto& info) { return std::string(info.param.name); });

/// A line for each window: content, installation, window, chi-square, degrees of freedom, probability, error in mm, alarm, cells,
/// whether the light may be on something before the wall, probability without any neighbourhood of cells.
TEST(WatchFigures, Windows) {
  const auto number = [](const char* variable, int usual) {
    const char* text = std::getenv(variable);
    return text != nullptr ? std::atoi(text) : usual;
  };
  const int first = number("PROCAM_WATCH_FIRST", 0), count = number("PROCAM_WATCH_INSTALLATIONS", 8);
  constexpr int kWindows = 5;  // of each content
  const Pictures pictures;
  std::printf("content,installation,window,chi2,dof,probability,error_mm,alarm,cells,before,of_others\n");
  for (int seed = first; seed < first + count; ++seed) {
    Installation installation(std::uint64_t(seed), pictures);
    for (const Shown shown :
         {Shown::kFilm, Shown::kSlides, Shown::kDarkGame, Shown::kPausedGame, Shown::kMarks}) {
      Watch watch(installation.rig.camera(), installation.rig.projector());
      watch.place(installation.surfaces);
      double last = 0, time = 0.013 + 1.7 * (seed % 12);
      int window = 0;
      for (const double end = time + 2.1 * kWindows + 1; time < end; time += 2 / 3.0 + 1e-3) {
        const ShownLight light = installation.light(shown, time);
        const WatchReport report = watch.add(time, light, installation.image(light, time));
        if (!(report.window_time > last)) continue;
        last = report.window_time;
        const auto causes = report.estimate->plausible();
        std::printf(
            "%s,%d,%d,%.2f,%d,%.4g,%.3f,%d,%d,%d,%.4g\n", kShownNames[int(shown)], seed, window++,
            report.estimate->chi2, report.estimate->degrees_of_freedom, report.probability,
            1e3 * report.error, report.is_alarm, report.estimate->cells,
            std::any_of(causes.begin(), causes.end(), [](const Explanation* one) { return one->is_before; }),
            report.estimate->of_others);
      }
      std::fflush(stdout);
    }
  }
}

}  // namespace
}  // namespace procam::watch
