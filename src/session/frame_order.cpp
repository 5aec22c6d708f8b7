#include "frame_order.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "procam/core/base/stats.hpp"

namespace procam::session {
namespace {

/// How an order differs from that of make-patterns.
struct FrameOrder {
  bool rows_first, fine_first, inverse_first, black_first;

  std::string text() const {
    std::string out;
    const auto add = [&](bool holds, const char* words) {
      if (holds) out += (out.empty() ? "" : ", ") + std::string(words);
    };
    add(rows_first, kRowsFirst);
    add(fine_first, "the finest stripes come first");
    add(inverse_first, "each inverse comes before its pattern");
    add(black_first, "black comes before white");
    return out;
  }
};

int bits_along(int pixels, int step) {
  int bits = 0;
  while ((1 << bits) * step < pixels) ++bits;
  return bits;
}

/// The captures, shown in `order`, in that of make-patterns.
std::vector<ViewU8> in_usual_order(const std::vector<ViewU8>& captures, const pattern::GrayCode& gray_code,
                                   const FrameOrder& order) {
  const int columns = bits_along(gray_code.projector_size.width, gray_code.step),
            rows = bits_along(gray_code.projector_size.height, gray_code.step);
  std::vector<ViewU8> usual;
  const auto add_axis = [&](int first_pair, int bits) {
    for (int bit = 0; bit < bits; ++bit) {
      const int pair = first_pair + (order.fine_first ? bits - 1 - bit : bit);
      for (const int second : {0, 1})
        usual.push_back(captures[std::size_t(2 * pair + (order.inverse_first ? 1 - second : second))]);
    }
  };
  add_axis(order.rows_first ? rows : 0, columns);
  add_axis(order.rows_first ? 0 : columns, rows);
  for (const int second : {0, 1})
    usual.push_back(captures[std::size_t(2 * (columns + rows) + (order.black_first ? 1 - second : second))]);
  return usual;
}

/// White as bright as bright stripes, black as dark as dark ones. An exposure that follows the light may make black brighter
/// than white, but neither is then like stripes.
bool ends_fit_stripes(const std::vector<ViewU8>& usual) {
  constexpr int kStep = 8, kContrast = 20;
  constexpr double kNear = 0.2;
  const ViewU8 &pattern = usual[0], &inverse = usual[1], &white = usual[usual.size() - 2],
               &black = usual.back();
  std::vector<double> of_white, of_black;
  for (int y = kStep; y < pattern.height; y += kStep)
    for (int x = kStep; x < pattern.width; x += kStep) {
      const int bright = std::max(pattern.at(x, y), inverse.at(x, y)),
                dark = std::min(pattern.at(x, y), inverse.at(x, y));
      if (bright - dark < kContrast) continue;
      of_white.push_back(std::abs(white.at(x, y) - bright) / double(bright - dark));
      of_black.push_back(std::abs(black.at(x, y) - dark) / double(bright - dark));
    }
  return median_or(std::move(of_white), 1.0) < kNear && median_or(std::move(of_black), 1.0) < kNear;
}

/// Camera pixels that decode like their right neighbour, but for a few stripes. A wrong order jumps by half of the frame.
int continuous_pixels(const std::vector<ViewU8>& captures, const pattern::GrayCode& gray_code) {
  try {
    const DecodedMap map = pattern::decode(captures, gray_code);
    if (map.diagnostics.find("projector_size") != nullptr) return 0;
    constexpr int kNear = 12;
    int near = 0, decoded = 0;
    for (int y = 0; y < map.columns.height(); ++y)
      for (int x = 0; x + 1 < map.columns.width(); ++x) {
        if (!map.decoded(x, y) || !map.decoded(x + 1, y)) continue;
        ++decoded;
        near += std::abs(map.columns.at(x + 1, y) - map.columns.at(x, y)) <= kNear &&
                std::abs(map.rows.at(x + 1, y) - map.rows.at(x, y)) <= kNear;
      }
    constexpr double kMinShare = 0.9;
    return near > kMinShare * decoded ? near : 0;
  } catch (const Error&) {  // white is darker than black
    return 0;
  }
}

}  // namespace

std::optional<std::string> other_frame_order(const std::vector<ViewU8>& captures,
                                             const pattern::GrayCode& gray_code) {
  constexpr int kFewPixels = 500;
  if (int(captures.size()) != pattern::frame_count(gray_code)) return std::nullopt;
  if (continuous_pixels(captures, gray_code) > kFewPixels) return std::nullopt;
  int most = kFewPixels;
  std::optional<std::string> found;
  for (int kind = 1; kind < 16; ++kind) {
    const FrameOrder order{(kind & 1) != 0, (kind & 2) != 0, (kind & 4) != 0, (kind & 8) != 0};
    const std::vector<ViewU8> usual = in_usual_order(captures, gray_code, order);
    if (order.black_first && !ends_fit_stripes(usual)) continue;
    const int pixels = continuous_pixels(usual, gray_code);
    if (pixels <= most) continue;
    most = pixels;
    found = order.text();
  }
  return found;
}

}  // namespace procam::session
