#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "html.hpp"
#include "pictures.hpp"
#include "procam/io/image/images.hpp"

namespace procam::report {
namespace {

using calibrate::CalibrationResult;

constexpr std::size_t kMaxCaptures = 12;
constexpr std::size_t kMaxImageBytes = 25000, kMaxDecodedBytes = 12000;

std::string base64(const std::string& bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    unsigned group = 0;
    for (std::size_t k = 0; k < 3; ++k)
      group = group << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k)
      out += i + k <= bytes.size() ? kDigits[group >> (18 - 6 * k) & 63u] : '=';
  }
  return out;
}

/// As an address that holds the image itself, a JPEG of at most max_bytes where a lower quality reaches that.
std::string image_address(const ImageU8& image, std::size_t max_bytes) {
  std::string bytes;
  for (const int quality : {80, 60, 40, 25}) {
    bytes = io::encode_jpeg(image, quality);
    if (bytes.size() <= max_bytes) break;
  }
  return "data:image/jpeg;base64," + base64(bytes);
}

/// A view's image with its numbers in the result.
struct Capture {
  const ViewImage* image = nullptr;
  std::size_t view = 0, device = 0;
};

template <typename List>
std::size_t index_named(const List& list, const std::string& name) {
  const auto found =
      std::find_if(list.begin(), list.end(), [&](const auto& one) { return one.name == name; });
  return std::size_t(found - list.begin());
}

/// Infinite for a rejected view; else the largest of the devices' RMS in the view over their RMS in all.
double badness(const CalibrationResult& result, std::size_t view) {
  if (!result.views[view].used) return HUGE_VAL;
  double largest = -1;
  for (std::size_t d = 0; d < result.devices.size(); ++d)
    if (const double ratio = result.views[view].rms_px[d] / result.rms_px[d]; std::isfinite(ratio))
      largest = std::max(largest, ratio);
  return largest;
}

/// Images of the result's views, worst first.
std::vector<Capture> captures(const CalibrationResult& result, const std::vector<ViewImage>& images) {
  std::vector<Capture> all;
  for (const ViewImage& image : images) {
    const Capture capture{&image, index_named(result.views, image.view),
                          index_named(result.devices, image.camera)};
    if (!image.image.empty() && capture.view < result.views.size() && capture.device < result.devices.size())
      all.push_back(capture);
  }
  std::stable_sort(all.begin(), all.end(), [&](const Capture& a, const Capture& b) {
    return badness(result, a.view) > badness(result, b.view);
  });
  return all;
}

/// Of a circle: a share of the image, less where points are close together.
double mark_radius(const CalibrationResult& result, const Capture& capture) {
  constexpr double kOfImage = 0.006, kOfDistance = 0.3;
  double radius = kOfImage * result.devices[capture.device].size.width;
  const Vec2* before = nullptr;
  for (const calibrate::Residual& r : result.residuals) {
    if (r.view != int(capture.view) || r.device != int(capture.device) || !r.pixel.allFinite()) continue;
    if (before != nullptr && r.pixel != *before)
      radius = std::min(radius, kOfDistance * (r.pixel - *before).norm());
    before = &r.pixel;
  }
  return radius;
}

/// Found points as circles, their projections as dots, rejected points as crosses, points of the pattern as dots.
struct CaptureMarks {
  std::string found, rejected;
  Marks projections, light;
  int used = 0, out = 0;
};

std::string rejected_point(const Vec2& pixel, double arm, const std::string& reason) {
  Marks cross;
  cross.cross(pixel, arm);
  return cross.path("class=\"rejected\"", reason.empty() ? "rejected" : reason);
}

CaptureMarks capture_marks(const CalibrationResult& result, const Correspondences& data,
                           const Capture& capture, double arm) {
  CaptureMarks marks;
  for (const calibrate::Residual& r : result.residuals) {
    if (r.view != int(capture.view) || r.device != int(capture.device) || !r.pixel.allFinite()) continue;
    if (r.used) {
      ++marks.used;
      marks.found += circle("class=\"found\"", r.pixel, arm);
      if (r.residual.allFinite()) marks.projections.dot(r.pixel + r.residual);
    } else {
      ++marks.out;
      marks.rejected += rejected_point(r.pixel, arm, r.reason);
    }
  }
  const View& view = data.views[capture.view];
  if (!result.views[capture.view].used && capture.device < view.observations.size())
    for (const Observation& o : view.observations[capture.device]) {
      ++marks.out;
      marks.rejected += rejected_point(o.pixel, arm, "view rejected");
    }
  for (const LightPoint& light : view.light_points)
    if (light.camera == int(capture.device)) marks.light.dot(light.camera_pixel);
  return marks;
}

/// "view_2 · camera 0.037, projector 0.036 px RMS; 54 points, 3 rejected".
std::string capture_caption(const CalibrationResult& result, const Capture& capture,
                            const CaptureMarks& marks) {
  const calibrate::ViewResult& view = result.views[capture.view];
  std::string rms;
  for (std::size_t d = 0; d < result.devices.size(); ++d)
    if (d == capture.device || result.devices[d].kind == DeviceKind::kProjector)
      rms += (rms.empty() ? "" : ", ") + escaped(result.devices[d].name) + " " + pixels(view.rms_px[d]);
  std::string caption = element("b", "", escaped(view.name)) + " · ";
  caption += marks.used > 0 ? rms + " px RMS; " + std::to_string(marks.used) + " points" : "no point used";
  if (marks.out > 0) caption += ", " + std::to_string(marks.out) + " rejected";
  return caption + (view.note.empty() ? "" : "; " + escaped(view.note));
}

