#include "procam/depth/height_field.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "procam/core/base/error.hpp"
#include "procam/core/base/stats.hpp"

namespace procam::depth {
namespace {

constexpr double kLongestPrediction = 0.2;  // seconds; a rate says little of later
constexpr double kFirstRateSigma = 0.2;     // m/s
constexpr float kCoveredShare = 0.15f;      // of a cell's readings
constexpr float kFewestReadings = 2;
constexpr double kSameHeight = 0.01;  // metres that what rests may seem to move by
constexpr double kGrazing = 0.1;      // cosine between normal and ray

struct RayReading {
  Vec3 ray;
  double inverse_depth = 0;
};

PixelRegion region_or_middle(const std::optional<PixelRegion>& region, ImageSize size) {
  const int x = size.width / 10, y = size.height / 10;
  const PixelRegion r = region.value_or(PixelRegion{x, y, size.width - 2 * x, size.height - 2 * y});
  if (r.x < 0 || r.y < 0 || r.width < 8 || r.height < 8 || r.width > size.width - r.x ||
      r.height > size.height - r.y)
    throw Error(ErrorKind::kInput, "region of the shape",
                "it is smaller than 8x8 pixels, or not inside of the depth image of " +
                    std::to_string(size.width) + "x" + std::to_string(size.height) + " pixels",
                "give X:Y:WIDTHxHEIGHT in pixels of the depth camera");
  return r;
}

std::vector<RayReading> readings_of(const DepthImage& image, const RayTable& rays, const PixelRegion& r) {
  constexpr int kStep = 3;  // a ninth of the readings fit a plane as well
  std::vector<RayReading> readings;
  int asked = 0;
  for (int y = r.y; y < r.y + r.height; y += kStep)
    for (int x = r.x; x < r.x + r.width; x += kStep) {
      ++asked;
      const float z = image.at(x, y);
      const Vec3 ray(rays.u(x, y), rays.v(x, y), 1);
      if (z > 0 && ray.allFinite()) readings.push_back({ray, 1 / double(z)});
    }
  if (int(readings.size()) * 4 < asked)
    throw Error(ErrorKind::kNotEnoughData, "region of the shape",
                "the depth camera has readings in " + std::to_string(readings.size()) + " of " +
                    std::to_string(asked) + " of its pixels",
                "move the camera to 0.5 to 4 m from the surface, or name another region");
  return readings;
}

/// n with n . X = 1 for the points X of the plane: 1/z = n . ray is linear.
Vec3 fit_plane(const std::vector<RayReading>& readings) {
  constexpr int kRounds = 8;
  constexpr double kHuber = 1.5;  // of the residuals' standard deviation by their median
  std::vector<double> weights(readings.size(), 1.0), sizes(readings.size());
  Vec3 plane = Vec3::Zero();
  for (int round = 0; round < kRounds; ++round) {
    Mat3 normal = Mat3::Zero();
    Vec3 right = Vec3::Zero();
    for (std::size_t i = 0; i < readings.size(); ++i) {
      normal += weights[i] * readings[i].ray * readings[i].ray.transpose();
      right += weights[i] * readings[i].inverse_depth * readings[i].ray;
    }
    plane = normal.ldlt().solve(right);
    for (std::size_t i = 0; i < readings.size(); ++i)
      sizes[i] = std::abs(readings[i].inverse_depth - plane.dot(readings[i].ray));
    std::vector<double> sorted = sizes;
    std::nth_element(sorted.begin(), sorted.begin() + std::ptrdiff_t(sorted.size() / 2), sorted.end());
    const double limit = std::max(1e-9, kHuber * 1.4826 * sorted[sorted.size() / 2]);
    for (std::size_t i = 0; i < readings.size(); ++i) weights[i] = sizes[i] <= limit ? 1 : limit / sizes[i];
  }
  return plane;
}

}  // namespace

ReferencePlane fit_reference_plane(const DepthImage& image, const RayTable& rays,
                                   const std::optional<PixelRegion>& region) {
  require(image.size() == rays.size(), "fit_reference_plane: the image is not of the camera's size");
  const PixelRegion r = region_or_middle(region, image.size());
  const Vec3 plane = fit_plane(readings_of(image, rays, r));
  const auto refuse = [] {
    throw Error(ErrorKind::kDegenerate, "region of the shape",
                "the plane through it is seen from its edge, or has no area",
                "aim the depth camera at the surface, or name another region");
  };
  if (!plane.allFinite() || !(plane.norm() > 0)) refuse();
  const Vec3 z = plane.normalized();
  const Vec3 across = Vec3::UnitX() - z * z.x();
  if (!(across.norm() > kGrazing)) refuse();
  const Vec3 x = across.normalized(), y = z.cross(x);
  const std::array<std::array<int, 2>, 4> corners = {{{r.x, r.y},
                                                      {r.x + r.width - 1, r.y},
                                                      {r.x + r.width - 1, r.y + r.height - 1},
                                                      {r.x, r.y + r.height - 1}}};
  std::array<Vec2, 4> seen;
  for (std::size_t i = 0; i < 4; ++i) {
    const Vec3 ray(rays.u(corners[i][0], corners[i][1]), rays.v(corners[i][0], corners[i][1]), 1);
    if (!ray.allFinite() || !(z.dot(ray.normalized()) > kGrazing)) refuse();
    const Vec3 point = ray / plane.dot(ray);
    seen[i] = {x.dot(point), y.dot(point)};
  }
  const Vec2 low(std::max(seen[0].x(), seen[3].x()), std::max(seen[0].y(), seen[1].y()));
  const Vec2 high(std::min(seen[1].x(), seen[2].x()), std::min(seen[2].y(), seen[3].y()));
  if (!((high - low).minCoeff() > 0.05)) refuse();
  Mat3 rotation;
  rotation << x, y, z;
  return {Pose(Eigen::Quaterniond(rotation), low.x() * x + low.y() * y + z / plane.norm()), high - low};
}

HeightField::HeightField(const Vec2& size, const HeightFieldOptions& options) : options_(options) {
  const HeightFieldOptions& o = options_;
  require(o.cell > 0 && o.acceleration > 0 && o.max_height > 0 && o.max_jump > 0 && o.settle_after >= 0 &&
              o.margin >= 0 && o.max_sigma > 0 && o.max_gap >= 0,
          "HeightField: a length, density or time that is negative, or no cell");
  const Vec2 cells = size / o.cell;
  require(cells.minCoeff() >= 2 && cells.maxCoeff() <= 1000, "HeightField: between 2 and 1000 cells a side");
  columns_ = int(cells.x());
  rows_ = int(cells.y());
  const std::size_t count = std::size_t(columns_) * std::size_t(rows_);
  cells_.resize(count);
  sums_.resize(count);
  lowest_.resize(count);
  highest_.resize(count);
  covered_.resize(count);
  hidden_.resize(count);
}

void HeightField::update(const DepthImage& image, const RayTable& rays, const Pose& reference_from_camera,
                         double time) {
  require(image.size() == rays.size(), "HeightField: the image is not of the camera's size");
  require(reference_from_camera.is_finite() && std::isfinite(time),
          "HeightField: a pose or time is not finite");
  if (has_image_ && !(time > time_)) return;
  if (has_image_) predict(time - time_);
  has_image_ = true;
  time_ = time;
  const Pose camera_from_reference = reference_from_camera.inverse();
  for (int row = 0; row < rows_; ++row)
    for (int column = 0; column < columns_; ++column) {
      const std::size_t i = index(column, row);
      const Cell& cell = cells_[i];
      lowest_[i] = -std::numeric_limits<float>::infinity();
      highest_[i] = float(options_.max_height);
      if (!(cell.hh > 0)) continue;
      const Vec3 point((column + 0.5) * options_.cell, (row + 0.5) * options_.cell, -cell.height);
      const double gate =
          options_.max_jump + 4 * reading_sigma(camera_from_reference, point, slope(column, row));
      lowest_[i] = float(cell.height - gate);
      highest_[i] = float(std::min(options_.max_height, cell.height + gate));
    }
  collect(image, rays, reference_from_camera);
  find_covered(time);
  measure(reference_from_camera);
}

void HeightField::predict(double dt) {
  const double q = options_.acceleration;
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    Cell& cell = cells_[i];
    if (!(cell.hh > 0)) continue;
    // Of what is not seen, nobody knows how it goes on.
    if (hidden_[i]) cell.rate = 0;
    cell.height += dt * cell.rate;
    cell.hh += dt * (2 * cell.hr + dt * (cell.rr + q * dt / 3));
    cell.hr += dt * (cell.rr + q * dt / 2);
    cell.rr += q * dt;
  }
}

