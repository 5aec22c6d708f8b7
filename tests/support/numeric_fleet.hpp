#pragma once
/// Several cameras and projectors round one board, in numbers alone: exact projections plus Gaussian noise.
#include <functional>
#include <random>
#include <set>
#include <string>

#include "procam/core/geometry/plane.hpp"
#include "procam/core/geometry/se3.hpp"
#include "procam/core/rig/observation.hpp"
#include "procam/core/rig/rig.hpp"

namespace procam::test {

/// Which devices take part in a view, by number: 0 left, 1 right (cameras), 2 lamp, 3 beamer (projectors).
using Cast = std::set<int>;

struct NumericFleet {
  Rig rig = true_rig();
  Board board = Chessboard{9, 6, 0.035};
  std::vector<Cast> casts;
  std::vector<Pose> rig_from_board;
  double corner_sigma_px = 0, light_sigma_px = 0;

  static Rig true_rig() {
    Rig rig;
    rig.cameras = {{"left",
                    {{1280, 960}, {1290, 1297, 655, 470, 0}, BrownConrady{{-0.12, 0.06, 0.0007, -0.0011, 0}}},
                    Pose()},
                   {"right",
                    {{1280, 960}, {1385, 1379, 622, 497, 0}, BrownConrady{{-0.09, 0.04, -0.0009, 0.0006, 0}}},
                    Pose(so3_exp<double>(Vec3(0.04, -0.38, 0.06)), Vec3(0.51, -0.03, 0.07))}};
    const Camera lamp{
        {1024, 768}, {1510, 1519, 498, 640, 0}, BrownConrady{{-0.05, 0.03, -0.0006, 0.0009, 0}}};
    const Camera beamer{
        {1280, 800}, {1830, 1822, 655, 610, 0}, BrownConrady{{0.03, -0.02, 0.0005, 0.0004, 0}}};
    rig.projectors = {
        {"lamp", Projector{lamp}, Pose(so3_exp<double>(Vec3(-0.12, 0.13, 0.03)), Vec3(-0.24, 0.19, 0.05))},
        {"beamer", Projector{beamer},
         Pose(so3_exp<double>(Vec3(-0.16, -0.50, -0.05)), Vec3(0.68, 0.23, -0.04))}};
    return rig;
  }

  /// A board for each cast, wholly before every device of the cast.
  static NumericFleet make(std::vector<Cast> casts, std::uint64_t seed, double corner_sigma = 0,
                           double light_sigma = 0) {
    NumericFleet fleet;
    fleet.casts = std::move(casts);
    fleet.corner_sigma_px = corner_sigma;
    fleet.light_sigma_px = light_sigma;
    std::mt19937_64 random(seed);
    const auto uniform = [&](double low, double high) {
      return low + (high - low) * (double(random() >> 11) * 0x1.0p-53);
    };
    while (fleet.rig_from_board.size() < fleet.casts.size()) {
      const Vec3 turn(uniform(-0.55, 0.55), uniform(-0.75, 0.45), uniform(-0.4, 0.4));
      const Pose pose(so3_exp<double>(turn),
                      Vec3(uniform(-0.35, 0.4), uniform(-0.3, 0.2), uniform(0.8, 1.6)));
      bool inside = true;
      for (const int d : fleet.casts[fleet.rig_from_board.size()])
        for (const Vec3& point : points_in_board(fleet.board))
          inside = inside && fleet.lens(d).sees(fleet.rig_from(d).inverse() * (pose * point));
      if (inside) fleet.rig_from_board.push_back(pose);
    }
    return fleet;
  }

  bool is_camera(int device) const { return device < int(rig.cameras.size()); }
  const Camera& lens(int device) const {
    return is_camera(device)
               ? rig.cameras[std::size_t(device)].camera
               : rig.projectors[std::size_t(device) - rig.cameras.size()].projector.inverse_camera;
  }
  const Pose& rig_from(int device) const {
    return is_camera(device) ? rig.cameras[std::size_t(device)].rig_from_camera
                             : rig.projectors[std::size_t(device) - rig.cameras.size()].rig_from_projector;
  }

  /// The projector pixel whose light a camera sees at one of its pixels, on the sheet of a view.
  std::optional<Vec2> light_seen(std::size_t view, int camera, const Vec2& pixel, int projector) const {
    const auto bearing = lens(camera).unproject(pixel);
    if (!bearing) return std::nullopt;
    const auto place =
        intersect(rig_from(camera) * Ray{Vec3::Zero(), *bearing}, Plane::of_xy(rig_from_board[view]));
    return place ? lens(projector).project(rig_from(projector).inverse() * *place) : std::nullopt;
  }

  /// Every camera finds the corners, and reads each projector's light there.
  Correspondences correspondences(std::uint64_t seed) const {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    const auto noise = [&](double sigma) {
      const double x = normal(random), y = normal(random);
      return Vec2(sigma * x, sigma * y);
    };
    Correspondences data;
    data.board = board;
    for (const RigCamera& c : rig.cameras)
      data.devices.push_back({c.name, DeviceKind::kCamera, c.camera.size});
    for (const RigProjector& p : rig.projectors)
      data.devices.push_back({p.name, DeviceKind::kProjector, p.projector.size()});
    const Points3 points = points_in_board(board);
    const double believed = corner_sigma_px > 0 ? corner_sigma_px : 0.1;
    for (std::size_t v = 0; v < casts.size(); ++v) {
      View view{"view_" + std::to_string(v), std::vector<std::vector<Observation>>(data.devices.size())};
      for (const int d : casts[v])
        for (std::size_t i = 0; is_camera(d) && i < points.size(); ++i)
          view.observations[std::size_t(d)].push_back(
              {int(i),
               *lens(d).project(rig_from(d).inverse() * (rig_from_board[v] * points[i])) +
                   noise(corner_sigma_px),
               Mat2::Identity() * believed * believed});
      for (const int p : casts[v])
        for (const int c : casts[v]) {
          if (is_camera(p) || !is_camera(c)) continue;
          for (const Observation& corner : view.observations[std::size_t(c)]) {
            const auto lit = light_seen(v, c, corner.pixel, p),
                       right = light_seen(v, c, corner.pixel + Vec2(0.5, 0), p),
                       below = light_seen(v, c, corner.pixel + Vec2(0, 0.5), p);
            Mat2 carry;
            carry << 2 * (*right - *lit), 2 * (*below - *lit);
            view.observations[std::size_t(p)].push_back(
                {corner.point, *lit + noise(light_sigma_px),
                 carry * corner.covariance * carry.transpose() +
                     light_sigma_px * light_sigma_px * Mat2::Identity(),
                 c, true});
          }
        }
      data.views.push_back(view);
    }
    return data;
  }
};

}  // namespace procam::test
