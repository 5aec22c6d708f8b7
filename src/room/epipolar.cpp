#include "epipolar.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "procam/core/base/stats.hpp"
#include "procam/core/geometry/se3.hpp"

namespace procam::room {
namespace {

/// To the mean of zero and a mean distance of sqrt(2).
Mat3 normaliser(const std::vector<ImagePair>& pairs, const std::vector<int>& chosen, Vec2 ImagePair::*side) {
  Vec2 mean = Vec2::Zero();
  for (const int i : chosen) mean += pairs[std::size_t(i)].*side;
  mean /= double(chosen.size());
  double distance = 0;
  for (const int i : chosen) distance += (pairs[std::size_t(i)].*side - mean).norm();
  const double scale = std::sqrt(2.0) * double(chosen.size()) / std::max(distance, 1e-300);
  Mat3 out;
  out << scale, 0, -scale * mean.x(), 0, scale, -scale * mean.y(), 0, 0, 1;
  return out;
}

std::optional<Mat3> eight_points(const std::vector<ImagePair>& pairs, const std::vector<int>& chosen,
                                 const std::vector<double>& weights) {
  if (chosen.size() < 8) return std::nullopt;
  const Mat3 first = normaliser(pairs, chosen, &ImagePair::first),
             second = normaliser(pairs, chosen, &ImagePair::second);
  Eigen::Matrix<double, 9, 9> normal = Eigen::Matrix<double, 9, 9>::Zero();
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    const ImagePair& pair = pairs[std::size_t(chosen[k])];
    const Vec3 x = first * Vec3(pair.first.x(), pair.first.y(), 1),
               y = second * Vec3(pair.second.x(), pair.second.y(), 1);
    Eigen::Matrix<double, 9, 1> row;
    row << y.x() * x, y.y() * x, y.z() * x;
    normal += (weights.empty() ? 1.0 : weights[k]) * row * row.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<MatX> eigen(normal);
  const Eigen::Matrix<double, 9, 1> f = eigen.eigenvectors().col(0);
  Mat3 fundamental;
  fundamental << f[0], f[1], f[2], f[3], f[4], f[5], f[6], f[7], f[8];
  const Eigen::JacobiSVD<Mat3> svd(fundamental, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Vec3 values = svd.singularValues();
  values[2] = 0;
  fundamental = second.transpose() * svd.matrixU() * values.asDiagonal() * svd.matrixV().transpose() * first;
  const double norm = fundamental.norm();
  if (!(norm > 0) || !fundamental.allFinite()) return std::nullopt;
  return Mat3(fundamental / norm);
}

double score(const Mat3& f, const std::vector<ImagePair>& pairs, double threshold) {
  double sum = 0;
  for (const ImagePair& pair : pairs) {
    const double d = sampson(f, pair) / threshold;
    sum += std::min(1.0, d * d);
  }
  return sum;
}

/// Least squares of Sampson's distance on the inliers, by reweighting the algebraic equations.
std::optional<Mat3> refit(Mat3 f, const std::vector<ImagePair>& pairs, double threshold) {
  for (int round = 0; round < 5; ++round) {
    std::vector<int> chosen;
    std::vector<double> weights;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      if (!(std::abs(sampson(f, pairs[i])) < threshold)) continue;
      const Vec3 x(pairs[i].first.x(), pairs[i].first.y(), 1), y(pairs[i].second.x(), pairs[i].second.y(), 1);
      const double gradient = (f * x).head<2>().squaredNorm() + (f.transpose() * y).head<2>().squaredNorm();
      chosen.push_back(int(i));
      weights.push_back(1 / std::max(gradient, 1e-300));
    }
    const std::optional<Mat3> next = eight_points(pairs, chosen, weights);
    if (!next) return std::nullopt;
    f = *next;
  }
  return f;
}

}  // namespace

double sampson(const Mat3& f, const ImagePair& pair) {
  const Vec3 x(pair.first.x(), pair.first.y(), 1), y(pair.second.x(), pair.second.y(), 1);
  const Vec3 fx = f * x, fy = f.transpose() * y;
  const double gradient = fx.head<2>().squaredNorm() + fy.head<2>().squaredNorm();
  return gradient > 0 ? y.dot(fx) / std::sqrt(gradient) : 0;
}

std::optional<EpipolarGeometry> find_epipolar(const std::vector<ImagePair>& pairs, double threshold,
                                              std::uint64_t seed) {
  if (pairs.size() < 16) return std::nullopt;
  std::mt19937_64 random(seed);
  std::optional<Mat3> best;
  double best_score = std::numeric_limits<double>::infinity();
  constexpr int kSamples = 600;  // 0.99 for 45 % outliers
  std::vector<int> sample(8);
  double needed = kSamples;
  for (int trial = 0; trial < kSamples && trial < needed; ++trial) {
    for (std::size_t n = 0; n < sample.size();) {
      sample[n] = int((random() >> 32) * std::uint64_t(pairs.size()) >> 32);
      if (std::find(sample.begin(), sample.begin() + std::ptrdiff_t(n), sample[n]) ==
          sample.begin() + std::ptrdiff_t(n))
        ++n;
    }
    const std::optional<Mat3> candidate = eight_points(pairs, sample, {});
    if (!candidate) continue;
    double s = score(*candidate, pairs, threshold);
    if (!(s < best_score)) continue;
    best = candidate;
    if (const std::optional<Mat3> improved = refit(*candidate, pairs, threshold))
      if (const double after = score(*improved, pairs, threshold); after < s) best = improved, s = after;
    best_score = s;
    const double inliers = 1 - s / double(pairs.size());
    needed = std::log(1e-3) / std::log1p(-std::min(0.999999, std::pow(std::max(inliers, 0.1), 8)));
  }
  if (!best) return std::nullopt;
  EpipolarGeometry out;
  out.fundamental = *best;
  out.inliers.resize(pairs.size());
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const double d = sampson(*best, pairs[i]);
    out.inliers[i] = std::abs(d) < threshold;
    if (!out.inliers[i]) continue;
    sum += d * d;
    ++count;
  }
  if (2 * count < pairs.size()) return std::nullopt;
  out.rms = std::sqrt(sum / double(count));
  return out;
}

