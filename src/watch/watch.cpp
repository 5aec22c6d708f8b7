#include "procam/watch/watch.hpp"

#include <algorithm>
#include <cmath>

#include "procam/core/base/stats.hpp"
#include "procam/core/base/words.hpp"
#include "procam/core/geometry/se3.hpp"

namespace procam::watch {
namespace {

constexpr double kWeek = 7 * 24 * 3600.0;
constexpr int kAlarmWindows = 2;  ///< in a row
/// In a row, of light that may be on something before a surface: people who stand there leave again.
constexpr int kBeforeWindows = 15;
constexpr double kMaxOfOthers =
    1e-3;  ///< probability without any neighbourhood of cells: with more, few cells moved
constexpr double kMaxStep =
    1.5;  ///< working pixels between the median shifts of a window's images: more is another view
constexpr int kMinImages = 3;       ///< of a window
constexpr double kMaxScatter = 25;  ///< of a window's cells about a movement, in variances of their noise
constexpr double kMaxGap = 1.5;     ///< seconds without a usable image: the window begins anew
constexpr double kSeenShare = 0.2;  ///< of textured cells: with fewer the view is lost
constexpr double kSwitchGrey = 10;  ///< change of the unlit level
constexpr double kSwitchTime = 2;   ///< seconds
/// A room without the projector's light: as bright as this share of the usual image or more, with at most this share of its
/// contrast, and nothing of the content in it.
constexpr double kCoveredShare = 0.1, kFlatShare = 0.6, kNoCorrelation = 0.2;

/// Grey level without projected light, by the cells' own gains and offsets.
std::optional<double> unlit_level(const ImageComparison& compared, const CameraTone& tone) {
  std::vector<double> levels;
  const double dark = std::pow(tone.ambient, 1 / tone.gamma);
  for (const CellShift& cell : compared.cells)
    if (cell.state == CellState::kMeasured) levels.push_back(cell.offset + cell.gain * dark);
  if (levels.empty()) return std::nullopt;
  return median(std::move(levels));
}

std::string movement_text(const Explanation& cause) {
  return cause.name + " rotated by " + fixed(cause.moved.head<3>().norm() / kDegree, 2) +
         " deg and moved by " + mm(cause.shift, 1) +
         (cause.is_before ? ", or something is before " + cause.name : "");
}

}  // namespace

const char* to_string(WatchState state) {
  switch (state) {
    case WatchState::kStarting:
      return "starting";
    case WatchState::kOk:
      return "ok";
    case WatchState::kSuspected:
      return "suspected";
    case WatchState::kMoved:
      return "moved";
    case WatchState::kInseparable:
      return "inseparable";
    case WatchState::kNoTexture:
      return "no_texture";
    case WatchState::kNotSeen:
      return "not_seen";
    case WatchState::kProjectorOff:
      return "projector_off";
    case WatchState::kLightSwitched:
      return "light_switched";
  }
  return "unknown";
}

Watch::Watch(const RigCamera& camera, const RigProjector& projector, const WatchOptions& options)
    : camera_(camera), projector_(projector), options_(options) {
  require(options.window > 0 && options.false_alarms_a_week > 0 && options.smallest_error >= 0 &&
              options.max_drift_step >= 0,
          "Watch: options out of range");
  window_limit_ = std::min(0.1, options.false_alarms_a_week * options.window / kWeek);
  place({});
}

void Watch::place(const std::vector<WatchedSurface>& surfaces) {
  surfaces_ = surfaces;
  geometry_ = light_geometry(camera_, projector_, surfaces, options_.geometry);
  window_begin_ = -1;
}

void Watch::correct(const RigProjector& projector, const std::optional<Mat6>& covariance) {
  projector_ = projector;
  if (covariance) options_.movement.projector_covariance = *covariance;
  end_alarm();
  place(std::vector<WatchedSurface>(surfaces_));
}

void Watch::correct(const std::string& surface, const Vec6& moved) {
  std::vector<WatchedSurface> surfaces = surfaces_;
  const auto found = std::find_if(surfaces.begin(), surfaces.end(),
                                  [&](const WatchedSurface& one) { return one.name == surface; });
  require(found != surfaces.end(), "Watch: there is no such surface");
  found->rig_from_surface = (se3_exp<double>(moved) * found->rig_from_surface).normalized();
  end_alarm();
  place(surfaces);
}

void Watch::end_alarm() {
  start_ = Vec2::Zero();
  moved_windows_ = sure_windows_ = calm_windows_ = 0;
  is_alarm_ = false;
  has_jumped_ = false;
  last_moved_.setZero();
  estimate_.reset();
}

void Watch::begin_window(double time) {
  window_begin_ = used_time_ = time;
  window_images_ = 0;
  sums_.assign(geometry_.cells.size(), {});
}

void Watch::add_to_window(const ImageComparison& compared) {
  const std::vector<double> weights = agreeing_cells(geometry_, compared.cells, options_.movement);
  for (std::size_t i = 0; i < compared.cells.size(); ++i) {
    if (!(weights[i] > 0)) continue;
    const CellShift& cell = compared.cells[i];
    CellSum& sum = sums_[i];
    sum.information += cell.information;
    sum.shift += cell.information * cell.shift;
    sum.by_delay += cell.information * cell.by_delay;
  }
  ++window_images_;
}

void Watch::end_window(double time) {
  std::vector<CellShift> shifts;
  for (std::size_t i = 0; i < sums_.size(); ++i) {
    const CellSum& sum = sums_[i];
    CellShift& shift = shifts.emplace_back();
    shift.cell = int(i);
    if (!(sum.information.trace() > 1e-6)) continue;
    const Mat2 covariance = (sum.information + 1e-6 * Mat2::Identity()).inverse();
    shift.state = CellState::kMeasured;
    shift.information = sum.information;
    shift.shift = covariance * sum.shift;
    shift.by_delay = covariance * sum.by_delay;
  }
  MovementEstimate estimate = estimate_movement(geometry_, projector_.name, shifts, options_.movement);
  begin_window(time);
  if (estimate.degrees_of_freedom == 0 || estimate.cells < options_.min_cells) return;
  // Cells that no movement explains tell of something else in the view: no movement, and none that can be excluded.
  if (estimate.scatter > kMaxScatter) return;
  const auto causes = estimate.plausible();
  const bool moved = estimate.probability < window_limit_ && estimate.of_others < kMaxOfOthers &&
                     !causes.empty() && causes.front()->error > options_.smallest_error;
  const bool is_before =
      std::any_of(causes.begin(), causes.end(), [](const Explanation* one) { return one->is_before; });
  moved_windows_ = moved ? moved_windows_ + 1 : 0;
  sure_windows_ = moved && !is_before ? sure_windows_ + 1 : 0;
  calm_windows_ = moved ? 0 : calm_windows_ + 1;
  if (sure_windows_ >= kAlarmWindows || moved_windows_ >= kBeforeWindows) is_alarm_ = true;
  if (calm_windows_ >= kAlarmWindows) is_alarm_ = false;
  look_for_jump(estimate);
  window_time_ = time;
  estimate_ = std::move(estimate);
}

void Watch::look_for_jump(const MovementEstimate& estimate) {
  for (const Explanation& one : estimate.explanations) {
    if (one.thing != MovedThing::kProjector) continue;
    const Vec6 step = one.moved - last_moved_;
    double square = 0;
    for (const LitCell& cell : geometry_.cells) square += (cell.by_projector() * step).squaredNorm();
    has_jumped_ = has_jumped_ ||
                  square > double(geometry_.cells.size()) * options_.max_drift_step * options_.max_drift_step;
    if (!is_alarm_ && moved_windows_ == 0 && one.error < options_.smallest_error) has_jumped_ = false;
    last_moved_ = one.moved;
  }
}

/// What the image shows, if it cannot be used for a measurement.
std::optional<WatchState> Watch::view_state(double time, const ImageComparison& compared) {
  if (compared.textured < options_.min_cells) return WatchState::kNoTexture;
  if (compared.measured < std::max(6.0, kSeenShare * compared.textured)) {
    if (!usual_mean_) return WatchState::kNotSeen;
    const double brightness = compared.image_mean / std::max(1.0, *usual_mean_);
    const bool is_room = brightness > kCoveredShare && brightness < 1 &&
                         compared.image_deviation < kFlatShare * usual_deviation_ &&
                         std::abs(compared.correlation) < kNoCorrelation;
    return is_room ? WatchState::kProjectorOff : WatchState::kNotSeen;
  }
  usual_deviation_ = usual_mean_ ? usual_deviation_ + 0.1 * (compared.image_deviation - usual_deviation_)
                                 : compared.image_deviation;
  usual_mean_ = usual_mean_ ? *usual_mean_ + 0.1 * (compared.image_mean - *usual_mean_) : compared.image_mean;
  const auto unlit = unlit_level(compared, tone_.value_or(options_.compare.tone));
  if (unlit) {
    if (unlit_ && std::abs(*unlit - *unlit_) > kSwitchGrey) {
      switched_ = time;
      unlit_ = unlit;
    }
    unlit_ = unlit_ ? *unlit_ + 0.1 * (*unlit - *unlit_) : *unlit;
  }
  return std::nullopt;
}

WatchReport Watch::add(double time, const ShownLight& light, ViewU8 image) {
  CompareOptions comparing = options_.compare;
  if (tone_) comparing.tone = *tone_;
  // Repeated content (lines of text) fits at many shifts: only a shift that windows confirm is a start.
  const Vec2 start = is_alarm_ || moved_windows_ > 0 ? start_ : Vec2::Zero();
  ImageComparison compared = compare(geometry_, light, image, start, comparing);
  if (!tone_ && compared.measured >= options_.min_cells) {
    tone_ = comparing.tone = fit_tone(geometry_, light, image, compared.start, comparing);
    compared = compare(geometry_, light, image, compared.start, comparing);
  }
  WatchReport report;
  report.time = time;
  report.textured = compared.textured;
  report.measured = compared.measured;
  const std::optional<WatchState> lost = view_state(time, compared);
  if (window_begin_ < 0 || time - used_time_ > kMaxGap) begin_window(time);
  if (!lost) {
    std::vector<double> x, y, by_delay;
    for (const CellShift& cell : compared.cells)
      if (cell.state == CellState::kMeasured)
        x.push_back(cell.shift.x()), y.push_back(cell.shift.y()), by_delay.push_back(cell.by_delay.norm());
    const Vec2 middle(median_or(std::move(x), 0.0), median_or(std::move(y), 0.0));
    report.median_shift = geometry_.average * middle;
    start_ = middle;
    used_time_ = time;
    // Content that moves is displaced by what the moment of exposure is off.
    const double max_step =
        kMaxStep + 4 * options_.movement.delay_sigma * median_or(std::move(by_delay), 0.0);
    if (window_images_ > 0 && (middle - window_shift_).norm() > max_step) begin_window(time);
    if (window_images_ == 0) window_shift_ = middle;
    if (options_.locates_rig) {
      report.rig = rig_information(geometry_, compared.cells, options_.movement);
      report.state = WatchState::kOk;
    } else {
      add_to_window(compared);
    }
  }
  // A slow camera or computer lengthens the window.
  if (!options_.locates_rig && time - window_begin_ >= options_.window && window_images_ >= kMinImages)
    end_window(time);
  report.is_alarm = is_alarm_;
  report.is_drift = is_alarm_ && !has_jumped_;
  report.window_time = window_time_;
  report.estimate = estimate_;
  if (lost)
    report.state = *lost;
  else if (time - switched_ < kSwitchTime)
    report.state = WatchState::kLightSwitched;
  else if (is_alarm_ && estimate_)
    report.state = estimate_->plausible().size() > 1 ? WatchState::kInseparable : WatchState::kMoved;
  else if (estimate_)
    report.state = moved_windows_ > 0 ? WatchState::kSuspected : WatchState::kOk;
  describe(report);
  return report;
}

void Watch::describe(WatchReport& report) const {
  std::string causes;
  if (report.estimate) {
    const std::vector<const Explanation*> plausible = report.estimate->plausible();
    const bool is_moved = is_alarm_ || moved_windows_ > 0;
    const Explanation& best =
        is_moved && !plausible.empty() ? *plausible.front() : report.estimate->explanations.front();
    report.error = best.error;
    report.error_sigma = best.error_sigma;
    report.probability = report.estimate->probability;
    for (const Explanation* one : plausible) causes += (causes.empty() ? "" : ", or ") + movement_text(*one);
  }
  const std::string error = mm(report.error, 1) + " +- " + mm(report.error_sigma);
  switch (report.state) {
    case WatchState::kStarting:
      report.sentence = "the first images are measured";
      break;
    case WatchState::kOk:
      report.sentence = options_.locates_rig ? "the light shows where the rig is"
                                             : "the light is where it should be: " + error;
      break;
    case WatchState::kSuspected:
      report.sentence = "the light may be off by " + error + ": " + causes + " (the next images decide)";
      break;
    case WatchState::kMoved:
      report.sentence = "the light is off by " + error + ": " + causes;
      break;
    case WatchState::kInseparable:
      report.sentence = "the light is off by " + error + "; the causes cannot be separated: " + causes;
      break;
    case WatchState::kNoTexture:
      if (geometry_.cells.empty()) {
        report.sentence = "no plane surface is lit where the camera sees it";
        break;
      }
      report.sentence =
          "the content has too little texture to be measured (" + std::to_string(report.textured) + " cells)";
      break;
    case WatchState::kNotSeen:
      report.sentence =
          "the camera does not see the content: it is covered, or something is in front of the surfaces";
      break;
    case WatchState::kProjectorOff:
      report.sentence = "the camera sees the room without the projector's light";
      break;
    case WatchState::kLightSwitched:
      report.sentence = "the room's light has changed";
      break;
  }
}

}  // namespace procam::watch
