#include "procam/calibrate/mount.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "mount_analysis.hpp"
#include "mount_start.hpp"
#include "procam/core/base/words.hpp"

namespace procam::calibrate {

BaseMotion parse_base_motion(const std::string& text) {
  if (text == "auto") return BaseMotion::kAuto;
  if (text == "planar") return BaseMotion::kPlanar;
  if (text == "full") return BaseMotion::kFull;
  throw Error(ErrorKind::kInput, "'" + text + "'", "it is no kind of motion", "give auto, planar or full");
}

namespace mount {
namespace {

constexpr const char* kDirectionNames[] = {"roll", "pitch", "yaw", "x", "y", "height"};
constexpr int kMaxEvents = 6;
constexpr double kRejectChi2 = 33;  // 6 degrees of freedom: 1 of 100 000 good ones

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i)
    text += (i == 0 ? "" : i + 1 == names.size() ? " and " : ", ") + names[i];
  return text;
}

void update_noise(Model& model, const Equations& equations) {
  if (!model.options->estimate_noise) return;
  const std::array<double, kGroups> factors = variance_factors(equations);
  const double root = std::sqrt(model.noise.correlation);
  const auto scale = [](double& sigma, double factor, double low, double high) {
    sigma = std::clamp(sigma * std::clamp(factor, 0.2, 5.0), low, high);
  };
  Noise& noise = model.noise;
  scale(noise.turn, root * factors[kBaseTurn], 1e-5, 0.5);
  scale(noise.position, root * factors[kBasePosition], 1e-5, 1);
  if (model.planar) {
    // A localiser in the plane reports both as constants.
    scale(noise.tilt, root * factors[kBaseTilt], 1e-3, 0.5);
    scale(noise.height, root * factors[kBaseHeight], 1e-3, 1);
  }
  if (model.coarse) return;
  scale(noise.sighting, factors[kSighting], 0.05, 100);
  scale(noise.motion, factors[kMotion], 1, 100);
  if (model.planar) {
    scale(noise.floor, factors[kFloorHeight], 1e-5, 0.05);
    scale(noise.floor_tilt, factors[kFloorTilt], 1e-5, 0.1);
  }
  noise.correlation = correlation_of(equations.linear, model.planar);
}

void insert(Model& model, const FoundEvent& event) {
  const bool bump = event.kind == MountEvent::Kind::kRigBumped;
  std::vector<Epoch>& epochs = bump ? model.mounts : model.frames;
  const std::size_t before = model.epoch(epochs, event.time);
  Epoch after = epochs[before];
  after.from = event.time;
  const PoseManifold manifold({0, 1, 2, 3, 4, 5},
                              bump ? PoseManifold::Side::kMount : PoseManifold::Side::kRight);
  const PoseBlock from = after.pose;
  manifold.Plus(from.data(), event.increment.data(), after.pose.data());
  epochs.insert(epochs.begin() + std::ptrdiff_t(before) + 1, after);
}

/// The most significant change, inserted into the model if it stands up to the noise that is left with it: noise that
/// is larger or slower than assumed looks like changes.
std::optional<FoundEvent> confirmed_event(Model& model, const MountProblem& problem,
                                          const Equations& equations) {
  const auto event = find_event(model, problem, equations);
  if (!event) return std::nullopt;
  Model with_event = model;
  insert(with_event, *event);
  MountProblem again(with_event, true);
  again.solve();
  const Equations after(again.linearise());
  const std::array<double, kGroups> factors = variance_factors(after);
  const double variance = std::pow(std::max({1.0, factors[kBaseTurn], factors[kBasePosition]}), 2) *
                          std::max(1.0, correlation_of(after.linear, model.planar) / model.noise.correlation);
  if (event->chi2 < variance * model.options->event_chi2) return std::nullopt;
  insert(model, *event);
  return event;
}

/// Rejects by chi-square; returns how many changed.
int reject(Model& model, const Linear& linear) {
  int changed = 0;
  const auto judge = [&](std::vector<char>& use, const std::vector<int>& rows) {
    for (std::size_t i = 0; i < use.size(); ++i) {
      if (use[i] == 0 || rows[i] < 0) continue;
      if (linear.residuals.segment<6>(rows[i]).squaredNorm() < kRejectChi2) continue;
      use[i] = 0;
      ++changed;
    }
  };
  judge(model.use_base, linear.base_row);
  judge(model.use_sighting, linear.sighting_row);
  return changed;
}

/// Throws for a direction that neither the drive nor a statement supplies.
void require_observable(const MountInformation& information, const MountOptions& options, bool planar) {
  const std::array<bool, 6> missing = unobservable_directions(information.posterior, options.max_sigma);
  std::vector<std::string> names;
  for (std::size_t i = 0; i < 6; ++i)
    if (missing[i]) names.push_back(kDirectionNames[i]);
  if (names.empty()) return;
  const bool height_alone = names.size() == 1 && missing[5];
  const bool yaw_alone = missing[2] && !missing[0] && !missing[1] && !missing[3] && !missing[4];
  if (height_alone && options.height)
    throw Error(ErrorKind::kDegenerate, "mount",
                "the standard deviation of the given height, " + mm(options.height->sigma, 0) +
                    ", is too large: this drive cannot observe the height, and the limit is " +
                    mm(options.max_sigma, 0),
                "measure the height of the rig's origin (the first camera's centre) above the base's origin "
                "more precisely, e.g. --height 0.85m+-5mm");
  throw Error(
      ErrorKind::kDegenerate, "mount",
      "this drive cannot observe " + listed(names) + " of the rig on the base" +
          (planar ? ": the base moves in a plane" : ""),
      height_alone
          ? "measure the height of the rig's origin (the first camera's centre) above the base's origin "
            "and give it, e.g. --height 0.85m+-5mm, or give the poses of markers on the wall (--markers)"
      : yaw_alone
          ? "drive straight for a metre or more, not only turns on the spot" +
                std::string(missing[5] ? ", and measure the height: --height 0.85m+-5mm" : "")
          : "drive curves in both directions and at changing speed past markers near and far (on one circle at one "
            "speed a time offset looks like a moved rig), or give an earlier pose of the rig "
            "with its covariance as --prior" +
                std::string(missing[5] ? ", and measure the height: --height 0.85m+-5mm" : ""));
}

void remark_on_rejected(const MountResult& result, Diagnostics& diagnostics) {
  const auto share = [&](const char* code, const char* what, std::size_t rejected, std::size_t used,
                         const char* next) {
    if (rejected == 0) return;
    const std::string text = std::to_string(rejected) + " of " + std::to_string(rejected + used) + " " +
                             what + " contradict the others and are rejected";
    constexpr double kMany = 0.05;
    if (double(rejected) > kMany * double(rejected + used))
      diagnostics.warn(code, text + "; " + next);
    else
      diagnostics.note(code, text);
  };
  share("sightings_rejected", "sightings", result.rejected_sightings.size(), result.sightings_used,
        "a marker moved, two have one id, or flat views were taken for their mirror image");
  share("base_poses_rejected", "base poses", result.rejected_base_poses.size(), result.base_poses_used,
        "the localiser loses itself; check its map");
}

void remark_on_event(const MountEvent& event, Diagnostics& diagnostics) {
  const Vec6 change = se3_log(event.change);
  const std::string size = mm(event.change.translation.norm(), 1) + " and " +
                           fixed(change.head<3>().norm() / kDegree, 2) + " degrees";
  if (event.kind == MountEvent::Kind::kRigBumped)
    diagnostics.warn("rig_bumped", "the rig moved on its base at " + fixed(event.time, 2) + " s by " + size +
                                       "; the mount is that of the time after. Fix the rig and drive again");
  else
    diagnostics.warn("localiser_jumped", "the localiser's poses moved at " + fixed(event.time, 2) + " s by " +
                                             size +
                                             ": a jump on the map, or wheel slip; the solve allows for it");
  constexpr double kClear = 0.7;
  if (event.other_chi2 > kClear * event.chi2)
    diagnostics.warn("event_unclear",
                     "at " + fixed(event.time, 2) +
                         " s a moved rig and a jump of the localiser explain the drive nearly "
                         "equally well (chi-square " +
                         fixed(event.chi2, 0) + " and " + fixed(event.other_chi2, 0) +
                         "); repeat the drive with more turns after this time");
}

void remark_on_noise(const MountResult& result, const MountOptions& options, Diagnostics& diagnostics) {
  if (result.correlation > 1)
    diagnostics.note("correlated_localiser",
                     "the localiser's errors are correlated in time; its variance counts " +
                         fixed(result.correlation, 1) + " times");
  constexpr double kNoisier = 2;
  if (result.sighting_factor > kNoisier)
    diagnostics.warn("sightings_noisier",
                     "the sightings scatter " + fixed(result.sighting_factor, 1) +
                         " times as much as their covariances state; the sigmas allow for it. "
                         "Check the camera's calibration and that the markers are flat");
  constexpr double kWeakOffset = 0.02;
  if (options.estimate_time_offset && result.time_offset_sigma > kWeakOffset)
    diagnostics.warn("time_offset_weak", "the time offset is known to " +
                                             fixed(1000 * result.time_offset_sigma, 0) +
                                             " ms only; change speed and direction more often");
}

/// What was stated against the drive alone, where the drive determines it.
void remark_on_statements(const MountResult& result, const MountOptions& options,
                          const MountInformation& information, Diagnostics& diagnostics) {
  constexpr double kDisagrees = 4.5;
  if (options.height && information.data(5, 5) > 0) {
    const double off =
        (result.base_from_rig.pose.translation.z() - options.height->value) / options.height->sigma;
    if (std::abs(off) > kDisagrees)
      diagnostics.warn("statement_disagrees", "the drive puts the rig at a height of " +
                                                  mm(result.base_from_rig.pose.translation.z(), 1) +
                                                  ", the statement at " + mm(options.height->value, 1) +
                                                  ": " + fixed(std::abs(off), 1) + " sigmas apart");
  }
  if (options.prior) {
    const Vec6 error = se3_log(result.base_from_rig.pose * options.prior->pose.inverse());
    const double chi2 = error.dot(options.prior->covariance.llt().solve(error));
    if (chi2 > kRejectChi2)
      diagnostics.warn("statement_disagrees",
                       "the earlier pose of the rig contradicts the drive (chi-square " + fixed(chi2, 0) +
                           " of 6); the rig has moved since, or its covariance is too small");
  }
}

void remark(MountResult& result, const MountOptions& options, const MountInformation& information) {
  Diagnostics& diagnostics = result.diagnostics;
  if (const auto names = result.unobservable(); !names.empty())
    diagnostics.note("stated_not_observed", "the drive cannot observe " + listed(names) + " of the mount; " +
                                                (names.size() == 1 ? "it is" : "they are") +
                                                " as stated, with the stated sigma");
  remark_on_rejected(result, diagnostics);
  for (const MountEvent& event : result.events) remark_on_event(event, diagnostics);
  remark_on_noise(result, options, diagnostics);
  remark_on_statements(result, options, information, diagnostics);
}

MountResult result_of(const Model& model, const Equations& equations) {
  const MountOptions& options = *model.options;
  const MountInformation information = mount_information(equations, options.estimate_time_offset);
  require_observable(information, options, model.planar);
  MountResult result;
  const Pose mount = pose_of(model.mounts.back().pose.data());
  const Mat6 left = left_by_directions(mount);
  result.base_from_rig = {mount, left * information.covariance * left.transpose()};
  const std::array<bool, 6> unobservable = unobservable_directions(information.data, options.max_sigma);
  const Eigen::SelfAdjointEigenSolver<Mat6> eigen(information.data);
  for (int i = 0; i < 6; ++i) {
    double variance = 0;
    for (int k = 0; k < 6; ++k) {
      const double along = std::pow(eigen.eigenvectors()(i, k), 2), known = eigen.eigenvalues()[k];
      constexpr double kNothing = 1e-9;
      if (along > kNothing || known > 0) variance += along / std::max(known, 1e-300);
    }
    constexpr double kInfinite = 1e4;  // m^2, rad^2
    result.directions.push_back(
        {kDirectionNames[i], std::sqrt(information.covariance(i, i)),
         variance < kInfinite ? std::sqrt(variance) : std::numeric_limits<double>::infinity(),
         !unobservable[std::size_t(i)]});
  }
  result.time_offset = model.offset;
  result.time_offset_sigma = information.offset_sigma;
  const Pose world_from_plane = pose_of(model.frames[0].pose.data());
  for (std::size_t m = 0; m < model.markers.size(); ++m) {
    const Pose pose = world_from_plane * pose_of(model.markers[m].data());
    const Mat6 to_left = adjoint(pose);
    result.markers.push_back(
        {model.marker_names[m], {pose, to_left * information.marker_covariance[m] * to_left.transpose()}});
  }
  result.planar = model.planar;
  for (std::size_t k = 0; k < model.knots.size(); ++k)
    result.path.push_back({model.start + double(k) * model.spacing + model.offset,
                           world_from_plane * pose_of(model.knots[k].data())});
  result.position_sigma = model.noise.position;
  result.rotation_sigma = model.noise.turn;
  result.correlation = model.noise.correlation;
  result.sighting_factor = model.noise.sighting;
  result.floor_sigma = model.noise.floor;
  result.floor_tilt_sigma = model.noise.floor_tilt;
  for (std::size_t i = 0; i < model.use_base.size(); ++i)
    if (model.use_base[i] == 0) result.rejected_base_poses.push_back(i);
  result.base_poses_used = model.use_base.size() - result.rejected_base_poses.size();
  for (std::size_t i = 0; i < model.use_sighting.size(); ++i) {
    if (model.use_sighting[i] == 0)
      result.rejected_sightings.push_back(i);
    else
      ++(equations.linear.sighting_row[i] >= 0 ? result.sightings_used : result.sightings_outside);
  }
  return result;
}

}  // namespace
}  // namespace mount

