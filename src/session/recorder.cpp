#include "procam/session/recorder.hpp"
#include "procam/core/base/words.hpp"

#include <algorithm>
#include <chrono>
#include <cstdarg>
#include <cstdio>
#include <thread>
#include <utility>
#include <vector>

#include "procam/core/base/clock.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/session/captures.hpp"
#include "procam/io/text.hpp"
#include "procam/session/coverage.hpp"
#include "procam/session/files.hpp"
#include "procam/session/reader.hpp"

namespace procam::session {
namespace {

namespace fs = std::filesystem;

/// Below this share of the camera's pixels the light of a view without a board counts as not seen.
constexpr double kMinLitShare = 0.02;

/// What one view's frames show.
struct Seen {
  ImageSize camera_size;
  Points2 in_camera, in_projector;  ///< board points and light points; without a board every decoded pixel
  std::string found;                ///< for people: "24 board points"; empty: the view is of no use
  Diagnostics why_not;
};

Seen see_board(const BoardView& view) {
  const Detections& camera = view.detections[kCameraDevice];
  Seen seen;
  seen.camera_size = camera.image_size;
  seen.why_not = camera.diagnostics;
  for (const Observation& point : camera.observations) seen.in_camera.push_back(point.pixel);
  for (const Observation& point : view.detections[kProjectorDevice].observations)
    seen.in_projector.push_back(point.pixel);
  for (const LightPoint& point : view.light_points) {
    seen.in_camera.push_back(point.camera_pixel);
    seen.in_projector.push_back(point.projector_pixel);
  }
  if (!camera.observations.empty()) seen.found = format("%zu board points", camera.observations.size());
  return seen;
}

Seen see_light(const LightMap& light) {
  Seen seen;
  seen.camera_size = light.camera_size();
  seen.why_not = light.diagnostics;
  for (int y = 0; y < seen.camera_size.height; ++y)
    for (int x = 0; x < seen.camera_size.width; ++x)
      if (const std::optional<Vec2> pixel = light.projector_pixel(x, y)) {
        seen.in_camera.emplace_back(x, y);
        seen.in_projector.push_back(*pixel);
      }
  const double share =
      double(seen.in_camera.size()) / (double(seen.camera_size.width) * seen.camera_size.height);
  if (share >= kMinLitShare) seen.found = format("light in %.0f %% of the camera's image", 100 * share);
  return seen;
}

/// The session while it is captured.
class Recorder {
 public:
  Recorder(const SessionPattern& pattern, const std::optional<Board>& board, device::FrameSink& screen,
           device::FrameSource& source, const RecorderOptions& options, RecorderDialog& dialog)
      : options_(options),
        dialog_(dialog),
        pattern_(pattern),
        board_(board),
        pictures_(pattern.frames()),
        screen_(screen),
        stand_{screen, source, [this] { tick(); }},
        shutter_(stand_, ShutterOptions{}),
        projector_(screen.size()) {
    shutter_.options().single_shot = options.single_shot;
    if (options.single_shot) shutter_.options().patience_s = 0;  // a person takes the time it takes
  }

  RecorderReport run() {
    if (screen_.size() != pictures_[0].size())
      throw Error(ErrorKind::kDevice, "window",
                  "it has " + io::format_size(screen_.size()) + " pixels, and the pattern " +
                      io::format_size(pictures_[0].size()),
                  "turn off the desktop's scaling of that display");
    if (options_.checked) {
      shutter_.options() = *options_.checked;
    } else if (!options_.single_shot) {
      check();
      if (light_.failed() && !options_.despite_checks) {
        dialog_.say("nothing was captured: fix what failed, or go on with --despite-checks");
        return report_;
      }
    }
    for (int view = 0; view < options_.views; ++view)
      if (!is_complete(options_.folder, std::size_t(view))) capture_view(view);
    // Views of earlier runs, too.
    camera_.reset();
    projector_ = Coverage(screen_.size());
    for (int view = 0; view < options_.views; ++view) {
      dialog_.progress("coverage", view, options_.views);
      const fs::path folder = options_.folder / numbered("view", std::size_t(view));
      add_coverage(
          read(io::load_capture_folder(folder, pattern_.frame_count()).frames, folder.filename().string()));
    }
    say_coverage();
    dialog_.say(format("%d views of %d frames: ", options_.views, pattern_.frame_count()) +
                options_.folder.string());
    const std::string captures = " --captures " + options_.folder.string();
    if (board_)
      dialog_.say("next: calibrate-projector" + captures + " -o rig.json");
    else
      dialog_.say("next: calibrate-room" + captures +
                  " --known-camera camera.json -o rig.json, or with a rig "
                  "scan-surfaces" +
                  captures + " --view view_00 --rig rig.json -o surfaces.json");
    report_.captured = true;
    return report_;
  }

