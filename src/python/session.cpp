// procam.session
#include "procam/session.hpp"

#include "bind.hpp"
#include "components.hpp"

/// It owns its projectors' patterns; std::is_copy_constructible does not see it through the vector.
template <>
struct pybind11::detail::is_copy_constructible<procam::session::SessionPlan> : std::false_type {};

namespace procam::python {

namespace {

using session::SessionPattern;

/// A pattern that is a Python class. Its methods are called from the reader's threads.
class PatternInPython : public session::SessionPattern {
 public:
  std::string text() const override { PYBIND11_OVERRIDE_PURE(std::string, session::SessionPattern, text, ); }
  std::string describe() const override {
    PYBIND11_OVERRIDE_PURE(std::string, session::SessionPattern, describe, );
  }
  std::vector<ImageU8> frames() const override {
    PYBIND11_OVERRIDE_PURE(std::vector<ImageU8>, session::SessionPattern, frames, );
  }
  int frame_count() const override { PYBIND11_OVERRIDE_PURE(int, session::SessionPattern, frame_count, ); }
  void save_files(const std::filesystem::path& session_folder) const override {
    PYBIND11_OVERRIDE(void, session::SessionPattern, save_files, session_folder);
  }
  int channels() const override { PYBIND11_OVERRIDE(int, session::SessionPattern, channels, ); }
  std::optional<Eigen::AlignedBox2d> on_blank_paper() const override {
    PYBIND11_OVERRIDE(std::optional<Eigen::AlignedBox2d>, session::SessionPattern, on_blank_paper, );
  }
  bool looks_same_mirrored() const override {
    PYBIND11_OVERRIDE(bool, session::SessionPattern, looks_same_mirrored, );
  }
  session::BoardView read(const std::string& view_name, const std::vector<ViewU8>& captures,
                          const Board& board) const override {
    PYBIND11_OVERRIDE_PURE(session::BoardView, session::SessionPattern, read, view_name, captures, board);
  }
  std::optional<session::ProjectedBoardPoints> read_light(
      const std::vector<ViewU8>& captures) const override {
    PYBIND11_OVERRIDE(std::optional<session::ProjectedBoardPoints>, session::SessionPattern, read_light,
                      captures);
  }
};

/// A pattern that Python owns, in a plan.
class PatternOfPython : public session::SessionPattern {
 public:
  explicit PatternOfPython(py::object pattern)
      : object_(std::move(pattern)), pattern_(object_.cast<const session::SessionPattern&>()) {}
  ~PatternOfPython() override {
    const py::gil_scoped_acquire gil;
    object_.release().dec_ref();
  }
  const py::object& object() const { return object_; }

  std::string text() const override { return pattern_.text(); }
  std::string describe() const override { return pattern_.describe(); }
  std::vector<ImageU8> frames() const override { return pattern_.frames(); }
  int frame_count() const override { return pattern_.frame_count(); }
  void save_files(const std::filesystem::path& session_folder) const override {
    pattern_.save_files(session_folder);
  }
  int channels() const override { return pattern_.channels(); }
  std::optional<Eigen::AlignedBox2d> on_blank_paper() const override { return pattern_.on_blank_paper(); }
  bool looks_same_mirrored() const override { return pattern_.looks_same_mirrored(); }
  session::BoardView read(const std::string& view_name, const std::vector<ViewU8>& captures,
                          const Board& board) const override {
    return pattern_.read(view_name, captures, board);
  }
  std::optional<session::ProjectedBoardPoints> read_light(
      const std::vector<ViewU8>& captures) const override {
    return pattern_.read_light(captures);
  }

