#include "procam/simulate/scan_view.hpp"

#include <cmath>

#include "procam/core/base/closed_form.hpp"
#include "procam/core/geometry/se3.hpp"

namespace procam::simulate {
namespace {

Pose turned(const Vec3& rotation, const Vec3& translation) {
  return Pose(so3_exp(rotation), translation);
}

Body far_wall() {
  return {"wall", Rectangle{Vec2(-4, -4), Vec2(4, 4)}, turned(Vec3(0.05, -0.2, 0.02), Vec3(0.1, 0, 2)), 0.7};
}

/// Waves over a rectangle about the origin, a vertex every 20 mm; normals are interpolated between them.
std::shared_ptr<Mesh> waves(int columns, int rows) {
  auto mesh = std::make_shared<Mesh>();
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      const double x = 0.02 * i - 0.01 * (columns - 1), y = 0.02 * j - 0.01 * (rows - 1);
      mesh->vertices.push_back(
          Vec3(x, y, 0.015 * (std::sin(2 * kPi * x / 0.5) + std::sin(2 * kPi * y / 0.7))));
      mesh->uv.push_back(Vec2(double(i) / (columns - 1), double(j) / (rows - 1)));
    }
  for (int j = 0; j + 1 < rows; ++j)
    for (int i = 0; i + 1 < columns; ++i) {
      const int a = j * columns + i, b = a + 1, c = a + columns, d = c + 1;
      mesh->triangles.push_back({a, b, d});
      mesh->triangles.push_back({a, d, c});
    }
  return mesh;
}

Body wavy_wall() {
  return {"relief", TriangleMesh(waves(121, 101)), turned(Vec3(0.1, -0.25, 0.03), Vec3(0.05, 0.02, 1.6)),
          0.65};
}

/// Two walls and a floor, a ball, and a relief.
Room alcove() {
  Room room;
  const double turn = -0.12;  // of both walls about the vertical
  const Vec3 corner(0.55, 0.36, 2.0);
  room.bodies = {
      {"back", Rectangle{Vec2(-3, -3), Vec2(0, 0)}, turned(Vec3(0, turn, 0), corner), 0.7},
      {"right", Rectangle{Vec2(0, -3), Vec2(3, 0)}, turned(Vec3(0, turn + kPi / 2, 0), corner), 0.55},
      {"floor", Rectangle{Vec2(-3, -3), Vec2(0, 0)}, turned(Vec3(0, turn, 0), corner), 0.5},
      {"ball", Sphere{0.15}, turned(Vec3::Zero(), Vec3(0.1, 0.12, 1.62)), 0.75},
      {"relief", TriangleMesh(waves(31, 29)), turned(Vec3(0.08, 0.35, 0.05), Vec3(-0.5, -0.02, 1.8)), 0.65}};
  room.bodies[2].room_from_body = room.bodies[2].room_from_body * turned(Vec3(-kPi / 2, 0, 0), Vec3::Zero());
  room.bodies[2].shape = Rectangle{Vec2(-3, 0), Vec2(0, 3)};
  return room;
}

Room corner() {
  Room room;
  const double left = -0.7;  // the walls' turns about y: 90 degrees apart
  room.bodies = {
      {"left", Rectangle{Vec2(-3, -3), Vec2(0, 3)}, turned(Vec3(0, left, 0), Vec3(0.05, 0, 1.9)), 0.7},
      {"right", Rectangle{Vec2(0, -3), Vec2(3, 3)}, turned(Vec3(0, left + kPi / 2, 0), Vec3(0.05, 0, 1.9)),
       0.5}};
  return room;
}

Room steps() {
  Room room;
  room.bodies.push_back(far_wall());
  const double heights[] = {0.02, 0.05, 0.12};
  for (int i = 0; i < 3; ++i) {
    const Vec3 size(0.18, 0.4, heights[i]);
    const Pose place =
        far_wall().room_from_body * Pose(Mat3::Identity(), Vec3(-0.4 + 0.26 * i, -0.25, -heights[i]));
    for (Body& face : box(std::string("board ") + char('1' + i), place, size, 0.5 + 0.1 * i))
      room.bodies.push_back(face);
  }
  return room;
}

/// Two white walls that meet at 80 degrees, and a floor: they light each other.
Room niche() {
  Room room;
  const Vec3 corner(0.05, 0.12, 2.1);
  const double left = -0.9, right = left + 100 * kDegree;  // the walls' turns about the vertical
  room.bodies = {{"left", Rectangle{Vec2(-3, -3), Vec2(0, 1)}, turned(Vec3(0, left, 0), corner), 0.85},
                 {"right", Rectangle{Vec2(0, -3), Vec2(3, 1)}, turned(Vec3(0, right, 0), corner), 0.85},
                 {"floor", Rectangle{Vec2(-3, -3), Vec2(3, 3)}, turned(Vec3(-1.15, 0, 0), corner), 0.85}};
  room.indirect = true;
  return room;
}

/// Seen from above: walls and a floor, furniture, a lacquered table, a screen and a dark picture on the wall, a thin pole, a curtain.
Room furnished() {
  constexpr double kFloor = 0.3, kBack = 2.15, kRight = 0.55;  // metres, before the room is turned
  const auto at = [](double x, double y, double z) { return turned(Vec3::Zero(), Vec3(x, y, z)); };
  Room room;
  std::vector<Body>& bodies = room.bodies;
  bodies = {{"back", Rectangle{Vec2(-3, -3), Vec2(kRight, kFloor)}, at(0, 0, kBack), 0.7},
            {"right", Rectangle{Vec2(0, -3), Vec2(0.9, kFloor)},
             turned(Vec3(0, kPi / 2, 0), Vec3(kRight, 0, kBack)), 0.55},
            {"floor", Rectangle{Vec2(-3, -3), Vec2(kRight, 3)},
             turned(Vec3(kPi / 2, 0, 0), Vec3(0, kFloor, kBack)), 0.4},
            {"ball", Sphere{0.07}, at(-0.2, 0.03, 1.78), 0.8},
            {"screen", Rectangle{Vec2(0, 0), Vec2(0.3, 0.2)}, at(-0.35, -0.3, kBack - 0.01), 0.03},
            {"picture", Rectangle{Vec2(0, 0), Vec2(0.2, 0.25)}, at(0.05, -0.35, kBack - 0.004), 0.05},
            {"pole", Cylinder{0.008, -0.8, kFloor}, turned(Vec3(-kPi / 2, 0, 0), Vec3(0, 0, 1.75)), 0.6},
            {"curtain", TriangleMesh(waves(16, 41)), turned(Vec3(0, 0.1, 0), Vec3(-0.6, -0.12, 2.08)), 0.6}};
  bodies[4].gloss.share = 0.05;
  const auto add_box = [&](const std::string& name, const Vec3& corner, const Vec3& size, double albedo,
                           const std::string& glossy, double share) {
    for (Body& face : box(name, at(corner.x(), corner.y(), corner.z()), size, albedo)) {
      if (face.name == name + glossy) face.gloss.share = share;
      bodies.push_back(face);
    }
  };
  add_box("cabinet", Vec3(0.1, -0.04, 1.9), Vec3(0.28, 0.34, 0.22), 0.5, " -z", 0.06);
  add_box("table", Vec3(-0.42, 0.1, 1.6), Vec3(0.34, 0.025, 0.35), 0.3, " -y", 0.12);
  for (const double x : {-0.41, -0.11})
    for (const double z : {1.61, 1.92})
      add_box("leg", Vec3(x, 0.125, z), Vec3(0.02, kFloor - 0.125, 0.02), 0.3, "", 0);
  const Vec3 centre(0, 0, 1.9);
  const Pose turn = turned(Vec3(0.42, 0.2, 0), Vec3::Zero());
  for (Body& body : bodies)
    body.room_from_body =
        Pose(Mat3::Identity(), centre) * turn * Pose(Mat3::Identity(), -centre) * body.room_from_body;
  room.indirect = true;
  return room;
}

}  // namespace

