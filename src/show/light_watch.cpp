#include "light_watch.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <fstream>
#include <mutex>
#include <set>
#include <thread>
#include <utility>

#include "procam/core/base/words.hpp"
#include "procam/core/geometry/se3.hpp"
#include "procam/detect/marker_edges.hpp"
#include "procam/device/frame_sink.hpp"
#include "procam/io/files.hpp"
#include "procam/io/rig_file.hpp"
#include "rejected_counts.hpp"
#include "rig_sights.hpp"

namespace procam::show {
namespace {

constexpr std::size_t kFramesOfCheck = 4;  ///< in a row, that a camera image may have seen
constexpr double kPatience = 0.5;          ///< seconds for these frames, then for the image
constexpr double kStillMetres = 1e-5,
                 kStillRadians = 1e-5;  ///< metres, radians: surfaces that stay where they are
constexpr double kSilence = 1.5;        ///< seconds without an image: reported then
constexpr const char* kNoImages = "no_images";
constexpr std::size_t kHistoryWindows = 300;  ///< windows that the status holds

struct HeldFrame {
  std::shared_ptr<const ImageU8> frame;
  double light_time = 0;
};

bool are_in_place(const std::vector<watch::WatchedSurface>& a, const std::vector<watch::WatchedSurface>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const auto& one, const auto& other) {
    const Vec6 moved = se3_log(Pose(one.rig_from_surface * other.rig_from_surface.inverse()));
    return one.name == other.name && one.outline == other.outline && moved.head<3>().norm() < kStillRadians &&
           moved.tail<3>().norm() < kStillMetres;
  });
}

bool is_in_world(const SolvedSurfaceSet& solved, const std::string& name) {
  for (const SolvedSurface& surface : solved.surfaces)
    if (surface.surface.name == name) {
      const InRoom* place = place_of(surface.surface.geometry);
      return place != nullptr && place->frame == "world";
    }
  return false;
}

/// The name of one in the projector's frame; empty: there is none.
std::string surface_of_projector(const SolvedSurfaceSet& solved) {
  for (const SolvedSurface& surface : solved.surfaces) {
    const InRoom* place = place_of(surface.surface.geometry);
    if (place == nullptr || (place->frame != "world" && place->frame != "rig")) return surface.surface.name;
  }
  return "";
}

bool are_equal(const ImageU8& a, const ImageU8& b) {
  const std::size_t size = std::size_t(a.width()) * std::size_t(a.height()) * std::size_t(a.channels());
  return a.size() == b.size() && a.channels() == b.channels() &&
         std::equal(a.data(), a.data() + size, b.data());
}

}  // namespace

struct LightWatch::State {
  /// What the frames of a check were drawn for.
  struct Lit {
    std::vector<watch::WatchedSurface> surfaces;
    Pose world_from_rig;
  };

  LightWatchOptions options;
  Open open;
  std::unique_ptr<device::FrameSource> camera;
  std::string description;  ///< of the first
  watch::Watch watcher;
  std::ofstream log;
  std::vector<watch::WatchedSurface> placed;

  std::atomic<bool> ends{false}, wants_frames{false};
  std::mutex mutex;  ///< of the rest
  std::condition_variable changed;
  std::vector<HeldFrame> frames;
  std::vector<watch::WatchedSurface> surfaces;
  Pose world_from_rig;  ///< for which the first of the frames was drawn
  track::PoseCorrectionStatus pose;
  std::string
      fixed_to_projector;    ///< a surface in the projector's frame, which a corrected pose does not move
  std::optional<bool> wish;  ///< to correct, or to undo
  std::optional<News> news;
  WatchStatus status;
  RejectedCounts rejected;
  std::thread thread;
  // Of the thread.
  MarkerCells cells;
  std::set<int> other_markers;  ///< seen, and not in the map
  bool knows_map = false;       ///< a marker of it was seen, or it was said that none was
  double first_look = -1;
  std::string said_of_correction;
  std::string said_of_fault;  ///< until an image can be used again
  double corrected_by = 0;    ///< metres, in all
  double last_image = device::now_s();

  State(Open opening, const LightWatchOptions& given)
      : options(given), open(std::move(opening)), watcher(given.camera, given.projector, given.watch) {
    status.corrects = given.corrects;
    if (!given.markers.markers.empty()) cells = detect::marker_cells(given.markers.dictionary);
  }

