#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "procam/io/exchange/calibration_file.hpp"
#include "procam/io/text.hpp"

namespace procam::io {
namespace {

/// "525,525,319.5,239.5": empty unless every part is a finite number.
std::vector<double> numbers_between_commas(const std::string& text) {
  std::vector<double> numbers;
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t comma = std::min(text.find(',', at), text.size());
    const std::string part = text.substr(at, comma - at);
    char* end = nullptr;
    const double value = std::strtod(part.c_str(), &end);
    if (part.empty() || *end != 0 || !std::isfinite(value)) return {};
    numbers.push_back(value);
    at = comma + 1;
  }
  return numbers;
}

Intrinsics intrinsics_from_text(const std::string& text, const std::vector<double>& k, ImageSize size) {
  constexpr const char* kNext =
      "give fx,fy,cx,cy in pixels, e.g. 525,525,319.5,239.5, in the mode of the image";
  const auto fail = [&](const std::string& why) { return Error(ErrorKind::kInput, text, why, kNext); };
  if (k.empty()) throw fail("not all of it are numbers");
  if (k.size() != 4 && k.size() != 5) throw fail("these are " + std::to_string(k.size()) + " numbers");
  if (!(k[0] > 0 && k[1] > 0)) throw fail("the focal lengths are not positive");
  // A cropped image may have it outside, but not by more than its own size.
  if (std::abs(k[2] / size.width - 0.5) > 1.5 || std::abs(k[3] / size.height - 0.5) > 1.5)
    throw fail("the principal point lies far outside the image of " + format_size(size) + " pixels");
  return {k[0], k[1], k[2], k[3], k.size() == 5 ? k[4] : 0};
}

}  // namespace

RigCamera load_camera(const std::string& text, const std::string& name, ImageSize size) {
  const std::vector<double> numbers = numbers_between_commas(text);
  RigCamera camera;
  if (!numbers.empty() || std::count(text.begin(), text.end(), ',') >= 3) {
    camera.camera = {size, intrinsics_from_text(text, numbers, size), NoDistortion{}};
    return camera;
  }
  CalibrationContext context;
  context.camera_size = size;
  context.projector_size = size;  // of a projector in the file, which is not used
  camera = load_calibration(text, context).camera(name);
  if (camera.camera.size != size)
    throw Error(
        ErrorKind::kInput, text,
        "its camera has " + format_size(camera.camera.size) + " pixels, the image " + format_size(size),
        "give the calibration of the camera that took the image, in the mode of the image");
  return camera;
}

}  // namespace procam::io
