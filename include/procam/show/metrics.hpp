#pragma once
/// What a running show measures of itself: counts, and durations with their percentiles.
#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "procam/core/base/export.hpp"

namespace procam::show {

/// Durations in bins that grow by a twentieth of an octave, from 1 us to 1000 s: percentiles are right to
/// 1.8 %, whatever came, in 5 KB. Shorter ones count as 1 us, longer as 1000 s.
class PROCAM_EXPORT Durations {
 public:
  void add(double seconds);
  std::uint64_t count() const { return count_; }
  double mean() const { return count_ == 0 ? 0 : sum_ / double(count_); }
  double largest() const { return largest_; }
  double sum() const { return sum_; }
  /// The duration that the share `q` (0..1) of all does not exceed; 0 without any.
  double quantile(double q) const;

 private:
  static constexpr int kAnOctave = 20, kBins = 30 * kAnOctave;
  std::array<std::uint64_t, kBins> bins_ = {};
  std::uint64_t count_ = 0;
  double sum_ = 0, largest_ = 0;
};

/// Where the light is, by a camera that watches it (docs/watch.md).
struct WatchStatus {
  std::string state;     ///< "ok", "moved", "no_texture" ...: watch::to_string(); or "no_images"
  std::string sentence;  ///< for people
  bool is_alarm = false;
  std::uint64_t checks = 0, alarms = 0, corrections = 0, faults = 0;
  bool corrects = false;                    ///< what is found is corrected, not only reported
  bool is_corrected = false;                ///< the projector does not stand where the rig file has it
  double error_mm = 0, error_sigma_mm = 0;  ///< of the last window, RMS on the surfaces
  double probability = 1;                   ///< of such shifts without a movement
  int textured = 0, measured = 0;           ///< cells of the last image
  double window_time = 0;                   ///< end of the last window, clock of device::now_s()
  std::vector<double> history_mm;           ///< errors of the last windows, oldest first
  // Of the localiser, as the last image that corrected its pose found it (track/pose_correction.hpp).
  bool corrects_pose = false;
  double pose_off_mm = 0, pose_off_deg = 0;  ///< along the floor, and about the world's z axis
  double pose_sigma_mm = 0;  ///< largest standard deviation of the corrected pose along the floor
  std::uint64_t pose_images = 0,
                pose_refused = 0;  ///< that corrected; that contradict the pose beyond its stated error
};

/// A surface that moves on its own and is tracked by its markers (docs/tracked-surfaces.md).
struct MovingMetrics {
  std::string surface;
  std::string state = "none";   ///< "none": never seen; "fresh", "stale": track::to_string()
  bool is_dark = true;          ///< in the last frame, since it is not seen
  std::uint64_t sightings = 0;  ///< images with its pose
  std::uint64_t refused = 0;    ///< images with markers of it and without a pose
  std::string refusal;          ///< why, of the last one
  std::uint64_t losses = 0;     ///< times that it was not seen for too long
  double lost_s = 0;            ///< in all
  double age_s = 0;             ///< from its last pose to the light of the last frame
  double error_mm = 0;          ///< of the light on it in the last frame, RMS, as its covariance predicts
};

/// Of a show that several hosts show (docs/live.md).
struct GroupMetrics {
  bool leads = false;
  std::string leader;           ///< host and process; empty: none is known
  int hosts = 1;                ///< with this one
  double clock_error_s = 0;     ///< bound of the error of content time, against the leader's
  std::uint64_t takeovers = 0;  ///< leaders that followed another one
  double last_takeover_s = 0;   ///< in which nobody led
  std::uint64_t rejected = 0;   ///< invalid messages
  std::size_t waiting = 0;      ///< requests of this host that the leader has not taken
};

/// Of a robot in a fleet (docs/live.md).
struct FleetMetrics {
  int robots = 1;                                      ///< with this one
  std::map<std::string, std::vector<std::string>> by;  ///< surface: the robots that light it
  int lit = 0;                                         ///< surfaces that this robot lights
  std::uint64_t turns = 0;                             ///< times that this robot began to light a surface
  double last_wait_s = 0;                              ///< from the request to the last grant, the last time
  std::uint64_t rejected = 0;                          ///< announcements that were invalid or too large
  bool is_superseded = false;    ///< a robot of the same name was started later: this one is dark
  double largest_latency_s = 0;  ///< from a grant to the light, of all robots
};

/// Of a show that blends with other projectors (docs/live.md).
struct BlendMetrics {
  std::vector<std::string> projectors;  ///< that the frames are blended for, this one among them
  bool is_dark = false;                 ///< this projector waits for its turn to light
  std::uint64_t changes = 0;            ///< of the maps that frames are drawn with
  double last_change_s =
      0;  ///< from a change of surfaces or projectors to the frame that follows it, the last time
};

struct Metrics {
  std::uint64_t frames = 0;          ///< shown
  std::uint64_t dropped = 0;         ///< whose time passed while another was drawn
  std::uint64_t blanked = 0;         ///< shown black because the pose was stale
  std::uint64_t waiting = 0;         ///< in which surfaces in the world were dark because no pose had come
  std::uint64_t checked = 0;         ///< frames, one a second, that were looked at while surfaces were placed
  std::uint64_t dark = 0;            ///< of these, without any light
  std::uint64_t reloads = 0;         ///< of the surfaces file that succeeded
  std::uint64_t failed_reloads = 0;  ///< of a file that cannot be read, or whose surfaces cannot be shown
  std::uint64_t poses = 0;           ///< arrived, good ones
  std::uint64_t malformed = 0;       ///< messages that were none
  Durations draw;                    ///< from the last look at the sources to the frame ready
  Durations render;                  ///< of that, the renderer
  Durations jitter;                  ///< between two frames' begins, from what it should be
  Durations pose_age;  ///< of frames that are not black: from the moment that the newest pose speaks of to
                       ///< the light of the frame
  Durations
      pose_to_frame;  ///< from a pose's arrival to the first frame with it ready, less that frame's render
  /// What failed while the show went on, by name: "blend", "command", "content", "control_page", "depth", "fleet", "frame", "group", "group_pose", "people"
  /// and "people_..." (messages), "page_connection" (closed for others), "page_refused", "page_request", "pose_source",
  /// "record", "reload", "room", "save", "surfaces", "track", "watch", and what a source rejected by its cause
  /// ("ros2_oversized").
  std::map<std::string, std::uint64_t> faults;
  std::optional<WatchStatus> watch;
  std::vector<MovingMetrics> moving;
  std::optional<GroupMetrics> group;
  std::optional<FleetMetrics> fleet;
  std::optional<BlendMetrics> blend;
  std::uint64_t contents_stopped = 0;  ///< now: contents that give no new images and show their last one
};

}  // namespace procam::show
