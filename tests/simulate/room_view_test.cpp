/// Rendered rooms against direct projection and closed forms. An edge between two levels lies, along a
/// picture row, where the levels' sum says: exact for every symmetric blur. Drawn edges: worst 0.02 px, mean
/// 0.003 px. Sampled ones (outlines, shadows) are right in the mean over many rows: 0.02 px.
#include "procam/simulate/room_view.hpp"

#include <gtest/gtest.h>

#include "procam/simulate/drive.hpp"
#include "room_hit.hpp"
#include "rooms.hpp"

namespace procam::simulate {
namespace {

using test::hung;
using test::looking_at;
using test::lopsided_room;
using test::room_camera;
using test::room_from_camera;
using test::room_light;

constexpr double kDrawnWorst = 0.02, kDrawnMean = 0.003, kSampledMean = 0.02;

bool seen_alike_around(const RoomTruth& truth, int x, int y) {
  for (int j = -1; j <= 1; ++j)
    for (int i = -1; i <= 1; ++i)
      if (truth.body.at(x + i, y + j) != truth.body.at(x, y)) return false;
  return true;
}

TEST(RoomView, TruthIsWhatRaysOneByOneSay) {
  const Room room = lopsided_room();
  const Camera camera = room_camera();
  const Pose room_from_eye = room_from_camera();
  const RoomLight light = room_light();
  RoomViewOptions options;
  options.samples_per_axis = 1;
  const RoomTruth truth = room_view(room, camera, room_from_eye, {light}, options).truth;
  const Pose room_from_projector = light.room_from_projector(0);
  std::vector<int> seen(room.bodies.size());
  int lit = 0, shadowed = 0;
  for (int y = 1; y < 511; y += 2)
    for (int x = 1; x < 639; x += 3) {
      const Ray ray = room_from_eye * Ray{Vec3::Zero(), *camera.unproject(Vec2(x, y))};
      const auto hit = nearest_hit(room, ray);
      if (!seen_alike_around(truth, x, y)) continue;  // an outline may pass within the rays' 1e-3 px
      ASSERT_EQ(truth.body.at(x, y), hit ? hit->body : -1) << x << " " << y;
      if (!hit) continue;
      ++seen[std::size_t(hit->body)];
      const Vec3 point(truth.point_in_room.at(x, y, 0), truth.point_in_room.at(x, y, 1),
                       truth.point_in_room.at(x, y, 2));
      const Vec3 in_camera = room_from_eye.inverse() * point;
      EXPECT_NEAR((*camera.project(in_camera) - Vec2(x, y)).norm(), 0, 2e-3);
      EXPECT_NEAR(truth.depth.at(x, y), in_camera.z(), 1e-5);

      const Vec3 from_light = hit->point_in_room - room_from_projector.translation;
      const auto first = nearest_hit(room, {room_from_projector.translation, from_light});
      const auto pixel = light.projector.project(room_from_projector.inverse() * hit->point_in_room);
      const bool in_picture = pixel && light.projector.size().contains(*pixel);
      const bool reached = hit->normal_in_room.dot(from_light) < 0 && first->lengths > 1 - 1e-6;
      const bool is_lit = truth.light[0].lit.at(x, y) != 0;
      (is_lit ? lit : shadowed) += in_picture;
      // Where neighbours agree no shadow's border is near.
      bool alike = true;
      for (int k = 0; k < 9; ++k)
        alike = alike && truth.light[0].lit.at(x + k % 3 - 1, y + k / 3 - 1) == truth.light[0].lit.at(x, y);
      if (!alike) continue;
      ASSERT_EQ(is_lit, in_picture && reached)
          << x << " " << y << " " << room.bodies[std::size_t(hit->body)].name;
      if (is_lit) {
        EXPECT_NEAR(truth.light[0].pixel.at(x, y, 0), pixel->x(), 5e-3);
        EXPECT_NEAR(truth.light[0].pixel.at(x, y, 1), pixel->y(), 5e-3);
      }
    }
  for (const char* name : {"far wall", "left wall", "floor", "table", "ball", "can", "niche", "poster",
                           "board", "marker 1", "parcel -y"})
    EXPECT_GT(seen[std::size_t(room.index_of(name))], 10) << name;
  EXPECT_GT(lit, 3000);
  EXPECT_GT(shadowed, 200);
}

/// A picture of two by two tiles, seen alone in ambient light.
Body four_tiles(const Pose& room_from_body) {
  Texture picture{ImageU8(2, 2), 1.0, 0.0};
  picture.image.at(0, 0) = picture.image.at(1, 1) = 255;
  return {"tiles", Rectangle{Vec2(-0.51, -0.4), Vec2(0.47, 0.43)}, room_from_body, picture};
}

struct EdgeErrors {
  double worst = 0, sum = 0;
  int count = 0;

