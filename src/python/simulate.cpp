// procam.simulate
#include "procam/simulate.hpp"

#include "bind.hpp"
#include "components.hpp"

namespace procam::python {

namespace {

void bind_world(py::module_& m) {
  Record<simulate::PrintedBoard> printed_board(
      m, "PrintedBoard", "A board printed on a white sheet. The back of the sheet is white.");
  printed_board.fields_init()
      .field("layout", &simulate::PrintedBoard::layout, "")
      .field("margin", &simulate::PrintedBoard::margin, "white paper round the print, metres")
      .field("white_albedo", &simulate::PrintedBoard::white_albedo, "0..1")
      .field("black_albedo", &simulate::PrintedBoard::black_albedo,
             "share of the light that is reflected, 0 .. 1")
      .field("blank", &simulate::PrintedBoard::blank, "more white paper to the right and below, metres")
      .field("sheet", &simulate::PrintedBoard::sheet,
             "what the paper is: z of print, margin and blank paper alike")
      .field("artwork", &simulate::PrintedBoard::artwork,
             "What is black (detect::board_artwork). A chessboard's squares need none.");

  Record<simulate::ThinLens> thin_lens(
      m, "ThinLens",
      "A lens of which one distance is in focus. A point at depth z along the axis becomes\n"
      "a disc of\n"
      "\n"
      "  diameter = aperture f |1/z - 1/focus|   pixels,   f = sqrt(fx fy)\n"
      "\n"
      "As f = image distance / pixel, this is exact for the thin lens. Discs of more than\n"
      "48 pixels are drawn with 48.");
  thin_lens.fields_init()
      .field("aperture", &simulate::ThinLens::aperture,
             "diameter, metres: focal length / f-number; 0: all is in focus")
      .field("focus", &simulate::ThinLens::focus, "depth of the plane in focus, metres");

  Record<simulate::World> world(m, "World", "A true world: rig, printed board, wall and light.");
  world.fields_init()
      .field("rig", &simulate::World::rig, "one camera, one projector")
      .field("board", &simulate::World::board, "printed")
      .field("rig_from_board", &simulate::World::rig_from_board, "")
      .field("wall_in_rig", &simulate::World::wall_in_rig, "")
      .field("wall_albedo", &simulate::World::wall_albedo, "share of the light that is reflected, 0 .. 1")
      .field("ambient", &simulate::World::ambient, "irradiance, in units of the projector's at one metre");

  Record<simulate::ProjectorMap> projector_map(
      m, "ProjectorMap", "projector_pixel_seen_at() for the centres of all camera pixels.");
  projector_map.fields_init()
      .field("pixel", &simulate::ProjectorMap::pixel, "two channels, x and y; 0 where not lit")
      .field("lit", &simulate::ProjectorMap::lit, "1 where projector light arrives, else 0");
}

void bind_world_geometry(py::module_& m) {
  function(m, "rig_from_wall", &simulate::rig_from_wall,
           "A surface frame on the wall: origin where the camera's axis meets it, x as the\n"
           "camera's, z into the wall. Raises ValueError when the camera does not\n"
           "face the wall.",
           py::arg("world"));
  function(m, "with_bare_wall", &simulate::with_bare_wall,
           "The world before its wall alone: the sheet is behind the camera, as far away as the\n"
           "wall (so that captures are exposed as for a sheet on the wall).",
           py::arg("world"));
  function(m, "sheet_corners_in_board", &simulate::sheet_corners_in_board,
           "The sheet's corners in the board's frame, clockwise from the origin's, metres.",
           py::arg("board"));
  function(m, "board_in_camera", &simulate::board_in_camera,
           "The board's points that fall on the camera's image / that the projector's picture\n"
           "covers, at their exact pixels. Occlusion is ignored: nothing stands before the\n"
           "board.",
           py::arg("world"));
  function(m, "board_in_projector", &simulate::board_in_projector,
           "The true projector pixels of the board's points.", py::arg("world"));
  function(m, "camera_pixel_of_light", &simulate::camera_pixel_of_light,
           "Where the camera sees that light; None where it falls outside the sheet or the\n"
           "image.",
           py::arg("world"), py::arg("projector_pixel"));
  function(m, "projector_pixel_seen_at", &simulate::projector_pixel_seen_at,
           "The projector pixel whose light falls on the surface point that a camera pixel sees;\n"
           "None where the camera sees nothing, or where no projector light arrives (outside\n"
           "its picture, in the board's shadow, from behind).",
           py::arg("world"), py::arg("camera_pixel"));
  function(m, "projector_map", &simulate::projector_map, "The true map from camera to projector pixels.",
           py::arg("world"));
}

void bind_simulated_captures(py::module_& m) {
  Record<simulate::FrameFault> frame_fault(m, "FrameFault", "What one capture of a sequence suffers.");
  frame_fault.fields_init()
      .field("gain", &simulate::FrameFault::gain, "on the exposure")
      .field("shift_px", &simulate::FrameFault::shift_px, "of the whole image")
      .field("blur_px", &simulate::FrameFault::blur_px, "sigma, beside camera_blur_px")
      .field("ripple", &simulate::FrameFault::ripple,
             "Brightness over the rows, 1 + amplitude sin(2 pi (row / rows + phase)): mains light\n"
             "and a rolling shutter.")
      .field("ripple_rows", &simulate::FrameFault::ripple_rows,
             "Brightness over the rows, 1 + amplitude sin(2 pi (row / rows + phase)): mains light\n"
             "and a rolling shutter.")
      .field("ripple_phase", &simulate::FrameFault::ripple_phase,
             "Brightness over the rows, 1 + amplitude sin(2 pi (row / rows + phase)): mains light\n"
             "and a rolling shutter.");

  Record<simulate::CaptureOptions> capture_options(
      m, "CaptureOptions", "Noise, blur, exposure and ambient light of a simulated camera.");
  capture_options.fields_init()
      .field("brightest_grey", &simulate::CaptureOptions::brightest_grey,
             "Grey level of the brightest corner of the sheet under full projector light: sets the\n"
             "exposure of the view.")
      .field("camera_blur_px", &simulate::CaptureOptions::camera_blur_px,
             "sigma of the camera's lens, camera pixels")
      .field("projector_blur_px", &simulate::CaptureOptions::projector_blur_px,
             "sigma of the projector's lens, projector pixels")
      .field("projector_lens", &simulate::CaptureOptions::projector_lens, "")
      .field("indirect", &simulate::CaptureOptions::indirect,
             "light that surfaces reflect onto each other, share")
      .field("glare", &simulate::CaptureOptions::glare,
             "light that the camera's lens scatters over its image, share")
      .field("vignetting", &simulate::CaptureOptions::vignetting,
             "power of the cosine of the field angle; 4: the natural law of a simple lens")
      .field("gamma", &simulate::CaptureOptions::gamma, "of the camera; 1: linear")
      .field("noise", &simulate::CaptureOptions::noise, "Gaussian; variance of the linear grey value")
      .field("faults", &simulate::CaptureOptions::faults, "one a frame; empty: none")
      .field("spot", &simulate::CaptureOptions::spot,
             "A lamp's reflection, a Gaussian: `spot` times full scale in its middle.")
      .field("spot_radius_px", &simulate::CaptureOptions::spot_radius_px,
             "A lamp's reflection, a Gaussian: `spot` times full scale in its middle.")
      .field("spot_at", &simulate::CaptureOptions::spot_at, "camera pixel")
      .field("crosstalk", &simulate::CaptureOptions::crosstalk,
             "share of a neighbouring colour's light, colour frames only")
      .field("seed", &simulate::CaptureOptions::seed, "of the noise")
      .field("samples_per_axis", &simulate::CaptureOptions::samples_per_axis, "rays a camera pixel, squared")
      .field("threads", &simulate::CaptureOptions::threads,
             "0: as many as the machine has. The result does not depend on it");

  function(m, "capture", &simulate::capture,
           "One capture a projector frame (one channel or three, all alike; the projector's\n"
           "size, 0 dark .. 255 full light). Raises ValueError for frames of another\n"
           "size, options out of range, or a sheet that no light reaches.",
           py::arg("world"), py::arg("projector_frames"),
           py::arg_v("options", simulate::CaptureOptions{}, "CaptureOptions()"));
}

void bind_conditions(py::module_& m) {
  Record<simulate::Range> range(m, "Range", "Two limits.");
  range.fields_init()
      .field("low", &simulate::Range::low, "in the unit of the quantity")
      .field("high", &simulate::Range::high, "in the unit of the quantity")
      .field("either_sign", &simulate::Range::either_sign, "low .. high or -high .. -low");

  Record<simulate::Conditions> conditions(m, "Conditions",
                                          "What a simulated session varies: light, noise, poses, defects.");
  conditions.fields_init()
      .field("camera_skew_px", &simulate::Conditions::camera_skew_px, "K(0, 1)")
      .field("projector_skew_px", &simulate::Conditions::projector_skew_px, "K(0, 1)")
      .field("camera_k3", &simulate::Conditions::camera_k3, "of the Brown-Conrady lens")
      .field("camera_deviation_px", &simulate::Conditions::camera_deviation_px,
             "What the true lens does beyond its model, RMS over the picture, of sessions with boards.")
      .field("projector_deviation_px", &simulate::Conditions::projector_deviation_px,
             "the same of the projector")
      .field("projector_k3", &simulate::Conditions::projector_k3, "of the Brown-Conrady lens")
      .field("gamma", &simulate::Conditions::gamma, "of the camera")
      .field("vignetting", &simulate::Conditions::vignetting, "power of the cosine of the field angle")
      .field("indirect", &simulate::Conditions::indirect,
             "light that surfaces reflect onto each other, share of the mean light around")
      .field("glare", &simulate::Conditions::glare,
             "light that the camera's lens scatters over its image, share")
      .field("finest_contrast", &simulate::Conditions::finest_contrast,
             "Contrast of projected stripes of two pixels (Gray code's finest) where the projector\n"
             "is most out of focus within the level's working distances: (max - min) / (max +\n"
             "min). 1: in focus everywhere.")
      .field("noise", &simulate::Conditions::noise,
             "of the linear grey value; none: as in the level's recipe")
      .field("noise_factor", &simulate::Conditions::noise_factor, "on the standard deviation of the noise")
      .field("views", &simulate::Conditions::views, "0: as in the level's recipe")
      .field("dark_views", &simulate::Conditions::dark_views, "underexposed ones")
      .field("white", &simulate::Conditions::white, "their white paper, share of full scale in linear light")
      .field("overexposed_views", &simulate::Conditions::overexposed_views, "")
      .field("overexposure", &simulate::Conditions::overexposure,
             "their white paper, as a multiple of full scale")
      .field("moved_views", &simulate::Conditions::moved_views, "the board moves once during the sequence")
      .field("moved_by", &simulate::Conditions::moved_by,
             "metres; it rotates by 0.1 degrees a millimetre as well")
      .field("stale_views", &simulate::Conditions::stale_views, "one capture still shows the frame before")
      .field("missing_views", &simulate::Conditions::missing_views,
             "one frame is missing, so that all later captures show the next frame")
      .field("torn_views", &simulate::Conditions::torn_views,
             "one capture shows the next frame in its lower rows")
      .field("auto_exposure", &simulate::Conditions::auto_exposure,
             "1: the exposure keeps the image's mean; less: this power of it")
      .field("flicker", &simulate::Conditions::flicker, "amplitude over the rows, and from frame to frame")
      .field("shake_px", &simulate::Conditions::shake_px, "sigma of each frame's shift, an axis")
      .field("drift_px", &simulate::Conditions::drift_px,
             "of the camera's image over the sequence (stabiliser, soft tripod)")
      .field("projector_drift_px", &simulate::Conditions::projector_drift_px,
             "of the projected frame over the sequence, projector pixels")
      .field("focus_drift_px", &simulate::Conditions::focus_drift_px,
             "sigma of the camera's blur at the start, none at the end")
      .field("projector_gamma", &simulate::Conditions::projector_gamma,
             "of the projector: light = value^gamma; 1: linear")
      .field("iris", &simulate::Conditions::iris,
             "1: the lamp follows the mean of the frame (dynamic contrast, automatic iris); less: this\n"
             "power of it")
      .field("lag", &simulate::Conditions::lag, "share of the light before that each capture still shows")
      .field("spot", &simulate::Conditions::spot, "reflection of a lamp on the board, multiple of full scale")
      .field("bend", &simulate::Conditions::bend,
             "Metres by which the sheet rises half a metre from the print's middle, like a cylinder\n"
             "about an axis of any direction.")
      .field("flex", &simulate::Conditions::flex,
             "RMS of the rise that the sheet has anew in each view, as `bend`, metres")
      .field("refocus", &simulate::Conditions::refocus,
             "the camera focuses anew in each view: RMS of the change of its focal length, share")
      .field("stabiliser_px", &simulate::Conditions::stabiliser_px,
             "RMS of its image's displacement anew in each view (image stabiliser), an axis")
      .field("print_scale", &simulate::Conditions::print_scale,
             "true size of the print / size that the session states");

  function(m, "plain_conditions", &simulate::plain_conditions,
           "None of these effects: a linear camera without scattered light, lenses and views as\n"
           "in the recipe.");
}

void bind_view_defects(py::module_& m) {
  Record<simulate::ViewDefects> view_defects(m, "ViewDefects", "What is wrong with one view.");
  Record<simulate::ViewDefects::Move> move(
      view_defects.type, "Move",
      "At `share` of the sequence, 0 .. 1, the board moves to rig_from_board *\n"
      "board_from_moved.");
  view_defects.fields_init()
      .field("white", &simulate::ViewDefects::white,
             "share of full scale of the brightest corner of the sheet, linear light")
      .field("moved", &simulate::ViewDefects::moved, "")
      .field("stale", &simulate::ViewDefects::stale, "at this share of the sequence")
      .field("missing", &simulate::ViewDefects::missing, "at this share of the sequence")
      .field("torn", &simulate::ViewDefects::torn, "at this share of the sequence")
      .method("empty", &simulate::ViewDefects::empty, "Has the view no defect?");
  move.fields_init()
      .field("share", &simulate::ViewDefects::Move::share, "when it moves, share of the sequence, 0 .. 1")
      .field("board_from_moved", &simulate::ViewDefects::Move::board_from_moved, "");

  function(m, "frame_at", &simulate::frame_at,
           "The frame at a share of a sequence, 1 .. frames - 1; 0 for a single frame.", py::arg("share"),
           py::arg("frames"));
  function(m, "description", &simulate::description,
           "\"white at 27 % of full scale, board moved by 7.1 mm before frame 12\"; empty for\n"
           "none.",
           py::arg("defects"), py::arg("frames"));
}

void bind_session_levels(py::module_& m) {
  Enum<simulate::Level>(m, "Level", "How difficult a simulated session is.")
      .value("kEasy", simulate::Level::kEasy)
      .value("kPaper", simulate::Level::kPaper)
      .value("kHard", simulate::Level::kHard);

  function(m, "to_string", &simulate::to_string, "The level's name, e.g. \"easy\".", py::arg("level"));
  function(m, "level_named", &simulate::level_named, "Raises Error(kUnsupported) for an unknown name.",
           py::arg("name"));
  function(m, "projector_size", &simulate::projector_size, "The size of the level's projector picture.",
           py::arg("level"));
  function(m, "level_conditions", &simulate::level_conditions,
           "The level's departures from what calibration assumes: none for easy.", py::arg("level"));
}

void bind_simulated_session(py::module_& m) {
  Record<simulate::BoardPrint> board_print(
      m, "BoardPrint", "A board and its drawing (detect::board_artwork; a chessboard needs none).");
  board_print.fields_init()
      .field("layout", &simulate::BoardPrint::layout, "")
      .field("artwork", &simulate::BoardPrint::artwork, "");

  Record<simulate::SimulatedSession> simulated_session(
      m, "SimulatedSession", "A session with its truth: the views, the camera, and what was done to them.");
  simulated_session.fields_init()
      .field("level", &simulate::SimulatedSession::level, "")
      .field("views", &simulate::SimulatedSession::views,
             "one a board pose; the same rig, board and wall in each")
      .field("capture", &simulate::SimulatedSession::capture, "")
      .field("defects", &simulate::SimulatedSession::defects, "of each view; empty: none has any")
      .field("conditions", &simulate::SimulatedSession::conditions, "that it was made with")
      .field(
          "lenses", &simulate::SimulatedSession::lenses,
          "By view: the camera's lens as it was focused and stabilised there; empty: in all as the\nrig has it.")
      .field("stated_board", &simulate::SimulatedSession::stated_board,
             "as its user believes it to be: print_scale is not in it")
      .method(
          "rig",
          [](const simulate::SimulatedSession& self) {
            require(!self.views.empty(), "SimulatedSession.rig: no views");
            return self.rig();
          },
          "The true rig, a copy.")
      .method(
          "board",
          [](const simulate::SimulatedSession& self) {
            require(!self.views.empty(), "SimulatedSession.board: no views");
            return self.board();
          },
          "The printed board, a copy.");

  function(m, "make_session",
           py::overload_cast<simulate::Level, std::uint64_t, const std::optional<Eigen::AlignedBox2d>&,
                             const std::optional<simulate::BoardPrint>&>(&simulate::make_session),
           "`on_blank_paper` is the part of the projector's picture that lands on blank paper in\n"
           "every view. Raises Error(kNotConverged) when no poses are found that camera and\n"
           "projector both cover, ValueError for conditions out of range. Without\n"
           "conditions: those of the level.",
           py::arg("level"), py::arg("seed"), py::arg("on_blank_paper") = py::none(),
           py::arg("print") = py::none());
  function(m, "make_session",
           py::overload_cast<simulate::Level, std::uint64_t, const std::optional<Eigen::AlignedBox2d>&,
                             const std::optional<simulate::BoardPrint>&, const simulate::Conditions&>(
               &simulate::make_session),
           "", py::arg("level"), py::arg("seed"), py::arg("on_blank_paper"), py::arg("print"),
           py::arg("conditions"));
  function(m, "capture_view", &simulate::capture_view,
           "The captures of one view while the projector shows `frames`. Noise differs from view\n"
           "to view.",
           py::arg("session"), py::arg("view"), py::arg("frames"));
}

}  // namespace

void bind_simulate(py::module_& m) {
  bind_world(m);
  bind_world_geometry(m);
  bind_simulated_captures(m);
  bind_conditions(m);
  bind_view_defects(m);
  bind_session_levels(m);
  bind_simulated_session(m);
}

}  // namespace procam::python
