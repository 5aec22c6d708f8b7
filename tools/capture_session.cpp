// capture-session: shows a pattern on the projector, watches it with a camera, and keeps a session folder.
#include <poll.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>

#include "common/cli.hpp"
#include "procam/io/board_file.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/text.hpp"
#include "procam/session/capture.hpp"
#include "procam/session/coverage.hpp"
#include "procam/session/files.hpp"
#include "procam/session/patterns.hpp"
#include "procam/session/reader.hpp"

namespace procam::tools {
namespace {

namespace fs = std::filesystem;

struct Flags {
  std::string camera;
  fs::path watch;
  device::CameraOptions camera_options;
  std::optional<int> display;
  bool list_displays = false;
  std::string pattern = "gray";
  int step = 1;
  std::optional<Board> board;
  int views = 8;
  double interval_s = 0;  ///< between poses; 0: Enter is waited for
  bool single_shot = false;
  bool despite_checks = false;
  fs::path output;
};

/// "8s", "500ms".
double parse_duration(const std::string& text) {
  double value = 0;
  char unit[3] = "";
  int used = 0;
  if (std::sscanf(text.c_str(), "%lf%2[ms]%n", &value, unit, &used) == 2 &&
      std::size_t(used) == text.size() && value > 0 && value < 1e6) {
    if (std::string(unit) == "s") return value;
    if (std::string(unit) == "ms") return value / 1000;
  }
  throw Error(ErrorKind::kInput, "duration '" + text + "'", "it is no positive time with a unit",
              "give e.g. 8s or 500ms");
}

void declare(CLI::App& app, Flags& flags) {
  auto* camera =
      app.add_option("--camera", flags.camera, "camera that this machine drives: number, device or URL");
  auto* watch =
      app.add_option("--watch", flags.watch, "folder into which a separate camera writes its pictures");
  camera->excludes(watch);
  add_parsed(
      app, "--camera-size",
      [&](const std::string& text) { flags.camera_options.size = io::parse_size(text); },
      "the camera's mode, e.g. 1280x720 (default: the driver's)")
      ->needs(camera);
  app.add_option("--exposure", flags.camera_options.exposure,
                 "exposure in the camera driver's own unit; turns its automatic off")
      ->needs(camera);
  app.add_option("--display", flags.display,
                 "number of the projector's display (default: the one that is not primary)");
  app.add_flag("--list-displays", flags.list_displays, "say which displays there are, and end");
  app.add_option("--pattern", flags.pattern, "What is projected: " + session::pattern_help())
      ->capture_default_str();
  app.add_option("--step", flags.step, "Gray code's stripe width in projector pixels")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  add_parsed(
      app, "--board", [&](const std::string& text) { flags.board = io::read_board(text); },
      "the printed board, e.g. chessboard:7x9:75mm, or a board file");
  app.add_option("--views", flags.views, "poses of the board")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  add_parsed(
      app, "--interval", [&](const std::string& text) { flags.interval_s = parse_duration(text); },
      "time to move the board between poses, e.g. 8s (default: wait for Enter)");
  app.add_flag("--single-shot", flags.single_shot,
               "a camera triggered by hand: one picture a frame is waited for, and no checks are made");
  app.add_flag("--despite-checks", flags.despite_checks, "go on when a check of the light fails");
  app.add_option("-o,--output", flags.output, "session folder; one that is there is gone on with");
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

device::Display choose_display(const std::optional<int>& wanted) {
  const std::vector<device::Display> list = device::displays();
  if (list.empty())
    throw Error(ErrorKind::kDevice, "display", "there is none",
                "connect the projector, and check the graphics driver");
  for (const device::Display& display : list)
    if (wanted ? display.number == *wanted : !display.is_primary) return display;
  if (wanted)
    throw Error(ErrorKind::kDevice, "display " + std::to_string(*wanted), "there is no such display",
                "choose one that --list-displays names");
  return list.front();
}

std::unique_ptr<device::FrameSource> open_source(const Flags& flags) {
  if (!flags.camera.empty()) return device::open_camera(flags.camera, flags.camera_options);
  return device::watch_folder(flags.watch);
}

/// The session while it is captured.
class Capture {
 public:
  Capture(const Flags& flags, Console& console, const session::SessionPattern& pattern, const Board& board,
          device::FrameSink& screen, device::FrameSource& source)
      : flags_(flags),
        console_(console),
        pattern_(pattern),
        board_(board),
        pictures_(pattern.frames()),
        screen_(screen),
        stand_{screen, source, [this] { tick(); }},
        shutter_(stand_, session::ShutterOptions{}),
        projector_(screen.size()) {
    shutter_.options().single_shot = flags.single_shot;
    if (flags.single_shot) shutter_.options().patience_s = 0;  // a person takes the time it takes
  }

  ExitCode run() {
    if (!flags_.single_shot) {
      check();
      if (light_.failed() && !flags_.despite_checks) {
        console_.say("nothing was captured: fix what failed, or go on with --despite-checks");
        return ExitCode::kGateFailed;
      }
    }
    for (int view = 0; view < flags_.views; ++view)
      if (!session::is_complete(flags_.output, std::size_t(view))) capture_view(view);
    // Views of earlier runs, too.
    camera_.reset();
    projector_ = session::Coverage(screen_.size());
    for (int view = 0; view < flags_.views; ++view) {
      console_.progress("coverage", view, flags_.views);
      const fs::path folder = flags_.output / session::numbered("view", std::size_t(view));
      add_coverage(
          read(io::load_capture_folder(folder, pattern_.frame_count()).frames, folder.filename().string()));
    }
    say_coverage();
    console_.summary().set("/views", flags_.views);
    console_.summary().set("/rejected/torn", torn_);
    console_.summary().set("/rejected/stale", stale_);
    console_.say(format("%d views of %d frames: ", flags_.views, pattern_.frame_count()) +
                 flags_.output.string());
    console_.say("next: calibrate-projector --captures " + flags_.output.string() + " -o rig.json");
    return light_.failed() ? ExitCode::kGateFailed : ExitCode::kOk;
  }

 private:
  void tick() {
    console_.progress(doing_, done_, total_);
    switch (screen_.poll()) {
      case device::WindowEvent::kClose:
        throw Error(ErrorKind::kDevice, "window", "it was closed",
                    "run the same command again to go on with the session");
      case device::WindowEvent::kGoOn:
        go_on_ = true;
        break;
      default:
        break;
    }
  }
  void now_doing(const std::string& what, int done, int total) {
    doing_ = what, done_ = done, total_ = total;
    tick();
  }

  /// Delay, then light.
  void check() {
    now_doing("finding the camera's delay", 0, 1);
    const session::Delay delay = session::measure_delay(stand_);
    shutter_.options() = session::shutter_options(delay);
    console_.say(
        format("delay      %.0f ms from showing to seeing, settled after %.0f ms; a frame every %.0f ms",
               1000 * delay.delay_s, 1000 * delay.settled_s, 1000 * delay.frame_interval_s));
    now_doing("checking the light", 0, 1);
    const fs::path folder = session::make_checks_folder(flags_.output);
    const session::LightReport report =
        session::check_light(shutter_, [&](const std::string& name, const ImageU8& frame) {
          io::save_image(folder / (name + ".png"), frame);
          tick();
        });
    light_ = report.diagnostics();
    console_.say(format(
        "exposure   %.0f %% of the camera's image is lit, %.0f grey levels between black and white, %.1f %% "
        "saturated",
        100 * report.exposure.lit_share, report.exposure.contrast, 100 * report.exposure.saturated_share));
    if (report.tone.gamma > 0)
      console_.say(format("tone       gamma %.2f of projector and camera together; drift %.1f %%",
                          report.tone.gamma, 100 * report.tone.drift));
    if (report.native.diagnostics.find("not_checked") == nullptr && report.tone.gamma > 0)
      console_.say(format("pixels     one-pixel squares beat by %.1f %% (scaling or keystone: above %.0f %%)",
                          100 * report.native.beat, 100 * session::NativeCheck::kLargestBeat));
    console_.report(light_);
    Summary& summary = console_.summary();
    summary.set("/delay/delay_ms", 1000 * delay.delay_s);
    summary.set("/delay/settled_ms", 1000 * delay.settled_s);
    summary.set("/delay/frame_interval_ms", 1000 * delay.frame_interval_s);
    summary.set("/light/lit_share", report.exposure.lit_share);
    summary.set("/light/contrast", report.exposure.contrast);
    summary.set("/light/saturated_share", report.exposure.saturated_share);
    summary.set("/light/gamma", report.tone.gamma);
    summary.set("/light/drift", report.tone.drift);
    summary.set("/light/beat", report.native.beat);
    summary.set("/light/noise_at_black", report.noise.at_black);
    summary.set("/light/noise_per_level", report.noise.per_level);
  }

  /// Until its board is found; useless captures are moved away.
  void capture_view(int view) {
    constexpr int kTries = 3;
    session::ViewWriter files(flags_.output, std::size_t(view));
    bool in_place = goes_on(files);
    const std::string name = session::numbered("view", std::size_t(view));
    for (int attempt = 0; attempt < kTries; ++attempt) {
      if (!in_place) wait_for_pose(view);
      in_place = false;
      take_frames(name, files);
      std::vector<ImageU8> frames;
      for (int i = 0; i < files.kept(); ++i) frames.push_back(io::load_image(files.frame_file(i)).image);
      try {
        const session::BoardView seen = read(frames, name);
        if (!seen.detections[session::kCameraDevice].observations.empty()) {
          files.finish();
          add_coverage(seen);
          console_.say(name + format(": %zu board points",
                                     seen.detections[session::kCameraDevice].observations.size()));
          say_coverage();
          return;
        }
        console_.report(seen.detections[session::kCameraDevice].diagnostics);
      } catch (const Error& unreadable) {
        if (unreadable.kind() != ErrorKind::kInput) throw;
        console_.say(name + ": " + unreadable.what());
      }
      console_.say(name +
                   ": the board was not found; its frames are moved away, and the pose is asked for again");
      files.set_aside();
    }
    throw Error(ErrorKind::kNotEnoughData, name,
                "the board was not found in " + std::to_string(kTries) + " poses",
                "check --board, and that the camera sees the whole board lit");
  }

  /// An earlier run's part of a view is of use while the board has not moved since.
  bool goes_on(session::ViewWriter& files) {
    shutter_.forget();
    if (files.kept() == 0) return false;
    if (files.kept() > pattern_.frame_count()) {
      files.set_aside();
      return false;
    }
    if (flags_.single_shot) return true;
    constexpr double kSharesMoved = 0.02;
    const int last = files.kept() - 1;
    const ImageU8 now = shutter_.take(pictures_[std::size_t(last)]).image;
    const ImageU8 then = io::load_image(files.frame_file(last)).image;
    if (now.size() == then.size() &&
        session::compare(now, then, shutter_.options().noise).share <= kSharesMoved) {
      console_.say(
          format("going on after %d frames of an earlier run: the board has not moved", files.kept()));
      return true;
    }
    console_.say(
        format("%d frames of an earlier run are moved away: the board has moved since", files.kept()));
    files.set_aside();
    shutter_.forget();
    return false;
  }

  void take_frames(const std::string& name, session::ViewWriter& files) {
    double unsteady = 0;
    int rejected_of_frame = 0;
    shutter_.on_rejected = [&](const ImageU8& frame, session::Rejected why) {
      const bool torn = why == session::Rejected::kTorn;
      ++(torn ? torn_ : stale_);
      // Light that flickers would fill the disk.
      constexpr int kKeptAFrame = 4;
      if (++rejected_of_frame <= kKeptAFrame) files.keep_rejected(frame, torn ? "torn" : "stale");
    };
    while (files.kept() < pattern_.frame_count()) {
      now_doing(name + " frame", files.kept(), pattern_.frame_count());
      const session::TakenFrame taken = shutter_.take(pictures_[std::size_t(files.kept())]);
      files.keep(taken.image);
      rejected_of_frame = 0;
      if (!taken.steady) unsteady = std::max(unsteady, taken.unsteady);
    }
    shutter_.on_rejected = [](const ImageU8&, session::Rejected) {};
    shutter_.forget();
    if (unsteady > 0) {
      Diagnostics remark;
      remark.warn(
          "unsteady",
          name + format(": frames of one picture differ by up to %.1f grey levels: something moved, or "
                        "the light flickers (expose a multiple of the mains period)",
                        unsteady));
      console_.report(remark);
    }
  }

  /// Shows where the light falls, until the board is in place.
  void wait_for_pose(int view) {
    const bool beside_print = pattern_.on_blank_paper().has_value();
    screen_.show(beside_print ? pictures_.back() : ImageU8(screen_.size(), 1, 255));
    const std::string what =
        format("pose %d of %d: ", view + 1, flags_.views) +
        (beside_print ? "print in the camera's view, light on the blank paper" : "board in the light");
    if (flags_.interval_s > 0) {
      console_.say(what + format(", within %g s", flags_.interval_s));
      const double end = device::now_s() + flags_.interval_s;
      while (device::now_s() < end) {
        now_doing("seconds left", int(end - device::now_s()), int(flags_.interval_s));
        usleep(20000);
      }
      return;
    }
    console_.say(what + ", then press Enter, here or in the projector's window");
    for (go_on_ = false; !go_on_;) {
      now_doing(what + "; views", view, flags_.views);
      pollfd input{STDIN_FILENO, POLLIN, 0};
      if (poll(&input, 1, 50) <= 0) continue;
      char byte = 0;
      const ssize_t count = ::read(STDIN_FILENO, &byte, 1);
      if (count == 0)
        throw Error(ErrorKind::kInput, "standard input", "nobody can press Enter: it has ended",
                    "give --interval 8s for a timer");
      if (count == 1 && byte == '\n') return;
    }
  }

  session::BoardView read(const std::vector<ImageU8>& frames, const std::string& name) const {
    return pattern_.read(name, {frames.begin(), frames.end()}, board_);
  }

  void add_coverage(const session::BoardView& seen) {
    Points2 in_camera, in_projector;
    for (const Observation& point : seen.detections[session::kCameraDevice].observations)
      in_camera.push_back(point.pixel);
    for (const Observation& point : seen.detections[session::kProjectorDevice].observations)
      in_projector.push_back(point.pixel);
    for (const LightPoint& point : seen.light_points) {
      in_camera.push_back(point.camera_pixel);
      in_projector.push_back(point.projector_pixel);
    }
    if (!camera_) camera_ = session::Coverage(seen.detections[session::kCameraDevice].image_size);
    camera_->add(in_camera);
    projector_.add(in_projector);
  }

  void say_coverage() {
    if (!camera_) return;
    io::save_image(flags_.output / "coverage.png", session::draw({&*camera_, &projector_}));
    std::string line = format("coverage   camera %.0f %%, projector %.0f %%", 100 * camera_->share(),
                              100 * projector_.share());
    if (const std::string part = projector_.emptiest_part(); !part.empty())
      line += "; least in the projector's " + part;
    else if (const std::string camera_part = camera_->emptiest_part(); !camera_part.empty())
      line += "; least in the camera's " + camera_part;
    console_.say(line);
    console_.summary().set("/coverage/camera", camera_->share());
    console_.summary().set("/coverage/projector", projector_.share());
  }

  const Flags& flags_;
  Console& console_;
  const session::SessionPattern& pattern_;
  const Board& board_;
  std::vector<ImageU8> pictures_;
  device::FrameSink& screen_;
  session::CaptureRig stand_;
  session::Shutter shutter_;
  Diagnostics light_;
  std::optional<session::Coverage> camera_;
  session::Coverage projector_;
  std::string doing_;
  int done_ = 0, total_ = 1;
  bool go_on_ = false;  ///< asked for in the window
  int torn_ = 0, stale_ = 0;
};

ExitCode capture_session(const Flags& flags, Console& console) {
  if (flags.list_displays) {
    list_displays(console);
    return ExitCode::kOk;
  }
  if (flags.camera.empty() == flags.watch.empty()) throw CLI::RequiredError("--camera or --watch");
  if (!flags.board) throw CLI::RequiredError("--board");
  if (flags.output.empty()) throw CLI::RequiredError("--output");

  const device::Display display = choose_display(flags.display);
  const auto pattern = session::make_pattern(flags.pattern, display.size, flags.step);
  if (pattern->channels() != 1)
    throw Error(
        ErrorKind::kUnsupported, "pattern '" + pattern->text() + "'",
        "pictures are shown and captured in grey here",
        "use the pair of frames (without ':colour'), or show the picture that make-patterns writes and "
        "capture it by other means");
  const io::SessionInfo session = session::describe_session(*pattern, display.size, flags.board, flags.step);
  session::make_folder(flags.output);
  session::require_same_session(flags.output, session);
  pattern->save_files(flags.output);
  io::save_session(flags.output, session);
  console.say("projector  display " + std::to_string(display.number) + " (" + display.name + "), " +
              pattern->describe());
  if (display.largest != display.size) {
    Diagnostics remark;
    remark.warn("smaller_mode", "the display runs at " + io::format_size(display.size) + " and offers " +
                                    io::format_size(display.largest) +
                                    ": if that is the projector's own resolution, run it there");
    console.report(remark);
  }
  console.summary().set("/output", flags.output.string());
  console.summary().set("/pattern", pattern->text());
  console.summary().set("/projector_size", io::format_size(display.size));

  const auto source = open_source(flags);
  const auto screen = device::open_window(display.number);
  if (screen->size() != display.size)
    throw Error(
        ErrorKind::kDevice, "display " + std::to_string(display.number),
        "its window has " + io::format_size(screen->size()) + " pixels, not " + io::format_size(display.size),
        "turn off the desktop's scaling of that display");
  return Capture(flags, console, *pattern, *flags.board, *screen, *source).run();
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
       "calibrate-projector. After Ctrl-C the same command continues.",
       "capture-session --camera 0 --camera-size 1280x720 --board chessboard:7x9:75mm --views 8 -o session"},
      [&](CLI::App& app) { declare(app, flags); },
      [&](Console& console) { return capture_session(flags, console); });
}