void HeightField::collect(const DepthImage& image, const RayTable& rays, const Pose& reference_from_camera) {
  std::fill(sums_.begin(), sums_.end(), Sums());
  const Eigen::Matrix3f r = reference_from_camera.rotation.toRotationMatrix().cast<float>();
  const Eigen::Vector3f t = reference_from_camera.translation.cast<float>();
  const float per_metre = float(1 / options_.cell), cell = float(options_.cell);
  for (int y = 0; y < image.size().height; ++y)
    for (int x = 0; x < image.size().width; ++x) {
      const float z = image.at(x, y), u = rays.u(x, y), v = rays.v(x, y);
      const float px = (t.x() + z * (r(0, 0) * u + r(0, 1) * v + r(0, 2))) * per_metre;
      const float py = (t.y() + z * (r(1, 0) * u + r(1, 1) * v + r(1, 2))) * per_metre;
      if (!(z > 0 && px >= 0 && py >= 0 && px < float(columns_) && py < float(rows_))) continue;
      const float height = -(t.z() + z * (r(2, 0) * u + r(2, 1) * v + r(2, 2)));
      const int column = int(px), row = int(py);
      const std::size_t i = index(column, row);
      Sums& sums = sums_[i];
      if (height > highest_[i]) {
        sums.above += 1;
        sums.above_height += height;
      } else if (height < lowest_[i]) {
        sums.below += 1;
        sums.below_height += height;
      } else {
        sums.own += 1;
        sums.own_height += height;
        sums.own_x += cell * (px - float(column) - 0.5f);
        sums.own_y += cell * (py - float(row) - 0.5f);
      }
    }
}

