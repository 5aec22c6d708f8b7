#include "desk.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "desk_devices.hpp"
#include "procam/analyze/light_error.hpp"
#include "procam/core/base/clock.hpp"
#include "procam/detect/board_artwork.hpp"
#include "procam/io/board_file.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/sheet/board_sheet.hpp"
#include "procam/io/surface_file.hpp"
#include "procam/io/text.hpp"
#include "refused.hpp"

namespace procam::studio {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMessages = 6;
constexpr double kPublishPeriod = 0.05;
constexpr double kLook = 0.03;

bool has_projector(const Rig& rig, const std::string& name) {
  return std::any_of(rig.projectors.begin(), rig.projectors.end(),
                     [&](const RigProjector& one) { return one.name == name; });
}

show::PageServerOptions server_options(const StudioOptions& options) {
  show::PageServerOptions server = show::parse_page_address(options.control);
  server.token = options.token;
  server.period_s = kPublishPeriod / 2;
  server.name = "studio";
  return server;
}

}  // namespace

Desk::Desk(const StudioOptions& options, StudioListener& listener)
    : options_(options), listener_(listener), project_(options.project), page_(project_), screens_(page_) {
  if (options.simulate) stage_ = std::make_unique<SimulatedStage>(*options.simulate);
  load_results();
  page_.publish(state_text());  // before the first page can ask for one
  server_.emplace(page_, server_options(options));
  listener.on_start("studio: " + server_->url());
}

Desk::~Desk() = default;

void Desk::run() {
  try {
    // What was open before is opened again; a projector that is gone is reported on the page.
    for (const auto open : {&Desk::open_displays, &Desk::open_camera}) {
      try {
        (this->*open)();
      } catch (const Error& error) {
        fail(error);
      }
    }
    go_to(project_.choices.step);
    while (true) {
      pump();
      if (job_ != Job::kNone) run_job();
      look(kLook);
    }
  } catch (const Ending&) {
    std::rethrow_exception(ending_);
  }
}

void Desk::pump() {
  for (const StudioCommand& command : page_.take_commands()) {
    try {
      error_.reset();
      take(command);
    } catch (const Error& error) {
      fail(error);
    } catch (const std::invalid_argument& error) {
      fail(refused(command.verb, error.what(), "try another value"));
    }
  }
  take_calibration();
  screens_.poll();
  const double now = steady_now();
  if (now - published_s_ >= kPublishPeriod) {
    published_s_ = now;
    page_.publish(state_text());
  }
  try {
    listener_.on_tick();
  } catch (...) {
    ending_ = std::current_exception();
    throw Ending();
  }
  if (stop_) {
    stop_ = false;
    if (job_ != Job::kNone) throw Stopped();
  }
}

void Desk::say(const std::string& sentence) {
  messages_.push_back(sentence);
  if (messages_.size() > kMessages) messages_.erase(messages_.begin());
  listener_.on_event(sentence);
}

void Desk::fail(const Error& error) {
  error_ = error;
  listener_.on_event(error.what());
}

void Desk::begin(Job job) {
  if (job_ != Job::kNone) throw refused("start", "something else is running", "stop it first");
  if (calibration_.is_running())
    throw refused("start", "a calibration is running", "wait for its end, or stop it");
  job_ = job;
  doing_.clear();
  done_ = total_ = 0;
}

/// An edit of something that another page has changed meanwhile waits for the person's choice.
void Desk::take(const StudioCommand& command) {
  if (command.verb == "use_mine" || command.verb == "keep_theirs") {
    const std::optional<EditLog::Held> held = edits_.take_held(command.page);
    if (!held || command.verb == "keep_theirs") return;
    execute(held->command);
    return edits_.record(held->command);
  }
  if (const std::optional<std::string> thing = edits_.conflict(command)) return edits_.hold(command, *thing);
  execute(command);
  edits_.record(command);
}

Surface& Desk::surface(const std::string& name) {
  for (Surface& one : surfaces_.surfaces)
    if (one.name == name) return one;
  throw refused("surface '" + name + "'", "there is none of this name", "choose one of the list");
}

void Desk::save_surfaces() {
  drift_.reset();
  io::save_surfaces(project_.surfaces(), surfaces_);
  if (outlines_shown_ && screens_.is_open()) show_outlines();
}

const Rig& Desk::rig() const {
  if (!rig_) throw refused("rig", "it is not calibrated yet", "finish the step 'calibrate' first");
  return *rig_;
}

void Desk::go_to(Step step) {
  project_.choices.step = step;
  project_.save();
  spotter_.look_for(step == Step::kBoard || step == Step::kCapture ? board_ : std::nullopt);
  if (stage_ && step != Step::kCapture) stage_->put_board_away();
  if (!screens_.is_open()) return;
  if (step == Step::kDisplay)
    show_test_card();
  else
    show_flat(255);
}

void Desk::show_outlines() {
  screens_.show_outlines(surfaces_, rig());
  outlines_shown_ = true;
}

void Desk::show_flat(int level) {
  outlines_shown_ = false;
  screens_.at();
  screens_.show_flat(level);
}

void Desk::show_test_card() {
  outlines_shown_ = false;
  screens_.at();
  screens_.show_test_card();
}

void Desk::open_displays() {
  shutters_.clear();
  lit_.clear();
  framed_ = 0;
  screens_.open(project_.choices.projectors(), stage_.get());
}

