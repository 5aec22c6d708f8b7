// The planner against hand geometry, neighbouring pixels, brute force and textbook optics.
#include "procam/analyze/planner.hpp"

#include <gtest/gtest.h>

#include <random>

#include "analyze/lopsided_site.hpp"
#include "support/lopsided.hpp"

namespace procam::analyze {
namespace {

using test::lopsided_sheet;
using test::lopsided_site;

/// Any of a picture's positions, its edges included.
Vec2 random_pixel(std::mt19937_64& random, ImageSize size) {
  return Vec2(test::uniform(random, -0.5, size.width - 0.5), test::uniform(random, -0.5, size.height - 0.5));
}

/// Where light lands, by core's verbs alone.
Vec2 landed(const ProjectionPlan& plan, const Vec2& pixel) {
  const Vec3 in_projector = plan.projector.intersect(pixel, Plane::of_xy(plan.projector_from_wall)).value();
  return (plan.projector_from_wall.inverse() * in_projector).head<2>();
}

bool lit(const ProjectionPlan& plan, const Vec2& on_wall) {
  const auto pixel = plan.projector.project(plan.projector_from_wall * Vec3(on_wall.x(), on_wall.y(), 0));
  // 1e-6 px: the sides of the lit area are the picture's edges, to rounding.
  return pixel && pixel->x() >= -0.5 - 1e-6 && pixel->y() >= -0.5 - 1e-6 &&
         pixel->x() <= plan.projector.size().width - 0.5 + 1e-6 &&
         pixel->y() <= plan.projector.size().height - 0.5 + 1e-6;
}

bool lit(const ProjectionPlan& plan, const WallRectangle& rectangle) {
  for (const Vec2& corner : rectangle.corners())
    if (!lit(plan, corner)) return false;
  return true;
}

TEST(Planner, MakesTheProjectorOfTheDataSheet) {
  const Projector projector = projector_of(lopsided_sheet());
  EXPECT_NEAR(projector.throw_ratio(), 0.83, 1e-12);
  EXPECT_NEAR((projector.lens_shift() - Vec2(-0.07, 0.46)).norm(), 0, 1e-12);
  EXPECT_EQ(projector.inverse_camera.intrinsics.fx, projector.inverse_camera.intrinsics.fy);
}

TEST(Planner, PlacesAnUnturnedPictureWhereARulerWould) {
  Site site;
  site.projector_from_wall = pose_before_wall(1.66);
  const ProjectionPlan plan = plan_projection(lopsided_sheet(), site);
  // Two metres wide; the picture's centre 0.07 widths right of the axis and 0.46 heights above it.
  const double width = 2, height = 2 * 801.0 / 1280;
  const Vec2 centre(0.07 * width, -0.46 * height);
  EXPECT_NEAR((plan.middle - centre).norm(), 0, 1e-12);
  EXPECT_NEAR((plan.corners[0] - (centre - Vec2(width, height) / 2)).norm(), 0, 1e-12);
  EXPECT_NEAR((plan.corners[2] - (centre + Vec2(width, height) / 2)).norm(), 0, 1e-12);
  EXPECT_NEAR(plan.mm_per_pixel_min, 2000.0 / 1280, 1e-9);
  EXPECT_NEAR(plan.mm_per_pixel_max, 2000.0 / 1280, 1e-9);
  EXPECT_NEAR(plan.lux->middle, 2900 / (width * height), 1e-9);
  EXPECT_NEAR(plan.lux->darkest, plan.lux->brightest, 1e-9);
  EXPECT_NEAR(plan.incidence_deg, std::atan2(centre.norm(), 1.66) / kDegree, 1e-9);
  EXPECT_NEAR(plan.undistorted_pixel_share, 1, 1e-12);
}

TEST(Planner, TurnsRightUpAndClockwise) {
  DataSheet sheet = lopsided_sheet();
  sheet.lens_shift = Vec2::Zero();
  Site site;
  site.projector_from_wall = pose_before_wall(1.7, 20 * kDegree);
  ProjectionPlan plan = plan_projection(sheet, site);
  EXPECT_NEAR((plan.middle - Vec2(1.7 * std::tan(20 * kDegree), 0)).norm(), 0, 1e-12);
  // The edges of the middle row: half the picture subtends atan(1 / (2 throw)).
  const double half = std::atan(0.5 / 0.83);
  EXPECT_NEAR(landed(plan, Vec2(-0.5, 400)).x(), 1.7 * std::tan(20 * kDegree - half), 1e-12);
  EXPECT_NEAR(landed(plan, Vec2(1279.5, 400)).x(), 1.7 * std::tan(20 * kDegree + half), 1e-12);
  site.projector_from_wall = pose_before_wall(1.7, 0, 10 * kDegree);
  EXPECT_NEAR(plan_projection(sheet, site).middle.y(), -1.7 * std::tan(10 * kDegree), 1e-12);
  site.projector_from_wall = pose_before_wall(1.7, 0, 0, 10 * kDegree);
  plan = plan_projection(sheet, site);
  EXPECT_GT(plan.corners[1].y(), plan.corners[0].y());  // the top edge falls towards the right
}

TEST(Planner, MeasuresPixelsAsNeighbouringRaysDo) {
  const ProjectionPlan plan = plan_projection(lopsided_sheet(), lopsided_site());
  std::mt19937_64 random(3);
  for (int trial = 0; trial < 40; ++trial) {
    const Vec2 pixel = random_pixel(random, plan.projector.size());
    const LightOnWall light = light_on_wall(plan.projector, plan.projector_from_wall, pixel).value();
    EXPECT_NEAR((light.on_wall - landed(plan, pixel)).norm(), 0, 1e-12);
    double finest = 1e9, coarsest = 0;
    for (int degree = 0; degree < 180; ++degree) {
      const Vec2 half = 0.5 * Vec2(std::cos(degree * kDegree), std::sin(degree * kDegree));
      const double mm = 1e3 * (landed(plan, pixel + half) - landed(plan, pixel - half)).norm();
      finest = std::min(finest, mm), coarsest = std::max(coarsest, mm);
    }
    // Directions in steps of a degree miss the extremes by 1e-4 of their difference at most.
    EXPECT_NEAR(light.mm_per_pixel_min, finest, 3e-4 * coarsest);
    EXPECT_NEAR(light.mm_per_pixel_max, coarsest, 3e-4 * coarsest);
    EXPECT_GE(light.mm_per_pixel_min, plan.mm_per_pixel_min - 1e-9);
    EXPECT_LE(light.mm_per_pixel_max, plan.mm_per_pixel_max + 1e-9);

    const Vec3 lens = plan.projector_from_wall.inverse().translation;
    const Vec3 ray = Vec3(light.on_wall.x(), light.on_wall.y(), 0) - lens;
    EXPECT_NEAR(light.incidence_deg, std::acos(ray.z() / ray.norm()) / kDegree, 1e-9);
    EXPECT_LE(light.incidence_deg, plan.incidence_max_deg + 1e-9);
  }
}

TEST(Planner, SpreadsAllLumensOverThePicture) {
  const ProjectionPlan plan = plan_projection(lopsided_sheet(), lopsided_site());
  Vec2 low = plan.corners[0], high = low;
  for (const Vec2& corner : plan.corners) low = low.cwiseMin(corner), high = high.cwiseMax(corner);
  constexpr int kCells = 300;
  const Vec2 cell = (high - low) / kCells;
  const Vec3 lens = plan.projector_from_wall.inverse().translation;
  const Intrinsics& k = plan.projector.inverse_camera.intrinsics;
  double lumens = 0, darkest = 1e9, brightest = 0;
  for (int j = 0; j < kCells; ++j)
    for (int i = 0; i < kCells; ++i) {
      const Vec2 at = low + cell.cwiseProduct(Vec2(i + 0.5, j + 0.5));
      const Vec3 in_projector = plan.projector_from_wall * Vec3(at.x(), at.y(), 0);
      const auto pixel = plan.projector.project(in_projector);
      if (!pixel || !plan.projector.size().contains(*pixel)) continue;
      const double lux =
          2900 * light_on_wall(plan.projector, plan.projector_from_wall, *pixel).value().lux_per_lumen;
      // intensity * cos(incidence) / r^2 with a pixel's solid angle cos^3 / (fx fy)
      const double r = in_projector.norm(), off_axis = in_projector.z() / r;
      const double intensity = 2900 / (1280.0 * 801) * k.fx * k.fy / std::pow(off_axis, 3);
      ASSERT_NEAR(lux, intensity * (-lens.z() / r) / (r * r), 1e-9 * lux);
      lumens += lux * cell.prod();
      darkest = std::min(darkest, lux), brightest = std::max(brightest, lux);
    }
  EXPECT_NEAR(lumens, 2900, 0.01 * 2900);
  EXPECT_NEAR(plan.lux->darkest, darkest, 0.02 * darkest);
  EXPECT_NEAR(plan.lux->brightest, brightest, 0.02 * brightest);
  EXPECT_LE(plan.lux->darkest, darkest);
  EXPECT_GE(plan.lux->brightest, brightest);
}

TEST(Planner, KeepsTheTextbooksDepthOfField) {
  const DataSheet sheet = lopsided_sheet();
  const ProjectionPlan plan = plan_projection(sheet, lopsided_site());
  const DepthOfField& field = plan.depth_of_field.value();
  // The camera's formulas with a circle of confusion of one pixel on the imager, whose pitch follows from the
  // distance between imager and lens: H = f^2 / (N c) + f, near = s (H - f) / (H + s - 2 f), far likewise.
  const double f = 0.0137, s = field.focus, pitch = f * s / (s - f) / (0.83 * 1280);
  const double h = f * f / (1.9 * pitch) + f;
  EXPECT_NEAR(field.near, s * (h - f) / (h + s - 2 * f), 1e-12);
  EXPECT_NEAR(field.far, s * (h - f) / (h - s), 1e-12);

  // The cone of light between the lens' rim and the focused point, cut at the nearest and farthest corner.
  const double aperture = f / 1.9;
  for (const double z : {field.nearest, field.farthest})
    EXPECT_NEAR(field.blur_max_px, aperture * std::abs(z - s) / s / (z / (0.83 * 1280)), 1e-9);
  std::mt19937_64 random(5);
  for (int trial = 0; trial < 200; ++trial) {
    const double depth =
        light_on_wall(plan.projector, plan.projector_from_wall, random_pixel(random, sheet.resolution))
            ->depth;
    EXPECT_GE(depth, field.nearest - 1e-12);
    EXPECT_LE(depth, field.farthest + 1e-12);
  }

  DataSheet pinhole = sheet;
  pinhole.f_number = 90;
  EXPECT_TRUE(std::isinf(plan_projection(pinhole, lopsided_site()).depth_of_field->far));
}

TEST(Planner, FindsTheLargestRectangleThatBruteForceFinds) {
  std::mt19937_64 random(11);
  for (int trial = 0; trial < 6; ++trial) {
    Site site;
    site.projector_from_wall =
        pose_before_wall(test::uniform(random, 0.8, 3), test::uniform(random, -25, 25) * kDegree,
                         test::uniform(random, -20, 20) * kDegree, test::uniform(random, -30, 30) * kDegree);
    const Vec2 shape(1, test::uniform(random, 0.3, 2));
    site.target = WallTarget{shape, std::nullopt};
    const ProjectionPlan plan = plan_projection(lopsided_sheet(), site);
    EXPECT_TRUE(lit(plan, plan.undistorted));
    EXPECT_NEAR(plan.undistorted.size.y() / plan.undistorted.size.x(), shape.y(), 1e-12);

    // Every centre on a grid, each with the widest rectangle that is still lit.
    Vec2 low = plan.corners[0], high = low;
    for (const Vec2& corner : plan.corners) low = low.cwiseMin(corner), high = high.cwiseMax(corner);
    constexpr int kCells = 80;
    double widest = 0;
    for (int j = 0; j < kCells; ++j)
      for (int i = 0; i < kCells; ++i) {
        const Vec2 centre = low + (high - low).cwiseProduct(Vec2(i + 0.5, j + 0.5)) / kCells;
        if (!lit(plan, WallRectangle{centre, widest * shape})) continue;
        double below = widest, above = (high - low).norm();
        for (int halving = 0; halving < 30; ++halving) {
          const double width = 0.5 * (below + above);
          (lit(plan, WallRectangle{centre, width * shape}) ? below : above) = width;
        }
        widest = below;
      }
    EXPECT_GE(plan.undistorted.size.x(), widest - 1e-5);
    // A centre at most half a cell from the best loses at most a cell's width in each direction.
    EXPECT_LE(plan.undistorted.size.x(), widest + 2 * (high - low).maxCoeff() / kCells);

    // The share of the pixels that light it, by asking pixels.
    int inside = 0;
    for (int n = 0; n < 20000; ++n) {
      const Vec2 off = landed(plan, random_pixel(random, plan.projector.size())) - plan.undistorted.centre;
      inside += (2 * off.cwiseAbs().array() <= plan.undistorted.size.array()).all();
    }
    // Five sigma of 20000 draws: 0.018 at most. Six trials: a false alarm in 3e5 runs over seeds.
    EXPECT_NEAR(plan.undistorted_pixel_share, inside / 20000.0, 0.018);
  }
}

TEST(Planner, CentresARectangleThatCouldSlide) {
  Site site;
  site.projector_from_wall = pose_before_wall(1.66);
  for (const Vec2& shape : {Vec2(1, 1), Vec2(3, 1)}) {
    site.target = WallTarget{shape, std::nullopt};
    const ProjectionPlan plan = plan_projection(lopsided_sheet(), site);
    EXPECT_NEAR((plan.undistorted.centre - plan.middle).norm(), 0, 1e-9);
    EXPECT_NEAR(plan.undistorted.size.x(), std::min(2.0, 2 * 801.0 / 1280 * shape.x()), 1e-9);
  }
}

TEST(Planner, SaysHowMuchOfTheTargetIsLit) {
  Site site = lopsided_site();
  const ProjectionPlan free = plan_projection(lopsided_sheet(), site);
  std::mt19937_64 random(17);
  for (const Vec2& off : {Vec2(0, 0), Vec2(0.6, -0.5), Vec2(-0.7, 0.2), Vec2(9, 9)}) {
    site.target = WallTarget{Vec2(1.1, 0.7), free.undistorted.centre + off};
    const ProjectionPlan plan = plan_projection(lopsided_sheet(), site);
    int hits = 0;
    for (int n = 0; n < 20000; ++n)
      hits += lit(plan, plan.target->rectangle.centre +
                            Vec2(test::uniform(random, -0.55, 0.55), test::uniform(random, -0.35, 0.35)));
    EXPECT_NEAR(plan.target->covered_share, hits / 20000.0, 0.018);  // five sigma
    EXPECT_EQ(plan.target->whole, lit(plan, plan.target->rectangle));
    if (hits < 20000) {
      EXPECT_FALSE(plan.target->whole);
    }
    EXPECT_EQ(plan.diagnostics.find("target_not_covered") == nullptr, plan.target->whole);
  }
  // Without a place it lies where it fits best: a hair smaller than the largest fits, a hair larger does not.
  for (const double factor : {0.999, 1.001}) {
    site.target = WallTarget{Vec2(factor * free.undistorted.size), std::nullopt};
    EXPECT_EQ(plan_projection(lopsided_sheet(), site).target->whole, factor < 1);
  }
}

TEST(Planner, KnowsWhichTextCanBeRead) {
  Site site = lopsided_site();
  ProjectionPlan plan = plan_projection(lopsided_sheet(), site);
  EXPECT_NEAR(plan.readable_text_height(), 9e-3 * plan.mm_per_pixel_max, 1e-12);

  // Where there is a target, its coarsest pixel counts, not that of a far corner of the picture.
  site.target = WallTarget{Vec2(0.9, 1.3), plan.middle + Vec2(0.3, -0.3)};
  plan = plan_projection(lopsided_sheet(), site);
  std::mt19937_64 random(23);
  double coarsest = 0;
  for (int n = 0; n < 20000; ++n) {
    const Vec2 pixel = random_pixel(random, plan.projector.size());
    const LightOnWall light = light_on_wall(plan.projector, plan.projector_from_wall, pixel).value();
    const Vec2 off = light.on_wall - plan.target->rectangle.centre;
    if (std::abs(off.x()) <= 0.45 && std::abs(off.y()) <= 0.65)
      coarsest = std::max(coarsest, light.mm_per_pixel_max);
  }
  EXPECT_GE(plan.readable_text_height(), 9e-3 * coarsest);
  EXPECT_LE(plan.readable_text_height(), 9e-3 * coarsest * 1.01);
  EXPECT_LT(plan.readable_text_height(), 9e-3 * plan.mm_per_pixel_max * 0.9);
  site.target.reset();

  site.viewer_distance = 10;
  plan = plan_projection(lopsided_sheet(), site);
  // 16 minutes of arc: 4.654 mm a metre.
  EXPECT_NEAR(plan.readable_text_height(), 0.04654, 1e-5);
  site.text_height = 0.046;
  EXPECT_NE(plan_projection(lopsided_sheet(), site).diagnostics.find("text_unreadable"), nullptr);
  site.text_height = 0.047;
  EXPECT_EQ(plan_projection(lopsided_sheet(), site).diagnostics.find("text_unreadable"), nullptr);
}

TEST(Planner, WarnsOfGrazingLightAndBlur) {
  DataSheet sheet = lopsided_sheet();
  const Diagnostics good = plan_projection(sheet, Site{pose_before_wall(2), {}, {}, {}}).diagnostics;
  EXPECT_TRUE(good.items.empty());
  Site site;
  site.projector_from_wall = pose_before_wall(2, 45 * kDegree);
  const Diagnostics steep = plan_projection(sheet, site).diagnostics;
  EXPECT_NE(steep.find("grazing"), nullptr);
  EXPECT_NE(steep.find("out_of_focus"), nullptr);
  EXPECT_FALSE(steep.failed());
  sheet.f_number.reset();
  EXPECT_NE(plan_projection(sheet, site).diagnostics.find("depth_of_field_unknown"), nullptr);
  EXPECT_FALSE(plan_projection(sheet, site).depth_of_field);
}

TEST(Planner, RefusesWhatNoProjectorAndNoWallCanBe) {
  const auto refusal = [](const auto& spoil) -> std::string {
    DataSheet sheet = lopsided_sheet();
    Site site = lopsided_site();
    try {
      spoil(sheet, site);
      plan_projection(sheet, site);
    } catch (const Error& error) {
      return std::string(to_string(error.kind())) + ": " + error.subject();
    }
    return "accepted";
  };
  using S = DataSheet;
  EXPECT_EQ(refusal([](S& s, Site&) { s.throw_ratio = 0; }), "input: throw ratio 0");
  EXPECT_EQ(refusal([](S& s, Site&) { s.throw_ratio = -0.8; }), "input: throw ratio -0.8");
  EXPECT_EQ(refusal([](S& s, Site&) { s.throw_ratio = NAN; }), "input: throw ratio -");
  EXPECT_EQ(refusal([](S& s, Site&) { s.resolution.height = 0; }), "input: resolution 1280x0");
  EXPECT_EQ(refusal([](S& s, Site&) { s.lens_shift.y() = INFINITY; }), "input: lens shift");
  EXPECT_EQ(refusal([](S& s, Site&) { s.lumens = -3000; }), "input: light -3000 lm");
  EXPECT_EQ(refusal([](S& s, Site&) { s.f_number = 0; }), "input: f-number 0");
  EXPECT_EQ(refusal([](S& s, Site&) { s.focal_length = -0.01; }), "input: focal length -0.01 m");
  EXPECT_EQ(refusal([](S&, Site& at) { at.viewer_distance = 0; }), "input: viewer distance 0 m");
  EXPECT_EQ(refusal([](S&, Site& at) { at.text_height = 0; }), "input: text height 0 m");
  EXPECT_EQ(refusal([](S&, Site& at) {
              at.target = WallTarget{Vec2(1, 0), {}};
            }),
            "input: target height 0 m");
  EXPECT_EQ(refusal([](S&, Site& at) {
              at.target = WallTarget{Vec2(1, 1), Vec2(NAN, 0)};
            }),
            "input: the target's centre");
  EXPECT_EQ(refusal([](S&, Site&) { pose_before_wall(0); }), "input: distance 0 m");
  EXPECT_EQ(refusal([](S&, Site&) { pose_before_wall(1, NAN); }), "input: the projector's angles");
  EXPECT_EQ(refusal([](S&, Site& at) { at.projector_from_wall.translation.x() = NAN; }),
            "input: the projector's pose");
  EXPECT_EQ(refusal([](S&, Site& at) { at.projector_from_wall = Pose(); }), "input: the projector's pose");
  EXPECT_EQ(refusal([](S&, Site& at) { at.projector_from_wall = pose_before_wall(2, 180 * kDegree); }),
            "degenerate: the picture");
  EXPECT_EQ(refusal([](S&, Site& at) { at.projector_from_wall = pose_before_wall(2, 80 * kDegree); }),
            "degenerate: the picture's corner top right, bottom right");
  EXPECT_EQ(refusal([](S& s, Site&) { s.throw_ratio = 1e303; }), "degenerate: the picture");
  EXPECT_EQ(refusal([](S& s, Site&) { s.lens_shift.x() = 1e200; }), "degenerate: the picture");
}

}  // namespace
}  // namespace procam::analyze
