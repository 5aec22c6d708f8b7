// A rig on an arm, and one on a pan-tilt head: calibrated by a motion of a minute before markers (docs/mount.md):
//
//   13_arm_and_head picture.png OUT
//
// The controller reports poses of the flange, the head two angles. Eight markers of known pose hang in the room. The calibration
// finds the rig on the flange, or the head's two axes and the rig on the tilting part, where the carrier stands, and the delay
// of its stamps. Then the carrier moves, and the rig projects on a wall: with what drawing and ruler say, and as calibrated.
// OUT/arm.mp4 and OUT/head.mp4 have both side by side, OUT/arm.png and OUT/head.png a moment, OUT/arm_error.svg and
// OUT/head_error.svg the true error over time. The program fails unless the calibrated ones are within 3 mm RMS.
#include <array>
#include <cstdio>
#include <functional>
#include <iostream>

#include "../common/error_plot.hpp"
#include "../common/stage.hpp"
#include "procam/calibrate/mount.hpp"
#include "procam/core/geometry/se3.hpp"
#include "procam/simulate/mount_motion.hpp"
#include "procam/track/head_angles.hpp"

using namespace procam;

namespace {

constexpr double kFramesPerSecond = 12, kBegin = 1, kEnd = 7, kMessages = 50, kDisplayDelay = 0.04;
const Vec2 kPoster(0.54, 0.36);  // metres

/// What a drawing and a ruler say of a pose.
Pose by_ruler(const Pose& truth) {
  return Pose(so3_exp(Vec3(0.012, -0.015, 0.018)) * truth.rotation,
              truth.translation + Vec3(0.007, -0.006, 0.004));
}

/// A carrier, as it is and as one of the two shows takes it.
struct Carrier {
  std::string name;
  Pose child_from_rig;         ///< the truth
  double stamp_delay = 0;      ///< of the reports
  double found_delay = 0;      ///< by the calibration
  std::array<Pose, 2> mounts;  ///< by ruler, calibrated
  std::function<Pose(double)> world_from_child;
  std::function<track::StampedPose(double, int)> report;  ///< at a time, as the first or second show takes it
};

std::vector<MarkerSighting> seen(const simulate::MarkerSightings& made) {
  std::vector<MarkerSighting> sightings;
  for (const track::StampedPose& message : made.messages)
    sightings.push_back({*message.stamp, message.frame, {message.frame_from_child, *message.covariance}});
  return sightings;
}

/// They hang in the room, in which the carrier stands.
calibrate::MountOptions with_markers(const simulate::MarkerSightings& made, const Pose& world_from_carrier) {
  calibrate::MountOptions options;
  for (const PlacedMarker& marker : made.markers)
    options.markers.push_back({"marker_" + std::to_string(marker.id),
                               {world_from_carrier * marker.world_from_marker, Mat6::Zero()}});
  return options;
}

Carrier arm() {
  constexpr std::uint64_t kSeed = 3;
  simulate::ArmMotionOptions motion;
  motion.seed = kSeed;
  const simulate::MountDrive made =
      simulate::mount_drive(simulate::arm_motion(motion).drive, simulate::arm_options(kSeed));
  const Pose place = simulate::world_from_carrier(kSeed);
  MountData data;
  for (const track::StampedPose& pose : made.base) data.base.push_back({*pose.stamp, pose.frame_from_child});
  data.sightings = seen(made.sightings);
  calibrate::MountOptions options = with_markers(made.sightings, place);
  options.carrier = calibrate::MountCarrier::kFlange;
  options.position_sigma = 0.0002;
  options.rotation_sigma = 0.02 * kDegree;
  const calibrate::MountResult found = calibrate::calibrate_mount(data, options);

  Carrier carrier{"arm", made.sightings.base_from_rig, made.time_offset, found.time_offset, {}, {}, {}};
  carrier.mounts = {by_ruler(carrier.child_from_rig), found.base_from_rig.pose};
  const auto base_from_flange = [middle = made.base[made.base.size() / 2].frame_from_child](double t) {
    Vec6 moved;
    moved << 0.06 * std::sin(0.9 * t), 0.10 * std::sin(0.7 * t), 0.05 * std::sin(t), 0.05 * std::sin(0.8 * t),
        0.04 * std::sin(0.6 * t), 0;
    return Pose(middle * se3_exp(moved));
  };
  carrier.world_from_child = [=](double t) { return place * base_from_flange(t); };
  const std::array<Pose, 2> places{by_ruler(place), found.world_from_base->pose};
  carrier.report = [=](double t, int show) {
    track::StampedPose message;
    message.frame_from_child = places[std::size_t(show)] * base_from_flange(t);
    return message;
  };
  return carrier;
}

Carrier head() {
  simulate::HeadRunOptions motion;
  motion.seed = 3;
  const simulate::HeadRun made = simulate::head_run(motion);
  const Pose place = simulate::world_from_carrier(motion.seed);
  MountData data;
  data.angles = made.angles;
  data.sightings = seen(made.sightings);
  calibrate::MountOptions options = with_markers(made.sightings, place);
  options.carrier = calibrate::MountCarrier::kHead;
  options.position_sigma = 0.00002;
  options.rotation_sigma = 0.018 * kDegree;
  const calibrate::MountResult found = calibrate::calibrate_mount(data, options);

  Carrier carrier{"head", made.sightings.base_from_rig, made.time_offset, found.time_offset, {}, {}, {}};
  carrier.mounts = {by_ruler(carrier.child_from_rig), found.base_from_rig.pose};
  const auto pan = [](double t) { return 0.14 * std::sin(0.9 * t); };
  const auto tilt = [](double t) { return 0.06 * std::sin(0.7 * t); };
  carrier.world_from_child = [=, axes = made.axes](double t) {
    return place * head_from_tilt(axes, pan(t), tilt(t));
  };
  // The data sheet's axes meet at a right angle.
  const std::array<track::PlacedHead, 2> heads{
      track::PlacedHead{{0.04, kPi / 2}, by_ruler(place), "world", "tilt"},
      track::PlacedHead{*found.axes, found.world_from_base->pose, "world", "tilt"}};
  carrier.report = [=](double t, int show) {
    const double step = 0.05 * kDegree;  // of the encoders
    track::StampedAngles angles;
    angles.pan = step * std::round(pan(t) / step);
    angles.tilt = step * std::round(tilt(t) / step);
    return track::pose_of(angles, heads[std::size_t(show)]);
  };
  return carrier;
}

/// Before the projector in the middle of the motion, turned a little.
Pose world_from_middle(const Rig& rig, const Carrier& carrier) {
  const Pose world_from_rig = carrier.world_from_child(0) * carrier.child_from_rig;
  const Ray ray = *rig.projector().projector.emit(Vec2(400, 300));
  const Vec3 middle = rig.projector().rig_from_projector * Vec3(2.0 * ray.direction);
  return world_from_rig * Pose(so3_exp(Vec3(0.05, 0.25, 0)), middle);
}

simulate::Room room(const Pose& middle) {
  simulate::Room room;
  room.ambient = 0.05;
  room.bodies.push_back(examples::sheet("wall", {-2, -1.5}, {2, 1.5}, 0.75, middle));
  examples::add_tape(room, kPoster, 0.012, middle, 0.75);
  return room;
}

show::Projection projection(const Rig& rig, const Carrier& carrier, std::size_t i, const Pose& middle,
                            const ImageU8& picture) {
  show::ProjectionOptions options;
  options.child_from_rig = carrier.mounts[i];
  options.track.delay = carrier.found_delay;
  show::Projection projection(rig, options);
  projection.set_show(examples::one_surface("poster", "world", middle, kPoster, picture));
  return projection;
}

/// RMS of the calibrated show, millimetres.
double demonstrate(const Carrier& carrier, const ImageU8& picture, const std::filesystem::path& out) {
  const Rig rig = examples::carried_rig();
  const Pose wall = world_from_middle(rig, carrier);
  const simulate::Room place = room(wall);
  std::array<show::Projection, 2> shows{projection(rig, carrier, 0, wall, picture),
                                        projection(rig, carrier, 1, wall, picture)};
  examples::Spectator spectator;
  spectator.room_from_eye = wall * Pose(so3_exp(Vec3(-0.04, -0.25, 0)), Vec3(0.42, -0.06, -1.75));
  examples::SideBySide video(out / (carrier.name + ".mp4"), spectator.eye.size, kFramesPerSecond);
  examples::ErrorPlot plot{"by drawing and ruler", "by calibrate-mount", {}, {}, {}, {}};
  ImageU8 frame(shows[0].frame_size(), 3);
  std::array<double, 2> sums{0, 0};
  double next = 0, worst = 0;
  for (double light = 0.3; light < kEnd; light += 1 / kFramesPerSecond) {
    for (; next + carrier.stamp_delay <= light - kDisplayDelay; next += 1 / kMessages)
      for (int i = 0; i < 2; ++i) {
        track::StampedPose message = carrier.report(next, i);
        message.arrival = next + carrier.stamp_delay;
        message.frame = "world";
        message.child = "carrier";
        shows[std::size_t(i)].add(message);
      }
    const Pose world_from_lamp =
        carrier.world_from_child(light) * carrier.child_from_rig * rig.projector().rig_from_projector;
    std::array<double, 2> errors{0, 0};
    for (std::size_t i = 0; i < 2; ++i) {
      shows[i].draw(light, light, frame);
      const Pose drawn =
          std::get<PlacedPlane>(shows[i].solved().surfaces[0].placement).projector_from_surface;
      errors[i] = examples::squared_error(rig.projector().projector, drawn, rig.projector().projector,
                                          world_from_lamp.inverse() * wall, kPoster);
      char words[64];
      std::snprintf(words, sizeof words, "%s: %.1f mm off", i == 0 ? "by ruler" : "calibrated",
                    1e3 * std::sqrt(errors[i]));
      video.put(int(i), spectator.view(place, rig.projector().projector, world_from_lamp, frame), words);
    }
    video.add();
    if (light < kBegin) continue;
    plot.add(light, std::sqrt(errors[0]), std::sqrt(errors[1]));
    for (std::size_t i = 0; i < 2; ++i) sums[i] += errors[i];
    if (errors[0] > worst) worst = errors[0], video.save(out / (carrier.name + ".png"));
  }
  video.finish();
  plot.save(out / (carrier.name + "_error.svg"));
  const auto rms_mm = [&](double sum) { return 1e3 * std::sqrt(sum / double(plot.time.size())); };
  const Vec3 ahead(0, 0, 2);
  std::printf(
      "%s: two metres ahead the rig is %.2f mm off on it; on the wall by ruler %.1f mm, calibrated %.1f mm RMS\n",
      carrier.name.c_str(), 1e3 * (carrier.mounts[1] * ahead - carrier.child_from_rig * ahead).norm(),
      rms_mm(sums[0]), rms_mm(sums[1]));
  return rms_mm(sums[1]);
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 3) {
    std::cerr << "usage: 13_arm_and_head picture.png OUT\n";
    return 2;
  }
  const ImageU8 picture = io::load_image(argv[1]).image;
  double worst_mm = 0;
  for (const Carrier& carrier : {arm(), head()})
    worst_mm = std::max(worst_mm, demonstrate(carrier, picture, argv[2]));
  return worst_mm < 3 ? 0 : 1;
} catch (const Error& error) {
  std::cerr << error.what() << "\n";
  return 3;
}
