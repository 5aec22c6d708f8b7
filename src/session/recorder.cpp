#include "procam/session/recorder.hpp"
#include "procam/core/base/words.hpp"

#include <algorithm>
#include <chrono>
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
#include "recorder_devices.hpp"
#include "seen_view.hpp"

namespace procam::session {
namespace {

namespace fs = std::filesystem;

/// The session while it is captured.
class Recorder {
 public:
  Recorder(const RecorderDevices& devices, const std::optional<Board>& board, const RecorderOptions& options,
           RecorderDialog& dialog)
      : options_(options),
        dialog_(dialog),
        board_(board),
        devices_(devices, [this] { tick(); }),
        beside_print_(devices.projectors[0].pattern.on_blank_paper().has_value()) {
    require(!options.checked || devices_.is_one_pair(), "record_session: options.checked is of one pair");
    for (Pair& pair : devices_.pairs()) {
      ShutterOptions& shutter = pair.shutter.options();
      if (options.checked) shutter = *options.checked;
      shutter.single_shot = options.single_shot;
      if (options.single_shot) shutter.patience_s = 0;  // a person takes the time it takes
      report_.pairs.push_back({projector_of(pair).device.name, camera_of(pair).name});
    }
  }

  RecorderReport run() {
    begin_folder();
    if (!options_.checked && !options_.single_shot && !check_all()) {
      dialog_.say("nothing was captured: fix what failed, or go on with --despite-checks");
      return report_;
    }
    for (std::size_t i = 0; i < devices_.pairs().size(); ++i) {
      if (!report_.pairs[i].seen) continue;
      devices_.pairs()[i].stack = stacks_.size();
      stacks_.push_back(devices_.pairs()[i].folder);
      seen_.push_back(&devices_.pairs()[i]);
    }
    for (int view = 0; view < options_.views; ++view)
      if (!is_complete(options_.folder, std::size_t(view))) capture_view(view);
    cover_all_views();
    say_end();
    report_.captured = true;
    return report_;
  }

 private:
  ShownBy& projector_of(const Pair& pair) { return devices_.projectors()[pair.projector]; }
  const RecorderDevices::Camera& camera_of(const Pair& pair) {
    return devices_.devices().cameras[pair.camera];
  }

