// procam.show
#include "procam/show.hpp"

#include "bind.hpp"
#include "components.hpp"

namespace procam::python {

namespace {

class ListenerInPython : public show::ShowListener {
 public:
  void on_start(const std::string& sentence) override {
    PYBIND11_OVERRIDE(void, show::ShowListener, on_start, sentence);
  }
  void on_load(int done, int total) override {
    PYBIND11_OVERRIDE(void, show::ShowListener, on_load, done, total);
  }
  void on_event(const std::string& sentence) override {
    PYBIND11_OVERRIDE(void, show::ShowListener, on_event, sentence);
  }
  void on_frame(const show::ShowReport& report) override {
    PYBIND11_OVERRIDE(void, show::ShowListener, on_frame, report);
  }
  std::vector<std::string> commands() override {
    PYBIND11_OVERRIDE(std::vector<std::string>, show::ShowListener, commands, );
  }
};

/// Looks for Ctrl-C before each frame, and passes all on.
class InterruptibleListener : public show::ShowListener {
 public:
  explicit InterruptibleListener(show::ShowListener* listener) : listener_(listener) {}
  void on_start(const std::string& sentence) override {
    if (listener_ != nullptr) listener_->on_start(sentence);
  }
  void on_load(int done, int total) override {
    check_signals();
    if (listener_ != nullptr) listener_->on_load(done, total);
  }
  void on_event(const std::string& sentence) override {
    if (listener_ != nullptr) listener_->on_event(sentence);
  }
  void on_frame(const show::ShowReport& report) override {
    check_signals();
    if (listener_ != nullptr) listener_->on_frame(report);
  }
  std::vector<std::string> commands() override {
    return listener_ != nullptr ? listener_->commands() : std::vector<std::string>();
  }

