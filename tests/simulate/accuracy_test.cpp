/// Rendered pictures against direct projection. Two rulers that know nothing of the renderer:
///
/// - Edges, by area: along a picture row an edge between the levels 0 and 1 lies where the levels' sum says.
/// Exact for
///   every symmetric blur; 8 bits leave about 0.004 px. Limits: worst 0.02 px, mean 0.003 px.
/// - Corners, by cv::cornerSubPix, itself right to some hundredths on corners seen in perspective (more rays
/// a pixel do
///   not change its answers): the limit is on the mean over the board, 0.02 px.
#include <gtest/gtest.h>

#include <functional>
#include <opencv2/imgproc.hpp>

#include "worlds.hpp"

namespace procam::simulate {
namespace {

using test::lopsided_world;

World bent(World world) {
  world.board.sheet = {Vec3(0.9, -0.5, 0.3), Vec2(0.12, 0.09)};  // up to 15 mm off its plane
  return world;
}

std::vector<World> poses() {
  return {lopsided_world(), bent(lopsided_world()),
          lopsided_world(Vec3(-0.5, 0.2, -0.15), Vec3(-0.05, 0.06, 1.1)),
          lopsided_world(Vec3(0.02, 0.03, 0.004), Vec3(0.06, -0.03, 0.8)),
          lopsided_world(Vec3(0.1, 0.55, 0.4), Vec3(0.02, 0.01, 0.95))};
}

struct Errors {
  std::vector<double> values;

