#include "procam/depth/main_planes.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <numeric>
#include "plane_estimate.hpp"

namespace procam::depth {
namespace {

/// A curve of which less lies in the band is not flat.
constexpr double kWhole = 0.9;
/// A fine plane of which less lies in the band only crosses it.
constexpr double kMember = 0.25;
/// A main plane of which a fine one is more than this is that one.
constexpr double kNearlyAll = 0.9;
/// Pairs of so many of the largest fine planes are tried together.
constexpr std::size_t kPaired = 12;
/// Every fourth pixel of every fourth row is looked at; every eighth while starts are compared.
constexpr int kStep = 4;
/// Starts that are followed to their end in each round.
constexpr std::size_t kFollowed = 4;

struct Reading {
  Eigen::Vector3f point;
  float band, weight;  ///< half the band, and 1 / band^2
  int label;
};

struct PointSums {
  Vec3 sum = Vec3::Zero();
  Mat3 squares = Mat3::Zero();
  double n = 0, w = 0;

  void add(const Vec3& p, double weight) {
    sum += weight * p;
    squares.noalias() += weight * p * p.transpose();
    n += 1;
    w += weight;
  }
  PointSums& operator+=(const PointSums& o) {
    sum += o.sum, squares += o.squares, n += o.n, w += o.w;
    return *this;
  }
};

struct FittedPlane {
  Plane plane;
  double mean_square = 0;  ///< weighted, of what is across it
};
/// Weighted least squares; the normal towards the camera. Nothing for fewer than three points, or through the
/// camera itself.
std::optional<FittedPlane> fit_points(const PointSums& sums) {
  if (sums.n < 3) return std::nullopt;
  const Vec3 mean = sums.sum / sums.w;
  const Eigen::SelfAdjointEigenSolver<Mat3> eigen(sums.squares / sums.w - mean * mean.transpose());
  Vec3 normal = eigen.eigenvectors().col(0);
  if (normal.dot(mean) > 0) normal = -normal;
  const double offset = -normal.dot(mean);
  if (eigen.info() != Eigen::Success || !(offset > 1e-3)) return std::nullopt;
  return FittedPlane{{normal, offset}, std::max(eigen.eigenvalues()[0], 0.0)};
}

/// What lies in a plane's band.
struct Support {
  PointSums sums;
  std::vector<std::size_t> readings;
};

class Consensus {
 public:
  Consensus(std::vector<Reading> readings, int planes, int curves)
      : readings_(std::move(readings)), planes_(planes), of_curve_(std::size_t(curves)) {
    for (const Reading& r : readings_)
      if (r.label >= planes_) ++of_curve_[std::size_t(r.label - planes_)];
  }

  const Reading& reading(std::size_t i) const { return readings_[i]; }

  Support support(const Plane& plane) const {
    const Eigen::Vector3f normal = plane.normal.cast<float>();
    const auto offset = float(plane.offset);
    Support out;
    std::vector<int> inside(of_curve_.size());
    for (std::size_t i = 0; i < readings_.size(); ++i) {
      const Reading& r = readings_[i];
      if (!(std::abs(normal.dot(r.point) + offset) < r.band)) continue;
      out.readings.push_back(i);
      if (r.label >= planes_) ++inside[std::size_t(r.label - planes_)];
    }
    const auto is_cut = [&](std::size_t i) {
      const int curve = readings_[i].label - planes_;
      return curve >= 0 && inside[std::size_t(curve)] < kWhole * of_curve_[std::size_t(curve)];
    };
    out.readings.erase(std::remove_if(out.readings.begin(), out.readings.end(), is_cut), out.readings.end());
    for (const std::size_t i : out.readings)
      out.sums.add(readings_[i].point.cast<double>(), double(readings_[i].weight));
    return out;
  }

  /// Fitted to what lies in its band until that changes nothing, at most so many times.
  Support settle(Plane& plane, int rounds) const {
    Support out = support(plane);
    for (int round = 0; round < rounds; ++round) {
      const auto fitted = fit_points(out.sums);
      if (!fitted) break;
      plane = fitted->plane;
      Support next = support(plane);
      const bool still = next.readings == out.readings;
      out = std::move(next);
      if (still) break;
    }
    return out;
  }

  void take_out(const Plane& plane) {
    const Support in = support(plane);
    for (const std::size_t i : in.readings) readings_[i].band = 0;
    readings_.erase(
        std::remove_if(readings_.begin(), readings_.end(), [](const Reading& r) { return !(r.band > 0); }),
        readings_.end());
  }

