/// Blending, judged by what a wall would show: the light of all projectors that reach a place is added up
/// there, with visibility and irradiance worked out by this test's own means.
#include "procam/surface/blend.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "positions.hpp"
#include "procam/core/base/color.hpp"
#include "procam/core/geometry/se3.hpp"
#include "procam/surface/warp.hpp"

namespace procam {
namespace {

using surface::Blend;
using surface::blend_maps;
using surface::BlendInput;
using surface::BlendMap;
using surface::BlendOptions;

/// A rectangle in the world: its corner and its two sides, metres.
struct Wall {
  std::string name;
  Vec3 corner, right, down;

  Vec3 at(double u, double v) const { return corner + u * right + v * down; }
  Vec3 normal() const { return right.cross(down).normalized(); }
  /// Does it stand between two points?
  bool hides(const Vec3& from, const Vec3& to) const {
    Mat3 m;
    m << right, down, from - to;
    const Vec3 uvt = m.inverse() * (from - corner);
    return uvt.minCoeff() > 0 && uvt.x() < 1 && uvt.y() < 1 && uvt.z() < 0.999;
  }
};

struct Lamp {
  Projector projector;
  Pose projector_from_world;
  double brightness = 1, black = 0;
};

struct Room {
  std::vector<Wall> walls;
  std::vector<Lamp> lamps;
  std::vector<SolvedSurfaceSet> solved;

  std::vector<BlendInput> lit() {
    solved.clear();
    for (const Lamp& lamp : lamps) {
      SolvedSurfaceSet set;
      for (const Wall& wall : walls) {
        Mat3 rotation;
        rotation << wall.right.normalized(), wall.normal().cross(wall.right.normalized()), wall.normal();
        PlacedPlane placed;
        placed.plane_from_content << wall.right.norm(), wall.down.dot(rotation.col(0)), 0, 0,
            wall.down.dot(rotation.col(1)), 0, 0, 0, 1;
        placed.projector_from_surface = lamp.projector_from_world * Pose(rotation, wall.corner);
        SolvedSurface surface;
        surface.surface.name = wall.name;
        surface.placement = placed;
        set.surfaces.push_back(surface);
      }
      solved.push_back(set);
    }
    std::vector<BlendInput> result;
    for (std::size_t i = 0; i < lamps.size(); ++i)
      result.push_back({lamps[i].projector, &solved[i], lamps[i].brightness, lamps[i].black});
    return result;
  }

