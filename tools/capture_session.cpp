// capture-session: shows patterns on projectors, watches them with cameras, and keeps a session folder.
#include <poll.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "common/capture_flags.hpp"
#include "common/cli.hpp"
#include "procam/dds/security.hpp"
#include "procam/io/text.hpp"
#include "procam/session/patterns.hpp"
#include "procam/session/recorder.hpp"

namespace procam::tools {
namespace {

void list_displays(Console& console) {
  std::vector<std::string> names;
  for (const device::Display& display : device::displays()) {
    names.push_back(format("%d: %s, %dx%d at %.0f Hz%s", display.number, display.name.c_str(),
                           display.size.width, display.size.height, display.refresh_hz,
                           display.is_primary ? ", primary" : ""));
    console.say("display " + names.back());
  }
  if (names.empty()) console.say("no display");
  console.summary().set("/displays", names);
}

/// The terminal, and the keyboard where poses are not timed.
class Terminal : public session::RecorderDialog {
 public:
  explicit Terminal(Console& console) : console_(console) {}
  void progress(const std::string& doing, int done, int total) override {
    console_.progress(doing, done, total);
  }
  void say(const std::string& line) override { console_.say(line); }
  void report(const Diagnostics& remarks) override { console_.report(remarks); }
  bool wants_to_go_on() override {
    pollfd input{STDIN_FILENO, POLLIN, 0};
    if (poll(&input, 1, 50) <= 0) return false;
    char byte = 0;
    const ssize_t count = ::read(STDIN_FILENO, &byte, 1);
    if (count == 0)
      throw Error(ErrorKind::kInput, "standard input", "nobody can press Enter: it has ended",
                  "give --interval 8s for a timer");
    return count == 1 && byte == '\n';
  }

