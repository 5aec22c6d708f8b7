#include "rig_error.hpp"

#include <algorithm>
#include <optional>
#include <vector>

#include "procam/core/base/parallel.hpp"

namespace procam::scan {
namespace {

constexpr int kCell = 16;  // pixels a side

/// A camera and a projector that their parameters may be changed of.
struct Devices {
  RigCamera camera;
  RigProjector projector;

  /// Where the projector shows the point at depth z on the ray of a camera pixel.
  std::optional<Vec2> project(const Vec2& camera_pixel, double z) const {
    const std::optional<Vec3> bearing = camera.camera.unproject(camera_pixel);
    if (!bearing || !(bearing->z() > 1e-6)) return std::nullopt;
    const Vec3 point = camera.rig_from_camera * Vec3(*bearing * (z / bearing->z()));
    return projector.projector.project(projector.rig_from_projector.inverse() * point);
  }
};

/// One parameter that the rig's covariance names, of the two devices.
struct Parameter {
  enum class Of { kCamera, kCameraPose, kProjector, kProjectorPose } of = Of::kCamera;
  Eigen::Index index = 0;
  double sigma = 0;

  Devices moved(const Devices& devices, double by) const {
    Devices out = devices;
    const auto change_lens = [&](Camera& camera) {
      VecX values = parameters_of(camera);
      values[index] += by;
      camera = with_parameters(camera, values);
    };
    const auto change_pose = [&](Pose& pose) {
      Vec6 increment = Vec6::Zero();
      increment[index] = by;
      pose = se3_exp(increment) * pose;
    };
    if (of == Of::kCamera) change_lens(out.camera.camera);
    if (of == Of::kCameraPose) change_pose(out.camera.rig_from_camera);
    if (of == Of::kProjector) change_lens(out.projector.projector.inverse_camera);
    if (of == Of::kProjectorPose) change_pose(out.projector.rig_from_projector);
    return out;
  }
};

/// The devices with one parameter changed by a tenth of its standard deviation, up and down.
struct Changed {
  Devices up, down;
  double step = 0;
};

class RigError {
 public:
  RigError(const Rig& rig, const RigCamera& camera, const RigProjector& projector)
      : devices_{camera, projector} {
    std::vector<std::string> names;
    const auto take = [&](Parameter::Of of, const std::vector<std::string>& all, const std::string& prefix) {
      for (std::size_t i = 0; i < all.size(); ++i) {
        const std::string name = prefix + all[i];
        const double sigma = rig.covariance.sigma(name);
        if (!(sigma > 0)) continue;
        names.push_back(name);
        const Parameter parameter{of, Eigen::Index(i), sigma};
        const double step = 0.1 * sigma;
        changed_.push_back({parameter.moved(devices_, step), parameter.moved(devices_, -step), step});
      }
    };
    take(Parameter::Of::kCamera, parameter_names(camera.camera), camera.name + ".");
    take(Parameter::Of::kCameraPose, pose_increment_names("rig_from_" + camera.name), "");
    take(Parameter::Of::kProjector, parameter_names(projector.projector.inverse_camera),
         projector.name + ".");
    take(Parameter::Of::kProjectorPose, pose_increment_names("rig_from_" + projector.name), "");
    covariance_ = rig.covariance.block(names);
  }

  bool empty() const { return changed_.empty(); }

  /// 0 where a device does not see the point under some change.
  double sigma(const Vec2& pixel, double z, const Vec2& light_sigma) const {
    const double dz = 1e-4 * z;
    const std::optional<Vec2> nearer = devices_.project(pixel, z - dz),
                              farther = devices_.project(pixel, z + dz);
    if (!nearer || !farther) return 0;
    const Vec2 weight = light_sigma.cwiseAbs2().cwiseInverse();
    const Vec2 by_depth = (*farther - *nearer) / (2 * dz);
    const double information = weight.dot(by_depth.cwiseAbs2());
    if (!(information > 0)) return 0;
    VecX gradient(Eigen::Index(changed_.size()));
    for (std::size_t i = 0; i < changed_.size(); ++i) {
      const std::optional<Vec2> up = changed_[i].up.project(pixel, z),
                                down = changed_[i].down.project(pixel, z);
      if (!up || !down) return 0;
      const Vec2 by_parameter = (*up - *down) / (2 * changed_[i].step);
      gradient[Eigen::Index(i)] = -weight.cwiseProduct(by_depth).dot(by_parameter) / information;
    }
    return std::sqrt(std::max(0.0, gradient.dot(covariance_ * gradient)));
  }

 private:
  Devices devices_;
  std::vector<Changed> changed_;
  MatX covariance_;
};

struct Node {
  double depth = 0, sigma = 0;  ///< 0: none in this cell
};

}  // namespace

ImageF rig_sigma(const Scan& scan, const LightMap& light, const Rig& rig, const RigProjector& projector,
                 int threads) {
  const ImageSize size = scan.depth.size();
  ImageF out(size);
  const RigError error(rig, scan.camera, projector);
  if (error.empty()) return out;
  const int columns = (size.width + kCell - 1) / kCell, rows = (size.height + kCell - 1) / kCell;
  std::vector<Node> nodes(std::size_t(columns) * std::size_t(rows));
  const auto node_at = [&](int column, int row) -> Node& {
    return nodes[std::size_t(row) * std::size_t(columns) + std::size_t(column)];
  };
  parallel_each(rows, threads, [&](int row) {
    for (int column = 0; column < columns; ++column) {
      // The measured pixel nearest to the cell's middle.
      int best = kCell * kCell, at_x = -1, at_y = -1;
      for (int y = row * kCell; y < std::min(size.height, (row + 1) * kCell); ++y)
        for (int x = column * kCell; x < std::min(size.width, (column + 1) * kCell); ++x) {
          const int dx = x - column * kCell - kCell / 2, dy = y - row * kCell - kCell / 2;
          if (scan.depth.at(x, y) > 0 && dx * dx + dy * dy < best)
            best = dx * dx + dy * dy, at_x = x, at_y = y;
        }
      if (at_x < 0) continue;
      const double z = scan.depth.at(at_x, at_y);
      const Vec2 sigma(light.sigma.at(at_x, at_y, 0), light.sigma.at(at_x, at_y, 1));
      node_at(column, row) = {z, error.sigma(Vec2(at_x, at_y), z, sigma)};
    }
  });
  parallel_each(size.height, threads, [&](int y) {
    const double fy = (double(y) + 0.5) / kCell - 0.5;
    const int row = int(std::floor(fy));
    for (int x = 0; x < size.width; ++x) {
      const double z = scan.depth.at(x, y);
      if (!(z > 0)) continue;
      const double fx = (double(x) + 0.5) / kCell - 0.5;
      const int column = int(std::floor(fx));
      double sum = 0, weights = 0;
      for (int j = std::max(0, row); j <= std::min(rows - 1, row + 1); ++j)
        for (int i = std::max(0, column); i <= std::min(columns - 1, column + 1); ++i) {
          const Node& node = node_at(i, j);
          if (!(node.sigma > 0)) continue;
          // Nodes on another surface count little.
          const double step = (z - node.depth) / (0.05 * z);
          const double weight =
              (1.01 - std::abs(fx - i)) * (1.01 - std::abs(fy - j)) / (1 + step * step * step * step);
          sum += weight * node.sigma * (z / node.depth) * (z / node.depth);
          weights += weight;
        }
      if (weights > 0) out.at(x, y) = float(sum / weights);
    }
  });
  return out;
}

}  // namespace procam::scan
