// Poses from a localiser in this program, without a network.
//
// A robot drives past a wall at 0.5 m/s. Its localiser gives ten poses a second, each 60 ms old when it arrives, and the light
// of a frame leaves the projector 40 ms after drawing. Each frame is drawn for the predicted pose at its light: 10 mm inside
// the content's edge the wall is lit, 10 mm outside it is dark. Drawn for the newest pose, the edge would be 50 to 100 mm off.
#include <cstdio>

#include "procam/show/projection.hpp"

using namespace procam;

namespace {

constexpr double kSpeed = 0.5, kPoseInterval = 0.1, kPoseAge = 0.06, kDelay = 0.04;  // m/s, seconds

/// The robot looks along the world's y axis; the projector's frame is x right, y down, z forward.
Pose world_from_base(double time) {
  return {Eigen::Quaterniond::Identity(), Vec3(-1.0 + kSpeed * time, 0.0, 0.4)};
}

Rig make_rig() {
  const Projector projector{{{1024, 768}, {1880, 1893, 502, 405, 0.4}, NoDistortion{}}};
  Rig rig;
  rig.projectors.push_back({"projector", projector, Pose::identity()});
  return rig;
}

show::Show make_show() {
  PlanarSurface wall;
  wall.frame_from_surface = {Eigen::Quaterniond(Eigen::AngleAxisd(-1.5707963, Vec3::UnitX())),
                             Vec3(0.0, 2.2, 0.4)};
  wall.content = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  wall.points = {{-0.3, -0.2}, {0.3, -0.2}, {0.3, 0.2}, {-0.3, 0.2}};
  Surface surface;
  surface.name = "wall";
  surface.geometry = wall;
  return {{{surface}}, {device::open_content("#40a0ff")}};
}

}  // namespace

int main() {
  show::ProjectionOptions options;
  // The projector's axes in the base's frame, and the age of a pose when it arrives.
  options.child_from_rig = {Eigen::Quaterniond(Eigen::AngleAxisd(-1.5707963, Vec3::UnitX())), Vec3::Zero()};
  options.track.delay = kPoseAge;
  const Rig rig = make_rig();
  show::Projection projection(rig, options);
  projection.set_show(make_show());
  ImageU8 frame(projection.frame_size(), 3);

  int wrong = 0, frames = 0;
  double next_pose = 0;
  for (double now = 0; now < 3.5; now += 1.0 / 60) {
    for (; next_pose + kPoseAge <= now; next_pose += kPoseInterval) {
      track::StampedPose pose;  // as the robot's own localiser gives it
      pose.stamp = next_pose;
      pose.arrival = next_pose + kPoseAge;
      pose.frame = "map";
      pose.child = "base";
      pose.frame_from_child = world_from_base(next_pose);
      projection.add(pose);
    }
    if (now < 1) continue;  // the prediction learns the robot's speed
    const double light = now + kDelay;
    projection.draw(light, now, frame);

    const Pose projector_from_world = (world_from_base(light) * options.child_from_rig).inverse();
    for (const double x : {-0.31, -0.29, 0.29, 0.31}) {
      const auto pixel = projection.projector().project(projector_from_world * Vec3(x, 2.2, 0.4));
      if (!pixel) continue;
      const int column = int(std::lround(pixel->x())), row = int(std::lround(pixel->y()));
      if (column < 0 || row < 0 || column >= frame.width() || row >= frame.height()) continue;
      ++frames;
      if ((frame.at(column, row, 2) > 128) != (std::abs(x) < 0.3)) ++wrong;
    }
  }
  std::printf("%d points on both sides of the content's edges, %d of them wrong\n", frames, wrong);
  return frames > 100 && wrong == 0 ? 0 : 1;
}
