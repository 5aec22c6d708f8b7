#include "procam/scan/stations.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "joint_solve.hpp"
#include "pose_check.hpp"
#include "procam/core/base/detail/chi_square.hpp"
#include "procam/core/base/words.hpp"
#include "procam/core/geometry/se3.hpp"

namespace procam::scan {
namespace {

constexpr int kMinPoints = 150;         // of a pair
constexpr double kFoundGate = 0.02;     // metres: what a search leaves
constexpr double kAlike = 0.9;          // of the best score: another alignment fits as well
constexpr double kDisagreeRate = 1e-3;  // false alarms of "poses_disagree", by station
constexpr double kManySigmas = 10;      // from a known pose: the check fails
constexpr double kCheckGate = 0.03;     // metres: kept poses are compared within

std::string station_name(const std::vector<Station>& stations, std::size_t s) {
  return "station '" + stations[s].name + "'";
}

void check(const std::vector<Station>& stations, const RegistrationOptions& options) {
  require(stations.size() >= 2, "register_stations: fewer than two stations");
  require(options.max_turn >= 0 && options.max_turn <= kPi && options.max_move >= 0 &&
              options.max_move <= 20 && options.min_overlap > 0 && options.min_normal_motion > 0 &&
              options.max_points >= 500 && options.max_position_sigma > 0 && options.max_angle_sigma > 0,
          "register_stations: options out of range");
  for (const Station& station : stations) {
    require(!station.scans.empty(), "register_stations: a station without scans");
    require(station.world_from_rig.has_value() == stations.front().world_from_rig.has_value(),
            "register_stations: known poses of some stations only");
    if (!station.world_from_rig) continue;
    require(station.world_from_rig->pose.is_finite() && station.world_from_rig->covariance.allFinite() &&
                Eigen::LLT<Mat6>(station.world_from_rig->covariance).info() == Eigen::Success,
            "register_stations: the covariance of a known pose is not positive definite");
  }
  require(options.refine || stations.front().world_from_rig, "register_stations: no poses to keep");
}

[[noreturn]] void refuse_overlap(const std::vector<Station>& stations, std::size_t s, double share) {
  throw Error(ErrorKind::kNotEnoughData, station_name(stations, s),
              "the other stations see only " + percent(std::max(0.0, share), 0) + " of its surfaces",
              "move the rig less between stations, or give the poses of the stations");
}

/// Another alignment that differs and fits as well; of a plane or a ball there are many, which is named otherwise.
void refuse_second(const std::vector<Station>& stations, std::size_t s, const std::vector<Alignment>& all) {
  if (all.size() < 2 || all[1].score < kAlike * all[0].score) return;
  const Pose change = all[1].second_from_first * all[0].second_from_first.inverse();
  throw Error(ErrorKind::kDegenerate, station_name(stations, s),
              "it fits the other stations in two ways, which differ by " + mm(change.translation.norm(), 0) +
                  " and " + fixed(so3_log(change.rotation).norm() / kDegree, 1) + " degrees",
              "let the stations see more of the room in common, or give their poses");
}

/// Poses in the first station's frame by search: each station is aligned with those that are placed, the best first.
std::vector<Pose> search(const std::vector<Station>& stations, const std::vector<StationView>& views,
                         const RegistrationOptions& options, std::vector<std::vector<Alignment>>& found) {
  const std::size_t count = stations.size();
  std::vector<Pose> poses(count);
  std::vector<bool> placed(count, false);
  placed[0] = true;
  struct Best {
    double score = -2;
    Pose pose;
    std::vector<Alignment> all;
  };
  std::vector<Best> best(count);
  std::size_t newest = 0;
  for (std::size_t n = 1; n < count; ++n) {
    for (std::size_t s = 0; s < count; ++s) {
      if (placed[s]) continue;
      std::vector<Alignment> all = find_alignments(views[s], views[newest], options);
      if (all.empty() || all.front().score <= best[s].score) continue;
      best[s] = {all.front().score, poses[newest] * all.front().second_from_first, std::move(all)};
    }
    newest = count;
    for (std::size_t s = 0; s < count; ++s)
      if (!placed[s] && (newest == count || best[s].score > best[newest].score)) newest = s;
    if (best[newest].score < options.min_overlap) refuse_overlap(stations, newest, best[newest].score);
    placed[newest] = true;
    poses[newest] = best[newest].pose;
    found[newest] = std::move(best[newest].all);
  }
  return poses;
}

/// How far apart the surfaces may be by the known poses.
double gate_of(const std::vector<Station>& stations) {
  double variance = 0;
  for (const Station& station : stations) {
    const Mat6& c = station.world_from_rig->covariance;
    Vec3 middle = Vec3::Zero();
    // At two metres before the rig.
    middle = station.world_from_rig->pose * Vec3(0, 0, 2);
    variance = std::max(variance, point_covariance(PoseWithCovariance{Pose(), c}, middle).trace());
  }
  return std::clamp(4 * std::sqrt(variance), 0.01, 0.3);
}

/// All pairs of stations that see enough of each other.
std::vector<ComparedPair> overlapping(const std::vector<StationView>& views, const std::vector<Pose>& poses,
                                      double gate, const RegistrationOptions& options,
                                      std::vector<StationPair>& described) {
  std::vector<std::vector<StationView::Sample>> samples;
  for (const StationView& view : views) samples.push_back(view.samples(options.max_points));
  std::vector<ComparedPair> pairs;
  for (std::size_t a = 0; a < views.size(); ++a)
    for (std::size_t b = a + 1; b < views.size(); ++b) {
      const Pose b_from_a = poses[b].inverse() * poses[a];
      const std::size_t of_a = common_points(samples[a], views[b], b_from_a, gate).size(),
                        of_b = common_points(samples[b], views[a], b_from_a.inverse(), gate).size();
      const double share = std::max(double(of_a) / double(std::max<std::size_t>(samples[a].size(), 1)),
                                    double(of_b) / double(std::max<std::size_t>(samples[b].size(), 1)));
      if (share < options.min_overlap || int(std::min(of_a, of_b)) < kMinPoints) continue;
      pairs.push_back({int(a), int(b), samples[a]});
      described.push_back({int(a), int(b), 0, share, 0});
    }
  return pairs;
}

/// By station: is it joined to the first one by pairs?
std::vector<bool> connected(std::size_t count, const std::vector<ComparedPair>& pairs) {
  std::vector<bool> reached(count, false);
  reached[0] = true;
  for (std::size_t round = 0; round < count; ++round)
    for (const ComparedPair& pair : pairs)
      if (reached[std::size_t(pair.first)] || reached[std::size_t(pair.second)])
        reached[std::size_t(pair.first)] = reached[std::size_t(pair.second)] = true;
  return reached;
}

void refuse_open(const std::vector<Station>& stations, const Unobservable& open, double min_motion) {
  const auto refuse = [&](std::size_t s, const MatX& directions) {
    throw Error(ErrorKind::kDegenerate, station_name(stations, s),
                "the common surfaces do not fix its " +
                    comma_list(direction_names(directions, open.centres[s], open.lengths[s])) +
                    ": they move along themselves",
                "let the stations see surfaces of other directions in common, or give their poses");
  };
  for (std::size_t s = 1; s < stations.size(); ++s)
    if (open.directions[s].cols() > 0) refuse(s, open.directions[s]);
  if (open.smallest_together >= 0.5 * min_motion) return;
  std::size_t most = 1;
  for (std::size_t s = 1; s < stations.size(); ++s)
    if (open.together.segment<6>(6 * Eigen::Index(s)).norm() >
        open.together.segment<6>(6 * Eigen::Index(most)).norm())
      most = s;
  refuse(most, MatX(open.together.segment<6>(6 * Eigen::Index(most)).normalized()));
}

void refuse_uncertain(const std::vector<Station>& stations, const JointSolution& solution,
                      const MatX& covariance, const RegistrationOptions& options) {
  for (std::size_t s = 1; s < stations.size(); ++s) {
    const PoseWithCovariance pose{solution.state.world_from_rig[s],
                                  covariance.block<6, 6>(6 * Eigen::Index(s), 6 * Eigen::Index(s))};
    // At the middle of the common points.
    const Vec3 middle = pose.pose.inverse() * solution.equations.open.centres[s];
    const auto largest = [](const Mat3& m) {
      return std::sqrt(std::max(0.0, Eigen::SelfAdjointEigenSolver<Mat3>(m).eigenvalues()[2]));
    };
    const double position = largest(point_covariance(pose, middle)),
                 angle = largest(pose.covariance.topLeftCorner<3, 3>());
    if (position <= options.max_position_sigma && angle <= options.max_angle_sigma) continue;
    throw Error(ErrorKind::kDegenerate, station_name(stations, s),
                "the common surfaces fix its pose only to " + mm(position, 1) + " and " +
                    fixed(angle / kDegree, 2) + " degrees (one standard deviation)",
                "let the stations see more in common, or give their poses");
  }
}

void describe_pairs(const JointProblem& problem, const std::vector<JointRow>& rows, const RowWeights& weights,
                    std::vector<StationPair>& pairs) {
  std::vector<double> squares(pairs.size(), 0.0), sums(pairs.size(), 0.0);
  for (const JointRow& row : rows) {
    const std::size_t p = std::size_t(row.pair);
    const double weight = weights.of(row);
    ++pairs[p].points;
    squares[p] += weight * row.residual * row.residual;
    sums[p] += weight;
  }
  for (std::size_t p = 0; p < pairs.size(); ++p)
    pairs[p].rms = sums[p] > 0 ? std::sqrt(squares[p] / sums[p]) : 0;
  static_cast<void>(problem);
}

void fill(const std::vector<Station>& stations, const JointSolution& solution, Registration& out) {
  for (std::size_t s = 0; s < stations.size(); ++s) {
    RegisteredStation station;
    station.name = stations[s].name;
    station.pose = {solution.state.world_from_rig[s],
                    out.covariance.block<6, 6>(6 * Eigen::Index(s), 6 * Eigen::Index(s))};
    if (out.has_known_poses && !solution.equations.open.directions.empty())
      station.unobservable =
          direction_names(solution.equations.open.directions[s], solution.equations.open.centres[s],
                          solution.equations.open.lengths[s]);
    if (!station.unobservable.empty())
      out.diagnostics.note("unobservable",
                           station_name(stations, s) + ": the common surfaces do not fix its " +
                               comma_list(station.unobservable) + "; the known pose does alone");
    out.stations.push_back(std::move(station));
  }
  out.rig_error = solution.state.c;
  out.noise_factor = solution.weights.scale;
}

/// Known poses against those that the surfaces ask for.
void compare_with_known(const std::vector<Station>& stations, Registration& out) {
  for (std::size_t s = 0; s < stations.size(); ++s) {
    const PoseWithCovariance& known = *stations[s].world_from_rig;
    const Vec6 off = se3_log(out.stations[s].pose.pose * known.pose.inverse());
    const double chi2 = off.dot(known.covariance.inverse() * off);
    if (chi2 <= procam::internal::chi_square_limit(kDisagreeRate, 6)) continue;
    const bool fails = std::sqrt(chi2 / 6) > kManySigmas;
    out.diagnostics.items.push_back(
        {fails ? Severity::kFailure : Severity::kWarning, "poses_disagree",
         format(
             "%s: the surfaces ask for a pose that is %.1f mm and %.2f degrees from the known one, %.1f times its "
             "standard deviation; check the pose, or state a larger covariance",
             station_name(stations, s).c_str(),
             1e3 * (out.stations[s].pose.pose.translation - known.pose.translation).norm(),
             so3_log(Eigen::Quaterniond(out.stations[s].pose.pose.rotation * known.pose.rotation.conjugate()))
                     .norm() /
                 kDegree,
             std::sqrt(chi2 / 6))});
  }
}

/// Poses as they are known. The common surfaces are compared alone.
Registration keep_poses(const JointProblem& problem, const JointState& state,
                        std::vector<StationPair> pairs) {
  Registration out;
  out.has_known_poses = true;
  const std::vector<Station>& stations = *problem.stations;
  out.covariance = MatX::Identity(problem.unknowns(), problem.unknowns());
  for (std::size_t s = 0; s < stations.size(); ++s)
    out.covariance.block<6, 6>(6 * Eigen::Index(s), 6 * Eigen::Index(s)) =
        stations[s].world_from_rig->covariance;
  JointSolution kept;
  kept.state = state;
  kept.rows = joint_rows(problem, state, kCheckGate, problem.modes > 0);
  describe_pairs(problem, kept.rows, kept.weights, pairs);
  fill(stations, kept, out);
  double squares = 0, expected = 0;
  for (const JointRow& row : kept.rows) {
    const ComparedPair& pair = problem.pairs[std::size_t(row.pair)];
    VecX j = VecX::Zero(problem.unknowns());
    Vec6 by_first;
    by_first << row.point.cross(row.normal), row.normal;
    j.segment<6>(6 * pair.first) = by_first;
    j.segment<6>(6 * pair.second) = -by_first;
    if (row.by_c.size() > 0) j.tail(problem.modes) = row.by_c;
    squares += row.residual * row.residual;
    expected += row.sigma * row.sigma + j.dot(out.covariance * j);
  }
  if (squares > 9 * expected)
    out.diagnostics.items.push_back(
        {squares > kManySigmas * kManySigmas * expected ? Severity::kFailure : Severity::kWarning,
         "poses_disagree",
         format(
             "the surfaces of the stations are %.1f mm apart (RMS), and the stated standard deviations allow "
             "%.1f mm: let the stations be registered, or check their poses",
             1e3 * std::sqrt(squares / double(kept.rows.size())),
             1e3 * std::sqrt(expected / double(kept.rows.size())))});
  out.pairs = std::move(pairs);
  return out;
}

}  // namespace

Registration register_stations(const std::vector<Station>& stations, const RegistrationOptions& options) {
  check(stations, options);
  const std::vector<StationView> views = station_views(stations, options.threads);
  JointProblem problem;
  problem.stations = &stations;
  problem.views = &views;
  problem.has_known_poses = stations.front().world_from_rig.has_value();
  problem.min_normal_motion = options.min_normal_motion;
  problem.modes = stations.front().scans.front().rig_modes.root.cols();
  for (const Station& station : stations)
    for (const Scan& scan : station.scans)
      require(scan.rig_modes.root.cols() == problem.modes, "register_stations: scans by different rigs");
  if (problem.has_known_poses) require_near_stations(stations);
  JointState state{{}, VecX::Zero(problem.modes)};
  std::vector<std::vector<Alignment>> found(stations.size());
  if (problem.has_known_poses)
    for (const Station& station : stations) state.world_from_rig.push_back(station.world_from_rig->pose);
  else
    state.world_from_rig = search(stations, views, options, found);
  const double gate = !options.refine ? kCheckGate : problem.has_known_poses ? gate_of(stations) : kFoundGate;
  std::vector<StationPair> pairs;
  problem.pairs = overlapping(views, state.world_from_rig, gate, options, pairs);

  const std::vector<bool> reached = connected(stations.size(), problem.pairs);
  const auto alone = std::find(reached.begin(), reached.end(), false);
  if (alone != reached.end() && !problem.has_known_poses)
    refuse_overlap(stations, std::size_t(alone - reached.begin()), 0);
  if (problem.has_known_poses) refuse_mistaken_poses(stations, views);
  if (!options.refine) return keep_poses(problem, state, std::move(pairs));
  const JointSolution solution = solve_jointly(problem, state, gate);
  Registration out;
  out.has_known_poses = problem.has_known_poses;
  out.covariance = joint_covariance(problem, solution.equations);
  if (!problem.has_known_poses) {
    refuse_open(stations, solution.equations.open, options.min_normal_motion);
    refuse_uncertain(stations, solution, out.covariance, options);
    for (std::size_t s = 1; s < stations.size(); ++s) refuse_second(stations, s, found[s]);
  }
  describe_pairs(problem, solution.rows, solution.weights, pairs);
  out.pairs = std::move(pairs);
  fill(stations, solution, out);
  if (problem.has_known_poses) compare_with_known(stations, out);
  for (std::size_t s = 0; s < reached.size(); ++s)
    if (!reached[s])
      out.diagnostics.warn("no_overlap",
                           station_name(stations, s) +
                               " sees too little of what the others see: its known pose places it alone");
  return out;
}

}  // namespace procam::scan
