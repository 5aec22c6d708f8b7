// The place of the rig on its robot: measured by a ruler, and calibrated by a drive of a minute (docs/mount.md):
//
//   09_mount picture.png OUT
//
// The robot drives past eight markers on the walls. Its localiser and the rig's camera record; where the markers hang is not
// known. The calibration finds the mount and the delay of the localiser. Then the robot moves before a wall and projects on it,
// with the mount by ruler (10 mm and 1.5 degrees off) and with the calibrated one. OUT/mount.mp4 has both side by side,
// OUT/mount.png the moment at which the first is worst, OUT/mount_error.svg the true error over time. The program fails unless the
// calibrated mount has less than a third of the error, and the mount is within 5 mm two metres ahead.
#include <array>
#include <cstdio>
#include <iostream>

#include "../common/error_plot.hpp"
#include "../common/stage.hpp"
#include "procam/calibrate/mount.hpp"
#include "procam/core/geometry/se3.hpp"
#include "procam/simulate/mount_drive.hpp"
#include "procam/simulate/robot.hpp"

using namespace procam;

namespace {

constexpr double kFramesPerSecond = 12, kSettled = 1, kDisplayDelay = 0.04;
constexpr double kPositionSigma = 0.002, kRotationSigma = 0.05 * kDegree, kLocaliserDelay = 0.08;
const Vec2 kPoster(0.54, 0.36);  // metres

simulate::MountDrive recorded_drive() {
  simulate::MountDriveOptions options;
  options.position_sigma = kPositionSigma;
  options.rotation_sigma = kRotationSigma;
  options.latency = kLocaliserDelay;
  options.seed = 5;
  return simulate::mount_drive(simulate::random_walk(0.5, 60, 5), options);
}

calibrate::MountResult calibrated(const simulate::MountDrive& drive) {
  MountData data;
  for (const track::StampedPose& message : drive.base)
    data.base.push_back({*message.stamp, message.frame_from_child});
  for (const track::StampedPose& message : drive.sightings.messages)
    data.sightings.push_back(
        {*message.stamp, message.frame, {message.frame_from_child, *message.covariance}});
  calibrate::MountOptions options;
  // The drive cannot observe it; measured by ruler.
  options.height = calibrate::MountHeight{drive.sightings.base_from_rig.translation.z() + 0.001, 0.002};
  return calibrate::calibrate_mount(data, options);
}

/// A bit ahead and back, turning: the base stays on the floor.
simulate::Drive before_the_wall() {
  const auto leg = [](double ahead, double turn, double seconds) {
    Vec6 increment;
    increment << 0, 0, turn, ahead, 0, 0;
    return simulate::Leg{increment, seconds, true};
  };
  return simulate::Drive(Pose(), {leg(0.12, 0.1, 2), leg(-0.2, -0.2, 3), leg(0.08, 0.1, 2)});
}

/// Where the light falls when the robot stands at its start.
Pose world_from_middle(const Rig& rig, const Pose& base_from_rig) {
  const Pose base_from_projector = base_from_rig * rig.projector().rig_from_projector;
  const Ray ray = *rig.projector().projector.emit(Vec2(400, 300));
  const Vec3 middle = base_from_projector * Vec3(2.2 * ray.direction);
  // An upright wall: x to the right, y down, z ahead, and turned a little.
  Mat3 upright;
  upright << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return Pose(so3_exp(Vec3(0, 0, 0.2)) * Eigen::Quaterniond(upright), middle);
}

simulate::Room room(const Pose& world_from_middle) {
  simulate::Room room;
  room.ambient = 0.05;
  room.bodies.push_back(examples::sheet("wall", {-2, -1.2}, {2, 1}, 0.75, world_from_middle));
  examples::add_tape(room, kPoster, 0.012, world_from_middle, 0.75);
  return room;
}

show::Projection projection(const Rig& rig, const Pose& base_from_rig, double localiser_delay,
                            const Pose& world_from_middle, const ImageU8& picture) {
  show::ProjectionOptions options;
  options.child_from_rig = base_from_rig;
  options.track.delay = localiser_delay;
  show::Projection projection(rig, options);
  projection.set_show(examples::one_surface("poster", "world", world_from_middle, kPoster, picture));
  return projection;
}

std::vector<simulate::LocalisedPose> localised(const simulate::Drive& drive) {
  simulate::Localiser localiser;
  localiser.rate = 30;
  localiser.delay = kLocaliserDelay;
  localiser.position_sigma = kPositionSigma;
  localiser.rotation_sigma = kRotationSigma;
  localiser.seed = 3;
  return localise(drive, localiser);
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 3) {
    std::cerr << "usage: 09_mount picture.png OUT\n";
    return 2;
  }
  const std::filesystem::path out = argv[2];
  const ImageU8 picture = io::load_image(argv[1]).image;
  const Rig rig = examples::carried_rig();
  const simulate::MountDrive recording = recorded_drive();
  const Pose truth = recording.sightings.base_from_rig;
  const Pose by_ruler(so3_exp(Vec3(0.012, -0.015, 0.018)) * truth.rotation,
                      truth.translation + Vec3(0.007, -0.006, 0.004));
  const calibrate::MountResult mount = calibrated(recording);
  const Vec3 ahead(0, 0, 2);  // of the rig
  const double mount_mm = 1e3 * (mount.base_from_rig.pose * ahead - truth * ahead).norm();
  std::printf(
      "two metres ahead: mount by ruler %.1f mm off, calibrated %.1f mm; delay of the localiser %.1f ms\n",
      1e3 * (by_ruler * ahead - truth * ahead).norm(), mount_mm, 1e3 * mount.time_offset);

