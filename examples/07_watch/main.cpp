// A show on a wall is bumped, and corrects itself by its camera, without a pattern (docs/watch.md):
//
//   07_watch picture.png OUT
//   07_watch --marks OUT
//   07_watch --watch-only picture.png OUT
//
// After six seconds the projector is turned by 0.2 degrees in its rig, and ten seconds later again. A camera of the rig
// sees the wall. Each of its images is compared with what it should be; a movement that is certain, with one cause, is
// corrected, so slowly that nobody sees the picture jump. OUT/watch.mp4 has the wall without and with the correction side by
// side, OUT/watch.png its end, OUT/watch_error.svg the true error over time. With --marks the content is a plain grey with the
// small marks of project-live --marks, and the files are called marks. The program fails unless both bumps are corrected to less
// than 0.8 mm.
//
// With --watch-only nothing is corrected: the error is reported, until somebody presses "Correct the light" after 22 seconds.
// OUT/watch_only.mp4 has the wall and the camera's image, OUT/watch_only_error.svg the true and the reported error. The program
// fails unless each bump is an alarm within ten seconds, the report agrees with the truth to 0.5 mm, and the light is in place at
// the end.
#include <array>
#include <cstdio>
#include <iostream>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>
#include <vector>

#include "../common/error_plot.hpp"
#include "../common/stage.hpp"
#include "procam/core/geometry/se3.hpp"
#include "procam/simulate/live_view.hpp"
#include "procam/watch/correction.hpp"
#include "procam/watch/watch.hpp"

using namespace procam;

namespace {

constexpr double kFramesPerSecond = 10, kEnd = 26;
constexpr std::array<double, 2> kBumps{6, 16};  // seconds
const Vec2 kPoster(0.96, 0.64);                 // metres

/// The middle of the content, on a wall that is not quite before the rig.
Pose rig_from_middle() {
  return Pose(so3_exp(Vec3(0.07, 0.16, -0.02)), Vec3(0.06, -0.2, 2.1));
}

simulate::Room wall_with_tape() {
  simulate::Room room;
  room.ambient = 0.06;
  room.bodies.push_back(examples::sheet("wall", {-2, -1.5}, {2, 1.5}, 0.75, rig_from_middle()));
  examples::add_tape(room, kPoster, 0.01, rig_from_middle(), 0.75);
  return room;
}

ImageU8 plain_grey() {
  ImageU8 picture({96, 64}, 3);
  std::fill_n(picture.data(), 96 * 64 * 3, std::uint8_t(140));
  return picture;
}

/// The projector in its rig after a bump about its own centre.
Pose bumped(const Pose& rig_from_projector, const Vec3& rotation) {
  return Pose(so3_exp(rotation) * rig_from_projector.rotation, rig_from_projector.translation);
}

/// What the rig's camera records while the projector stands there.
simulate::LiveView camera_before(const Rig& rig, const Pose& true_rig_from_projector, double exposure) {
  simulate::LiveViewOptions options;
  options.view.exposure = exposure;
  options.view.brightest_grey = 210;
  options.view.camera_blur_px = 0.6;
  options.view.vignetting = 3;
  options.view.gamma = 2.2;
  options.view.noise = {2, 0.02};
  options.view.adaptive = true;
  options.glare = 0.02;
  simulate::RoomLight light{rig.projector().projector, true_rig_from_projector, {}};
  light.gamma = simulate::kSrgb;
  light.black = 0.001;
  light.blur_px = 0.7;
  return {wall_with_tape(), rig.camera().camera, rig.camera().rig_from_camera, light, options};
}

/// A show on the wall: its frame, and its view by somebody in the room. Both are kept while nothing moves.
struct WallShow {
  WallShow(const Rig& rig, const ImageU8& picture, bool marks) : projection(rig, standing(rig, marks)) {
    projection.set_show(examples::one_surface("poster", "world", rig_from_middle(), kPoster, picture));
    frame = ImageU8(projection.frame_size(), 3);
    // The upper right corner, from near.
    spectator.room_from_eye =
        rig_from_middle() * Pose(so3_exp(Vec3(-0.06, -0.2, 0)), Vec3(0.5, -0.35, -0.95));
  }
  static show::ProjectionOptions standing(const Rig& rig, bool marks) {
    show::ProjectionOptions options;
    options.marks = marks;
    options.projector_from_world = rig.projector().rig_from_projector.inverse();
    return options;
  }

