#include "resect.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <optional>

#include "procam/core/base/error.hpp"
#include "procam/core/base/stats.hpp"
#include "procam/core/geometry/planar_pose.hpp"
#include "procam/core/geometry/se3.hpp"

namespace procam::room {
namespace {

constexpr double kHuberPx = 3;

struct Centred {
  Vec3 mean = Vec3::Zero();
  double size = 1;      ///< root mean square distance from the mean
  Mat3 axes;            ///< columns: by falling extent
  double flatness = 0;  ///< smallest extent over the largest
};

Centred centred(const Points3& points) {
  Centred out;
  for (const Vec3& p : points) out.mean += p;
  out.mean /= double(points.size());
  Mat3 sum = Mat3::Zero();
  for (const Vec3& p : points) sum += (p - out.mean) * (p - out.mean).transpose();
  const Eigen::SelfAdjointEigenSolver<Mat3> eigen(sum / double(points.size()));
  const Vec3 values = eigen.eigenvalues().cwiseMax(0);
  out.size = std::sqrt(values.sum());
  out.axes << eigen.eigenvectors().col(2), eigen.eigenvectors().col(1), eigen.eigenvectors().col(0);
  if (out.axes.determinant() < 0) out.axes.col(2) *= -1;
  out.flatness = std::sqrt(values[0] / std::max(values[2], 1e-300));
  return out;
}

/// The 3x4 matrix of the direct linear transform.
std::optional<Mat34> linear_projection(const Points3& points, const Points2& images) {
  if (points.size() < 6) return std::nullopt;
  const Centred c = centred(points);
  Vec2 mean = Vec2::Zero();
  for (const Vec2& m : images) mean += m;
  mean /= double(images.size());
  double spread = 0;
  for (const Vec2& m : images) spread += (m - mean).squaredNorm();
  spread = std::sqrt(spread / double(images.size()));
  if (!(spread > 0) || !(c.size > 0)) return std::nullopt;
  Eigen::Matrix<double, 12, 12> normal = Eigen::Matrix<double, 12, 12>::Zero();
  for (std::size_t i = 0; i < points.size(); ++i) {
    Vec4 x;
    x << (points[i] - c.mean) / c.size, 1;
    const Vec2 m = (images[i] - mean) / spread;
    Eigen::Matrix<double, 2, 12> rows = Eigen::Matrix<double, 2, 12>::Zero();
    rows.block<1, 4>(0, 0) = x.transpose();
    rows.block<1, 4>(0, 8) = -m.x() * x.transpose();
    rows.block<1, 4>(1, 4) = x.transpose();
    rows.block<1, 4>(1, 8) = -m.y() * x.transpose();
    normal += rows.transpose() * rows;
  }
  const Eigen::SelfAdjointEigenSolver<MatX> eigen(normal);
  const Eigen::Matrix<double, 12, 1> v = eigen.eigenvectors().col(0);
  Mat34 p;
  p << v.segment<4>(0).transpose(), v.segment<4>(4).transpose(), v.segment<4>(8).transpose();
  Mat3 image;
  image << spread, 0, mean.x(), 0, spread, mean.y(), 0, 0, 1;
  Mat4 space = Mat4::Identity();
  space.topLeftCorner<3, 3>() /= c.size;
  space.topRightCorner<3, 1>() = -c.mean / c.size;
  p = image * p * space;
  double depth = 0;
  for (const Vec3& x : points) depth += p.row(2).head<3>().dot(x) + p(2, 3);
  return Mat34(depth < 0 ? Mat34(-p) : p);
}

Mat3 nearest_rotation(const Mat3& m) {
  const Eigen::JacobiSVD<Mat3> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Mat3 flip =
      Vec3(1, 1, (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1).asDiagonal();
  return svd.matrixU() * flip * svd.matrixV().transpose();
}

/// From the linear projection of normalised images.
Pose pose_of(const Mat34& p) {
  const Eigen::JacobiSVD<Mat3> svd(p.leftCols<3>());
  const double scale = svd.singularValues().mean();
  return Pose(nearest_rotation(p.leftCols<3>() / scale), Vec3(p.col(3) / scale));
}

struct Refined {
  Resection at;
  bool ok = false;
};

class Refiner {
 public:
  Refiner(const Points3& points, const Points2& pixels, const LensGuess* guess)
      : points_(points), pixels_(pixels), guess_(guess) {}

  Refined run(const Pose& start, const Intrinsics& lens, int iterations) const {
    Refined out;
    out.at.device_from_rig = start;
    out.at.lens = lens;
    double damping = 1e-3, cost = cost_of(out.at);
    const int n = guess_ != nullptr ? 9 : 6;
    for (int iteration = 0; iteration < iterations; ++iteration) {
      MatX h = MatX::Zero(n, n);
      VecX g = VecX::Zero(n);
      accumulate(out.at, h, g);
      bool improved = false;
      for (int attempt = 0; attempt < 6 && !improved; ++attempt) {
        MatX damped = h;
        damped.diagonal() *= 1 + damping;
        damped.diagonal().array() += 1e-12;
        const VecX step = -damped.ldlt().solve(g);
        Resection next = out.at;
        next.device_from_rig = (se3_exp<double>(Vec6(step.head<6>())) * next.device_from_rig).normalized();
        if (guess_ != nullptr) {
          const double factor = std::exp(std::clamp(step[6], -0.5, 0.5));
          next.lens.fx *= factor;
          next.lens.fy *= factor;
          next.lens.cx += step[7] * guess_->size.width;
          next.lens.cy += step[8] * guess_->size.width;
        }
        const double trial = step.allFinite() ? cost_of(next) : cost;
        if (trial < cost) {
          improved = true;
          const bool done = trial > cost * (1 - 1e-6);
          cost = trial;
          out.at = next;
          damping = std::max(1e-9, damping * 0.2);
          if (done) iteration = iterations;
        } else {
          damping *= 10;
        }
      }
      if (!improved) break;
    }
    out.at.cost = cost;
    std::vector<double> squares;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const Vec3 y = out.at.device_from_rig * points_[i];
      squares.push_back(
          y.z() > 0 ? (out.at.lens.pixel_from_normalized(y.head<2>() / y.z()) - pixels_[i]).squaredNorm()
                    : 1e12);
    }
    const double limit = 9 * median(squares);
    double sum = 0;
    int count = 0;
    for (const double s : squares)
      if (s <= limit) sum += s, ++count;
    out.at.rms = count > 0 ? std::sqrt(sum / count) : 1e6;
    out.ok = std::isfinite(cost) && median(squares) < 1e11;
    return out;
  }

 private:
  double prior(const Resection& at, VecX* g, MatX* h) const {
    if (guess_ == nullptr) return 0;
    const double weight = kPriorPx * kPriorPx;
    double cost = 0;
    const auto add = [&](int index, double off, double by, double sigma) {
      cost += weight * off * off / (sigma * sigma);
      if (g == nullptr) return;
      (*g)[index] += weight * off * by / (sigma * sigma);
      (*h)(index, index) += weight * by * by / (sigma * sigma);
    };
    add(6, std::log(at.lens.fx / guess_->focal), 1, guess_->focal_sigma);
    add(7, at.lens.cx - guess_->centre.x(), guess_->size.width, guess_->centre_sigma.x());
    add(8, at.lens.cy - guess_->centre.y(), guess_->size.width, guess_->centre_sigma.y());
    return cost;
  }

  /// Half the points' squares and half the guess', per point.
  double cost_of(const Resection& at) const {
    double sum = 0;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const Vec3 y = at.device_from_rig * points_[i];
      if (!(y.z() > 1e-9)) {
        sum += 1e6;
        continue;
      }
      const double r = (at.lens.pixel_from_normalized(y.head<2>() / y.z()) - pixels_[i]).norm();
      sum += r < kHuberPx ? r * r : kHuberPx * (2 * r - kHuberPx);
    }
    return sum / double(points_.size()) + prior(at, nullptr, nullptr);
  }