  void tick() {
    dialog_.progress(doing_, done_, total_);
    for (ShownBy& projector : devices_.projectors()) switch (projector.device.screen.poll()) {
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

  void begin_folder() {
    const io::SessionInfo session = devices_.devices().session(board_, options_.step);
    make_folder(options_.folder);
    require_same_session(options_.folder, session);
    require_same_cameras(session);
    devices_.devices().projectors[0].pattern.save_files(options_.folder);
    io::save_session(options_.folder, session);
  }

  /// The views that are there were captured with these cameras, or some of them.
  void require_same_cameras(const io::SessionInfo& session) {
    std::vector<std::string> projectors;
    for (const auto& projector : session.projectors) projectors.push_back(projector.first);
    for (int view = 0; view < options_.views; ++view) {
      if (!is_complete(options_.folder, std::size_t(view))) continue;
      const fs::path folder = options_.folder / numbered("view", std::size_t(view));
      for (const io::Stack& stack : io::list_stacks(folder, projectors)) {
        const fs::path captured = stack.folder.lexically_relative(folder);
        const bool known =
            std::any_of(devices_.pairs().begin(), devices_.pairs().end(), [&](const Pair& pair) {
              return captured == (pair.folder.empty() ? fs::path(".") : fs::path(pair.folder));
            });
        if (!known)
          throw Error(ErrorKind::kInput, stack.folder.string(), "it is a session with other cameras",
                      "give the same --camera flags to go on with it, or another folder");
      }
    }
  }

  /// Delay and light of each pair; false: what failed forbids to capture.
  bool check_all() {
    for (std::size_t i = 0; i < devices_.pairs().size(); ++i) check(devices_.pairs()[i], report_.pairs[i]);
    if (!devices_.is_one_pair()) require_light_everywhere();
    return !report_.light_failed || options_.despite_checks;
  }

  void check(Pair& pair, RecordedPair& found) {
    now_doing(pair.title + "finding the camera's delay", 0, 1);
    found.delay = devices_.is_one_pair() ? measure_delay(pair.stand) : find_screen(pair.stand);
    found.seen = found.delay.has_value();
    if (found.seen) {
      pair.shutter.options() = shutter_options(*found.delay);
      found.light = check_light_of(pair);
      if (!devices_.is_one_pair() && found.light->diagnostics().find("not_lit") != nullptr)
        found.seen = false;
    }
    if (!found.seen) {
      dialog_.say(pair.title + "the camera does not see this projector's light");
      return;
    }
    say_light(pair, found);
    report_.light_failed = report_.light_failed || found.light->diagnostics().failed();
  }

  LightReport check_light_of(Pair& pair) {
    now_doing(pair.title + "checking the light", 0, 1);
    if (checks_.empty()) checks_ = make_checks_folder(options_.folder);
    make_folder(checks_ / pair.folder);
    return check_light(pair.shutter, [&](const std::string& name, const ImageU8& frame) {
      io::save_image(checks_ / pair.folder / (name + ".png"), frame);
      tick();
    });
  }

  void say_light(const Pair& pair, const RecordedPair& found) {
    const Delay& delay = *found.delay;
    const LightReport& light = *found.light;
    const auto say = [&](const std::string& line) { dialog_.say(pair.title + line); };
    say(format("delay      %.0f ms from showing to seeing, settled after %.0f ms; a frame every %.0f ms",
               1000 * delay.delay_s, 1000 * delay.settled_s, 1000 * delay.frame_interval_s));
    say(format(
        "exposure   %.0f %% of the camera's image is lit, %.0f grey levels between black and white, %.1f %% "
        "saturated",
        100 * light.exposure.lit_share, light.exposure.contrast, 100 * light.exposure.saturated_share));
    if (light.tone.gamma > 0)
      say(format("tone       gamma %.2f of projector and camera together; drift %.1f %%", light.tone.gamma,
                 100 * light.tone.drift));
    if (light.native.diagnostics.find("not_checked") == nullptr && light.tone.gamma > 0)
      say(format("pixels     one-pixel squares beat by %.1f %% (scaling or keystone: above %.0f %%)",
                 100 * light.native.beat, 100 * NativeCheck::kLargestBeat));
    Diagnostics remarks = light.diagnostics();
    for (Diagnostic& remark : remarks.items) remark.message = pair.title + remark.message;
    dialog_.report(remarks);
  }

  /// No projector and no camera is left over.
  void require_light_everywhere() {
    const auto require_one = [&](const std::string& subject, const std::string& why, auto&& is_its_own) {
      for (const RecordedPair& pair : report_.pairs)
        if (pair.seen && is_its_own(pair)) return;
      throw Error(
          ErrorKind::kDevice, subject, why,
          "point projector and camera at the same part of the room, choose them with --display and --camera, "
          "and turn off automatic exposure; or omit the device");
    };
    for (const auto& projector : devices_.devices().projectors)
      require_one("projector " + projector.name, "no camera sees its light",
                  [&](const RecordedPair& pair) { return pair.projector == projector.name; });
    for (const auto& camera : devices_.devices().cameras)
      require_one("camera " + camera.name, "it sees no projector's light",
                  [&](const RecordedPair& pair) { return pair.camera == camera.name; });
  }

  /// Until its board is found; useless captures are moved away.
  void capture_view(int view) {
    constexpr int kTries = 3;
    ViewWriter files(options_.folder, std::size_t(view), stacks_);
    bool in_place = goes_on(files);
    const std::string name = numbered("view", std::size_t(view));
    for (int attempt = 0; attempt < kTries; ++attempt) {
      if (!in_place) wait_for_pose(view);
      in_place = false;
      take_frames(name, files);
      if (is_of_use(name, files)) {
        files.finish();
        say_coverage();
        return;
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

  /// Does a pair show the board, or the room? What all pairs show is added to the coverage then.
  bool is_of_use(const std::string& name, const ViewWriter& files) {
    std::vector<std::pair<const Pair*, Seen>> all;
    bool found = false;
    for (const Pair* pair : seen_) {
      std::vector<ImageU8> frames;
      for (int i = 0; i < files.kept(pair->stack); ++i)
        frames.push_back(io::load_image(files.frame_file(i, pair->stack)).image);
      try {
        Seen seen = read(*pair, frames, name);
        found = found || !seen.found.empty();
        if (seen.found.empty()) dialog_.report(seen.why_not);
        if (!devices_.is_one_pair() && seen.found.empty())
          dialog_.say(name + ": " + pair->title + format("the %s was not found", wanted()));
        all.emplace_back(pair, std::move(seen));
      } catch (const Error& unreadable) {
        if (unreadable.kind() != ErrorKind::kInput) throw;
        dialog_.say(name + ": " + pair->title + unreadable.what());
      }
    }
    if (!found) return false;
    for (const auto& [pair, seen] : all) {
      if (seen.found.empty()) continue;
      add_coverage(*pair, seen);
      dialog_.say(name + ": " + pair->title + seen.found);
    }
    return true;
  }

  /// An earlier run's part of a view is of use while nothing has moved since.
  bool goes_on(ViewWriter& files) {
    for (Pair* pair : seen_) pair->shutter.forget();
    int frames = 0;
    bool moved = false;
    for (Pair* pair : seen_) {
      const int kept = files.kept(pair->stack);
      frames += kept;
      moved = moved || kept > int(projector_of(*pair).pictures.size());
      if (kept > 0 && !moved && !options_.single_shot) moved = has_moved(*pair, files);
    }
    if (frames == 0) return false;
    if (!moved) {
      if (!options_.single_shot)
        dialog_.say(
            format("going on after %d frames of an earlier run: the %s has not moved", frames, mover()));
      return true;
    }
    dialog_.say(
        format("%d frames of an earlier run are moved away: the %s has moved since", frames, mover()));
    files.set_aside();
    for (Pair* pair : seen_) pair->shutter.forget();
    return false;
  }

  /// The picture of the last frame that is kept, shown again.
  bool has_moved(Pair& pair, const ViewWriter& files) {
    constexpr double kSharesMoved = 0.02;
    const int last = files.kept(pair.stack) - 1;
    const ImageU8 now = pair.shutter.take(projector_of(pair).pictures[std::size_t(last)]).image;
    const ImageU8 then = io::load_image(files.frame_file(last, pair.stack)).image;
    return now.size() != then.size() || compare(now, then, pair.shutter.options().noise).share > kSharesMoved;
  }

  /// Projector by projector, each picture by all cameras that see it.
  void take_frames(const std::string& name, ViewWriter& files) {
    std::vector<double> unsteady(seen_.size(), 0);
    for (std::size_t p = 0; p < devices_.projectors().size(); ++p) {
      const int count = int(devices_.projectors()[p].pictures.size());
      for (int frame = 0; frame < count; ++frame)
        for (std::size_t i = 0; i < seen_.size(); ++i) {
          Pair& pair = *seen_[i];
          if (pair.projector != p || files.kept(pair.stack) > frame) continue;
          now_doing(name + " " + pair.title + "frame", frame, count);
          unsteady[i] = std::max(unsteady[i], take_frame(pair, frame, files));
        }
    }
    for (std::size_t i = 0; i < seen_.size(); ++i) {
      seen_[i]->shutter.forget();
      if (!(unsteady[i] > 0)) continue;
      Diagnostics remark;
      remark.warn("unsteady",
                  name + ": " + seen_[i]->title +
                      format("frames of one picture differ by up to %.1f grey levels: something moved, or "
                             "the light flickers (expose a multiple of the mains period)",
                             unsteady[i]));
      dialog_.report(remark);
    }
  }

  /// Returns by how many grey levels frames of the picture differed; 0 of a steady one.
  double take_frame(Pair& pair, int frame, ViewWriter& files) {
    int rejected = 0;
    pair.shutter.on_rejected = [&](const ImageU8& image, Rejected why) {
      const bool torn = why == Rejected::kTorn;
      ++(torn ? report_.torn : report_.stale);
      // Light that flickers would fill the disk.
      constexpr int kKeptAFrame = 4;
      if (++rejected <= kKeptAFrame) files.keep_rejected(image, torn ? "torn" : "stale", pair.stack);
    };
    const TakenFrame taken = pair.shutter.take(projector_of(pair).pictures[std::size_t(frame)]);
    pair.shutter.on_rejected = [](const ImageU8&, Rejected) {};
    files.keep(taken.image, pair.stack);
    return taken.steady ? 0 : taken.unsteady;
  }

  /// Shows where the light falls, until the board is in place.
  void wait_for_pose(int view) {
    for (ShownBy& projector : devices_.projectors()) {
      projector.device.screen.show(beside_print_ ? projector.pictures.back()
                                                 : ImageU8(projector.device.screen.size(), 1, 255));
      projector.shown = ImageU8();  // frames of now are no frames of the view
    }
    const std::string what =
        format("%s %d of %d: ", place(), view + 1, options_.views) +
        (!board_         ? format("the %s still and see%s the light",
                          several_cameras() ? "cameras stand" : "camera stands", several_cameras() ? "" : "s")
         : beside_print_ ? "print in the camera's view, light on the blank paper"
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

  bool several_cameras() const { return devices_.devices().cameras.size() > 1; }
  const char* wanted() const { return board_ ? "board" : "light"; }
  const char* place() const { return board_ ? "pose" : "place"; }
  const char* mover() const { return board_ ? "board" : "camera"; }

  Seen read(const Pair& pair, const std::vector<ImageU8>& frames, const std::string& name) {
    const SessionPattern& pattern = projector_of(pair).device.pattern;
    const std::vector<ViewU8> captures(frames.begin(), frames.end());
    return board_ ? see_board(pattern.read(name, captures, *board_))
                  : see_light(pattern.read_light_map(captures)->light);
  }

  void add_coverage(const Pair& pair, const Seen& seen) {
    std::optional<Coverage>& camera = devices_.cameras()[pair.camera];
    if (!camera) camera = Coverage(seen.camera_size);
    const auto add = board_ ? &Coverage::add : &Coverage::add_dense;
    ((*camera).*add)(seen.in_camera);
    (projector_of(pair).coverage.*add)(seen.in_projector);
  }

  /// Views of earlier runs, too.
  void cover_all_views() {
    for (std::optional<Coverage>& camera : devices_.cameras()) camera.reset();
    for (ShownBy& projector : devices_.projectors())
      projector.coverage = Coverage(projector.device.screen.size());
    for (int view = 0; view < options_.views; ++view) {
      dialog_.progress("coverage", view, options_.views);
      const fs::path folder = options_.folder / numbered("view", std::size_t(view));
      for (const Pair& pair : devices_.pairs()) {
        std::error_code ignored;
        if (!fs::is_directory(folder / pair.folder, ignored)) continue;
        const int count = int(projector_of(pair).pictures.size());
        const std::vector<ImageU8> frames = io::load_capture_folder(folder / pair.folder, count).frames;
        try {
          add_coverage(pair, read(pair, frames, folder.filename().string()));
        } catch (const Error& unreadable) {
          if (devices_.is_one_pair() || unreadable.kind() != ErrorKind::kInput) throw;
        }
      }
    }
    say_coverage();
  }

  void say_coverage() {
    std::vector<const Coverage*> drawn;
    std::string shares, emptiest;
    report_.camera_coverage.clear();
    report_.projector_coverage.clear();
    const auto add = [&](const std::string& kind, const std::string& name, const Coverage* coverage,
                         std::vector<double>& list) {
      list.push_back(coverage != nullptr ? coverage->share() : 0);
      const std::string title = name.empty() ? kind : name;
      shares += (shares.empty() ? "" : ", ") + title + format(" %.0f %%", 100 * list.back());
      if (coverage == nullptr) return;
      drawn.push_back(coverage);
      if (const std::string part = coverage->emptiest_part(); !part.empty())
        emptiest = "; least in the " + (name.empty() ? kind + "'s" : kind + " " + name + "'s") + " " + part;
    };
    // The last that has an empty part is named: of projectors, rather.
    for (std::size_t i = 0; i < devices_.cameras().size(); ++i) {
      const std::optional<Coverage>& camera = devices_.cameras()[i];
      add("camera", devices_.devices().cameras[i].name, camera ? &*camera : nullptr, report_.camera_coverage);
    }
    for (const ShownBy& projector : devices_.projectors())
      add("projector", projector.device.name, &projector.coverage, report_.projector_coverage);
    io::save_image(options_.folder / "coverage.png", draw(drawn));
    dialog_.say("coverage   " + shares + emptiest);
    const auto smallest = [](const std::vector<double>& list) {
      return *std::min_element(list.begin(), list.end());
    };
    dialog_.covered(smallest(report_.camera_coverage), smallest(report_.projector_coverage));
  }

  void say_end() {
    const std::string folder = options_.folder.string(), captures = " --captures " + folder;
    dialog_.say(devices_.is_one_pair() ? format("%d views of %zu frames: ", options_.views,
                                                devices_.projectors()[0].pictures.size()) +
                                             folder
                                       : counted(std::size_t(options_.views), "view") + " of " +
                                             counted(devices_.projectors().size(), "projector") + " and " +
                                             counted(devices_.cameras().size(), "camera") + ": " + folder);
    if (board_)
      dialog_.say("next: calibrate-projector" + captures + " -o rig.json");
    else
      dialog_.say("next: calibrate-room" + captures +
                  " --known-camera camera.json -o rig.json, or with a rig "
                  "scan-surfaces" +
                  captures + " --view view_00 --rig rig.json -o surfaces.json");
  }

  const RecorderOptions& options_;
  RecorderDialog& dialog_;
  const std::optional<Board>& board_;
  DeviceTable devices_;
  const bool beside_print_;
  std::vector<Pair*> seen_;          ///< of devices_: whose frames are captured
  std::vector<std::string> stacks_;  ///< their folders in a view
  fs::path checks_;                  ///< folder of the frames of the checks, once there are some
  std::string doing_;
  int done_ = 0, total_ = 1;
  bool go_on_ = false;  ///< asked for in a window
  RecorderReport report_;
};

}  // namespace

RecorderReport record_session(const RecorderDevices& devices, const std::optional<Board>& board,
                              const RecorderOptions& options, RecorderDialog& dialog) {
  require(!devices.projectors.empty() && !devices.cameras.empty(),
          "RecorderDevices: no projector, or no camera");
  if (const SessionPattern& pattern = devices.projectors[0].pattern; !board && pattern.on_blank_paper())
    throw Error(ErrorKind::kInput, "pattern '" + pattern.text() + "'",
                "it lights points beside a printed board, and no board is given",
                "give the board, or capture Gray code or phase shift (gray, phase, gray+phase)");
  return Recorder(devices, board, options, dialog).run();
}

}  // namespace procam::session