 private:
  void tick() {
    dialog_.progress(doing_, done_, total_);
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
    const Delay delay = measure_delay(stand_);
    shutter_.options() = shutter_options(delay);
    dialog_.say(
        format("delay      %.0f ms from showing to seeing, settled after %.0f ms; a frame every %.0f ms",
               1000 * delay.delay_s, 1000 * delay.settled_s, 1000 * delay.frame_interval_s));
    now_doing("checking the light", 0, 1);
    const fs::path folder = make_checks_folder(options_.folder);
    const LightReport report = check_light(shutter_, [&](const std::string& name, const ImageU8& frame) {
      io::save_image(folder / (name + ".png"), frame);
      tick();
    });
    light_ = report.diagnostics();
    report_.light_failed = light_.failed();
    dialog_.say(format(
        "exposure   %.0f %% of the camera's image is lit, %.0f grey levels between black and white, %.1f %% "
        "saturated",
        100 * report.exposure.lit_share, report.exposure.contrast, 100 * report.exposure.saturated_share));
    if (report.tone.gamma > 0)
      dialog_.say(format("tone       gamma %.2f of projector and camera together; drift %.1f %%",
                         report.tone.gamma, 100 * report.tone.drift));
    if (report.native.diagnostics.find("not_checked") == nullptr && report.tone.gamma > 0)
      dialog_.say(format("pixels     one-pixel squares beat by %.1f %% (scaling or keystone: above %.0f %%)",
                         100 * report.native.beat, 100 * NativeCheck::kLargestBeat));
    dialog_.report(light_);
    report_.delay = delay;
    report_.light = report;
  }

  /// Until its board is found; useless captures are moved away.
  void capture_view(int view) {
    constexpr int kTries = 3;
    ViewWriter files(options_.folder, std::size_t(view));
    bool in_place = goes_on(files);
    const std::string name = numbered("view", std::size_t(view));
    for (int attempt = 0; attempt < kTries; ++attempt) {
      if (!in_place) wait_for_pose(view);
      in_place = false;
      take_frames(name, files);
      std::vector<ImageU8> frames;
      for (int i = 0; i < files.kept(); ++i) frames.push_back(io::load_image(files.frame_file(i)).image);
      try {
        const Seen seen = read(frames, name);
        if (!seen.found.empty()) {
          files.finish();
          add_coverage(seen);
          dialog_.say(name + ": " + seen.found);
          say_coverage();
          return;
        }
        dialog_.report(seen.why_not);
      } catch (const Error& unreadable) {
        if (unreadable.kind() != ErrorKind::kInput) throw;
        dialog_.say(name + ": " + unreadable.what());
      }
      dialog_.say(name +
                  format(": the %s was not found; the frames are moved away, and the %s is asked for again",
                         wanted(), place()));
      files.set_aside();
    }
    throw Error(ErrorKind::kNotEnoughData, name,
                format("the %s was not found in %d %ss", wanted(), kTries, place()),
                board_ ? "check --board, and that the camera sees the whole board lit"
                       : "check that the camera sees the projector's picture in focus, and darken the room");
  }

  /// An earlier run's part of a view is of use while the board has not moved since.
  bool goes_on(ViewWriter& files) {
    shutter_.forget();
    if (files.kept() == 0) return false;
    if (files.kept() > pattern_.frame_count()) {
      files.set_aside();
      return false;
    }
    if (options_.single_shot) return true;
    constexpr double kSharesMoved = 0.02;
    const int last = files.kept() - 1;
    const ImageU8 now = shutter_.take(pictures_[std::size_t(last)]).image;
    const ImageU8 then = io::load_image(files.frame_file(last)).image;
    if (now.size() == then.size() && compare(now, then, shutter_.options().noise).share <= kSharesMoved) {
      dialog_.say(
          format("going on after %d frames of an earlier run: the %s has not moved", files.kept(), moved()));
      return true;
    }
    dialog_.say(
        format("%d frames of an earlier run are moved away: the %s has moved since", files.kept(), moved()));
    files.set_aside();
    shutter_.forget();
    return false;
  }

