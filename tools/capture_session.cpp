// capture-session: shows a pattern on the projector, watches it with a camera, and keeps a session folder.
#include <poll.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <filesystem>

#include "common/cli.hpp"
#include "procam/io/board_file.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/text.hpp"
#include "procam/session/files.hpp"
#include "procam/session/patterns.hpp"
#include "procam/session/recorder.hpp"

namespace procam::tools {
namespace {

namespace fs = std::filesystem;

struct Flags {
  std::string camera;
  fs::path watch;
  device::CameraOptions camera_options;
  std::optional<std::string> display;
  bool list_displays = false;
  std::string pattern = "gray";
  int step = 1;
  std::optional<Board> board;
  std::optional<int> views;
  session::RecorderOptions recorder;
};

void declare(CLI::App& app, Flags& flags) {
  auto* camera =
      app.add_option("--camera", flags.camera, "Camera: its number, device or URL, or ros2:/TOPIC");
  auto* watch =
      app.add_option("--watch", flags.watch, "Folder into which a separate camera writes its images");
  camera->excludes(watch);
  add_parsed(
      app, "--camera-size",
      [&](const std::string& text) { flags.camera_options.size = io::parse_size(text); },
      "Image size of the camera, e.g. 1280x720 (default: the driver's)")
      ->needs(camera);
  app.add_option("--exposure", flags.camera_options.exposure,
                 "Exposure in the unit of the camera driver; switches automatic exposure off")
      ->needs(camera);
  app.add_option("--display", flags.display,
                 "Display of the projector: number, name or a part of it, or position on the desktop such as "
                 "1920,0 (default: the display that is not primary)");
  app.add_flag("--list-displays", flags.list_displays, "List the displays and end");
  app.add_option("--pattern", flags.pattern, "What is projected: " + session::pattern_help())
      ->capture_default_str();
  app.add_option("--step", flags.step, "Stripe width of Gray code in projector pixels")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  add_parsed(
      app, "--board", [&](const std::string& text) { flags.board = io::read_board(text); },
      "The printed board, e.g. charuco:5x7:34mm:25mm:5x5_100, or a board file (without one: a room for "
      "calibrate-room and scan-surfaces)");
  app.add_option(
         "--views", flags.views,
         "Number of poses of the board (default 8), or without a board of places of the camera (default 2)")
      ->check(CLI::Range(1, 1000));
  add_parsed(
      app, "--interval",
      [&](const std::string& text) {
        if (!((flags.recorder.interval_s = io::parse_duration(text)) > 0))
          throw Error(ErrorKind::kInput, "--interval " + text, "a time must be positive", "give e.g. 8s");
      },
      "Time to move the board, or the camera, between views, e.g. 8s (default: wait for Enter)");
  app.add_flag("--single-shot", flags.recorder.single_shot,
               "For a camera that is triggered by hand: one image for each frame, without checks");
  app.add_flag("--despite-checks", flags.recorder.despite_checks, "Continue when a check of the light fails");
  app.add_option("-o,--output", flags.recorder.folder, "Session folder; an existing session is continued");
}

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

void summarize(const session::RecorderReport& report, int views, Summary& summary) {
  if (report.delay) {
    summary.set("/delay/delay_ms", 1000 * report.delay->delay_s);
    summary.set("/delay/settled_ms", 1000 * report.delay->settled_s);
    summary.set("/delay/frame_interval_ms", 1000 * report.delay->frame_interval_s);
  }
  if (const auto& light = report.light) {
    summary.set("/light/lit_share", light->exposure.lit_share);
    summary.set("/light/contrast", light->exposure.contrast);
    summary.set("/light/saturated_share", light->exposure.saturated_share);
    summary.set("/light/gamma", light->tone.gamma);
    summary.set("/light/drift", light->tone.drift);
    summary.set("/light/beat", light->native.beat);
    summary.set("/light/noise_at_black", light->noise.at_black);
    summary.set("/light/noise_per_level", light->noise.per_level);
  }
  if (!report.captured) return;
  summary.set("/coverage/camera", report.camera_coverage);
  summary.set("/coverage/projector", report.projector_coverage);
  summary.set("/views", views);
  summary.set("/rejected/torn", report.torn);
  summary.set("/rejected/stale", report.stale);
}

ExitCode capture_session(Flags& flags, Console& console) {
  if (flags.list_displays) {
    list_displays(console);
    return ExitCode::kOk;
  }
  if (flags.camera.empty() == flags.watch.empty()) throw CLI::RequiredError("--camera or --watch");
  flags.recorder.views = flags.views.value_or(flags.board ? 8 : 2);
  if (flags.recorder.folder.empty()) throw CLI::RequiredError("--output");

  const device::Display display = device::choose_display(device::displays(), flags.display);
  const auto pattern = session::make_pattern(flags.pattern, display.size, flags.step);
  if (pattern->channels() != 1)
    throw Error(
        ErrorKind::kUnsupported, "pattern '" + pattern->text() + "'",
        "pictures are shown and captured in grey here",
        "use the pair of frames (without ':colour'), or show the picture that make-patterns writes and "
        "capture it by other means");
  const io::SessionInfo session = session::describe_session(*pattern, display.size, flags.board, flags.step);
  session::make_folder(flags.recorder.folder);
  session::require_same_session(flags.recorder.folder, session);
  pattern->save_files(flags.recorder.folder);
  io::save_session(flags.recorder.folder, session);
  console.say("projector  display " + std::to_string(display.number) + " (" + display.name + "), " +
              pattern->describe());
  if (display.largest != display.size) {
    Diagnostics remark;
    remark.warn("smaller_mode", "the display runs at " + io::format_size(display.size) + " and offers " +
                                    io::format_size(display.largest) +
                                    ": if that is the projector's own resolution, run it there");
    console.report(remark);
  }
  Summary& summary = console.summary();
  summary.set("/output", flags.recorder.folder.string());
  summary.set("/pattern", pattern->text());
  summary.set("/projector_size", io::format_size(display.size));

  const auto source = device::open_camera(
      flags.watch.empty() ? flags.camera : "watch:" + flags.watch.string(), flags.camera_options);
  if (const std::string opened = source->description(); !opened.empty()) console.say("camera     " + opened);
  const auto screen = device::open_window(display.number);
  Terminal terminal(console);
  const session::RecorderReport report =
      session::record_session(*pattern, flags.board, *screen, *source, flags.recorder, terminal);
  summarize(report, flags.recorder.views, summary);
  return report.light_failed ? ExitCode::kGateFailed : ExitCode::kOk;
}

}  // namespace
}  // namespace procam::tools

int main(int argc, char** argv) {
  using namespace procam::tools;
  Flags flags;
  return run_tool(
      argc, argv,
      {"capture-session",
       "Shows a pattern full-screen on a projector, captures it with a camera, and writes a session for "
       "calibrate-projector, or without a board for calibrate-room and scan-surfaces. After Ctrl-C the same "
       "command continues."},
      [&](CLI::App& app) { declare(app, flags); },
      [&](Console& console) { return capture_session(flags, console); });
}
