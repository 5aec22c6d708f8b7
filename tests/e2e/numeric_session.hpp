#pragma once
/// A simulated session as its detectors would report it, without pictures: exact places and Gaussian noise.
#include <Eigen/LU>
#include <random>

#include "procam/detect/board_artwork.hpp"
#include "procam/pattern/projected_board.hpp"
#include "procam/session/reader.hpp"
#include "procam/simulate/session.hpp"

namespace procam::test {

/// One sigma an axis, as measured on rendered sessions (docs/calibration.md).
struct DetectorNoise {
  double corner_px = 0;  ///< of printed corners, camera pixels
  double light_px =
      0;  ///< Gray code: of the light at a corner, projector pixels; projected corners: camera's
};

namespace internal {

class Noise {
 public:
  explicit Noise(std::uint64_t seed) : random_(seed) {}
  Vec2 operator()(double sigma) {
    const double x = normal_(random_), y = normal_(random_);
    return sigma * Vec2(x, y);
  }

 private:
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
};

inline Correspondences printed_corners(const simulate::SimulatedSession& session, double sigma,
                                       Noise& noise) {
  Correspondences data;
  data.board = session.board().layout;
  data.devices = session::session_devices(session.rig().camera().camera.size,
                                          session.rig().projector().projector.size());
  for (const simulate::World& world : session.views) {
    View view{"view_" + std::to_string(data.views.size()), {simulate::board_in_camera(world), {}}};
    for (Observation& corner : view.observations[0]) {
      corner.pixel += noise(sigma);
      corner.covariance = sigma * sigma * Mat2::Identity();
    }
    data.views.push_back(view);
  }
  return data;
}

}  // namespace internal

/// Gray code: the light is read where the camera saw the corner.
inline Correspondences numeric_gray_code(const simulate::SimulatedSession& session,
                                         const DetectorNoise& sigma, std::uint64_t seed) {
  internal::Noise noise(seed);
  Correspondences data = internal::printed_corners(session, sigma.corner_px, noise);
  for (std::size_t v = 0; v < data.views.size(); ++v)
    for (const Observation& corner : data.views[v].observations[0]) {
      const auto light_at = [&](const Vec2& offset) {
        return simulate::projector_pixel_seen_at(session.views[v], corner.pixel + offset);
      };
      const auto lit = light_at({0, 0}), right = light_at({0.5, 0}), below = light_at({0, 0.5});
      if (!lit || !right || !below) continue;
      Mat2 carry;
      carry << 2 * (*right - *lit), 2 * (*below - *lit);
      data.views[v].observations[1].push_back(
          {corner.point, *lit + noise(sigma.light_px),
           carry * corner.covariance * carry.transpose() + sigma.light_px * sigma.light_px * Mat2::Identity(),
           0, true});
    }
  return data;
}

/// Printed and projected boards.
inline Correspondences numeric_chessboards(const simulate::SimulatedSession& session,
                                           const DetectorNoise& sigma, std::uint64_t seed) {
  internal::Noise noise(seed);
  Correspondences data = internal::printed_corners(session, sigma.corner_px, noise);
  const Board light = pattern::chessboard_filling(data.devices[1].size);
  const Points2 shown = pattern::point_pixels(
      pattern::projected_board(data.devices[1].size, light, detect::board_artwork(light)));
  for (std::size_t v = 0; v < data.views.size(); ++v)
    for (const Vec2& pixel : shown)
      if (const auto seen = simulate::camera_pixel_of_light(session.views[v], pixel))
        data.views[v].light_points.push_back({session::kProjectorDevice, pixel, session::kCameraDevice,
                                              *seen + noise(sigma.light_px),
                                              sigma.light_px * sigma.light_px * Mat2::Identity()});
  return data;
}

}  // namespace procam::test
