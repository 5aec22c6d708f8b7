#include "procam/simulate/session.hpp"

#include <algorithm>
#include <cmath>

#include "procam/core/base/closed_form.hpp"
#include "session_recipe.hpp"
#include "sheet_points.hpp"

namespace procam::simulate {
namespace {

using internal::draw;
using internal::make_rig;
using internal::Random;
using internal::Recipe;
using internal::recipe_of;
using internal::recipes;
using internal::vary;

/// How a sheet is put before the rig: where its middle falls, and how it is turned.
struct Placing {
  double distance = 0;        ///< of the middle from the camera
  double tilt_direction = 0;  ///< radians
  Vec3 middle_in_board;
  Eigen::AlignedBox2d on_pixels;  ///< the middle lies on the light of one of these
  double roll_deg = 25;
};

/// A sheet in a random pose, facing the camera up to a tilt.
std::optional<Pose> draw_pose(const Recipe& recipe, const World& world, const Placing& placing,
                              Random& random) {
  const RigProjector& device = world.rig.projector();
  const Vec2 low = placing.on_pixels.min(), high = placing.on_pixels.max();
  const double pixel_x = random.uniform(low.x(), high.x()), pixel_y = random.uniform(low.y(), high.y());
  const Vec2 pixel(pixel_x, pixel_y);
  const double tilt = random.uniform(0.3, 1.0) * recipe.tilt_deg * kDegree;
  const double roll = random.uniform(-placing.roll_deg, placing.roll_deg) * kDegree;
  const std::optional<Ray> ray_in_projector = device.projector.emit(pixel);
  if (!ray_in_projector) return std::nullopt;
  const Ray ray = device.rig_from_projector * *ray_in_projector;
  // |origin + s direction| = distance
  const double b = ray.origin.dot(ray.direction);
  const double root = b * b - ray.origin.squaredNorm() + placing.distance * placing.distance;
  if (root < 0) return std::nullopt;
  const Vec3 center = ray.at(-b + std::sqrt(root));
  const Vec3 sight = center.normalized();
  const Eigen::Quaterniond facing = rotation_between(Vec3::UnitZ(), sight);
  const Vec3 axis = facing * Vec3(std::cos(placing.tilt_direction), std::sin(placing.tilt_direction), 0);
  const Eigen::Quaterniond rotation = Eigen::Quaterniond(Eigen::AngleAxisd(tilt, axis)) *
                                      Eigen::Quaterniond(Eigen::AngleAxisd(roll, sight)) * facing;
  return Pose(rotation, center - rotation * placing.middle_in_board);
}

constexpr double kRimPx = 6;  // what matters keeps this far from a picture's rim

bool inside(const Camera& device, const Vec3& point) {
  const std::optional<Vec2> p = device.project(point);
  return p && p->x() >= kRimPx && p->y() >= kRimPx && p->x() <= device.size.width - 1 - kRimPx &&
         p->y() <= device.size.height - 1 - kRimPx;
}

/// Print towards camera and projector, not too flat.
bool faces_both(const World& world) {
  for (const Pose& rig_from_device :
       {world.rig.camera().rig_from_camera, world.rig.projector().rig_from_projector}) {
    const Vec3 eye_in_board = world.rig_from_board.inverse() * rig_from_device.translation;
    if (eye_in_board.z() > -0.5 * eye_in_board.norm()) return false;
  }
  return true;
}

Points3 print_corners(const World& world, double margin) {
  PrintedBoard print = world.board;
  print.margin = margin;
  print.blank.setZero();
  return sheet_corners_in_board(print);
}

/// How much of a board a view shows.
enum class Shown {
  kAll,         ///< the sheet wholly on the camera's image, all of the print lit
  kPartlyLit,   ///< the sheet wholly on the camera's image, 50 .. 90 % of the points lit
  kPartlySeen,  ///< 40 .. 85 % of the points on the camera's image, 35 % or more of all both seen and lit
};

bool is_usable(const World& world, Shown shown) {
  if (!faces_both(world)) return false;
  const double all = double(points_in_board(world.board.layout).size());
  const std::vector<Observation> lit = board_in_projector(world);
  if (shown == Shown::kPartlySeen) {
    const std::vector<Observation> seen = board_in_camera(world);
    const auto both = std::count_if(seen.begin(), seen.end(), [&](const Observation& s) {
      return std::any_of(lit.begin(), lit.end(), [&](const Observation& l) { return l.point == s.point; });
    });
    const double share = double(seen.size()) / all;
    return share >= 0.4 && share <= 0.85 && double(both) >= 0.35 * all;
  }
  const RigCamera& camera = world.rig.camera();
  const RigProjector& projector = world.rig.projector();
  const Pose camera_from_board = camera.rig_from_camera.inverse() * world.rig_from_board;
  const Pose projector_from_board = projector.rig_from_projector.inverse() * world.rig_from_board;
  for (const Vec3& corner : sheet_corners_in_board(world.board))
    if (!inside(camera.camera, camera_from_board * corner)) return false;
  if (shown == Shown::kPartlyLit) {
    const double share = double(lit.size()) / all;
    return share >= 0.5 && share <= 0.9;
  }
  for (const Vec3& corner : print_corners(world, 0))
    if (!inside(projector.projector.inverse_camera, projector_from_board * corner)) return false;
  return true;
}

/// Print with its margin on the camera's image (or only a part of it); the box of projector pixels on blank
/// paper that the camera sees.
bool is_usable(const World& world, const Eigen::AlignedBox2d& on_blank_paper, Shown shown) {
  if (!faces_both(world)) return false;
  const RigCamera& camera = world.rig.camera();
  const Pose camera_from_board = camera.rig_from_camera.inverse() * world.rig_from_board;
  const Points3 print = print_corners(world, world.board.margin);
  if (shown == Shown::kPartlySeen) {
    const double share =
        double(board_in_camera(world).size()) / double(points_in_board(world.board.layout).size());
    if (share < 0.4 || share > 0.85) return false;
  } else {
    for (const Vec3& corner : print)
      if (!inside(camera.camera, camera_from_board * corner)) return false;
  }
  for (int i = 0; i < 4; ++i) {
    const Vec2 pixel = on_blank_paper.corner(Eigen::AlignedBox2d::CornerType(i));
    const std::optional<Vec2> place = light_on_sheet(world, pixel);
    if (!place || place->x() < print[1].x()) return false;
    if (!inside(camera.camera, camera_from_board * Vec3(place->x(), place->y(), 0))) return false;
  }
  return true;
}

/// Sessions with blank paper: room light strong enough to read a print that lies outside the projector's
/// picture, and an exposure that spares the middle of a sheet that is brighter there than at its corners.
constexpr double kLitRoom = 0.25;
constexpr double kExposureShare = 0.75;
constexpr int kViewsOfLightPoints = 18;
/// Of boards whose markers say which point is which.
constexpr int kPartlySeenEvery = 3;
constexpr double kNearer = 0.6;
/// They reach a little farther: light and print must both fit the camera's image.
constexpr double kReach = 1.25;

/// Paper beside the print for a box of projector pixels at all but the farthest distances.
void add_blank_paper(const Recipe& recipe, World& world, const Eigen::AlignedBox2d& box) {
  const Intrinsics& k = recipe.projector.intrinsics;
  const double reach = kReach * recipe.farthest;
  const double width = box.sizes().x() / k.fx * reach, height = box.sizes().y() / k.fy * reach;
  const ArtworkRectangle print = print_of(world.board.layout);
  const double print_height = print.high.y() - print.low.y() + 2 * world.board.margin;
  world.board.blank = Vec2(width, std::max(0.0, height - print_height));
  world.ambient = std::max(world.ambient, kLitRoom);
}

/// 2 J1(x) / x by its power series, for x up to 4: the contrast that a disc of radius r leaves of a sine of
/// period p is that of x = 2 pi r / p.
double disc_transfer(double x) {
  double term = 1, sum = 1;
  for (int k = 1; k < 20; ++k) {
    term *= -0.25 * x * x / (double(k) * (k + 1));
    sum += term;
  }
  return sum;
}

/// The lens that leaves this contrast of stripes of two pixels at the depth that is most out of focus.
ThinLens defocused_lens(double finest_contrast, double focus, double nearest, double farthest,
                        double focal_px, double blur_px) {
  constexpr double kPeriod = 4;
  // Samples 1, 1, 0, 0, linear between: the fundamental's amplitude by its mean; a Gaussian's transfer.
  const double in_focus = 1.146 * std::exp(-2 * kPi * kPi * blur_px * blur_px / (kPeriod * kPeriod));
  double low = 0, high = 3.8;  // before the first zero of the disc's transfer
  for (int i = 0; i < 50; ++i) {
    const double middle = 0.5 * (low + high);
    (in_focus * disc_transfer(middle) > finest_contrast ? low : high) = middle;
  }
  const double radius = low * kPeriod / (2 * kPi);
  const double off_focus = std::max(std::abs(1 / nearest - 1 / focus), std::abs(1 / farthest - 1 / focus));
  return {2 * radius / (focal_px * off_focus), focus};
}

void check(const Conditions& c) {
  require(c.finest_contrast > 0 && c.finest_contrast <= 1, "make_session: finest_contrast not in (0, 1]");
  require(c.gamma.low > 0 && c.white.low > 0 && c.overexposure > 0 && c.print_scale > 0 &&
              c.noise_factor >= 0 && c.moved_by.low >= 0,
          "make_session: gamma, white, overexposure, print_scale, noise_factor or moved_by out of range");
  require(c.views >= 0 && c.dark_views >= 0 && c.overexposed_views >= 0 && c.moved_views >= 0 &&
              c.stale_views >= 0 && c.missing_views >= 0 && c.torn_views >= 0,
          "make_session: a negative number of views");
  require(std::abs(c.lateral_colour) < 0.1, "make_session: lateral_colour not in (-0.1, 0.1)");
  require(c.camera_deviation_px >= 0 && c.projector_deviation_px >= 0,
          "make_session: camera_deviation_px or projector_deviation_px negative");
  require(c.flex >= 0 && c.flex <= 0.1, "make_session: flex not in [0, 0.1] metres");
  require(c.refocus >= 0 && c.refocus <= 0.05 && c.stabiliser_px >= 0 && c.stabiliser_px <= 100,
          "make_session: refocus not in [0, 0.05], or stabiliser_px not in [0, 100]");
  require(c.lag >= 0 && c.lag < 1 && c.iris >= 0 && c.projector_gamma > 0,
          "make_session: lag not in [0, 1), negative iris, or projector_gamma not above 0");
}

/// Mostly along the sheet, as by a hand.
Pose draw_move(const Range& distance, Random& random) {
  const double direction = random.uniform(0, 2 * kPi), out = random.uniform(-0.3, 0.3);
  const double length = random.uniform(distance.low, distance.high);
  const Vec3 along = Vec3(std::cos(direction), std::sin(direction), out).normalized();
  const double x = random.uniform(-1, 1), y = random.uniform(-1, 1), z = random.uniform(-1, 1);
  const Vec3 axis = Vec3(x, y, z + 2).normalized();
  constexpr double kAnglePerLength = 100 * kDegree;  // 0.1 degrees a millimetre
  return Pose(Eigen::Quaterniond(Eigen::AngleAxisd(kAnglePerLength * length, axis)), length * along);
}

/// Every kind of mistake in views of its own, as far as there are views; a dark view may be partly lit too.
std::vector<ViewDefects> draw_defects(const Conditions& c, int views, Random& random) {
  std::vector<int> order;
  for (int i = 0; i < views; ++i) order.push_back(i);
  for (int i = views - 1; i > 0; --i)
    std::swap(order[std::size_t(i)], order[std::size_t(random.uniform(0, i + 1))]);
  std::vector<ViewDefects> defects(static_cast<std::size_t>(views));
  std::size_t next = 0;
  const auto in_views = [&](int count, const auto& spoil) {
    for (int i = 0; i < count && next < order.size(); ++i) spoil(defects[std::size_t(order[next++])]);
  };
  in_views(c.moved_views, [&](ViewDefects& d) {
    const double share = random.uniform(0.15, 0.85);
    d.moved = ViewDefects::Move{share, draw_move(c.moved_by, random)};
  });
  in_views(c.stale_views, [&](ViewDefects& d) { d.stale = random.uniform(0.1, 0.9); });
  in_views(c.missing_views, [&](ViewDefects& d) { d.missing = random.uniform(0.1, 0.9); });
  in_views(c.torn_views, [&](ViewDefects& d) { d.torn = random.uniform(0.02, 0.3); });
  in_views(c.overexposed_views, [&](ViewDefects& d) { d.white = c.overexposure; });
  in_views(c.dark_views, [&](ViewDefects& d) { d.white = draw(c.white, random); });
  return defects;
}

BoardArtwork scaled(BoardArtwork artwork, double factor) {
  const auto scale = [&](ArtworkRectangle& r) { r.low *= factor, r.high *= factor; };
  for (ArtworkRectangle& rectangle : artwork.rectangles) scale(rectangle);
  for (ArtworkDisc& disc : artwork.discs) disc.centre *= factor, disc.radius *= factor;
  scale(artwork.sheet);
  return artwork;
}

/// Of a cylinder about an axis of any direction that rises by this half a metre from its middle.
Vec3 curvature_of(double rise, Random& random) {
  const double axis = random.uniform(0, 2 * kPi);
  const Vec2 across(std::cos(axis), std::sin(axis));
  const double curvature = 8 * rise;  // of a parabola: rise = curvature (0.5 m)^2 / 2
  return curvature * Vec3(across.x() * across.x(), across.x() * across.y(), across.y() * across.y());
}

double draw_with_rms(double rms, Random& random) {
  return std::sqrt(3.0) * rms * random.uniform(-1, 1);
}

/// The camera's lens as each view's focus and stabiliser have it; empty without these. A lens that is focused magnifies the
/// image about a point beside the principal point.
std::vector<Camera> lenses_by_view(const Camera& lens, const Conditions& conditions, int views,
                                   Random random) {
  std::vector<Camera> lenses;
  if (conditions.refocus == 0 && conditions.stabiliser_px == 0) return lenses;
  constexpr double kOffCentre = 0.04;  // of the image's width
  const double right = random.uniform(-1, 1), below = random.uniform(-1, 1);
  const Vec2 off_centre = kOffCentre * lens.size.width * Vec2(right, below);
  for (int view = 0; view < views; ++view) {
    const double longer = draw_with_rms(conditions.refocus, random);
    const double x = draw_with_rms(conditions.stabiliser_px, random);
    const double y = draw_with_rms(conditions.stabiliser_px, random);
    Intrinsics k = lens.intrinsics;
    k.fx *= 1 + longer, k.fy *= 1 + longer, k.skew *= 1 + longer;
    k.cx += x - longer * off_centre.x();
    k.cy += y - longer * off_centre.y();
    lenses.push_back({lens.size, k, lens.distortion});
  }
  return lenses;
}

/// The board as it was printed, the rig, and a wall behind both.
World make_world(const Recipe& recipe, const std::optional<Eigen::AlignedBox2d>& on_blank_paper,
                 const std::optional<BoardPrint>& print, const Conditions& conditions, Random& random,
                 Random& random_conditions, Random& random_bend) {
  World world;
  world.board = recipe.board;
  if (print) {
    world.board.layout = print->layout;
    world.board.artwork = print->artwork;
  }
  if (conditions.print_scale != 1) {
    world.board.layout = procam::scaled(world.board.layout, conditions.print_scale);
    world.board.artwork = scaled(world.board.artwork, conditions.print_scale);
  }
  const double rise = draw(conditions.bend, random_bend);
  world.board.sheet = {curvature_of(rise, random_bend), middle_of_print(world.board.layout).head<2>()};
  // Print and light share the camera's image: the light's place is half a print right of the axis.
  const ArtworkRectangle dark = print_of(world.board.layout);
  const double print_width = dark.high.x() - dark.low.x() + 2 * world.board.margin;
  world.rig = make_rig(recipe, on_blank_paper ? 0.5 * print_width : 0, conditions, random, random_conditions);
  world.ambient = recipe.ambient;
  const Vec3 wall_normal = vary(Vec3(0.08, -0.05, -1), 0.03, random).normalized();
  world.wall_in_rig = {wall_normal, -wall_normal.z() * (recipe.farthest + 0.7)};
  if (on_blank_paper) add_blank_paper(recipe, world, *on_blank_paper);
  return world;
}

CaptureOptions make_capture(const Recipe& recipe, const Conditions& conditions, bool on_blank_paper,
                            std::uint64_t seed, Random& random_conditions) {
  CaptureOptions capture = recipe.capture;
  capture.seed = seed;
  capture.gamma = draw(conditions.gamma, random_conditions);
  capture.vignetting = conditions.vignetting;
  capture.indirect = conditions.indirect;
  capture.glare = conditions.glare;
  if (conditions.noise) capture.noise = *conditions.noise;
  capture.noise.at_black *= conditions.noise_factor * conditions.noise_factor;
  capture.noise.per_level *= conditions.noise_factor * conditions.noise_factor;
  const double focus_share = random_conditions.uniform(0.35, 0.65);
  if (conditions.finest_contrast < 1) {
    const double nearest = 0.9 * recipe.nearest;
    const double farthest = (on_blank_paper ? kReach : 1.1) * recipe.farthest;
    const double focus = 1 / (focus_share / nearest + (1 - focus_share) / farthest);
    capture.projector_lens = defocused_lens(conditions.finest_contrast, focus, nearest, farthest,
                                            recipe.projector.intrinsics.fx, capture.projector_blur_px);
  }
  if (on_blank_paper) capture.brightest_grey *= kExposureShare;
  return capture;
}

/// Which part of the board goes onto which pixels of the projector.
Placing make_placing(const Recipe& recipe, const World& world,
                     const std::optional<Eigen::AlignedBox2d>& on_blank_paper) {
  Placing placing;
  const ImageSize projector_size = recipe.projector.size;
  placing.middle_in_board = middle_of_print(world.board.layout);
  placing.on_pixels = {Vec2(0, 0), Vec2(projector_size.width - 1.0, projector_size.height - 1.0)};
  if (on_blank_paper) {
    const Vec3 right = print_corners(world, world.board.margin)[1];
    const Points3 sheet = sheet_corners_in_board(world.board);
    placing.middle_in_board = 0.5 * (right + sheet[2]);
    const Vec2 near_middle = 0.1 * on_blank_paper->sizes();
    placing.on_pixels = {on_blank_paper->center() - near_middle, on_blank_paper->center() + near_middle};
    placing.roll_deg = 10;
  }
  return placing;
}

/// Moves the world's board until the view is usable; false when no such pose is found.
bool place_board(const Recipe& recipe, const std::optional<Eigen::AlignedBox2d>& on_blank_paper, Shown shown,
                 Placing placing, World& world, Random& random) {
  constexpr int kTries = 20000;
  const double tilt_direction = placing.tilt_direction;
  for (int i = 0; i < kTries; ++i) {
    if (on_blank_paper) {
      // Not every distance and tilt leaves room for print and light in the camera's image: search wider
      // and wider.
      placing.distance = random.uniform(recipe.nearest, kReach * recipe.farthest);
      placing.tilt_direction = tilt_direction + kPi * i / kTries * random.uniform(-1, 1);
    } else if (shown == Shown::kPartlySeen) {
      // Light that reaches the rim of the camera's image is near.
      placing.distance = random.uniform(kNearer * recipe.nearest, recipe.farthest);
    }
    const std::optional<Pose> pose = draw_pose(recipe, world, placing, random);
    if (!pose) continue;
    world.rig_from_board = *pose;
    if (on_blank_paper ? is_usable(world, *on_blank_paper, shown) : is_usable(world, shown)) return true;
  }
  return false;
}

}  // namespace

Conditions level_conditions(Level level) {
  Conditions c;
  if (level == Level::kEasy) return c;
  c.camera_skew_px = c.projector_skew_px = Range{1, 5, true};
  c.camera_k3 = Range{0.01, 0.03, true};
  c.projector_k3 = Range{0.02, 0.06, true};
  c.gamma = {1.8, 2.2};
  c.vignetting = 4;
  c.indirect = 0.1;
  c.glare = 0.04;
  c.finest_contrast = 0.2;
  // A full well of 8000 and of 2500 electrons, read noise of 0.3 % and 0.6 % of full scale.
  c.noise = NoiseModel{0.6, 0.032};
  if (level == Level::kPaper) return c;
  c.noise = NoiseModel{2.3, 0.10};
  c.camera_k3 = Range{0.005, 0.015};  // the other sign would fold this lens inside its image
  c.views = 12;
  c.dark_views = 4;
  c.overexposed_views = c.moved_views = c.stale_views = 1;
  return c;
}

const char* to_string(Level level) {
  return recipe_of(level).name;
}

Level level_named(const std::string& name) {
  for (const Recipe& recipe : recipes())
    if (name == recipe.name) return recipe.level;
  throw Error(ErrorKind::kUnsupported, "level '" + name + "'", "there is no such level",
              "use easy, paper or hard");
}

ImageSize projector_size(Level level) {
  return recipe_of(level).projector.size;
}

SimulatedSession make_session(Level level, std::uint64_t seed,
                              const std::optional<Eigen::AlignedBox2d>& on_blank_paper,
                              const std::optional<BoardPrint>& print) {
  return make_session(level, seed, on_blank_paper, print, level_conditions(level));
}

SimulatedSession make_session(Level level, std::uint64_t seed,
                              const std::optional<Eigen::AlignedBox2d>& on_blank_paper,
                              const std::optional<BoardPrint>& print, const Conditions& conditions) {
  check(conditions);
  const Recipe& recipe = recipe_of(level);
  Random random(seed, std::uint64_t(level), 0);
  Random random_conditions(seed, std::uint64_t(level), 11);  // the poses do not depend on conditions
  Random random_bend(seed, std::uint64_t(level), 12);
  World world = make_world(recipe, on_blank_paper, print, conditions, random, random_conditions, random_bend);
  world.camera_deviation = LensDeviation(world.rig.camera().camera, conditions.camera_deviation_px, 2 * seed);
  world.projector_deviation = LensDeviation(world.rig.projector().projector.inverse_camera,
                                            conditions.projector_deviation_px, 2 * seed + 1);

  SimulatedSession session;
  session.level = level;
  session.stated_board = print ? print->layout : recipe.board.layout;
  session.conditions = conditions;
  session.capture = make_capture(recipe, conditions, on_blank_paper.has_value(), seed, random_conditions);
  Placing placing = make_placing(recipe, world, on_blank_paper);
  // Golden sections spread distances and tilt directions evenly, however many views there are.
  const double distance_start = random.uniform(0, 1), tilt_start = random.uniform(0, 1);
  const int views = on_blank_paper         ? kViewsOfLightPoints
                    : conditions.views > 0 ? conditions.views
                                           : recipe.views;
  session.defects = draw_defects(conditions, views, random_conditions);
  Random random_flex(seed, std::uint64_t(level), 13);
  const Vec3 common_curvature = world.board.sheet.curvature;
  for (int view = 0; view < views; ++view) {
    const double rise = draw_with_rms(conditions.flex, random_flex);
    world.board.sheet.curvature = common_curvature + curvature_of(rise, random_flex);
    const double turn = distance_start + view * 0.6180339887498949;
    placing.distance = recipe.nearest + (recipe.farthest - recipe.nearest) * (turn - std::floor(turn));
    placing.tilt_direction = 2 * kPi * (tilt_start + view * 0.3819660112501051);
    const bool partly_lit =
        recipe.partly_lit_every > 0 && view % recipe.partly_lit_every == recipe.partly_lit_every - 1;
    const bool partly_seen = is_coded(world.board.layout) && view % kPartlySeenEvery == 1;
    const Shown shown = partly_seen ? Shown::kPartlySeen : partly_lit ? Shown::kPartlyLit : Shown::kAll;
    if (!place_board(recipe, on_blank_paper, shown, placing, world, random))
      throw Error(ErrorKind::kNotConverged,
                  "simulated session of level " + std::string(recipe.name) + ", view " + std::to_string(view),
                  "no board pose that camera and projector both cover was found",
                  print ? "use a smaller board or another seed" : "use another seed");
    session.views.push_back(world);
  }
  session.lenses =
      lenses_by_view(world.rig.camera().camera, conditions, views, Random(seed, std::uint64_t(level), 14));
  return session;
}

}  // namespace procam::simulate
