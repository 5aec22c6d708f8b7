#pragma once
/// A rig and its views in numbers alone: exact projections plus Gaussian noise, no images. Lopsided
/// everywhere.
#include <random>

#include "procam/core/geometry/bent_sheet.hpp"
#include "procam/core/geometry/plane.hpp"
#include "procam/core/geometry/se3.hpp"
#include "procam/core/rig/observation.hpp"
#include "procam/core/rig/rig.hpp"
#include "support/lopsided.hpp"

namespace procam::test {

struct NumericWorld {
  Camera camera{
      {1280, 960}, {1290.0, 1297.0, 655.0, 470.0, 0.0}, BrownConrady{{-0.12, 0.06, 0.0007, -0.0011, 0.0}}};
  /// Lens shift: the principal point lies below the 768-row picture.
  Projector projector{Camera{
      {1024, 768}, {1880.0, 1891.0, 498.0, 846.0, 0.0}, BrownConrady{{-0.05, 0.03, -0.0006, 0.0009, 0.0}}}};
  Pose projector_from_camera{so3_exp<double>(Vec3(0.07, -0.11, 0.02)), Vec3(0.19, -0.31, -0.08)};
  Board board = Chessboard{9, 6, 0.035};
  std::vector<Pose> camera_from_board;
  double camera_sigma_px = 0, projector_sigma_px = 0;
  BentSheet sheet;         ///< that the projected board of with_projected_board() falls on
  std::vector<Vec3> flex;  ///< by view: curvature that is added to the sheet's; empty: none
  std::vector<Vec3>
      image_changes;  ///< by view: (g, x, y) of the camera (calibrate/costs/image_change.hpp); empty: none
  Points3 bend;  ///< by point: where the sheet has it, minus where it was printed; empty for a flat sheet

  /// A sheet that sags by 1 mm between its ends, curls at one corner and was printed 0.2 % too wide.
  void bend_board() {
    for (const Vec3& p : points_in_board(board))
      bend.emplace_back(0.002 * p.x() - 0.0003, 0.0001 * std::sin(40 * p.x()),
                        0.001 * std::cos(9 * p.x()) + 0.15 * p.x() * p.x() * p.y() - 0.0008);
  }

  /// A sheet that is bent like a cylinder about an oblique axis, print and blank part alike: by `sag` where it is half a
  /// metre from the print's middle.
  void bend_sheet(double sag) {
    const Points3 printed = points_in_board(board);
    sheet.centre = 0.5 * (printed.front() + printed.back()).head<2>();
    const Vec2 across(0.8, -0.6);
    sheet.curvature =
        8 * sag * Vec3(across.x() * across.x(), across.x() * across.y(), across.y() * across.y());
    for (const Vec3& p : printed) bend.emplace_back(0, 0, sheet.height(p.head<2>()));
  }

  /// The sheet bends anew in each view like a cylinder about an axis of any direction: by `rms` where it is half a metre from
  /// the print's middle.
  void flex_sheet(double rms, std::uint64_t seed) {
    const Points3 printed = points_in_board(board);
    sheet.centre = 0.5 * (printed.front() + printed.back()).head<2>();
    std::mt19937_64 random(seed ^ 0x51ed270b);
    std::normal_distribution<double> normal;
    flex.clear();
    for (std::size_t v = 0; v < camera_from_board.size(); ++v) {
      const double axis = 2 * kPi * uniform(random, 0, 1), curvature = 8 * rms * normal(random);
      const Vec2 across(std::cos(axis), std::sin(axis));
      flex.push_back(curvature *
                     Vec3(across.x() * across.x(), across.x() * across.y(), across.y() * across.y()));
    }
  }
  /// The camera focuses anew in each view, by this share (RMS), and a stabiliser displaces its image, by this (RMS) an axis.
  void change_images(double focus, double shift_px, std::uint64_t seed) {
    std::mt19937_64 random(seed ^ 0x2c1b3c6d);
    std::normal_distribution<double> normal;
    image_changes.clear();
    for (std::size_t v = 0; v < camera_from_board.size(); ++v) {
      const double g = focus * normal(random), x = shift_px * normal(random), y = shift_px * normal(random);
      image_changes.emplace_back(g, x, y);
    }
  }
  Camera camera_in(std::size_t view) const {
    Camera lens = camera;
    if (image_changes.empty()) return lens;
    const Vec3& change = image_changes[view];
    Intrinsics& k = lens.intrinsics;
    k.fx *= 1 + change[0], k.fy *= 1 + change[0], k.skew *= 1 + change[0];
    k.cx += change[1], k.cy += change[2];
    return lens;
  }

