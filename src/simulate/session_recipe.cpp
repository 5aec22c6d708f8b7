#include "session_recipe.hpp"

#include <cmath>

#include "procam/core/base/closed_form.hpp"

namespace procam::simulate::internal {
namespace {

CaptureOptions captured(double brightest_grey, double camera_blur_px, double projector_blur_px,
                        NoiseModel noise) {
  CaptureOptions options;
  options.brightest_grey = brightest_grey;
  options.camera_blur_px = camera_blur_px;
  options.projector_blur_px = projector_blur_px;
  options.noise = noise;
  return options;
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

/// Terms that the recipe's lens does not have.
Camera with_more_terms(Camera lens, const std::optional<Range>& skew_px, const std::optional<Range>& k3,
                       Random& random) {
  const double drawn_skew = draw(skew_px.value_or(Range{}), random),
               drawn_k3 = draw(k3.value_or(Range{}), random);
  if (skew_px) lens.intrinsics.skew = drawn_skew;
  if (k3) std::get<BrownConrady>(lens.distortion).coefficients[4] = drawn_k3;
  return lens;
}

}  // namespace

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

double draw(const Range& range, Random& random) {
  const double size = random.uniform(range.low, range.high), sign = random.uniform(-1, 1);
  return range.either_sign && sign < 0 ? -size : size;
}

Vec3 vary(const Vec3& v, double by, Random& random) {
  const double x = random.uniform(-by, by), y = random.uniform(-by, by), z = random.uniform(-by, by);
  return v + Vec3(x, y, z);
}

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

}  // namespace procam::simulate::internal
