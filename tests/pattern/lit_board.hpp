#pragma once
/// A small true world for matching: a slightly bent board in front of a camera and a projector with lenses;
/// every camera pixel's code and the stripe edges follow from the true light, with noise.
#include <cmath>
#include <random>

#include "procam/core/geometry/se3.hpp"
#include "procam/core/lens/projector.hpp"
#include "procam/core/rig/decoded_map.hpp"
#include "procam/core/rig/observation.hpp"
#include "procam/core/rig/stripe_edge.hpp"
#include "procam/detect/board_artwork.hpp"

namespace procam::test {

struct LitBoard {
  Board board = Chessboard{5, 7, 0.05};
  Camera camera{{480, 400}, {760, 751, 229, 208, 0.4}, BrownConrady{{-0.12, 0.05, 0.0007, -0.0004, 0}}};
  Projector projector{{{640, 500}, {1101, 1108, 309, 451, -0.6}, BrownConrady{{-0.05, 0.02, 0, 0.0003, 0}}}};
  Pose camera_from_board{so3_exp(Vec3(0.24, -0.33, 0.08)), Vec3(-0.07, -0.15, 0.86)};
  Pose projector_from_camera{so3_exp(Vec3(0.29, -0.12, 0.02)), Vec3(0.10, 0.13, 0.04)};
  double bow = 0.0015;          ///< the sheet's bow towards the camera over one half-width, metres
  double code_noise_px = 0.25;  ///< of the light that integer codes are cut from, projector pixels
  double edge_sigma_px = 0.06;  ///< camera pixels
  double lit_below_u = 1e9;     ///< the projector's picture ends here
  double wrong_edges = 0;       ///< share of edges with a wrong code
  double border_shift_px = 0;   ///< edges within 2 px of a printed line are moved by this much
  unsigned seed = 3;

  BoardArtwork artwork() const { return detect::board_artwork(board); }
  Vec3 on_sheet(double x, double y) const {
    const double w = 0.5 * print_of(board).high.x();
    const double s = (x - w) / w;
    return Vec3(x, y, -bow * s * s);
  }
  /// Where the camera pixel's ray meets the sheet, in the board's frame.
  Vec3 sheet_at(const Vec2& pixel) const {
    const Pose board_from_camera = camera_from_board.inverse();
    const Vec3 d = board_from_camera.rotation * *camera.unproject(pixel);
    Vec3 p = Vec3::Zero();
    for (int i = 0; i < 6; ++i) {
      const double depth = (p.z() - board_from_camera.translation.z()) / d.z();
      const Vec3 q = board_from_camera.translation + depth * d;
      p = on_sheet(q.x(), q.y());
    }
    return p;
  }
  Vec2 light_at(const Vec2& pixel) const {
    return *projector.project(projector_from_camera * (camera_from_board * sheet_at(pixel)));
  }
  Vec2 corner_pixel(int point) const {
    const Vec3 p = points_in_board(board)[std::size_t(point)];
    return *camera.project(camera_from_board * on_sheet(p.x(), p.y()));
  }
  /// The camera's true corners, moved by a noise that their covariance states.
  Detections corners(double sigma) const {
    Detections detections;
    detections.image_size = camera.size;
    std::mt19937 random(seed + 100);
    std::normal_distribution<double> normal;
    const int count = int(points_in_board(board).size());
    for (int i = 0; i < count; ++i)
      detections.observations.push_back({i, corner_pixel(i) + sigma * Vec2{normal(random), normal(random)},
                                         Mat2::Identity() * sigma * sigma});
    return detections;
  }
};

struct Light {
  DecodedMap decoded;
  std::vector<StripeEdge> edges;
};

inline Light shine(const LitBoard& world) {
  const ImageSize size = world.camera.size;
  std::mt19937 random(world.seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  Light light;
  light.decoded.projector_size = world.projector.size();
  light.decoded.columns = Image<std::int16_t>(size, 1, DecodedMap::kUndecoded);
  light.decoded.rows = light.decoded.columns;
  Image<double> truth(size, 2);
  const auto lit = [&](const Vec2& l) {
    return world.projector.size().contains(l) && l.x() < world.lit_below_u;
  };
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      const Vec2 l = world.light_at(Vec2(x, y));
      truth.at(x, y, 0) = l.x(), truth.at(x, y, 1) = l.y();
      const Vec2 noisy = l + world.code_noise_px * Vec2{normal(random), normal(random)};
      if (!lit(l) || !world.projector.size().contains(noisy)) continue;
      light.decoded.columns.at(x, y) = std::int16_t(std::lround(noisy.x()));
      light.decoded.rows.at(x, y) = std::int16_t(std::lround(noisy.y()));
    }
  for (int axis = 0; axis < 2; ++axis)
    for (int y = 0; y + 1 < size.height; ++y)
      for (int x = 0; x + 1 < size.width; ++x) {
        const double here = truth.at(x, y, axis),
                     next = axis == 0 ? truth.at(x + 1, y, 0) : truth.at(x, y + 1, 1);
        if (!lit({truth.at(x, y, 0), truth.at(x, y, 1)})) continue;
        const double low = std::min(here, next), high = std::max(here, next);
        for (double k = std::ceil(low + 0.5); k - 0.5 < high; ++k) {
          double along = (k - 0.5 - here) / (next - here) + world.edge_sigma_px * normal(random);
          const Vec3 p = world.sheet_at(Vec2(x, y)) / pitch_of(world.board);
          const double line =
              std::min(std::abs(p.x() - std::round(p.x())), std::abs(p.y() - std::round(p.y())));
          if (line * 40 < 2) along += world.border_shift_px;  // a square is about 40 camera pixels
          StripeEdge edge;
          edge.axis = axis == 0 ? StripeAxis::kColumn : StripeAxis::kRow;
          edge.scan = axis == 0 ? ScanAxis::kCameraX : ScanAxis::kCameraY;
          edge.camera_pixel = axis == 0 ? Vec2(x + along, y) : Vec2(x, y + along);
          edge.projector_coordinate = k - 0.5;
          if (uniform(random) < world.wrong_edges)
            edge.projector_coordinate += std::exp2(std::floor(8 * uniform(random)));
          edge.sigma_px = world.edge_sigma_px;
          light.edges.push_back(edge);
        }
      }
  return light;
}

/// Of projector pixels read off the light.
struct LightErrors {
  double rms = 0;   ///< a coordinate, projector pixels
  double chi2 = 0;  ///< mean of e^T C^-1 e / 2: 1 for a correct covariance
};

/// Against the light on the true corner.
inline LightErrors errors_of(const Detections& projected, const LitBoard& world) {
  LightErrors errors;
  for (const Observation& o : projected.observations) {
    const Vec2 e = o.pixel - world.light_at(world.corner_pixel(o.point));
    errors.rms += e.squaredNorm() / (2 * double(projected.observations.size()));
    errors.chi2 += e.dot(o.covariance.inverse() * e) / (2 * double(projected.observations.size()));
  }
  errors.rms = std::sqrt(errors.rms);
  return errors;
}

}  // namespace procam::test