  BentSheet sheet_in(std::size_t view) const {
    return flex.empty() ? sheet : BentSheet{sheet.curvature + flex[view], sheet.centre};
  }

  /// Boards spread over distance and tilt; every one inside the camera's image.
  static NumericWorld make(int views, std::uint64_t seed, double camera_sigma = 0.0,
                           double projector_sigma = 0.0) {
    return make_with(Chessboard{9, 6, 0.035}, views, seed, camera_sigma, projector_sigma);
  }
  static NumericWorld make_with(const Board& board, int views, std::uint64_t seed, double camera_sigma,
                                double projector_sigma) {
    NumericWorld world;
    world.board = board;
    world.camera_sigma_px = camera_sigma;
    world.projector_sigma_px = projector_sigma;
    world.place_boards(views, seed);
    return world;
  }

  /// Another rig for each seed: lenses, lens shift, baseline and aim.
  static NumericWorld make_rig(int views, std::uint64_t seed, double camera_sigma, double projector_sigma) {
    NumericWorld world;
    world.camera_sigma_px = camera_sigma;
    world.projector_sigma_px = projector_sigma;
    std::mt19937_64 random(seed ^ 0x9e3779b97f4a7c15);
    const auto vary_lens = [&](Camera& lens) {
      Intrinsics& k = lens.intrinsics;
      const double zoom = uniform(random, 0.9, 1.15);
      k.fx *= zoom * uniform(random, 0.995, 1.005);
      k.fy *= zoom * uniform(random, 0.995, 1.005);
      k.cx += uniform(random, -40, 40);
      k.cy += uniform(random, -40, 40);
      std::vector<double> coefficients = coefficients_of(lens.distortion);
      for (double& c : coefficients) c *= uniform(random, 0.3, 1.5);
      lens.distortion = with_coefficients(lens.distortion, coefficients);
    };
    vary_lens(world.camera);
    vary_lens(world.projector.inverse_camera);
    world.projector_from_camera =
        Pose(so3_exp<double>(random_vec3(random, 0.03)), random_vec3(random, 0.05)) *
        world.projector_from_camera;
    world.place_boards(views, seed);
    return world;
  }

  /// The true rig, in the camera's frame.
  Rig rig() const {
    Rig truth;
    truth.cameras.push_back({"camera", camera, Pose()});
    truth.projectors.push_back({"projector", projector, projector_from_camera.inverse()});
    return truth;
  }

  void place_boards(int views, std::uint64_t seed) {
    std::mt19937_64 random(seed);
    // Not the library's distribution, whose numbers differ from one to the next.
    const auto uniform = [&](double low, double high) {
      return low + (high - low) * (double(random() >> 11) * 0x1.0p-53);
    };
    const Points3 points = points_in_board(board);
    while (int(camera_from_board.size()) < views) {
      const Vec3 turn(uniform(-0.6, 0.6), uniform(-0.6, 0.6), uniform(-0.4, 0.4));
      const Pose pose(so3_exp<double>(turn),
                      Vec3(uniform(-0.35, 0.2), uniform(-0.3, 0.2), uniform(0.7, 1.5)));
      bool inside = true;
      for (const Vec3& point : points)
        inside = inside && camera.sees(pose * point) &&
                 projector.inverse_camera.sees(projector_from_camera * (pose * point));
      if (inside) camera_from_board.push_back(pose);
    }
  }

