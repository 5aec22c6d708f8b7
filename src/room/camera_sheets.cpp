/// What EXIF or a data sheet states of the cameras' focal lengths, as a prior and against the light.
///
/// Of a prior N(f0, P0) and a result f with variance P that has used it, f - f0 has the variance P0 - P; of a result
/// without it, P0 + P. More than three standard deviations contradict the prior.
#include <cmath>
#include <set>

#include "procam/core/base/words.hpp"
#include "route.hpp"

namespace procam::room {
namespace {

constexpr double kContradicts = 3;  // standard deviations

/// `variance`: of the difference.
bool contradicts(double focal, const CameraSheet& sheet, double variance) {
  return std::pow(focal - sheet.focal_px.value, 2) > std::pow(kContradicts, 2) * variance;
}

double focal_sigma(const Rig& rig, const std::string& camera) {
  return rig.covariance.sigma(camera + ".fx");
}

std::string stated(const std::string& camera, const CameraSheet& sheet) {
  return "camera '" + camera + "': " + sheet.source + " is a focal length of " +
         fixed(sheet.focal_px.value, 0) + " px (+-" +
         percent(sheet.focal_px.sigma / sheet.focal_px.value, 0) + ")";
}

/// Names of estimated cameras whose sheet this result contradicts.
std::set<std::string> contradicted(const RoomCalibration& result, const RoomOptions& options, bool used) {
  std::set<std::string> names;
  for (const auto& [name, sheet] : options.camera_sheets) {
    if (options.cameras.count(name) != 0) continue;
    const double prior = std::pow(sheet.focal_px.sigma, 2),
                 posterior = std::pow(focal_sigma(result.rig, name), 2);
    const double variance = used ? std::max(prior - posterior, 0.01 * prior) : prior + posterior;
    if (contradicts(result.rig.camera(name).camera.intrinsics.fx, sheet, variance)) names.insert(name);
  }
  return names;
}

void remark(const RoomOptions& options, const std::set<std::string>& dropped, RoomCalibration& result) {
  for (const auto& [name, sheet] : options.camera_sheets) {
    const double focal = result.rig.camera(name).camera.intrinsics.fx;
    const bool is_known = options.cameras.count(name) != 0;
    const std::string found = fixed(focal, 0) + " px" +
                              (is_known ? "" : " (+-" + significant(focal_sigma(result.rig, name), 2) + ")");
    if (is_known && contradicts(focal, sheet, std::pow(sheet.focal_px.sigma, 2)))
      result.diagnostics.warn("camera_sheet_disagrees",
                              stated(name, sheet) + ", the known lens has " + found +
                                  "; check that --known-camera is this camera at this zoom and resolution");
    else if (dropped.count(name) != 0)
      result.diagnostics.warn(
          "camera_sheet_disagrees",
          stated(name, sheet) + ", the light finds " + found +
              " and contradicts it; it is not used. Check that the images are neither cropped nor "
              "from another lens");
    else if (!is_known)
      result.diagnostics.note("camera_sheet",
                              stated(name, sheet) + ", taken as a prior; the result is " + found);
  }
}

RoomOptions without(RoomOptions options, const std::set<std::string>& sheets) {
  for (const std::string& name : sheets) options.camera_sheets.erase(name);
  return options;
}

/// Without any sheet, where no rig was found with them: the ones that it contradicts. Throws Error.
std::set<std::string> contradicted_by_light_alone(const RoomPoints& points, const RoomOptions& options) {
  RoomOptions none = options;
  none.camera_sheets.clear();
  return contradicted(Route(points, none).run(), options, false);
}

}  // namespace

RoomCalibration calibrate_with_sheets(const RoomPoints& points, const RoomOptions& options) {
  std::set<std::string> dropped;
  std::optional<RoomCalibration> result;
  try {
    result = Route(points, options).run();
    dropped = contradicted(*result, options, true);
  } catch (const Error&) {
    // A sheet that is far off may be the cause.
    try {
      dropped = contradicted_by_light_alone(points, options);
    } catch (const Error&) {
      dropped.clear();
    }
    if (dropped.empty()) throw;
  }
  if (!dropped.empty()) {
    const RoomOptions fewer = without(options, dropped);
    result = Route(points, fewer).run();
  }
  remark(options, dropped, *result);
  return std::move(*result);
}

}  // namespace procam::room
