#include "pose_guide.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "procam/core/base/closed_form.hpp"
#include "procam/core/base/words.hpp"

namespace procam::studio {
namespace {

constexpr double kFocalLength = 0.85;  // image widths
constexpr double kFill = 0.62;         // of the light by the nearest board

struct Placing {
  double distance;     ///< multiple of the nearest
  double tilt_deg;     ///< against the line of sight
  double towards_deg;  ///< direction in the image of the axis that it is turned about
  double x, y;         ///< of the board's middle, shares of the lit box's half sides
  double roll_deg;
  const char* words;
};

// Both tilts about each axis, three distances, four directions off the middle.
constexpr std::array<Placing, 12> kPlacings = {{
    {1.05, 8, 0, 0, 0, 0, "facing the camera"},
    {1.15, 32, 0, -0.1, 0.1, 5, "upper edge tilted away from you"},
    {1.3, 32, 90, 0.2, 0, -5, "left edge tilted towards the wall"},
    {1.6, 30, 180, -0.3, -0.2, 0, "upper edge tilted towards you"},
    {1.2, 34, 270, 0.1, 0.2, 8, "right edge tilted towards the wall"},
    {1.8, 20, 45, 0.3, 0.3, -8, "one corner tilted towards you"},
    {1.1, 34, 135, 0, 0, 15, "another corner tilted towards you"},
    {1.5, 34, 225, -0.3, 0.3, -15, "a corner tilted towards the wall"},
    {1.9, 32, 315, 0.3, -0.3, 0, "far away, a corner tilted towards you"},
    {1.25, 25, 20, 0.2, -0.1, 25, "turned clockwise"},
    {1.4, 25, 200, -0.2, 0.1, -25, "turned anticlockwise"},
    {1.7, 35, 100, 0, 0, 0, "far away, strongly tilted"},
}};

struct PrintExtent {
  Vec2 low, high;
};

PrintExtent print_extent(const Board& board) {
  PrintExtent result{Vec2::Constant(1e9), Vec2::Constant(-1e9)};
  for (const Vec3& point : points_in_board(board)) {
    result.low = result.low.cwiseMin(point.head<2>());
    result.high = result.high.cwiseMax(point.head<2>());
  }
  return result;
}

/// As they are where at least one is in the frame; else none.
std::vector<Vec2> if_in_frame(std::vector<Vec2> corners, ImageSize frame) {
  const auto is_in = [&](const Vec2& corner) {
    return corner.x() >= 0 && corner.y() >= 0 && corner.x() <= frame.width - 1 &&
           corner.y() <= frame.height - 1;
  };
  return std::any_of(corners.begin(), corners.end(), is_in) ? std::move(corners) : std::vector<Vec2>{};
}

}  // namespace

Camera assumed_camera(ImageSize size) {
  Intrinsics k;
  k.fx = k.fy = kFocalLength * size.width;
  k.cx = 0.5 * (size.width - 1);
  k.cy = 0.5 * (size.height - 1);
  return {size, k, NoDistortion{}};
}

GuidedPose guided_pose(int view, const Board& board, ImageSize camera_size, const LitBox& lit) {
  const Placing& placing = kPlacings[std::size_t(view) % kPlacings.size()];
  const Camera camera = assumed_camera(camera_size);
  const PrintExtent print = print_extent(board);
  const Vec2 size = print.high - print.low, box = (lit.high - lit.low).cwiseMax(Vec2(50, 50));
  const double nearest = camera.intrinsics.fx * size.cwiseQuotient(box).maxCoeff() / kFill;
  const double distance = placing.distance * nearest;
  const Vec2 middle_px = 0.5 * (lit.low + lit.high) +
                         0.5 * box.cwiseProduct(Vec2(placing.x, placing.y)) * (1 - kFill / placing.distance);
  const Vec3 sight = camera.unproject(middle_px).value_or(Vec3::UnitZ()).normalized();
  const double direction = placing.towards_deg * kDegree;
  const Eigen::Quaterniond facing = rotation_between(Vec3::UnitZ(), sight);
  const Vec3 axis = facing * Vec3(std::cos(direction), std::sin(direction), 0);
  const Eigen::Quaterniond rotation =
      Eigen::Quaterniond(Eigen::AngleAxisd(placing.tilt_deg * kDegree, axis)) *
      Eigen::Quaterniond(Eigen::AngleAxisd(placing.roll_deg * kDegree, sight)) * facing;
  const Vec3 middle = (Vec3() << 0.5 * (print.low + print.high), 0).finished();
  return {Pose(rotation, distance * sight - rotation * middle), camera,
          "about " + fixed(distance, 1) + " m from the camera, " + placing.words};
}

std::vector<Vec2> outline(const Board& board, const Pose& camera_from_board, const Camera& camera,
                          double margin) {
  PrintExtent print = print_extent(board);
  print.low -= Vec2::Constant(margin);
  print.high += Vec2::Constant(margin);
  std::vector<Vec2> corners;
  for (const Vec2& corner :
       {print.low, Vec2(print.high.x(), print.low.y()), print.high, Vec2(print.low.x(), print.high.y())}) {
    const auto pixel = camera.project(camera_from_board * Vec3(corner.x(), corner.y(), 0));
    if (!pixel) return {};
    corners.push_back(*pixel);
  }
  return corners;
}

double light_margin(const Board& board) {
  constexpr double kSpacings = 1.4;  // a chessboard's squares go on for one beyond its outer corners
  const PrintExtent print = print_extent(board);
  const Vec2 size = print.high - print.low;
  return kSpacings * std::sqrt(size.x() * size.y() / double(points_in_board(board).size()));
}

std::vector<Vec2> outline_in_frame(const Board& board, const Pose& projector_from_board,
                                   const Projector& projector) {
  return if_in_frame(outline(board, projector_from_board, projector.inverse_camera, light_margin(board)),
                     projector.size());
}

std::vector<Vec2> outline_in_frame(const Board& board, const GuidedPose& pose, const LitBox& lit,
                                   ImageSize frame) {
  const Vec2 box = (lit.high - lit.low).cwiseMax(Vec2(1, 1)), size(frame.width, frame.height);
  std::vector<Vec2> corners = outline(board, pose.camera_from_board, pose.camera, light_margin(board));
  for (Vec2& corner : corners)
    corner = (corner - lit.low).cwiseQuotient(box).cwiseProduct(size) - Vec2(0.5, 0.5);
  return if_in_frame(std::move(corners), frame);
}

}  // namespace procam::studio