  Correspondences correspondences(std::uint64_t noise_seed) const {
    std::mt19937_64 random(noise_seed);
    std::normal_distribution<double> normal;
    Correspondences data;
    data.board = board;
    data.devices = {{"camera", DeviceKind::kCamera, camera.size},
                    {"projector", DeviceKind::kProjector, projector.size()}};
    Points3 points = points_in_board(board);
    for (std::size_t i = 0; i < bend.size(); ++i) points[i] += bend[i];
    for (std::size_t v = 0; v < camera_from_board.size(); ++v) {
      View view{"view_" + std::to_string(v), {{}, {}}};
      for (std::size_t i = 0; i < points.size(); ++i) {
        Vec3 place = points[i];
        if (!flex.empty()) place.z() += BentSheet{flex[v], sheet.centre}.height(place.head<2>());
        const Vec3 in_camera = camera_from_board[v] * place;
        const auto seen = camera_in(v).project(in_camera);
        const auto lit = projector.project(projector_from_camera * in_camera);
        const auto add = [&](std::size_t device, const Vec2& pixel, double sigma) {
          const Vec2 noise(sigma * normal(random), sigma * normal(random));
          const double believed = sigma > 0 ? sigma : 0.1;
          view.observations[device].push_back(
              {int(i), pixel + noise, Mat2::Identity() * believed * believed});
        };
        if (seen) add(0, *seen, camera_sigma_px);
        if (lit) add(1, *lit, projector_sigma_px);
      }
      data.views.push_back(view);
    }
    return data;
  }

  /// The same, the projector's pixels read off its light where the camera saw the noisy corners: camera noise
  /// in both, projector_sigma_px of the light's own.
  Correspondences with_light_read_at_corners(std::uint64_t noise_seed) const {
    Correspondences data = correspondences(noise_seed);
    std::mt19937_64 random(noise_seed + 2);
    std::normal_distribution<double> normal;
    for (std::size_t v = 0; v < data.views.size(); ++v) {
      const Pose& from_board = camera_from_board[v];
      const auto light_at = [&](const Vec2& camera_pixel) -> std::optional<Vec2> {
        const auto bearing = camera_in(v).unproject(camera_pixel);
        const auto place = bearing
                               ? intersect(from_board.inverse() * Ray{Vec3::Zero(), *bearing}, sheet_in(v))
                               : std::nullopt;
        return place ? projector.project(projector_from_camera * (from_board * *place)) : std::nullopt;
      };
      View& view = data.views[v];
      view.observations[1].clear();
      for (const Observation& corner : view.observations[0]) {
        const auto lit = light_at(corner.pixel), right = light_at(corner.pixel + Vec2(0.5, 0)),
                   below = light_at(corner.pixel + Vec2(0, 0.5));
        if (!lit || !right || !below) continue;
        Mat2 carry;
        carry << 2 * (*right - *lit), 2 * (*below - *lit);
        view.observations[1].push_back({corner.point,
                                        *lit + projector_sigma_px * Vec2{normal(random), normal(random)},
                                        carry * corner.covariance * carry.transpose() +
                                            projector_sigma_px * projector_sigma_px * Mat2::Identity(),
                                        0, true});
      }
    }
    return data;
  }

  /// The same, the projector's light in corners of a projected chessboard beside the print instead.
  Correspondences with_projected_board(std::uint64_t noise_seed) const {
    Correspondences data = correspondences(noise_seed);
    std::mt19937_64 random(noise_seed + 1);
    std::normal_distribution<double> normal;
    for (std::size_t v = 0; v < data.views.size(); ++v) {
      data.views[v].observations[1].clear();
      const Pose projector_from_board = projector_from_camera * camera_from_board[v];
      for (int y = 0; y < 7; ++y)
        for (int x = 0; x < 9; ++x) {
          const Vec2 shown(120.0 + 95 * x, 90.0 + 85 * y);
          const auto ray = projector.emit(shown);
          const auto on_sheet =
              ray ? intersect(projector_from_board.inverse() * *ray, sheet_in(v)) : std::nullopt;
          const auto seen = on_sheet ? camera_in(v).project(camera_from_board[v] * *on_sheet) : std::nullopt;
          if (!seen || !camera.size.contains(*seen)) continue;
          LightPoint light;
          light.projector = 1;
          light.projector_pixel = shown;
          light.camera_pixel = *seen + camera_sigma_px * Vec2{normal(random), normal(random)};
          const double believed = camera_sigma_px > 0 ? camera_sigma_px : 0.1;
          light.camera_covariance = Mat2::Identity() * believed * believed;
          data.views[v].light_points.push_back(light);
        }
    }
    return data;
  }
};

}  // namespace procam::test
