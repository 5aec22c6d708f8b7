#include "procam/room/points.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "procam/core/base/cholesky.hpp"
#include "procam/core/base/parallel.hpp"
#include "procam/core/base/words.hpp"

namespace procam::room {
namespace {

constexpr int kHalf = 2;  // of the window that a map is linear in, pixels
constexpr int kFewestInWindow = 15;
constexpr int kFewestPoints = 100;

/// The map about a pixel; nullopt where light is missing or the window is on no single smooth surface.
std::optional<LightReading> read(const LightMap& light, const Vec2& at) {
  const ImageSize size = light.camera_size();
  const int cx = int(std::lround(at.x())), cy = int(std::lround(at.y()));
  if (cx < kHalf || cy < kHalf || cx >= size.width - kHalf || cy >= size.height - kHalf) return std::nullopt;
  Mat3 normal = Mat3::Zero();
  Eigen::Matrix<double, 3, 2> right = Eigen::Matrix<double, 3, 2>::Zero();
  Vec2 variance = Vec2::Zero();
  int count = 0;
  for (int y = cy - kHalf; y <= cy + kHalf; ++y)
    for (int x = cx - kHalf; x <= cx + kHalf; ++x) {
      const std::optional<Vec2> p = light.projector_pixel(x, y);
      if (!p) continue;
      const Vec3 a(1, x - at.x(), y - at.y());
      normal += a * a.transpose();
      right += a * p->transpose();
      for (int c = 0; c < 2; ++c)
        variance[c] += double(light.sigma.at(x, y, c)) * double(light.sigma.at(x, y, c));
      ++count;
    }
  if (count < kFewestInWindow) return std::nullopt;
  variance /= count;
  const Eigen::Matrix<double, 3, 2> fit = Cholesky<3>(normal).solve(right);
  double square = 0;
  for (int y = cy - kHalf; y <= cy + kHalf; ++y)
    for (int x = cx - kHalf; x <= cx + kHalf; ++x)
      if (const std::optional<Vec2> p = light.projector_pixel(x, y)) {
        const Vec2 off = fit.transpose() * Vec3(1, x - at.x(), y - at.y()) - *p;
        square = std::max(square, off.cwiseAbs2().cwiseQuotient(variance).maxCoeff());
      }
  // An edge of depth within the window moves the light by pixels; noise of 25 values reaches four sigmas once in 600
  // windows.
  constexpr double kLargest = 5;
  if (!(square < kLargest * kLargest)) return std::nullopt;
  LightReading reading;
  reading.camera_pixel = at;
  reading.projector_pixel = fit.row(0).transpose();
  reading.projector_by_camera = fit.bottomRows<2>().transpose();
  reading.sigma = variance.cwiseSqrt();
  if (!reading.projector_pixel.allFinite() || !(std::abs(reading.projector_by_camera.determinant()) > 1e-4))
    return std::nullopt;
  return reading;
}

/// For each cell of the projector's picture a camera pixel that it lights: where Newton begins.
class InverseMap {
 public:
  explicit InverseMap(const LightMap& light)
      : light_(light),
        columns_(light.projector_size.width / kCell + 1),
        rows_(light.projector_size.height / kCell + 1),
        cells_(std::size_t(columns_) * std::size_t(rows_), {-1, -1}) {
    for (int y = 0; y < light.camera_size().height; ++y)
      for (int x = 0; x < light.camera_size().width; ++x)
        if (const std::optional<Vec2> p = light.projector_pixel(x, y))
          if (const auto cell = cell_of(*p)) cells_[*cell] = {x, y};
  }