const std::vector<std::string>& scan_scenes() {
  static const std::vector<std::string> names = {"sphere", "cylinder", "corner", "relief", "steps",
                                                 "alcove", "wall",     "ball",   "niche",  "furnished"};
  return names;
}

Room scan_scene(const std::string& name) {
  Room room;
  if (name == "sphere") {
    room.bodies = {far_wall(), {"sphere", Sphere{0.35}, turned(Vec3::Zero(), Vec3(0.05, -0.1, 1.55)), 0.75}};
  } else if (name == "cylinder") {
    room.bodies = {
        far_wall(),
        {"cylinder", Cylinder{0.25, -0.6, 0.6}, turned(Vec3(1.4, 0.1, 0.2), Vec3(0.1, -0.05, 1.5)), 0.6}};
  } else if (name == "corner") {
    room = corner();
  } else if (name == "relief") {
    room.bodies = {wavy_wall()};
  } else if (name == "steps") {
    room = steps();
  } else if (name == "alcove") {
    room = alcove();
  } else if (name == "niche") {
    room = niche();
  } else if (name == "furnished") {
    room = furnished();
  } else if (name == "wall") {
    room.bodies = {far_wall()};
  } else if (name == "ball") {
    room.bodies = {{"ball", Sphere{0.4}, turned(Vec3::Zero(), Vec3(0.02, -0.03, 1.8)), 0.75}};
  } else {
    std::string known;
    for (const std::string& scene : scan_scenes()) known += (known.empty() ? "" : ", ") + scene;
    throw Error(ErrorKind::kUnsupported, "room '" + name + "'", "there is no such room",
                "use one of: " + known);
  }
  room.ambient = 0.02;
  return room;
}

