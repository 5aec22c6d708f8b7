#include "observability.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "procam/core/base/words.hpp"
#include "procam/core/geometry/se3.hpp"

namespace procam::scan {
namespace {

/// The left increment of a unit of [L rotation, translation] about a centre.
Mat6 from_centre(const Vec3& centre, double length) {
  Mat6 out = Mat6::Zero();
  out.topLeftCorner<3, 3>() = Mat3::Identity() / length;
  out.bottomLeftCorner<3, 3>() = hat(centre) / length;
  out.bottomRightCorner<3, 3>().setIdentity();
  return out;
}

/// Weights, centre and extent of the common points of each station.
struct StationMoments {
  std::vector<double> weight;
  std::vector<Vec3> centre;
  std::vector<double> length;
};

StationMoments moments(const JointProblem& problem, const std::vector<JointRow>& rows,
                       const std::vector<double>& weights) {
  const std::size_t count = problem.stations->size();
  StationMoments out{std::vector<double>(count, 0.0), std::vector<Vec3>(count, Vec3::Zero()),
                     std::vector<double>(count, 0.0)};
  const auto each = [&](const auto& visit) {
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const ComparedPair& pair = problem.pairs[std::size_t(rows[i].pair)];
      for (const int s : {pair.first, pair.second}) visit(std::size_t(s), rows[i].point, weights[i]);
    }
  };
  each([&](std::size_t s, const Vec3& point, double weight) {
    out.weight[s] += weight;
    out.centre[s] += weight * point;
  });
  for (std::size_t s = 0; s < count; ++s)
    if (out.weight[s] > 0) out.centre[s] /= out.weight[s];
  each([&](std::size_t s, const Vec3& point, double weight) {
    out.length[s] += weight * (point - out.centre[s]).squaredNorm();
  });
  for (std::size_t s = 0; s < count; ++s)
    out.length[s] = out.weight[s] > 0 ? std::max(0.01, std::sqrt(out.length[s] / out.weight[s])) : 1;
  return out;
}

/// Information of the poses by normals whose errors are independent: (J_first^T J_second + J_second^T J_first) / 2.
MatX cross_information(const JointProblem& problem, const std::vector<JointRow>& rows,
                       const std::vector<double>& weights) {
  MatX out = MatX::Zero(problem.pose_unknowns(), problem.pose_unknowns());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const JointRow& row = rows[i];
    const ComparedPair& pair = problem.pairs[std::size_t(row.pair)];
    Vec6 a, b;
    a << row.point.cross(row.first_normal), row.first_normal;
    b << row.point.cross(row.second_normal), row.second_normal;
    const Mat6 block = 0.5 * weights[i] * (a * b.transpose() + b * a.transpose());
    const Eigen::Index first = 6 * pair.first, second = 6 * pair.second;
    out.block<6, 6>(first, first) += block;
    out.block<6, 6>(second, second) += block;
    out.block<6, 6>(first, second) -= block;
    out.block<6, 6>(second, first) -= block;
  }
  return out;
}

/// Smallest eigenvalue of the graph of stations, the first of them fixed: what chains of stations cost by themselves.
double chain_loss(const JointProblem& problem, const std::vector<JointRow>& rows,
                  const std::vector<double>& weights, const StationMoments& of) {
  const Eigen::Index count = Eigen::Index(problem.stations->size());
  MatX graph = MatX::Zero(count, count);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const ComparedPair& pair = problem.pairs[std::size_t(rows[i].pair)];
    graph(pair.first, pair.first) += weights[i];
    graph(pair.second, pair.second) += weights[i];
    graph(pair.first, pair.second) -= weights[i];
    graph(pair.second, pair.first) -= weights[i];
  }
  for (Eigen::Index a = 0; a < count; ++a)
    for (Eigen::Index b = 0; b < count; ++b)
      graph(a, b) /= std::sqrt(std::max(1e-300, of.weight[std::size_t(a)] * of.weight[std::size_t(b)]));
  const MatX free = graph.bottomRightCorner(count - 1, count - 1);
  return Eigen::SelfAdjointEigenSolver<MatX>(free).eigenvalues()[0];
}

void check_together(const JointProblem& problem, const std::vector<JointRow>& rows,
                    const std::vector<double>& weights, const MatX& information, const StationMoments& of,
                    Unobservable& out) {
  const std::size_t count = problem.stations->size();
  const double loss = chain_loss(problem, rows, weights, of);
  if (!(loss > 1e-9)) return;  // not connected, which is another error
  MatX scaled = MatX::Zero(problem.pose_unknowns(), problem.pose_unknowns());
  for (std::size_t a = 0; a < count; ++a)
    for (std::size_t b = 0; b < count; ++b)
      scaled.block<6, 6>(6 * Eigen::Index(a), 6 * Eigen::Index(b)) =
          from_centre(of.centre[a], of.length[a]).transpose() *
          information.block<6, 6>(6 * Eigen::Index(a), 6 * Eigen::Index(b)) *
          from_centre(of.centre[b], of.length[b]) / std::sqrt(of.weight[a] * of.weight[b]);
  const Eigen::Index free = problem.pose_unknowns() - 6;
  const Eigen::SelfAdjointEigenSolver<MatX> eigen(MatX(scaled.bottomRightCorner(free, free)));
  out.smallest_together = std::sqrt(std::max(0.0, eigen.eigenvalues()[0] / loss));
  out.together = VecX::Zero(problem.pose_unknowns());
  out.together.tail(free) = eigen.eigenvectors().col(0);
}

