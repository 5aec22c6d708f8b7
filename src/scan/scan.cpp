#include "procam/scan/scan.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cstdint>
#include <limits>
#include <vector>

#include "consistency.hpp"
#include "procam/core/base/parallel.hpp"
#include "procam/core/base/words.hpp"
#include "rig_error.hpp"

namespace procam::scan {
namespace {

RawDepths solve_all(const LightMap& light, const DepthSolver& solver, const ImageF& rays, int threads,
                    Scan& scan) {
  const ImageSize size = light.camera_size();
  RawDepths raw{ImageF(size, 1, -1.0f), ImageF(size), ImageF(size)};
  parallel_each(size.height, threads, [&](int y) {
    for (int x = 0; x < size.width; ++x) {
      if (!light.decoded(x, y)) continue;
      raw.left.at(x, y) = 0;
      const Depth depth =
          solver.solve(rays.at(x, y, 0), rays.at(x, y, 1), light.pixel.at(x, y, 0), light.pixel.at(x, y, 1),
                       light.sigma.at(x, y, 0), light.sigma.at(x, y, 1));
      scan.depth.at(x, y) = float(depth.z);
      scan.sigma.at(x, y) = float(depth.sigma);
      raw.left.at(x, y) = float(depth.left);
      raw.left_px.at(x, y) = float(depth.left_px);
      raw.by_px.at(x, y) = float(depth.by_px);
    }
  });
  return raw;
}

void reject(const RawDepths& raw, const ScanOptions& options, Scan& scan) {
  const double limit = options.consistency_sigmas * std::max(1.0, scan.consistency);
  for (int y = 0; y < scan.depth.height(); ++y)
    for (int x = 0; x < scan.depth.width(); ++x) {
      if (raw.left.at(x, y) < 0) continue;
      ++scan.counts.lit;
      float& z = scan.depth.at(x, y);
      const bool in_range =
          z >= options.nearest && z <= options.farthest && scan.sigma.at(x, y) <= options.max_sigma;
      const bool consistent = raw.left.at(x, y) <= limit;
      if (in_range && consistent) continue;
      ++(in_range ? scan.counts.inconsistent : scan.counts.out_of_range);
      z = 0;
    }
}

/// Removes patches of few pixels: neighbours belong together when their depths differ by less than 2 %, or than their
/// noise explains.
void reject_isolated(int min_patch, Scan& scan) {
  const int width = scan.depth.width(), height = scan.depth.height();
  Image<std::uint8_t> seen(width, height);
  std::vector<std::pair<int, int>> patch;
  const auto joined = [&](int x, int y, int nx, int ny) {
    const double a = scan.depth.at(x, y), b = scan.depth.at(nx, ny);
    return b > 0 &&
           std::abs(a - b) <= 0.02 * std::min(a, b) + 4 * (scan.sigma.at(x, y) + scan.sigma.at(nx, ny));
  };
  for (int y0 = 0; y0 < height; ++y0)
    for (int x0 = 0; x0 < width; ++x0) {
      if (seen.at(x0, y0) || !scan.measured(x0, y0)) continue;
      patch.assign(1, {x0, y0});
      seen.at(x0, y0) = 1;
      for (std::size_t i = 0; i < patch.size(); ++i) {
        const auto [x, y] = patch[i];
        const std::pair<int, int> beside[] = {{x - 1, y}, {x + 1, y}, {x, y - 1}, {x, y + 1}};
        for (const auto& [nx, ny] : beside) {
          if (nx < 0 || ny < 0 || nx >= width || ny >= height || seen.at(nx, ny) || !joined(x, y, nx, ny))
            continue;
          seen.at(nx, ny) = 1;
          patch.push_back({nx, ny});
        }
      }
      if (int(patch.size()) >= min_patch) continue;
      for (const auto& [x, y] : patch) scan.depth.at(x, y) = 0;
      scan.counts.isolated += int(patch.size());
    }
}

void finish(Scan& scan) {
  for (int y = 0; y < scan.depth.height(); ++y)
    for (int x = 0; x < scan.depth.width(); ++x) {
      if (scan.measured(x, y))
        ++scan.counts.measured;
      else
        scan.depth.at(x, y) = scan.sigma.at(x, y) = 0;
    }
}

/// `change` of the camera's images makes the light fit; empty: none.
[[noreturn]] void refuse_empty(const Scan& scan, const std::string& change) {
  const ScanCounts& counts = scan.counts;
  if (counts.lit == 0)
    throw Error(ErrorKind::kNotEnoughData, "scan", "no camera pixel has decoded light of columns and rows",
                "check that the camera sees the projector's light, and that the captures are complete");
  const bool rig = counts.inconsistent >= counts.out_of_range;
  throw Error(
      ErrorKind::kNotEnoughData, "scan",
      format(
          "none of the %d lit pixels has a depth: columns and rows of %d do not meet the camera's ray, %d lie "
          "outside of the range or behind a device, %d are isolated",
          counts.lit, counts.inconsistent, counts.out_of_range, counts.isolated) +
          (change.empty() ? "" : "; they fit when the camera's images are " + change),
      !change.empty() ? "give the images as the camera had them at the calibration"
      : rig           ? "use the rig file of this camera and projector, in the same position and focus"
                      : "check that the rig file is that of this camera and projector, and its unit");
}

void remark(const Rig& rig, Scan& scan) {
  if (rig.covariance.empty())
    scan.diagnostics.note(
        "no_rig_covariance",
        "the rig states no covariance: the standard deviations are those of the light's noise alone");
  const double share = double(scan.counts.measured) / double(std::max(scan.counts.lit, 1));
  if (share < 0.7)
    scan.diagnostics.warn(
        "few_points",
        format("only %.0f %% of the lit pixels have a depth: %d are inconsistent, %d out of "
               "range, %d isolated",
               100 * share, scan.counts.inconsistent, scan.counts.out_of_range, scan.counts.isolated));
}

/// In the camera's frame, towards it: of the plane t . (a, b, 1) = 1 / z fitted to the neighbours within three pixels that
/// are on the same surface; against the ray where they do not determine one.
Vec3 normal_at(const Scan& scan, const ImageF& rays, int x, int y) {
  constexpr int kReach = 3;
  const double z = scan.depth.at(x, y), step = 0.02 * z;
  const Vec3 ray(rays.at(x, y, 0), rays.at(x, y, 1), 1);
  Mat3 normal = Mat3::Zero();
  Vec3 right = Vec3::Zero();
  for (int j = std::max(0, y - kReach); j <= std::min(scan.depth.height() - 1, y + kReach); ++j)
    for (int i = std::max(0, x - kReach); i <= std::min(scan.depth.width() - 1, x + kReach); ++i) {
      const double other = scan.depth.at(i, j);
      if (!(other > 0) || std::abs(other - z) > step) continue;
      const Vec3 d(rays.at(i, j, 0) - ray.x(), rays.at(i, j, 1) - ray.y(), 1);
      normal += d * d.transpose();
      right += d / other;
    }
  const Vec3 t = normal.ldlt().solve(right);  // about this ray: 1 / z = t . (da, db, 1)
  const Vec3 plane(t.x(), t.y(), t.z() - t.x() * ray.x() - t.y() * ray.y());
  const double length = plane.norm();
  if (!(normal.determinant() > 1e-18) || !(length > 1e-9) || !std::isfinite(length)) return -ray.normalized();
  return -plane / length;
}

}  // namespace

ImageF pixel_rays(const Camera& camera, int threads) {
  ImageF rays(camera.size, 2);
  parallel_each(camera.size.height, threads, [&](int y) {
    for (int x = 0; x < camera.size.width; ++x) {
      const std::optional<Vec3> bearing = camera.unproject(Vec2(x, y));
      const bool ahead = bearing && bearing->z() > 1e-6;
      for (int c = 0; c < 2; ++c)
        rays.at(x, y, c) =
            ahead ? float((*bearing)[c] / bearing->z()) : std::numeric_limits<float>::quiet_NaN();
    }
  });
  return rays;
}

Scan measure_depth(const LightMap& light, const Rig& rig, const std::string& camera,
                   const std::string& projector, const ScanOptions& options) {
  require(options.nearest > 0 && options.farthest > options.nearest && options.max_sigma > 0 &&
              options.consistency_sigmas > 0,
          "measure_depth: options out of range");
  const RigCamera& seeing = rig.camera(camera);
  const RigProjector& lighting = rig.projector(projector);
  if (light.camera_size() != seeing.camera.size || light.projector_size != lighting.projector.size())
    throw Error(
        ErrorKind::kInput, "scan",
        format(
            "the captures have %dx%d pixels of a %dx%d frame, the rig's camera '%s' %dx%d and its projector "
            "'%s' %dx%d",
            light.camera_size().width, light.camera_size().height, light.projector_size.width,
            light.projector_size.height, seeing.name.c_str(), seeing.camera.size.width,
            seeing.camera.size.height, lighting.name.c_str(), lighting.projector.size().width,
            lighting.projector.size().height),
        "use the rig that was calibrated with these devices in the same modes");
  const Pose projector_from_camera = lighting.rig_from_projector.inverse() * seeing.rig_from_camera;
  if (!(projector_from_camera.translation.norm() > 1e-6))
    throw Error(ErrorKind::kDegenerate, "scan", "camera and projector are in one place: light tells no depth",
                "use a camera that stands beside the projector");
  Scan scan;
  scan.camera = seeing;
  scan.projector = lighting.name;
  scan.depth = ImageF(light.camera_size());
  scan.sigma = ImageF(light.camera_size());
  const UndistortedPixels pixels(lighting.projector.inverse_camera, options.threads);
  const ImageF rays = pixel_rays(seeing.camera, options.threads);
  const DepthSolver solver(projector_from_camera, pixels);
  const RawDepths raw = solve_all(light, solver, rays, options.threads, scan);
  measure_consistency(raw, scan);
  reject(raw, options, scan);
  reject_isolated(options.min_patch, scan);
  finish(scan);
  if (scan.counts.measured == 0) refuse_empty(scan, image_change(light, solver, rays));
  set_rig_error(light, rig, lighting, options.threads, scan);
  set_misfit_sigma(raw, scan);
  check_consistency(light, solver, rays, scan);
  remark(rig, scan);
  return scan;
}

PointCloud point_cloud(const Scan& scan) {
  const ImageF rays = pixel_rays(scan.camera.camera);
  PointCloud cloud;
  const Eigen::Quaterniond rotation = scan.camera.rig_from_camera.rotation;
  for (int y = 0; y < scan.depth.height(); ++y)
    for (int x = 0; x < scan.depth.width(); ++x) {
      if (!scan.measured(x, y)) continue;
      const Vec3 ray(rays.at(x, y, 0), rays.at(x, y, 1), 1);
      cloud.points.push_back(scan.camera.rig_from_camera * Vec3(double(scan.depth.at(x, y)) * ray));
      cloud.normals.push_back(rotation * normal_at(scan, rays, x, y));
      cloud.sigma.push_back(scan.total_sigma(x, y) * ray.norm());
    }
  return cloud;
}

}  // namespace procam::scan
