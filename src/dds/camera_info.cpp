#include "camera_info.hpp"

#include <algorithm>
#include <cmath>

#include "procam/core/base/detail/plain_text.hpp"
#include "procam/core/base/limits.hpp"

namespace procam::dds::internal {
namespace {

[[noreturn]] void refuse_info(const std::string& why) {
  throw Refusal{"ros2_invalid_camera_info", "a CameraInfo: " + why};
}

bool is_zero(double value) {
  return value == 0;
}

Distortion distortion_of(const RawCameraInfo& raw) {
  std::vector<double> d = raw.d;
  if (d.size() > 14) refuse_info("it has " + std::to_string(d.size()) + " coefficients");
  if (!std::all_of(d.begin(), d.end(), [](double value) { return std::isfinite(value); }))
    refuse_info("a coefficient is not finite");
  if (std::all_of(d.begin(), d.end(), is_zero)) return NoDistortion{};
  if (raw.model == "equidistant") {
    if (d.size() != 4) refuse_info("an equidistant lens has 4 coefficients, not " + std::to_string(d.size()));
    return with_coefficients(FisheyeDistortion{}, d);
  }
  const std::size_t most = raw.model == "plumb_bob" ? 5 : raw.model == "rational_polynomial" ? 8 : 0;
  if (most == 0)
    refuse_info("its distortion model '" + procam::internal::to_plain_text(raw.model.substr(0, 64)) +
                "' is not read here");
  if (d.size() < 4)
    refuse_info("it has " + std::to_string(d.size()) + " coefficients, fewer than k1 k2 p1 p2");
  if (d.size() > most && !std::all_of(d.begin() + std::ptrdiff_t(most), d.end(), is_zero))
    refuse_info("it has more than " + std::to_string(most) + " coefficients");
  d.resize(most);
  return most == 5 ? with_coefficients(BrownConrady{}, d) : with_coefficients(RationalDistortion{}, d);
}

}  // namespace

std::optional<Camera> camera_of(const RawCameraInfo& raw) {
  const auto& k = raw.k;
  if (std::all_of(k.begin(), k.end(), is_zero)) return std::nullopt;
  if (!std::all_of(k.begin(), k.end(), [](double value) { return std::isfinite(value); }))
    refuse_info("a number of K is not finite");
  if (!(k[0] > 0 && k[4] > 0) || k[3] != 0 || k[6] != 0 || k[7] != 0 || k[8] != 1)
    refuse_info("K is not of the form [fx skew cx; 0 fy cy; 0 0 1] with positive focal lengths");
  const auto sides = {raw.width, raw.height, raw.roi_x, raw.roi_y, raw.roi_width, raw.roi_height};
  if (raw.width == 0 || raw.height == 0 || std::max(sides) > std::uint32_t(limits::kSizeSide))
    refuse_info("a size is zero or too large");
  const std::uint32_t width = raw.roi_width == 0 ? raw.width : raw.roi_width,
                      height = raw.roi_height == 0 ? raw.height : raw.roi_height;
  const std::uint32_t columns = std::max(raw.binning_x, 1u), rows = std::max(raw.binning_y, 1u);
  if (raw.roi_x + width > raw.width || raw.roi_y + height > raw.height || columns > width || rows > height)
    refuse_info("its region of interest or its binning is larger than the image");
  Camera camera;
  camera.size = {int(width / columns), int(height / rows)};
  camera.intrinsics = {k[0] / columns, k[4] / rows, (k[2] - raw.roi_x + 0.5) / columns - 0.5,
                       (k[5] - raw.roi_y + 0.5) / rows - 0.5, k[1] / columns};
  camera.distortion = distortion_of(raw);
  return camera;
}

}  // namespace procam::dds::internal