void HeightField::begin_again(Cell& cell, double height, double variance) const {
  cell = Cell();
  cell.height = height;
  cell.hh = variance;
  cell.rr = kFirstRateSigma * kFirstRateSigma;
}

void HeightField::find_covered(double time) {
  constexpr double kFirstVariance = 1e-4;  // (10 mm)^2: the readings of this image follow
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    Cell& cell = cells_[i];
    Sums& sums = sums_[i];
    const float all = sums.own + sums.above + sums.below;
    covered_[i] = 0;
    if (sums.above >= kFewestReadings && sums.above > kCoveredShare * all) {
      const double height = double(sums.above_height / sums.above);
      covered_[i] = 1;
      if (!cell.has_candidate || std::abs(height - cell.candidate) > kSameHeight) {
        cell.has_candidate = height <= options_.max_height;
        cell.candidate = height;
        cell.since = time;
      } else if (time - cell.since >= options_.settle_after) {
        begin_again(cell, height, kFirstVariance);
        covered_[i] = 0;
      }
      continue;
    }
    cell.has_candidate = false;
    if (sums.below >= kFewestReadings && sums.below > all / 2)
      begin_again(cell, double(sums.below_height / sums.below), kFirstVariance);
    else if (!(cell.hh > 0) && sums.own >= kFewestReadings)
      begin_again(cell, double(sums.own_height / sums.own), kFirstVariance);
  }
  const int reach = int(std::ceil(options_.margin / options_.cell));
  std::fill(hidden_.begin(), hidden_.end(), std::uint8_t(0));
  for (int row = 0; row < rows_; ++row)
    for (int column = 0; column < columns_; ++column) {
      if (!covered_[index(column, row)]) continue;
      for (int y = std::max(0, row - reach); y <= std::min(rows_ - 1, row + reach); ++y)
        for (int x = std::max(0, column - reach); x <= std::min(columns_ - 1, column + reach); ++x)
          hidden_[index(x, y)] = 1;
    }
}

