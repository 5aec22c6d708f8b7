#include "procam/calibrate/gates.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lens_models.hpp"
#include "procam/core/base/words.hpp"
#include "rig_checks.hpp"

namespace procam::calibrate {
namespace {

constexpr double kEverywhere = std::numeric_limits<double>::infinity();

std::string number(double value, int decimals = 3) {
  return fixed(value, decimals);
}

/// Collects the quality checks of one device. Every detail has the measured value, the limit, and the
/// action after a failure.
class DeviceGates {
 public:
  DeviceGates(std::vector<Gate>& gates, std::string device, const Camera& lens)
      : gates_(gates), device_(std::move(device)), lens_(lens) {}

  void add(const std::string& what, bool passed, const std::string& measured, const std::string& advice) {
    gates_.push_back({device_ + " " + what, passed, passed ? measured : measured + ": " + advice});
  }

  void aspect(const GateLimits& limits) {
    const double ratio = lens_.intrinsics.fx / lens_.intrinsics.fy;
    add("aspect", std::abs(ratio - 1) <= limits.max_aspect_error, "fx/fy " + number(ratio, 4),
        "pixels are square to " + number(100 * limits.max_aspect_error, 0) +
            " %; check the image size, and that no keystone or scaling is applied between file and light");
  }

  void field_of_view(const GateLimits& limits) {
    const double middle = 0.5 * (lens_.size.height - 1);
    const auto ray = [&](const Vec2& pixel) {  // a pinhole's beyond the fold of the distortion
      return lens_.unproject(pixel).value_or(
          lens_.intrinsics.normalized_from_pixel(pixel).homogeneous().normalized());
    };
    const Vec3 left = ray(Vec2(-0.5, middle)), right = ray(Vec2(lens_.size.width - 0.5, middle));
    const double fov = std::atan2(left.cross(right).norm(), left.dot(right)) / kDegree;
    add("field of view", fov >= limits.min_fov_deg && fov <= limits.max_fov_deg,
        number(fov, 1) + " degrees across",
        "expected " + number(limits.min_fov_deg, 0) + " to " + number(limits.max_fov_deg, 0) +
            "; the focal length is probably wrong: add views with the board tilted and at other distances");
  }

  /// The lens model must be invertible wherever the device is used: on the whole frame of a projector, which
  /// all is lit. A camera's image may have empty borders (padding, a vignette); there only pixels up to `reach`
  /// from the principal point count.
  void monotone(double reach) {
    const double everywhere = folded_share(lens_), used = folded_share(lens_, reach);
    const std::string folds =
        "the distortion folds back over " + number(100 * everywhere, 0) + " % of the picture";
    add("distortion monotone", used == 0,
        everywhere == 0 ? std::string("over the whole picture")
        : used == 0     ? "up to " + number(reach, 0) +
                          " px from the principal point, where the points lie; beyond, " + folds
                    : folds,
        "hold k3 (and k2), or cover the picture's corners with the board");
  }

  void tangential(const GateLimits& limits) {
    const std::vector<std::string> names = coefficient_names(lens_.distortion);
    const std::vector<double> values = coefficients_of(lens_.distortion);
    double largest = 0;
    for (std::size_t i = 0; i < names.size(); ++i)
      if (names[i] == "p1" || names[i] == "p2") largest = std::max(largest, std::abs(values[i]));
    add("tangential distortion", largest <= limits.max_tangential, "largest " + number(largest, 4),
        "above " + number(limits.max_tangential, 2) +
            " it stands in for a wrong principal point: add tilted views or hold p1, p2");
  }

  void sigma(const GateLimits& limits, const NamedCovariance& covariance) {
    if (covariance.empty()) return;
    const double relative = std::max(covariance.sigma(device_ + ".fx") / lens_.intrinsics.fx,
                                     covariance.sigma(device_ + ".fy") / lens_.intrinsics.fy);
    add("focal length known", relative <= limits.max_relative_sigma,
        "sigma " + number(100 * relative, 2) + " % of f",
        "the views determine it poorly: tilt the board 20 to 40 degrees about both axes and vary the "
        "distance");
  }

