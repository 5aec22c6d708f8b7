#include "common/known_before.hpp"

#include <algorithm>

#include "procam/io/exchange/calibration_file.hpp"

namespace procam::tools {

std::vector<calibrate::LensPrior> priors_of(const DataSheet& sheet, ImageSize picture) {
  constexpr double kSheet = 0.02;
  std::vector<calibrate::LensPrior> priors;
  if (sheet.throw_ratio) {
    const auto [ratio, sigma] = *sheet.throw_ratio;
    if (!(ratio > 0))
      throw Error(ErrorKind::kInput, "--throw-ratio", "it is not positive",
                  "give distance over width, e.g. 1.4+-0.02");
    priors.push_back(calibrate::throw_ratio_prior(ratio, sigma > 0 ? sigma : kSheet * ratio, picture));
  }
  if (!sheet.lens_shift.empty()) {
    const auto& [x, y] = std::pair(sheet.lens_shift[0], sheet.lens_shift[1]);
    const Vec2 sigma(x.sigma > 0 ? x.sigma : kSheet, y.sigma > 0 ? y.sigma : kSheet);
    priors.push_back(calibrate::lens_shift_prior(Vec2(x.value, y.value), sigma.x(), picture)[0]);
    priors.push_back(calibrate::lens_shift_prior(Vec2(x.value, y.value), sigma.y(), picture)[1]);
  }
  if (sheet.square_pixels) priors.push_back(calibrate::square_pixels());
  return priors;
}

calibrate::KnownLens read_known_camera(const std::filesystem::path& file,
                                       const std::vector<Device>& devices) {
  const auto is_camera = [](const Device& device) { return device.kind == DeviceKind::kCamera; };
  if (std::count_if(devices.begin(), devices.end(), is_camera) > 1)
    throw Error(ErrorKind::kUnsupported, "--known-camera", "the session has several cameras",
                "leave it out: all of them are calibrated from the session");
  const ImageSize size = devices.front().size;
  io::CalibrationContext context;
  context.camera_size = size;
  context.projector_size = devices.back().size;  // of what the file may hold beside the camera
  const Rig rig = io::load_calibration(file, context);
  const RigCamera& camera = rig.camera();
  if (camera.camera.size != size)
    throw Error(ErrorKind::kInput, file.string(),
                "its camera has images of " + io::format_size(camera.camera.size) + ", the session of " +
                    io::format_size(size),
                "give the same camera in the same mode, neither scaled nor cut");
  calibrate::KnownLens known{camera.camera, {}};
  std::vector<std::string> rows;
  for (const std::string& name : parameter_names(camera.camera))
    if (rig.covariance.sigma(camera.name + "." + name) > 0) {
      known.covariance.names.push_back(name);
      rows.push_back(camera.name + "." + name);
    }
  known.covariance.matrix = rig.covariance.block(rows);
  return known;
}

}  // namespace procam::tools
