#include <gtest/gtest.h>

#include "procam/pattern/gray_code.hpp"
#include "worlds.hpp"

namespace procam::simulate {
namespace {

using test::full_light;
using test::lopsided_world;

double mean_of(const ImageU8& image, int x0, int y0, int size) {
  double sum = 0;
  for (int y = y0; y < y0 + size; ++y)
    for (int x = x0; x < x0 + size; ++x) sum += image.at(x, y);
  return sum / (size * size);
}

/// The whole pixel nearest to a point on the board.
Vec2 pixel_of(const World& world, const Vec3& point_on_board) {
  const RigCamera& camera = world.rig.camera();
  const Vec2 p =
      *camera.camera.project(camera.rig_from_camera.inverse() * (world.rig_from_board * point_on_board));
  return Vec2(std::round(p.x()), std::round(p.y()));
}

/// cos(angle) / distance^2 of the projector's light on the printed side.
double irradiance(const World& world, const Vec3& point_on_board) {
  const Vec3 light = world.rig_from_board.inverse() * world.rig.projector().rig_from_projector.translation;
  const Vec3 to_light = light - point_on_board;
  return -to_light.normalized().z() / to_light.squaredNorm();
}

TEST(Capture, FollowsCosineAndInverseSquare) {
  World world = lopsided_world(Vec3(0.3, -0.5, 0.2));
  world.board.black_albedo = world.board.white_albedo;
  world.ambient = 0;
  CaptureOptions options;
  options.brightest_grey = 250;
  const ImageU8 image = capture(world, {full_light(world)}, options)[0];
  double brightest = 0;
  for (const Vec3& corner : sheet_corners_in_board(world.board))
    brightest = std::max(brightest, irradiance(world, corner));
  for (const Observation& o : board_in_projector(world)) {
    const Vec3 point = points_in_board(world.board.layout)[std::size_t(o.point)];
    const Vec2 pixel = pixel_of(world, point);
    if (o.pixel.x() < 3 || o.pixel.y() < 3 || o.pixel.x() > 508 || o.pixel.y() > 386) continue;
    // Rounding 0.5, and up to half a pixel between the point and the pixel's centre.
    EXPECT_NEAR(image.at(int(pixel.x()), int(pixel.y())), 250 * irradiance(world, point) / brightest, 1.0);
  }
}

TEST(Capture, AddsRoomLightByAlbedo) {
  World world = lopsided_world();
  world.ambient = 1e6;
  CaptureOptions options;
  options.brightest_grey = 240;
  const ImageU8 image = capture(world, {full_light(world)}, options)[0];
  const double square = std::get<Chessboard>(world.board.layout).square_size;
  const Vec2 black = pixel_of(world, Vec3(0.5 * square, 0.5 * square, 0));
  const Vec2 white = pixel_of(world, Vec3(1.5 * square, 0.5 * square, 0));
  const Vec2 margin = pixel_of(world, Vec3(-1.5 * square, 0.5 * square, 0));
  EXPECT_EQ(image.at(int(white.x()), int(white.y())), 240);
  EXPECT_EQ(image.at(int(margin.x()), int(margin.y())), 240);
  EXPECT_EQ(image.at(int(black.x()), int(black.y())), 15);  // 240 * 0.05 / 0.8
  EXPECT_EQ(image.at(3, 466), 180);                         // the wall: 240 * 0.6 / 0.8
}

TEST(Capture, IsDarkInTheBoardsShadowAndOutsideThePicture) {
  World world = lopsided_world();
  world.ambient = 0;
  const ImageU8 image = capture(world, {full_light(world)})[0];
  const ProjectorMap map = projector_map(world);
  const RigCamera& camera = world.rig.camera();
  const RigProjector& projector = world.rig.projector();
  const Pose camera_from_projector = world.rig.projector_from_camera().inverse();
  const Plane wall_in_projector = projector.rig_from_projector.inverse() * world.wall_in_rig;
  const Plane board_in_rig = Plane::of_xy(world.rig_from_board);
  int in_shadow = 0, on_wall = 0;
  for (int v = 4; v < 386; v += 7)
    for (int u = 4; u < 508; u += 7) {
      // Independently of the renderer: follow the light to the wall, and see whether the sheet is in its way.
      const auto landed = projector.projector.intersect(Vec2(u, v), wall_in_projector);
      if (!landed) continue;
      const auto pixel = camera.camera.project(camera_from_projector * *landed);
      if (!pixel || pixel->x() < 2 || pixel->y() < 2 || pixel->x() > 637 || pixel->y() > 467) continue;
      const auto met =
          intersect(projector.rig_from_projector * *projector.projector.emit(Vec2(u, v)), board_in_rig);
      const auto seen = intersect(
          camera.rig_from_camera * Ray{Vec3::Zero(), *camera.camera.unproject(*pixel)}, board_in_rig);
      const double square = 0.041, edge = square + 0.05;
      const auto beyond = [&](const Vec3& point_in_rig, double by) {
        const Vec3 p = world.rig_from_board.inverse() * point_in_rig;
        return p.x() < -edge - by || p.y() < -edge - by || p.x() > 7 * square + edge + by ||
               p.y() > 4 * square + edge + by;
      };
      if (!met || !seen || !beyond(*seen, 0.01)) continue;  // the camera must see the wall there
      const int x = int(std::lround(pixel->x())), y = int(std::lround(pixel->y()));
      if (beyond(*met, 0.01)) {
        ++on_wall;
        EXPECT_GT(image.at(x, y), 20);
        ASSERT_TRUE(map.lit.at(x, y));
        EXPECT_NEAR(map.pixel.at(x, y, 0), u, 1.5);  // the camera pixel's centre is up to 0.7 px off
        EXPECT_NEAR(map.pixel.at(x, y, 1), v, 1.5);
      } else if (!beyond(*met, -0.01)) {
        ++in_shadow;
        EXPECT_EQ(image.at(x, y), 0);
        EXPECT_FALSE(map.lit.at(x, y));
      }
    }
  EXPECT_GT(on_wall, 100);
  EXPECT_GT(in_shadow, 30);
}

TEST(Capture, ReadsTheMapsProjectorPixel) {
  World world = lopsided_world();
  world.board.black_albedo = world.board.white_albedo;
  world.ambient = 0;
  // Ramps over full light give the coordinate straight away, to a quarter of a projector pixel at 8 bits and
  // grey 250.
  ImageU8 along_x = full_light(world), along_y = full_light(world);
  for (int y = 0; y < along_x.height(); ++y)
    for (int x = 0; x < along_x.width(); ++x) {
      along_x.at(x, y) = std::uint8_t(x / 2);
      along_y.at(x, y) = std::uint8_t(y / 2);
    }
  CaptureOptions options;
  options.brightest_grey = 250;
  const std::vector<ImageU8> captures = capture(world, {full_light(world), along_x, along_y}, options);
  for (const Observation& o : board_in_camera(world)) {
    const auto lit = projector_pixel_seen_at(world, Vec2(std::round(o.pixel.x()), std::round(o.pixel.y())));
    if (!lit) continue;
    const int x = int(std::lround(o.pixel.x())), y = int(std::lround(o.pixel.y()));
    const double white = captures[0].at(x, y);
    // A ramp of pairs is 0.5 px late on the mean; rounding of ramp and white.
    const double tolerance = 0.6 + 510 * 0.5 / white * 2;
    EXPECT_NEAR(captures[1].at(x, y) / white * 510 + 0.5, lit->x(), tolerance);
    EXPECT_NEAR(captures[2].at(x, y) / white * 510 + 0.5, lit->y(), tolerance);
  }
}

/// A chessboard's squares, drawn: the other way to the same picture.
BoardArtwork squares_of(const Chessboard& board) {
  BoardArtwork art;
  const double s = board.square_size;
  for (int row = 0; row <= board.rows; ++row)
    for (int column = row % 2; column <= board.columns; column += 2)
      art.rectangles.push_back({Vec2((column - 1) * s, (row - 1) * s), Vec2(column * s, row * s)});
  art.sheet = print_of(board);
  return art;
}

TEST(Capture, ShowsArtworkAsItShowsTheSameSquares) {
  World world = lopsided_world();
  const ImageU8 squares = capture(world, {full_light(world)})[0];
  world.board.artwork = squares_of(std::get<Chessboard>(world.board.layout));
  const ImageU8 drawn = capture(world, {full_light(world)})[0];
  for (int y = 0; y < squares.height(); ++y)
    for (int x = 0; x < squares.width(); ++x)
      ASSERT_NEAR(drawn.at(x, y), squares.at(x, y), 1) << x << " " << y;
}

TEST(Capture, ShowsDiscsOfTheirArea) {
  World world = lopsided_world(Vec3(0, 0, 0.2), Vec3(0.03, 0.02, 0.9));
  const CircleGrid circles{4, 3, 0.05, 0.034, false};
  world.board.layout = circles;
  world.ambient = 1e6;
  EXPECT_THROW(capture(world, {full_light(world)}), std::invalid_argument);  // nobody drew it
  const ArtworkRectangle print = print_of(circles);
  world.board.artwork.sheet = print;
  for (const Vec3& centre : points_in_board(circles))
    world.board.artwork.discs.push_back({centre.head<2>(), 0.5 * circles.diameter});
  CaptureOptions options;
  options.brightest_grey = 240;
  const ImageU8 image = capture(world, {full_light(world)}, options)[0];
  // Darkness round the first disc in pixels against its area there; white 240, black 15.
  const Vec2 centre = pixel_of(world, Vec3::Zero()), right = pixel_of(world, Vec3(0.15, 0, 0)),
             below = pixel_of(world, Vec3(0, 0.1, 0));
  const Vec2 a = (right - centre) / 0.15, b = (below - centre) / 0.1;
  const double pixels_per_m2 = std::abs(a.x() * b.y() - a.y() * b.x());
  double dark = 0;
  for (int y = int(centre.y()) - 18; y <= int(centre.y()) + 18; ++y)
    for (int x = int(centre.x()) - 18; x <= int(centre.x()) + 18; ++x) dark += (240 - image.at(x, y)) / 225.0;
  EXPECT_NEAR(dark, M_PI * 0.017 * 0.017 * pixels_per_m2, 0.03 * dark);
}

TEST(Capture, SeesColouredLightInItsChannelAndALittleBeside) {
  World world = lopsided_world();
  world.board.black_albedo = world.board.white_albedo;
  world.ambient = 0;
  ImageU8 red(world.rig.projector().projector.size(), 3);
  for (int y = 0; y < red.height(); ++y)
    for (int x = 0; x < red.width(); ++x) red.at(x, y, 0) = 255;
  CaptureOptions options;
  options.brightest_grey = 240;
  options.crosstalk = 0.25;
  const ImageU8 image = capture(world, {red}, options)[0],
                full = capture(world, {full_light(world)}, options)[0];
  ASSERT_EQ(image.channels(), 3);
  const Vec2 p = pixel_of(world, points_in_board(world.board.layout)[20]);
  const int x = int(p.x()), y = int(p.y());
  // Red sees red and a quarter of green, and its gain makes white 1: 1 / 1.25. Green sees a quarter: 0.25
  // / 1.5.
  EXPECT_NEAR(image.at(x, y, 0), full.at(x, y) / 1.25, 1.5);
  EXPECT_NEAR(image.at(x, y, 1), full.at(x, y) * 0.25 / 1.5, 1.5);
  EXPECT_EQ(image.at(x, y, 2), 0);
}

TEST(Capture, NoiseHasTheVarianceAskedFor) {
  World world = lopsided_world();
  world.ambient = 1e6;
  CaptureOptions options;
  options.noise = {3.0, 0.05};
  options.seed = 11;
  const std::vector<ImageU8> frames(32, full_light(world));
  const std::vector<ImageU8> captures = capture(world, frames, options);
  // A patch of the wall at grey 150: 32 frames x 400 pixels.
  double sum = 0, sum2 = 0, neighbours = 0;
  int n = 0;
  for (const ImageU8& image : captures)
    for (int y = 440; y < 460; ++y)
      for (int x = 10; x < 30; ++x, ++n) {
        const double d = image.at(x, y) - 150.0;
        sum += d;
        sum2 += d * d;
        neighbours += d * (image.at(x + 1, y) - 150.0);
      }
  const double variance = 3.0 + 0.05 * 150 + 1. / 12;  // and rounding
  // Limits of 4.4 sigma each: false alarm 1e-5 a statistic.
  EXPECT_NEAR(sum / n, 0, 4.4 * std::sqrt(variance / n));
  EXPECT_NEAR(sum2 / n, variance, 4.4 * variance * std::sqrt(2.0 / n));
  EXPECT_NEAR(neighbours / n, 0, 4.4 * variance / std::sqrt(n));
}

TEST(Capture, IsTheSameForAnyNumberOfThreadsAndAnotherForAnotherSeed) {
  const World world = lopsided_world();
  CaptureOptions options;
  options.noise = {2, 0.01};
  options.camera_blur_px = 0.7;
  options.projector_blur_px = 0.5;
  options.samples_per_axis = 1;
  options.seed = 5;
  const std::vector<ImageU8> frames(18, full_light(world));  // more than one batch
  const auto pixels = [](const std::vector<ImageU8>& images) {
    std::vector<std::uint8_t> all;
    for (const ImageU8& i : images) all.insert(all.end(), i.data(), i.data() + i.width() * i.height());
    return all;
  };
  options.threads = 1;
  const auto alone = pixels(capture(world, frames, options));
  options.threads = 3;
  EXPECT_EQ(alone, pixels(capture(world, frames, options)));
  options.seed = 6;
  EXPECT_NE(alone, pixels(capture(world, frames, options)));
}

TEST(Capture, BlursByTheSigmaAskedFor) {
  World world = lopsided_world(Vec3(0.01, 0.02, 0.004));
  world.ambient = 1e6;
  CaptureOptions sharp, blurred;
  sharp.brightest_grey = blurred.brightest_grey = 240;
  blurred.camera_blur_px = 1.5;
  const auto spread = [&](const CaptureOptions& options) {
    // Variance of an edge's derivative, along the row through the middle of a vertical edge, mean over rows.
    const ImageU8 image = capture(world, {full_light(world)}, options)[0];
    const Vec2 p = pixel_of(world, points_in_board(world.board.layout)[std::size_t(20)] + Vec3(0, 0.02, 0));
    double variance = 0;
    for (int y = int(p.y()) - 3; y <= int(p.y()) + 3; ++y) {
      double total = 0, first = 0, second = 0;
      for (int x = -10; x < 10; ++x) {
        const double step = image.at(int(p.x()) + x + 1, y) - double(image.at(int(p.x()) + x, y));
        total += step;
        first += x * step;
        second += x * x * step;
      }
      variance += (second / total - first * first / (total * total)) / 7;
    }
    return variance;
  };
  EXPECT_NEAR(spread(blurred) - spread(sharp), 1.5 * 1.5, 0.15);
}

TEST(Capture, DecodesToTheTrueProjectorMap) {
  World world = lopsided_world();
  world.board.black_albedo = world.board.white_albedo;
  const pattern::GrayCode gray_code{world.rig.projector().projector.size()};
  CaptureOptions options;
  options.camera_blur_px = 0.3;
  options.noise = {0.3, 0.002};
  const std::vector<ImageU8> captures = capture(world, pattern::frames(gray_code), options);
  const DecodedMap decoded = pattern::decode({captures.begin(), captures.end()}, gray_code);
  const ProjectorMap truth = projector_map(world);
  int lit = 0, right = 0, wrong = 0;
  for (int y = 0; y < truth.lit.height(); ++y)
    for (int x = 0; x < truth.lit.width(); ++x) {
      if (!truth.lit.at(x, y)) continue;
      ++lit;
      const auto pixel = decoded.projector_pixel(x, y);
      if (!pixel) continue;
      const Vec2 error = *pixel - Vec2(truth.pixel.at(x, y, 0), truth.pixel.at(x, y, 1));
      // Half a stripe, and as much again where blur and noise decide at the stripe's edge.
      (error.cwiseAbs().maxCoeff() <= 1 ? right : wrong)++;
    }
  EXPECT_GT(right, 0.85 * lit);   // the rest: undecided along stripe edges
  EXPECT_LT(wrong, 0.005 * lit);  // across the sheet's outline, where a pixel sees both sheet and wall
}

TEST(Capture, RefusesFramesOfAnotherSize) {
  const World world = lopsided_world();
  EXPECT_THROW(capture(world, {ImageU8(390, 512)}), std::invalid_argument);
  EXPECT_THROW(capture(world, {ImageU8(512, 390, 2)}), std::invalid_argument);
  CaptureOptions options;
  options.samples_per_axis = 0;
  EXPECT_THROW(capture(world, {full_light(world)}, options), std::invalid_argument);
}

TEST(Capture, MeanOfANoisyPatchIsThatOfTheCleanOne) {
  World world = lopsided_world();
  world.ambient = 1e6;
  CaptureOptions options;
  const double clean = mean_of(capture(world, {full_light(world)}, options)[0], 10, 440, 20);
  options.noise = {16, 0};
  // 400 pixels of sigma 4: 4.4 sigma of the mean, false alarm 1e-5.
  EXPECT_NEAR(mean_of(capture(world, {full_light(world)}, options)[0], 10, 440, 20), clean, 4.4 * 4 / 20);
}

}  // namespace
}  // namespace procam::simulate
