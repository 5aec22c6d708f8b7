#include "rig_error.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "procam/core/base/parallel.hpp"

namespace procam::scan {
namespace {

constexpr int kCell = 16;  // pixels a side, as cell_columns() has it

/// A camera and a projector that their parameters may be changed of.
struct Devices {
  RigCamera camera;
  RigProjector projector;

  /// Where the projector shows the point at depth z on the ray of a camera pixel.
  std::optional<Vec2> project(const Vec2& camera_pixel, double z) const {
    const std::optional<Vec3> seen = point(camera_pixel, z);
    if (!seen) return std::nullopt;
    return projector.projector.project(projector.rig_from_projector.inverse() * *seen);
  }

  /// The point at depth z on that ray, in the rig's frame.
  std::optional<Vec3> point(const Vec2& camera_pixel, double z) const {
    const std::optional<Vec3> bearing = camera.camera.unproject(camera_pixel);
    if (!bearing || !(bearing->z() > 1e-6)) return std::nullopt;
    return camera.rig_from_camera * Vec3(*bearing * (z / bearing->z()));
  }
};

/// One parameter that the rig's covariance names, of the two devices.
struct Parameter {
  enum class Of { kCamera, kCameraPose, kProjector, kProjectorPose } of = Of::kCamera;
  Eigen::Index index = 0;
  Eigen::Index row = 0;  ///< of the rig's covariance

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
  Eigen::Index row = 0;
};

/// A matrix S with S S^T = C, without the directions in which nothing varies.
MatX root_of(const MatX& covariance) {
  const VecX sigma = covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
  const VecX inverse = sigma.unaryExpr([](double s) { return s > 0 ? 1 / s : 0.0; });
  const MatX correlation = inverse.asDiagonal() * covariance * inverse.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<MatX> eigen(correlation);
  const Eigen::Index all = covariance.rows();
  Eigen::Index first = 0;  // the values ascend
  while (first < all && !(eigen.eigenvalues()[first] > 1e-10)) ++first;
  return sigma.asDiagonal() * eigen.eigenvectors().rightCols(all - first) *
         eigen.eigenvalues().tail(all - first).cwiseSqrt().asDiagonal();
}

std::vector<Parameter> named_parameters(const RigCamera& camera, const std::string& of_projector,
                                        const Camera* projector, const NamedCovariance& covariance) {
  std::vector<Parameter> parameters;
  const auto take = [&](Parameter::Of of, const std::vector<std::string>& all, const std::string& prefix) {
    for (std::size_t i = 0; i < all.size(); ++i) {
      const auto row = covariance.index_of(prefix + all[i]);
      if (row && covariance.matrix(*row, *row) > 0) parameters.push_back({of, Eigen::Index(i), *row});
    }
  };
  take(Parameter::Of::kCamera, parameter_names(camera.camera), camera.name + ".");
  take(Parameter::Of::kCameraPose, pose_increment_names("rig_from_" + camera.name), "");
  if (projector == nullptr) return parameters;
  take(Parameter::Of::kProjector, parameter_names(*projector), of_projector + ".");
  take(Parameter::Of::kProjectorPose, pose_increment_names("rig_from_" + of_projector), "");
  return parameters;
}

class RigError {
 public:
  RigError(const Rig& rig, const RigCamera& camera, const RigProjector& projector)
      : devices_{camera, projector} {
    for (const Parameter& parameter :
         named_parameters(camera, projector.name, &projector.projector.inverse_camera, rig.covariance)) {
      const double step = 0.1 * std::sqrt(rig.covariance.matrix(parameter.row, parameter.row));
      changed_.push_back(
          {parameter.moved(devices_, step), parameter.moved(devices_, -step), step, parameter.row});
    }
    if (!changed_.empty()) root_ = root_of(rig.covariance.matrix);
  }

  bool empty() const { return changed_.empty(); }
  const MatX& root() const { return root_; }