  void add(double error) {
    worst = std::max(worst, std::abs(error));
    sum += error;
    ++count;
  }
  double mean() const { return sum / count; }
};

/// Where the picture of a curve crosses the line of pixels: axis 0, the row y = line; axis 1, the column x =
/// line. The curve's coordinate along the other axis must grow or fall with its parameter 0..1.
template <typename Curve>
std::optional<double> crossing(const Curve& curve, int axis, double line) {
  const int along = 1 - axis;
  double low = 0, high = 1;
  const double sign = curve(1)[along] > curve(0)[along] ? 1 : -1;
  if (sign * (curve(0)[along] - line) > 0 || sign * (curve(1)[along] - line) < 0) return std::nullopt;
  for (int i = 0; i < 50; ++i) {
    const double middle = 0.5 * (low + high);
    (sign * (curve(middle)[along] - line) < 0 ? low : high) = middle;
  }
  return curve(low)[axis];
}

/// Measured minus true place of an edge on one line of pixels, from `reach` pixels on both sides.
template <typename Level>
double edge_error(const Level& level, int axis, int line, double truth, int reach) {
  const int middle = int(std::lround(truth));
  const auto at = [&](int i) { return double(axis == 0 ? level(i, line) : level(line, i)); };
  const double low = at(middle - reach), high = at(middle + reach);
  double share = 0;
  for (int i = middle - reach; i <= middle + reach; ++i) share += (high - at(i)) / (high - low);
  return middle - reach - 0.5 + share - truth;
}
auto levels_of(const ImageU8& image) {
  return [&image](int x, int y) { return image.at(x, y); };
}

/// Errors of both inner edges of the tiles, camera poses by row.
template <typename CameraFromRoomAtRow>
std::array<EdgeErrors, 2> tile_errors(const ImageU8& image, const Camera& camera, const Body& tiles,
                                      const CameraFromRoomAtRow& camera_from_room) {
  std::array<EdgeErrors, 2> errors;
  for (const int axis : {0, 1})
    for (int line = 20; line < (axis == 0 ? image.height() : image.width()) - 20; ++line) {
      const auto truth = [&](double row) {
        return crossing(
            [&](double t) {
              const Vec2 uv = axis == 0 ? Vec2(0.5, t) : Vec2(t, 0.5);
              return *camera.project(camera_from_room(row) * point_at(tiles, uv));
            },
            axis, line);
      };
      // Of a moving camera's nearly horizontal edge, the row is part of the answer.
      std::optional<double> at = truth(axis == 0 ? line : image.height() / 2);
      for (int i = 0; i < 5 && at && axis == 1; ++i) at = truth(*at);
      if (!at || *at < 20 || *at > (axis == 0 ? image.width() : image.height()) - 20) continue;
      const Vec2 here = axis == 0 ? Vec2(*at, line) : Vec2(line, *at);
      const Vec2 cross = *camera.project(camera_from_room(here.y()) * point_at(tiles, Vec2(0.5, 0.5)));
      const Vec2 corner = *camera.project(camera_from_room(here.y()) *
                                          point_at(tiles, axis == 0 ? Vec2(0.5, 0) : Vec2(0, 0.5)));
      const Vec2 other = *camera.project(camera_from_room(here.y()) *
                                         point_at(tiles, axis == 0 ? Vec2(0.5, 1) : Vec2(1, 0.5)));
      if ((here - cross).norm() < 14 || (here - corner).norm() < 14 || (here - other).norm() < 14) continue;
      errors[std::size_t(axis)].add(edge_error(levels_of(image), axis, line, *at, 6));
    }
  return errors;
}

TEST(RoomView, DrawsThePicturesEdgesWhereTheyProject) {
  const Camera camera = room_camera();
  Room room;
  room.ambient = 1;
  for (const Vec3& turn : {Vec3(0.1, -0.15, 0.08), Vec3(-0.5, 0.6, -0.2)}) {
    const Pose place(so3_exp(turn), Vec3(0.05, 0.03, 1.4));
    room.bodies = {four_tiles(place)};
    RoomViewOptions options;
    options.brightest_grey = 250;
    options.camera_blur_px = 0.7;
    const ImageU8 image = room_view(room, camera, Pose(), {}, options).image();
    const auto errors = tile_errors(image, camera, room.bodies[0], [](double) { return Pose(); });
    for (const EdgeErrors& e : errors) {
      EXPECT_GT(e.count, 100);
      EXPECT_LT(e.worst, kDrawnWorst);
      EXPECT_LT(std::abs(e.mean()), kDrawnMean);
    }
  }
}

TEST(RoomView, RollsThroughTheRowsOfAMovingCamera) {
  const Camera camera = room_camera();
  Room room;
  room.ambient = 1;
  room.bodies = {four_tiles(Pose(so3_exp(Vec3(0.1, -0.15, 0.08)), Vec3(0.05, 0.03, 1.4)))};
  Vec6 twist;
  twist << 0.3, -0.5, 0.4, 0.7, -0.4, 0.2;  // over the frame's 30 ms, up to 10 px
  const Drive drive(Pose(so3_exp(Vec3(0.02, 0.01, 0)), Vec3(0.02, 0, 0)), {constant_twist(twist, 1)});
  const Pose rig_from_camera(so3_exp(Vec3(0.02, -0.03, 0.01)), Vec3(0.03, -0.02, 0.04));
  RoomViewOptions options;
  options.brightest_grey = 250;
  options.camera_blur_px = 0.7;
  options.time = 0.2;
  options.row_time = 0.03 / 512;
  const RoomView view = room_view(room, camera, drive * rig_from_camera, {}, options);
  const auto camera_from_room = [&](double row) {
    return (drive(options.time + row * options.row_time) * rig_from_camera).inverse();
  };
  for (const EdgeErrors& e : tile_errors(view.image(), camera, room.bodies[0], camera_from_room)) {
    EXPECT_GT(e.count, 100);
    EXPECT_LT(e.worst, 1.5 * kDrawnWorst);  // one pose a row: an edge along the rows comes in small steps
    EXPECT_LT(std::abs(e.mean()), kDrawnMean);
  }
  // And a camera taken as still at its first row would be pixels off.
  const auto still =
      tile_errors(view.image(), camera, room.bodies[0], [&](double) { return camera_from_room(0); });
  EXPECT_GT(still[0].worst, 1);
  for (int y = 5; y < 512; y += 40)
    for (int x = 3; x < 640; x += 40) {
      if (view.truth.body.at(x, y) < 0) continue;
      const Vec3 point(view.truth.point_in_room.at(x, y, 0), view.truth.point_in_room.at(x, y, 1),
                       view.truth.point_in_room.at(x, y, 2));
      EXPECT_NEAR((*camera.project(camera_from_room(y) * point) - Vec2(x, y)).norm(), 0, 2e-3);
    }
}

TEST(RoomView, AMovingRigsShadowsAndTilesStayRight) {
  // Fast enough that tiles made for the band's middle alone would lose bodies.
  const Room room = lopsided_room();
  Vec6 twist;
  twist << 0.6, 0.9, -0.7, 1.5, 0.4, -1.1;
  const Drive drive(se3_exp(Vec6(-0.5 * twist)), {constant_twist(twist, 1)}, -0.5);
  RoomLight light = room_light();
  const Pose room_from_projector = light.room_from_projector(0);
  const auto riding = [&](const Pose& pose) {
    return Motion([=](double t) {
      return Pose(Pose(Eigen::Quaterniond::Identity(), pose.translation) * drive(t) *
                  Pose(pose.rotation, Vec3::Zero()));
    });
  };
  const Motion camera_motion = riding(room_from_camera()), light_motion = riding(room_from_projector);
  light.room_from_projector = light_motion;
  const Camera camera = room_camera({320, 256});
  RoomViewOptions options;
  options.samples_per_axis = 1;
  options.row_time = 0.0028;  // eight pixels from a band's middle to its rim
  options.time = -0.35;
  const RoomTruth truth = room_view(room, camera, camera_motion, {light}, options).truth;
  int lit = 0;
  for (int y = 1; y < 255; y += 2)
    for (int x = 1; x < 319; x += 2) {
      if (!seen_alike_around(truth, x, y)) continue;
      const double time = options.time + y * options.row_time;
      const auto hit =
          nearest_hit(room, camera_motion(time) * Ray{Vec3::Zero(), *camera.unproject(Vec2(x, y))});
      ASSERT_EQ(truth.body.at(x, y), hit ? hit->body : -1) << x << " " << y;
      if (!truth.light[0].lit.at(x, y)) continue;
      ++lit;
      const auto pixel = light.projector.project(light_motion(time).inverse() * hit->point_in_room);
      EXPECT_NEAR((*pixel - Vec2(truth.light[0].pixel.at(x, y, 0), truth.light[0].pixel.at(x, y, 1))).norm(),
                  0, 0.01);
    }
  EXPECT_GT(lit, 1000);
}

TEST(RoomView, ASphereCoversItsEllipse) {
  Camera camera = room_camera();
  camera.distortion = NoDistortion{};
  Room room;
  room.ambient = 1;
  const Vec3 centre(0.31, -0.17, 1.5);
  const double radius = 0.23;
  room.bodies = {{"ball", Sphere{radius}, Pose(so3_exp(Vec3(0.4, -0.2, 1)), centre), 0.8}};
  RoomViewOptions options;
  options.brightest_grey = 250;
  const ImageU8 image = room_view(room, camera, Pose(), {}, options).image();
  double area = 0;
  Vec2 moment = Vec2::Zero();
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x) {
      area += image.at(x, y) / 250.0;
      moment += image.at(x, y) / 250.0 * Vec2(x, y);
    }
  // The tangent cone (d c)^2 = d^2 (c^2 - r^2) as a conic of pixels, x^T Q x = 0.
  const Mat3 inverse = camera.intrinsics.matrix().inverse();
  const Mat3 q = inverse.transpose() *
                 (centre * centre.transpose() - (centre.squaredNorm() - radius * radius) * Mat3::Identity()) *
                 inverse;
  const Mat2 a = q.topLeftCorner<2, 2>();
  const double det = a(0, 0) * a(1, 1) - a(0, 1) * a(1, 0);
  const Vec2 b = q.topRightCorner<2, 1>();
  const Vec2 middle = -Vec2(a(1, 1) * b.x() - a(0, 1) * b.y(), a(0, 0) * b.y() - a(1, 0) * b.x()) / det;
  const double level = -(q(2, 2) + b.dot(middle));  // (x - m)^T A (x - m) = level
  const double true_area = M_PI * std::abs(level) / std::sqrt(det);
  EXPECT_NEAR((moment / area - middle).norm(), 0, 0.02);
  EXPECT_NEAR((area - true_area) / (2 * std::sqrt(M_PI * true_area)), 0, kSampledMean);  // mean over the rim
  EXPECT_GT(true_area, 15000);
}

TEST(RoomView, ATubesSidesLieInItsTangentPlanes) {
  Camera camera = room_camera();
  camera.distortion = NoDistortion{};
  Room room;
  room.ambient = 1;
  const Pose place(so3_exp(Vec3(1.35, 0.2, 0.1)), Vec3(0.1, 0.2, 1.5));
  room.bodies = {{"tube", Cylinder{0.17, -3, 3}, place, 0.8}};
  RoomViewOptions options;
  options.brightest_grey = 250;
  const ImageU8 image = room_view(room, camera, Pose(), {}, options).image();
  const Vec3 eye = place.inverse().translation;
  const double towards = std::atan2(-eye.y(), -eye.x()), half = std::asin(0.17 / eye.head<2>().norm());
  for (const double side : {-1.0, 1.0}) {
    const double angle = towards + side * half;
    const Vec3 normal = place.rotate(Vec3(-std::sin(angle), std::cos(angle), 0));
    const Vec3 line = camera.intrinsics.matrix().inverse().transpose() * normal;
    EdgeErrors errors;
    for (int y = 5; y < 507; ++y)
      errors.add(edge_error(levels_of(image), 0, y, -(line.y() * y + line.z()) / line.x(), 8));
    EXPECT_LT(std::abs(errors.mean()), kSampledMean);
    EXPECT_LT(errors.worst, 0.5);
  }
}

TEST(RoomView, AShadowEndsWhereTheLightPassesTheEdge) {
  const Camera camera = room_camera();
  Room bare;
  bare.bodies = {hung("wall", Vec3(0, 2, 1), Vec3(0.1, -1, 0.05), Vec2(6, 6), 0.6)};
  Room room = bare;
  room.bodies.push_back(hung("screen", Vec3(0.9, 1.1, 0.9), Vec3(0.2, -1, 0.1), Vec2(1.1, 1.3), 0.3, 0.15));
  RoomLight light = room_light();
  light.room_from_projector = looking_at(Vec3(1.3, -0.2, 0.8), Vec3(0.0, 2, 1.05));
  const Pose eye = looking_at(Vec3(-0.6, 0, 1), Vec3(-0.1, 2, 1));
  RoomViewOptions options;
  options.samples_per_axis = 4;
  options.exposure = 900;
  const RoomView with = room_view(room, camera, eye, {light}, options);
  const ImageU8 unshadowed = room_view(bare, camera, eye, {light}, options).image();
  const auto lit_share = [&](int x, int y) { return with.image().at(x, y) / double(unshadowed.at(x, y)); };
  // The screen's left edge, u = 0, thrown onto the wall and seen.
  const Vec3 lamp = light.room_from_projector(0).translation;
  const auto border = [&](double v) {
    const Vec3 edge = point_at(room.bodies[1], Vec2(0, v));
    return *camera.project(eye.inverse() * nearest_hit(bare, {lamp, edge - lamp})->point_in_room);
  };
  EdgeErrors errors;
  for (int y = 0; y < 512; ++y) {
    const auto truth = crossing(border, 0, y);
    if (!truth || *truth < 20 || *truth > 620) continue;
    const int x = int(std::lround(*truth));
    // Lit on one side, dark on the other, nothing else near.
    if (!with.truth.light[0].lit.at(x - 10, y) || with.truth.light[0].lit.at(x + 10, y) ||
        with.truth.body.at(x + 10, y) != 0)
      continue;
    errors.add(edge_error(lit_share, 0, y, *truth, 6));
  }
  EXPECT_GT(errors.count, 100);
  EXPECT_LT(std::abs(errors.mean()), kSampledMean);
  EXPECT_LT(errors.worst, 0.25);
}

TEST(RoomView, FollowsTheEquationOfItsHeader) {
  const Room room = lopsided_room();
  const Camera camera = room_camera();
  const ImageU8 frame(512, 390, 1, 140);
  RoomLight light = room_light(frame);
  light.intensity = 1.7;
  light.gamma = 2.1;
  light.blur_px = 0.4;
  RoomViewOptions options;
  options.exposure = 2500;
  options.vignetting = 3;
  options.gamma = 1.6;
  const RoomView view = room_view(room, camera, room_from_camera(), {light}, options);
  const Vec3 lamp = light.room_from_projector(0).translation;
  int checked = 0, clipped = 0;
  for (int y = 2; y < 510; y += 5)
    for (int x = 2; x < 638; x += 5) {
      const int body = view.truth.body.at(x, y);
      if (body < 0 || !std::holds_alternative<double>(room.bodies[std::size_t(body)].paint)) continue;
      if (!seen_alike_around(view.truth, x, y)) continue;
      const auto& truth = view.truth.light[0];
      bool all = true, none = true;
      for (int k = 0; k < 25; ++k) (truth.lit.at(x + k % 5 - 2, y + k / 5 - 2) ? none : all) = false;
      if (!all && !none) continue;
      if (all && !(truth.pixel.at(x, y, 0) > 3 && truth.pixel.at(x, y, 0) < 508 &&
                   truth.pixel.at(x, y, 1) > 3 && truth.pixel.at(x, y, 1) < 386))
        continue;
      const Ray ray = room_from_camera() * Ray{Vec3::Zero(), *camera.unproject(Vec2(x, y))};
      const auto hit = nearest_hit(room, ray);
      const Vec3 to_lamp = lamp - hit->point_in_room;
      const double arriving = all ? 1.7 * std::pow(140 / 255.0, 2.1) *
                                        hit->normal_in_room.dot(to_lamp.normalized()) / to_lamp.squaredNorm()
                                  : 0;
      const double level = std::get<double>(room.bodies[std::size_t(body)].paint) * (room.ambient + arriving);
      const double linear = 2500 * level * std::pow(camera.unproject(Vec2(x, y))->z(), 3);
      clipped += linear > 255;
      EXPECT_NEAR(view.image().at(x, y), 255 * std::pow(std::min(linear, 255.0) / 255, 1 / 1.6), 1.0)
          << x << " " << y << " " << room.bodies[std::size_t(body)].name;
      ++checked;
    }
  EXPECT_GT(checked, 3000);
  EXPECT_LT(clipped, checked / 2);
}

TEST(RoomView, ShowsAWorldAsCaptureDoes) {
  const World world = test::lopsided_world();
  Room room;
  room.ambient = world.ambient;
  // The wall as a large sheet, z into it.
  const Vec3 into = -world.wall_in_rig.normal;
  const Vec3 x = into.cross(Vec3(0.1, 1, 0.2)).normalized();
  Mat3 axes;
  axes << x, into.cross(x), into;
  room.bodies = {{"wall", Rectangle{Vec2(-9, -9), Vec2(9, 9)},
                  Pose(axes, Vec3(into * world.wall_in_rig.offset)), world.wall_albedo},
                 printed_sheet("board", world.board, world.rig_from_board)};
  ImageU8 frame = test::full_light(world);
  for (int row = 0; row < frame.height(); ++row)
    for (int column = 0; column < frame.width(); ++column)
      frame.at(column, row) = std::uint8_t(40 + (column * 3 + row * 2) % 200);
  CaptureOptions options;
  options.camera_blur_px = 0.6;
  options.projector_blur_px = 0.5;
  options.noise = {2, 0.01};
  options.seed = 7;
  const ImageU8 captured = capture(world, {frame, frame}, options)[1];
  RoomViewOptions as_captured;
  as_captured.camera_blur_px = 0.6;
  as_captured.noise = {2, 0.01};
  as_captured.seed = 7;
  as_captured.samples_per_axis = 3;
  const RigProjector& projector = world.rig.projector();
  RoomLight light{projector.projector, projector.rig_from_projector, {frame, frame}};
  light.blur_px = 0.5;
  // capture() exposes for the sheet's brightest corner.
  const Vec3 lamp = world.rig_from_board.inverse() * projector.rig_from_projector.translation;
  double brightest = 0;
  for (const Vec3& corner : sheet_corners_in_board(world.board))
    brightest = std::max(
        brightest,
        0.8 * (std::abs((lamp - corner).normalized().z()) / (lamp - corner).squaredNorm() + world.ambient));
  as_captured.exposure = 200 / brightest;
  const RoomView view =
      room_view(room, world.rig.camera().camera, world.rig.camera().rig_from_camera, {light}, as_captured);
  const ProjectorMap map = projector_map(world);
  int differing = 0;
  for (int row = 0; row < captured.height(); ++row)
    for (int column = 0; column < captured.width(); ++column) {
      differing += std::abs(view.captures[1].at(column, row) - captured.at(column, row)) > 1;
      if (row == 0 || column == 0 || row == captured.height() - 1 || column == captured.width() - 1) continue;
      if (map.lit.at(column, row) && view.truth.light[0].lit.at(column, row) &&
          seen_alike_around(view.truth, column, row)) {
        EXPECT_NEAR(view.truth.light[0].pixel.at(column, row, 0), map.pixel.at(column, row, 0), 0.01);
      }
    }
  EXPECT_EQ(differing, 0);
}

TEST(RoomView, IsTheSameForAnyNumberOfThreadsAndAnotherForAnotherSeed) {
  const Room room = lopsided_room();
  const Camera camera = room_camera({160, 128});
  RoomViewOptions options;
  options.noise = {2, 0.01};
  options.camera_blur_px = 0.5;
  options.seed = 5;
  const auto pixels = [&] {
    const ImageU8 image = room_view(room, camera, room_from_camera(), {room_light()}, options).image();
    return std::vector<std::uint8_t>(image.data(), image.data() + 160 * 128);
  };
  options.threads = 1;
  const auto alone = pixels();
  options.threads = 3;
  EXPECT_EQ(alone, pixels());
  options.seed = 6;
  EXPECT_NE(alone, pixels());
}

TEST(RoomView, RefusesWhatCannotBe) {
  Room room = lopsided_room();
  const Camera camera = room_camera({64, 48});
  const auto view = [&](const std::vector<RoomLight>& lights, const RoomViewOptions& options = {}) {
    return room_view(room, camera, room_from_camera(), lights, options);
  };
  EXPECT_THROW(view({room_light(ImageU8(390, 512))}), std::invalid_argument);
  EXPECT_THROW(view({room_light(ImageU8(512, 390, 2))}), std::invalid_argument);
  RoomLight two = room_light();
  two.frames.push_back(two.frames[0]);
  EXPECT_THROW(view({room_light(), two}), std::invalid_argument);
  RoomViewOptions options;
  options.samples_per_axis = 0;
  EXPECT_THROW(view({room_light()}, options), std::invalid_argument);
  options = {};
  options.gamma = -1;
  EXPECT_THROW(view({room_light()}, options), std::invalid_argument);
  options = {};
  options.lens.aperture = -0.01;
  EXPECT_THROW(view({room_light()}, options), std::invalid_argument);
  options = {};
  options.crosstalk = 0.5;
  EXPECT_THROW(view({room_light()}, options), std::invalid_argument);
  RoomLight unfocused = room_light();
  unfocused.lens.focus = 0;
  EXPECT_THROW(view({unfocused}), std::invalid_argument);
  room.ambient = 0;
  EXPECT_THROW(view({}), std::invalid_argument);  // no light at all
  room.bodies[0].paint = 1.2;
  EXPECT_THROW(view({room_light()}), std::invalid_argument);
  room = lopsided_room();
  room.bodies[std::size_t(room.index_of("ball"))].paint = test::lopsided_world().board;
  EXPECT_THROW(view({room_light()}), std::invalid_argument);
}

}  // namespace
}  // namespace procam::simulate
