#include "preview.hpp"

#include <algorithm>
#include <cstdint>

namespace procam::session {
namespace {

constexpr int kMaxSize = 480;

/// Of the channel that is measured: green where there is colour.
int measured_channel(const ViewU8& frame) {
  return frame.channels >= 3 ? 1 : 0;
}

/// Sum over every eighth pixel of every eighth row.
std::int64_t coarse_sum(const ViewU8& frame) {
  constexpr int kStep = 8;
  const int channel = measured_channel(frame);
  std::int64_t sum = 0;
  for (int y = 0; y < frame.height; y += kStep)
    for (int x = 0; x < frame.width; x += kStep) sum += frame.at(x, y, channel);
  return sum;
}

/// Camera pixels a pixel of the preview.
int preview_scale(ImageSize camera) {
  return (std::max(camera.width, camera.height) + kMaxSize - 1) / kMaxSize;
}

ImageSize preview_size(ImageSize camera) {
  const int scale = preview_scale(camera);
  return {std::max(camera.width / scale, 1), std::max(camera.height / scale, 1)};
}

}  // namespace

ViewImage preview(const std::string& view, const std::string& camera, const std::vector<ViewU8>& frames) {
  require(!frames.empty() && !frames.front().empty(), "preview: no frame");
  const ViewU8& frame = *std::max_element(frames.begin(), frames.end(), [](const auto& a, const auto& b) {
    return coarse_sum(a) < coarse_sum(b);
  });
  const int scale = preview_scale(frame.size());
  const int channel = measured_channel(frame);
  ViewImage out{view, camera, ImageU8(preview_size(frame.size()), 1), scale};
  for (int y = 0; y < out.image.height(); ++y)
    for (int x = 0; x < out.image.width(); ++x) {
      int sum = 0, count = 0;
      for (int v = y * scale; v < std::min((y + 1) * scale, frame.height); ++v)
        for (int u = x * scale; u < std::min((x + 1) * scale, frame.width); ++u)
          sum += frame.at(u, v, channel), ++count;
      out.image.at(x, y) = std::uint8_t((sum + count / 2) / std::max(count, 1));
    }
  return out;
}

ImageF decoded_preview(ImageSize camera,
                       const std::function<std::optional<Vec2>(int x, int y)>& projector_pixel) {
  const int scale = preview_scale(camera);
  ImageF out(preview_size(camera), 2, -1.0F);
  for (int y = 0; y < out.height(); ++y)
    for (int x = 0; x < out.width(); ++x)
      if (const auto pixel = projector_pixel(x * scale + scale / 2, y * scale + scale / 2))
        for (int c = 0; c < 2; ++c) out.at(x, y, c) = std::max(float((*pixel)[c]), 0.0F);
  return out;
}

ImageF decoded_preview(const LightMap& light) {
  return decoded_preview(light.camera_size(), [&](int x, int y) { return light.projector_pixel(x, y); });
}

}  // namespace procam::session