  void draw(const Pose& believed) {
    if (is_drawn && (drawn_for.inverse() * believed).matrix().isIdentity(1e-12)) return;
    projection.move_projector(believed);
    projection.draw(1, 1, frame);
    drawn_for = believed;
    is_drawn = true;
    is_seen = false;
  }
  const ImageU8& look(const simulate::Room& room, const Pose& true_rig_from_projector) {
    if (!is_seen || !(seen_from.inverse() * true_rig_from_projector).matrix().isIdentity(1e-12))
      seen = spectator.view(room, projection.projector(), true_rig_from_projector, frame);
    seen_from = true_rig_from_projector;
    is_seen = true;
    return seen;
  }
  double error(const Pose& true_rig_from_projector) const {
    return std::sqrt(examples::squared_error(projection.projector(), drawn_for.inverse() * rig_from_middle(),
                                             projection.projector(),
                                             true_rig_from_projector.inverse() * rig_from_middle(), kPoster));
  }

  show::Projection projection;
  examples::Spectator spectator;
  ImageU8 frame, seen;
  Pose drawn_for, seen_from;
  bool is_drawn = false, is_seen = false;
};

/// The watch of the right show, as project-live --watch runs it.
struct WatchedProjector {
  explicit WatchedProjector(const Rig& rig, const SolvedSurfaceSet& solved)
      : watcher(rig.camera(), rig.projector()), glide(place(rig), place(rig), 0, 0) {
    watcher.place(watch::watched_surfaces(solved, rig.projector()));
  }
  static Pose place(const Rig& rig) { return rig.projector().rig_from_projector; }

  /// True if this image led to a correction.
  bool add(double time, const ImageU8& frame, const ImageU8& image) {
    const watch::WatchReport report = watcher.add(time, {frame, frame, 0, 0}, image);
    const watch::Correction correction = watch::correction_of(report, watcher.projector());
    if (!correction.is_possible()) return false;
    correct(time, correction);
    return true;
  }
  void correct(double time, const watch::Correction& correction) {
    std::printf("%4.1f s: %s\n", time, correction.sentence.c_str());
    glide = watch::Glide(glide.at(time), correction.projector.rig_from_projector, correction.error, time);
    watcher.correct(correction.projector, correction.covariance);
  }

