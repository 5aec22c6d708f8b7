/// The long works of the desk: checks, captures, measurements of the wall.
#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>

#include "desk.hpp"
#include "desk_devices.hpp"
#include "measured_wall.hpp"
#include "procam/analyze/light_error.hpp"
#include "procam/core/base/clock.hpp"
#include "procam/core/base/stats.hpp"
#include "procam/core/base/words.hpp"
#include "procam/io/board_file.hpp"
#include "procam/io/image/depth_file.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/image/pfm.hpp"
#include "procam/io/marker_map_file.hpp"
#include "procam/io/session/captures.hpp"
#include "procam/session/files.hpp"
#include "procam/session/patterns.hpp"
#include "procam/session/recorder.hpp"
#include "procam/show/run.hpp"

namespace procam::studio {
namespace {

namespace fs = std::filesystem;

constexpr double kStillFor = 0.5;       // seconds without a movement before a capture starts
constexpr double kNewPoseShare = 0.02;  // of the image's width, by which corners differ from the last pose
constexpr double kDialogLook = 0.04;

/// The box of what is brighter under white than under black by half of what the brightest parts are; single pixels at its
/// border do not count.
std::optional<LitBox> lit_box(const ImageU8& white, const ImageU8& black) {
  constexpr int kEvery = 2, kContrast = 12;
  std::vector<int> steps;
  for (int y = 0; y < white.height(); y += kEvery)
    for (int x = 0; x < white.width(); x += kEvery) steps.push_back(int(white.at(x, y)) - black.at(x, y));
  const int limit = std::max(kContrast, quantile(steps, 0.98) / 2);
  std::vector<int> columns, rows;
  for (int y = 0; y < white.height(); y += kEvery)
    for (int x = 0; x < white.width(); x += kEvery)
      if (white.at(x, y) - black.at(x, y) > limit) columns.push_back(x), rows.push_back(y);
  constexpr std::size_t kFewest = 200;
  if (columns.size() < kFewest) return std::nullopt;
  return LitBox{Vec2(quantile(columns, 0.01), quantile(rows, 0.01)),
                Vec2(quantile(columns, 0.99), quantile(rows, 0.99))};
}

}  // namespace

/// The pattern of each projector, and what records it.
struct Desk::ShownPatterns {
  ShownPatterns(ProjectorScreens& screens, const std::string& pattern, device::FrameSource& camera) {
    for (std::size_t i = 0; i < screens.size(); ++i) {
      patterns.push_back(session::make_pattern(pattern, screens.at(i).size()));
      devices.projectors.push_back({screens.name(i), *patterns.back(), screens.at(i)});
    }
    devices.cameras.push_back({"", camera});
  }
  std::vector<std::unique_ptr<session::SessionPattern>> patterns;
  session::RecorderDevices devices;
};

class Desk::CaptureDialog : public session::RecorderDialog {
 public:
  /// `lights_outline`: the projector shows where to hold the board next.
  CaptureDialog(Desk& desk, bool lights_outline) : desk_(desk), lights_outline_(lights_outline) {}

  void progress(const std::string& doing, int done, int total) override {
    desk_.doing_ = doing, desk_.done_ = done, desk_.total_ = total;
    desk_.pump();
  }
  void say(const std::string& line) override {
    // The page has its own words for what the person does next.
    if (line.rfind("next:", 0) != 0 && line.rfind("pose ", 0) != 0) desk_.say(line);
  }
  void report(const Diagnostics& remarks) override {
    for (const Diagnostic& remark : remarks.items) desk_.say(remark.message);
  }
  /// Yes: the board is still in a new pose, or the person has asked for it.
  bool wants_to_go_on() override {
    const int view = desk_.project_.views_captured();
    if (view != guided_) {
      guided_ = view;
      others_ = 0;
      desk_.begin_guiding();
    }
    if (const auto advice = desk_.next_pose_.take()) desk_.guide_next_pose(advice->pose);
    light_outline(desk_.guided_ ? desk_.guided_->in_frame : std::vector<Vec2>{});
    desk_.look(kDialogLook);
    if (!is_board_ready(view)) return false;
    light_outline({});  // the patterns follow
    return true;
  }
  void covered(double camera, double projector) override {
    desk_.camera_coverage_ = camera, desk_.projector_coverage_ = projector;
  }