void Desk::open_camera() {
  camera_.reset();
  opened_source_.reset();
  const Choices& choices = project_.choices;
  if (choices.camera.empty()) return;
  device::FrameSource* source = nullptr;
  if (stage_) {
    source = &stage_->camera();
  } else {
    device::CameraOptions options;
    if (!choices.camera_size.empty()) options.size = io::parse_size(choices.camera_size);
    if (!choices.exposure.empty()) {
      char* end = nullptr;
      options.exposure = std::strtod(choices.exposure.c_str(), &end);
      if (*end != '\0' || !std::isfinite(*options.exposure))
        throw refused("exposure " + choices.exposure, "it is no number",
                      "give a number in the driver's unit");
    }
    opened_source_ = device::open_camera(choices.camera, options);
    source = opened_source_.get();
  }
  camera_ = std::make_unique<Camera>(*source, [this](const device::SeenFrame& frame) { seen(frame); });
}

device::FrameSource& Desk::camera() {
  if (!camera_) throw refused("camera", "none is chosen", "choose one in the step 'camera'");
  return *camera_;
}

void Desk::look(double timeout_s) {
  if (!camera_) {
    std::this_thread::sleep_for(std::chrono::duration<double>(timeout_s));
    return;
  }
  try {
    camera_->next(last_image_s_, timeout_s);
  } catch (const Error& error) {
    camera_.reset();
    fail(error);
  }
}

void Desk::seen(const device::SeenFrame& frame) {
  const double interval = frame.time_s - last_image_s_;
  constexpr double kShare = 0.1, kGap = 2;
  if (interval > 0 && interval < kGap)
    images_per_s_ = images_per_s_ > 0 ? 1 / ((1 - kShare) / images_per_s_ + kShare * interval) : 1 / interval;
  last_image_s_ = frame.time_s;
  image_size_ = frame.image.size();
  std::size_t saturated = 0, count = 0;
  double sum = 0, steps = 0;
  constexpr int kEvery = 4, kSaturated = 252;
  for (int y = 0; y < frame.image.height(); y += kEvery)
    for (int x = 0; x + 2 < frame.image.width(); x += kEvery, ++count) {
      const int level = frame.image.at(x, y);
      saturated += level >= kSaturated ? 1 : 0;
      sum += level;
      steps += std::pow(double(frame.image.at(x + 2, y)) - level, 2);
    }
  if (count > 0) {
    saturated_share_ = double(saturated) / double(count);
    brightness_ = sum / double(count);
    sharpness_ = std::sqrt(steps / double(count));
  }
  if (spotter_.is_free()) spotter_.give(frame.image, frame.time_s);
  page_.publish(std::make_shared<const ImageU8>(frame.image));
}

void Desk::make_board() {
  const Choices& choices = project_.choices;
  const Board printed = io::parse_board(choices.board);
  const Board board =
      choices.measured.empty() ? printed : io::board_as_measured(printed, io::parse_length(choices.measured));
  if (board_ && !(*board_ == board) && project_.views_captured() > 0)
    throw refused("board", "the captured views show another one",
                  "move " + project_.session().string() + " away to begin again");
  const io::BoardSheet sheet =
      io::board_sheet(printed, detect::board_artwork(printed), io::parse_paper(choices.paper));
  io::save_sheet(project_.board_sheet(), sheet, 300);
  io::save_board(project_.board(), board);
  board_ = board;
  if (stage_) stage_->take_board(board_);
  spotter_.look_for(board_);
}

void Desk::load_results() {
  if (fs::exists(project_.board())) board_ = io::load_board(project_.board());
  if (stage_) stage_->take_board(board_);
  if (fs::exists(project_.surfaces())) surfaces_ = io::load_surfaces(project_.surfaces());
  rig_.reset();
  if (!fs::exists(project_.rig())) return;
  Rig stored = io::load_rig(project_.rig());
  if (const std::optional<std::string> missing = missing_projector(stored)) {
    say("rig.json is of other projectors than those of the step 'display': " + *missing);
    return;
  }
  rig_ = std::move(stored);
  const CalibrationOutcome judged = judge_stored(*rig_, project_.choices.accept_mm);
  headline_ = judged.lines;
  predicted_mm_ = judged.predicted_mm;
  rig_passed_ = judged.passed;
  if (stage_) true_rig_mm_ = true_rig_error();
}

/// What of the chosen projectors the rig does not have.
std::optional<std::string> Desk::missing_projector(const Rig& rig) const {
  const std::vector<ChosenProjector> chosen = project_.choices.projectors();
  if (chosen.size() < 2 && rig.projectors.size() != 1)
    return "it has " + std::to_string(rig.projectors.size()) + " projectors";
  for (const ChosenProjector& one : chosen)
    if (!one.name.empty() && !has_projector(rig, one.name)) return "it has no '" + one.name + "'";
  return std::nullopt;
}

/// Of the projector with the largest one, mm on a wall.
double Desk::true_rig_error() const {
  double largest = 0;
  for (const RigProjector& projector : rig().projectors)
    largest = std::max(
        largest, analyze::true_light_error(rig(), stage_->truth(), kStatedDistance, projector.name).rms_mm);
  return largest;
}

}  // namespace procam::studio
