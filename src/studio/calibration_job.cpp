#include "calibration_job.hpp"

#include <algorithm>
#include <utility>

#include "procam/calibrate/calibrate.hpp"
#include "procam/calibrate/gates.hpp"
#include "procam/io/files.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/report/calibration.hpp"
#include "procam/session/reader.hpp"

namespace procam::studio {
namespace {

struct CalibrationStopped {};

/// Of the projector with the largest one, mm on the wall.
double largest_error(const report::ReportInput& input) {
  double largest = 0;
  for (const analyze::LightErrors& one : input.predicted) largest = std::max(largest, one.externally.rms_mm);
  return largest;
}

/// Shares of the whole work.
constexpr double kReading = 0.5, kSolving = 0.9;

analyze::AcceptedError accepted(double accept_mm) {
  analyze::AcceptedError error;
  error.rms_mm = accept_mm;
  return error;
}

}  // namespace

CalibrationJob::~CalibrationJob() {
  stop();
  if (thread_.joinable()) thread_.join();
}

void CalibrationJob::start(const Project& project, const std::optional<Rig>& truth) {
  if (running_) return;
  if (thread_.joinable()) thread_.join();
  stopping_ = false;
  running_ = true;
  thread_ = std::thread([this, project, truth] {
    CalibrationOutcome outcome;
    try {
      outcome = work(project, truth);
    } catch (const CalibrationStopped&) {
      outcome.error = Error(ErrorKind::kInput, "calibration", "it was stopped", "start it again");
    } catch (const Error& error) {
      outcome.error = error;
    } catch (const std::exception& error) {
      outcome.error = Error(ErrorKind::kNotConverged, "calibration", error.what(), "capture more views");
    }
    const std::lock_guard<std::mutex> lock(mutex_);
    outcome_ = std::move(outcome);
    running_ = false;
  });
}

std::pair<std::string, int> CalibrationJob::progress() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return {doing_, int(100 * share_)};
}

std::optional<CalibrationOutcome> CalibrationJob::take() {
  const std::lock_guard<std::mutex> lock(mutex_);
  return std::exchange(outcome_, std::nullopt);
}

void CalibrationJob::report(const std::string& doing, double share) {
  if (stopping_) throw CalibrationStopped();
  const std::lock_guard<std::mutex> lock(mutex_);
  doing_ = doing;
  share_ = share;
}

CalibrationOutcome CalibrationJob::work(const Project& project, const std::optional<Rig>& truth) {
  report("reading the session", 0);
  const session::SessionPlan plan = session::open(project.session());
  const session::SessionContents contents =
      session::read(plan, [&](const std::string& view, int done, int total) {
        report("reading " + view, kReading * done / std::max(1, total));
      });
  calibrate::Options options;
  options.progress = [&](const std::string& step, double share) {
    report(step, kReading + (kSolving - kReading) * share);
  };
  calibrate::CalibrationResult result = calibrate::calibrate_rig(contents.correspondences, options);
  result.rig.provenance = session::provenance(contents, "procam-studio");
  report("predicting the error on the wall", kSolving);
  report::ReportInput input =
      report::judge(result, kStatedDistance, accepted(project.choices.accept_mm), truth);
  input.title = project.folder().filename().string();
  input.views = contents.views;
  input.images = contents.view_images;
  report("writing the report", 0.97);
  io::write_file_atomically(project.report(),
                            report::calibration_report(result, contents.correspondences, input));
  io::save_rig(project.rig(), result.rig);
  CalibrationOutcome outcome;
  outcome.rig = result.rig;
  outcome.passed = result.rig.quality.passed();
  outcome.predicted_mm = largest_error(input);
  outcome.lines = report::headline(result, input);
  return outcome;
}

CalibrationOutcome judge_stored(const Rig& rig, double accept_mm) {
  CalibrationOutcome outcome;
  outcome.rig = rig;
  RigQuality quality;
  quality.gates = calibrate::check_stored_rig(rig);
  Diagnostics diagnostics;
  const report::ReportInput input =
      report::judge(rig, kStatedDistance, accepted(accept_mm), quality.gates, diagnostics);
  outcome.passed = quality.passed() && rig.quality.passed();
  outcome.predicted_mm = largest_error(input);
  outcome.lines = report::headline(rig, quality, input);
  return outcome;
}

}  // namespace procam::studio