 private:
  std::vector<Reading> readings_;
  int planes_;
  std::vector<int> of_curve_;  ///< readings on each curve, those taken out as well
};

std::vector<Reading> readings_of(const Planes& fine, const DepthImage& image, const RayTable& rays,
                                 const MainPlaneOptions& options, int step) {
  std::vector<Reading> out;
  for (int y = 0; y < rays.size().height; y += step)
    for (int x = 0; x < rays.size().width; x += step) {
      const float z = image.at(x, y), u = rays.u(x, y), v = rays.v(x, y);
      if (!(z > 0 && double(z) < options.farthest) || std::isnan(u) || std::isnan(v)) continue;
      const float band = float(options.band_floor) + float(options.band_square) * z * z;
      out.push_back({z * Eigen::Vector3f(u, v, 1), band, 1 / (band * band), fine.labels.at(x, y)});
    }
  return out;
}

std::vector<Plane> starts_of(const Planes& fine, const std::vector<Reading>& readings) {
  std::vector<Plane> out;
  for (const DetectedPlane& plane : fine.planes) out.push_back(plane.estimate.plane);
  std::vector<PointSums> sums(std::min(fine.planes.size(), kPaired));
  for (const Reading& r : readings)
    if (r.label >= 0 && std::size_t(r.label) < sums.size())
      sums[std::size_t(r.label)].add(r.point.cast<double>(), double(r.weight));
  for (std::size_t i = 0; i < sums.size(); ++i)
    for (std::size_t j = i + 1; j < sums.size(); ++j) {
      PointSums both = sums[i];
      both += sums[j];
      if (const auto fitted = fit_points(both)) out.push_back(fitted->plane);
    }
  return out;
}

/// See the header.
Mat4 covariance_of_steps(const FittedPlane& fitted, const PointSums& sums) {
  const Eigen::Matrix<double, 3, 2> turns = turns_of(fitted.plane.normal);
  Mat3 a;
  a.topLeftCorner<2, 2>() = turns.transpose() * sums.squares * turns;
  a.topRightCorner<2, 1>() = turns.transpose() * sums.sum;
  a.bottomLeftCorner<1, 2>() = a.topRightCorner<2, 1>().transpose();
  a(2, 2) = sums.w;
  const Mat3 covariance = fitted.mean_square * (a / sums.w).ldlt().solve(Mat3::Identity());
  Eigen::Matrix<double, 4, 3> j = Eigen::Matrix<double, 4, 3>::Zero();
  j.topLeftCorner<3, 2>() = turns;
  j(3, 2) = 1;
  return j * covariance * j.transpose();
}

struct Found {
  DetectedPlane plane;
  std::vector<int> members;
};

std::vector<Found> search(const Planes& fine, const DepthImage& image, const RayTable& rays,
                          const MainPlaneOptions& options) {
  const int planes = int(fine.planes.size()), curves = int(fine.curves.size());
  const std::vector<Reading> all = readings_of(fine, image, rays, options, kStep);
  std::vector<double> of_label(std::size_t(planes + curves));
  for (const Reading& r : all)
    if (r.label >= 0) of_label[std::size_t(r.label)] += 1;
  std::vector<Plane> starts = starts_of(fine, all);
  Consensus consensus(all, planes, curves),
      thin(readings_of(fine, image, rays, options, 2 * kStep), planes, curves);
  std::vector<Found> out;
  for (;;) {
    // Compared on few readings, then the best of them on more.
    std::vector<std::pair<double, std::size_t>> order;
    for (std::size_t i = 0; i < starts.size(); ++i)
      order.emplace_back(-thin.settle(starts[i], out.empty() ? 6 : 3).sums.n, i);
    std::sort(order.begin(), order.end());
    Support best;
    Plane plane;
    for (std::size_t k = 0; k < std::min(order.size(), kFollowed); ++k) {
      Plane candidate = starts[order[k].second];
      Support support = consensus.settle(candidate, 30);
      if (support.sums.n > best.sums.n) best = std::move(support), plane = candidate;
    }
    const auto fitted = fit_points(best.sums);
    if (!fitted || best.sums.n < options.min_share * double(all.size())) return out;
    std::vector<double> inside(of_label.size());
    double squares = 0;
    for (const std::size_t i : best.readings) {
      const Reading& r = consensus.reading(i);
      if (r.label >= 0) inside[std::size_t(r.label)] += 1;
      const double off = fitted->plane.signed_distance(r.point.cast<double>());
      squares += off * off;
    }
    Found found;
    found.plane.rms = std::sqrt(squares / best.sums.n);
    for (std::size_t k = 0; k < inside.size(); ++k)
      if (inside[k] > 0 && inside[k] >= kMember * of_label[k]) found.members.push_back(int(k));
    const auto largest = std::max_element(inside.begin(), inside.end());
    if (*largest < kNearlyAll * best.sums.n) {
      found.plane.estimate.plane = fitted->plane;
      found.plane.estimate.covariance = covariance_of_steps(*fitted, best.sums);
      const Vec3 mean = best.sums.sum / best.sums.w;
      if (const auto k = std::size_t(largest - inside.begin()); k < fine.planes.size())
        found.plane.noise_rms = fine.planes[k].noise_rms;
      found.plane.middle = mean - fitted->plane.signed_distance(mean) * fitted->plane.normal;
      out.push_back(std::move(found));
    }
    consensus.take_out(plane);
    thin.take_out(plane);
  }
}

/// Each pixel to the main plane in whose band it is, the nearest by its band, where its fine plane is a
/// member or it has none. Adds pixels and areas, and takes them from the fine ones.
Image<std::int16_t> owners(const Planes& fine, const DepthImage& image, const RayTable& rays,
                           const MainPlaneOptions& options, std::vector<Found>& found,
                           std::vector<int>& left) {
  const auto count = std::int16_t(found.size());
  std::vector<std::vector<char>> gives(found.size(), std::vector<char>(left.size()));
  for (std::size_t k = 0; k < found.size(); ++k)
    for (const int member : found[k].members) gives[k][std::size_t(member)] = 1;
  const Intrinsics& camera = rays.camera().intrinsics;
  Image<std::int16_t> out(rays.size());
  for (int y = 0; y < rays.size().height; ++y)
    for (int x = 0; x < rays.size().width; ++x) {
      const int label = fine.labels.at(x, y);
      std::int16_t& owner = out.at(x, y);
      owner = label < 0 ? std::int16_t(label) : std::int16_t(count + label);
      const double z = double(image.at(x, y)), u = double(rays.u(x, y)), v = double(rays.v(x, y));
      if (label == Planes::kNothing || !(z > 0) || std::isnan(u) || std::isnan(v)) continue;
      const double near = std::min(z, options.farthest);
      double nearest = options.band_floor + options.band_square * near * near;
      for (std::size_t k = 0; k < found.size(); ++k) {
        if (label >= 0 && !gives[k][std::size_t(label)]) continue;
        const double off = std::abs(found[k].plane.estimate.plane.signed_distance(z * Vec3(u, v, 1)));
        if (off < nearest) nearest = off, owner = std::int16_t(k);
      }
      if (owner < 0 || owner >= count) continue;
      DetectedPlane& plane = found[std::size_t(owner)].plane;
      ++plane.pixels;
      plane.area += z * z * z / (plane.estimate.plane.offset * camera.fx * camera.fy);
      if (label >= 0) --left[std::size_t(label)];
    }
  return out;
}

void check_main_planes(const Planes& fine, const DepthImage& image, const RayTable& rays,
                       const MainPlaneOptions& options) {
  require(image.size() == rays.size() && fine.labels.size() == rays.size(),
          "main_planes: the image, the camera and the planes found before must be of one size");
  require(options.band_floor >= 0 && options.band_square >= 0 && options.band_floor + options.band_square > 0,
          "main_planes: the band must be positive");
  require(options.farthest > 0 && options.farthest < 1e4 && options.min_share > 0 && options.min_share <= 1,
          "main_planes: farthest must be positive and min_share between 0 and 1");
}

}  // namespace

MainPlanes main_planes(const Planes& fine, const DepthImage& image, const RayTable& rays,
                       const MainPlaneOptions& options) {
  check_main_planes(fine, image, rays, options);
  std::vector<Found> found = search(fine, image, rays, options);
  const std::size_t mains = found.size(), planes = fine.planes.size(), curves = fine.curves.size();
  std::vector<int> left;
  for (const DetectedPlane& plane : fine.planes) left.push_back(plane.pixels);
  for (const DetectedCurve& curve : fine.curves) left.push_back(curve.pixels);
  const std::vector<int> before = left;
  const Image<std::int16_t> owner = owners(fine, image, rays, options, found, left);
  const auto stays = [&](std::size_t k) { return 2 * left[k] > before[k]; };

  // Main planes and the fine ones that stay, the largest first; then curves.
  MainPlanes out;
  std::vector<std::pair<int, std::size_t>> order;
  for (std::size_t k = 0; k < mains; ++k) order.emplace_back(-found[k].plane.pixels, k);
  for (std::size_t k = 0; k < planes; ++k)
    if (stays(k)) order.emplace_back(-left[k], mains + k);
  std::sort(order.begin(), order.end());
  std::vector<std::int16_t> place(mains + planes + curves, Planes::kNone);
  for (const auto& [pixels, k] : order) {
    place[k] = std::int16_t(out.planes.planes.size());
    out.planes.planes.push_back(k < mains ? found[k].plane : fine.planes[k - mains]);
    DetectedPlane& plane = out.planes.planes.back();
    plane.area *= -double(pixels) / std::max(plane.pixels, 1);
    plane.pixels = -pixels;
    out.members.push_back(k < mains ? found[k].members : std::vector<int>{int(k - mains)});
  }
  for (std::size_t k = 0; k < curves; ++k)
    if (stays(planes + k)) {
      place[mains + planes + k] = std::int16_t(out.planes.planes.size() + out.planes.curves.size());
      out.planes.curves.push_back(fine.curves[k]);
      out.planes.curves.back().pixels = left[planes + k];
    }
  out.planes.noise_ratio = fine.noise_ratio;
  out.planes.labels = Image<std::int16_t>(rays.size());
  for (int y = 0; y < rays.size().height; ++y)
    for (int x = 0; x < rays.size().width; ++x) {
      const std::int16_t at = owner.at(x, y);
      out.planes.labels.at(x, y) = at < 0 ? at : place[std::size_t(at)];
    }
  return out;
}

}  // namespace procam::depth