  /// Where the camera sees this projector pixel.
  std::optional<LightReading> read_at(const Vec2& projector_pixel) const {
    const auto cell = cell_of(projector_pixel);
    if (!cell || cells_[*cell][0] < 0) return std::nullopt;
    Vec2 at(cells_[*cell][0], cells_[*cell][1]);
    for (int iteration = 0; iteration < 8; ++iteration) {
      const std::optional<LightReading> here = read(light_, at);
      if (!here) return std::nullopt;
      const Vec2 off = projector_pixel - here->projector_pixel;
      const Vec2 step = here->projector_by_camera.inverse() * off;
      if (step.norm() < 0.7 && off.norm() < 1) return here;
      at += step.norm() > 40 ? Vec2(step * (40 / step.norm())) : step;
      at = Vec2(std::round(at.x()), std::round(at.y()));
    }
    return std::nullopt;
  }

 private:
  static constexpr int kCell = 8;  // projector pixels
  std::optional<std::size_t> cell_of(const Vec2& p) const {
    const int i = int(std::floor(p.x() / kCell)), j = int(std::floor(p.y() / kCell));
    if (i < 0 || j < 0 || i >= columns_ || j >= rows_) return std::nullopt;
    return std::size_t(j) * std::size_t(columns_) + std::size_t(i);
  }
  const LightMap& light_;
  int columns_, rows_;
  std::vector<std::array<int, 2>> cells_;
};

int index_of(std::vector<Device>& devices, const std::string& name, DeviceKind kind, ImageSize size) {
  const std::string called = !name.empty() ? name : kind == DeviceKind::kCamera ? "camera" : "projector";
  for (std::size_t i = 0; i < devices.size(); ++i) {
    if (devices[i].name != called) continue;
    if (devices[i].size != size)
      throw Error(ErrorKind::kInput, "'" + called + "'",
                  "its light maps are of " + counts(devices[i].size) + " and of " + counts(size) + " pixels",
                  "capture all views with one resolution");
    return int(i);
  }
  devices.push_back({called, kind, size});
  return int(devices.size()) - 1;
}

int position_of(RoomPoints& out, int camera, const std::string& view) {
  for (std::size_t i = 0; i < out.positions.size(); ++i)
    if (out.positions[i].camera == camera && out.positions[i].view == view) return int(i);
  out.positions.push_back({camera, view});
  return int(out.positions.size()) - 1;
}

int decoded_pixels(const LightMap& light) {
  int count = 0;
  for (int y = 0; y < light.camera_size().height; ++y)
    for (int x = 0; x < light.camera_size().width; ++x) count += light.decoded(x, y);
  return count;
}

/// Reads points of the room in every map of light that sees them.
class PointReader {
 public:
  /// `maps` belong to `lights`, one by one.
  PointReader(const std::vector<PositionLight>& lights, const std::vector<MapDevices>& maps, int threads)
      : lights_(lights), maps_(maps), threads_(threads), inverse_(lights.size()), decoded_(lights.size()) {
    parallel_each(int(lights.size()), threads, [&](int i) {
      inverse_[std::size_t(i)].emplace(lights[std::size_t(i)].light);
      decoded_[std::size_t(i)] = decoded_pixels(lights[std::size_t(i)].light);
    });
  }

  /// The point seen at a camera's pixel in map m: in the other maps of its position by the camera's pixel, in
  /// those of its projector by the projector's pixel.
  std::optional<RoomPoint> point_at(int m, const Vec2& at) const {
    std::optional<LightReading> anchor = read(lights_[std::size_t(m)].light, at);
    if (!anchor) return std::nullopt;
    anchor->map = m;
    RoomPoint point{{*anchor}};
    for (int other = 0; other < int(lights_.size()); ++other) {
      if (other == m) continue;
      std::optional<LightReading> reading;
      if (maps_[std::size_t(other)].position == maps_[std::size_t(m)].position)
        reading = read(lights_[std::size_t(other)].light, at);
      else if (maps_[std::size_t(other)].projector == maps_[std::size_t(m)].projector)
        reading = inverse_[std::size_t(other)]->read_at(anchor->projector_pixel);
      if (!reading) continue;
      reading->map = other;
      point.readings.push_back(*reading);
    }
    return point;
  }

