#pragma once
/// The depth of one camera pixel by the projector's column and row that light it (procam/scan/scan.hpp has the equations).
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "procam/core/base/image.hpp"
#include "procam/core/base/parallel.hpp"
#include "procam/core/geometry/pose.hpp"
#include "procam/core/lens/camera.hpp"

namespace procam::scan {

/// Projector pixels without their lens: normalised coordinates by linear interpolation on a grid of four pixels, right to
/// a thousandth of a pixel for usual lenses.
class UndistortedPixels {
 public:
  UndistortedPixels(const Camera& projector, int threads)
      : columns_(projector.size.width / kStep + 3),
        rows_(projector.size.height / kStep + 3),
        nodes_(columns_, rows_, 2) {
    parallel_each(rows_, threads, [&](int row) {
      for (int column = 0; column < columns_; ++column) {
        const std::optional<Vec3> bearing =
            projector.unproject(Vec2((column - 1) * kStep, (row - 1) * kStep));
        const bool ahead = bearing && bearing->z() > 1e-6;
        for (int c = 0; c < 2; ++c)
          nodes_.at(column, row, c) = ahead ? (*bearing)[c] / bearing->z() : std::nan("");
      }
    });
  }

  struct Position {
    double x, y;    ///< normalised; NaN where the lens has no inverse
    double dx, dy;  ///< by a pixel in its own direction
  };
  Position at(double u, double v) const {
    const double column = std::clamp(u / kStep + 1, 0.0, columns_ - 1.001),
                 row = std::clamp(v / kStep + 1, 0.0, rows_ - 1.001);
    const int i = int(column), j = int(row);
    const double s = column - i, t = row - j;
    const double *a = &nodes_.at(i, j), *b = &nodes_.at(i, j + 1);
    const double top_x = a[0] + s * (a[2] - a[0]), low_x = b[0] + s * (b[2] - b[0]);
    const double top_y = a[1] + s * (a[3] - a[1]), low_y = b[1] + s * (b[3] - b[1]);
    return {top_x + t * (low_x - top_x), top_y + t * (low_y - top_y), (a[2] - a[0]) / kStep,
            (b[1] - a[1]) / kStep};
  }

 private:
  static constexpr int kStep = 4;
  int columns_, rows_;
  Image<double> nodes_;
};

/// What column and row say together about a pixel's depth.
struct Depth {
  double z = 0, sigma = 0;  ///< z 0: none, behind a device, or not finite
  double left = 0;          ///< of the two equations, in standard deviations
  double left_px = 0;       ///< the same in projector pixels
  double by_px = 0;         ///< depth by projector pixels along the epipolar line
};

class DepthSolver {
 public:
  DepthSolver(const Pose& projector_from_camera, const UndistortedPixels& pixels)
      : rotation_(projector_from_camera.rotation.toRotationMatrix()),
        translation_(projector_from_camera.translation),
        pixels_(pixels) {}

  Depth solve(double a, double b, double u, double v, double sigma_u, double sigma_v) const {
    if (!std::isfinite(u + v + sigma_u + sigma_v)) return {};
    const UndistortedPixels::Position m = pixels_.at(u, v);
    const double sx = std::abs(m.dx) * sigma_u, sy = std::abs(m.dy) * sigma_v;
    const double rx = rotation_(0, 0) * a + rotation_(0, 1) * b + rotation_(0, 2);
    const double ry = rotation_(1, 0) * a + rotation_(1, 1) * b + rotation_(1, 2);
    const double rz = rotation_(2, 0) * a + rotation_(2, 1) * b + rotation_(2, 2);
    // The coordinate that says more gives the start; one step of least squares is then exact to second order.
    const double more_x = std::abs(rx - m.x * rz) * sy, more_y = std::abs(ry - m.y * rz) * sx;
    const double start = more_x >= more_y ? (translation_.x() - m.x * translation_.z()) / (m.x * rz - rx)
                                          : (translation_.y() - m.y * translation_.z()) / (m.y * rz - ry);
    const double ahead = start * rz + translation_.z();
    if (!(start > 0 && ahead > 0 && start < 1e6)) return {};
    const double x = (start * rx + translation_.x()) / ahead, y = (start * ry + translation_.y()) / ahead;
    const double jx = (rx - x * rz) / ahead, jy = (ry - y * rz) / ahead, ex = m.x - x, ey = m.y - y;
    const double wx = 1 / (sx * sx), wy = 1 / (sy * sy);
    const double information = jx * jx * wx + jy * jy * wy;
    const double step = (jx * ex * wx + jy * ey * wy) / information;
    const double lx = ex - jx * step, ly = ey - jy * step;
    Depth depth;
    depth.z = start + step;
    depth.sigma = 1 / std::sqrt(information);
    depth.left = std::sqrt(lx * lx * wx + ly * ly * wy);
    depth.left_px = std::hypot(lx / m.dx, ly / m.dy);
    depth.by_px = 1 / std::hypot(jx / m.dx, jy / m.dy);
    if (!(depth.z > 0 && std::isfinite(depth.sigma) && std::isfinite(depth.left) &&
          std::isfinite(depth.left_px) && std::isfinite(depth.by_px)))
      return {};
    return depth;
  }

 private:
  Mat3 rotation_;
  Vec3 translation_;
  const UndistortedPixels& pixels_;
};

}  // namespace procam::scan