 private:
  bool is_board_ready(int view) {
    if (std::exchange(desk_.take_now_, false)) return note_pose();
    if (desk_.stage_ && (desk_.stage_->is_moving() || desk_.next_pose_.is_running())) {
      arrived_s_ = device::now_s();
      return false;
    }
    const std::optional<SpottedBoard> spotted = desk_.spotter_.newest();
    if (!spotted || spotted->found.observations.empty() || spotted->still_s < kStillFor) return false;
    // Images that were exposed before the simulated person arrived show the former pose.
    if (desk_.stage_ && spotted->time_s < arrived_s_ + kStillFor + 2 / std::max(desk_.images_per_s_, 1.0))
      return false;
    if (desk_.captured_) {
      const auto moved = largest_move(*desk_.captured_, spotted->found);
      if (moved && *moved < kNewPoseShare * spotted->found.image_size.width) {
        // The pose nearest to the advised one that the simulated person can hold is the last one again.
        if (desk_.stage_) desk_.hold_listed_pose(view + ++others_ * desk_.projectors_in_turn());
        return false;
      }
    }
    return note_pose();
  }
  /// The board's rectangle as it should be held; white light without one.
  void light_outline(const std::vector<Vec2>& outline) {
    if (!lights_outline_ || outline == outline_) return;
    outline_ = outline;
    if (outline.empty())
      desk_.screens_.show_flat(255);
    else
      desk_.screens_.show_guide(desk_.guided_->projector, outline);
  }
  bool note_pose() {
    if (const auto spotted = desk_.spotter_.newest()) desk_.captured_ = spotted->found;
    return true;
  }