 private:
  show::ShowListener* listener_;
};

void bind_watch_status(py::module_& m) {
  Record<show::Durations> durations(
      m, "Durations",
      "Durations in bins that grow by a twentieth of an octave, from 1 us to 1000 s:\n"
      "percentiles are right to 1.8 %, whatever came, in 5 KB. Shorter ones count as 1 us,\n"
      "longer as 1000 s.");
  durations.method("add", &show::Durations::add, "Adds one duration, seconds.", py::arg("seconds"))
      .method("count", &show::Durations::count, "How many were added.")
      .method("mean", &show::Durations::mean, "Seconds; 0 without any.")
      .method("largest", &show::Durations::largest, "Seconds; 0 without any.")
      .method("sum", &show::Durations::sum, "Seconds.")
      .method("quantile", &show::Durations::quantile,
              "The duration that the share `q` (0..1) of all does not exceed; 0 without any.", py::arg("q"));

  Record<show::WatchStatus> watch_status(m, "WatchStatus",
                                         "Where the light is, by a camera that watches it (docs/watch.md).");
  watch_status.fields_init()
      .field("state", &show::WatchStatus::state, "\"ok\", \"moved\", \"no_texture\" ...: watch::to_string()")
      .field("sentence", &show::WatchStatus::sentence, "for people")
      .field("is_alarm", &show::WatchStatus::is_alarm, "")
      .field("checks", &show::WatchStatus::checks, "")
      .field("alarms", &show::WatchStatus::alarms, "")
      .field("corrections", &show::WatchStatus::corrections, "")
      .field("corrects", &show::WatchStatus::corrects, "what is found is corrected, not only reported")
      .field("is_corrected", &show::WatchStatus::is_corrected,
             "the projector does not stand where the rig file has it")
      .field("faults", &show::WatchStatus::faults, "")
      .field("error_mm", &show::WatchStatus::error_mm, "of the last window, RMS on the surfaces")
      .field("error_sigma_mm", &show::WatchStatus::error_sigma_mm, "of the last window, RMS on the surfaces")
      .field("probability", &show::WatchStatus::probability, "of such shifts without a movement")
      .field("textured", &show::WatchStatus::textured, "cells of the last image")
      .field("measured", &show::WatchStatus::measured, "cells of the last image")
      .field("window_time", &show::WatchStatus::window_time,
             "end of the last window, clock of device::now_s()")
      .field("history_mm", &show::WatchStatus::history_mm, "errors of the last windows, oldest first")
      .field("corrects_pose", &show::WatchStatus::corrects_pose, "the localiser's poses are corrected")
      .field("pose_off_mm", &show::WatchStatus::pose_off_mm, "error of the localiser's pose, along the floor")
      .field("pose_off_deg", &show::WatchStatus::pose_off_deg, "about the world's z axis")
      .field("pose_sigma_mm", &show::WatchStatus::pose_sigma_mm,
             "largest standard deviation of the corrected pose along the floor")
      .field("pose_images", &show::WatchStatus::pose_images, "images that corrected the pose")
      .field("pose_refused", &show::WatchStatus::pose_refused,
             "images that contradict the pose beyond its stated error");
}

void bind_metrics(py::module_& m) {
  Record<show::MovingMetrics> moving(
      m, "MovingMetrics",
      "A surface that moves on its own and is tracked by its markers (docs/tracked-surfaces.md).");
  moving.fields_init()
      .field("surface", &show::MovingMetrics::surface, "")
      .field("state", &show::MovingMetrics::state, "\"none\": never seen; \"fresh\", \"stale\"")
      .field("is_dark", &show::MovingMetrics::is_dark, "in the last frame, since it is not seen")
      .field("sightings", &show::MovingMetrics::sightings, "images with its pose")
      .field("refused", &show::MovingMetrics::refused, "images with markers of it and without a pose")
      .field("refusal", &show::MovingMetrics::refusal, "why, of the last one")
      .field("losses", &show::MovingMetrics::losses, "times that it was not seen for too long")
      .field("lost_s", &show::MovingMetrics::lost_s, "in all")
      .field("age_s", &show::MovingMetrics::age_s, "from its last pose to the light of the last frame")
      .field("error_mm", &show::MovingMetrics::error_mm,
             "of the light on it in the last frame, RMS, as its covariance predicts");
  Record<show::GroupMetrics> group(m, "GroupMetrics", "Of a show that several hosts show (docs/live.md).");
  group.fields_init()
      .field("leads", &show::GroupMetrics::leads, "")
      .field("leader", &show::GroupMetrics::leader, "host and process; empty: none is known")
      .field("hosts", &show::GroupMetrics::hosts, "with this one")
      .field("clock_error_s", &show::GroupMetrics::clock_error_s,
             "bound of the error of content time, against the leader's")
      .field("takeovers", &show::GroupMetrics::takeovers, "leaders that followed another one")
      .field("last_takeover_s", &show::GroupMetrics::last_takeover_s, "in which nobody led")
      .field("rejected", &show::GroupMetrics::rejected, "invalid messages")
      .field("waiting", &show::GroupMetrics::waiting, "requests of this host that the leader has not taken");
  Record<show::FleetMetrics> fleet(m, "FleetMetrics", "Of a robot in a fleet (docs/live.md).");
  fleet.fields_init()
      .field("robots", &show::FleetMetrics::robots, "with this one")
      .field("by", &show::FleetMetrics::by, "surface: the robots that light it")
      .field("lit", &show::FleetMetrics::lit, "surfaces that this robot lights")
      .field("turns", &show::FleetMetrics::turns, "times that this robot began to light a surface")
      .field("last_wait_s", &show::FleetMetrics::last_wait_s,
             "from the request to the last grant, the last time")
      .field("rejected", &show::FleetMetrics::rejected, "announcements that were invalid or too large")
      .field("is_superseded", &show::FleetMetrics::is_superseded,
             "a robot of the same name was started later: this one is dark")
      .field("largest_latency_s", &show::FleetMetrics::largest_latency_s,
             "from a grant to the light, of all robots");
  Record<show::BlendMetrics> blend(m, "BlendMetrics",
                                   "Of a show that blends with other projectors (docs/live.md).");
  blend.fields_init()
      .field("projectors", &show::BlendMetrics::projectors,
             "that the frames are blended for, this one among them")
      .field("is_dark", &show::BlendMetrics::is_dark, "this projector waits for its turn to light")
      .field("changes", &show::BlendMetrics::changes, "of the maps that frames are drawn with")
      .field("last_change_s", &show::BlendMetrics::last_change_s,
             "from a change of surfaces or projectors to the frame that follows it, the last time");
  Record<show::Metrics> metrics(m, "Metrics", "Counts and durations of a running show.");
  metrics.fields_init()
      .field("frames", &show::Metrics::frames, "shown")
      .field("dropped", &show::Metrics::dropped, "whose time passed while another was drawn")
      .field("blanked", &show::Metrics::blanked, "shown black because the pose was stale")
      .field("waiting", &show::Metrics::waiting,
             "in which surfaces in the world were dark because no pose had come")
      .field("checked", &show::Metrics::checked,
             "frames, one a second, that were looked at while surfaces were placed")
      .field("dark", &show::Metrics::dark, "of these, without any light")
      .field("reloads", &show::Metrics::reloads, "of the surfaces file that succeeded")
      .field("failed_reloads", &show::Metrics::failed_reloads,
             "of a file that cannot be read, or whose surfaces cannot be shown")
      .field("poses", &show::Metrics::poses, "arrived, good ones")
      .field("malformed", &show::Metrics::malformed, "messages that were none")
      .field("draw", &show::Metrics::draw, "from the last look at the sources to the frame ready")
      .field("render", &show::Metrics::render, "of that, the renderer")
      .field("jitter", &show::Metrics::jitter, "between two frames' begins, from what it should be")
      .field("pose_age", &show::Metrics::pose_age,
             "of frames that are not black: from the moment that the newest pose speaks of to the\n"
             "light of the frame")
      .field("pose_to_frame", &show::Metrics::pose_to_frame,
             "from a pose's arrival to the first frame with it ready, less that frame's render")
      .field("faults", &show::Metrics::faults,
             "What failed while the show went on, by name: \"command\", \"content\", \"control_page\",\n"
             "\"depth\", \"frame\", \"people\" and \"people_...\" (messages), \"page_connection\" (closed\n"
             "for others), \"page_refused\", \"page_request\", \"pose_source\", \"record\", \"reload\",\n"
             "\"room\", \"save\", \"surfaces\", \"watch\".")
      .field("watch", &show::Metrics::watch, "")
      .field("moving", &show::Metrics::moving, "")
      .field("group", &show::Metrics::group, "")
      .field("fleet", &show::Metrics::fleet, "")
      .field("blend", &show::Metrics::blend, "")
      .field("contents_stopped", &show::Metrics::contents_stopped,
             "now: contents that give no new images and show their last one");
}

void bind_inputs(py::module_& m) {
  Record<show::WatchInput> watch_input(
      m, "WatchInput", "A camera of the rig that watches where the light of the show is (docs/watch.md).");
  watch_input.fields_init()
      .field("camera", &show::WatchInput::camera,
             "number, device, address, topic or folder, as device::open_camera() takes it")
      .field("name", &show::WatchInput::name,
             "the camera's name in the rig; may be empty when the rig has one")
      .field("delay_s", &show::WatchInput::delay_s, "from the exposure of an image to its arrival")
      .field("only", &show::WatchInput::only, "report, and correct nothing")
      .field("marks", &show::WatchInput::marks, "small marks are drawn where the content has no texture")
      .field("save", &show::WatchInput::save,
             "file for the rig as corrected, written after each correction; empty: none")
      .field("pose_m", &show::WatchInput::pose_m,
             "standard deviation of the localiser's error, metres; 0: its poses are not corrected")
      .field("pose_rad", &show::WatchInput::pose_rad, "the same about the world's z axis, radians")
      .field("pose_time_s", &show::WatchInput::pose_time_s, "time for which such an error lasts, seconds")
      .field("markers", &show::WatchInput::markers,
             "with pose_m: marker map file of known markers in the world; empty: none");

  Record<show::TrackInput> track_input(
      m, "TrackInput",
      "Surfaces that move on their own, found by the markers on them (docs/tracked-surfaces.md).");
  track_input.fields_init()
      .field("camera", &show::TrackInput::camera,
             "number, device, address, topic or folder, as device::open_camera() takes it")
      .field("name", &show::TrackInput::name,
             "the camera's name in the rig; may be empty when the rig has one")
      .field("delay_s", &show::TrackInput::delay_s,
             "from the exposure of an image's middle row to its arrival")
      .field("readout_s", &show::TrackInput::readout_s,
             "from the exposure of the first row to that of the last")
      .field("surfaces", &show::TrackInput::surfaces,
             "By surface: one marker, whose frame is the surface's, DICTIONARY:ID:SIZE; or a marker map\n"
             "file with the markers in the surface's frame. Surfaces that move as one are joined by commas.")
      .field("hinges", &show::TrackInput::hinges,
             "By surface: the edge of its content about which it rotates: left, right, top or bottom.")
      .field("marker_light", &show::TrackInput::marker_light,
             "grey value of the light on the markers, 0..255; -1: search_light, or the content's")
      .field("search_light", &show::TrackInput::search_light,
             "grey value of the light around the surfaces while one of these is not seen; 0: none");

  Record<show::ScreenOutput> screen_output(
      m, "ScreenOutput", "One of several projectors of the rig in one process, and where its frames go.");
  screen_output.fields_init()
      .field("projector", &show::ScreenOutput::projector, "its name in the rig")
      .field("display", &show::ScreenOutput::display, "number, name or place on the desktop")
      .field("output", &show::ScreenOutput::output, "or as device::open_sink() takes it");

  Record<show::BlendSettings> blend_settings(
      m, "BlendSettings",
      "The blend with other projectors of the rig, where they light the same surfaces\n"
      "(docs/live.md).");
  blend_settings.fields_init()
      .field("projectors", &show::BlendSettings::projectors,
             "Names in the rig, or \"all\". In a group none: the hosts announce their projectors; or\n"
             "\"off\".")
      .field("black", &show::BlendSettings::black, "of each projector over its white; 0 where it is missing")
      .field("brightness", &show::BlendSettings::brightness,
             "light of its white, with `compensate`; 1 where it is missing")
      .field("compensate", &show::BlendSettings::compensate,
             "brightness is evened out; bright places keep at least this share; 0: it is not")
      .field("one_level", &show::BlendSettings::one_level,
             "with `compensate`: all surfaces come to one brightness");

  Record<show::MarkerInput> marker_input(
      m, "MarkerInput", "Poses from what a camera of the rig sees of markers (marker_source.hpp).");
  marker_input.fields_init()
      .field("camera", &show::MarkerInput::camera,
             "number, device, address, topic or folder, as device::open_camera() takes it")
      .field("name", &show::MarkerInput::name,
             "the camera's name in the rig; may be empty when the rig has one")
      .field("marker", &show::MarkerInput::marker,
             "one marker, whose frame becomes the world: DICTIONARY:ID:SIZE (io::parse_marker)")
      .field("markers", &show::MarkerInput::markers, "or a marker map file");

  Record<show::DepthInput> depth_input(m, "DepthInput",
                                       "The rig's depth camera, for surfaces that begin with \"depth:\".");
  depth_input.fields_init()
      .field("camera", &show::DepthInput::camera,
             "its name in the rig; may be empty when the rig has one camera")
      .field("metres_per_unit", &show::DepthInput::metres_per_unit,
             "of 16-bit depth images, where no sensor states it")
      .field("delay_s", &show::DepthInput::delay_s, "from a depth image's exposure to its arrival")
      .field("up", &show::DepthInput::up, "in the world; default 0,0,1, without poses 0,-1,0 (the rig's)")
      .field("silhouettes", &show::DepthInput::silhouettes,
             "what comes before the room is kept out of the light; dark without depth");

  Record<show::PeopleInput> people_input(
      m, "PeopleInput", "Skeletons of the people before the projector, whose heads are kept dark.");
  people_input.fields_init()
      .field("source", &show::PeopleInput::source,
             "udp:9100, tcp:HOST:PORT, tcp-listen:PORT, vmc:39539, log:FILE")
      .field("sensor", &show::PeopleInput::sensor,
             "pose file between \"sensor\" and the rig, its projector, a camera or the world")
      .field("delay_s", &show::PeopleInput::delay_s,
             "from the exposure of a skeleton to its arrival, the fastest")
      .field("destinations", &show::PeopleInput::destinations,
             "SURFACE=udp:HOST:PORT: skeletons in metres of that surface");

  function(m, "is_marker_file", &show::is_marker_file,
           "Does a value of TrackInput.surfaces name a marker map file, instead of one marker?",
           py::arg("markers"));
  function(m, "is_depth_source", &show::is_depth_source,
           "Does the text name a depth camera instead of a surface file?", py::arg("surfaces"));
  function(m, "is_shape_source", &show::is_shape_source, "Is its surface a live shape (\"depth-shape:\")?",
           py::arg("surfaces"));
}

void bind_show_options(py::module_& m) {
  Record<show::ShowOptions> show_options(m, "ShowOptions",
                                         "What a show draws, where it draws, and what it listens to.");
  show_options.fields_init()
      .field("projector", &show::ShowOptions::projector,
             "its name in the rig; may be empty when the rig has one")
      .field("surfaces", &show::ShowOptions::surfaces,
             "A surface file, read again when it changes; or depth:watch:FOLDER,\n"
             "depth:folder:FOLDER, depth:openni2:[URI],\n"
             "depth:ros2:/TOPIC.")
      .field("contents", &show::ShowOptions::contents,
             "Contents by surface (device/content_source.hpp), instead of the surface file's own.")
      .field("poses", &show::ShowOptions::poses, "pose sources (track/pose_source.hpp): \"udp:9000\"")
      .field("marker", &show::ShowOptions::marker, "instead of `poses`")
      .field("pose", &show::ShowOptions::pose, "or a pose file, for a projector that stands still")
      .field("mount", &show::ShowOptions::mount,
             "Pose file that places the rig, its projector or a camera on \"base\", the moving frame\n"
             "of the poses. Without it the poses are those of the rig.")
      .field("frame", &show::ShowOptions::frame, "of the poses; empty: those of the first message")
      .field("child", &show::ShowOptions::child, "of the poses; empty: those of the first message")
      .field("prediction", &show::ShowOptions::prediction, "auto, twist, acceleration or none")
      .field("source_delay_s", &show::ShowOptions::source_delay_s,
             "from the time of a pose to its arrival, the fastest")
      .field("blank_on_stale_s", &show::ShowOptions::blank_on_stale_s,
             "Without a new pose for so long the frame is black, or drawn for the last pose (the\n"
             "default, 0.5 s).")
      .field("freeze_on_stale_s", &show::ShowOptions::freeze_on_stale_s,
             "Without a new pose for so long the frame is black, or drawn for the last pose (the\n"
             "default, 0.5 s).")
      .field("display", &show::ShowOptions::display,
             "The projector's display (device::find_display); without it, as\n"
             "device::choose_display() chooses.")
      .field("output", &show::ShowOptions::output, "instead of a display, as device::open_sink() takes it")
      .field("screens", &show::ShowOptions::screens,
             "Several projectors of the rig in this process (docs/live.md), instead of `projector`,\n"
             "`display` and `output`. All show the same surfaces, pictures and poses, and blend.")
      .field("size", &show::ShowOptions::size, "of the frame, where neither a rig nor a display states it")
      .field("fps", &show::ShowOptions::fps, "frames a second; 0: the display's, or 60")
      .field("duration_s", &show::ShowOptions::duration_s,
             "0: until the window is closed or the listener ends it")
      .field("delay_s", &show::ShowOptions::delay_s, "from the begin of a frame to its light")
      .field("delay_camera", &show::ShowOptions::delay_camera,
             "a camera that measures delay_s before the show, instead")
      .field("camera_delay_s", &show::ShowOptions::camera_delay_s,
             "the camera's own share of what it measures")
      .field("depth", &show::ShowOptions::depth, "")
      .field("people", &show::ShowOptions::people, "")
      .field("publish", &show::ShowOptions::publish, "ros2:[NAMESPACE]: the projector in the ROS 2 graph")
      .field("dds_security", &show::ShowOptions::dds_security,
             "folder of the certificates of DDS Security, for all that the show opens in the graph")
      .field("watch", &show::ShowOptions::watch, "")
      .field("track", &show::ShowOptions::track, "")
      .field("blend", &show::ShowOptions::blend,
             "Without it a show blends in a group, and with several screens, alone.")
      .field("group", &show::ShowOptions::group, "hosts with one name show one show")
      .field("group_strength", &show::ShowOptions::group_strength,
             "the strongest follows a leader that is gone")
      .field("fleet", &show::ShowOptions::fleet, "robots of one fleet light one room")
      .field("robot", &show::ShowOptions::robot, "the name of this robot in the fleet")
      .field("fleet_priority", &show::ShowOptions::fleet_priority,
             "the robot with the greatest number lights a surface")
      .field("fleet_blend", &show::ShowOptions::fleet_blend,
             "surfaces are lit together with other robots that blend")
      .field("autosave", &show::ShowOptions::autosave, "edits at the control page are saved within a second")
      .field("record", &show::ShowOptions::record, "log of the run, for replay()")
      .field("control", &show::ShowOptions::control, "[ADDRESS:]PORT of the control page, or \"off\"")
      .field("token", &show::ShowOptions::token, "the control page's secret; empty: a random one")
      .field("renderer", &show::ShowOptions::renderer, "cpu or gl")
      .field("threads", &show::ShowOptions::threads, "0: as many as the machine has")
      .field("bilinear", &show::ShowOptions::bilinear,
             "one sample a pixel: faster, and aliases where content is minified")
      .field("average_numbers", &show::ShowOptions::average_numbers,
             "average pixel values as they stand instead of the light");
}

void bind_show_files(py::module_& m) {
  function(m, "load_options", &show::load_options,
           "Relative file names become relative to the working directory. Raises Error(kIo), and\n"
           "Error(kInput) with file, line and field, also for an unknown field.",
           py::arg("path"));
  function(m, "save_options", &show::save_options,
           "Writes what differs from the defaults; file names become relative to the file.\n"
           "Raises Error(kIo).",
           py::arg("path"), py::arg("options"));
}

void bind_reports(py::module_& m) {
  Record<show::PeopleCounts> people_counts(m, "PeopleCounts", "What became of the people's skeletons.");
  people_counts.fields_init()
      .field("frames", &show::PeopleCounts::frames, "of skeletons taken")
      .field("malformed", &show::PeopleCounts::malformed, "messages that were none")
      .field("refused", &show::PeopleCounts::refused, "frames with impossible values")
      .field("repeated", &show::PeopleCounts::repeated, "frames that came twice or late")
      .field("teleports", &show::PeopleCounts::teleports, "joints that jumped")
      .field("sent", &show::PeopleCounts::sent, "frames sent to contents");

  Record<show::ShowReport> show_report(m, "ShowReport",
                                       "What happened in a show: frames, durations, faults.");
  show_report.fields_init()
      .field("metrics", &show::ShowReport::metrics, "")
      .field("poses", &show::ShowReport::poses, "by their fate")
      .field("people", &show::ShowReport::people, "");

  Record<show::ReplayReport> replay_report(m, "ReplayReport", "What a replay drew.");
  replay_report.fields_init()
      .field("frames", &show::ReplayReport::frames, "")
      .field("equal", &show::ReplayReport::equal, "to the recorded ones, bit for bit");
}

void bind_listener(py::module_& m) {
  py::class_<show::ShowListener, ListenerInPython> show_listener(
      m, "ShowListener", "Follows a running show: derive from it and define what is of interest.");
  show_listener.def(py::init<>())
      .def("on_start", &show::ShowListener::on_start,
           "Before the first frame: the display, the control page's address, the measured delay.",
           py::arg("sentence"))
      .def("on_load", &show::ShowListener::on_load, "While contents are opened, before each surface.",
           py::arg("done"), py::arg("total"))
      .def("on_event", &show::ShowListener::on_event, "An event: faults, recoveries, reloads.",
           py::arg("sentence"))
      .def("on_frame", &show::ShowListener::on_frame,
           "After each frame, and ten times a second while the next one is awaited. An exception\n"
           "ends the show and passes through run().",
           py::arg("report"))
      .def("commands", &show::ShowListener::commands,
           "Commands to the show since the last call, JSON as the control page sends them.");
}

void bind_run(py::module_& m) {
  function(m, "darkness", &show::darkness,
           "Warnings about a show that nobody could see: \"no_pose\", \"no_light\".", py::arg("report"),
           py::arg("options"));
  function(
      m, "run",
      [](const Rig& rig, const show::ShowOptions& options, show::ShowListener* listener) {
        InterruptibleListener interruptible_listener(listener);
        return show::run(rig, options, &interruptible_listener);
      },
      "Shows until the window is closed, the time is over, the listener raises or Ctrl-C.\n"
      "Raises Error for options, files and devices that cannot be used.",
      py::arg("rig"), py::arg("options"), py::arg("listener") = py::none());
  function(
      m, "run",
      [](const show::ShowOptions& options, show::ShowListener* listener) {
        InterruptibleListener interruptible_listener(listener);
        return show::run(options, &interruptible_listener);
      },
      "A show without a calibrated rig: surfaces in projector pixels alone, whose corners\n"
      "are dragged at the control page.",
      py::arg("options"), py::arg("listener") = py::none());
  function(
      m, "replay",
      [](const Rig& rig, const show::ShowOptions& options, const std::filesystem::path& log,
         show::ShowListener* listener) {
        InterruptibleListener interruptible_listener(listener);
        return show::replay(rig, options, log, &interruptible_listener);
      },
      "Shows a recorded run again, frame by frame, and compares. Of `options`, surfaces and\n"
      "contents are those of the log. Events name conditions other than the recorded ones.",
      py::arg("rig"), py::arg("options"), py::arg("log"), py::arg("listener") = py::none());
}

}  // namespace

void bind_show(py::module_& m) {
  bind_watch_status(m);
  bind_metrics(m);
  bind_inputs(m);
  bind_show_options(m);
  bind_show_files(m);
  bind_reports(m);
  bind_listener(m);
  bind_run(m);
}

}  // namespace procam::python