  double mean() const {
    double sum = 0;
    for (const double v : values) sum += v;
    return sum / double(values.size());
  }
  double worst() const {
    double most = 0;
    for (const double v : values) most = std::max(most, std::abs(v));
    return most;
  }
};

/// An edge in the world as a curve in the camera's picture, parameter 0..1.
using EdgeInCamera = std::function<Vec2(double)>;

/// Measured minus true position of an edge, at the whole row (axis 0: along x) or column (axis 1) nearest to
/// the curve's middle. `level(x, y)` runs from about one value to another across the edge, monotone but for
/// the ends.
template <typename Level>
std::optional<double> edge_error(const EdgeInCamera& edge, int axis, int reach, const Level& level) {
  const int across = axis, along = 1 - axis;
  const double line = std::round(edge(0.5)[along]);
  double low = 0, high = 1;  // where the curve crosses that line
  const double sign = edge(1)[along] > edge(0)[along] ? 1 : -1;
  if (sign * (edge(0)[along] - line) > 0 || sign * (edge(1)[along] - line) < 0) return std::nullopt;
  for (int i = 0; i < 50; ++i) {
    const double middle = 0.5 * (low + high);
    (sign * (edge(middle)[along] - line) < 0 ? low : high) = middle;
  }
  const double truth = edge(low)[across];
  // An edge that runs along the scan line cannot be measured on it.
  const Vec2 direction = (edge(low + 0.01) - edge(low - 0.01)).normalized();
  if (std::abs(direction[along]) < 0.85) return std::nullopt;
  const int center = int(std::lround(truth)), begin = center - reach, end = center + reach;
  const auto at = [&](int i) { return axis == 0 ? level(i, int(line)) : level(int(line), i); };
  const double first = at(begin), last = at(end);
  double sum = 0;  // of the share of `first`
  for (int i = begin; i <= end; ++i) sum += (at(i) - last) / (first - last);
  return begin - 0.5 + sum - truth;
}

void expect_right(const Errors& errors, std::size_t at_least) {
  EXPECT_GE(errors.values.size(), at_least);
  EXPECT_LT(std::abs(errors.mean()), 0.003);
  EXPECT_LT(errors.worst(), 0.02);
}

TEST(Capture, ShowsTheBoardsEdgesWhereProjectionPutsThem) {
  for (World world : poses())
    for (const double blur : {0.0, 0.8}) {
      world.ambient = 1e6;  // even light: the levels beside an edge are flat, white 240 and black 15
      CaptureOptions options;
      options.brightest_grey = 240;
      options.camera_blur_px = blur;
      const ImageU8 dark(world.rig.projector().projector.size());
      const ImageU8 image = capture(world, {dark}, options)[0];
      const auto level = [&](int x, int y) { return double(image.at(x, y)); };
      const RigCamera& camera = world.rig.camera();
      const Pose camera_from_board = camera.rig_from_camera.inverse() * world.rig_from_board;
      const Chessboard& board = std::get<Chessboard>(world.board.layout);
      Errors errors;
      for (int row = 0; row < board.rows; ++row)
        for (int column = 0; column < board.columns; ++column)
          for (const int axis : {0, 1}) {
            // Axis 0: the vertical edge below this corner; axis 1: the horizontal one to its right.
            const EdgeInCamera edge = [&](double t) {
              const Vec3 step = (axis == 0 ? Vec3::UnitY() : Vec3::UnitX()) * board.square_size;
              Vec3 point = board.point_in_board(row * board.columns + column) + t * step;
              point.z() = world.board.sheet.height(point.head<2>());
              return *camera.camera.project(camera_from_board * point);
            };
            if (const auto error = edge_error(edge, axis, 7, level)) errors.values.push_back(*error);
          }
      expect_right(errors, 15);
    }
}

TEST(Capture, LandsProjectorLightWhereItsRayMeetsTheBoard) {
  constexpr int kStripe = 24;
  for (World world : poses()) {
    world.board.black_albedo = world.board.white_albedo;  // a blank sheet
    world.ambient = 0;
    const Projector& projector = world.rig.projector().projector;
    const Camera& camera = world.rig.camera().camera;
    const Pose projector_from_board =
        world.rig.projector().rig_from_projector.inverse() * world.rig_from_board;
    const Pose camera_from_projector = world.rig.projector_from_camera().inverse();
    std::vector<ImageU8> stripes(4, ImageU8(projector.size()));  // vertical, inverse, horizontal, inverse
    for (int y = 0; y < projector.size().height; ++y)
      for (int x = 0; x < projector.size().width; ++x) {
        const bool u = x / kStripe % 2 == 0, v = y / kStripe % 2 == 0;
        stripes[u ? 0 : 1].at(x, y) = stripes[v ? 2 : 3].at(x, y) = 255;
      }
    CaptureOptions options;
    options.brightest_grey = 250;
    options.camera_blur_px = 0.5;
    options.projector_blur_px = 0.6;
    const std::vector<ImageU8> captures = capture(world, stripes, options);

    Errors errors;
    for (const int axis : {0, 1}) {
      // Shading cancels in the ratio.
      const auto level = [&](int x, int y) {
        const double a = captures[std::size_t(2 * axis)].at(x, y),
                     b = captures[std::size_t(2 * axis + 1)].at(x, y);
        return (a - b) / (a + b + 1e-9);
      };
      for (int across = kStripe; across < projector.size().width; across += kStripe)
        for (int along = kStripe / 2; along < projector.size().width; along += kStripe) {
          const Vec2 middle = axis == 0 ? Vec2(across - 0.5, along) : Vec2(along, across - 0.5);
          if (!projector.size().contains(middle + Vec2(12, 12))) continue;
          const auto lands = [&](const Vec2& pixel) {
            return *intersect(projector_from_board.inverse() * *projector.emit(pixel), world.board.sheet);
          };
          const Vec3 on_board = lands(middle);
          const double margin = 0.06;
          if (on_board.x() < -margin || on_board.y() < -margin || on_board.x() > 7 * 0.041 + margin ||
              on_board.y() > 4 * 0.041 + margin)
            continue;
          const EdgeInCamera edge = [&](double t) {
            const Vec2 pixel = middle + (t - 0.5) * 10 * (axis == 0 ? Vec2::UnitY() : Vec2::UnitX());
            return *camera.project(camera_from_projector * (projector_from_board * lands(pixel)));
          };
          if (const auto error = edge_error(edge, axis, 8, level)) errors.values.push_back(*error);
        }
    }
    expect_right(errors, 60);
  }
}

TEST(Capture, ShowsTheBoardsCornersWhereProjectionPutsThem) {
  for (World world : poses()) {
    world.ambient = 1e6;
    CaptureOptions options;
    options.camera_blur_px = 1;
    const ImageU8 dark(world.rig.projector().projector.size());
    const ImageU8 image = capture(world, {dark}, options)[0];
    std::vector<cv::Point2f> corners;
    const std::vector<Observation> truth = board_in_camera(world);
    for (const Observation& o : truth)
      corners.emplace_back(float(o.pixel.x() + 0.4), float(o.pixel.y() - 0.3));
    cv::cornerSubPix(cv::Mat(image.height(), image.width(), CV_8U, const_cast<std::uint8_t*>(image.data())),
                     corners, {5, 5}, {-1, -1}, {cv::TermCriteria::EPS | cv::TermCriteria::COUNT, 100, 1e-4});
    Vec2 mean = Vec2::Zero();
    for (std::size_t i = 0; i < truth.size(); ++i)
      mean += (Vec2(corners[i].x, corners[i].y) - truth[i].pixel) / double(truth.size());
    EXPECT_EQ(truth.size(), 40u);
    EXPECT_LT(mean.norm(), 0.02);
  }
}

}  // namespace
}  // namespace procam::simulate
