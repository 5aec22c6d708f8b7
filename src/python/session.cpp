// procam.session
#include "procam/session.hpp"

#include "bind.hpp"
#include "components.hpp"

/// It owns its projectors' patterns; std::is_copy_constructible does not see it through the vector.
template <>
struct pybind11::detail::is_copy_constructible<procam::session::SessionPlan> : std::false_type {};

namespace procam::python {

namespace {

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

}  // namespace

void bind_session(py::module_& m) {
  Record<session::Change> change(m, "Change", "");
  Record<session::ExposureCheck> exposure_check(
      m, "ExposureCheck",
      "Flat white and flat black: what the projector lights, and how the camera is exposed.");
  Record<session::ToneCheck> tone_check(m, "ToneCheck", "A ramp of flat pictures, up and down again.");
  Record<session::NativeCheck> native_check(
      m, "NativeCheck",
      "Does each pixel of the picture have its own pixel in the projector?\n"
      "\n"
      "A checkerboard of one-pixel squares C and its inverse D add up to the light of white\n"
      "W and black B, whatever the camera resolves of them:\n"
      "  s = (C + D - 2 B) / (W - B) = 1   at every camera pixel, free of the print and of room light.\n"
      "A projector that scales its input or corrects keystone mixes neighbouring pixels,\n"
      "which turns the squares into grey where they fall between its own; grey is darker\n"
      "than half of white (gamma), so s beats over the picture between 1 and 2^(1 - gamma).\n"
      "The beat is the standard deviation of s over the lit pixels, from the covariance of\n"
      "two rounds, so that noise averages out. A camera with a curve of its own makes s\n"
      "fall with the contrast it resolves, (C - D)^2; that share is taken out first.");
  Record<session::Delay> delay(m, "Delay", "");
  Record<session::BoardView> board_view(
      m, "BoardView",
      "One placement of the board: what each device saw or lit of it, in the order of the\n"
      "devices.");
  Record<session::Reading> reading(
      m, "Reading",
      "What one camera read off one projector's patterns while the board stood in one\n"
      "place.");
  Record<session::ProjectedBoardPoints> projected_board_points(
      m, "ProjectedBoardPoints", "A projected board by itself, on whatever it falls.");
  Record<session::ProjectedBoardCapture> projected_board_capture(m, "ProjectedBoardCapture", "");
  Record<session::ShownFlags> shown_flags(m, "ShownFlags", "What flags state of such a session.");
  Record<session::PhotographedView> photographed_view(m, "PhotographedView", "");
  Record<session::ShownViews> shown_views(m, "ShownViews", "");
  Record<session::PlannedView> planned_view(m, "PlannedView", "");
  Record<session::OpenOptions> open_options(
      m, "OpenOptions", "What a caller knows of a session; it goes before what session.json states.");
  Record<session::SessionContents> session_contents(
      m, "SessionContents",
      "What a calibration works on, whether it comes from images or from a table of\n"
      "observations.");
  Record<session::CapturedLight> captured_light(m, "CapturedLight",
                                                "One camera's captures of one projector's pattern.");
  Record<session::SimulationOptions> simulation_options(m, "SimulationOptions", "");
  Record<session::SimulatedFolder> simulated_folder(m, "SimulatedFolder", "The folder as it was written.");
  py::class_<session::SessionPattern, PatternInPython> session_pattern(
      m, "SessionPattern",
      "What the projector shows, and how one view's captures become what camera and\n"
      "projector saw of the board. To make one\n"
      ""
      "in Python: derive from it, call super().__init__(), define text, describe, frames,\n"
      "frame_count and read, and set it\n"
      ""
      "as a projector's pattern in a plan.");
  Record<session::PlannedProjector> planned_projector(m, "PlannedProjector", "");
  Record<session::SessionPlan> session_plan(m, "SessionPlan",
                                            "A session with everything known that its reading needs.");
  Record<session::Coverage> coverage(m, "Coverage", "Which parts of a device's picture the views cover.");

  change.fields_init()
      .field("share", &session::Change::share, "of the image's blocks that changed, 0..1")
      .field("largest", &session::Change::largest,
             "rms difference of the block that changed most beyond noise, grey levels")
      .method("any", &session::Change::any, "");
  exposure_check.fields_init()
      .field("lit_share", &session::ExposureCheck::lit_share,
             "of the camera's image: white exceeds black by 5 grey levels and 5 sigmas")
      .field("contrast", &session::ExposureCheck::contrast,
             "white minus black, grey levels, that a tenth of the lit pixels exceed: paper's")
      .field("brightest", &session::ExposureCheck::brightest,
             "grey level that 98 % of the lit pixels stay below")
      .field("saturated_share", &session::ExposureCheck::saturated_share,
             "of the lit pixels, at 254 or 255 in white")
      .field("paper", &session::ExposureCheck::paper,
             "1 where white minus black is at least half of the contrast")
      .field("diagnostics", &session::ExposureCheck::diagnostics,
             "Failures \"not_lit\" (below 1 % of the image), \"too_dark\" (contrast below 12),\n"
             "\"saturated\" (more than 2 %); warnings \"little_contrast\" (below 40), \"some_saturated\"\n"
             "(more than 0.1 %).");
  tone_check.fields_init()
      .field("gamma", &session::ToneCheck::gamma,
             "of projector and camera together: seen ~ shown^gamma between black and white")
      .field("drift", &session::ToneCheck::drift,
             "largest difference of the two ways at one level, as a share of white minus black")
      .field("diagnostics", &session::ToneCheck::diagnostics,
             "Warnings \"light_drifts\" (more than 3 %: an automatic is on), \"not_monotone\",\n"
             "\"clipped\" (the brightest step adds less than 1 %).");
  native_check.fields_init()
      .field("beat", &session::NativeCheck::beat, "")
      .field("diagnostics", &session::NativeCheck::diagnostics,
             "Failure \"resampled\" above kLargestBeat. Warning \"not_checked\" when too few pixels\n"
             "are bright and unsaturated.");
  delay.fields_init()
      .field("delay_s", &session::Delay::delay_s,
             "from show() to the arrival of a frame whose exposure has its middle there")
      .field("settled_s", &session::Delay::settled_s,
             "Frames that arrive later than this after a switch showed the new picture alone:\n"
             "exposure, rolling shutter and jitter are in it, as far as they showed during the\n"
             "code. At least delay_s.")
      .field("frame_interval_s", &session::Delay::frame_interval_s, "median")
      .field("correlation", &session::Delay::correlation, "at delay_s, of at most 1");
  board_view.fields_init()
      .field("name", &session::BoardView::name, "the folder's name")
      .field("detections", &session::BoardView::detections, "")
      .field("light_points", &session::BoardView::light_points, "by device numbers of join()'s `devices`");
  reading.fields_init()
      .field("camera", &session::Reading::camera, "device numbers of join()'s `devices`")
      .field("projector", &session::Reading::projector, "device numbers of join()'s `devices`")
      .field("in_camera", &session::Reading::in_camera, "")
      .field("in_projector", &session::Reading::in_projector, "")
      .field("light_points", &session::Reading::light_points, "");
  projected_board_points.fields_init()
      .field("points", &session::ProjectedBoardPoints::points, "")
      .field("flat_lit", &session::ProjectedBoardPoints::flat_lit, "the same view under flat light")
      .field("diagnostics", &session::ProjectedBoardPoints::diagnostics, "why there are no points");
  projected_board_capture.fields_init()
      .field("light", &session::ProjectedBoardCapture::light,
             "the points found, the flat-lit image, warnings")
      .field("pattern", &session::ProjectedBoardCapture::pattern, "as used")
      .field("inputs", &session::ProjectedBoardCapture::inputs, "");
  shown_flags.fields_init()
      .field("shown", &session::ShownFlags::shown, "shown.json, or the frame that was shown in all views")
      .field("upright", &session::ShownFlags::upright, "");
  photographed_view.fields_init()
      .field("name", &session::PhotographedView::name, "")
      .field("photograph", &session::PhotographedView::photograph, "")
      .field("unlit", &session::PhotographedView::unlit, "empty where there is none")
      .field("board", &session::PhotographedView::board, "index into ShownViews::boards");
  shown_views.fields_init()
      .field("boards", &session::ShownViews::boards, "")
      .field("views", &session::ShownViews::views, "")
      .field("files", &session::ShownViews::files, "shown.json and frames that were read")
      .field("projector_size", &session::ShownViews::projector_size, "")
      .field("upright", &session::ShownViews::upright, "");
  planned_view.fields_init()
      .field("name", &session::PlannedView::name, "")
      .field("stacks", &session::PlannedView::stacks, "");
  captured_light.fields_init()
      .field("view", &session::CapturedLight::view, "")
      .field("camera", &session::CapturedLight::camera, "")
      .field("projector", &session::CapturedLight::projector, "")
      .field("light", &session::CapturedLight::light, "")
      .field("flat_lit", &session::CapturedLight::flat_lit, "the same view under flat light")
      .field("inputs", &session::CapturedLight::inputs, "");
  open_options.fields_init()
      .field("stated", &session::OpenOptions::stated, "pattern, sizes, board, step")
      .field("shown", &session::OpenOptions::shown, "of a session of one photograph a view")
      .field("needs_board", &session::OpenOptions::needs_board,
             "False: the light on whatever it falls on is read");
  session_contents.fields_init()
      .field("correspondences", &session::SessionContents::correspondences, "")
      .field("inputs", &session::SessionContents::inputs, "every file that was read")
      .field("options", &session::SessionContents::options, "pattern, sizes, board: for the rig's provenance")
      .field("views", &session::SessionContents::views, "given, also those without enough points")
      .field("title", &session::SessionContents::title, "of the report: the folder's or the file's name");
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
      .field("replace", &session::SimulationOptions::replace, "remove an earlier simulated session");
  simulated_folder.fields_init()
      .field("views", &session::SimulatedFolder::views, "")
      .field("frames_per_view", &session::SimulatedFolder::frames_per_view, "")
      .field("pattern", &session::SimulatedFolder::pattern, "")
      .field("board", &session::SimulatedFolder::board, "")
      .field("projector_size", &session::SimulatedFolder::projector_size, "");

  using session::SessionPattern;
  session_pattern.def(py::init<>())
      .def("text", &SessionPattern::text, "As session.json states it; make_pattern() reads it back.")
      .def("describe", &SessionPattern::describe, "For people: how many frames of which kinds.")
      .def("frames", &SessionPattern::frames,
           "What the projector shows, uint8 (h, w) or (h, w, 3) of its size, in the order of\n"
           "capture.")
      .def("frame_count", &SessionPattern::frame_count)
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
           "One board pose from its captures, frame by frame. Throws Error(kInput) for captures\n"
           "that are not of this pattern.",
           py::arg("view_name"), py::arg("captures"), py::arg("board"),
           py::call_guard<py::gil_scoped_release>())
      .def("read_light", &SessionPattern::read_light,
           "The points of a projected board, with no printed board round it; None of patterns\n"
           "that have none.",
           py::arg("captures"), py::call_guard<py::gil_scoped_release>());
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
  coverage.init([](ImageSize device) { return session::Coverage(device); }, "", py::arg("device"))
      .method("add", &session::Coverage::add,
              "One view's points, in pixels of the device, (n, 2). Fewer than three cover nothing.",
              py::arg("points"))
      .method("add_dense", &session::Coverage::add_dense,
              "One view's points, so dense that each cell which the view covers holds one, (n, 2).",
              py::arg("points"))
      .method("share", &session::Coverage::share, "Of the device's area, 0..1.")
      .method("emptiest_part", &session::Coverage::emptiest_part,
              "The ninth of the picture that is covered least, in words; empty when none is below a\n"
              "half.")
      .method("views", &session::Coverage::views,
              "Views that covered each cell of the raster; its longer side has 160 cells.")
      .method("points", &session::Coverage::points, "All points so far, in cells of the raster.");