RoomView scan_view(const SimulatedSession& session, const Room& room, const std::vector<ImageU8>& frames) {
  require(!session.views.empty(), "scan_view: the session has no view");
  return scan_view(session.capture, room, session.rig().camera(), session.rig().projector(), frames);
}

RoomView scan_view(const CaptureOptions& capture, const Room& room, const RigCamera& camera,
                   const RigProjector& projector, const std::vector<ImageU8>& frames) {
  RoomLight light;
  light.projector = projector.projector;
  light.room_from_projector = projector.rig_from_projector;
  light.frames = frames;
  light.lens = capture.projector_lens;
  light.blur_px = capture.projector_blur_px;
  RoomViewOptions options;
  options.brightest_grey = capture.brightest_grey;
  options.camera_blur_px = capture.camera_blur_px;
  options.vignetting = capture.vignetting;
  options.gamma = capture.gamma;
  options.noise = capture.noise;
  options.seed = capture.seed;
  options.adaptive = true;
  return room_view(room, camera.camera, camera.rig_from_camera, {light}, options);
}

Pose room_from_rig(int station) {
  require(station >= 0, "room_from_rig: a negative station");
  if (station == 0) return {};
  const Vec3 moves[] = {Vec3(-0.32, -0.06, 0.04), Vec3(0.36, 0.05, -0.12), Vec3(0.05, -0.2, -0.25),
                        Vec3(-0.15, 0.12, 0.2)};
  const Vec3 targets[] = {Vec3(-0.25, 0.03, 1.8), Vec3(0.22, -0.02, 1.8), Vec3(0.05, -0.08, 1.8),
                          Vec3(-0.05, 0.1, 1.8)};
  const std::size_t number = std::size_t((station - 1) % 4);
  const Vec3 move = moves[number] * (1 + 0.2 * ((station - 1) / 4));
  const Eigen::Quaterniond turn = rotation_between(Vec3::UnitZ(), Vec3(targets[number] - move).normalized());
  const Eigen::Quaterniond roll = so3_exp(Vec3(0, 0, station % 2 == 1 ? 0.05 : -0.035));
  return Pose(Eigen::Quaterniond(turn * roll), move);
}

Pose moved_camera(const Pose& rig_from_camera, int view) {
  require(view >= 0, "moved_camera: a negative view");
  if (view == 0) return rig_from_camera;
  constexpr double kTarget = 1.75;  // metres ahead of the rig's camera
  const Vec3 moves[] = {Vec3(-0.5, -0.15, 0.05), Vec3(0.25, -0.45, 0.1), Vec3(-0.3, 0.4, -0.1),
                        Vec3(0.6, 0.2, 0.0)};
  const Vec3 move = moves[(view - 1) % 4] * (1 + 0.2 * ((view - 1) / 4));
  const Vec3 before = Vec3::UnitZ(), after = (Vec3(0, 0, kTarget) - move).normalized();
  const Eigen::Quaterniond turn = rotation_between(before, after);
  const Eigen::Quaterniond roll = so3_exp(Vec3(0, 0, 0.04 * view));
  return rig_from_camera * Pose(Eigen::Quaterniond(turn * roll), move);
}

}  // namespace procam::simulate