MountResult calibrate_mount(const MountData& data, const MountOptions& options) {
  using namespace mount;
  Model model = start_model(data, options);
  std::vector<FoundEvent> found;
  // Coarse and robust, until large events and outliers are known; then fine and robust, for noise and small events.
  constexpr int kCoarseRounds = 2, kRounds = 5;
  for (int round = 0; round < kRounds;) {
    model.coarse = round < kCoarseRounds;
    MountProblem problem(model, true);
    problem.solve();
    const Equations equations(problem.linearise());
    const bool looks_for_events = round == 0 || round == kCoarseRounds + 1;
    if (looks_for_events && options.find_events && int(found.size()) < kMaxEvents) {
      if (const auto event = confirmed_event(model, problem, equations)) {
        found.push_back(*event);
        continue;
      }
    }
    update_noise(model, equations);
    if (round == kCoarseRounds - 1) reject(model, MountProblem(model, false).linearise());
    ++round;
  }
  // Then without the outliers.
  std::optional<Equations> last;
  constexpr int kFinalRounds = 3;
  for (int round = 0; round < kFinalRounds; ++round) {
    MountProblem problem(model, false);
    if (round > 0) problem.solve();
    Linear linear = problem.linearise();
    const int changed = reject(model, linear);
    if (changed == 0 && round > 0) {
      last.emplace(std::move(linear));
      if (round + 1 < kFinalRounds) update_noise(model, *last);
    }
  }
  MountProblem problem(model, false);
  problem.solve();
  const Equations equations(problem.linearise());
  MountResult result = result_of(model, equations);

  std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.time < b.time; });
  std::size_t bumps = 0, jumps = 0;
  for (const FoundEvent& event : found) {
    const bool bump = event.kind == MountEvent::Kind::kRigBumped;
    const std::vector<Epoch>& epochs = bump ? model.mounts : model.frames;
    const std::size_t i = ++(bump ? bumps : jumps);
    const Pose before = pose_of(epochs[i - 1].pose.data()), after = pose_of(epochs[i].pose.data());
    result.events.push_back({event.kind, event.time + (bump ? model.offset : 0), after * before.inverse(),
                             event.chi2, event.other_chi2});
  }
  remark(result, options, mount_information(equations, options.estimate_time_offset));
  return result;
}

}  // namespace procam::calibrate