  /// Of the point (3 rows, in the rig's frame), of the depth, and of the part of column and row that no depth explains (2 rows,
  /// projector pixels) by each element of c; empty where a device does not see the point
  /// under some change.
  MatX modes(const Vec2& pixel, double z, const Vec2& light_sigma) const {
    const double dz = 1e-4 * z;
    const std::optional<Vec2> nearer = devices_.project(pixel, z - dz),
                              farther = devices_.project(pixel, z + dz);
    if (!nearer || !farther) return {};
    const Vec2 weight = light_sigma.cwiseAbs2().cwiseInverse();
    const Vec2 by_depth = (*farther - *nearer) / (2 * dz);
    const double information = weight.dot(by_depth.cwiseAbs2());
    if (!(information > 0)) return {};
    MatX gradient = MatX::Zero(6, root_.rows());
    for (const Changed& changed : changed_) {
      const std::optional<Vec2> up = changed.up.project(pixel, z), down = changed.down.project(pixel, z);
      if (!up || !down) return {};
      const Vec2 by_parameter = (*up - *down) / (2 * changed.step);
      const double depth = -weight.cwiseProduct(by_depth).dot(by_parameter) / information;
      const std::optional<Vec3> high = changed.up.point(pixel, z + depth * changed.step),
                                low = changed.down.point(pixel, z - depth * changed.step);
      if (!high || !low) return {};
      gradient.col(changed.row) << (*high - *low) / (2 * changed.step), depth,
          by_parameter + by_depth * depth;
    }
    return gradient * root_;
  }