  void take_frames(const std::string& name, ViewWriter& files) {
    double unsteady = 0;
    int rejected_of_frame = 0;
    shutter_.on_rejected = [&](const ImageU8& frame, Rejected why) {
      const bool torn = why == Rejected::kTorn;
      ++(torn ? report_.torn : report_.stale);
      // Light that flickers would fill the disk.
      constexpr int kKeptAFrame = 4;
      if (++rejected_of_frame <= kKeptAFrame) files.keep_rejected(frame, torn ? "torn" : "stale");
    };
    while (files.kept() < pattern_.frame_count()) {
      now_doing(name + " frame", files.kept(), pattern_.frame_count());
      const TakenFrame taken = shutter_.take(pictures_[std::size_t(files.kept())]);
      files.keep(taken.image);
      rejected_of_frame = 0;
      if (!taken.steady) unsteady = std::max(unsteady, taken.unsteady);
    }
    shutter_.on_rejected = [](const ImageU8&, Rejected) {};
    shutter_.forget();
    if (unsteady > 0) {
      Diagnostics remark;
      remark.warn(
          "unsteady",
          name + format(": frames of one picture differ by up to %.1f grey levels: something moved, or "
                        "the light flickers (expose a multiple of the mains period)",
                        unsteady));
      dialog_.report(remark);
    }
  }

  /// Shows where the light falls, until the board is in place.
  void wait_for_pose(int view) {
    const bool beside_print = pattern_.on_blank_paper().has_value();
    screen_.show(beside_print ? pictures_.back() : ImageU8(screen_.size(), 1, 255));
    const std::string what = format("%s %d of %d: ", place(), view + 1, options_.views) +
                             (!board_        ? "the camera stands still and sees the light"
                              : beside_print ? "print in the camera's view, light on the blank paper"
                                             : "board in the light");
    if (options_.interval_s > 0) {
      dialog_.say(what + format(", within %g s", options_.interval_s));
      const double end = steady_now() + options_.interval_s;
      while (steady_now() < end) {
        now_doing("seconds left", int(end - steady_now()), int(options_.interval_s));
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
      }
      return;
    }
    dialog_.say(what + ", then press Enter, here or in the projector's window");
    for (go_on_ = false; !go_on_ && !dialog_.wants_to_go_on();)
      now_doing(what + "; captured", view, options_.views);
  }

  const char* wanted() const { return board_ ? "board" : "light"; }
  const char* place() const { return board_ ? "pose" : "place"; }
  const char* moved() const { return board_ ? "board" : "camera"; }

  Seen read(const std::vector<ImageU8>& frames, const std::string& name) const {
    const std::vector<ViewU8> captures(frames.begin(), frames.end());
    return board_ ? see_board(pattern_.read(name, captures, *board_))
                  : see_light(pattern_.read_light_map(captures)->light);
  }

  void add_coverage(const Seen& seen) {
    if (!camera_) camera_ = Coverage(seen.camera_size);
    const auto add = board_ ? &Coverage::add : &Coverage::add_dense;
    ((*camera_).*add)(seen.in_camera);
    (projector_.*add)(seen.in_projector);
  }

  void say_coverage() {
    if (!camera_) return;
    io::save_image(options_.folder / "coverage.png", draw({&*camera_, &projector_}));
    std::string text = format("coverage   camera %.0f %%, projector %.0f %%", 100 * camera_->share(),
                              100 * projector_.share());
    if (const std::string part = projector_.emptiest_part(); !part.empty())
      text += "; least in the projector's " + part;
    else if (const std::string camera_part = camera_->emptiest_part(); !camera_part.empty())
      text += "; least in the camera's " + camera_part;
    dialog_.say(text);
    report_.camera_coverage = camera_->share();
    report_.projector_coverage = projector_.share();
    dialog_.covered(report_.camera_coverage, report_.projector_coverage);
  }

  const RecorderOptions& options_;
  RecorderDialog& dialog_;
  const SessionPattern& pattern_;
  const std::optional<Board>& board_;
  std::vector<ImageU8> pictures_;
  device::FrameSink& screen_;
  CaptureRig stand_;
  Shutter shutter_;
  Diagnostics light_;
  std::optional<Coverage> camera_;
  Coverage projector_;
  std::string doing_;
  int done_ = 0, total_ = 1;
  bool go_on_ = false;  ///< asked for in the window
  RecorderReport report_;
};

}  // namespace

RecorderReport record_session(const SessionPattern& pattern, const std::optional<Board>& board,
                              device::FrameSink& screen, device::FrameSource& source,
                              const RecorderOptions& options, RecorderDialog& dialog) {
  if (!board && pattern.on_blank_paper())
    throw Error(ErrorKind::kInput, "pattern '" + pattern.text() + "'",
                "it lights points beside a printed board, and no board is given",
                "give the board, or capture Gray code or phase shift (gray, phase, gray+phase)");
  return Recorder(pattern, board, screen, source, options, dialog).run();
}

}  // namespace procam::session
