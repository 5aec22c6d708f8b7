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

}  // namespace

ViewImage preview(const std::string& view, const std::string& camera, const std::vector<ViewU8>& frames) {
  require(!frames.empty() && !frames.front().empty(), "preview: no frame");
  const ViewU8& frame = *std::max_element(frames.begin(), frames.end(), [](const auto& a, const auto& b) {
    return coarse_sum(a) < coarse_sum(b);
  });
  const int scale = (std::max(frame.width, frame.height) + kMaxSize - 1) / kMaxSize;
  const int channel = measured_channel(frame);
  ViewImage out{view, camera, ImageU8(std::max(frame.width / scale, 1), std::max(frame.height / scale, 1)),
                scale};
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

}  // namespace procam::session