  function(m, "compare", &session::compare,
           "Throws std::invalid_argument for images of two sizes or more than one channel.", py::arg("a"),
           py::arg("b"), py::arg("noise"));
  function(m, "measure_noise", &session::measure_noise,
           "The noise of single frames, from frames of one unchanging scene: variance at_black +\n"
           "per_level * grey through the medians of the blocks' half mean squared differences,\n"
           "so that a torn part does not count as noise, and its departure from this line by the\n"
           "pixels near each knot. At least 1/12, the rounding. Needs two frames or more of one\n"
           "size.",
           py::arg("frames"));
  function(m, "measure_noise_of_scenes", &session::measure_noise_of_scenes,
           "The same from several scenes, each with frames of its own: a dark one shows the\n"
           "noise of dark pixels, which is the largest of cameras with a gamma.",
           py::arg("scenes"));
  function(m, "check_exposure", &session::check_exposure, "", py::arg("white"), py::arg("black"),
           py::arg("noise"));
  function(m, "combine", &session::combine,
           "One view of all that its cameras read while its projectors shone one after the\n"
           "other; devices without a reading saw nothing.\n"
           "\n"
           "A camera that read several projectors has found each corner several times, in\n"
           "pictures of one print that barely moved: it is one measurement, their mean, with the\n"
           "covariance of one (what moves a corner, blur and the pixels' grid, moves it in all\n"
           "of them). The light was read where each picture had the corner; it is carried to the\n"
           "mean by the homography from the camera's picture to the projector's, which is good\n"
           "for the small part of a pixel that this takes. Throws std::invalid_argument for\n"
           "device numbers that are no camera and projector.",
           py::arg("name"), py::arg("devices"), py::arg("readings"));
  function(m, "join", &session::join,
           "Correspondences of all views in which a camera sees at least four points, and the\n"
           "others as many as they have. Diagnostics of the detections are kept, their view\n"
           "named; a rejected view is warned of (\"view_left_out\"). Light points travel with\n"
           "their view. Throws Error(kInput), naming the view, where an image's size is not the\n"
           "device's, and Error(kNotEnoughData) when no view is left.",
           py::arg("board"), py::arg("devices"), py::arg("views"));
  function(m, "pattern_help", &session::pattern_help,
           "The table as help for --pattern: \"gray (...) | phase (...)\".");
  function(m, "numbered", &session::numbered, "\"view_07\", \"frame_12.png\": at least two digits.",
           py::arg("stem"), py::arg("number"), py::arg("extension") = "");
  function(m, "make_folder", &session::make_folder, "Makes the folder unless it is there. Throws Error(kIo).",
           py::arg("folder"));
  function(m, "require_same_session", &session::require_same_session,
           "Throws Error(kInput) when the folder holds a session of another pattern, size, step\n"
           "or board.",
           py::arg("folder"), py::arg("session"));
  function(m, "is_complete", &session::is_complete, "session/view_NN of an earlier run, complete?",
           py::arg("session"), py::arg("view"));
  function(m, "make_checks_folder", &session::make_checks_folder,
           "session/.checks_N: a new folder for the frames of the checks.", py::arg("session"));
  function(m, "read_projected_board", &session::read_projected_board,
           "Reads the captures of `pattern`; empty: what session.json states, in the folder or\n"
           "the one above. Throws Error(kInput) for a pattern that is no projected board, for\n"
           "images of another size than the camera's, and where the pattern is not found.",
           py::arg("captures"), py::arg("pattern"), py::arg("projector_size"), py::arg("camera_size"));
  function(m, "pattern_text", &session::pattern_text,
           "As --pattern states it; of photographs \"shown\", of decoded maps \"decoded\".", py::arg("plan"));
  function(m, "read_observations", &session::read_observations,
           "A table of observations (io/session/observations_file.hpp); `devices` and `board` as\n"
           "far as the caller knows them. Views without four points in any camera are rejected\n"
           "with a warning, as in a session of images. Throws as io::load_observations().",
           py::arg("file"), py::arg_v("devices", std::vector<Device>{}, "()"), py::arg("board") = py::none());
  function(m, "read_board_images", &session::read_board_images,
           "The images of a folder (png, jpg, bmp, tif), each one view of the board by one\n"
           "camera called \"camera\". Images whose size is not that of most are rejected by name.\n"
           "Throws Error(kInput) for a folder without images and for images without the board,\n"
           "Error(kIo) for what cannot be read.",
           py::arg("folder"), py::arg("board"), py::arg("progress") = py::none());
  function(m, "read_board_image", &session::read_board_image,
           "The board's points in one image file. Throws Error(kIo), Error(kInput) for what\n"
           "cannot be read.",
           py::arg("file"), py::arg("board"));
  function(m, "provenance", &session::provenance,
           "For the rig that was solved from the contents: `program`, procam's version, the time\n"
           "(SOURCE_DATE_EPOCH where it is set:\n"
           "https://reproducible-builds.org/specs/source-date-epoch), what was read.",
           py::arg("contents"), py::arg("program"));
  function(m, "session_devices", &session::session_devices,
           "The devices of a session with one of each, in the order of kCameraDevice,\n"
           "kProjectorDevice.",
           py::arg("camera_size"), py::arg("projector_size"));
  function(m, "settings_help", &session::settings_help,
           "The keys of `settings` with an example and their meaning, for --help.");
  function(m, "write_simulated_session", &session::write_simulated_session,
           "The folder appears whole or not at all. Throws Error(kIo) for a folder that is not\n"
           "empty (unless `replace`, and then for one that is no simulated session),\n"
           "Error(kInput) for settings that cannot be read, Error(kUnsupported) for `markers`,\n"
           "`check` and `board` with several devices, and as make_session() does.",
           py::arg("folder"), py::arg("options"), py::arg("progress") = py::none());