Vec2 HeightField::slope(int column, int row) const {
  const auto along = [&](int before_column, int before_row, int after_column, int after_row) {
    if (before_column < 0 || before_row < 0 || after_column >= columns_ || after_row >= rows_) return 0.0;
    const Cell &before = cells_[index(before_column, before_row)],
               &after = cells_[index(after_column, after_row)];
    return before.hh > 0 && after.hh > 0 ? (after.height - before.height) / (2 * options_.cell) : 0.0;
  };
  return {along(column - 1, row, column + 1, row), along(column, row - 1, column, row + 1)};
}

double HeightField::reading_sigma(const Pose& camera_from_reference, const Vec3& point,
                                  const Vec2& slope) const {
  const Vec3 in_camera = camera_from_reference * point;
  if (!(in_camera.z() > 0)) return options_.max_sigma;
  const Vec3 ray = camera_from_reference.rotation.conjugate() * (in_camera / in_camera.z());
  // The height over a fixed place of the plane changes by -dz (d_z + g . d_xy), with h = -z of the frame.
  return options_.noise.sigma(in_camera.z()) * std::abs(ray.z() + slope.dot(ray.head<2>()));
}

void HeightField::measure(const Pose& reference_from_camera) {
  const Pose camera_from_reference = reference_from_camera.inverse();
  constexpr float kKernel[3] = {1, 2, 1};
  for (int row = 0; row < rows_; ++row)
    for (int column = 0; column < columns_; ++column) {
      Cell& cell = cells_[index(column, row)];
      if (!(cell.hh > 0) || hidden_[index(column, row)]) continue;
      float weight = 0, squares = 0, height = 0, x = 0, y = 0;
      for (int j = std::max(0, row - 1); j <= std::min(rows_ - 1, row + 1); ++j)
        for (int i = std::max(0, column - 1); i <= std::min(columns_ - 1, column + 1); ++i) {
          if (hidden_[index(i, j)]) continue;
          const Sums& sums = sums_[index(i, j)];
          const float k = kKernel[i - column + 1] * kKernel[j - row + 1];
          weight += k * sums.own;
          squares += k * k * sums.own;
          height += k * sums.own_height;
          x += k * (sums.own_x + float((i - column) * options_.cell) * sums.own);
          y += k * (sums.own_y + float((j - row) * options_.cell) * sums.own);
        }
      if (sums_[index(column, row)].own <= 0 || !(weight > 0)) continue;
      const Vec2 g = slope(column, row);
      const Vec3 point((column + 0.5) * options_.cell, (row + 0.5) * options_.cell, -cell.height);
      const double sigma = reading_sigma(camera_from_reference, point, g);
      const double variance = sigma * sigma * double(squares / (weight * weight));
      const double residual =
          double(height / weight) - g.dot(Vec2(double(x / weight), double(y / weight))) - cell.height;
      const double total = cell.hh + variance, gain_h = cell.hh / total, gain_r = cell.hr / total;
      cell.height += gain_h * residual;
      cell.rate += gain_r * residual;
      cell.rr -= gain_r * cell.hr;
      cell.hr *= 1 - gain_h;
      cell.hh *= 1 - gain_h;
    }
}

HeightMap HeightField::at(double time) const {
  require(std::isfinite(time), "HeightField: the time is not finite");
  const double dt = has_image_ ? std::clamp(time - time_, 0.0, kLongestPrediction) : 0;
  const double q = options_.acceleration;
  HeightMap map{options_.cell, ImageF(columns_, rows_), ImageF(columns_, rows_)};
  for (int row = 0; row < rows_; ++row)
    for (int column = 0; column < columns_; ++column) {
      const Cell& cell = cells_[index(column, row)];
      // By what the last image left: when no more come, the surface stays where it was, and is not full of holes.
      if (!(cell.hh > 0 && cell.hh <= options_.max_sigma * options_.max_sigma) || hidden_[index(column, row)])
        continue;
      const double variance = cell.hh + dt * (2 * cell.hr + dt * (cell.rr + q * dt / 3));
      map.height.at(column, row) = float(cell.height + dt * cell.rate);
      map.sigma.at(column, row) = float(std::sqrt(std::max(variance, 1e-12)));
    }
  bridge(map);
  return map;
}