  Desk& desk_;
  const bool lights_outline_;
  std::vector<Vec2> outline_;  ///< that is shown
  int guided_ = -1;
  int others_ = 0;        ///< poses of the list that were tried instead of the advised one
  double arrived_s_ = 0;  ///< when the simulated person was last seen to move
};

void Desk::run_job() {
  const Job job = job_;
  try {
    switch (job) {
      case Job::kIdentify:
        identify();
        break;
      case Job::kCheckCamera:
        check_camera();
        break;
      case Job::kCapture:
        capture();
        break;
      case Job::kScan:
        measure_wall();
        break;
      case Job::kDriftCheck:
        find_drift();
        break;
      case Job::kShow:
        run_show();
        break;
      case Job::kMapping:
        map_by_hand();
        break;
      case Job::kLookAround:
        look_around();
        break;
      case Job::kNone:
        break;
    }
  } catch (const Stopped&) {
    say("stopped; everything written is kept");
  } catch (const Error& error) {
    fail(error);
  } catch (const std::exception& error) {
    fail(Error(ErrorKind::kDevice, "the step", error.what(), "try it again"));
  }
  job_ = Job::kNone;
  stop_ = false;
  show_url_.clear();
  doing_.clear();
  guided_.reset();
  if (!screens_.is_open()) return;
  job == Job::kIdentify || job == Job::kMapping ? show_test_card() : show_flat(255);
}

/// The chosen camera makes way as well: a device is opened once.
void Desk::look_around() {
  doing_ = "opening the cameras";
  camera_.reset();
  opened_source_.reset();
  const auto end = [this] {
    previews_.close();
    open_camera();
  };
  try {
    previews_.open(listed_cameras(stage_ != nullptr, project_.choices.camera),
                   stage_ ? &stage_->camera() : nullptr, [this] { pump(); });
    doing_ = "showing the images of all cameras";
    while (true) {
      pump();
      previews_.poll(page_);
      std::this_thread::sleep_for(std::chrono::duration<double>(kDialogLook));
    }
  } catch (const Stopped&) {
    end();
  } catch (...) {
    end();
    throw;
  }
}

/// The projectors' own windows make way for those of all displays.
void Desk::identify() {
  doing_ = "showing each display its number";
  screens_.close();
  try {
    if (stage_) {
      screens_.open(stage_->all_projectors(), stage_.get());
      for (std::size_t i = 0; i < screens_.size(); ++i)
        screens_.at(i).show(show::identification(screens_.at(i).size(), int(i) + 1, "simulated projector"));
      constexpr double kTime = 3;  // seconds
      for (const double end = steady_now() + kTime; steady_now() < end; look(kDialogLook)) pump();
    } else {
      ShowFollower follower(*this);
      show::identify_displays(&follower);
    }
  } catch (...) {
    open_displays();
    throw;
  }
  open_displays();
}

session::CaptureRig Desk::capture_rig(std::size_t projector) {
  device::FrameSink& screen = screens_.at(projector);
  screens_.darken_others(projector);
  return {screen, camera(), [this] { pump(); }};
}

bool Desk::is_light_checked() const {
  return screens_.is_open() && shutters_.size() == screens_.size();
}

void Desk::check_camera() {
  screens_.at();
  if (stage_) stage_->put_board_away();
  shutters_.clear(), lit_.clear();
  try {
    for (std::size_t i = 0; i < screens_.size(); ++i) check_light_of(i);
  } catch (...) {
    shutters_.clear();
    throw;
  }
  project_.choices.camera_checked = 1;
  project_.save();
}

void Desk::check_light_of(std::size_t projector) {
  const session::CaptureRig devices = capture_rig(projector);
  const std::string name = screens_.name(projector);
  doing_ = name.empty() ? "measuring the camera's delay" : "measuring the camera's delay after " + name;
  const session::Delay delay = session::measure_delay(devices);
  doing_ = "checking light, tone and pixels";
  session::Shutter shutter(devices, session::shutter_options(delay));
  ImageU8 white, black;
  const session::LightReport report =
      session::check_light(shutter, [&](const std::string& image_name, const ImageU8& image) {
        if (image_name == "white_0" || image_name == "white") white = image;
        if (image_name == "black_0") black = image;
        ++done_;
        pump();
      });
  say((name.empty() ? "" : name + ": ") + "the camera sees a frame " +
      std::to_string(int(1000 * delay.delay_s)) + " ms after it is shown; " +
      fixed(100 * report.exposure.lit_share, 0) + " % of its image is lit, with " +
      fixed(report.exposure.contrast, 0) + " grey levels of contrast, " +
      fixed(100 * report.exposure.saturated_share, 1) + " % saturated");
  const Diagnostics found = report.diagnostics();
  for (const Diagnostic& remark : found.items) say(remark.message);
  lit_.push_back(white.size() == black.size() && !white.empty() ? lit_box(white, black) : std::nullopt);
  shutters_.push_back(shutter.options());
  for (const Diagnostic& remark : found.items)
    if (remark.severity == Severity::kFailure)
      throw Error(ErrorKind::kDevice, "check of projector and camera", remark.message,
                  "correct it and check again");
}

void Desk::capture() {
  if (!board_)
    throw Error(ErrorKind::kInput, "capture", "no board is chosen", "choose one in the step 'board'");
  if (!is_light_checked()) check_camera();
  const ShownPatterns shown(screens_, project_.choices.pattern, camera());
  session::RecorderOptions options;
  options.folder = project_.session();
  options.views = project_.choices.views;
  if (screens_.size() == 1) options.checked = shutters_.front();
  // A pattern beside the print needs its own frame while the board is placed.
  CaptureDialog dialog(*this, !shown.patterns.front()->on_blank_paper().has_value());
  captured_.reset();
  take_now_ = false;
  spotter_.look_for(board_);
  // Of an interrupted pose the frames are kept while the board is where it was.
  if (stage_ && !is_next_pose_advised()) {
    guide_next_pose(std::nullopt);
    while (stage_->is_moving()) look(kDialogLook), pump();
  }
  session::record_session(shown.devices, *board_, options, dialog);
  if (stage_) stage_->put_board_away();
}

/// Not before each projector may have had as many views as it needs.
bool Desk::is_next_pose_advised() const {
  return project_.views_captured() >= NextPoseJob::kFewestViews * int(screens_.size());
}

void Desk::begin_guiding() {
  guided_.reset();
  if (is_next_pose_advised())
    next_pose_.start(project_.session(), *board_);
  else
    guide_next_pose(std::nullopt);
}

int Desk::projectors_in_turn() const {
  return std::max(1, int(lit_.size()));
}

GuidedPose Desk::listed_pose(int number) const {
  const Vec2 size(image_size_.width, image_size_.height);
  const LitBox middle{0.25 * size, 0.75 * size};
  // In the light of each projector in turn.
  const int projectors = projectors_in_turn();
  const auto projector = std::size_t(number % projectors);
  const std::optional<LitBox> known = lit_.empty() ? std::nullopt : lit_[projector];
  GuidedPose pose = guided_pose(number / projectors, *board_, image_size_, known.value_or(middle));
  pose.projector = projector;
  if (projectors > 1) pose.words += ", in the light of " + screens_.name(pose.projector);
  if (known && screens_.is_open())
    pose.in_frame = outline_in_frame(*board_, pose, *known, screens_.frame_size(projector));
  return pose;
}

bool Desk::hold_listed_pose(int number) {
  guided_ = listed_pose(number);
  return stage_->hold_at(guided_->camera_from_board, guided_->projector);
}

void Desk::guide_next_pose(const std::optional<GuidedPose>& advised) {
  if (!board_ || image_size_.width == 0) return;
  guided_ = advised ? *advised : listed_pose(project_.views_captured());
  if (!stage_ || stage_->hold_at(guided_->camera_from_board, guided_->projector)) return;
  // The person cannot bring it there: the next of the list that is possible.
  constexpr int kOthers = 12;
  for (int i = 0; i < kOthers; ++i)
    if (hold_listed_pose(project_.views_captured() + i * projectors_in_turn())) return;
  say("the simulated person finds no pose of this board that camera and projector both cover");
}

void Desk::capture_wall(const std::string& pattern, const fs::path& folder) {
  if (!is_light_checked()) check_camera();
  if (stage_) {
    stage_->put_board_away();
    while (stage_->is_moving()) look(kDialogLook), pump();
  }
  const ShownPatterns shown(screens_, pattern, camera());
  std::error_code ignored;
  fs::remove_all(folder / "view_00", ignored);
  fs::remove_all(folder / ".view_00.partial", ignored);
  session::make_folder(folder);
  io::save_session(folder, shown.devices.session(std::nullopt, 1));
  std::vector<std::string> stacks;
  done_ = total_ = 0;
  for (const session::RecorderDevices::Projector& projector : shown.devices.projectors) {
    stacks.push_back(projector.name);
    total_ += projector.pattern.frame_count();
  }
  session::ViewWriter files(folder, 0, stacks);
  doing_ = "measuring the wall";
  for (std::size_t i = 0; i < stacks.size(); ++i) {
    session::Shutter shutter(capture_rig(i), shutters_[i]);
    for (const ImageU8& frame : shown.devices.projectors[i].pattern.frames()) {
      files.keep(shutter.take(frame).image, i);
      ++done_;
    }
  }
  files.finish();
}

void Desk::measure_wall() {
  rig();
  scan_.clear(), wall_plane_.reset();
  const std::string& by = project_.choices.measure_by;
  if (by == "depth") {
    doing_ = "measuring the wall by depth";
    constexpr int kImages = 10;
    const auto opened = stage_ ? nullptr : device::open_depth(project_.choices.depth);
    io::save_pfm(project_.wall_depth(), mean_depth(opened ? *opened : stage_->depth_camera(),
                                                   rig().camera().camera, kImages, [this] { pump(); }));
  } else if (by == "marker") {
    see_marker();
  } else {
    capture_wall("gray", project_.scan());
  }
  read_wall();
  say(wall_plane_
          ? "the wall's plane is known, " + fixed(std::abs(wall_plane_->offset), 2) + " m from the camera"
          : "the wall is measured: " + std::to_string(scan_.size()) + " points");
}

/// What is on disk, with the rig as it is now.
void Desk::read_wall() {
  if (!scan_.empty() || wall_plane_) return;
  const Choices& choices = project_.choices;
  if (!project_.is_wall_measured())
    throw Error(ErrorKind::kInput, "surface", "the wall is not measured yet",
                "click 'Measure the wall' first");
  if (choices.measure_by == "depth") {
    const DepthPixels pixels = io::load_depth_pixels(project_.wall_depth());
    scan_ = points_of_depth(depth::DepthImage(pixels, 1e-3), rig());
  } else if (choices.measure_by == "marker") {
    wall_plane_ = plane_of_marker(io::green_channel(io::load_image(project_.wall_marker()).image), rig(),
                                  io::parse_marker(choices.marker));
  } else {
    scan_ = read_scan(project_.scan(), rig());
  }
}

void Desk::see_marker() {
  const MarkerMap map = io::parse_marker(project_.choices.marker);
  if (!is_light_checked()) check_camera();
  const auto hang = [&](const std::optional<PlacedMarker>& marker) {
    if (!stage_) return;
    stage_->put_board_away();
    while (stage_->is_moving()) look(kDialogLook), pump();
    stage_->hang_marker(marker, map.dictionary);
    while (stage_->is_moving()) look(kDialogLook), pump();
  };
  doing_ = "looking for the marker";
  hang(map.markers.front());
  screens_.show_flat(255);
  const session::CaptureRig devices{screens_.at(), camera(), [this] { pump(); }};
  session::Shutter shutter(devices, shutters_.front());
  constexpr int kImages = 10;
  const ImageU8 image = mean_image(shutter, ImageU8(devices.screen.size(), 1, 255), kImages);
  hang(std::nullopt);
  plane_of_marker(image, rig(), map);  // throws, before the file is written
  io::save_image(project_.wall_marker(), image);
}

void Desk::find_drift() {
  rig();
  if (surfaces_.surfaces.empty())
    throw Error(ErrorKind::kInput, "drift check", "there is no surface", "make one in the step 'surfaces'");
  drift_.reset();
  const std::string pattern = "charuco";
  capture_wall(pattern, project_.check());
  std::vector<DriftCapture> captured;
  for (std::size_t i = 0; i < screens_.size(); ++i)
    captured.push_back({screens_.name(i), session::read_projected_board(
                                              project_.check() / "view_00" / screens_.name(i), pattern,
                                              screens_.at(i).size(), rig().camera().camera.size)});
  drift_ = check_drift(rig(), surfaces_, captured);
  for (const WallDrift& wall : drift_->walls) say(to_sentence(wall));
}

void Desk::take_calibration() {
  std::optional<CalibrationOutcome> outcome = calibration_.take();
  if (!outcome) return;
  if (outcome->error) return fail(*outcome->error);
  rig_ = outcome->rig;
  headline_ = outcome->lines;
  predicted_mm_ = outcome->predicted_mm;
  rig_passed_ = outcome->passed;
  scan_.clear(), wall_plane_.reset();  // read again with this rig
  drift_.reset();
  for (const std::string& line : headline_) say(line);
  if (!stage_) return;
  true_rig_mm_ = true_rig_error();
  say("true error on a wall at 2 m: " + fixed(*true_rig_mm_, 2) + " mm rms");
}

}  // namespace procam::studio
