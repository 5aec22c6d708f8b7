#include "procam/pattern/stripe_edges.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "support/gray_code_world.hpp"

namespace procam::pattern {
namespace {

const GrayCode kGrayCode{{117, 93}, 1};

struct Errors {
  std::size_t count = 0, columns = 0;
  double bias = 0, spread = 0, largest = 0;  ///< along the scan, camera pixels; spread is the RMS
  double normalised = 0;                     ///< RMS of error / sigma
};

/// Edges against the world's affine map, away from the projector's border, where light ends as well as
/// stripes.
Errors errors_of(const std::vector<StripeEdge>& edges, const test::GrayCodeWorld& world,
                 const GrayCode& gray_code) {
  Errors errors;
  double sum = 0, squares = 0, normalised = 0;
  for (const StripeEdge& edge : edges) {
    const Vec2 projector = world.projector_pixel(edge.camera_pixel);
    if (projector.x() < 3 || projector.y() < 3 || projector.x() > gray_code.projector_size.width - 4 ||
        projector.y() > gray_code.projector_size.height - 4)
      continue;
    const int axis = edge.axis == StripeAxis::kColumn ? 0 : 1, scan = edge.scan == ScanAxis::kCameraX ? 0 : 1;
    const double rate = world.projector_from_camera_linear(axis, scan);
    // Signed towards larger projector coordinates, so that a bias of all edges shows.
    const double error = (projector[axis] - edge.projector_coordinate) / std::abs(rate);
    ++errors.count;
    errors.columns += axis == 0;
    sum += error, squares += error * error, normalised += std::pow(error / edge.sigma_px, 2);
    errors.largest = std::max(errors.largest, std::abs(error));
  }
  const double n = double(errors.count);
  errors.bias = sum / n, errors.spread = std::sqrt(squares / n),
  errors.normalised = std::sqrt(normalised / n);
  return errors;
}

Errors measure(const test::GrayCodeWorld& world, const GrayCode& gray_code = kGrayCode,
               const StripeEdgeOptions& options = {}) {
  const std::vector<ImageU8> captures = test::capture_all(world, frames(gray_code));
  const std::vector<ViewU8> views = test::views_of(captures);
  return errors_of(stripe_edges(views, decode(views, gray_code), gray_code, options), world, gray_code);
}

TEST(StripeEdges, LieWhereTheLightChangesInAWhitePlane) {
  const Errors errors = measure({});
  EXPECT_GT(errors.count, 12000u);
  EXPECT_LT(std::abs(errors.bias), 0.003);
  EXPECT_LT(errors.spread, 0.03);
}

TEST(StripeEdges, StayTrueBesidePrintedSquares) {
  test::GrayCodeWorld world;
  world.square = 23;
  const std::vector<ImageU8> captures = test::capture_all(world, frames(kGrayCode));
  const std::vector<ViewU8> views = test::views_of(captures);
  const DecodedMap map = decode(views, kGrayCode);
  const Errors corrected = errors_of(stripe_edges(views, map, kGrayCode), world, kGrayCode);
  EXPECT_LT(std::abs(corrected.bias), 0.003);
  EXPECT_LT(corrected.spread, 0.1);
  EXPECT_LT(corrected.normalised, 1.2);
  // Without the blur's correction the squares' borders are off and nothing says so (measured 3.2 sigma).
  StripeEdgeOptions blind;
  blind.camera_blur_px = 0;
  const Errors uncorrected = errors_of(stripe_edges(views, map, kGrayCode, blind), world, kGrayCode);
  EXPECT_GT(uncorrected.spread, 1.2 * corrected.spread);
  EXPECT_GT(uncorrected.normalised, 2.0);
}

TEST(StripeEdges, HaveTheSpreadTheyState) {
  test::GrayCodeWorld world;
  world.noise_at_black = 0.6, world.noise_per_level = 0.03;
  world.square = 23;
  const Errors errors = measure(world);
  EXPECT_LT(std::abs(errors.bias), 0.003);
  // More than 12 000 edges: sampling moves this by 1 %; the bounds are for effects that are not in the model.
  EXPECT_GT(errors.normalised, 0.5);
  EXPECT_LT(errors.normalised, 1.3);
}

TEST(StripeEdges, SurviveMirroredAndTurnedProjectors) {
  test::GrayCodeWorld mirrored;
  mirrored.projector_from_camera_linear << -0.53, 0.05, -0.02, 0.57;
  mirrored.projector_from_camera_offset << 114.0, 1.3;
  const Errors mirror = measure(mirrored);
  EXPECT_GT(mirror.count, 12000u);
  EXPECT_LT(std::abs(mirror.bias), 0.003);
  EXPECT_LT(mirror.spread, 0.03);

  test::GrayCodeWorld turned;
  turned.projector_from_camera_linear << 0.03, 0.68, -0.43, 0.02;
  turned.projector_from_camera_offset << 2.0, 91.0;
  const Errors turn = measure(turned);
  EXPECT_GT(turn.count, 12000u);
  EXPECT_LT(std::abs(turn.bias), 0.003);
  EXPECT_LT(turn.spread, 0.045);  // the world itself is sampled at quarters of a camera pixel
}

TEST(StripeEdges, SurviveACameraCoarserThanTheProjector) {
  test::GrayCodeWorld world;
  world.camera = {83, 71};
  world.projector_from_camera_linear << 1.31, 0.06, -0.05, 1.27;
  world.camera_blur = 0.3;
  const Errors errors = measure(world);
  EXPECT_GT(errors.count, 4000u);
  EXPECT_LT(std::abs(errors.bias), 0.01);
  EXPECT_LT(errors.spread, 0.1);
}

TEST(StripeEdges, BoundWideStripesAtTheirBorders) {
  const GrayCode wide{{117, 93}, 4};
  const Errors errors = measure({}, wide);
  EXPECT_GT(errors.count, 3000u);
  EXPECT_LT(std::abs(errors.bias), 0.003);
  EXPECT_LT(errors.spread, 0.03);
}

TEST(StripeEdges, ComeFromTheCoarserBitsWhereTheFinestCannotBeRead) {
  // Two projector pixels a camera pixel: the finest bit repeats every other camera pixel, and blur leaves
  // nothing.
  const GrayCode gray_code{{203, 159}, 1};
  test::GrayCodeWorld world;
  world.camera = {97, 77};
  world.projector_from_camera_linear << 1.97, 0.06, -0.05, 1.93;
  world.projector_from_camera_offset << 4.2, 9.3;
  world.camera_blur = 1.0;
  world.noise_at_black = 1, world.noise_per_level = 0.01;
  const std::vector<ImageU8> captures = test::capture_all(world, frames(gray_code));
  const std::vector<ViewU8> views = test::views_of(captures);
  const DecodedMap map = decode(views, gray_code);
  long decoded = 0;
  for (int y = 0; y < world.camera.height; ++y)
    for (int x = 0; x < world.camera.width; ++x) decoded += map.decoded(x, y);
  EXPECT_LT(decoded, world.camera.width * world.camera.height / 4);
  const Errors errors = errors_of(stripe_edges(views, map, gray_code), world, gray_code);
  EXPECT_GT(errors.count, 4000u);
  EXPECT_LT(std::abs(errors.bias), 0.01);
  EXPECT_LT(errors.spread, 0.2);
  EXPECT_LT(errors.largest, 1.5) << "a wrong boundary";
}

TEST(StripeEdges, AreFittedOverTheirOwnWidth) {
  // A defocused projector: edges rise over six camera pixels, the finest stripes keep 5 % of their contrast;
  // a camera with a tone curve, whose dark pixels are the noisiest. Two neighbouring pixels differ by two
  // standard deviations at most.
  test::GrayCodeWorld world;
  world.projector_blur = 1.3;
  world.gamma = 2.0;
  world.black_level = 3, world.white_level = 28;
  world.noise_at_black = 32, world.noise_per_level = -0.28;
  const Errors errors = measure(world);
  RecordProperty("edges", std::to_string(errors.count)),
      RecordProperty("spread", std::to_string(errors.spread));
  RecordProperty("bias", std::to_string(errors.bias)),
      RecordProperty("largest", std::to_string(errors.largest));
  RecordProperty("normalised", std::to_string(errors.normalised));
  // Of 14 000 boundaries half belong to the finest bit, a quarter of them to the next one.
  EXPECT_GT(errors.count, 6000u);
  EXPECT_LT(std::abs(errors.bias), 0.01);
  EXPECT_LT(errors.spread, 0.35);
  EXPECT_LT(errors.largest, 3) << "a wrong boundary";
  EXPECT_GT(errors.normalised, 0.5);
  EXPECT_LT(errors.normalised, 1.3);
}

TEST(StripeEdges, StayWithinTheAreaThatIsAskedFor) {
  const test::GrayCodeWorld world;
  const std::vector<ImageU8> captures = test::capture_all(world, frames(kGrayCode));
  const std::vector<ViewU8> views = test::views_of(captures);
  const DecodedMap map = decode(views, kGrayCode);
  const std::vector<StripeEdge> all = stripe_edges(views, map, kGrayCode);
  ImageU8 area(world.camera, 1, 0);
  for (int y = 20; y < 70; ++y)
    for (int x = 40; x < 120; ++x) area.at(x, y) = 1;
  StripeEdgeOptions options;
  options.area = area;
  const std::vector<StripeEdge> within = stripe_edges(views, map, kGrayCode, options);
  const auto inside = [&](const StripeEdge& edge) {
    return area.at(int(std::floor(edge.camera_pixel.x())), int(std::floor(edge.camera_pixel.y()))) != 0;
  };
  EXPECT_GT(within.size(), 3000u);
  EXPECT_NEAR(double(within.size()), double(std::count_if(all.begin(), all.end(), inside)), 150);
  EXPECT_GT(std::count_if(within.begin(), within.end(), inside), long(within.size()) - 150);
  const ImageU8 other(world.camera.width, world.camera.height - 1);
  options.area = other;
  EXPECT_THROW(stripe_edges(views, map, kGrayCode, options), std::invalid_argument);
}

TEST(StripeEdges, RefuseAMapOfOtherCaptures) {
  const std::vector<ImageU8> shown = frames(kGrayCode);
  const std::vector<ViewU8> views = test::views_of(shown);
  DecodedMap map = decode(views, kGrayCode);
  map.step = 2;
  EXPECT_THROW(stripe_edges(views, map, kGrayCode), std::invalid_argument);
  EXPECT_THROW(stripe_edges(views, DecodedMap(), kGrayCode), std::invalid_argument);
  std::vector<ViewU8> fewer(views.begin(), views.end() - 1);
  EXPECT_THROW(stripe_edges(fewer, decode(views, kGrayCode), kGrayCode), Error);
}

}  // namespace
}  // namespace procam::pattern
