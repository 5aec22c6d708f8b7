// A robot drives past a wall; its localiser speaks 30 times a second, 80 ms late, with noise:
//
//   04_drive truth.json rig.json picture.png drive.mp4 [drive.png]
//
// Drawn twice with the calibrated rig: for the newest pose that is known, and for the moment of light. A true
// projector shows both in a simulated room, where a frame of black tape, three centimetres off, surrounds the
// picture's place. The video has both side by side with their errors, as somebody standing in the room sees them;
// the PNG is the moment at which the first is worst. Printed is how far off the picture's corners and centre land, and the program fails unless
// predicting makes that two and a half times less.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <string>

#include "../common/stage.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/simulate/drive.hpp"

using namespace procam;

namespace {

constexpr double kFramesPerSecond = 25, kLocaliserDelay = 0.08, kDisplayDelay = 0.04;
constexpr double kSettled = 1;   // seconds of the drive that are not judged: the filter has to begin
const Vec2 kPoster(0.54, 0.36);  // metres
constexpr double kGap = 0.03;    // between the picture and the tape, metres

/// Where the projector's light falls when the robot stands at its start, askew by 30 degrees; x right, y
/// down.
Pose world_from_wall(const Rig& truth) {
  const RigProjector& projector = truth.projector();
  const Vec2 middle(0.5 * (projector.projector.size().width - 1),
                    0.5 * (projector.projector.size().height - 1));
  const std::optional<Ray> ray = projector.projector.emit(middle);
  if (!ray)
    throw Error(ErrorKind::kDegenerate, "true projector", "its centre pixel emits no ray", "check its lens");
  const Eigen::Quaterniond turned = so3_exp(Vec3(0, 0.52, 0));
  return Pose(turned, projector.rig_from_projector * Vec3(2.2 * ray->direction));
}

/// To and fro before the wall by 0.6 m, swaying: at most 0.5 m/s.
simulate::Drive robot() {
  const auto leg = [](double along, double seconds) {
    Vec6 increment;
    increment << 0.03, 0.06 * along, 0.05 * along, along, 0.02, 0.2 * along;
    return simulate::Leg{increment, seconds, true};
  };
  return simulate::Drive(Pose(), {leg(0.3, 1.5), leg(-0.6, 2.25), leg(0.6, 2.25), leg(-0.3, 1.5)});
}

show::Projection projection(const Rig& rig, const Pose& world_from_wall, const ImageU8& picture,
                            track::Prediction prediction) {
  show::ProjectionOptions options;
  options.track.prediction = prediction;
  options.track.delay = kLocaliserDelay;
  show::Projection projection(rig, options);
  projection.set_show(examples::one_surface("poster", "world", world_from_wall, kPoster, picture));
  return projection;
}

simulate::Room room(const Pose& world_from_wall) {
  simulate::Room room;
  room.ambient = 0.05;
  room.bodies.push_back(examples::sheet("wall", {-1.6, -1.0}, {1.6, 0.75}, 0.75, world_from_wall));
  examples::add_tape(room, kPoster, kGap, world_from_wall, 0.75);
  room.bodies.push_back(
      examples::sheet("floor", {-2.5, -3}, {2.5, 0}, 0.35,
                      world_from_wall * Pose(so3_exp(Vec3(M_PI_2, 0, 0)), Vec3(0, 0.75, 0))));
  return room;
}

/// Of the true light, from where it was meant to be.
double squared_error(const Rig& truth, const Rig& rig, const Pose& true_world_from_rig,
                     const Pose& drawn_world_from_rig, const Pose& world_from_wall) {
  const RigProjector &lamp = truth.projector(), &model = rig.projector();
  return examples::squared_error(
      model.projector, (drawn_world_from_rig * model.rig_from_projector).inverse() * world_from_wall,
      lamp.projector, (true_world_from_rig * lamp.rig_from_projector).inverse() * world_from_wall, kPoster);
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc < 5 || argc > 6) {
    std::cerr << "usage: 04_drive truth.json rig.json picture.png drive.mp4 [drive.png]\n";
    return 2;
  }
  const Rig truth = io::load_rig(argv[1]), rig = io::load_rig(argv[2]);
  const ImageU8 picture = io::load_image(argv[3]).image;
  const Pose wall = world_from_wall(truth);
  const simulate::Drive drive = robot();
  simulate::Localiser localiser;
  localiser.rate = 30;
  localiser.delay = kLocaliserDelay;
  localiser.jitter = 0.004;
  localiser.position_sigma = 0.004;
  localiser.rotation_sigma = 0.15 * M_PI / 180;
  localiser.dropped = 0.02;
  localiser.seed = 3;
  const std::vector<simulate::LocalisedPose> messages = localise(drive, localiser);

  std::array<show::Projection, 2> projections{projection(rig, wall, picture, track::Prediction::kNone),
                                              projection(rig, wall, picture, track::Prediction::kAuto)};
  std::array<double, 2> sums{0, 0};
  std::size_t arrived = 0;
  int judged = 0;
  double worst = 0;

  examples::Spectator spectator;
  spectator.room_from_eye = wall * Pose(so3_exp(Vec3(0.03, -0.25, 0)), Vec3(0.42, 0.04, -1.75));
  const simulate::Room place = room(wall);
  ImageU8 frame(truth.projector().projector.size(), 3);
  examples::SideBySide video(argv[4], spectator.eye.size, kFramesPerSecond);

  for (double light = 0.3; light < drive.end_time(); light += 1 / kFramesPerSecond) {
    std::array<double, 2> errors{};
    for (; arrived < messages.size() && messages[arrived].arrival <= light - kDisplayDelay; ++arrived) {
      track::StampedPose message;
      message.stamp = messages[arrived].stamp;
      message.arrival = messages[arrived].arrival;
      message.frame = "world";
      message.child = "rig";
      message.frame_from_child = messages[arrived].measured;
      for (show::Projection& projection : projections) projection.add(message);
    }
    const Pose world_from_rig = drive.world_from_rig(light);
    for (int i = 0; i < 2; ++i) {
      const show::DrawnFrame drawn = projections[i].draw(light, light, frame);
      errors[i] = squared_error(truth, rig, world_from_rig, drawn.pose.frame_from_child, wall);
      char caption[64];
      std::snprintf(caption, sizeof caption, "%s: %.0f mm off", i == 0 ? "newest pose" : "predicted pose",
                    1000 * std::sqrt(errors[std::size_t(i)]));
      video.put(i,
                spectator.view(place, truth.projector().projector,
                               world_from_rig * truth.projector().rig_from_projector, frame),
                caption);
    }
    video.add();
    if (light < kSettled) continue;
    for (int i = 0; i < 2; ++i) sums[i] += errors[i];
    ++judged;
    if (argc == 6 && errors[0] > worst) video.save(argv[5]);
    worst = std::max(worst, errors[0]);
  }
  video.finish();

  const double newest_mm = 1000 * std::sqrt(sums[0] / judged),
               predicted_mm = 1000 * std::sqrt(sums[1] / judged);
  std::cout << "on the wall, rms over " << judged << " frames: the newest pose " << newest_mm
            << " mm (at worst " << 1000 * std::sqrt(worst) << "), predicted to the moment of light "
            << predicted_mm << " mm\n";
  return predicted_mm < newest_mm / 2.5 ? 0 : 1;
} catch (const Error& error) {
  std::cerr << error.what() << "\n";
  return 3;
}