  watch::Watch watcher;
  watch::Glide glide;
};

/// A grey image in the size and channels of the video's other half.
ImageU8 in_colour(const ImageU8& grey, ImageSize size) {
  ImageU8 out(size, 3);
  cv::Mat small, canvas(size.height, size.width, CV_8UC3, out.data());
  cv::resize(cv::Mat(grey.height(), grey.width(), CV_8UC1, const_cast<std::uint8_t*>(grey.data())), small,
             canvas.size(), 0, 0, cv::INTER_AREA);
  cv::cvtColor(small, canvas, cv::COLOR_GRAY2RGB);
  return out;
}

/// The rig's frame is the world.
Rig stage_rig() {
  return examples::camera_with_projector({640, 633, 322, 251, 0.4}, {1490, 1478, 530, 702, -0.8});
}

/// The bump that begins with this frame of the video, if one does.
std::optional<Vec3> bump_at(int frame) {
  if (frame == int(kBumps[0] * kFramesPerSecond)) return Vec3(0.0012, 0.0031, 0.0008);
  if (frame == int(kBumps[1] * kFramesPerSecond)) return Vec3(-0.0026, 0.0022, -0.0007);
  return std::nullopt;
}

int corrected_show(const ImageU8& picture, bool marks, const std::filesystem::path& out) {
  const std::string name = marks ? "marks" : "watch";
  const Rig rig = stage_rig();
  const simulate::Room room = wall_with_tape();
  WallShow alone(rig, picture, marks), corrected(rig, picture, marks);
  alone.draw(rig.projector().rig_from_projector);
  corrected.draw(rig.projector().rig_from_projector);
  WatchedProjector watched(rig, corrected.projection.solved());

  Pose truth = rig.projector().rig_from_projector;
  simulate::LiveView camera = camera_before(rig, truth, 0);
  const double exposure = camera.exposure();
  examples::SideBySide video(out / (name + ".mp4"), alone.spectator.eye.size, kFramesPerSecond);
  examples::ErrorPlot plot{
      "without a correction", marks ? "with --watch --marks" : "with --watch", {}, {}, {}, {}};
  int corrections = 0;
  double before_second = 0, last = 0;
  for (int i = 0; i < int(kEnd * kFramesPerSecond); ++i) {
    const double time = i / kFramesPerSecond;
    if (const std::optional<Vec3> bump = bump_at(i)) {
      truth = bumped(truth, *bump);
      camera = camera_before(rig, truth, exposure);
      plot.events.emplace_back(time, "bump");
      before_second = last;
    }
    corrected.draw(watched.glide.at(time));
    if (i % 2 == 0 && watched.add(time, corrected.frame, camera.capture(corrected.frame, std::uint64_t(i)))) {
      ++corrections;
      plot.events.emplace_back(time, "correction");
    }
    plot.add(time, alone.error(truth), last = corrected.error(truth));
    char words[64];
    std::snprintf(words, sizeof words, "not corrected: %.1f mm off", plot.without_mm.back());
    video.put(0, alone.look(room, truth), words);
    std::snprintf(words, sizeof words, "watched: %.1f mm off", plot.with_mm.back());
    video.put(1, corrected.look(room, truth), words);
    video.add();
  }
  video.save(out / (name + ".png"));
  video.finish();
  plot.save(out / (name + "_error.svg"));
  std::printf("true error after the first correction %.2f mm, at the end %.2f mm; without %.2f mm\n",
              1e3 * before_second, 1e3 * last, plot.without_mm.back());
  return corrections >= 2 && before_second < 0.8e-3 && last < 0.8e-3 ? 0 : 1;
}

int reported_show(const ImageU8& picture, const std::filesystem::path& out) {
  constexpr double kPressed = 22;  // seconds
  const Rig rig = stage_rig();
  const simulate::Room room = wall_with_tape();
  WallShow shown(rig, picture, false);
  shown.draw(rig.projector().rig_from_projector);
  WatchedProjector watched(rig, shown.projection.solved());

  Pose truth = rig.projector().rig_from_projector;
  simulate::LiveView camera = camera_before(rig, truth, 0);
  const double exposure = camera.exposure();
  examples::SideBySide video(out / "watch_only.mp4", shown.spectator.eye.size, kFramesPerSecond);
  examples::ErrorPlot plot{"true", "reported with --watch-only", {}, {}, {}, {}};
  plot.heading = "error of the light, mm RMS";
  watch::WatchReport report;
  ImageU8 image;
  int alarms = 0, wrong = 0;
  bool is_pressed = false;
  double last_bump = -1;
  for (int i = 0; i < int(kEnd * kFramesPerSecond); ++i) {
    const double time = i / kFramesPerSecond;
    if (const std::optional<Vec3> bump = bump_at(i)) {
      truth = bumped(truth, *bump);
      camera = camera_before(rig, truth, exposure);
      plot.events.emplace_back(last_bump = time, "bump");
    }
    shown.draw(watched.glide.at(time));
    const double error = shown.error(truth);
    if (i % 2 == 0) {
      image = camera.capture(shown.frame, std::uint64_t(i));
      const bool was_alarm = report.is_alarm;
      report = watched.watcher.add(time, {shown.frame, shown.frame, 0, 0}, image);
      if (report.is_alarm && !was_alarm) {
        std::printf("%4.1f s: %s\n", time, report.sentence.c_str());
        plot.events.emplace_back(time, "alarm");
        ++alarms;
      }
      // A window that began before the bump has images of both.
      if (last_bump >= 0 && !is_pressed && report.window_time > last_bump + 4)
        wrong += !report.is_alarm || std::abs(report.error - error) > 5e-4;
      const watch::Correction correction = watch::correction_of(report, watched.watcher.projector());
      if (time >= kPressed && !is_pressed && correction.is_possible()) {
        plot.events.emplace_back(time, "Correct the light");
        watched.correct(time, correction);
        is_pressed = true;
      }
    }
    plot.add(time, error, report.error);
    char words[64];
    std::snprintf(words, sizeof words, "%.1f mm off", 1e3 * error);
    video.put(0, shown.look(room, truth), words);
    std::snprintf(words, sizeof words, report.is_alarm ? "alarm: %.1f mm" : "%.1f mm", 1e3 * report.error);
    video.put(1, in_colour(image, shown.spectator.eye.size), words);
    video.add();
    if (i == int((kPressed - 1) * kFramesPerSecond)) video.save(out / "watch_only.png");
  }
  video.finish();
  plot.save(out / "watch_only_error.svg");
  const double end = shown.error(truth);
  std::printf("%d alarms, %d reports more than 0.5 mm off; true error at the end %.2f mm\n", alarms, wrong,
              1e3 * end);
  return alarms == 1 && wrong == 0 && end < 0.8e-3 ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) try {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  if (arguments.size() == 3 && arguments[0] == "--watch-only")
    return reported_show(io::load_image(arguments[1]).image, arguments[2]);
  if (arguments.size() == 2 && arguments[0] == "--marks")
    return corrected_show(plain_grey(), true, arguments[1]);
  if (arguments.size() == 2) return corrected_show(io::load_image(arguments[0]).image, false, arguments[1]);
  std::cerr << "usage: 07_watch [--watch-only] picture.png OUT, or 07_watch --marks OUT\n";
  return 2;
} catch (const Error& error) {
  std::cerr << error.what() << "\n";
  return 3;
}