  void accumulate(const Resection& at, MatX& h, VecX& g) const {
    const double each = 1 / double(points_.size());
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const Vec3 y = at.device_from_rig * points_[i];
      if (!(y.z() > 1e-9)) continue;
      const Vec2 m = y.head<2>() / y.z();
      const Vec2 r = at.lens.pixel_from_normalized(m) - pixels_[i];
      const double weight = each * (r.norm() < kHuberPx ? 1 : kHuberPx / r.norm());
      Mat23 by_y;
      by_y << at.lens.fx / y.z(), at.lens.skew / y.z(), -(at.lens.fx * m.x() + at.lens.skew * m.y()) / y.z(),
          0, at.lens.fy / y.z(), -at.lens.fy * m.y() / y.z();
      Eigen::Matrix<double, 2, 9> j = Eigen::Matrix<double, 2, 9>::Zero();
      j.leftCols<3>() = -by_y * hat(y);
      j.middleCols<3>(3) = by_y;
      if (guess_ != nullptr) {
        j.col(6) << at.lens.fx * m.x(), at.lens.fy * m.y();
        j(0, 7) = j(1, 8) = guess_->size.width;
      }
      const auto used = j.leftCols(h.cols());
      h += weight * used.transpose() * used;
      g += weight * used.transpose() * r;
    }
    prior(at, &g, &h);
  }

  static constexpr double kPriorPx = 0.3;  // what one sigma of the guess costs, as an error of all points
  const Points3& points_;
  const Points2& pixels_;
  const LensGuess* guess_;
};

/// Poses for a lens, from the points' normalised images.
std::vector<Pose> start_poses(const Points3& points, const Points2& images) {
  std::vector<Pose> poses;
  const Centred c = centred(points);
  if (c.flatness > 0.005)
    if (const std::optional<Mat34> p = linear_projection(points, images)) poses.push_back(pose_of(*p));
  if (c.flatness < 0.15) {
    Points2 on_plane;
    for (const Vec3& x : points) on_plane.push_back((c.axes.transpose() * (x - c.mean)).head<2>());
    try {
      const PlanarPose planar = planar_pose(on_plane, images);
      const Pose plane_from_rig = Pose(c.axes, c.mean).inverse();
      for (const PlanarPoseSolution& solution : planar.solutions)
        poses.push_back(solution.camera_from_plane * plane_from_rig);
    } catch (const Error&) {
      // No pose from this lens: the next one of the grid.
    }
  }
  return poses;
}

