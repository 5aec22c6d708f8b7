#include "procam/detect/projected_board.hpp"

#include <algorithm>

namespace procam::detect {

/// Edges of light are made of pixels, which the models of straight blurred edges do not know: rendered
/// boards without noise err by this much.
constexpr double kRasterSigmaPx = 0.005;

Detections detect_projected_board(const ViewU8& board_lit, const ViewU8& flat_lit, const Board& layout,
                                  const BoardOptions& options) {
  require(board_lit.size() == flat_lit.size() && board_lit.channels == 1 && flat_lit.channels == 1,
          "detect_projected_board: needs two images of one size with one channel");
  constexpr float kDark = 4;     // grey levels: darkness is not blown up to noise
  constexpr float kLight = 200;  // grey of full light; what noise makes brighter still fits
  ImageU8 light(board_lit.size());
  for (int y = 0; y < light.height(); ++y) {
    const std::uint8_t *lit = board_lit.row(y), *flat = flat_lit.row(y);
    std::uint8_t* out = light.row(y);
    for (int x = 0; x < light.width(); ++x)
      out[x] =
          std::uint8_t(std::min(255.f, kLight * (float(lit[x]) + kDark) / (float(flat[x]) + kDark) + 0.5f));
  }
  Detections result = detect_board(light, layout, options);
  for (Observation& point : result.observations)
    point.covariance += kRasterSigmaPx * kRasterSigmaPx * Mat2::Identity();
  return result;
}

}  // namespace procam::detect