void HeightField::bridge(HeightMap& map) const {
  const int reach = int(options_.max_gap / options_.cell);
  const HeightMap seen = map;
  // The nearest known cells of both sides, along a row or a column.
  const auto between = [&](int column, int row, int dx, int dy) {
    const auto find = [&](int sign) {
      for (int k = 1; k <= reach; ++k) {
        const int x = column + sign * k * dx, y = row + sign * k * dy;
        if (x < 0 || y < 0 || x >= columns_ || y >= rows_) return 0;
        if (seen.is_known(x, y)) return k;
      }
      return 0;
    };
    const int before = find(-1), after = find(1);
    if (before == 0 || after == 0 || before + after - 1 > reach) return false;
    const int x0 = column - before * dx, y0 = row - before * dy, x1 = column + after * dx,
              y1 = row + after * dy;
    const float share = float(before) / float(before + after);
    const float h0 = seen.height.at(x0, y0), h1 = seen.height.at(x1, y1);
    map.height.at(column, row) = h0 + share * (h1 - h0);
    // The bridge may be off by what separates its ends, at most.
    map.sigma.at(column, row) =
        std::max(seen.sigma.at(x0, y0), seen.sigma.at(x1, y1)) + 0.3f * std::abs(h1 - h0);
    return true;
  };
  for (int row = 0; row < rows_; ++row)
    for (int column = 0; column < columns_; ++column)
      if (!seen.is_known(column, row) && !hidden_[index(column, row)] && !between(column, row, 1, 0))
        between(column, row, 0, 1);
}

ImageF HeightField::background(const DepthImage& image, const RayTable& rays,
                               const Pose& reference_from_camera) const {
  require(image.size() == rays.size(), "HeightField: the image is not of the camera's size");
  constexpr int kRounds = 3;  // of a slope of one half, an eighth of the first error remains
  ImageF depth(rays.size());
  const Vec3 eye = reference_from_camera.translation;
  const Mat3 rotation = reference_from_camera.rotation.toRotationMatrix();
  const auto depth_at = [&](const Vec3& ray) {
    double height = 0, z = 0;
    for (int round = 0; round < kRounds; ++round) {
      z = (-height - eye.z()) / ray.z();
      const Vec2 place = (eye + z * ray).head<2>() / options_.cell;
      if (!(z > 0 && place.minCoeff() >= 0 && place.x() < columns_ && place.y() < rows_)) return -1.0;
      const Cell& cell = cells_[index(int(place.x()), int(place.y()))];
      if (!(cell.hh > 0)) return 0.0;
      height = cell.height;
    }
    return (-height - eye.z()) / ray.z();
  };
  for (int y = 0; y < depth.height(); ++y)
    for (int x = 0; x < depth.width(); ++x) {
      const Vec3 ray = rotation * Vec3(rays.u(x, y), rays.v(x, y), 1);
      double z = depth_at(ray);
      if (z < 0) z = image.at(x, y) > 0 ? (-options_.max_height - eye.z()) / ray.z() : 0;
      depth.at(x, y) = std::isfinite(z) && z > 0 ? float(z) : 0.0f;
    }
  return depth;
}

std::shared_ptr<const Mesh> mesh_of(const HeightMap& map) {
  auto mesh = std::make_shared<Mesh>();
  const int columns = map.height.width(), rows = map.height.height();
  std::vector<int> number(std::size_t(columns) * std::size_t(rows), -1);
  const auto at = [&](int column, int row) -> int& {
    return number[std::size_t(row) * std::size_t(columns) + std::size_t(column)];
  };
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) {
      if (!map.is_known(column, row)) continue;
      at(column, row) = int(mesh->vertices.size());
      const Vec2 uv((column + 0.5) / columns, (row + 0.5) / rows);
      mesh->uv.push_back(uv);
      mesh->vertices.emplace_back((column + 0.5) * map.cell, (row + 0.5) * map.cell,
                                  -double(map.height.at(column, row)));
    }
  for (int row = 0; row + 1 < rows; ++row)
    for (int column = 0; column + 1 < columns; ++column) {
      const int a = at(column, row), b = at(column + 1, row), c = at(column + 1, row + 1),
                d = at(column, row + 1);
      if (a >= 0 && b >= 0 && c >= 0) mesh->triangles.push_back({a, b, c});
      if (a >= 0 && c >= 0 && d >= 0) mesh->triangles.push_back({a, c, d});
    }
  return mesh;
}

}  // namespace procam::depth