void keep_best(std::vector<Resection>& found, std::size_t count) {
  std::sort(found.begin(), found.end(),
            [](const Resection& a, const Resection& b) { return a.cost < b.cost; });
  std::vector<Resection> kept;
  for (const Resection& r : found) {
    const bool known = std::any_of(kept.begin(), kept.end(), [&](const Resection& k) {
      return (k.device_from_rig.rotation * r.device_from_rig.rotation.conjugate()).vec().norm() < 0.01 &&
             std::abs(std::log(k.lens.fx / r.lens.fx)) < 0.03;
    });
    if (!known && kept.size() < count) kept.push_back(r);
  }
  found = std::move(kept);
}

}  // namespace

std::vector<Intrinsics> lens_grid(const LensGuess& guess) {
  std::vector<Intrinsics> grid;
  const auto steps = [](double sigma, double step, int max_steps) {
    return std::clamp(int(std::ceil(1.5 * sigma / step)), 0, max_steps);
  };
  const int focal = steps(guess.focal_sigma, 0.2, 5);
  const int x = steps(guess.centre_sigma.x() / guess.size.width, 0.15, 2),
            y = steps(guess.centre_sigma.y() / guess.size.height, 0.15, 4);
  for (int f = -focal; f <= focal; ++f)
    for (int i = -x; i <= x; ++i)
      for (int j = -y; j <= y; ++j) {
        const double value = guess.focal * std::exp(0.2 * f);
        grid.push_back({value, value, guess.centre.x() + 0.15 * i * guess.size.width,
                        guess.centre.y() + 0.15 * j * guess.size.height, 0});
      }
  return grid;
}

std::vector<Resection> resect_with_lens(const Points3& points, const Points2& pixels,
                                        const LensGuess& guess) {
  std::vector<Resection> found;
  if (points.size() < 6) return found;
  // The search with few points, the last steps with all.
  Points3 few_points;
  Points2 few_pixels;
  const std::size_t stride = std::max<std::size_t>(1, points.size() / 60);
  for (std::size_t i = 0; i < points.size(); i += stride) {
    few_points.push_back(points[i]);
    few_pixels.push_back(pixels[i]);
  }
  const Refiner search(few_points, few_pixels, &guess), finish(points, pixels, &guess);
  if (centred(points).flatness > 0.005)
    if (const std::optional<Mat34> p = linear_projection(points, pixels)) {
      // K R by an RQ decomposition: of the rows in reverse.
      Mat3 reverse;
      reverse << 0, 0, 1, 0, 1, 0, 1, 0, 0;
      const Mat3 m = p->leftCols<3>();
      const Eigen::HouseholderQR<Mat3> qr((reverse * m).transpose());
      Mat3 q = qr.householderQ();
      Mat3 r = qr.matrixQR().triangularView<Eigen::Upper>();
      Mat3 k = reverse * r.transpose() * reverse, rotation = reverse * q.transpose();
      const Mat3 sign = k.diagonal().cwiseSign().asDiagonal();
      k = k * sign;
      rotation = sign * rotation;
      if (k(2, 2) > 0 && rotation.determinant() > 0) {
        const Vec3 t = k.inverse() * p->col(3);
        k /= k(2, 2);
        const double f = std::sqrt(std::abs(k(0, 0) * k(1, 1)));
        if (std::isfinite(f) && f > 0)
          if (const Refined refined = finish.run(Pose(rotation, t), {f, f, k(0, 2), k(1, 2), 0}, 60);
              refined.ok)
            found.push_back(refined.at);
      }
    }
  for (const Intrinsics& lens : lens_grid(guess)) {
    Points2 images;
    for (const Vec2& pixel : few_pixels) images.push_back(lens.normalized_from_pixel(pixel));
    for (const Pose& pose : start_poses(few_points, images))
      if (const Refined refined = search.run(pose, lens, 15); refined.ok) found.push_back(refined.at);
  }
  keep_best(found, 6);
  for (Resection& resection : found) resection = finish.run(resection.device_from_rig, resection.lens, 60).at;
  keep_best(found, 3);
  return found;
}

std::vector<Resection> resect_known(const Points3& points, const Points2& rays, double focal) {
  std::vector<Resection> found;
  if (points.size() < 6) return found;
  Points2 pixels;
  for (const Vec2& ray : rays) pixels.push_back(focal * ray);
  const Refiner refiner(points, pixels, nullptr);
  for (const Pose& pose : start_poses(points, rays))
    if (const Refined refined = refiner.run(pose, {focal, focal, 0, 0, 0}, 60); refined.ok)
      found.push_back(refined.at);
  keep_best(found, 2);
  return found;
}

}  // namespace procam::room
