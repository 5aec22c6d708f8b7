#pragma once
/// What the demonstrations of a show share: a simulated wall with tape around the place of the content, somebody who looks at
/// it, two views side by side as a video, and the true error of the light.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "procam/core/geometry/plane.hpp"
#include "procam/core/geometry/se3.hpp"
#include "procam/device/content_source.hpp"
#include "procam/device/video_file.hpp"
#include "procam/io/image/images.hpp"
#include "procam/show/projection.hpp"
#include "procam/simulate/room_view.hpp"

namespace procam::examples {

inline constexpr double kTape = 0.012;  ///< width of the tape, metres

/// A camera, whose frame is the rig's (z ahead, x right, y down), and a projector beside it.
inline Rig camera_with_projector(const Intrinsics& camera, const Intrinsics& projector) {
  Rig rig;
  Vec6 place;
  place << -0.11, -0.10, 0.02, 0.31, 0.05, 0.03;
  rig.cameras.push_back(
      {"camera", {{640, 480}, camera, BrownConrady{{-0.17, 0.05, 0.0009, -0.0006, 0}}}, Pose()});
  rig.projectors.push_back({"projector",
                            {{{1024, 768}, projector, BrownConrady{{-0.04, 0.01, -0.0005, 0.0006, 0}}}},
                            se3_exp(place)});
  return rig;
}

/// A smaller rig, that a robot, an arm or a head carries.
inline Rig carried_rig() {
  Rig rig;
  Vec6 place;
  place << -0.05, -0.04, 0.02, 0.14, 0.05, 0.03;
  rig.cameras.push_back({"camera", {{1280, 960}, {1150, 1157, 652, 468, 0.4}, {}}, Pose()});
  rig.projectors.push_back(
      {"projector",
       {{{800, 600}, {1090, 1081, 411, 530, -0.5}, BrownConrady{{-0.03, 0.01, -0.0005, 0.0006, 0}}}},
       se3_exp(place)});
  return rig;
}

/// A sheet in the x, y plane of a frame, metres.
inline simulate::Body sheet(const std::string& name, const Vec2& low, const Vec2& high, double albedo,
                            const Pose& room_from_sheet) {
  return {name, simulate::Rectangle{low, high}, room_from_sheet, albedo};
}

/// A frame of black tape around content of this size, so far from its border. The origin is the middle of the content.
inline void add_tape(simulate::Room& room, const Vec2& content, double gap, const Pose& room_from_middle,
                     double albedo) {
  const Vec2 inner = 0.5 * content + Vec2(gap, gap), outer = inner + Vec2(kTape, kTape);
  room.bodies.push_back(sheet("tape", -outer, outer, 0.05, room_from_middle));
  room.bodies.push_back(sheet("inside", -inner, inner, albedo, room_from_middle));
}

/// One plane, with content of this size (metres) about its origin.
inline show::Show one_surface(const std::string& name, const std::string& frame,
                              const Pose& frame_from_middle, const Vec2& size, const ImageU8& picture) {
  PlanarSurface plane;
  plane.frame = frame;
  plane.frame_from_surface = frame_from_middle;
  plane.content = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  for (const Vec2& corner : plane.content)
    plane.points.push_back((corner - Vec2(0.5, 0.5)).cwiseProduct(size));
  show::Show show;
  show.surfaces.surfaces = {{name, plane, {}, ""}};
  show.contents = {device::still_content(picture)};
  return show;
}

/// Mean square distance on the surface, metres^2, of the light from its place: at the corners and the middle of content of
/// this size. It is drawn for `model`, and a `lamp` shows it.
inline double squared_error(const Projector& model, const Pose& model_from_middle, const Projector& lamp,
                            const Pose& lamp_from_middle, const Vec2& size) {
  double sum = 0;
  int count = 0;
  for (const Vec2& unit : {Vec2(-1, -1), Vec2(1, -1), Vec2(1, 1), Vec2(-1, 1), Vec2(0, 0)}) {
    const Vec2 meant = 0.5 * unit.cwiseProduct(size);
    const std::optional<Vec2> pixel = model.project(model_from_middle * Vec3(meant.x(), meant.y(), 0));
    if (!pixel) continue;
    const std::optional<Vec3> lit = lamp.intersect(*pixel, Plane::of_xy(lamp_from_middle));
    if (!lit) continue;
    sum += ((lamp_from_middle.inverse() * *lit).head<2>() - meant).squaredNorm();
    ++count;
  }
  if (count == 0)
    throw Error(ErrorKind::kDegenerate, "the demonstration", "the content left the light",
                "move it less far");
  return sum / count;
}

/// Somebody in the room.
struct Spectator {
  Camera eye{{480, 360}, {920, 920, 239.5, 179.5}, {}};
  Pose room_from_eye;
  simulate::RoomViewOptions look = usual_look();

  static simulate::RoomViewOptions usual_look() {
    simulate::RoomViewOptions look;
    look.colour = true;
    look.crosstalk = 0;
    look.gamma = 2.2;
    look.brightest_grey = 240;
    return look;
  }

  /// The frame in the light of a projector. One exposure for all views, that of the first.
  ImageU8 view(const simulate::Room& room, const Projector& projector, const Pose& room_from_projector,
               const ImageU8& frame) {
    std::vector<simulate::RoomLight> lamp(1);
    lamp[0].projector = projector;
    lamp[0].room_from_projector = room_from_projector;
    lamp[0].frames.push_back(frame);
    lamp[0].gamma = 2.2;
    lamp[0].intensity = 4;
    const simulate::RoomView seen = simulate::room_view(room, eye, room_from_eye, lamp, look);
    look.exposure = seen.exposure;
    return seen.image();
  }
};

/// Two views of one size, side by side.
class SideBySide {
 public:
  SideBySide(const std::filesystem::path& video, ImageSize one, double frames_per_second)
      : both_({2 * one.width, one.height}, 3), video_(video, both_.size(), frames_per_second) {}

  /// The views for the next frame, with what is written over them.
  void put(int side, const ImageU8& view, const std::string& caption) {
    const int at_x = side * (both_.width() / 2);
    for (int y = 0; y < view.height(); ++y)
      std::copy_n(view.view().row(y), view.width() * 3, both_.view().row(y) + 3 * at_x);
    cv::Mat canvas(both_.height(), both_.width(), CV_8UC3, both_.data());
    cv::putText(canvas, caption, {at_x + 16, 34}, cv::FONT_HERSHEY_SIMPLEX, 0.62, {255, 255, 255}, 1,
                cv::LINE_AA);
  }
  void add() { video_.add(both_); }
  void save(const std::filesystem::path& picture) const { io::save_image(picture, both_); }
  void finish() { video_.finish(); }

 private:
  ImageU8 both_;
  device::VideoFile video_;
};

}  // namespace procam::examples