  const Pose wall = world_from_middle(rig, truth);
  const simulate::Room place = room(wall);
  // The third, with the true mount, shows what localiser and prediction leave.
  std::array<show::Projection, 3> shows{
      projection(rig, by_ruler, mount.time_offset, wall, picture),
      projection(rig, mount.base_from_rig.pose, mount.time_offset, wall, picture),
      projection(rig, truth, mount.time_offset, wall, picture)};
  const std::array<const char*, 2> names{"mount by ruler", "calibrated mount"};
  examples::Spectator spectator;
  spectator.room_from_eye = wall * Pose(so3_exp(Vec3(-0.04, -0.25, 0)), Vec3(0.42, -0.06, -1.75));
  examples::SideBySide video(out / "mount.mp4", spectator.eye.size, kFramesPerSecond);
  examples::ErrorPlot plot{"mount by ruler", "mount by calibrate-mount", {}, {}, {}, {}};
  const simulate::Drive drive = before_the_wall();
  const std::vector<simulate::LocalisedPose> messages = localised(drive);
  ImageU8 frame(shows[0].frame_size(), 3);
  std::array<double, 3> sums{0, 0, 0};
  std::size_t arrived = 0;
  int judged = 0;
  double worst = 0;
  for (double light = 0.3; light < drive.end_time(); light += 1 / kFramesPerSecond) {
    for (; arrived < messages.size() && messages[arrived].arrival <= light - kDisplayDelay; ++arrived) {
      track::StampedPose message;
      message.arrival = messages[arrived].arrival;
      message.frame = "world";
      message.child = "base";
      message.frame_from_child = messages[arrived].measured;
      for (show::Projection& show : shows) show.add(message);
    }
    const Pose world_from_lamp = drive.world_from_rig(light) * truth * rig.projector().rig_from_projector;
    std::array<double, 3> errors{0, 0, 0};
    for (std::size_t i = 0; i < 3; ++i) {
      shows[i].draw(light, light, frame);
      const Pose drawn =
          std::get<PlacedPlane>(shows[i].solved().surfaces[0].placement).projector_from_surface;
      errors[i] = examples::squared_error(rig.projector().projector, drawn, rig.projector().projector,
                                          world_from_lamp.inverse() * wall, kPoster);
      if (i == 2) continue;
      char words[64];
      std::snprintf(words, sizeof words, "%s: %.0f mm off", names[i], 1e3 * std::sqrt(errors[i]));
      video.put(int(i), spectator.view(place, rig.projector().projector, world_from_lamp, frame), words);
    }
    video.add();
    if (light < kSettled) continue;
    plot.add(light, std::sqrt(errors[0]), std::sqrt(errors[1]));
    for (std::size_t i = 0; i < 3; ++i) sums[i] += errors[i];
    ++judged;
    if (errors[0] > worst) worst = errors[0], video.save(out / "mount.png");
  }
  video.finish();
  plot.save(out / "mount_error.svg");
  const double ruler_mm = 1e3 * std::sqrt(sums[0] / judged),
               calibrated_mm = 1e3 * std::sqrt(sums[1] / judged), true_mm = 1e3 * std::sqrt(sums[2] / judged);
  std::printf(
      "on the wall, RMS of %d frames: mount by ruler %.1f mm, calibrated %.1f mm, true mount %.1f mm\n",
      judged, ruler_mm, calibrated_mm, true_mm);
  return calibrated_mm < ruler_mm / 3 && mount_mm < 5 ? 0 : 1;
} catch (const Error& error) {
  std::cerr << error.what() << "\n";
  return 3;
}