  /// The pixel of a lamp that lights a place of a wall, at least `margin` pixels inside the picture.
  std::optional<Vec2> pixel(const Lamp& lamp, const Vec3& point, double margin) const {
    const Vec3 centre = lamp.projector_from_world.inverse() * Vec3(0, 0, 0);
    for (const Wall& wall : walls)
      if (wall.hides(centre, point)) return std::nullopt;
    const auto pixel = lamp.projector.project(lamp.projector_from_world * point);
    const ImageSize size = lamp.projector.size();
    if (!pixel || !(pixel->minCoeff() >= margin && pixel->x() <= size.width - 1 - margin &&
                    pixel->y() <= size.height - 1 - margin))
      return std::nullopt;
    return pixel;
  }
  /// Light of white: brightness over all pixels, times pixels over an area there.
  double irradiance(const Lamp& lamp, const Wall& wall, const Vec3& point) const {
    constexpr double kStep = 1e-4;
    const Vec3 right = wall.right.normalized(), down = wall.normal().cross(right);
    const auto at = [&](const Vec3& p) { return *lamp.projector.project(lamp.projector_from_world * p); };
    Mat2 jacobian;
    jacobian << at(point + kStep * right) - at(point - kStep * right),
        at(point + kStep * down) - at(point - kStep * down);
    const ImageSize size = lamp.projector.size();
    return lamp.brightness * std::abs(jacobian.determinant()) / (4 * kStep * kStep) /
           (double(size.width) * size.height);
  }
};

double sample(const ImageF& map, const Vec2& pixel) {
  const int x = std::min(int(pixel.x()), map.width() - 2), y = std::min(int(pixel.y()), map.height() - 2);
  const double s = pixel.x() - x, t = pixel.y() - y;
  return (1 - t) * ((1 - s) * map.at(x, y) + s * map.at(x + 1, y)) +
         t * ((1 - s) * map.at(x, y + 1) + s * map.at(x + 1, y + 1));
}

/// What the room shows for content of one light everywhere.
struct Shown {
  double mean = 0, deviation = 0, worst = 0;  ///< of the mean
  int places = 0, by_two = 0, off = 0;        ///< off: by more than 1 %
};
Shown shown(const Room& room, const Blend& blend, double content, bool with_irradiance,
            const std::string& only = "", double inset = 0.006) {
  std::vector<double> lights;
  Shown result;
  constexpr double kMargin = 2;  // px: at a picture's border light is as sharp as pixels are, and no sharper
  for (const Wall& wall : room.walls) {
    if (!only.empty() && wall.name != only) continue;
    for (double v = inset; v < 1 - inset; v += 0.0123)
      for (double u = inset; u < 1 - inset; u += 0.0117) {
        const Vec3 point = wall.at(u, v);
        double light = 0;
        int lamps = 0;
        bool at_border = false;
        for (std::size_t i = 0; i < room.lamps.size(); ++i) {
          const Lamp& lamp = room.lamps[i];
          const auto pixel = room.pixel(lamp, point, kMargin);
          if (!pixel) {
            at_border = at_border || room.pixel(lamp, point, -kMargin).has_value();
            continue;
          }
          const double asked =
              sample(blend.maps[i].gain, *pixel) * content + sample(blend.maps[i].lift, *pixel);
          light += (with_irradiance ? room.irradiance(lamp, wall, point) : 1) *
                   (lamp.black + (1 - lamp.black) * asked);
          ++lamps;
        }
        if (lamps == 0 || at_border) continue;
        result.by_two += lamps > 1;
        lights.push_back(light);
      }
  }
  result.places = int(lights.size());
  for (const double light : lights) result.mean += light / double(lights.size());
  for (const double light : lights) {
    const double off = std::abs(light / result.mean - 1);
    result.worst = std::max(result.worst, off);
    result.off += off > 0.01;
    result.deviation += off * off / double(lights.size());
  }
  result.deviation = std::sqrt(result.deviation);
  return result;
}

Pose looking(const Vec3& from, const Vec3& to, double roll) {
  const Vec3 forward = (to - from).normalized();
  const Vec3 right = Vec3::UnitY().cross(forward).normalized();
  Mat3 rotation;
  rotation << right, forward.cross(right), forward;
  return (Pose(rotation, from) * Pose(so3_exp<double>(Vec3(0, 0, roll)), Vec3::Zero())).inverse();
}

Lamp left_lamp() {
  Lamp lamp;
  lamp.projector = {
      Camera{{320, 240}, {420, 413, 150.3, 121.6, 1.1}, BrownConrady{{-0.1, 0.02, 1e-3, -5e-4, 0}}}};
  lamp.projector_from_world = looking({-0.55, 0.1, 0}, {-0.3, 0.05, 2.1}, 0.03);
  return lamp;
}
Lamp right_lamp() {
  Lamp lamp;
  lamp.projector = {Camera{{400, 250}, {515, 522, 210.4, 110.9, -0.7}, {}}};
  lamp.projector_from_world = looking({0.7, -0.12, 0.25}, {0.36, 0.0, 2.1}, -0.05);
  return lamp;
}

Room flat_wall() {
  Room room;
  room.walls = {{"wall", {-2.2, -1.3, 2.0}, {4.4, 0, 0.25}, {0.05, 2.6, 0.1}}};
  room.lamps = {left_lamp(), right_lamp()};
  return room;
}
Room corner() {
  Room room;
  room.walls = {{"left", {-2.0, -1.3, 1.6}, {2.1, 0, 0.9}, {0, 2.6, 0.0}},
                {"right", {0.1, -1.3, 2.5}, {1.9, 0, -1.3}, {0, 2.6, 0.0}}};
  room.lamps = {left_lamp(), right_lamp()};
  return room;
}

TEST(Blend, TwoProjectorsOnAWallAddUpToOne) {
  Room room = flat_wall();
  const Blend blend = blend_maps(room.lit());
  const Shown white = shown(room, blend, 1, false), grey = shown(room, blend, 0.2, false);
  ASSERT_GT(white.by_two, 200);
  ASSERT_GT(white.places, 3 * white.by_two / 2);
  EXPECT_NEAR(white.mean, 1, 1e-3);
  EXPECT_LT(white.worst, 0.01);      // measured 0.0034, where the two pictures' borders cross
  EXPECT_LT(white.deviation, 5e-4);  // 0.00012
  EXPECT_LT(grey.worst, 0.01);
}

TEST(Blend, WeightsStepNowhereAndEndAtZero) {
  Room room = flat_wall();
  const Blend blend = blend_maps(room.lit());
  for (const BlendMap& map : blend.maps) {
    int steps = 0;
    bool alone = false;
    for (int y = 0; y < map.weight.height(); ++y)
      for (int x = 1; x < map.weight.width(); ++x) {
        steps += std::abs(map.weight.at(x, y) - map.weight.at(x - 1, y)) > 0.1F;
        alone = alone || map.weight.at(x, y) == 1;
      }
    EXPECT_TRUE(alone);
    EXPECT_LT(steps, 60) << "of 80 000 pixels: a step only where two pictures' borders cross";
  }
  // In the middle of the left lamp's right border, where the right lamp takes over.
  EXPECT_LT(blend.maps[0].weight.at(319, 120), 1e-3);
}

/// A show asks for its own map alone: it is the same, and names those that it shares places with.
TEST(Blend, OneMapAloneIsThatOfAll) {
  Room room = corner();
  room.lamps.push_back(left_lamp());
  room.lamps[2].projector_from_world = looking({-1.5, 0.1, 0.3}, {-1.5, 0.05, 1.9}, 0.02);
  for (const bool has_level : {false, true}) {
    room.lamps[1].black = has_level ? 0.003 : 0;
    BlendOptions options;
    options.compensate = has_level;
    const Blend all = blend_maps(room.lit(), options);
    ASSERT_EQ(all.neighbours[0], (std::vector<std::size_t>{1, 2}));
    EXPECT_EQ(all.neighbours[1], std::vector<std::size_t>{0}) << "the third lights the far end";
    for (std::size_t i = 0; i < 3; ++i) {
      options.only = i;
      options.threads = int(i) + 1;
      const Blend one = blend_maps(room.lit(), options);
      EXPECT_EQ(one.neighbours[i], all.neighbours[i]);
      EXPECT_TRUE(one.maps[(i + 1) % 3].gain.empty());
      const auto same = [](const ImageF& a, const ImageF& b) {
        return a.size() == b.size() &&
               std::equal(a.data(), a.data() + std::ptrdiff_t(a.width()) * a.height(), b.data());
      };
      EXPECT_TRUE(same(one.maps[i].weight, all.maps[i].weight));
      EXPECT_TRUE(same(one.maps[i].gain, all.maps[i].gain));
      EXPECT_TRUE(same(one.maps[i].lift, all.maps[i].lift));
    }
  }
  BlendOptions none;
  none.only = 3;
  EXPECT_THROW(blend_maps(room.lit(), none), std::invalid_argument);
}

/// Rays that are interpolated between every fourth pixel of a frame of this size.
TEST(Positions, InterpolatedRaysAreThoseOfTheLens) {
  const Projector projector{
      Camera{{1922, 1083}, {2400, 2380, 950, 1000, 2}, BrownConrady{{-0.2, 0.03, 1e-3, -5e-4, 0}}}};
  const ImageF directions = surface::light_directions(projector, 2);
  double furthest = 0;
  for (int y = 0; y < 1083; y += 7)
    for (int x = 0; x < 1922; x += 5) {
      const float* d = &directions.at(x, y, 0);
      const Vec3 direction = Eigen::Map<const Eigen::Vector3f>(d).cast<double>();
      furthest = std::max(furthest, (*projector.project(direction) - Vec2(x, y)).norm());
    }
  EXPECT_LT(furthest, 2e-3);
  EXPECT_GT(furthest, 1e-7) << "or nothing is interpolated";
  RecordProperty("furthest_1e6_px", int(1e6 * furthest));
  Room room = corner();
  room.lamps = {{projector, room.lamps[0].projector_from_world}};
  const std::vector<BlendInput> lit = room.lit();
  for (const SolvedSurface& wall : lit[0].surfaces->surfaces) {
    const ImageF fast = surface::positions_along(directions, wall.placement, projector, 2),
                 exact = surface::position_map(wall.placement, projector);
    int only_one = 0;
    double off = 0;
    for (int y = 0; y < 1083; y += 3)
      for (int x = 0; x < 1922; x += 3) {
        const bool has = std::isfinite(fast.at(x, y, 2));
        only_one += has != bool(std::isfinite(exact.at(x, y, 2)));
        for (int c = 0; c < 3 && has && std::isfinite(exact.at(x, y, 2)); ++c)
          off = std::max(off, std::abs(double(fast.at(x, y, c)) - double(exact.at(x, y, c))));
      }
    EXPECT_LT(only_one, 5);
    EXPECT_LT(off, 5e-6);  // metres, at two metres and 0.9 mm a pixel
  }
}

TEST(FrameBlend, RowsTogetherAreApplyBlendAndUntouchedPixelsStay) {
  BlendMap map{ImageF(640, 11, 1, 1), ImageF(640, 11, 1, 1), ImageF(640, 11)};
  for (int y = 2; y < 9; ++y)
    for (int x = 30 * y; x < 640 - 7 * y; ++x) {
      map.gain.at(x, y) = float(x) / 640;
      map.lift.at(x, y) = 0.0004F * float(y);
    }
  ImageU8 frame(640, 11, 3);
  for (int i = 0; i < 640 * 11 * 3; ++i) frame.data()[i] = std::uint8_t(i * 37 % 256);
  ImageU8 whole = frame, parts = frame;
  surface::apply_blend(map, whole);
  const surface::FrameBlend blend(map);
  for (const auto& [first, last] : {std::pair(0, 3), std::pair(3, 4), std::pair(4, 11)})
    blend.apply(parts, first, last);
  const auto same = [](const ImageU8& a, const ImageU8& b) {
    return std::equal(a.data(), a.data() + 640 * 11 * 3, b.data());
  };
  EXPECT_TRUE(same(whole, parts));
  for (int v = 0; v < 256; ++v) EXPECT_EQ(whole.at(v, 0, 1), frame.at(v, 0, 1)) << "gain 1, lift 0";
  int furthest = 0;  // from the formula in doubles
  for (int y = 0; y < 11; ++y)
    for (int x = 0; x < 640; ++x)
      for (int k = 0; k < 3; ++k) {
        const double light = light_from_srgb(frame.at(x, y, k) / 255.0);
        const double shown = std::min(1.0, double(map.gain.at(x, y)) * light + double(map.lift.at(x, y)));
        furthest =
            std::max(furthest, std::abs(int(std::lround(255 * srgb_from_light(shown))) - whole.at(x, y, k)));
      }
  EXPECT_LE(furthest, 1);
  EXPECT_NEAR(blend.changed_share(),
              1 - (640.0 * 11 -
                   [&] {
                     double count = 0;
                     for (int y = 2; y < 9; ++y) count += 640 - 37 * y;
                     return count;
                   }()) /
                      (640 * 11),
              1e-9);
  EXPECT_THROW(blend.apply(parts, 0, 12), std::invalid_argument);
  ImageU8 narrow(639, 11, 3);
  EXPECT_THROW(blend.apply(narrow, 0, 11), std::invalid_argument);
}

TEST(Blend, BlackIsTheSameEverywhere) {
  Room room = flat_wall();
  room.lamps[0].black = 0.004;
  room.lamps[1].black = 0.0025;
  const Blend blend = blend_maps(room.lit());
  const Shown black = shown(room, blend, 0, false), white = shown(room, blend, 1, false);
  EXPECT_NEAR(black.mean, 0.0065, 1e-4);
  EXPECT_LT(black.worst, 0.02);
  EXPECT_LT(white.worst, 0.01);
  room.lamps[0].black = room.lamps[1].black = 0;  // as if nothing was known of it
  const Blend without = blend_maps(room.lit());
  room.lamps[0].black = 0.004;
  room.lamps[1].black = 0.0025;
  EXPECT_GT(shown(room, without, 0, false).worst, 0.3) << "the overlap's black would show";
}

TEST(Blend, CompensationEvensOutDistanceAndIncidenceInACorner) {
  Room room = corner();
  room.lamps[0].brightness = 1.4;
  BlendOptions options;
  options.compensate = true;
  options.one_level = true;
  options.min_gain = 0.05;
  const Blend even = blend_maps(room.lit(), options);
  const Blend plain = blend_maps(room.lit());
  const Shown evened = shown(room, even, 1, true), uneven = shown(room, plain, 1, true);
  EXPECT_GT(evened.by_two, 200);
  EXPECT_GT(uneven.deviation, 0.1);
  EXPECT_LT(evened.deviation, 0.01);  // measured 0.0069, the darkest 1 % in it; plain 0.24
  EXPECT_LT(evened.worst, 0.15);      // 0.097
  options.one_level = false;
  const Blend each = blend_maps(room.lit(), options);
  for (const char* wall : {"left", "right"})
    EXPECT_LT(shown(room, each, 1, true, wall).deviation, 0.01) << wall;
}

TEST(Blend, TheLeastGainLimitsWhatBrightPlacesLose) {
  Room room = corner();
  BlendOptions options;
  options.compensate = true;
  options.one_level = true;
  options.min_gain = 0.8;
  const Blend blend = blend_maps(room.lit(), options);
  ASSERT_TRUE(blend.diagnostics.find("stays_dark"));
  double least = 1;
  for (const BlendMap& map : blend.maps)
    for (int y = 0; y < map.gain.height(); ++y)
      for (int x = 0; x < map.gain.width(); ++x)
        if (map.weight.at(x, y) == 1) least = std::min(least, double(map.gain.at(x, y)));
  EXPECT_GT(least, 0.75) << "1 % of all places is brighter than the brightest counted";
}

/// A post before the wall: the right lamp must fill in what the left one cannot reach, and only that.
TEST(Blend, ShadowsAreFilledByTheOther) {
  Room room = flat_wall();
  room.walls.push_back({"post", {0.05, -0.25, 1.6}, {0.11, 0, 0.01}, {0, 0.55, 0.02}});
  const Blend blend = blend_maps(room.lit());
  const Shown wall = shown(room, blend, 1, false, "wall"), post = shown(room, blend, 1, false, "post", 0.12);
  int weak = 0, filled = 0;
  for (double v = 0.2; v < 0.8; v += 0.004)
    for (double u = 0.3; u < 0.9; u += 0.004) {
      const Vec3 point = room.walls[0].at(u, v);
      const auto left = room.pixel(room.lamps[0], point, 1), right = room.pixel(room.lamps[1], point, 1);
      const auto in_picture = room.lamps[0].projector.project(room.lamps[0].projector_from_world * point);
      if (left || !right || !room.lamps[0].projector.size().contains(*in_picture)) continue;
      ++filled;
      weak += sample(blend.maps[1].weight, *right) < 0.97;
    }
  ASSERT_GT(filled, 100);
  EXPECT_LT(weak, 0.1 * filled) << "at the shadow's border alone";
  // Pixels half on the post, half past it, can be right for one of the two.
  EXPECT_LT(wall.off, 0.01 * wall.places);
  EXPECT_LT(wall.deviation, 0.02);  // measured 0.012
  EXPECT_GT(post.by_two, 100);
  EXPECT_LT(post.worst, 0.01);
}

TEST(Blend, ReflectanceIsMadeUpFor) {
  Room room = flat_wall();
  ImageF dark(64, 40);
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 64; ++x) dark.at(x, y) = float(0.6 + 0.3 * std::sin(0.3 * x) * std::cos(0.25 * y));
  BlendOptions options;
  options.compensate = true;
  options.min_gain = 0.02;
  const auto lit = room.lit();
  const Blend plain = blend_maps(lit, options);
  options.reflectance["wall"] = dark;
  const Blend blend = blend_maps(lit, options);
  // gain x reflectance is the other gain, up to the level.
  const Wall& wall = room.walls[0];
  std::vector<double> ratios;
  for (double v = 0.3; v < 0.7; v += 0.013)
    for (double u = 0.25; u < 0.75; u += 0.011) {
      const auto pixel = room.pixel(room.lamps[0], wall.at(u, v), 2);
      if (!pixel) continue;
      ratios.push_back(sample(blend.maps[0].gain, *pixel) / sample(plain.maps[0].gain, *pixel) *
                       sample(dark, Vec2(u * 64 - 0.5, v * 40 - 0.5)));
    }
  std::sort(ratios.begin(), ratios.end());
  // The darkest 1 % of the wall cannot be had as bright as the rest.
  EXPECT_LT(ratios[ratios.size() * 98 / 100] / ratios[ratios.size() * 4 / 100], 1.03);
  options.compensate = false;
  EXPECT_THROW(blend_maps(lit, options), std::invalid_argument);
}

TEST(Blend, HolesAreNotBlendedAndPixelSurfacesAreTold) {
  Room room = flat_wall();
  std::vector<BlendInput> lit = room.lit();
  for (SolvedSurfaceSet& set : room.solved) {
    set.surfaces[0].surface.shape.holes = {{{0.4, 0.4}, {0.6, 0.4}, {0.6, 0.6}, {0.4, 0.6}}};
    SolvedSurface pixels;
    pixels.surface.name = "dragged";
    pixels.placement = PlacedPixels{};
    set.surfaces.push_back(pixels);
  }
  const Blend blend = blend_maps(lit);
  EXPECT_TRUE(blend.diagnostics.find("no_place"));
  const auto in_hole = room.pixel(room.lamps[0], room.walls[0].at(0.45, 0.5), 2);
  ASSERT_TRUE(in_hole);
  EXPECT_EQ(blend.maps[0].weight.at(int(in_hole->x()), int(in_hole->y())), 0);
  EXPECT_EQ(blend.maps[0].gain.at(int(in_hole->x()), int(in_hole->y())), 1);
}

TEST(Blend, IsAppliedToLightAndEncodedForTheProjector) {
  BlendMap map{ImageF(256, 1, 1, 1.0F), ImageF(256, 1, 1, 1.0F), ImageF(256, 1)};
  ImageU8 frame(256, 1, 3);
  const auto fill = [&] {
    for (int x = 0; x < 256; ++x)
      for (int k = 0; k < 3; ++k) frame.at(x, 0, k) = std::uint8_t(x);
  };
  fill();
  surface::apply_blend(map, frame);
  for (int x = 0; x < 256; ++x) ASSERT_EQ(frame.at(x, 0, 1), x) << "gain 1 changes nothing";
  fill();
  surface::apply_blend(map, frame, 2.2);
  EXPECT_NEAR(frame.at(128, 0, 2), 255 * std::pow(0.21586, 1 / 2.2), 0.6);
  map.gain = ImageF(256, 1, 1, 0.5F);
  map.lift = ImageF(256, 1, 1, 0.01F);
  fill();
  surface::apply_blend(map, frame);
  EXPECT_EQ(frame.at(255, 0), 189);  // sRGB of 0.51
  EXPECT_EQ(frame.at(0, 0), 25);     // of 0.01
  EXPECT_THROW(surface::apply_blend(map, frame, -1), std::invalid_argument);
  ImageF light(256, 1, 3, 0.4F);  // stays light
  surface::apply_blend(map, light);
  EXPECT_FLOAT_EQ(light.at(255, 0, 2), 0.21F);
}

}  // namespace
}  // namespace procam
