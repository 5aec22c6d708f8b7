#include "procam/simulate/session.hpp"

#include <algorithm>
#include <cmath>

#include "noise.hpp"
#include "procam/core/closed_form.hpp"

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

/// Camera and projector look at the same place: the middle of the projector's picture falls on the camera's
/// axis amid the working distances, or `aside` metres right of it.
Rig make_rig(const Recipe& recipe, double aside, Random& random) {
  Rig rig;
  rig.cameras.push_back({"camera", vary(recipe.camera, random), Pose::identity()});
  const Projector projector{vary(recipe.projector, random)};
  const Vec3 position = vary(recipe.projector_in_camera, 0.03, random);
  const Vec3 target = vary(Vec3(aside, 0, 0.5 * (recipe.nearest + recipe.farthest)), 0.04, random);
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

}  // namespace

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

Session make_session(Level level, std::uint64_t seed,
                     const std::optional<Eigen::AlignedBox2d>& on_blank_paper,
                     const std::optional<BoardPrint>& print) {
  const Recipe& recipe = recipe_of(level);
  Random random(seed, std::uint64_t(level), 0);
  World world;
  world.board = recipe.board;
  if (print) {
    world.board.layout = print->layout;
    world.board.artwork = print->artwork;
  }
  // Print and light share the camera's image: the light's place is half a print right of the axis.
  const ArtworkRectangle dark = print_of(world.board.layout);
  const double print_width = dark.high.x() - dark.low.x() + 2 * world.board.margin;
  world.rig = make_rig(recipe, on_blank_paper ? 0.5 * print_width : 0, random);
  world.ambient = recipe.ambient;
  const Vec3 wall_normal = vary(Vec3(0.08, -0.05, -1), 0.03, random).normalized();
  world.wall_in_rig = {wall_normal, -wall_normal.z() * (recipe.farthest + 0.7)};

  Session session;
  session.level = level;
  session.capture = recipe.capture;
  session.capture.seed = seed;
  if (on_blank_paper) add_blank_paper(recipe, world, *on_blank_paper);
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
    session.capture.brightest_grey *= kExposureShare;
  }
  // Golden sections spread distances and tilt directions evenly, however many views there are.
  const double distance_start = random.uniform(0, 1), tilt_start = random.uniform(0, 1);
  const int views = on_blank_paper ? kViewsOfLightPoints : recipe.views;
  for (int view = 0; view < views; ++view) {
    const double turn = distance_start + view * 0.6180339887498949;
    placing.distance = recipe.nearest + (recipe.farthest - recipe.nearest) * (turn - std::floor(turn));
    const double tilt_direction = 2 * kPi * (tilt_start + view * 0.3819660112501051);
    placing.tilt_direction = tilt_direction;
    const bool partly_lit =
        recipe.partly_lit_every > 0 && view % recipe.partly_lit_every == recipe.partly_lit_every - 1;
    const bool partly_seen = is_coded(world.board.layout) && view % kPartlySeenEvery == 1;
    const Shown shown = partly_seen ? Shown::kPartlySeen : partly_lit ? Shown::kPartlyLit : Shown::kAll;
    constexpr int kTries = 20000;
    bool found = false;
    for (int i = 0; i < kTries && !found; ++i) {
      if (on_blank_paper) {
        // Not every distance and tilt leaves room for print and light in the camera's image: search wider
        // and wider.
        placing.distance = random.uniform(recipe.nearest, kReach * recipe.farthest);
        placing.tilt_direction = tilt_direction + kPi * i / kTries * random.uniform(-1, 1);
      } else if (partly_seen) {
        // Light that reaches the rim of the camera's image is near.
        placing.distance = random.uniform(kNearer * recipe.nearest, recipe.farthest);
      }
      const std::optional<Pose> pose = draw_pose(recipe, world, placing, random);
      if (!pose) continue;
      world.rig_from_board = *pose;
      found = on_blank_paper ? is_usable(world, *on_blank_paper, shown) : is_usable(world, shown);
    }
    if (!found)
      throw Error(ErrorKind::kNotConverged,
                  "simulated session of level " + std::string(recipe.name) + ", view " + std::to_string(view),
                  "no board pose that camera and projector both cover was found",
                  print ? "use a smaller board or another seed" : "use another seed");
    session.views.push_back(world);
  }
  return session;
}

std::vector<ImageU8> capture_view(const Session& session, std::size_t view,
                                  const std::vector<ImageU8>& frames) {
  require(view < session.views.size(), "capture_view: there is no view " + std::to_string(view));
  CaptureOptions options = session.capture;
  options.seed = Random(session.capture.seed, view, 1).next();
  return capture(session.views[view], frames, options);
}

}  // namespace procam::simulate