  void run() {
    while (!ends) {
      const double begin = device::now_s();
      try {
        if (!camera) camera = open();
        check();
        rejected.note(camera->rejected());
      } catch (const std::exception& error) {
        fail(error);
      }
      while (!ends && device::now_s() - begin < options.period)
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  }

  void fail(const std::exception& error) {
    {
      const std::lock_guard<std::mutex> lock(mutex);
      ++status.faults;
      status.state = kNoImages;
      status.sentence = error.what();
      tell(said_of_fault == error.what() ? "" : "watch: " + status.sentence);
      said_of_fault = error.what();
    }
    const auto* known = dynamic_cast<const Error*>(&error);
    if (camera && (known == nullptr || known->kind() != ErrorKind::kDevice)) return;
    if (camera) rejected.note(camera->rejected());
    camera.reset();
    rejected.closed();
    for (int i = 0; i < 20 && !ends; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }

  /// With the mutex held.
  void tell(const std::string& sentence) {
    if (!news) news.emplace();
    news->status = status;
    if (!sentence.empty()) news->sentences.push_back(sentence);
  }

  std::vector<HeldFrame> next_frames(Lit& lit) {
    std::unique_lock<std::mutex> lock(mutex);
    frames.clear();
    wants_frames = true;
    changed.wait_for(lock, std::chrono::duration<double>(kPatience),
                     [&] { return frames.size() >= kFramesOfCheck || ends; });
    wants_frames = false;
    lit = {surfaces, world_from_rig};
    return std::move(frames);
  }

  void check() {
    Lit lit;
    const std::vector<HeldFrame> shown = next_frames(lit);
    if (shown.size() < 2) return;
    const double first = shown.front().light_time + options.camera_delay,
                 last = shown.back().light_time + options.camera_delay;
    for (const double begin = device::now_s(); !ends && device::now_s() - begin < kPatience;) {
      const std::optional<device::SeenFrame> seen = camera->next(first, 0.05);
      if (!seen) continue;
      last_image = device::now_s();
      // It saw later frames: of content that stands still they are the same.
      if (seen->time_s > last && !are_equal(*shown.front().frame, *shown.back().frame)) return;
      return compare(shown, lit, *seen);
    }
    if (device::now_s() - last_image > kSilence) report_silence();
  }

  void report_silence() {
    const std::lock_guard<std::mutex> lock(mutex);
    if (status.state == kNoImages) return;
    status.state = kNoImages;
    status.sentence = "the camera gives no images";
    tell("watch: " + status.sentence);
  }

  void compare(const std::vector<HeldFrame>& shown, const Lit& lit, const device::SeenFrame& seen) {
    if (seen.image.size() != options.camera.camera.size)
      throw Error(ErrorKind::kInput, "camera", "its frames are not of the size it was calibrated with",
                  "set its mode to that of the rig file");
    const double exposed = seen.time_s - options.camera_delay;
    std::size_t k = 0;
    while (k + 2 < shown.size() && shown[k + 1].light_time <= exposed) ++k;
    const double interval = shown[k + 1].light_time - shown[k].light_time;
    const double share = interval > 0 ? std::clamp((exposed - shown[k].light_time) / interval, 0.0, 1.0) : 0;
    take_wish();
    if (!are_in_place(placed, lit.surfaces)) watcher.place(placed = lit.surfaces);
    // Frames of equal pixels are compared as one that stands still.
    const ImageU8 &frame = *shown[k].frame, &next = *shown[k + 1].frame;
    const bool still = are_equal(frame, next);
    watch::ShownLight light{frame, still ? frame : next, share, interval};
    const watch::WatchReport found = watcher.add(exposed, light, seen.image);
    report(found);
    if (options.watch.locates_rig)
      locate(found, lit.world_from_rig, seen.image);
    else
      correct(found);
  }

  /// Where the rig was at the exposure, by the light and by markers.
  void locate(const watch::WatchReport& found, const Pose& drawn_for, const ImageU8& image) {
    if (!status.corrects) return;
    std::vector<track::PoseSight> sights;
    if (found.rig && found.rig->cells > 0)
      sights.push_back({found.time, drawn_for, found.rig->information, found.rig->score});
    if (!options.markers.markers.empty()) {
      const MarkerDetections markers = detect::detect_marker_edges(image, cells, {options.camera.camera});
      look_for_map(markers);
      if (auto seen = sight_of_markers(markers, found.time, options.camera, options.markers, drawn_for))
        sights.push_back(*seen);
    }
    if (sights.empty()) return;
    const std::lock_guard<std::mutex> lock(mutex);
    status.is_corrected = true;
    tell("");
    news->sights.insert(news->sights.end(), sights.begin(), sights.end());
  }

  /// Says once that the map fits nothing that is there: other ids, another dictionary.
  void look_for_map(const MarkerDetections& found) {
    if (knows_map) return;
    const auto& map = options.markers.markers;
    for (const SeenMarker& seen : found.markers) {
      if (std::any_of(map.begin(), map.end(), [&](const PlacedMarker& one) { return one.id == seen.id; })) {
        knows_map = true;
        return;
      }
      other_markers.insert(seen.id);
    }
    if (first_look < 0) first_look = device::now_s();
    if (device::now_s() - first_look < options.map_patience) return;
    knows_map = true;
    std::vector<std::string> others;
    for (const int id : other_markers) others.push_back(std::to_string(id));
    const std::lock_guard<std::mutex> lock(mutex);
    tell("watch: none of the " + std::to_string(map.size()) + " markers of the map was seen for " +
         fixed(options.map_patience, 0) + " s" +
         (others.empty() ? ": check that the camera sees them, and the dictionary"
                         : "; " + and_list(others) + ", which are seen, are not in it: check the ids"));
  }

  void take_wish() {
    const std::lock_guard<std::mutex> lock(mutex);
    const std::optional<bool> wished = std::exchange(wish, std::nullopt);
    if (!wished || *wished == status.corrects) return;
    status.corrects = *wished;
    if (*wished) return tell("watch: what is found is corrected from now on");
    const double error = corrected_by;
    corrected_by = 0;
    watcher.correct(options.projector, options.watch.movement.projector_covariance);
    status.is_corrected = false;
    tell("watch: the correction is undone; from now on errors are reported and not corrected");
    news->target = Target{options.projector.rig_from_projector, error};
  }

  void correct(const watch::WatchReport& found) {
    if (!status.corrects) return;
    watch::Correction correction = watch::correction_of(found, watcher.projector(), options.correction);
    const std::lock_guard<std::mutex> lock(mutex);
    const bool is_surface = !correction.surface.empty();
    if (correction.is_possible() && !is_surface && !fixed_to_projector.empty()) {
      correction.error = 0;
      correction.sentence = "not corrected: surface '" + fixed_to_projector +
                            "' was placed in the projector's frame; place it in the rig or the world";
    }
    if (correction.sentence != said_of_correction && !correction.sentence.empty())
      tell("watch: " + correction.sentence);
    said_of_correction = correction.is_possible() ? "" : correction.sentence;
    if (!correction.is_possible()) return;
    ++status.corrections;
    status.is_corrected = true;
    status.is_alarm = false;
    tell("");
    if (is_surface) {
      watcher.correct(correction.surface, correction.moved);
      placed = watcher.surfaces();
      news->surfaces.push_back({correction.surface, correction.moved, correction.error});
      return;
    }
    watcher.correct(correction.projector, correction.covariance);
    corrected_by += correction.error;
    news->target = Target{correction.projector.rig_from_projector, correction.error};
    save(correction);
  }

  /// With the mutex held.
  void save(const watch::Correction& correction) {
    if (options.save.empty()) return;
    try {
      Rig rig = watch::corrected_rig(options.rig, correction, options.camera.name);
      rig.provenance.options["corrected"] = correction.sentence;
      io::save_rig(options.save, rig);
    } catch (const Error& error) {
      ++status.faults;
      tell(std::string("watch: ") + error.what());
    }
  }

  void report(const watch::WatchReport& seen) {
    write_line(seen);
    said_of_fault.clear();
    const std::lock_guard<std::mutex> lock(mutex);
    const bool is_new = status.state != to_string(seen.state) || status.is_alarm != seen.is_alarm;
    ++status.checks;
    status.alarms += seen.is_alarm && !status.is_alarm ? 1 : 0;
    status.state = to_string(seen.state);
    status.sentence = seen.sentence;
    status.is_alarm = seen.is_alarm;
    status.error_mm = 1e3 * seen.error;
    status.error_sigma_mm = 1e3 * seen.error_sigma;
    status.probability = seen.probability;
    status.textured = seen.textured;
    status.measured = seen.measured;
    if (seen.window_time > status.window_time) {
      status.window_time = seen.window_time;
      status.history_mm.push_back(status.error_mm);
      if (status.history_mm.size() > kHistoryWindows) status.history_mm.erase(status.history_mm.begin());
    }
    tell(is_new ? "watch: " + seen.sentence : "");
  }

  /// The error of the localiser that the last image gave.
  void write_pose() {
    track::PoseCorrectionStatus last;
    {
      const std::lock_guard<std::mutex> lock(mutex);
      last = pose;
    }
    char line[160];
    std::snprintf(line, sizeof line, ",%.1f,%.1f,%.3f,%.1f,%.1f,%.3f,%.1f,%llu", 1e3 * last.error[3],
                  1e3 * last.error[4], last.error[2] / kDegree, 1e3 * last.sigma[3], 1e3 * last.sigma[4],
                  last.sigma[2] / kDegree, last.chi2, (unsigned long long)last.refused);
    log << line;
  }

  void write_line(const watch::WatchReport& seen) {
    if (!log.is_open()) return;
    char line[256];
    std::snprintf(line, sizeof line, "%.3f,%s,%d,%d,%d,%.3f,%.3f,%.4g,%.2f,%.2f", seen.time,
                  to_string(seen.state), int(seen.is_alarm), seen.textured, seen.measured, 1e3 * seen.error,
                  1e3 * seen.error_sigma, seen.probability, seen.median_shift.x(), seen.median_shift.y());
    log << line;
    if (options.watch.locates_rig) write_pose();
    log << "\n" << std::flush;
    if (log) return;
    log.close();
    const std::lock_guard<std::mutex> lock(mutex);
    ++status.faults;
    tell("watch: '" + options.log + "' cannot be written; the show continues without it");
  }
};

LightWatch::LightWatch(Open open, const LightWatchOptions& options)
    : state_(std::make_unique<State>(std::move(open), options)) {
  State& s = *state_;
  s.camera = s.open();
  s.description = s.camera->description();
  if (!options.log.empty()) {
    s.log.open(options.log);
    s.log << "time_s,state,alarm,textured,measured,error_mm,sigma_mm,probability,shift_x_px,shift_y_px"
          << (options.watch.locates_rig ? ",pose_x_mm,pose_y_mm,pose_yaw_deg,pose_x_sigma_mm,pose_y_sigma_mm,"
                                          "pose_yaw_sigma_deg,pose_chi2,pose_refused"
                                        : "")
          << "\n"
          << std::flush;
    if (!s.log)
      throw Error(ErrorKind::kIo, options.log, "it cannot be written",
                  "choose a folder that exists for the record");
  }
  s.status.state = to_string(watch::WatchState::kStarting);
  s.tell("");  // the page shows from the start that the light is watched
  s.thread = std::thread([state = state_.get()] { state->run(); });
}

LightWatch::~LightWatch() {
  state_->ends = true;
  state_->changed.notify_all();
  state_->thread.join();
}

void LightWatch::undo() {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  state_->wish = false;
}

void LightWatch::resume() {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  state_->wish = true;
}

void LightWatch::shown(const std::shared_ptr<const ImageU8>& frame, double light_time,
                       const SolvedSurfaceSet& solved, const Pose& rig_from_projector) {
  State& s = *state_;
  if (!s.wants_frames) return;
  {
    const std::lock_guard<std::mutex> lock(s.mutex);
    if (!s.wants_frames) return;
    if (s.frames.empty()) {
      RigProjector drawn_for = s.options.projector;
      drawn_for.rig_from_projector = rig_from_projector;
      s.surfaces = watch::watched_surfaces(solved, drawn_for);
      if (s.options.watch.locates_rig) {
        s.surfaces.erase(std::remove_if(s.surfaces.begin(), s.surfaces.end(),
                                        [&](const auto& one) { return !is_in_world(solved, one.name); }),
                         s.surfaces.end());
        s.world_from_rig =
            (rig_from_projector * solved.projector_from_world.value_or(Pose())).inverse().normalized();
      }
      s.fixed_to_projector = surface_of_projector(solved);
    }
    s.frames.push_back({frame, light_time});
    if (s.frames.size() < kFramesOfCheck) return;
    s.wants_frames = false;
  }
  s.changed.notify_all();
}

void LightWatch::tell(const track::PoseCorrectionStatus& pose) {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  state_->pose = pose;
}

std::string LightWatch::description() const {
  return state_->description;
}

std::map<std::string, std::uint64_t> LightWatch::rejected() const {
  return state_->rejected.counts();
}

std::optional<LightWatch::News> LightWatch::take() {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  return std::exchange(state_->news, std::nullopt);
}

}  // namespace procam::show