 private:
  Devices devices_;
  std::vector<Changed> changed_;
  MatX root_;
};

/// The weights of the cells around a pixel, for a point at depth z. Cells on another surface count little.
template <typename Visit>
double each_node(const RigModes& modes, const Vec2& pixel, double z, const Visit& visit) {
  const std::size_t stride = 1 + 4 * std::size_t(modes.count());
  const double fx = (pixel.x() + 0.5) / kCell - 0.5, fy = (pixel.y() + 0.5) / kCell - 0.5;
  const int column = int(std::floor(fx)), row = int(std::floor(fy));
  double weights = 0;
  for (int j = std::max(0, row); j <= std::min(modes.rows - 1, row + 1); ++j)
    for (int i = std::max(0, column); i <= std::min(modes.columns - 1, column + 1); ++i) {
      const float* node =
          &modes.nodes[(std::size_t(j) * std::size_t(modes.columns) + std::size_t(i)) * stride];
      if (!(node[0] > 0)) continue;
      const double depth = double(node[0]), step = (z - depth) / (0.05 * z);
      const double weight =
          (1.01 - std::abs(fx - i)) * (1.01 - std::abs(fy - j)) / (1 + step * step * step * step);
      visit(node, weight, (z / depth) * (z / depth));
      weights += weight;
    }
  return weights;
}

void set_nodes(const LightMap& light, const RigError& error, int threads, Scan& scan) {
  RigModes& modes = scan.rig_modes;
  const std::size_t stride = 1 + 4 * std::size_t(modes.count());
  modes.columns = cell_columns(scan.depth.width());
  modes.rows = cell_rows(scan.depth.height());
  modes.nodes.assign(std::size_t(modes.columns) * std::size_t(modes.rows) * stride, 0.0f);
  // Squares of the inconsistency by each cell; negative: none.
  std::vector<double> left(std::size_t(modes.columns) * std::size_t(modes.rows), -1.0);
  parallel_each(modes.rows, threads, [&](int row) {
    for (int column = 0; column < modes.columns; ++column) {
      const Eigen::Vector2i at = pixel_of_cell(scan.depth, column, row);
      if (at.x() < 0) continue;
      const double z = double(scan.depth.at(at.x(), at.y()));
      const Vec2 sigma(light.sigma.at(at.x(), at.y(), 0), light.sigma.at(at.x(), at.y(), 1));
      const MatX of_pixel = error.modes(at.cast<double>(), z, sigma);
      if (of_pixel.size() == 0) continue;
      const MatX of_point = of_pixel.topRows<4>();
      const std::size_t cell = std::size_t(row) * std::size_t(modes.columns) + std::size_t(column);
      left[cell] = of_pixel.bottomRows<2>().squaredNorm();
      float* node = &modes.nodes[cell * stride];
      node[0] = float(z);
      for (Eigen::Index i = 0; i < of_point.size(); ++i) node[1 + i] = float(of_point.data()[i]);
    }
  });
  double squares = 0;
  int cells = 0;
  for (const double of_cell : left)
    if (of_cell >= 0) {
      squares += of_cell;
      ++cells;
    }
  scan.consistency_px_of_rig = std::sqrt(squares / std::max(cells, 1));
}

}  // namespace

Eigen::Vector2i pixel_of_cell(const ImageF& depth, int column, int row) {
  Eigen::Vector2i found(-1, -1);
  int best = kCell * kCell;
  for (int y = row * kCell; y < std::min(depth.height(), (row + 1) * kCell); ++y)
    for (int x = column * kCell; x < std::min(depth.width(), (column + 1) * kCell); ++x) {
      const int dx = x - column * kCell - kCell / 2, dy = y - row * kCell - kCell / 2;
      if (depth.at(x, y) > 0 && dx * dx + dy * dy < best) {
        best = dx * dx + dy * dy;
        found = {x, y};
      }
    }
  return found;
}

bool rig_modes_at(const RigModes& modes, const Vec2& pixel, double z, MatX& errors) {
  errors.setZero(4, modes.count());
  const double weights = each_node(modes, pixel, z, [&](const float* node, double weight, double growth) {
    for (Eigen::Index i = 0; i < errors.size(); ++i)
      errors.data()[i] += weight * growth * double(node[1 + i]);
  });
  if (!(weights > 0)) return false;
  errors /= weights;
  return true;
}

ImageF carried(const ImageF& depth, const std::vector<float>& cells, int threads) {
  RigModes values;
  values.root = MatX(0, 1);
  values.columns = cell_columns(depth.width());
  values.rows = cell_rows(depth.height());
  for (std::size_t at = 0; at + 1 < cells.size(); at += 2)
    values.nodes.insert(values.nodes.end(), {cells[at], cells[at + 1], 0.0f, 0.0f, 0.0f});
  ImageF out(depth.size());
  parallel_each(depth.height(), threads, [&](int y) {
    for (int x = 0; x < depth.width(); ++x) {
      const double z = double(depth.at(x, y));
      if (!(z > 0)) continue;
      double sum = 0;
      const double weights = each_node(
          values, Vec2(x, y), z,
          [&](const float* node, double weight, double growth) { sum += weight * growth * double(node[1]); });
      if (weights > 0) out.at(x, y) = float(sum / weights);
    }
  });
  return out;
}

RigCamera without_error(const RigCamera& camera, const RigModes& modes, const VecX& c) {
  NamedCovariance named{modes.names, modes.root * modes.root.transpose()};
  const VecX error = modes.root * c;
  Devices devices{camera, {}};
  for (const Parameter& parameter : named_parameters(camera, "", nullptr, named))
    devices = parameter.moved(devices, -error[parameter.row]);
  return devices.camera;
}

void set_rig_error(const LightMap& light, const Rig& rig, const RigProjector& projector, int threads,
                   Scan& scan) {
  scan.rig_sigma = ImageF(scan.depth.size());
  scan.rig_modes = {};
  const RigError error(rig, scan.camera, projector);
  if (error.empty()) return;
  scan.rig_modes.names = rig.covariance.names;
  scan.rig_modes.root = error.root();
  set_nodes(light, error, threads, scan);
  const std::size_t count = std::size_t(scan.rig_modes.count()), stride = 1 + 4 * count;
  std::vector<float> cells;
  for (std::size_t at = 0; at < scan.rig_modes.nodes.size(); at += stride) {
    const float* node = &scan.rig_modes.nodes[at];
    double squares = 0;
    for (std::size_t k = 0; k < count; ++k) squares += double(node[4 + 4 * k]) * double(node[4 + 4 * k]);
    cells.insert(cells.end(), {node[0], float(std::sqrt(squares))});
  }
  scan.rig_sigma = carried(scan.depth, cells, threads);
}

}  // namespace procam::scan