  /// On a grid of map m's camera with about `points` points, row by row.
  std::vector<RoomPoint> points_of_map(int m, int points) const {
    const LightMap& light = lights_[std::size_t(m)].light;
    const ImageSize size = light.camera_size();
    const int step = std::max(kHalf, int(std::sqrt(double(decoded_[std::size_t(m)]) / points)));
    const int rows = size.height / step;
    std::vector<std::vector<RoomPoint>> found(std::size_t(std::max(rows, 0)));
    parallel_each(rows, threads_, [&](int row) {
      for (int x = step / 2; x < size.width; x += step) {
        const Vec2 at(x, row * step + step / 2);
        if (at.y() >= size.height || !light.decoded(x, int(at.y()))) continue;
        if (std::optional<RoomPoint> point = point_at(m, at))
          found[std::size_t(row)].push_back(std::move(*point));
      }
    });
    std::vector<RoomPoint> out;
    for (std::vector<RoomPoint>& row : found) std::move(row.begin(), row.end(), std::back_inserter(out));
    return out;
  }

  RoomPoint marked_point(const MarkedPixel& mark) const {
    for (std::size_t m = 0; m < lights_.size(); ++m) {
      const PositionLight& seen = lights_[m];
      if ((!mark.camera.empty() && mark.camera != seen.camera) ||
          (!mark.view.empty() && mark.view != seen.view))
        continue;
      if (std::optional<RoomPoint> point = point_at(int(m), mark.pixel)) return std::move(*point);
    }
    throw Error(ErrorKind::kInput,
                format("camera pixel %g,%g", mark.pixel.x(), mark.pixel.y()) +
                    (mark.view.empty() ? "" : " of view '" + mark.view + "'"),
                "no projector's light is read there, or it is on an edge",
                "give a pixel on a lit, smooth part of the wall");
  }

  [[noreturn]] void fail_with_too_few(std::size_t points) const {
    const std::size_t least =
        std::size_t(std::min_element(decoded_.begin(), decoded_.end()) - decoded_.begin());
    throw Error(
        ErrorKind::kNotEnoughData, "the room's light",
        std::to_string(points) + " points are read, " + std::to_string(kFewestPoints) +
            " are needed; the least light is in view '" + lights_[least].view + "', " +
            std::to_string(decoded_[least]) + " pixels",
        "darken the room, raise the camera's exposure, and see that it looks at the projected picture");
  }

 private:
  const std::vector<PositionLight>& lights_;
  const std::vector<MapDevices>& maps_;
  int threads_;
  std::vector<std::optional<InverseMap>> inverse_;
  std::vector<int> decoded_;  ///< pixels, by map
};

}  // namespace

RoomPoints room_points(const std::vector<PositionLight>& lights, const RoomPointsOptions& options) {
  require(!lights.empty() && options.points_a_map > 0, "room_points: no light maps, or no points asked for");
  RoomPoints out;
  for (const PositionLight& seen : lights) {
    const int camera = index_of(out.cameras, seen.camera, DeviceKind::kCamera, seen.light.camera_size());
    const int projector =
        index_of(out.projectors, seen.projector, DeviceKind::kProjector, seen.light.projector_size);
    out.maps.push_back({position_of(out, camera, seen.view), projector});
  }
  const PointReader reader(lights, out.maps, options.threads);
  for (int m = 0; m < int(lights.size()); ++m) {
    std::vector<RoomPoint> points = reader.points_of_map(m, options.points_a_map);
    std::move(points.begin(), points.end(), std::back_inserter(out.points));
  }
  if (int(out.points.size()) < kFewestPoints) reader.fail_with_too_few(out.points.size());
  for (const MarkedPixel& mark : options.marked) {
    RoomPoint point = reader.marked_point(mark);
    out.marked.push_back(int(out.points.size()));
    out.points.push_back(std::move(point));
  }
  return out;
}

}  // namespace procam::room
