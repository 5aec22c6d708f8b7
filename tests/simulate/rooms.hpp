#pragma once
/// A lopsided room for the tests: six surfaces, a table with things on it, sheets on the walls, a rig of a
/// camera and a projector before them. The world is z up, metres.
#include "procam/simulate/room_view.hpp"
#include "worlds.hpp"

namespace procam::simulate::test {

/// An optical frame at `eye` that looks at `target`, turned by `roll` about its axis.
inline Pose looking_at(const Vec3& eye, const Vec3& target, double roll = 0) {
  const Vec3 z = (target - eye).normalized(), x = z.cross(Vec3::UnitZ()).normalized();
  Mat3 axes;
  axes << x, z.cross(x), z;
  return Pose(axes, eye) * Pose(so3_exp(Vec3(0, 0, roll)), Vec3::Zero());
}

/// A rectangle about `middle` that is seen from where `normal` points, `up` on the sheet turned by `roll`.
inline Body hung(const std::string& name, const Vec3& middle, const Vec3& normal, const Vec2& size,
                 const Paint& paint, double roll = 0) {
  const Vec3 up = std::abs(normal.normalized().z()) > 0.9 ? Vec3(Vec3::UnitY()) : Vec3(Vec3::UnitZ());
  const Vec3 z = -normal.normalized(), x = z.cross(up).normalized();
  Mat3 axes;
  axes << x, z.cross(x), z;
  return {name, Rectangle{-0.5 * size, 0.5 * size},
          Pose(axes, middle) * Pose(so3_exp(Vec3(0, 0, roll)), Vec3::Zero()), paint};
}

/// Codes of 4 x 4 cells without symmetry.
inline MarkerCells some_codes() {
  return {
      4,
      0,
      {{1, 0, 0, 1, 1, 1, 0, 0, 0, 1, 0, 1, 0, 0, 1, 1}, {0, 1, 1, 1, 0, 0, 1, 0, 1, 0, 0, 0, 1, 1, 0, 1}}};
}

/// Grey ramps and a dark corner: every side is another.
inline Texture poster(int width = 48, int height = 32) {
  Texture picture;
  picture.image = ImageU8(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      picture.image.at(x, y) =
          std::uint8_t(x < 8 && y < 8 ? 0 : 60 + 100 * x / width + ((x / 4 + y / 4) % 2 ? 80 : 0));
  return picture;
}

inline Room lopsided_room() {
  Room room;
  room.ambient = 0.02;
  auto& b = room.bodies;
  b.push_back(hung("far wall", Vec3(0.3, 3.1, 1.2), Vec3(-0.06, -1, 0), Vec2(5.2, 2.9), 0.62));
  b.push_back(hung("left wall", Vec3(-1.9, 1.0, 1.2), Vec3(1, 0.04, 0), Vec2(5.5, 2.9), 0.55));
  b.push_back(hung("right wall", Vec3(2.2, 1.0, 1.2), Vec3(-1, 0.02, 0), Vec2(5.5, 2.9), 0.5));
  b.push_back(hung("floor", Vec3(0.2, 1.0, -0.2), Vec3(0, 0, 1), Vec2(4.6, 5.6), 0.35));
  b.push_back(hung("ceiling", Vec3(0.2, 1.0, 2.6), Vec3(0, 0, -1), Vec2(4.6, 5.6), 0.7));
  // A table top of six corners on a block, with a ball, a can and a tilted block on it.
  b.push_back({"table",
               Polygon{{Vec2(-0.7, -0.3), Vec2(0.5, -0.36), Vec2(0.75, -0.1), Vec2(0.7, 0.3),
                        Vec2(-0.6, 0.34), Vec2(-0.8, 0.05)}},
               Pose(so3_exp(Vec3(0, 0, 0.12)), Vec3(0.15, 2.1, 0.55)), 0.75});
  for (const Body& face :
       box("foot", Pose(so3_exp(Vec3(0, 0, 0.12)), Vec3(-0.1, 1.98, -0.2)), Vec3(0.5, 0.3, 0.74), 0.4))
    b.push_back(face);
  for (const Body& face : box("parcel", Pose(so3_exp(Vec3(0, 0, 0.6)), Vec3(-0.25, 2.02, 0.55)),
                              Vec3(0.31, 0.17, 0.23), poster()))
    b.push_back(face);
  b.push_back(
      {"ball", Sphere{0.16}, Pose(so3_exp(Vec3(0.4, -0.3, 1.1)), Vec3(0.31, 2.02, 0.71)), poster(64, 32)});
  b.push_back({"can", Cylinder{0.07, 0, 0.27}, Pose(so3_exp(Vec3(0.02, 0.05, 0)), Vec3(0.6, 2.2, 0.55)),
               poster(40, 20)});
  b.push_back({"niche", Cylinder{0.5, 0.2, 1.9, {-2.9, -0.7}},
               Pose(so3_exp(Vec3(0, 0, 2.6)), Vec3(1.45, 2.6, 0)), 0.66});
  b.push_back(hung("poster", Vec3(-0.62, 3.0, 1.25), Vec3(-0.05, -1, 0.03), Vec2(0.9, 0.6), poster(), 0.1));
  PrintedBoard board{Chessboard{8, 5, 0.061}, 0.05, 0.8, 0.05};
  b.push_back(printed_sheet("board", board, looking_at(Vec3(0.25, 2.85, 1.5), Vec3(0.4, 3.9, 1.45), -0.1)));
  b.push_back(marker_sheet({1, 0.22, Pose(looking_at(Vec3(1.0, 2.95, 1.75), Vec3(1.05, 3.9, 1.8), 0.2))},
                           some_codes()));
  return room;
}

inline Camera room_camera(ImageSize size = {640, 512}) {
  const double k = size.width / 640.0;
  return {size, {505 * k, 512 * k, 321 * k, 247 * k, 0.7}, BrownConrady{{-0.16, 0.05, 0.0011, -0.0008, 0}}};
}
inline Pose room_from_camera() {
  return looking_at(Vec3(-0.2, -0.35, 1.15), Vec3(0.05, 2.5, 0.95), 0.03);
}

inline RoomLight room_light(const ImageU8& frame = ImageU8(512, 390, 1, 255)) {
  RoomLight light;
  light.projector = {
      {{512, 390}, {600, 607, 250, 371, -0.9}, BrownConrady{{-0.09, 0.03, -0.0007, 0.0009, 0}}}};
  light.room_from_projector = looking_at(Vec3(0.25, -0.2, 0.95), Vec3(0.2, 2.5, 0.75), -0.05);
  light.frames = {frame};
  return light;
}

}  // namespace procam::simulate::test