  void rms(const GateLimits& limits, const RigQuality& quality) {
    const auto rms = quality.rms_px.find(device_);
    if (rms == quality.rms_px.end()) return;
    constexpr double kFitsNothing =
        0.02;  // of the width: no lens, wrong as its model may be, misses by as much
    const bool nothing_fits = rms->second > kFitsNothing * lens_.size.width;
    add("RMS", rms->second <= limits.max_rms_px, number(rms->second) + " px",
        nothing_fits
            ? "no lens at any place fits its points, and the other checks say little: check that they are numbered "
              "as the board's, that each view has its own ones, and that u runs to the right and v downwards"
            : "above " + number(limits.max_rms_px, 2) +
                  " px something does not fit: a bent or moved board, a camera that refocused between the views (switch "
                  "autofocus off), a sheet printed at two scales, a scaled frame, a wrong lens model");
    const auto holdout = quality.holdout_px.find(device_);
    if (holdout == quality.holdout_px.end()) return;
    const auto known = quality.expected_holdout_px.find(device_);
    const double expected = known == quality.expected_holdout_px.end() ? 0 : known->second;
    const bool usual = holdout->second <= limits.max_holdout_ratio * std::max(rms->second, 0.05);
    add("held-out error", usual || holdout->second <= limits.max_holdout_sigmas * expected,
        number(holdout->second) + " px on held-out views, " + number(rms->second) + " px in the fit" +
            (expected > 0 ? "; the sigmas explain " + number(expected) + " px" : ""),
        "the model fits its views better than others: add views, or fix distortion terms");
  }

 private:
  std::vector<Gate>& gates_;
  std::string device_;
  const Camera& lens_;
};

}  // namespace

std::vector<Gate> check_rig(const Rig& rig, const GateLimits& limits,
                            const std::map<std::string, double>& camera_reach) {
  std::vector<Gate> gates;
  const auto check_common = [&](DeviceGates& device, const std::string& name) {
    device.rms(limits, rig.quality);
    device.aspect(limits);
    device.field_of_view(limits);
    const auto reach = camera_reach.find(name);
    device.monotone(reach == camera_reach.end() ? kEverywhere : reach->second);
    device.tangential(limits);
    device.sigma(limits, rig.covariance);
  };
  for (const RigCamera& camera : rig.cameras) {
    DeviceGates device(gates, camera.name, camera.camera);
    check_common(device, camera.name);
    const Camera& c = camera.camera;
    const double dx = (c.intrinsics.cx - 0.5 * (c.size.width - 1)) / c.size.width,
                 dy = (c.intrinsics.cy - 0.5 * (c.size.height - 1)) / c.size.height;
    device.add("principal point", std::max(std::abs(dx), std::abs(dy)) <= limits.max_camera_offset,
               number(dx, 2) + " widths, " + number(dy, 2) + " heights from the centre",
               "a camera's lies near its centre unless the image was cropped: add tilted views");
  }
  for (const RigProjector& projector : rig.projectors) {
    DeviceGates device(gates, projector.name, projector.projector.inverse_camera);
    check_common(device, "");
    const Vec2 shift = projector.projector.lens_shift();
    device.add(
        "lens shift", shift.cwiseAbs().maxCoeff() <= limits.max_lens_shift,
        number(shift.x(), 2) + " widths, " + number(shift.y(), 2) + " heights",
        "beyond " + number(limits.max_lens_shift, 1) +
            " no common projector goes: switch its keystone correction off; or focal length, principal "
            "point and pose have traded off: add views with the board tilted and at other distances");
  }
  return gates;
}

std::vector<Gate> check_stored_rig(const Rig& rig, const GateLimits& limits) {
  const std::vector<Gate> made_again = check_rig(rig, limits);
  std::vector<Gate> gates = made_again;
  // Where the points of a camera lie, only its calibration knew.
  for (const RigCamera& camera : rig.cameras)
    for (const Gate& stored : rig.quality.gates)
      for (Gate& gate : gates)
        if (gate.name == camera.name + " distortion monotone" && stored.name == gate.name) gate = stored;
  const std::string predicted = "predicted error";
  for (const Gate& stored : rig.quality.gates) {
    const std::size_t length = stored.name.size();
    const bool of_wall = length >= predicted.size() &&
                         stored.name.compare(length - predicted.size(), predicted.size(), predicted) == 0;
    const bool again = std::any_of(made_again.begin(), made_again.end(),
                                   [&](const Gate& gate) { return gate.name == stored.name; });
    if (!of_wall && !again) gates.push_back(stored);
  }
  return gates;
}

}  // namespace procam::calibrate