std::string vector_text(const Vec3& v, int decimals) {
  const auto number = [&](double x) {
    return fixed(std::abs(x) < 0.5 * std::pow(10.0, -decimals) ? 0 : x, decimals);
  };
  return "(" + number(v.x()) + " " + number(v.y()) + " " + number(v.z()) + ")";
}

/// With its largest component positive: of an axis, either sign means the same.
Vec3 signed_axis(const Vec3& v) {
  Eigen::Index largest = 0;
  v.cwiseAbs().maxCoeff(&largest);
  return v.normalized() * (v[largest] < 0 ? -1 : 1);
}

}  // namespace

Unobservable unobservable_directions(const JointProblem& problem, const std::vector<JointRow>& rows,
                                     const RowWeights& weights) {
  std::vector<double> of_row;
  of_row.reserve(rows.size());
  for (const JointRow& row : rows) of_row.push_back(weights.of(row));
  const StationMoments of = moments(problem, rows, of_row);
  const MatX information = cross_information(problem, rows, of_row);
  const std::size_t count = problem.stations->size();
  Unobservable out{std::vector<MatX>(count, MatX(6, 0)), of.centre, of.length,
                   std::vector<double>(count, 1.0),      1,         {}};
  bool all_seen = true;
  for (std::size_t s = 0; s < count; ++s) {
    if (!(of.weight[s] > 0)) {
      all_seen = false;
      continue;
    }
    const Mat6 basis = from_centre(of.centre[s], of.length[s]);
    const Mat6 scaled = basis.transpose() *
                        information.block<6, 6>(6 * Eigen::Index(s), 6 * Eigen::Index(s)) * basis /
                        of.weight[s];
    const Eigen::SelfAdjointEigenSolver<MatX> eigen(scaled);
    out.smallest[s] = std::sqrt(std::max(0.0, eigen.eigenvalues()[0]));
    const double limit = problem.min_normal_motion * problem.min_normal_motion;
    Eigen::Index weak = 0;
    while (weak < 6 && eigen.eigenvalues()[weak] < limit) ++weak;
    out.directions[s] = eigen.eigenvectors().leftCols(weak);
  }
  if (all_seen && count > 2 && !problem.has_known_poses)
    check_together(problem, rows, of_row, information, of, out);
  return out;
}

MatX observable_projection(const JointProblem& problem, const Unobservable& open) {
  MatX keep = MatX::Identity(problem.pose_unknowns(), problem.pose_unknowns());
  for (std::size_t s = 0; s < open.directions.size(); ++s) {
    const MatX& weak = open.directions[s];
    if (weak.cols() == 0) continue;
    const Mat6 basis = from_centre(open.centres[s], open.lengths[s]);
    // A gradient g becomes B^-T (I - U U^T) B^T g.
    const Mat6 projection = Mat6::Identity() - weak * weak.transpose();
    keep.block<6, 6>(6 * Eigen::Index(s), 6 * Eigen::Index(s)) =
        basis.transpose().inverse() * projection * basis.transpose();
  }
  return keep;
}

std::vector<std::string> direction_names(const MatX& directions, const Vec3& centre, double length) {
  std::vector<std::string> names;
  if (directions.cols() == 0) return names;
  // Pure translations first, the rest are rotations about an axis.
  const MatX projector = directions * directions.transpose();
  const Eigen::SelfAdjointEigenSolver<Mat3> shifts(Mat3(projector.bottomRightCorner<3, 3>()));
  constexpr double kPure = 0.95;
  MatX rest = directions;
  for (int k = 2; k >= 0 && shifts.eigenvalues()[k] > kPure; --k) {
    Vec6 shift = Vec6::Zero();
    shift.tail<3>() = shifts.eigenvectors().col(k);
    names.push_back("position along " + vector_text(signed_axis(shift.tail<3>()), 2));
    rest -= shift * (shift.transpose() * rest);
  }
  const Eigen::Index turns = directions.cols() - Eigen::Index(names.size());
  const Eigen::JacobiSVD<MatX> svd(rest, Eigen::ComputeThinU);
  for (Eigen::Index k = 0; k < turns; ++k) {
    const Vec6 along = svd.matrixU().col(k);
    const Vec3 turn = along.head<3>() / length, shift = along.tail<3>();
    if (turn.norm() * length < 0.2) {
      names.push_back("position along " + vector_text(signed_axis(shift), 2));
      continue;
    }
    const Vec3 through = centre + turn.cross(shift) / turn.squaredNorm();
    names.push_back("rotation about the axis " + vector_text(signed_axis(turn), 2) + " through " +
                    vector_text(through, 2) + " m");
  }
  return names;
}

}  // namespace procam::scan
