#include "procam/report/stations.hpp"

#include <Eigen/Cholesky>
#include <cmath>

#include "fields.hpp"
#include "procam/core/base/stats.hpp"

namespace procam::report {
namespace {

std::string pair_name(const StationsReport& report, const scan::StationPair& pair) {
  return report.registration.stations[std::size_t(pair.first)].name + " - " +
         report.registration.stations[std::size_t(pair.second)].name;
}

Vec3 position_sigma(const PoseWithCovariance& pose) {
  return point_covariance(pose, Vec3::Zero()).diagonal().cwiseMax(0).cwiseSqrt();
}

Vec3 angle_sigma(const PoseWithCovariance& pose) {
  return pose.covariance.diagonal().head<3>().cwiseMax(0).cwiseSqrt();
}

}  // namespace

static void fields(Fields& f, const scan::RegisteredStation& station) {
  f.field("name", station.name);
  f.field("translation", station.pose.pose.translation);
  f.field("rotation_xyzw", Eigen::Vector4d(station.pose.pose.rotation.coeffs()));
  f.field("translation_sigma", position_sigma(station.pose));
  f.field("rotation_sigma_deg", Vec3(angle_sigma(station.pose) / kDegree));
  std::vector<double> covariance;
  for (Eigen::Index row = 0; row < 6; ++row)
    for (Eigen::Index column = 0; column < 6; ++column)
      covariance.push_back(station.pose.covariance(row, column));
  f.field("covariance", covariance);
  f.field("unobservable", station.unobservable);
}

static void fields(Fields& f, const StationError& error) {
  f.field("position", error.position);
  f.field("angle_deg", error.angle / kDegree);
  f.field("in_sigmas", error.in_sigmas);
  f.field("largest_in_sigmas", error.largest_in_sigmas);
  f.field("single_rms", error.single_rms);
}

StationError pose_error(const PoseWithCovariance& world_from_rig, const Pose& true_world_from_rig) {
  StationError out;
  out.position = (world_from_rig.pose.translation - true_world_from_rig.translation).norm();
  const Vec6 off = se3_log(world_from_rig.pose * true_world_from_rig.inverse());
  out.angle = off.head<3>().norm();
  const Eigen::LLT<Mat6> root(world_from_rig.covariance);
  if (root.info() != Eigen::Success) return out;
  out.in_sigmas = std::sqrt(off.dot(root.solve(off)) / 6);
  out.largest_in_sigmas =
      off.cwiseAbs().cwiseQuotient(world_from_rig.covariance.diagonal().cwiseSqrt()).maxCoeff();
  return out;
}

std::string to_json(const StationsReport& report) {
  Json object;
  Fields f(object);
  f.field("stations", report.registration.stations);
  f.field("frame", std::string(report.registration.has_known_poses ? "world" : "rig of the first station"));
  Json pairs = Json::array();
  for (const scan::StationPair& pair : report.registration.pairs) {
    Json one = Json::object();
    Fields of_pair(one);
    of_pair.field("stations", pair_name(report, pair));
    of_pair.field("points", pair.points);
    of_pair.field("overlap", pair.overlap);
    of_pair.field("rms", pair.rms);
    pairs.push_back(std::move(one));
  }
  object["pairs"] = std::move(pairs);
  f.field("noise_factor", report.registration.noise_factor);
  f.object("merged", [&](Fields& merged) {
    merged.field("points", int(report.merged.cloud.points.size()));
    merged.field("median_sigma", median_or(report.merged.cloud.sigma, 0.0));
    merged.field("vertices", int(report.merged.mesh.vertices.size()));
    merged.field("triangles", int(report.merged.mesh.triangles.size()));
    merged.field("fused_share", report.merged.fused_share);
    merged.field("gap_before", report.merged.gap_before);
    merged.field("gap_expected", report.merged.gap_expected);
    merged.field("contradictions", report.merged.contradictions);
    if (!report.true_error) return;
    merged.object("true_error", [&](Fields& error) {
      error.field("compared", report.true_error->compared);
      error.field("rms", report.true_error->rms);
      error.field("median", report.true_error->median);
      error.field("expected_rms", report.true_error->expected_rms);
      error.field("inside_3_sigma", report.true_error->inside_3_sigma);
      error.field("outliers", report.true_error->outliers);
    });
  });
  if (!report.true_pose_errors.empty()) f.field("true_pose_errors", report.true_pose_errors);
  return text(object);
}

std::vector<std::string> lines(const StationsReport& report) {
  std::vector<std::string> out;
  for (const scan::RegisteredStation& station : report.registration.stations) {
    const Vec3 shift = 1e3 * station.pose.pose.translation,
               turn = so3_log(station.pose.pose.rotation) / kDegree;
    const Vec3 shift_sigma = 1e3 * position_sigma(station.pose),
               turn_sigma = angle_sigma(station.pose) / kDegree;
    out.push_back(format(
        "station %-8s at (%.2f, %.2f, %.2f) +- (%.2g, %.2g, %.2g) mm, rotation (%.3f, %.3f, %.3f) +- (%.2g, %.2g, %.2g) deg",
        station.name.c_str(), shift.x(), shift.y(), shift.z(), shift_sigma.x(), shift_sigma.y(),
        shift_sigma.z(), turn.x(), turn.y(), turn.z(), turn_sigma.x(), turn_sigma.y(), turn_sigma.z()));
  }
  for (const scan::StationPair& pair : report.registration.pairs)
    out.push_back(
        format("stations %-7s overlap %.0f %%, %d points in the solve, %.2g mm RMS along the normals",
               pair_name(report, pair).c_str(), 100 * pair.overlap, pair.points, 1e3 * pair.rms));
  out.push_back(format(
      "merged     %zu points, standard deviation %.2g mm (median, along the normal); %.0f %% are seen by two stations "
      "or more, which were %.2g mm apart (RMS, %.2g mm by their noise); mesh of %zu triangles",
      report.merged.cloud.points.size(), 1e3 * median_or(report.merged.cloud.sigma, 0.0),
      100 * report.merged.fused_share, 1e3 * report.merged.gap_before, 1e3 * report.merged.gap_expected,
      report.merged.mesh.triangles.size()));
  for (std::size_t s = 0; s < report.true_pose_errors.size(); ++s) {
    const StationError& error = report.true_pose_errors[s];
    out.push_back(format(
        "           true error of station %s: %.3g mm, %.3g deg; %.2g sigma (RMS of six), %.2g (largest); its points alone "
        "%.2g mm RMS",
        report.registration.stations[s].name.c_str(), 1e3 * error.position, error.angle / kDegree,
        error.in_sigmas, error.largest_in_sigmas, 1e3 * error.single_rms));
  }
  if (report.true_error)
    out.push_back(format(
        "           true error of the merged points %.2g mm RMS along the normal (%.2g mm expected), %.2g mm median, %.1f %% "
        "inside three sigma, %.2f %% outliers",
        1e3 * report.true_error->rms, 1e3 * report.true_error->expected_rms, 1e3 * report.true_error->median,
        100 * report.true_error->inside_3_sigma, 100 * report.true_error->outliers));
  return out;
}

}  // namespace procam::report