  function(m, "open", &session::open,
           "What is to be read, without reading an image: `options` first, then session.json;\n"
           "without either the pattern is \"gray\". Throws Error(kInput) naming the flag that\n"
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
  function(m, "read_light", &session::read_light,
           "Which projector pixel lights each camera pixel, of the view of that name or of the\n"
           "only one. Throws Error(kInput).",
           py::arg("plan"), py::arg("view") = "");
  function(m, "make_pattern", &session::make_pattern,
           "\"gray\", a name with parameters after a colon, or a pattern file (.json,\n"
           "io/session/pattern_file.hpp). Throws Error(kInput) with the names there are.",
           py::arg("text"), py::arg("projector_size"), py::arg("step") = 1);
  function(m, "describe_session", &session::describe_session, "session.json's contents.", py::arg("pattern"),
           py::arg("projector_size"), py::arg("board"), py::arg("step"));
  function(
      m, "turn_left_to_right",
      [](ImageU8 image) {
        session::turn_left_to_right(image);
        return image;
      },
      "u -> width - 1 - u, in a new array.", py::arg("image"));
  function(
      m, "draw",
      [](const std::vector<session::Coverage>& devices) {
        std::vector<const session::Coverage*> pointers;
        for (const session::Coverage& one : devices) pointers.push_back(&one);
        return session::draw(pointers);
      },
      "Side by side, three channels: dark where nothing was, greener with each view, points\n"
      "white.",
      py::arg("devices"));

  m.attr("kCameraDevice") = session::kCameraDevice;
  m.attr("kProjectorDevice") = session::kProjectorDevice;
  m.attr("kDecodedMaps") = session::kDecodedMaps;
}

}  // namespace procam::python
