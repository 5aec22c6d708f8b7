#include "alignment.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "procam/core/base/parallel.hpp"
#include "procam/core/geometry/se3.hpp"

namespace procam::scan {
namespace {

const double kMaxNormalAngle = std::cos(30 * kDegree);
constexpr int kSearchSamples = 300, kRefineSamples = 700;
constexpr std::size_t kMaxCandidates = 40;
constexpr double kSearchTolerance = 0.07, kSeenThrough = 0.12, kFineTolerance = 0.01;
constexpr double kOtherPosition = 0.03, kOtherAngle = 1.5 * kDegree;

bool agree(const StationView::Sample& sample, const StationView& second, const Pose& second_from_first,
           double gate, CommonPoint& common) {
  const Vec3 point = second_from_first * sample.at.point, normal = second_from_first.rotate(sample.at.normal);
  double best = gate;
  bool found = false;
  for (int i = 0; i < int(second.views.size()); ++i) {
    const SurfaceView& view = second.views[std::size_t(i)];
    const std::optional<Eigen::Vector2i> pixel = view.pixel_of(point);
    if (!pixel || !view.has_plane(pixel->x(), pixel->y())) continue;
    const SurfacePoint seen = view.at(pixel->x(), pixel->y());
    const Vec3 between = seen.normal + normal, offset = point - seen.point;
    if (seen.normal.dot(normal) < kMaxNormalAngle) continue;
    const double distance = std::abs(between.dot(offset)) / between.norm();
    if (distance > best || offset.norm() > 2 * gate + 0.01) continue;
    best = distance;
    common = {sample.at, seen, sample.view, i};
    found = true;
  }
  return found;
}

/// Does the second station measure something well behind the point?
bool sees_through(const Vec3& point, const StationView& second) {
  for (const SurfaceView& view : second.views) {
    const std::optional<Eigen::Vector2i> pixel = view.pixel_of(point);
    if (!pixel) continue;
    const double depth = double(view.scan().depth.at(pixel->x(), pixel->y()));
    if (depth > 0 && view.depth_of(point) < depth - kSeenThrough) return true;
  }
  return false;
}

double score(const std::vector<StationView::Sample>& samples, const StationView& second,
             const Pose& second_from_first, double tolerance) {
  int sum = 0;
  CommonPoint common;
  for (const StationView::Sample& sample : samples) {
    if (agree(sample, second, second_from_first, tolerance, common))
      ++sum;
    else if (sees_through(second_from_first * sample.at.point, second))
      --sum;
  }
  return double(sum) / double(std::max<std::size_t>(samples.size(), 1));
}

/// One step of point-to-plane ICP; directions that the surfaces leave open stay. The length of the step.
double icp_step(const std::vector<CommonPoint>& common, double gate, Pose& second_from_first) {
  Mat6 information = Mat6::Zero();
  Vec6 gradient = Vec6::Zero();
  for (const CommonPoint& c : common) {
    const Vec3 point = second_from_first * c.first.point;
    const Vec3 normal = (second_from_first.rotate(c.first.normal) + c.second.normal).normalized();
    const double r = normal.dot(point - c.second.point), u = 2 * r / gate;
    Vec6 j;
    j << point.cross(normal), normal;
    const double weight = 1 / ((1 + u * u) * (1 + u * u));
    information += weight * j * j.transpose();
    gradient += weight * r * j;
  }
  const Eigen::SelfAdjointEigenSolver<MatX> eigen(information);
  Vec6 step = Vec6::Zero();
  for (int k = 0; k < 6; ++k)
    if (eigen.eigenvalues()[k] > 1e-3 * eigen.eigenvalues()[5])
      step -=
          eigen.eigenvectors().col(k) * eigen.eigenvectors().col(k).dot(gradient) / eigen.eigenvalues()[k];
  second_from_first = (se3_exp(step) * second_from_first).normalized();
  return step.norm();
}

Alignment refined_alignment(const std::vector<StationView::Sample>& samples, const StationView& second,
                            Alignment at) {
  for (const double gate : {0.25, 0.15, 0.08, 0.04, 0.02, 0.01})
    for (int i = 0; i < 8; ++i) {
      const std::vector<CommonPoint> common = common_points(samples, second, at.second_from_first, gate);
      if (common.size() < 20) break;
      if (icp_step(common, gate, at.second_from_first) < 1e-4) break;
    }
  at.score = score(samples, second, at.second_from_first, kFineTolerance);
  return at;
}

bool differ(const Pose& a, const Pose& b, const Vec3& middle, double position, double angle) {
  return (a * middle - b * middle).norm() > position ||
         so3_log(Eigen::Quaterniond(a.rotation * b.rotation.conjugate())).norm() > angle;
}

std::vector<double> steps(double limit, double step) {
  std::vector<double> values;
  const int count = int(std::ceil(limit / step - 1e-9));
  for (int i = -count; i <= count; ++i) values.push_back(count == 0 ? 0 : limit * i / count);
  return values;
}

/// Rotations about the first camera, whose axes are those of `rig_from_camera`.
std::vector<Pose> search_grid(const Pose& rig_from_camera, const RegistrationOptions& options) {
  std::vector<Pose> grid;
  for (const double yaw : steps(options.max_turn, 12 * kDegree))
    for (const double pitch : steps(options.max_turn / 5, 12 * kDegree))
      for (const double roll : steps(options.max_turn / 5, 12 * kDegree))
        for (const double x : steps(options.max_move, 0.25))
          for (const double y : steps(options.max_move / 4, 0.25))
            for (const double z : steps(options.max_move, 0.25)) {
              const Pose moved(Eigen::Quaterniond(so3_exp(Vec3(0, yaw, 0)) * so3_exp(Vec3(pitch, 0, 0)) *
                                                  so3_exp(Vec3(0, 0, roll))),
                               Vec3(x, y, z));
              grid.push_back(rig_from_camera * moved * rig_from_camera.inverse());
            }
  return grid;
}

Vec3 middle_of(const std::vector<StationView::Sample>& samples) {
  Vec3 middle = Vec3::Zero();
  for (const StationView::Sample& sample : samples) middle += sample.at.point / double(samples.size());
  return middle;
}

bool scores_higher(const Alignment& a, const Alignment& b) {
  return a.score > b.score;
}

/// The alignments that differ from all better ones.
std::vector<Alignment> distinct(std::vector<Alignment> all, const Vec3& middle, double position, double angle,
                                std::size_t count) {
  std::stable_sort(all.begin(), all.end(), scores_higher);
  std::vector<Alignment> out;
  for (const Alignment& one : all) {
    if (out.size() == count) break;
    if (std::all_of(out.begin(), out.end(), [&](const Alignment& better) {
          return differ(one.second_from_first, better.second_from_first, middle, position, angle);
        }))
      out.push_back(one);
  }
  return out;
}

}  // namespace

std::vector<CommonPoint> common_points(const std::vector<StationView::Sample>& samples,
                                       const StationView& second, const Pose& second_from_first,
                                       double gate) {
  std::vector<CommonPoint> out;
  CommonPoint common;
  for (const StationView::Sample& sample : samples)
    if (agree(sample, second, second_from_first, gate, common)) out.push_back(common);
  return out;
}

std::vector<Alignment> find_alignments(const StationView& first, const StationView& second,
                                       const RegistrationOptions& options) {
  const std::vector<StationView::Sample> few = first.samples(kSearchSamples),
                                         more = first.samples(kRefineSamples);
  if (few.empty()) return {};
  const std::vector<Pose> grid = search_grid(first.views.front().scan().camera.rig_from_camera, options);
  std::vector<Alignment> rough(grid.size());
  parallel_for(int(grid.size()), options.threads, [&](int begin, int end) {
    for (int i = begin; i < end; ++i)
      rough[std::size_t(i)] = {grid[std::size_t(i)],
                               score(few, second, grid[std::size_t(i)], kSearchTolerance)};
  });
  const Vec3 middle = middle_of(few);
  std::vector<Alignment> fine = distinct(rough, middle, 0.2, 8 * kDegree, kMaxCandidates);
  parallel_each(int(fine.size()), options.threads,
                [&](int i) { fine[std::size_t(i)] = refined_alignment(more, second, fine[std::size_t(i)]); });
  return distinct(fine, middle, kOtherPosition, kOtherAngle, fine.size());
}

double alignment_near(const StationView& first, const StationView& second, const Pose& second_from_first,
                      double max_distance, double max_angle) {
  const std::vector<StationView::Sample> samples = first.samples(kRefineSamples);
  if (samples.empty()) return -1;
  const Alignment found = refined_alignment(samples, second, {second_from_first, 0});
  const bool is_far =
      differ(found.second_from_first, second_from_first, middle_of(samples), max_distance, max_angle);
  return is_far ? -1 : found.score;
}

}  // namespace procam::scan