std::string capture_figure(const CalibrationResult& result, const Correspondences& data,
                           const Capture& capture) {
  const Device& camera = result.devices[capture.device];
  const calibrate::ViewResult& view = result.views[capture.view];
  const Vec2 corner(-0.5, -0.5), size(camera.size.width, camera.size.height);
  const ImageU8& image = capture.image->image;
  const Vec2 shown = capture.image->scale * Vec2(image.width(), image.height());
  const CaptureMarks marks = capture_marks(result, data, capture, mark_radius(result, capture));
  const std::string content = "<image x=\"-0.5\" y=\"-0.5\" width=\"" + coordinate(shown.x()) +
                              "\" height=\"" + coordinate(shown.y()) +
                              "\" preserveAspectRatio=\"none\" href=\"" +
                              image_address(image, kMaxImageBytes) + "\"/>\n" +
                              marks.light.path("class=\"light-point\"", "projected points") + marks.found +
                              marks.projections.path("class=\"projection\"", "projections") + marks.rejected;
  return figure(svg(box(corner, size), "Capture of " + camera.name + " in " + view.name, content),
                capture_caption(result, capture, marks));
}

/// False colour of a position from 0 (blue) over green to 1 (red), darker in every second of 16 bands.
std::array<std::uint8_t, 3> code_colour(double share) {
  constexpr int kBands = 16;
  const double hue = 4 * (1 - std::clamp(share, 0.0, 1.0));  // of six: 0 red, 2 green, 4 blue
  const double light = int(share * kBands) % 2 == 0 ? 255 : 175;
  std::array<std::uint8_t, 3> colour{};
  for (int c = 0; c < 3; ++c) {
    const double away = std::abs(hue - 2 * c), nearest = std::min(away, 6 - away);
    colour[std::size_t(c)] = std::uint8_t(light * std::clamp(2 - nearest, 0.0, 1.0));
  }
  return colour;
}

/// Decoded columns left, rows right.
ImageU8 decoded_picture(const ImageF& decoded, ImageSize projector) {
  constexpr std::uint8_t kNotDecoded = 60;
  const std::array<int, 2> sizes{projector.width, projector.height};
  ImageU8 picture(2 * decoded.width(), decoded.height(), 3, kNotDecoded);
  for (int y = 0; y < decoded.height(); ++y)
    for (int x = 0; x < decoded.width(); ++x)
      for (int axis = 0; axis < 2; ++axis) {
        const float code = decoded.at(x, y, axis);
        if (code < 0) continue;
        const auto colour = code_colour(double(code) / sizes[std::size_t(axis)]);
        for (int c = 0; c < 3; ++c) picture.at(x + axis * decoded.width(), y, c) = colour[std::size_t(c)];
      }
  return picture;
}

/// Empty for a pattern without a map of pixels.
std::string decoded_figure(const CalibrationResult& result, const Capture& capture) {
  const ImageF& decoded = capture.image->decoded;
  const auto projector = std::find_if(result.devices.begin(), result.devices.end(), [](const Device& device) {
    return device.kind == DeviceKind::kProjector;
  });
  if (decoded.empty() || decoded.channels() != 2 || projector == result.devices.end()) return "";
  const ImageU8 picture = decoded_picture(decoded, projector->size);
  const Vec2 size(picture.width(), picture.height());
  const std::string& view = result.views[capture.view].name;
  return figure(svg(box(Vec2(0, 0), size),
                    "Decoded columns and rows of " + result.devices[capture.device].name + " in " + view,
                    "<image width=\"" + coordinate(size.x()) + "\" height=\"" + coordinate(size.y()) +
                        "\" href=\"" + image_address(picture, kMaxDecodedBytes) + "\"/>\n"),
                element("b", "", escaped(view)) + " · decoded columns, decoded rows");
}

}  // namespace

std::string view_captures(const CalibrationResult& result, const Correspondences& data,
                          const std::vector<ViewImage>& images) {
  std::vector<Capture> all = captures(result, images);
  if (all.empty()) return "";
  const std::size_t hidden = all.size() - std::min(all.size(), kMaxCaptures);
  all.resize(all.size() - hidden);
  std::string figures;
  bool is_decoded = false;
  for (const Capture& capture : all) {
    const std::string codes = decoded_figure(result, capture);
    is_decoded = is_decoded || !codes.empty();
    figures += element("div", "", capture_figure(result, data, capture) + codes) + "\n";
  }
  return element("div", "class=\"captures\"", "\n" + figures) + "\n" +
         element(
             "p", "class=\"hint\"",
             "The brightest frame of each view, reduced. Circles: board points that were found; yellow dots: their "
             "projections by the rig; red crosses: rejected points; orange dots: points of the projector's pattern. "
             "Rejected views first, then by RMS relative to the device's." +
                 std::string(
                     is_decoded ? " In false colour: the projector's columns and rows that each camera pixel "
                                  "decoded, from blue (0) to red; grey where nothing was decoded."
                                : "") +
                 (hidden > 0 ? " " + std::to_string(hidden) + " images of better views are not shown."
                             : "")) +
         "\n";
}

}  // namespace procam::report