std::vector<Pose> poses_of_essential(const Mat3& essential) {
  const Eigen::JacobiSVD<Mat3> svd(essential, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Mat3 u = svd.matrixU(), v = svd.matrixV();
  if (u.determinant() < 0) u = -u;
  if (v.determinant() < 0) v = -v;
  Mat3 w;
  w << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  const Vec3 t = u.col(2);
  std::vector<Pose> poses;
  for (const Mat3& turn : {w, Mat3(w.transpose())})
    for (const double sign : {1.0, -1.0}) poses.emplace_back(Mat3(u * turn * v.transpose()), Vec3(sign * t));
  return poses;
}

std::vector<Pose> poses_of_homography(const Mat3& homography) {
  Eigen::JacobiSVD<Mat3> svd(homography, Eigen::ComputeFullV);
  Mat3 h = homography / svd.singularValues()[1];
  const Vec3 s2 = (svd.singularValues() / svd.singularValues()[1]).cwiseAbs2();
  const Mat3 v = svd.matrixV();
  std::vector<Pose> poses;
  if (s2[0] - s2[2] < 1e-10) return poses;  // a rotation alone
  const Vec3 v1 = v.col(0), v2 = v.col(1), v3 = v.col(2);
  const double a = std::sqrt(std::max(0.0, 1 - s2[2])), b = std::sqrt(std::max(0.0, s2[0] - 1)),
               c = std::sqrt(s2[0] - s2[2]);
  for (const double side : {1.0, -1.0}) {
    const Vec3 u = (a * v1 + side * b * v3) / c;
    Mat3 big_u, big_w;
    big_u << v2, u, v2.cross(u);
    for (const double sign : {1.0, -1.0}) {
      const Mat3 signed_h = sign * h;
      big_w << signed_h * v2, signed_h * u, (signed_h * v2).cross(signed_h * u);
      const Mat3 r = big_w * big_u.transpose();
      const Vec3 n = v2.cross(u);
      const Vec3 t = (signed_h - r) * n;
      if (!(std::abs(r.determinant() - 1) < 1e-2) || !(t.norm() > 1e-9)) continue;
      poses.emplace_back(r, Vec3(t.normalized()));
      poses.emplace_back(r, Vec3(-t.normalized()));
    }
  }
  return poses;
}

double rotation_error(const std::vector<ImagePair>& rays) {
  if (rays.empty()) return 0;
  Mat3 sum = Mat3::Zero();
  const auto unit = [](const Vec2& ray) { return Vec3(Vec3(ray.x(), ray.y(), 1).normalized()); };
  for (const ImagePair& pair : rays) sum += unit(pair.second) * unit(pair.first).transpose();
  const Eigen::JacobiSVD<Mat3> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  const Mat3 rotation = svd.matrixU() * Vec3(1, 1, sign).asDiagonal() * svd.matrixV().transpose();
  std::vector<double> off;
  for (const ImagePair& pair : rays) off.push_back((rotation * unit(pair.first) - unit(pair.second)).norm());
  return quantile(off, 0.9);
}

double share_in_front(const Pose& second_from_first, const std::vector<ImagePair>& rays) {
  std::size_t count = 0;
  for (const ImagePair& pair : rays) {
    const Vec3 d = second_from_first.rotation * Vec3(pair.first.x(), pair.first.y(), 1),
               e(pair.second.x(), pair.second.y(), 1);
    // z d + t = s e
    const Vec3 a = e.cross(d), b = e.cross(second_from_first.translation);
    const double z = -a.dot(b) / std::max(a.squaredNorm(), 1e-300);
    count += z > 0 && (z * d + second_from_first.translation).dot(e) > 0;
  }
  return rays.empty() ? 0 : double(count) / double(rays.size());
}

}  // namespace procam::room
