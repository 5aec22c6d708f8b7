#pragma once
/// The calibration of a room in steps: solve by all light, check known lenses, find the scale, judge the result. The
/// steps are implemented by topic: calibrate.cpp (the solution), known_lenses.cpp, scale.cpp, wall_uncertainty.cpp and
/// result.cpp (the rig and the report).
#include <algorithm>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "adjust.hpp"
#include "lens_check.hpp"
#include "procam/room/calibrate_room.hpp"
#include "start.hpp"

namespace procam::room {

/// Of the points one in so many is held out.
inline constexpr int kHeldOutEvery = 10;

/// The point in the rig's frame, by the state's own length.
std::optional<Vec3> place(const RoomPoints& points, const RoomState& state, int index);

/// Of the points in use some, as many of each light map: enough for a start and for outliers to be found. All where there
/// are not many.
std::vector<char> evenly_by_map(const RoomPoints& points, const std::vector<char>& used);
RoomPoints part_of(const RoomPoints& points, const std::vector<char>& chosen);

/// Solves for one set of points. A part that is refused throws Error.
class Route {
 public:
  Route(const RoomPoints& points, const RoomOptions& options)
      : points_(points), options_(options), plan_(plan_lenses(points, options)) {}
  RoomCalibration run();

 private:
  int positions() const { return int(points_.positions.size()); }
  bool held_out(int point) const { return point % kHeldOutEvery == kHeldOutEvery / 2; }
  static bool any(const std::vector<char>& chosen) {
    return std::find(chosen.begin(), chosen.end(), 1) != chosen.end();
  }
  PointsInUse in_use() const { return {adjustment_->used, result_.scatter}; }

  // The solution: calibrate.cpp.
  void check_names() const;
  /// With cameras whose lens is not known: by the focal length that explains the light best.
  RoomState start() const;
  RoomState start_with(const RoomPoints& points) const;
  void prepare();
  void reject();
  void fit_without_loss();
  double mean_variance(int point) const;
  void check_fit() const;
  void find_covariance();

  // Known lenses against the light: known_lenses.cpp.
  std::vector<char> known_lenses(bool unstated) const;
  std::string disagreement_words(const LensDisagreement& disagrees) const;
  /// The light of several positions tells a camera's lens as well, though less exactly than a board: does it agree?
  void check_stated_lenses();
  /// Do the projectors keep to their data sheets? False: a failure is reported, and a known lens is not to be blamed.
  bool check_sheets();
  /// A lens of which nothing is stated: kept where the light agrees, else estimated. What the light leaves open is part
  /// of the covariance.
  void check_unstated_lenses();

  // Known distances: scale.cpp.
  /// A known distance by the state's own length, the points' depths at their minimum.
  std::optional<double> modelled(const KnownDistance& distance, RoomState& state) const;
  const Pose& pose_of(const std::string& name, const RoomState& state) const;
  int first_position(const std::string& camera) const;
  /// Something of known length, by the state's own length.
  struct KnownLength {
    double length = 0, relative_variance = 0;
    std::function<std::optional<double>(RoomState&)> modelled;
  };
  KnownLength known_length(const KnownDistance& distance) const;
  KnownLength known_length(const KnownTarget& target) const;
  /// log(scale) = value + by_parameters . (change of the parameters) + noise.
  void find_scale();
  double distance_between(const KnownDistance& distance, const RoomState& state) const;

  // The uncertainty of the walls: wall_uncertainty.cpp.
  void measure_parallax();
  /// Is this position where the rig has its camera?
  bool is_in_rig(int position) const;
  void measure_walls();
  /// Where a stated lens is in doubt, a remark instead. `contradicted`: a lens that is not in use, in words.
  void refuse_uncertain(const std::string& contradicted = "");
  void measure_flatness();

  // The result: result.cpp.
  void fill_rig();
  void judge_regions();
  void add_remarks();

  const RoomPoints& points_;
  const RoomOptions& options_;
  LensPlan plan_;
  RoomState state_;
  std::optional<Adjustment> adjustment_;
  Layout layout_;
  MatX covariance_;
  VecX scale_by_parameters_;
  double scale_ = 1, scale_variance_ = 0;
  std::string doubt_;  ///< of a known lens, where the light contradicts it
  RoomCalibration result_;
};

/// calibrate_room() with what is known of cameras' focal lengths; a sheet that the light contradicts is not used.
RoomCalibration calibrate_with_sheets(const RoomPoints& points, const RoomOptions& options);

}  // namespace procam::room
