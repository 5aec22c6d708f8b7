#include "procam/simulate/session.hpp"

#include <algorithm>
#include <cmath>

#include "noise.hpp"
#include "procam/core/closed_form.hpp"

namespace procam::simulate {
namespace {

using internal::Random;

constexpr double kPi = 3.14159265358979323846;
constexpr double kDegree = kPi / 180;

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
       {{10, 7, 0.030}, 0.03, 0.80, 0.06},
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
       {{9, 6, 0.036}, 0.036, 0.80, 0.06},
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
       {{7, 9, 0.034}, 0.034, 0.62, 0.10},
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
/// axis amid the working distances.
Rig make_rig(const Recipe& recipe, Random& random) {
  Rig rig;
  rig.cameras.push_back({"camera", vary(recipe.camera, random), Pose::identity()});
  const Projector projector{vary(recipe.projector, random)};
  const Vec3 position = vary(recipe.projector_in_camera, 0.03, random);
  const Vec3 target = vary(Vec3(0, 0, 0.5 * (recipe.nearest + recipe.farthest)), 0.04, random);
  const Vec2 middle(0.5 * (projector.size().width - 1), 0.5 * (projector.size().height - 1));
  const std::optional<Ray> ray = projector.emit(middle);
  require(ray.has_value(), "simulate: the recipe's projector lens does not reach its picture's middle");
  const Vec3 aim = (target - position).normalized();
  const Eigen::Quaterniond roll(Eigen::AngleAxisd(random.uniform(-3, 3) * kDegree, aim));
  rig.projectors.push_back(
      {"projector", projector, Pose(roll * rotation_between(ray->direction, aim), position)});
  return rig;
}

/// A sheet whose middle lies on a random pixel's light, `distance` from the camera, facing it up to a tilt.
std::optional<Pose> draw_pose(const Recipe& recipe, const World& world, double distance,
                              double tilt_direction, Random& random) {
  const RigProjector& device = world.rig.projector();
  const Vec2 pixel(random.uniform(0, device.projector.size().width - 1.0),
                   random.uniform(0, device.projector.size().height - 1.0));
  const double tilt = random.uniform(0.3, 1.0) * recipe.tilt_deg * kDegree;
  const double roll = random.uniform(-25, 25) * kDegree;
  const std::optional<Ray> ray_in_projector = device.projector.emit(pixel);
  if (!ray_in_projector) return std::nullopt;
  const Ray ray = device.rig_from_projector * *ray_in_projector;
  // |origin + s direction| = distance
  const double b = ray.origin.dot(ray.direction);
  const double root = b * b - ray.origin.squaredNorm() + distance * distance;
  if (root < 0) return std::nullopt;
  const Vec3 center = ray.at(-b + std::sqrt(root));
  const Vec3 sight = center.normalized();
  const Eigen::Quaterniond facing = rotation_between(Vec3::UnitZ(), sight);
  const Vec3 axis = facing * Vec3(std::cos(tilt_direction), std::sin(tilt_direction), 0);
  const Eigen::Quaterniond rotation = Eigen::Quaterniond(Eigen::AngleAxisd(tilt, axis)) *
                                      Eigen::Quaterniond(Eigen::AngleAxisd(roll, sight)) * facing;
  const Chessboard& layout = recipe.board.layout;
  const Vec3 middle(0.5 * (layout.columns - 1) * layout.square_size,
                    0.5 * (layout.rows - 1) * layout.square_size, 0);
  return Pose(rotation, center - rotation * middle);
}

/// Sheet wholly on the camera's image; print towards camera and projector, not too flat; `partly`: 50 .. 90 %
/// of the points lit, else all of them, with their squares.
bool is_usable(const World& world, bool partly) {
  const RigCamera& camera = world.rig.camera();
  const RigProjector& projector = world.rig.projector();
  const Pose camera_from_board = camera.rig_from_camera.inverse() * world.rig_from_board;
  const Pose projector_from_board = projector.rig_from_projector.inverse() * world.rig_from_board;
  constexpr double kMarginPx = 6;
  const auto inside = [](const Camera& device, const Vec3& point) {
    const std::optional<Vec2> p = device.project(point);
    return p && p->x() >= kMarginPx && p->y() >= kMarginPx && p->x() <= device.size.width - 1 - kMarginPx &&
           p->y() <= device.size.height - 1 - kMarginPx;
  };
  for (const Vec3& corner : sheet_corners_in_board(world.board))
    if (!inside(camera.camera, camera_from_board * corner)) return false;
  for (const Pose& device_from_board : {camera_from_board, projector_from_board}) {
    const Vec3 eye_in_board = device_from_board.inverse().translation;
    if (eye_in_board.z() > -0.5 * eye_in_board.norm()) return false;
  }
  if (partly) {
    const double share = double(board_in_projector(world).size()) / world.board.layout.size();
    return share >= 0.5 && share <= 0.9;
  }
  PrintedBoard squares = world.board;
  squares.margin = 0;
  for (const Vec3& corner : sheet_corners_in_board(squares))
    if (!inside(projector.projector.inverse_camera, projector_from_board * corner)) return false;
  return true;
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

Session make_session(Level level, std::uint64_t seed) {
  const Recipe& recipe = recipe_of(level);
  Random random(seed, std::uint64_t(level), 0);
  World world;
  world.rig = make_rig(recipe, random);
  world.board = recipe.board;
  world.ambient = recipe.ambient;
  const Vec3 wall_normal = vary(Vec3(0.08, -0.05, -1), 0.03, random).normalized();
  world.wall_in_rig = {wall_normal, -wall_normal.z() * (recipe.farthest + 0.7)};

  Session session;
  session.level = level;
  session.gray_code.projector_size = recipe.projector.size;
  session.capture = recipe.capture;
  session.capture.seed = seed;
  // Golden sections spread distances and tilt directions evenly, however many views there are.
  const double distance_start = random.uniform(0, 1), tilt_start = random.uniform(0, 1);
  for (int view = 0; view < recipe.views; ++view) {
    const double turn = distance_start + view * 0.6180339887498949;
    const double distance = recipe.nearest + (recipe.farthest - recipe.nearest) * (turn - std::floor(turn));
    const double tilt_direction = 2 * kPi * (tilt_start + view * 0.3819660112501051);
    const bool partly =
        recipe.partly_lit_every > 0 && view % recipe.partly_lit_every == recipe.partly_lit_every - 1;
    constexpr int kTries = 20000;
    bool found = false;
    for (int i = 0; i < kTries && !found; ++i)
      if (const std::optional<Pose> pose = draw_pose(recipe, world, distance, tilt_direction, random)) {
        world.rig_from_board = *pose;
        found = is_usable(world, partly);
      }
    if (!found)
      throw Error(ErrorKind::kNotConverged,
                  "simulated session of level " + std::string(recipe.name) + ", view " + std::to_string(view),
                  "no board pose that camera and projector both cover was found", "use another seed");
    session.views.push_back(world);
  }
  return session;
}

std::vector<ImageU8> capture_view(const Session& session, std::size_t view) {
  require(view < session.views.size(), "capture_view: there is no view " + std::to_string(view));
  CaptureOptions options = session.capture;
  options.seed = Random(session.capture.seed, view, 1).next();
  return capture(session.views[view], pattern::frames(session.gray_code), options);
}

}  // namespace procam::simulate