 private:
  py::object object_;
  const session::SessionPattern& pattern_;
};

void bind_session_pattern(py::module_& m) {
  py::class_<session::SessionPattern, PatternInPython> session_pattern(
      m, "SessionPattern",
      "What the projector shows, and how one view's captures become what camera and\n"
      "projector saw of the board. To make one\n"
      ""
      "in Python: derive from it, call super().__init__(), define text, describe, frames,\n"
      "frame_count and read, and set it\n"
      ""
      "as a projector's pattern in a plan.");
  session_pattern.def(py::init<>())
      .def("text", &SessionPattern::text, "As session.json states it; make_pattern() reads it back.")
      .def("describe", &SessionPattern::describe, "For people: how many frames of which kinds.")
      .def("frames", &SessionPattern::frames,
           "What the projector shows, uint8 (h, w) or (h, w, 3) of its size, in the order of\n"
           "capture.")
      .def("frame_count", &SessionPattern::frame_count, "Number of frames of one view.")
      .def("save_files", &SessionPattern::save_files,
           "Files beside session.json that text() names; most patterns have none.", py::arg("session_folder"))
      .def("channels", &SessionPattern::channels,
           "Of the frames and of their captures: 1, grey, or 3, colour.")
      .def("on_blank_paper", &SessionPattern::on_blank_paper,
           "The part of the picture that must land on blank paper beside the print, (2, 2): low,\n"
           "high corner; or None.")
      .def("looks_same_mirrored", &SessionPattern::looks_same_mirrored,
           "Does the light in a mirror look like the light itself? Then a session with a plain\n"
           "printed board cannot show that the camera's images are mirrored.")
      .def("read", &SessionPattern::read,
           "One board pose from its captures, frame by frame. Raises Error(kInput) for captures\n"
           "that are not of this pattern.",
           py::arg("view_name"), py::arg("captures"), py::arg("board"),
           py::call_guard<py::gil_scoped_release>())
      .def("read_light", &SessionPattern::read_light,
           "The points of a projected board, with no printed board round it; None of patterns\n"
           "that have none.",
           py::arg("captures"), py::call_guard<py::gil_scoped_release>());

  function(m, "pattern_help", &session::pattern_help,
           "The table as help for --pattern: \"gray (...) | phase (...)\".");
  function(m, "make_pattern", &session::make_pattern,
           "\"gray\", a name with parameters after a colon, or a pattern file (.json,\n"
           "io/session/pattern_file.hpp). Raises Error(kInput) with the names there are.",
           py::arg("text"), py::arg("projector_size"), py::arg("step") = 1);
}

void bind_plan(py::module_& m) {
  Record<session::PlannedView> planned_view(m, "PlannedView",
                                            "One view of a session: its name and its files.");
  planned_view.fields_init()
      .field("name", &session::PlannedView::name, "")
      .field("stacks", &session::PlannedView::stacks, "");

  Record<session::PlannedProjector> planned_projector(m, "PlannedProjector",
                                                      "One projector of a session: name, size, pattern.");
  planned_projector.field("name", &session::PlannedProjector::name, "")
      .field("size", &session::PlannedProjector::size, "");
  planned_projector.type.def_property(
      "pattern",
      [](const py::object& self) -> py::object {
        SessionPattern* const pattern = self.cast<session::PlannedProjector&>().pattern.get();
        if (const auto* of_python = dynamic_cast<const PatternOfPython*>(pattern)) return of_python->object();
        return py::cast(pattern, py::return_value_policy::reference_internal, self);
      },
      [](session::PlannedProjector& self, const py::object& pattern) {
        if (!py::isinstance<SessionPattern>(pattern))
          refuse_type({"PlannedProjector", "pattern"}, "procam.session.SessionPattern", pattern);
        self.pattern = std::make_unique<PatternOfPython>(pattern);
      },
      "None in sessions of photographs and of decoded maps; may be set.");

  Record<session::SessionPlan> session_plan(m, "SessionPlan",
                                            "A session with everything known that its reading needs.");
  session_plan.field("folder", &session::SessionPlan::folder, "")
      .field("cameras", &session::SessionPlan::cameras,
             "natural order; the first one's frame will be the rig's")
      .field("step", &session::SessionPlan::step, "")
      .field("pattern_file", &session::SessionPlan::pattern_file, "of another program's frames; empty: none")
      .field("board", &session::SessionPlan::board, "")
      .field("views", &session::SessionPlan::views, "")
      .field("shown", &session::SessionPlan::shown,
             "a session of one photograph a view; then `views` have no stacks")
      .field("decoded", &session::SessionPlan::decoded, "views hold decoded maps instead of frames")
      .field("through_mirror", &session::SessionPlan::through_mirror,
             "turn every frame left to right before it is read");
  session_plan.type.def_property_readonly(
      "projectors",
      [](const py::object& self) {
        auto& projectors = self.cast<session::SessionPlan&>().projectors;
        py::tuple out(projectors.size());
        for (std::size_t i = 0; i < projectors.size(); ++i)
          out[i] = py::cast(&projectors[i], py::return_value_policy::reference_internal, self);
        return out;
      },
      "tuple of PlannedProjector, the plan's own");

  function(m, "pattern_text", &session::pattern_text,
           "As --pattern states it; of photographs \"shown\", of decoded maps \"decoded\".", py::arg("plan"));
}

void bind_reader(py::module_& m) {
  Record<session::OpenOptions> open_options(
      m, "OpenOptions", "What a caller knows of a session; it goes before what session.json states.");
  open_options.fields_init()
      .field("stated", &session::OpenOptions::stated, "pattern, sizes, board, step")
      .field("shown", &session::OpenOptions::shown, "of a session of one photograph a view")
      .field("needs_board", &session::OpenOptions::needs_board,
             "False: the light on whatever it falls on is read");

  Record<session::SessionContents> session_contents(
      m, "SessionContents",
      "What a calibration works on, whether it comes from images or from a table of\n"
      "observations.");
  session_contents.fields_init()
      .field("correspondences", &session::SessionContents::correspondences, "")
      .field("inputs", &session::SessionContents::inputs, "every file that was read")
      .field("options", &session::SessionContents::options, "pattern, sizes, board: for the rig's provenance")
      .field("views", &session::SessionContents::views, "given, also those without enough points")
      .field("title", &session::SessionContents::title, "of the report: the folder's or the file's name")
      .field("view_images", &session::SessionContents::view_images,
             "The brightest frame of each view and camera, at most 480 pixels wide and high; none from\n"
             "tables.");

  function(m, "open", &session::open,
           "What is to be read, without reading an image: `options` first, then session.json;\n"
           "without either the pattern is \"gray\". Raises Error(kInput) naming the flag that\n"
           "would answer what neither says, and for folders that do not tell which device they\n"
           "belong to. The pattern kDecodedMaps stands for views that another program has\n"
           "decoded.\n"
           "\n"
           "  const auto session = session::read(session::open(\"captures\"));\n"
           "  const auto result = calibrate::calibrate_rig(session.correspondences);\n"
           "  io::save_rig(\"rig.json\", result.rig);",
           py::arg("folder"), py::arg_v("options", session::OpenOptions{}, "OpenOptions()"));
  function(m, "read", &session::read,
           "Reads and joins all views: cameras first among the devices, then projectors. A board\n"
           "missed in one view is a remark; one found in none of the first three views is an\n"
           "Error(kInput), as is whatever is wrong with a view's files. An image whose size is\n"
           "not that of most of its camera's images is rejected by name; a view that then has\n"
           "too few frames is rejected with it. Files that repeat another view's are warned of\n"
           "(\"identical_files\").",
           py::arg("plan"), py::arg("progress") = py::none());
  function(m, "session_devices", &session::session_devices,
           "The devices of a session with one of each, in the order of kCameraDevice,\n"
           "kProjectorDevice.",
           py::arg("camera_size"), py::arg("projector_size"));
  function(m, "provenance", &session::provenance,
           "For the rig that was solved from the contents: `program`, procam's version, the time\n"
           "(SOURCE_DATE_EPOCH where it is set:\n"
           "https://reproducible-builds.org/specs/source-date-epoch), what was read.",
           py::arg("contents"), py::arg("program"));
  function(
      m, "turn_left_to_right",
      [](ImageU8 image) {
        session::turn_left_to_right(image);
        return image;
      },
      "u -> width - 1 - u, in a new array.", py::arg("image"));
}

void bind_single_reads(py::module_& m) {
  Record<session::CapturedLight> captured_light(m, "CapturedLight",
                                                "One camera's captures of one projector's pattern.");
  captured_light.fields_init()
      .field("view", &session::CapturedLight::view, "")
      .field("camera", &session::CapturedLight::camera, "")
      .field("projector", &session::CapturedLight::projector, "")
      .field("light", &session::CapturedLight::light, "")
      .field("flat_lit", &session::CapturedLight::flat_lit, "the same view under flat light")
      .field("inputs", &session::CapturedLight::inputs, "")
      .field("exif", &session::CapturedLight::exif, "of the first capture, or None");

  function(m, "read_light", &session::read_light,
           "Which projector pixel lights each camera pixel, of the view of that name or of the\n"
           "only one. Raises Error(kInput).",
           py::arg("plan"), py::arg("view") = "");
  function(m, "read_observations", &session::read_observations,
           "A table of observations (io/session/observations_file.hpp); `devices` and `board` as\n"
           "far as the caller knows them. Views without four points in any camera are rejected\n"
           "with a warning, as in a session of images. Raises as io::load_observations().",
           py::arg("file"), py::arg_v("devices", std::vector<Device>{}, "()"), py::arg("board") = py::none());
  function(m, "read_board_images", &session::read_board_images,
           "The images of a folder (png, jpg, bmp, tif), each one view of the board by one\n"
           "camera called \"camera\". Images whose size is not that of most are rejected by name.\n"
           "Raises Error(kInput) for a folder without images and for images without the board,\n"
           "Error(kIo) for what cannot be read.",
           py::arg("folder"), py::arg("board"), py::arg("progress") = py::none());
  function(m, "read_board_image", &session::read_board_image,
           "The board's points in one image file. Raises Error(kIo), Error(kInput) for what\n"
           "cannot be read.",
           py::arg("file"), py::arg("board"));
}

void bind_folders(py::module_& m) {
  function(m, "numbered", &session::numbered, "\"view_07\", \"frame_12.png\": at least two digits.",
           py::arg("stem"), py::arg("number"), py::arg("extension") = "");
  function(m, "make_folder", &session::make_folder, "Makes the folder unless it is there. Raises Error(kIo).",
           py::arg("folder"));
  function(m, "require_same_session", &session::require_same_session,
           "Raises Error(kInput) when the folder holds a session of another pattern, size, step\n"
           "or board.",
           py::arg("folder"), py::arg("session"));
  function(m, "is_complete", &session::is_complete, "session/view_NN of an earlier run, complete?",
           py::arg("session"), py::arg("view"));
  function(m, "make_checks_folder", &session::make_checks_folder,
           "session/.checks_N: a new folder for the frames of the checks.", py::arg("session"));
  function(m, "describe_session", &session::describe_session, "session.json's contents.", py::arg("pattern"),
           py::arg("projector_size"), py::arg("board"), py::arg("step"));
}

void bind_simulated(py::module_& m) {
  Record<session::SimulationOptions> simulation_options(m, "SimulationOptions",
                                                        "What write_simulated_session() simulates.");
  simulation_options.fields_init()
      .field("seed", &session::SimulationOptions::seed, "")
      .field("level", &session::SimulationOptions::level, "")
      .field("pattern", &session::SimulationOptions::pattern, "pattern_help()")
      .field("board", &session::SimulationOptions::board, "the printed board instead of the level's")
      .field("views", &session::SimulationOptions::views, "only the first ones; 0: all of the level")
      .field("cameras", &session::SimulationOptions::cameras, "")
      .field("projectors", &session::SimulationOptions::projectors, "")
      .field("settings", &session::SimulationOptions::settings,
             "KEY=VALUE changes to the level's conditions: settings_help()")
      .field("markers", &session::SimulationOptions::markers,
             "also a view of markers on the wall (simulate/marker_view.hpp)")
      .field("check", &session::SimulationOptions::check,
             "also captures of this projected board on the bare wall")
      .field("bump", &session::SimulationOptions::bump, "rotation of the projector before `check`, radians")
      .field("room", &session::SimulationOptions::room, "a room to scan instead of boards")
      .field("station", &session::SimulationOptions::station, "where the rig stands in the room")
      .field("replace", &session::SimulationOptions::replace, "remove an earlier simulated session");

  Record<session::SimulatedFolder> simulated_folder(m, "SimulatedFolder", "The folder as it was written.");
  simulated_folder.fields_init()
      .field("views", &session::SimulatedFolder::views, "")
      .field("frames_per_view", &session::SimulatedFolder::frames_per_view, "")
      .field("pattern", &session::SimulatedFolder::pattern, "")
      .field("board", &session::SimulatedFolder::board, "")
      .field("projector_size", &session::SimulatedFolder::projector_size, "");

  function(m, "settings_help", &session::settings_help,
           "The keys of `settings` with an example and their meaning, for --help.");
  function(m, "write_simulated_session", &session::write_simulated_session,
           "The folder appears whole or not at all. Raises Error(kIo) for a folder that is not\n"
           "empty (unless `replace`, and then for one that is no simulated session),\n"
           "Error(kInput) for settings that cannot be read, Error(kUnsupported) for `markers`,\n"
           "`check` and `board` with several devices, and as make_session() does.",
           py::arg("folder"), py::arg("options"), py::arg("progress") = py::none());
}

}  // namespace

void bind_session(py::module_& m) {
  m.attr("kCameraDevice") = session::kCameraDevice;
  m.attr("kProjectorDevice") = session::kProjectorDevice;
  m.attr("kDecodedMaps") = session::kDecodedMaps;
  bind_session_pattern(m);
  bind_plan(m);
  bind_reader(m);
  bind_single_reads(m);
  bind_folders(m);
  bind_simulated(m);
}

}  // namespace procam::python
