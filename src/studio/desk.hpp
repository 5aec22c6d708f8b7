#pragma once
/// The studio at work: takes what people did on the page, drives the devices, and tells the page how it stands.
///
/// One thread does all of it: devices belong to the thread that opened them. Long work (a capture, a show) calls pump()
/// again and again; a calibration and the search for the board have threads of their own.
#include <exception>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "board_spotter.hpp"
#include "calibration_job.hpp"
#include "camera_list.hpp"
#include "drift_check.hpp"
#include "edit_log.hpp"
#include "next_pose_job.hpp"
#include "page.hpp"
#include "pose_guide.hpp"
#include "procam/core/base/error.hpp"
#include "procam/device/frame_sink.hpp"
#include "procam/device/frame_source.hpp"
#include "procam/session/capture.hpp"
#include "procam/session/patterns.hpp"
#include "procam/show/show_options.hpp"
#include "procam/studio/studio.hpp"
#include "project.hpp"
#include "projector_screens.hpp"
#include "simulated_stage.hpp"
#include "wall.hpp"

namespace procam::studio {

class Desk {
 public:
  Desk(const StudioOptions& options, StudioListener& listener);
  ~Desk();
  /// Until the listener throws.
  void run();

 private:
  enum class Job {
    kNone,
    kIdentify,
    kCheckCamera,
    kCapture,
    kScan,
    kDriftCheck,
    kShow,
    kMapping,
    kLookAround
  };
  /// What the listener threw ends everything.
  struct Ending {};
  /// The person has stopped a job.
  struct Stopped {};
  class Camera;         ///< the source, with a copy of each image for the page
  class CaptureDialog;  ///< of session::record_session()
  class ShowFollower;   ///< of show::run()
  struct ShownPatterns;
  struct StateParts;  ///< of state_text()

  // desk.cpp
  void pump();
  void take(const StudioCommand& command);
  void go_to(Step step);
  void begin(Job job);
  void say(const std::string& sentence);
  void fail(const Error& error);
  /// Waits for the next camera image, which goes to the page and to the search for the board.
  void look(double timeout_s);
  void seen(const device::SeenFrame& frame);
  void show_flat(int level);
  void show_outlines();
  void show_test_card();
  void open_displays();
  void open_camera();
  device::FrameSource& camera();
  void make_board();
  void load_results();
  void save_surfaces();
  const Rig& rig() const;
  double true_rig_error() const;
  std::optional<std::string> missing_projector(const Rig& rig) const;
  Surface& surface(const std::string& name);

  // desk_commands.cpp
  void execute(const StudioCommand& command);
  void execute_setup(const StudioCommand& command);
  void choose_further_display(const StudioCommand& command);
  /// In the rig, of the projector whose frame the page shows.
  std::string framed_name() const;
  void choose(const StudioCommand& command);  ///< what execute_setup() takes back where it fails
  void execute_surfaces(const StudioCommand& command);
  void add_surface(const StudioCommand& command);
  FittedSurface clicked_surface(const StudioCommand& command);
  void add_surfaces_of(const std::string& file);
  void require_new(const std::string& surface) const;
  void add_mask(const StudioCommand& command);
  void correct_rig();
  void write_service();

  // desk_jobs.cpp
  void run_job();
  void identify();
  void check_camera();
  void check_light_of(std::size_t projector);
  bool is_light_checked() const;
  void capture();
  void measure_wall();
  void read_wall();
  void see_marker();
  void find_drift();
  /// The wall without the board under each frame, in folder/view_00.
  void capture_wall(const std::string& pattern, const std::filesystem::path& folder);
  void look_around();
  void take_calibration();
  /// With one of the projectors, while the others are black.
  session::CaptureRig capture_rig(std::size_t projector);
  bool is_next_pose_advised() const;
  void begin_guiding();
  void guide_next_pose(const std::optional<GuidedPose>& advised);
  GuidedPose listed_pose(int number) const;
  /// Of the list, poses whose numbers differ by this one are in the light of the same projector.
  int projectors_in_turn() const;
  /// The simulated person's; false: it cannot be held.
  bool hold_listed_pose(int number);

  // desk_show.cpp
  void run_show();
  void map_by_hand();
  void serve_beside(show::ShowOptions& options);
  show::ShowOptions show_options(const std::filesystem::path& surfaces) const;

  // desk_state.cpp
  std::string state_text() const;

  const StudioOptions options_;
  StudioListener& listener_;
  Project project_;
  EditLog edits_;
  std::exception_ptr ending_;
  StudioPage page_;

  std::unique_ptr<SimulatedStage> stage_;  ///< with options_.simulate
  std::unique_ptr<device::FrameSource> opened_source_;
  ProjectorScreens screens_;
  std::unique_ptr<Camera> camera_;

  Job job_ = Job::kNone;
  bool stop_ = false;      ///< the job is to end
  bool take_now_ = false;  ///< the person asks for a capture without waiting for a still board
  std::string doing_;
  int done_ = 0, total_ = 0;
  std::optional<Error> error_;
  std::vector<std::string> messages_;
  double published_s_ = 0;

  // What the camera sees.
  double last_image_s_ = 0, images_per_s_ = 0;
  ImageSize image_size_;
  double saturated_share_ = 0, brightness_ = 0, sharpness_ = 0;
  std::vector<std::optional<LitBox>> lit_;         ///< by each projector; empty: not checked
  std::vector<session::ShutterOptions> shutters_;  ///< one a projector, measured by check_camera()
  BoardSpotter spotter_;
  CameraPreviews previews_;

  // Results.
  std::optional<Board> board_;
  std::optional<GuidedPose> guided_;
  std::optional<Detections> captured_;  ///< of the pose captured last
  double camera_coverage_ = 0, projector_coverage_ = 0;
  NextPoseJob next_pose_;
  CalibrationJob calibration_;
  std::vector<std::string> headline_;
  std::optional<double> predicted_mm_, true_rig_mm_;
  bool rig_passed_ = false;
  std::optional<Rig> rig_;
  std::vector<ScanPoint> scan_;      ///< of the measured wall, by light or depth
  std::optional<Plane> wall_plane_;  ///< or its plane, by a marker
  SurfaceSet surfaces_;
  std::optional<Drift> drift_;  ///< of all projectors
  bool outlines_shown_ = false;
  std::size_t framed_ = 0;  ///< the projector whose frame the page shows for dragging
  std::string show_url_;
  bool frozen_ = false;
  std::vector<std::string> show_commands_;
  std::optional<show::PageServer> server_;  ///< last: its thread uses the page
};

}  // namespace procam::studio
