#pragma once
/// Simulated drives that calibrate a mount (localiser 10 mm, 0.5 degrees), and how far the mount is off.
#include <gtest/gtest.h>

#include <random>
#include <string>

#include "procam/calibrate/mount.hpp"
#include "procam/simulate/mount_drive.hpp"
#include "procam/simulate/robot.hpp"

namespace procam::calibrate {

using simulate::MountDrive;
using simulate::MountDriveOptions;

constexpr double kHeightSigma = 0.002;

inline MountDriveOptions uneven(std::uint64_t seed) {
  MountDriveOptions options;
  options.seed = seed;
  options.floor_sigma = options.floor_tilt_sigma = 0.0002;
  return options;
}

inline MountDrive walk(const MountDriveOptions& options, double duration = 60) {
  return simulate::mount_drive(simulate::random_walk(0.5, duration, options.seed), options);
}

inline MountData data_of(const MountDrive& made) {
  MountData data;
  for (const track::StampedPose& pose : made.base) data.base.push_back({*pose.stamp, pose.frame_from_child});
  for (const track::StampedPose& seen : made.sightings.messages)
    data.sightings.push_back({*seen.stamp,
                              seen.frame,
                              {seen.frame_from_child, *seen.covariance},
                              seen.frame.rfind("plane_", 0) == 0});
  return data;
}

/// As measured with that sigma.
inline MountOptions with_height(const MountDrive& made, std::uint64_t seed) {
  std::mt19937 random(static_cast<unsigned>(seed));
  double sum = -6;  // of twelve uniform numbers: unit variance
  for (int i = 0; i < 12; ++i) sum += double(random()) / double(std::mt19937::max());
  MountOptions options;
  options.height =
      MountHeight{made.sightings.base_from_rig.translation.z() + kHeightSigma * sum, kHeightSigma};
  return options;
}

struct Deviation {
  double chi2, at_two_metres, time_in_sigmas, time;
};
inline Deviation deviation(const MountResult& result, const MountDrive& made) {
  const Pose &found = result.base_from_rig.pose, &truth = made.sightings.base_from_rig;
  const Vec6 error = se3_log(found * truth.inverse());
  const Vec3 point(0, 0, 2);
  const double time = result.time_offset - made.time_offset;
  return {error.dot(result.base_from_rig.covariance.ldlt().solve(error)),
          (found * point - truth * point).norm(), time / result.time_offset_sigma, time};
}

constexpr double kChi2Of6 = 27.9;  // 1 in 10 000 of 6 degrees of freedom

/// "Error kind: message" of a calibration that has to fail.
inline std::string refusal(const MountData& data, const MountOptions& options, ErrorKind kind) {
  try {
    calibrate_mount(data, options);
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), kind) << error.what();
    return error.what();
  }
  ADD_FAILURE() << "a mount was returned";
  return "";
}

}  // namespace procam::calibrate
