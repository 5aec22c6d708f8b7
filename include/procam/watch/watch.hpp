#pragma once
/// Watches where the light of a running show is: image after image, without a pattern, with a stated rate of false alarms.
///
///   watch::Watch watch(rig.camera(), rig.projector(), covariance, options);
///   watch.place(watch::watched_surfaces(solved, rig.projector()));
///   WatchReport report = watch.add(time, light, image);           // some 5 a second
///
/// Each image gives shifts of cells (cell_shifts.hpp). Those of one window (2 s) are averaged cell by cell and give one
/// estimate (movement.hpp) and one test. Two windows in a row beyond the limit, with an error of at least `smallest_error`,
/// raise the alarm; fifteen where the light may be on something that stands before a surface. An image whose shifts differ from
/// those of its window begins the window anew. With a rate R of false alarms a week and N windows a week the limit of one window
/// is at the probability
///
///   p = R / N,   N = 604800 s / window
///
/// Windows of content that stands still have the same errors: two in a row are barely rarer than one. The rate holds as far
/// as the noise is as stated (cell_sigma, for one). Two windows in a row without a movement end the alarm.
///
/// A lamp that warms up moves the light by tenths of a pixel a minute, a bump at once. Between windows the movement of the
/// projector changes by d; an error has grown as a drift does if the RMS light shift by d was below `max_drift_step` in every
/// window since the light was last in place.
///
/// No clock, no thread and no device here: the same calls in the same order give the same reports.
#include <optional>
#include <string>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/watch/cell_shifts.hpp"
#include "procam/watch/light_geometry.hpp"
#include "procam/watch/movement.hpp"

namespace procam::watch {

enum class WatchState {
  kStarting,       ///< no window is complete yet
  kOk,             ///< the light is where it should be
  kSuspected,      ///< one window is beyond the limit; the next one decides
  kMoved,          ///< alarm, with one plausible cause
  kInseparable,    ///< alarm, with several plausible causes
  kNoTexture,      ///< the content has too little texture where the camera sees it
  kNotSeen,        ///< the camera is covered, or sees something else
  kProjectorOff,   ///< the camera sees the room without the content's light
  kLightSwitched,  ///< the room's light has changed within the last two seconds
};

PROCAM_EXPORT const char* to_string(WatchState state);

struct WatchOptions {
  GeometryOptions geometry;
  CompareOptions compare;
  MovementOptions movement;
  double window = 2;  ///< seconds; longer where that time gives fewer than three usable images
  double false_alarms_a_week = 1;
  double smallest_error = 5e-4;  ///< metres RMS on the surfaces: less is no alarm, however certain
  int min_cells = 8;             ///< textured cells that are needed
  double max_drift_step = 3e-4;  ///< metres RMS from one window to the next: more is a bump
  /// A localiser places the rig: each image tells where it is (WatchReport::rig), and no window is tested.
  bool locates_rig = false;
};

struct WatchReport {
  double time = 0;
  WatchState state = WatchState::kStarting;
  bool is_alarm = false;  ///< moved or inseparable, also while the view is lost for a moment
  bool is_drift = false;  ///< alarm, and the error has grown slowly
  std::string sentence;   ///< for people
  // Of this image.
  int textured = 0, measured = 0;
  Vec2 median_shift = Vec2::Zero();  ///< of the measured cells, camera pixels
  std::optional<RigInformation>
      rig;  ///< WatchOptions::locates_rig: about the places of the surfaces as given
  // Of the last complete window; of the explanation that fits best, without a movement of the most probable one.
  double window_time = 0;             ///< its end; 0: none yet
  double error = 0, error_sigma = 0;  ///< of the light on the surfaces, metres RMS
  double probability = 1;             ///< of the test
  std::optional<MovementEstimate> estimate;
};

class PROCAM_EXPORT Watch {
 public:
  /// Throws std::invalid_argument for options out of range.
  Watch(const RigCamera& camera, const RigProjector& projector, const WatchOptions& options = {});

  /// Surfaces as the projector is to light them from now on. The window begins anew.
  void place(const std::vector<WatchedSurface>& surfaces);
  /// The projector as it is now known (a correction), and the covariance of its pose relative to the camera where that has
  /// changed. The window begins anew, and the alarm ends.
  void correct(const RigProjector& projector, const std::optional<Mat6>& covariance = std::nullopt);
  /// A surface as it is now known: rig_from_surface = exp(moved) rig_from_surface. The window begins anew, and the alarm
  /// ends. Throws std::invalid_argument for a name that was not placed.
  void correct(const std::string& surface, const Vec6& moved);
  const std::vector<WatchedSurface>& surfaces() const { return surfaces_; }

  /// The camera's image at `time` (seconds, growing) and the light that was shown then. Throws std::invalid_argument for
  /// other sizes than those of the rig.
  WatchReport add(double time, const ShownLight& light, ViewU8 image);

  const LightGeometry& geometry() const { return geometry_; }
  const RigProjector& projector() const { return projector_; }
  /// Probability below which a window counts as moved.
  double window_limit() const { return window_limit_; }

 private:
  struct CellSum {
    Mat2 information = Mat2::Zero();
    Vec2 shift = Vec2::Zero(), by_delay = Vec2::Zero();  ///< weighted by the information
  };
  void end_alarm();
  void begin_window(double time);
  void add_to_window(const ImageComparison& compared);
  void end_window(double time);
  void look_for_jump(const MovementEstimate& estimate);
  std::optional<WatchState> view_state(double time, const ImageComparison& compared);
  void describe(WatchReport& report) const;

  RigCamera camera_;
  RigProjector projector_;
  WatchOptions options_;
  double window_limit_ = 0;
  std::vector<WatchedSurface> surfaces_;
  LightGeometry geometry_;
  std::optional<CameraTone> tone_;
  Vec2 start_ = Vec2::Zero();
  std::vector<CellSum> sums_;
  double window_begin_ = -1;
  double used_time_ = 0;  ///< of the last usable image of the window, or its begin
  int window_images_ = 0;
  Vec2 window_shift_ = Vec2::Zero();  ///< median of its first image, working pixels
  std::optional<double> usual_mean_;  ///< of images in which the content is seen, grey levels
  double usual_deviation_ = 0;
  std::optional<double> unlit_;  ///< grey level without the projector's light
  double switched_ = -1e9;       ///< when the room's light changed
  int moved_windows_ = 0, calm_windows_ = 0;
  int sure_windows_ = 0;  ///< moved ones in a row that nothing before a surface explains
  bool is_alarm_ = false;
  bool has_jumped_ = false;         ///< since the light was last in place
  Vec6 last_moved_ = Vec6::Zero();  ///< of the projector, in the last window
  double window_time_ = 0;
  std::optional<MovementEstimate> estimate_;
};

}  // namespace procam::watch
