#include "procam/simulate/session.hpp"

#include <algorithm>
#include <cmath>

#include "noise.hpp"
#include "procam/core/base/closed_form.hpp"
#include "sheet_points.hpp"

namespace procam::simulate {
namespace {

using internal::Random;

struct Lens {
  ImageSize size;
  Intrinsics intrinsics;
  std::array<double, 5> distortion;  ///< k1 k2 p1 p2 k3
};

/// What a level is, before the seed moves it.
struct Recipe {
  Level level;
  const char* name;
  Lens camera, projector;
  Vec3 projector_in_camera;
  PrintedBoard board;
  int views;
  double nearest, farthest;  ///< camera to board centre, metres
  double tilt_deg;           ///< largest, against the line of sight
  int partly_lit_every;      ///< every such view has points outside the projector's picture; 0: none
  double ambient;
  CaptureOptions capture;
};

CaptureOptions captured(double brightest_grey, double camera_blur_px, double projector_blur_px,
                        NoiseModel noise) {
  CaptureOptions options;
  options.brightest_grey = brightest_grey;
  options.camera_blur_px = camera_blur_px;
  options.projector_blur_px = projector_blur_px;
  options.noise = noise;
  return options;
}

const std::vector<Recipe>& recipes() {
  static const std::vector<Recipe> table{
      {Level::kEasy,
       "easy",
       {{1280, 1024}, {1400, 1406, 652, 498, 0}, {-0.03, 0.01, 0.0004, -0.0003, 0}},
       {{1024, 768}, {1500, 1507, 528, 402, 0}, {0.01, -0.005, 0.0002, 0.0003, 0}},
       Vec3(0.27, -0.09, 0.04),
       {Chessboard{10, 7, 0.030}, 0.03, 0.80, 0.06},
       8,
       0.8,
       1.6,
       35,
       0,
       0.01,
       captured(210, 0.4, 0.2, {0.25, 0.002})},
      {Level::kPaper,
       "paper",
       {{1280, 960}, {1052, 1047, 633, 491, 0}, {0.06, -0.12, 0.0010, -0.0007, 0}},
       {{1024, 768}, {2010, 2003, 671, 696, 0}, {-0.04, 0.02, 0.0005, 0.0008, 0}},
       Vec3(0.32, 0.12, -0.08),
       {Chessboard{9, 6, 0.036}, 0.036, 0.80, 0.06},
       10,
       1.2,
       2.2,
       40,
       0,
       0.02,
       captured(200, 0.8, 0.4, {2.5, 0.015})},
      {Level::kHard,
       "hard",
       {{1280, 1024}, {905, 913, 668, 489, 0.6}, {-0.25, 0.08, 0.0012, -0.0009, 0}},
       {{1024, 768}, {1480, 1493, 489, 845, 0.8}, {-0.10, 0.03, -0.0006, 0.0010, 0}},
       Vec3(-0.35, 0.16, 0.10),
       {Chessboard{7, 9, 0.034}, 0.034, 0.62, 0.10},
       6,
       0.8,
       1.4,
       40,
       3,
       0.08,
       captured(170, 1.2, 1.0, {8, 0.08})},
  };
  return table;
}

const Recipe& recipe_of(Level level) {
  for (const Recipe& recipe : recipes())
    if (recipe.level == level) return recipe;
  throw std::invalid_argument("simulate: no recipe for this level");
}

/// Takes as many random numbers from any range, so that one condition does not move the others.
double draw(const Range& range, Random& random) {
  const double size = random.uniform(range.low, range.high), sign = random.uniform(-1, 1);
  return range.either_sign && sign < 0 ? -size : size;
}

Camera vary(const Lens& lens, Random& random) {
  Intrinsics k = lens.intrinsics;
  const double zoom = random.uniform(0.97, 1.03);  // both focal lengths: pixels stay almost square
  k.fx *= zoom * random.uniform(0.998, 1.002);
  k.fy *= zoom * random.uniform(0.998, 1.002);
  k.cx += random.uniform(-0.015, 0.015) * lens.size.width;
  k.cy += random.uniform(-0.015, 0.015) * lens.size.height;
  k.skew *= random.uniform(0.5, 1.5);
  BrownConrady distortion{lens.distortion};
  for (double& c : distortion.coefficients) c *= random.uniform(0.8, 1.2);
  return {lens.size, k, distortion};
}

Vec3 vary(const Vec3& v, double by, Random& random) {
  const double x = random.uniform(-by, by), y = random.uniform(-by, by), z = random.uniform(-by, by);
  return v + Vec3(x, y, z);
}

/// Terms that the recipe's lens does not have.
Camera with_more_terms(Camera lens, const std::optional<Range>& skew_px, const std::optional<Range>& k3,
                       Random& random) {
  const double drawn_skew = draw(skew_px.value_or(Range{}), random),
               drawn_k3 = draw(k3.value_or(Range{}), random);
  if (skew_px) lens.intrinsics.skew = drawn_skew;
  if (k3) std::get<BrownConrady>(lens.distortion).coefficients[4] = drawn_k3;
  return lens;
}

/// Camera and projector look at the same point: the middle of the projected frame falls on the camera's axis
/// in the middle of the working distances, or `offset` metres right of it.
Rig make_rig(const Recipe& recipe, double offset, const Conditions& conditions, Random& random,
             Random& random_terms) {
  Rig rig;
  const Camera camera = with_more_terms(vary(recipe.camera, random), conditions.camera_skew_px,
                                        conditions.camera_k3, random_terms);
  rig.cameras.push_back({"camera", camera, Pose::identity()});
  const Projector projector{with_more_terms(vary(recipe.projector, random), conditions.projector_skew_px,
                                            conditions.projector_k3, random_terms)};
  const Vec3 position = vary(recipe.projector_in_camera, 0.03, random);
  const Vec3 target = vary(Vec3(offset, 0, 0.5 * (recipe.nearest + recipe.farthest)), 0.04, random);
  const Vec2 middle(0.5 * (projector.size().width - 1), 0.5 * (projector.size().height - 1));
  const std::optional<Ray> ray = projector.emit(middle);
  require(ray.has_value(), "simulate: the recipe's projector lens does not reach its picture's middle");
  const Vec3 aim = (target - position).normalized();
  const Eigen::Quaterniond roll(Eigen::AngleAxisd(random.uniform(-3, 3) * kDegree, aim));
  rig.projectors.push_back(
      {"projector", projector, Pose(roll * rotation_between(ray->direction, aim), position)});
  return rig;
}

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

Vec3 middle_of_print(const Board& layout) {
  const ArtworkRectangle print = print_of(layout);
  return (Vec3() << 0.5 * (print.low + print.high), 0).finished();
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

/// Light moved over the projected frame, linear between pixels; dark comes in from beyond its border.
ImageU8 moved_frame(const ImageU8& frame, const Vec2& shift) {
  ImageU8 moved(frame.size(), frame.channels());
  const int dx = int(std::floor(shift.x())), dy = int(std::floor(shift.y()));
  const double left = shift.x() - dx, top = shift.y() - dy;
  for (int y = 0; y < frame.height(); ++y)
    for (int x = 0; x < frame.width(); ++x)
      for (int channel = 0; channel < frame.channels(); ++channel) {
        const auto at = [&](int u, int v) {
          return u < 0 || v < 0 || u >= frame.width() || v >= frame.height()
                     ? 0.0
                     : double(frame.at(u, v, channel));
        };
        const int u = x - dx, v = y - dy;
        moved.at(x, y, channel) =
            std::uint8_t((1 - top) * ((1 - left) * at(u, v) + left * at(u - 1, v)) +
                         top * ((1 - left) * at(u, v - 1) + left * at(u - 1, v - 1)) + 0.5);
      }
  return moved;
}

double mean(const ImageU8& image) {
  double sum = 0;
  const std::ptrdiff_t count = std::ptrdiff_t(image.width()) * image.height() * image.channels();
  for (std::ptrdiff_t i = 0; i < count; ++i) sum += image.data()[i];
  return sum / double(count);
}

/// The conditions' faults of a view's sequence.
void add_faults(const SimulatedSession& session, std::size_t view, CaptureOptions& options,
                std::vector<ImageU8>& shown) {
  const Conditions& c = session.conditions;
  const World& world = session.views[view];
  Random random(session.capture.seed, view, 3);
  const auto normal = [&] {
    double sum = -6;
    for (int i = 0; i < 12; ++i) sum += random.uniform(0, 1);
    return sum;
  };
  const double angle = random.uniform(0, 2 * kPi);
  const Vec2 direction(std::cos(angle), std::sin(angle));
  if (c.spot > 0) {
    options.spot = c.spot;
    const double x = random.uniform(0.3, 0.7), y = random.uniform(0.3, 0.7);
    const ArtworkRectangle print = print_of(world.board.layout);
    const Vec2 on_board = print.low + Vec2(x, y).cwiseProduct(print.high - print.low);
    const auto pixel =
        world.rig.camera().camera.project(world.rig.camera().rig_from_camera.inverse() *
                                          (world.rig_from_board * Vec3(on_board.x(), on_board.y(), 0)));
    if (pixel) options.spot_at = *pixel;
  }
  const std::size_t count = shown.size();
  if (c.auto_exposure > 0 || c.flicker > 0 || c.shake_px > 0 || c.drift_px > 0 || c.focus_drift_px > 0)
    options.faults.resize(count);
  for (std::size_t i = 0; i < options.faults.size(); ++i) {
    FrameFault& fault = options.faults[i];
    const double left = count > 1 ? 1 - double(i) / double(count - 1) : 0;
    const double shake_x = normal(), shake_y = normal();
    fault.shift_px = c.shake_px * Vec2(shake_x, shake_y) + left * c.drift_px * direction;
    fault.blur_px = left * c.focus_drift_px;
    // A frame's share of full light, and a tenth of it from the room.
    const double light = (mean(shown[i]) / 255 + 0.1) / 1.1;
    fault.gain =
        std::pow(light, -c.auto_exposure) * (1 + c.flicker * std::sin(2 * kPi * random.uniform(0, 1)));
    fault.ripple = c.flicker;
    fault.ripple_phase = random.uniform(0, 1);
  }
  if (c.projector_drift_px > 0)
    for (std::size_t i = 0; i + 1 < count; ++i)
      shown[i] =
          moved_frame(shown[i], (1 - double(i) / double(count - 1)) * c.projector_drift_px * direction);
}

BoardArtwork scaled(BoardArtwork artwork, double factor) {
  const auto scale = [&](ArtworkRectangle& r) { r.low *= factor, r.high *= factor; };
  for (ArtworkRectangle& rectangle : artwork.rectangles) scale(rectangle);
  for (ArtworkDisc& disc : artwork.discs) disc.centre *= factor, disc.radius *= factor;
  scale(artwork.sheet);
  return artwork;
}

/// The board as it was printed, the rig, and a wall behind both.
World make_world(const Recipe& recipe, const std::optional<Eigen::AlignedBox2d>& on_blank_paper,
                 const std::optional<BoardPrint>& print, const Conditions& conditions, Random& random,
                 Random& random_conditions) {
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
  World world = make_world(recipe, on_blank_paper, print, conditions, random, random_conditions);

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
  for (int view = 0; view < views; ++view) {
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
  return session;
}

std::vector<ImageU8> capture_view(const SimulatedSession& session, std::size_t view,
                                  const std::vector<ImageU8>& frames) {
  require(view < session.views.size(), "capture_view: there is no view " + std::to_string(view));
  CaptureOptions options = session.capture;
  options.seed = Random(session.capture.seed, view, 1).next();
  std::vector<ImageU8> shown = frames;
  add_faults(session, view, options, shown);
  const ViewDefects defects = session.defects.empty() ? ViewDefects{} : session.defects.at(view);
  if (defects.white) options.brightest_grey = 255 * *defects.white;
  const int count = int(frames.size());
  if (defects.missing && count > 1)
    for (int i = frame_at(*defects.missing, count); i + 1 < count; ++i)
      shown[std::size_t(i)] = shown[std::size_t(i + 1)];
  if (defects.stale && count > 1) {
    const auto stale = std::size_t(frame_at(*defects.stale, count));
    shown[stale] = shown[stale - 1];
  }
  const World& world = session.views[view];
  if (defects.torn && count > 1) {
    std::vector<ImageU8> captures = capture(world, shown, options);
    const auto next = std::size_t(frame_at(*defects.torn, count));
    if (!options.faults.empty()) options.faults = {options.faults[next]};
    options.seed = Random(options.seed, 2, 0).next();
    const ImageU8 later = capture(world, {shown[next]}, options).front();
    // Through the board, wherever it is.
    const auto middle =
        world.rig.camera().camera.project(world.rig.camera().rig_from_camera.inverse() *
                                          (world.rig_from_board * middle_of_print(world.board.layout)));
    const int from = middle ? int(middle->y()) : later.height() / 2;
    for (int y = from; y < later.height(); ++y)
      std::copy_n(later.row(y), later.width() * later.channels(), captures[next - 1].row(y));
    return captures;
  }
  if (!defects.moved || count < 2) return capture(world, shown, options);
  const std::ptrdiff_t first_moved = frame_at(defects.moved->share, count);
  std::vector<FrameFault> later_faults;
  if (!options.faults.empty()) {
    later_faults.assign(options.faults.begin() + first_moved, options.faults.end());
    options.faults.resize(std::size_t(first_moved));
  }
  std::vector<ImageU8> captures = capture(world, {shown.begin(), shown.begin() + first_moved}, options);
  World moved = world;
  moved.rig_from_board = world.rig_from_board * defects.moved->board_from_moved;
  options.seed = Random(options.seed, 1, 0).next();
  options.faults = later_faults;
  for (ImageU8& image : capture(moved, {shown.begin() + first_moved, shown.end()}, options))
    captures.push_back(std::move(image));
  return captures;
}

}  // namespace procam::simulate
