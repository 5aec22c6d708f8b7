#include "procam/show/metrics.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "prometheus.hpp"

namespace procam::show {
namespace {

constexpr double kShortest = 1e-6;

void write(std::string& text, const char* name, const char* help, std::uint64_t count) {
  char line[256];
  std::snprintf(line, sizeof line, "# HELP procam_%s %s\n# TYPE procam_%s counter\nprocam_%s %llu\n", name,
                help, name, name, static_cast<unsigned long long>(count));
  text += line;
}

void write(std::string& text, const char* name, const char* help, const Durations& durations) {
  char line[256];
  std::snprintf(line, sizeof line, "# HELP procam_%s_seconds %s\n# TYPE procam_%s_seconds summary\n", name,
                help, name);
  text += line;
  for (const double q : {0.5, 0.9, 0.99}) {
    std::snprintf(line, sizeof line, "procam_%s_seconds{quantile=\"%g\"} %.6g\n", name, q,
                  durations.quantile(q));
    text += line;
  }
  std::snprintf(line, sizeof line, "procam_%s_seconds_sum %.9g\nprocam_%s_seconds_count %llu\n", name,
                durations.sum(), name, static_cast<unsigned long long>(durations.count()));
  text += line;
}

/// The metric procam_PART_NAME.
void write(std::string& text, const std::string& part, const char* name, const char* kind, const char* help,
           double value) {
  const std::string metric = "procam_" + part + "_" + name;
  char line[64];
  std::snprintf(line, sizeof line, " %.9g\n", value);
  text += "# HELP " + metric + " " + help + "\n# TYPE " + metric + " " + kind + "\n" + metric + line;
}

void write(std::string& text, const WatchStatus& watch) {
  const auto add = [&](const char* name, const char* kind, const char* help, double value) {
    write(text, "watch", name, kind, help, value);
  };
  add("checks_total", "counter", "Camera images that were compared with the frame.", double(watch.checks));
  add("alarms_total", "counter", "Times that the light was found to be off.", double(watch.alarms));
  add("corrections_total", "counter", "Corrections of the projector's pose.", double(watch.corrections));
  add("alarm", "gauge", "1 while the light is off.", watch.is_alarm ? 1 : 0);
  add("error_metres", "gauge", "Error of the light on the surfaces, RMS.", 1e-3 * watch.error_mm);
  add("error_sigma_metres", "gauge", "Its standard deviation.", 1e-3 * watch.error_sigma_mm);
  if (watch.corrects_pose) {
    add("pose_off_metres", "gauge", "Error of the localiser's pose along the floor.",
        1e-3 * watch.pose_off_mm);
    add("pose_sigma_metres", "gauge", "Standard deviation of the corrected pose.",
        1e-3 * watch.pose_sigma_mm);
    add("pose_images_total", "counter", "Images that corrected the pose.", double(watch.pose_images));
    add("pose_refused_total", "counter", "Images that contradict the pose.", double(watch.pose_refused));
  }
  text +=
      "# HELP procam_watch_state What the camera sees.\n# TYPE procam_watch_state gauge\nprocam_watch_state{state=\"" +
      watch.state + "\"} 1\n";
}

void write(std::string& text, const GroupMetrics& group) {
  const auto add = [&](const char* name, const char* kind, const char* help, double value) {
    write(text, "group", name, kind, help, value);
  };
  add("hosts", "gauge", "Hosts of the group, with this one.", group.hosts);
  add("leads", "gauge", "1 while this host leads.", group.leads ? 1 : 0);
  add("clock_error_seconds", "gauge", "Bound of the error of content time, against the leader's.",
      group.clock_error_s);
  add("takeovers_total", "counter", "Leaders that followed another one.", double(group.takeovers));
  add("rejected_total", "counter", "Invalid messages of the group.", double(group.rejected));
  add("requests_waiting", "gauge", "Requests that the leader has not taken.", double(group.waiting));
}

/// As a label's value is written.
std::string escaped(const std::string& text) {
  std::string written;
  for (const char c : text) {
    if (c == '\\' || c == '"') written += '\\';
    written += c == '\n' ? std::string("\\n") : std::string(1, c);
  }
  return written;
}

void write(std::string& text, const FleetMetrics& fleet) {
  const auto add = [&](const char* name, const char* kind, const char* help, double value) {
    write(text, "fleet", name, kind, help, value);
  };
  add("robots", "gauge", "Robots of the fleet, with this one.", fleet.robots);
  add("lit", "gauge", "Surfaces that this robot lights.", fleet.lit);
  add("turns_total", "counter", "Times that this robot began to light a surface.", double(fleet.turns));
  add("last_wait_seconds", "gauge", "From the request to the last grant, the last time.", fleet.last_wait_s);
  add("latency_seconds", "gauge", "From a grant to the light, the largest of all robots.",
      fleet.largest_latency_s);
  add("rejected_total", "counter", "Announcements that were invalid or too large.", double(fleet.rejected));
  add("superseded", "gauge", "1 while a robot of the same name, started later, lights instead.",
      fleet.is_superseded ? 1 : 0);
  text +=
      "# HELP procam_fleet_surface Which robots light which surface.\n# TYPE procam_fleet_surface gauge\n";
  for (const auto& [surface, robots] : fleet.by)
    for (const std::string& robot : robots)
      text += "procam_fleet_surface{surface=\"" + escaped(surface) + "\",robot=\"" + robot + "\"} 1\n";
}

void write(std::string& text, const std::vector<MovingMetrics>& moving) {
  const auto add = [&](const char* name, const char* kind, const char* help,
                       double (*value)(const MovingMetrics&)) {
    const std::string metric = std::string("procam_tracked_") + name;
    text += "# HELP " + metric + " " + help + "\n# TYPE " + metric + " " + kind + "\n";
    for (const MovingMetrics& one : moving) {
      char number[64];
      std::snprintf(number, sizeof number, "\"} %.9g\n", value(one));
      text += metric + "{surface=\"" + escaped(one.surface) + number;
    }
  };
  add("sightings_total", "counter", "Camera images that gave the surface's pose.",
      [](const MovingMetrics& one) { return double(one.sightings); });
  add("refused_total", "counter", "Camera images with markers of the surface that gave no pose.",
      [](const MovingMetrics& one) { return double(one.refused); });
  add("losses_total", "counter", "Times that the surface was not seen for too long.",
      [](const MovingMetrics& one) { return double(one.losses); });
  add("lost_seconds_total", "counter", "Time in which it was not seen.",
      [](const MovingMetrics& one) { return one.lost_s; });
  add("fresh", "gauge", "1 while the surface's pose is fresh.",
      [](const MovingMetrics& one) { return one.state == "fresh" ? 1.0 : 0.0; });
  add("age_seconds", "gauge", "From its last pose to the light.",
      [](const MovingMetrics& one) { return one.age_s; });
  add("error_metres", "gauge", "Error of the light on it, RMS, as its covariance predicts.",
      [](const MovingMetrics& one) { return 1e-3 * one.error_mm; });
}

void write(std::string& text, const BlendMetrics& blend) {
  const auto add = [&](const char* name, const char* kind, const char* help, double value) {
    write(text, "blend", name, kind, help, value);
  };
  add("dark", "gauge", "1 while this projector waits for its turn to light.", blend.is_dark ? 1 : 0);
  add("changes_total", "counter", "Changes of the maps that frames are drawn with.", double(blend.changes));
  add("last_change_seconds", "gauge", "From a change to the frame that follows it, the last time.",
      blend.last_change_s);
  text +=
      "# HELP procam_blend_projector The projectors that frames are blended for.\n"
      "# TYPE procam_blend_projector gauge\n";
  for (const std::string& projector : blend.projectors)
    text += "procam_blend_projector{projector=\"" + escaped(projector) + "\"} 1\n";
}

}  // namespace

void Durations::add(double seconds) {
  if (!(seconds >= 0)) seconds = 0;
  const double octaves = std::log2(std::max(seconds, kShortest) / kShortest);
  ++bins_[std::size_t(std::min(kBins - 1, int(octaves * kAnOctave)))];
  ++count_;
  sum_ += seconds;
  largest_ = std::max(largest_, seconds);
}

double Durations::quantile(double q) const {
  if (count_ == 0 || q >= 1) return largest_;
  const auto rank = std::uint64_t(std::ceil(std::clamp(q, 0.0, 1.0) * double(count_)));
  std::uint64_t seen = 0;
  for (int bin = 0; bin < kBins; ++bin) {
    seen += bins_[std::size_t(bin)];
    // The bin's middle; no more than has been seen at all.
    if (seen >= rank && seen > 0) return std::min(largest_, kShortest * std::exp2((bin + 0.5) / kAnOctave));
  }
  return largest_;
}

std::string to_prometheus(const Metrics& m, const track::Faults& poses) {
  std::string text;
  write(text, "frames_total", "Frames shown.", m.frames);
  write(text, "frames_dropped_total", "Frames whose time passed while another was drawn.", m.dropped);
  write(text, "frames_blanked_total", "Frames shown black because the pose was stale.", m.blanked);
  write(text, "reloads_total", "Times the surfaces file was read anew.", m.reloads);
  write(text, "reloads_failed_total", "Times the surfaces file could not be used.", m.failed_reloads);
  write(text, "frames_waiting_total", "Frames in which surfaces were dark because no pose had come.",
        m.waiting);
  write(text, "poses_total", "Good pose messages.", m.poses);
  write(text, "poses_malformed_total", "Messages that were no pose.", m.malformed);
  text +=
      "# HELP procam_contents_stopped Contents that show their last image at present.\n"
      "# TYPE procam_contents_stopped gauge\nprocam_contents_stopped " +
      std::to_string(m.contents_stopped) + "\n";
  text +=
      "# HELP procam_faults_total What failed while the show went on.\n# TYPE procam_faults_total counter\n";
  for (const auto& [name, count] : m.faults)
    text += "procam_faults_total{name=\"" + name + "\"} " + std::to_string(count) + "\n";
  text +=
      "# HELP procam_pose_faults_total Good messages that were not simply taken, and events of the poses.\n"
      "# TYPE procam_pose_faults_total counter\n";
  for (const auto& [name, count] : named_counts(poses)) {
    if (name == std::string("taken")) continue;
    text += "procam_pose_faults_total{name=\"" + std::string(name) + "\"} " + std::to_string(count) + "\n";
  }
  if (m.watch) write(text, *m.watch);
  if (!m.moving.empty()) write(text, m.moving);
  if (m.group) write(text, *m.group);
  if (m.fleet) write(text, *m.fleet);
  if (m.blend) write(text, *m.blend);
  write(text, "draw", "From the last look at the pose sources to the frame ready.", m.draw);
  write(text, "render", "The renderer's part of it.", m.render);
  write(text, "frame_jitter", "Between the begins of two frames, from what it should be.", m.jitter);
  write(text, "pose_age", "From the moment the newest pose speaks of to the light.", m.pose_age);
  write(text, "pose_to_frame", "From a pose's arrival to the first frame with it, less the renderer's part.",
        m.pose_to_frame);
  return text;
}

}  // namespace procam::show
