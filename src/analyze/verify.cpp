#include "procam/analyze/verify.hpp"

#include <algorithm>
#include <cmath>

#include "most_probable.hpp"
#include "procam/analyze/error_sources.hpp"
#include "procam/core/base/closed_form.hpp"
#include "procam/core/base/detail/chi_square.hpp"
#include "procam/core/base/words.hpp"

namespace procam::analyze {
namespace {

constexpr std::size_t kMinMarks = 8;
constexpr double kBeyondBumpRate = 1e-6;  ///< of a bump of the stated sigmas
constexpr double kWarnOdds = 20, kRejectOdds = 1000;
constexpr double kMaxScatter = 3;  ///< times the detected noise
constexpr double kAbsurdScatter = 50;
constexpr double kThinnest = 0.03;  ///< of the marks on the surface, across over along
constexpr int kDirections = 8;      ///< what rigid movements can do to a picture of a plane

/// How far things move when they are bumped, as covariance of left increments in the rig's frame.
Mat6 bump_of(const Pose& rig_from_thing, const VerifyOptions& options) {
  const Mat6 ad = adjoint(rig_from_thing);
  return ad * isotropic_pose_covariance(options.bump_position_sigma, options.bump_rotation_sigma) *
         ad.transpose();
}

[[noreturn]] void refuse_contradiction(const std::string& why) {
  throw Error(ErrorKind::kDegenerate, "the marks of light", why,
              "check that they all fall on the one flat surface, and that the captures are of this pattern");
}

/// The marks that agree on some rigid movement, and why the others are rejected.
Which agreeing(const Fit& robust, const Which& marks, double rate, std::vector<VerifiedMark>& all) {
  const double limit = -2 * std::log(rate / double(marks.size()));
  const double usual = scatter2_of(robust.squares);
  Which used;
  for (std::size_t i = 0; i < marks.size(); ++i) {
    const double square = robust.squares[Eigen::Index(i)];
    if (square <= limit * usual)
      used.push_back(marks[i]);
    else
      all[marks[i]].rejection =
          fixed(std::sqrt(square / usual), 0) +
          " sigmas from where the others put it: hidden, mirrored, or on something else";
  }
  if (used.size() < kMinMarks || 3 * used.size() < 2 * marks.size())
    refuse_contradiction("only " + std::to_string(used.size()) + " of " + std::to_string(marks.size()) +
                         " agree on any movement of projector or surface");
  return used;
}

/// Times the detected noise, one at least: what the movements that explain most leave.
double remaining_scatter(const Fit& any, std::size_t marks) {
  const double spare = 2 * double(marks) - kDirections;
  const double scatter = std::sqrt(std::max(1.0, any.squares.sum() / spare));
  if (scatter > kAbsurdScatter)
    refuse_contradiction(fixed(scatter, 0) +
                         " times the detected noise remain after any movement of projector or surface");
  return scatter;
}

/// Squared length of the errors' projection onto what rigid movements can do, and their number.
struct CommonMovement {
  double chi2 = 0;
  int degrees_of_freedom = 0;
};

CommonMovement common_movement(const MarkChain& chain, const Which& marks, double scatter,
                               const Pose& rig_from_surface) {
  LinearMarks linear = *chain.linearise(marks, {});
  whiten(linear, scatter, VecX::Ones(Eigen::Index(marks.size())));
  const Marginal stated(linear.by_state, root_of(chain.stated()));
  MatX directions(linear.error.size(), kDirections);
  directions.leftCols<6>() = linear.by_state.middleCols<6>(chain.projector_place());
  const Mat6 from_own = adjoint(rig_from_surface);
  const auto by_surface = linear.by_state.middleCols<6>(chain.surface_place());
  directions.col(6) = by_surface * from_own.col(0);  // tilts about its x and y
  directions.col(7) = by_surface * from_own.col(1);
  CommonMovement result;
  std::vector<VecX> basis;  // Gram-Schmidt in the metric of `stated`, each direction twice for its digits
  for (Eigen::Index k = 0; k < directions.cols(); ++k) {
    VecX direction = directions.col(k);
    const double before = stated.product(direction, direction);
    for (int again = 0; again < 2; ++again)
      for (const VecX& b : basis) direction -= stated.product(b, direction) * b;
    const double square = stated.product(direction, direction);
    if (!(square > 1e-12 * before)) continue;
    basis.push_back(direction / std::sqrt(square));
    const double along = stated.product(basis.back(), linear.error);
    result.chi2 += along * along;
    ++result.degrees_of_freedom;
  }
  return result;
}

double root_mean_square(const MarkChain& chain, const Which& marks, const Moved& moved,
                        double* worst = nullptr) {
  double sum = 0;
  for (const std::size_t i : marks) {
    const auto error = chain.error(i, moved);
    if (!error) return INFINITY;
    sum += error->squaredNorm();
    if (worst) *worst = std::max(*worst, error->norm());
  }
  return std::sqrt(sum / double(marks.size()));
}

Movement movement(const std::string& what, const Pose& rig_from_thing, const Vec6& increment,
                  const Mat6& covariance, double rms_after, double log_evidence) {
  const Mat6 to_own = adjoint(rig_from_thing.inverse());
  return {what, to_own * increment, to_own * covariance * to_own.transpose(), rms_after, log_evidence};
}

double sigma_along(const Vec3& direction, const Mat3& covariance) {
  const double length = direction.norm();
  if (!(length > 0)) return std::sqrt(covariance.trace() / 3);
  return std::sqrt(std::max(0.0, direction.dot(covariance * direction))) / length;
}

std::string words_of(const Movement& m) {
  return m.what + " rotated by " + fixed(m.angle() / kDegree, 3) + " deg and translated by " +
         fixed(1e3 * m.shift(), 1) + " mm";
}

/// Is one bump of the stated size enough?
bool beyond_bump(const Movement& m, const VerifyOptions& options) {
  const double chi2 = std::pow(m.angle() / options.bump_rotation_sigma, 2) +
                      std::pow(m.shift() / options.bump_position_sigma, 2);
  return chi2 > internal::chi_square_limit(kBeyondBumpRate, 6);
}

/// Throws where the surface elsewhere explains the marks as well as the projector's movement, and only the size of a bump speaks
/// against it: a wall may have been mapped 0.2 m off. `misfits`: chi-square, of the projector and of the surface.
void refuse_wrong_map(const Movement& projector, const std::optional<Movement>& surface, const Vec2& misfits,
                      const VerifyOptions& options) {
  constexpr double kAsWell = 12;
  if (!surface || !beyond_bump(*surface, options) || misfits[1] > misfits[0] + kAsWell) return;
  throw Error(
      ErrorKind::kDegenerate, "the correction",
      "that " + words_of(*surface) + " explains the marks as well as a movement of " + projector.what +
          "; only the size of a bump speaks against it, and a wrong map is no bump",
      "measure " + surface->what +
          " again, state how uncertain its pose is (--map-sigma 20mm,1deg), or put a mapped marker on it "
          "(--markers)");
}

/// Throws when the correction asked for is not what the marks say; remarks on what they leave open.
void judge_correction(bool settled, const Movement& asked, const std::optional<Movement>& other,
                      const VerifyOptions& options, Diagnostics& diagnostics) {
  if (other) {
    const double odds = std::exp(std::min(other->log_evidence - asked.log_evidence, 600.0));
    if (odds > kRejectOdds)
      throw Error(
          ErrorKind::kDegenerate, "the correction",
          "the marks say that " + words_of(*other) + ", odds above " + fixed(kRejectOdds, 0) +
              " to 1 against a movement of " + asked.what,
          "correct that instead, measure the surface again, or give the true uncertainty of its pose");
    if (odds > 1 / kWarnOdds && settled)
      diagnostics.warn("cannot_tell_apart", "a movement of " + other->what +
                                                " explains the marks as well as one of " + asked.what +
                                                " (odds " + significant(odds, 2) +
                                                " to 1): put a mapped marker on the surface " +
                                                "(--markers), or look again at a surface in another plane");
  }
  if (beyond_bump(asked, options))
    throw Error(
        ErrorKind::kInput, "the correction",
        "it would take that " + words_of(asked) + ", far more than a bump of " +
            fixed(options.bump_rotation_sigma / kDegree, 2) + " deg and " +
            fixed(1e3 * options.bump_position_sigma, 0) + " mm",
        "check that pattern, projector size, rig and surface are those of the captures and that nothing "
        "scales the picture; if it really moved that far, state a larger --sigma-bump");
  if (!settled)
    throw Error(ErrorKind::kNotConverged, "the correction",
                "the estimate of how " + asked.what + " moved does not settle",
                "check that surface, rig and pattern belong together");
  static const char* const kAxes[6] = {"turn about its x",  "turn about its y",  "turn about its z",
                                       "shift along its x", "shift along its y", "shift along its z"};
  std::string unseen;
  for (int i = 0; i < 6; ++i) {
    const double bump = i < 3 ? options.bump_rotation_sigma : options.bump_position_sigma;
    if (asked.covariance(i, i) > 0.25 * bump * bump)
      unseen += (unseen.empty() ? "" : ", ") + std::string(kAxes[i]);
  }
  if (!unseen.empty())
    diagnostics.warn("not_seen", "of the movement of " + asked.what + " the marks do not tell: " + unseen +
                                     "; there the correction rests on --sigma-bump");
}

void check(const StatedSurface& surface, const std::vector<LightPoint>& marks, const VerifyOptions& options) {
  const auto positive = [](double value) { return value > 0 && std::isfinite(value); };
  require(positive(options.bump_rotation_sigma) && positive(options.bump_position_sigma),
          "verify: the bump's sigmas must be positive");
  require(options.false_alarm_rate > 0 && options.false_alarm_rate < 1,
          "verify: the false-alarm rate must lie between 0 and 1");
  require(surface.rig_from_surface.pose.is_finite(), "verify: the surface's pose is not finite");
  for (const Pose& tangent : surface.tangents)
    require(tangent.is_finite(), "verify: a tangent plane is not finite");
  for (const LightPoint& mark : marks)
    require(mark.camera_pixel.allFinite() && mark.projector_pixel.allFinite() &&
                mark.camera_covariance.allFinite() && mark.camera_covariance(0, 0) > 0 &&
                mark.camera_covariance.determinant() > 0,
            "verify: a mark's pixel is not finite or its covariance not positive definite");
  require(!(surface.jacobian_camera.size() > 0 && options.correct == Correct::kSurface),
          "verify: a surface that the camera measured in this very view needs no correction");
}

/// The marks whose rays meet the surface.
Which meeting(const MarkChain& chain, const std::string& surface, std::vector<VerifiedMark>& all) {
  Which marks;
  for (std::size_t i = 0; i < chain.marks(); ++i) {
    all[i].rejection = chain.flaw(i);
    if (all[i].rejection.empty()) marks.push_back(i);
  }
  if (chain.marks() < kMinMarks)
    throw Error(ErrorKind::kNotEnoughData, "the marks of light",
                std::to_string(chain.marks()) + " are seen, " + std::to_string(kMinMarks) + " are needed",
                "let more of the pattern fall where the camera sees it, in focus and not too dark");
  if (marks.size() < kMinMarks)
    throw Error(ErrorKind::kInput, "surface '" + surface + "'",
                all.front().rejection + " (so for " + std::to_string(chain.marks() - marks.size()) + " of " +
                    std::to_string(chain.marks()) + " marks)",
                "check its frame, its pose and --pose: z points into the wall, away from the projector");
  return marks;
}

/// Of marks near one line no turn about it can be told.
void require_an_area(const MarkChain& chain, const Which& marks) {
  Vec2 sum = Vec2::Zero();
  Mat2 squares = Mat2::Zero();
  for (const std::size_t i : marks) {
    const Vec2 at = *chain.intended(i);
    sum += at;
    squares += at * at.transpose();
  }
  const double n = double(marks.size());
  const SymmetricEigen2 spread = symmetric_eigen(squares / n - sum * sum.transpose() / (n * n));
  if (!(spread.values[1] > kThinnest * kThinnest * spread.values[0]))
    throw Error(ErrorKind::kDegenerate, "the marks of light", "they lie on one line of the surface",
                "let the pattern cover an area of it");
}

/// Is the common movement more than chance makes of marks that did not move?
void test_for_movement(const CommonMovement& common, const VerifyOptions& options, VerifyResult& result) {
  result.chi2 = common.chi2;
  result.degrees_of_freedom = common.degrees_of_freedom;
  result.false_alarm_rate = options.false_alarm_rate;
  result.limit = internal::chi_square_limit(options.false_alarm_rate, common.degrees_of_freedom);
  result.alarm = result.chi2 > result.limit;
}

/// The error of each mark that meets the surface, and whether it is beyond its own limit.
void judge_marks(const MarkChain& chain, const Which& meet, const Moved& corrected, VerifyResult& result) {
  const LinearMarks linear = *chain.linearise(meet, {});
  const double limit = -2 * std::log(result.false_alarm_rate / double(meet.size()));
  for (std::size_t i = 0; i < meet.size(); ++i) {
    VerifiedMark& mark = result.marks[meet[i]];
    const auto by_state = linear.by_state.middleRows(Eigen::Index(2 * i), 2);
    mark.intended = *chain.intended(meet[i]);
    mark.error = linear.error.segment<2>(Eigen::Index(2 * i));
    mark.covariance =
        result.scatter * result.scatter * linear.noise[i] + by_state * chain.stated() * by_state.transpose();
    const Mat2 root = cholesky_lower(mark.covariance);
    const double first = mark.error.x() / root(0, 0),
                 second = (mark.error.y() - root(1, 0) * first) / root(1, 1);
    mark.chi2 = first * first + second * second;
    mark.beyond = mark.chi2 > limit;
    mark.error_after = chain.error(meet[i], corrected).value_or(mark.error);
  }
}

Rig corrected_rig(Rig rig, const MarkChain& chain, const RigProjector& projector, const Fit& fit) {
  for (RigProjector& device : rig.projectors)
    if (device.name == projector.name)
      device.rig_from_projector = (se3_exp(fit.moved.projector) * device.rig_from_projector).normalized();
  if (rig.covariance.empty()) return rig;
  // Rows and columns of what is corrected; the rest stays as uncertain as it was.
  NamedCovariance all{chain.rig_names(),
                      chain.stated().topLeftCorner(chain.surface_place(), chain.surface_place())};
  const Eigen::Index at = chain.projector_place(), count = chain.surface_place();
  all.matrix.middleRows(at, 6) = fit.covariance.block(at, 0, 6, count);
  all.matrix.middleCols(at, 6) = fit.covariance.block(0, at, count, 6);
  all.matrix = (0.5 * (all.matrix + all.matrix.transpose())).eval();
  std::vector<std::string> names = rig.covariance.names;
  for (const std::string& name : pose_increment_names("rig_from_" + projector.name))
    if (!rig.covariance.index_of(name)) names.push_back(name);
  rig.covariance = {names, all.block(names)};
  return rig;
}

std::string mm(double metres) {
  return fixed(1e3 * metres, 2) + " mm";
}

void add_remarks(const Rig& rig, const StatedSurface& surface, const VerifyOptions& options,
                 VerifyResult& result) {
  Diagnostics& remarks = result.diagnostics;
  if (result.alarm) {
    const bool corrected = result.rig || result.rig_from_surface;
    remarks.fail("drift",
                 "the error is " + mm(result.rms) + " RMS, " + mm(result.worst) +
                     " max, more than rig, surface and noise explain" +
                     (corrected ? "; with the correction " + mm(result.rms_after) + " RMS"
                                : "; find what moved, correct it with --correct, or calibrate again"));
    const Movement& moved = result.projector_moved;
    if (options.correct == Correct::kNothing && beyond_bump(moved, options) &&
        (!result.surface_moved || beyond_bump(*result.surface_moved, options)))
      remarks.warn(
          "beyond_bump",
          "it would take that " + words_of(moved) +
              ", more than any bump: check pattern, projector size, rig and surface of the captures");
  }
  int rejected = 0, beyond = 0;
  for (const VerifiedMark& mark : result.marks) {
    rejected += mark.rejection.empty() ? 0 : 1;
    beyond += mark.rejection.empty() && mark.beyond ? 1 : 0;
  }
  if (rejected > 0)
    remarks.warn("marks_left_out", std::to_string(rejected) + " of " + std::to_string(result.marks.size()) +
                                       " marks do not go with the others and are rejected");
  if (beyond > 0 && !result.alarm)
    remarks.warn("marks_beyond", std::to_string(beyond) +
                                     " marks lie beyond their own limits although together they show no "
                                     "movement: look there whether the surface is flat");
  if (result.scatter > kMaxScatter)
    remarks.warn(
        "marks_scatter",
        "after any movement of projector or surface the marks still lie " + mm(result.scatter_rms) +
            " rms from their places, " + fixed(result.scatter, 1) +
            " times what their detection promises: the surface is not flat, or the projector's zoom, "
            "focus or lens shift has changed; then calibrate again");
  if (rig.covariance.empty())
    remarks.warn(
        "rig_taken_as_exact",
        "the rig file states no uncertainty, so calibration error is reported as drift; calibrate with "
        "calibrate-projector, which writes the covariance");
  if (surface.rig_from_surface.covariance.isZero(0) && surface.jacobian_camera.size() == 0)
    remarks.warn("surface_taken_as_exact",
                 "the surface's pose has no uncertainty, so its error is reported as drift; state it "
                 "(--map-sigma 5mm,0.2deg)");
}

}  // namespace

double Movement::angle() const {
  return moved.head<3>().norm();
}
double Movement::angle_sigma() const {
  return sigma_along(moved.head<3>(), covariance.topLeftCorner<3, 3>());
}
double Movement::shift() const {
  return moved.tail<3>().norm();
}
double Movement::shift_sigma() const {
  return sigma_along(moved.tail<3>(), covariance.bottomRightCorner<3, 3>());
}

VerifyResult verify(const Rig& rig, const RigCamera& camera, const RigProjector& projector,
                    const StatedSurface& surface, const std::vector<LightPoint>& marks,
                    const VerifyOptions& options) {
  check(surface, marks, options);
  const bool camera_measured = surface.jacobian_camera.size() > 0;
  const Pose& rig_from_surface = surface.rig_from_surface.pose;
  const MarkChain chain(rig, camera, projector, surface, marks);
  VerifyResult result;
  result.surface = surface.name;
  for (const LightPoint& mark : marks) result.marks.emplace_back().seen = mark;
  const Which meet = meeting(chain, surface.name, result.marks);

  const Bumps bumps{bump_of(projector.rig_from_projector, options), bump_of(rig_from_surface, options)};
  const auto fit = [&](const Which& which, const Free& free, double scatter, bool robust = false) {
    return most_probable(chain, which, free, bumps, scatter, robust);
  };
  const Which used = agreeing(fit(meet, {true, true}, 1, true), meet, options.false_alarm_rate, result.marks);
  result.used = int(used.size());
  require_an_area(chain, used);

  const Fit any = fit(used, {true, true}, 1);
  result.scatter = remaining_scatter(any, used.size());
  test_for_movement(common_movement(chain, used, result.scatter, rig_from_surface), options, result);

  const Fit by_projector = fit(used, {true, false}, result.scatter),
            by_surface = fit(used, {false, true}, result.scatter);
  result.projector_moved =
      movement(projector.name, projector.rig_from_projector, by_projector.moved.projector,
               by_projector.covariance.block<6, 6>(chain.projector_place(), chain.projector_place()),
               root_mean_square(chain, used, by_projector.moved), by_projector.log_evidence);
  if (!camera_measured)
    result.surface_moved =
        movement(surface.name, rig_from_surface, by_surface.moved.surface,
                 by_surface.covariance.block<6, 6>(chain.surface_place(), chain.surface_place()),
                 root_mean_square(chain, used, by_surface.moved), by_surface.log_evidence);

  Moved corrected;
  if (result.alarm && options.correct == Correct::kProjector) {
    const double unit = result.scatter * result.scatter;
    refuse_wrong_map(result.projector_moved, result.surface_moved,
                     Vec2(by_projector.squares.sum(), by_surface.squares.sum()) / unit, options);
    judge_correction(by_projector.settled, result.projector_moved, result.surface_moved, options,
                     result.diagnostics);
    corrected = by_projector.moved;
    result.rig = corrected_rig(rig, chain, projector, by_projector);
  } else if (result.alarm && options.correct == Correct::kSurface) {
    judge_correction(by_surface.settled, *result.surface_moved, result.projector_moved, options,
                     result.diagnostics);
    corrected = by_surface.moved;
    result.rig_from_surface = {
        (se3_exp(corrected.surface) * rig_from_surface).normalized(),
        by_surface.covariance.block<6, 6>(chain.surface_place(), chain.surface_place())};
  }

  result.rms = root_mean_square(chain, used, {}, &result.worst);
  result.rms_after = root_mean_square(chain, used, corrected, &result.worst_after);
  result.scatter_rms = root_mean_square(chain, used, any.moved);
  judge_marks(chain, meet, corrected, result);
  add_remarks(rig, surface, options, result);
  return result;
}

}  // namespace procam::analyze