 private:
  Console& console_;
};

void summarize(const session::RecordedPair& pair, const std::string& key, Summary& summary) {
  if (pair.delay) {
    summary.set(key + "/delay/delay_ms", 1000 * pair.delay->delay_s);
    summary.set(key + "/delay/settled_ms", 1000 * pair.delay->settled_s);
    summary.set(key + "/delay/frame_interval_ms", 1000 * pair.delay->frame_interval_s);
  }
  if (const auto& light = pair.light) {
    summary.set(key + "/light/lit_share", light->exposure.lit_share);
    summary.set(key + "/light/contrast", light->exposure.contrast);
    summary.set(key + "/light/saturated_share", light->exposure.saturated_share);
    summary.set(key + "/light/gamma", light->tone.gamma);
    summary.set(key + "/light/drift", light->tone.drift);
    summary.set(key + "/light/beat", light->native.beat);
    summary.set(key + "/light/noise_at_black", light->noise.at_black);
    summary.set(key + "/light/noise_per_level", light->noise.per_level);
  }
}

void summarize(const session::RecorderReport& report, const session::RecorderDevices& devices, int views,
               Summary& summary) {
  const bool one = report.pairs.size() == 1;
  for (std::size_t i = 0; i < report.pairs.size(); ++i) {
    const std::string key = one ? "" : "/pairs/" + std::to_string(i);
    summarize(report.pairs[i], key, summary);
    if (one) continue;
    if (devices.projectors.size() > 1) summary.set(key + "/projector", report.pairs[i].projector);
    if (devices.cameras.size() > 1) summary.set(key + "/camera", report.pairs[i].camera);
    summary.set(key + "/seen", report.pairs[i].seen);
  }
  if (!report.captured) return;
  const auto set_share = [&](const std::string& name, const char* kind, double share) {
    summary.set("/coverage/" + (name.empty() ? kind : name), share);
  };
  for (std::size_t i = 0; i < devices.cameras.size(); ++i)
    set_share(devices.cameras[i].name, "camera", report.camera_coverage[i]);
  for (std::size_t i = 0; i < devices.projectors.size(); ++i)
    set_share(devices.projectors[i].name, "projector", report.projector_coverage[i]);
  summary.set("/views", views);
  summary.set("/rejected/torn", report.torn);
  summary.set("/rejected/stale", report.stale);
}

/// A projector, and what it shows where.
struct OpenProjector {
  std::string name;
  device::Display display;
  std::unique_ptr<session::SessionPattern> pattern;
  std::unique_ptr<device::FrameSink> screen;
};

OpenProjector open_projector(const std::string& name, const std::optional<std::string>& place,
                             const CaptureFlags& flags, Console& console) {
  OpenProjector projector{name, device::choose_display(device::displays(), place), nullptr, nullptr};
  const device::Display& display = projector.display;
  projector.pattern = session::make_pattern(flags.pattern, display.size, flags.recorder.step);
  if (projector.pattern->channels() != 1)
    throw Error(ErrorKind::kUnsupported, "pattern '" + projector.pattern->text() + "'",
                "frames are shown and captured in grey here",
                "use the pair of frames (without ':colour'), or show the frame that make-patterns writes and "
                "capture it by other means");
  console.say("projector  " + (name.empty() ? "" : name + ": ") + "display " +
              std::to_string(display.number) + " (" + display.name + "), " + projector.pattern->describe());
  if (display.largest != display.size) {
    Diagnostics remark;
    remark.warn("smaller_mode", "the display runs at " + io::format_size(display.size) + " and offers " +
                                    io::format_size(display.largest) +
                                    ": if that is the projector's own resolution, run it there");
    console.report(remark);
  }
  return projector;
}

std::vector<OpenProjector> open_projectors(const CaptureFlags& flags, Console& console) {
  std::vector<OpenProjector> projectors;
  if (flags.displays.empty()) projectors.push_back(open_projector("", {}, flags, console));
  for (const auto& [name, place] : named_places("--display", flags.displays)) {
    projectors.push_back(open_projector(name, place, flags, console));
    for (std::size_t i = 0; i + 1 < projectors.size(); ++i)
      if (projectors[i].display.number == projectors.back().display.number)
        throw Error(ErrorKind::kInput, "--display " + name + "=" + place,
                    "it is the display of projector '" + projectors[i].name + "', too",
                    "give each projector a display of its own (--list-displays)");
  }
  return projectors;
}

ExitCode capture_session(CaptureFlags& flags, Console& console) {
  if (flags.list_displays) {
    list_displays(console);
    return ExitCode::kOk;
  }
  if (flags.cameras.empty() == flags.watch.empty()) throw CLI::RequiredError("--camera or --watch");
  flags.recorder.views = flags.views.value_or(default_views(flags));
  if (flags.recorder.folder.empty()) throw CLI::RequiredError("--output");

  if (!flags.dds_security.empty()) dds::use_security(flags.dds_security);
  std::vector<OpenProjector> projectors = open_projectors(flags, console);
  Summary& summary = console.summary();
  summary.set("/output", flags.recorder.folder.string());
  summary.set("/pattern", projectors[0].pattern->text());
  for (const OpenProjector& projector : projectors)
    summary.set("/projector_size" + (projector.name.empty() ? "" : "/" + projector.name),
                io::format_size(projector.display.size));

  std::vector<std::unique_ptr<device::FrameSource>> sources;
  session::RecorderDevices devices;
  if (!flags.watch.empty()) flags.cameras = {"watch:" + flags.watch.string()};
  for (const auto& [name, place] : named_places("--camera", flags.cameras)) {
    sources.push_back(device::open_camera(place, flags.camera_options));
    if (const std::string opened = sources.back()->description(); !opened.empty())
      console.say("camera     " + (name.empty() ? "" : name + ": ") + opened);
    devices.cameras.push_back({name, *sources.back()});
  }
  for (OpenProjector& projector : projectors) {
    projector.screen = device::open_window(projector.display.number);
    devices.projectors.push_back({projector.name, *projector.pattern, *projector.screen});
  }
  Terminal terminal(console);
  const session::RecorderReport report =
      session::record_session(devices, flags.board, flags.recorder, terminal);
  summarize(report, devices, flags.recorder.views, summary);
  return report.light_failed ? ExitCode::kGateFailed : ExitCode::kOk;
}

}  // namespace
}  // namespace procam::tools

int main(int argc, char** argv) {
  using namespace procam::tools;
  CaptureFlags flags;
  return run_tool(
      argc, argv,
      {"capture-session",
       "Shows a pattern full-screen on a projector, captures it with a camera, and writes a session for "
       "calibrate-projector, or without a board for calibrate-room and scan-surfaces. Several projectors show it one "
       "after the other, and all cameras watch. After Ctrl-C the same command continues."},
      [&](CLI::App& app) { declare_capture(app, flags); },
      [&](Console& console) { return capture_session(flags, console); });
}
