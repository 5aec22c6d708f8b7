// procam.session: checks of captures, and views joined
#include "procam/session.hpp"

#include "bind.hpp"
#include "components.hpp"

namespace procam::python {

namespace {

void bind_change(py::module_& m) {
  Record<session::Change> change(m, "Change", "How much two images of one scene differ.");
  change.fields_init()
      .field("share", &session::Change::share, "of the image's blocks that changed, 0..1")
      .field("largest", &session::Change::largest,
             "rms difference of the block that changed most beyond noise, grey levels")
      .method("any", &session::Change::any, "Has any part changed?");

  function(m, "compare", &session::compare,
           "Raises ValueError for images of two sizes or more than one channel.", py::arg("a"), py::arg("b"),
           py::arg("noise"));
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
}

void bind_checks(py::module_& m) {
  Record<session::ExposureCheck> exposure_check(
      m, "ExposureCheck",
      "Flat white and flat black: what the projector lights, and how the camera is exposed.");
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

  Record<session::ToneCheck> tone_check(m, "ToneCheck", "A ramp of flat pictures, up and down again.");
  tone_check.fields_init()
      .field("gamma", &session::ToneCheck::gamma,
             "of projector and camera together: seen ~ shown^gamma between black and white")
      .field("drift", &session::ToneCheck::drift,
             "largest difference of the two ways at one level, as a share of white minus black")
      .field("diagnostics", &session::ToneCheck::diagnostics,
             "Warnings \"light_drifts\" (more than 3 %: an automatic is on), \"not_monotone\",\n"
             "\"clipped\" (the brightest step adds less than 1 %).");

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
  native_check.fields_init()
      .field("beat", &session::NativeCheck::beat, "contrast of the beat, without unit")
      .field("diagnostics", &session::NativeCheck::diagnostics,
             "Failure \"resampled\" above kLargestBeat. Warning \"not_checked\" when too few pixels\n"
             "are bright and unsaturated.");

  function(m, "check_exposure", &session::check_exposure,
           "Contrast and saturation by a lit and an unlit image, uint8 (h, w).", py::arg("white"),
           py::arg("black"), py::arg("noise"));
}

void bind_delay(py::module_& m) {
  Record<session::Delay> delay(m, "Delay", "Time from the display to the camera's frame.");
  delay.fields_init()
      .field("delay_s", &session::Delay::delay_s,
             "from show() to the arrival of a frame whose exposure has its middle there")
      .field("settled_s", &session::Delay::settled_s,
             "Frames that arrive later than this after a switch showed the new picture alone:\n"
             "exposure, rolling shutter and jitter are in it, as far as they showed during the\n"
             "code. At least delay_s.")
      .field("frame_interval_s", &session::Delay::frame_interval_s, "median")
      .field("correlation", &session::Delay::correlation, "at delay_s, of at most 1");
}

void bind_board_view(py::module_& m) {
  Record<session::BoardView> board_view(
      m, "BoardView",
      "One placement of the board: what each device saw or lit of it, in the order of the\n"
      "devices.");
  board_view.fields_init()
      .field("name", &session::BoardView::name, "the folder's name")
      .field("detections", &session::BoardView::detections, "")
      .field("light_points", &session::BoardView::light_points, "by device numbers of join()'s `devices`")
      .field("decoded", &session::BoardView::decoded, "as ViewImage.decoded, for pictures of the view");

  Record<session::Reading> reading(
      m, "Reading",
      "What one camera read off one projector's patterns while the board stood in one\n"
      "place.");
  reading.fields_init()
      .field("camera", &session::Reading::camera, "device numbers of join()'s `devices`")
      .field("projector", &session::Reading::projector, "device numbers of join()'s `devices`")
      .field("in_camera", &session::Reading::in_camera, "")
      .field("in_projector", &session::Reading::in_projector, "")
      .field("light_points", &session::Reading::light_points, "");

  function(m, "combine", &session::combine,
           "One view of all that its cameras read while its projectors shone one after the\n"
           "other; devices without a reading saw nothing.\n"
           "\n"
           "A camera that read several projectors has found each corner several times, in\n"
           "pictures of one print that barely moved: it is one measurement, their mean, with the\n"
           "covariance of one (what moves a corner, blur and the pixels' grid, moves it in all\n"
           "of them). The light was read where each picture had the corner; it is carried to the\n"
           "mean by the homography from the camera's picture to the projector's, which is good\n"
           "for the small part of a pixel that this takes. Raises ValueError for\n"
           "device numbers that are no camera and projector.",
           py::arg("name"), py::arg("devices"), py::arg("readings"));
  function(m, "join", &session::join,
           "Correspondences of all views in which a camera sees at least four points, and the\n"
           "others as many as they have. Diagnostics of the detections are kept, their view\n"
           "named; a rejected view is warned of (\"view_left_out\"). Light points travel with\n"
           "their view. Raises Error(kInput), naming the view, where an image's size is not the\n"
           "device's, and Error(kNotEnoughData) when no view is left.",
           py::arg("board"), py::arg("devices"), py::arg("views"));
}

void bind_projected_board_views(py::module_& m) {
  Record<session::ProjectedBoardPoints> projected_board_points(
      m, "ProjectedBoardPoints", "A projected board by itself, on whatever it falls.");
  projected_board_points.fields_init()
      .field("points", &session::ProjectedBoardPoints::points, "")
      .field("flat_lit", &session::ProjectedBoardPoints::flat_lit, "the same view under flat light")
      .field("diagnostics", &session::ProjectedBoardPoints::diagnostics, "why there are no points");

  Record<session::ProjectedBoardCapture> projected_board_capture(
      m, "ProjectedBoardCapture", "A projected board that was read from captures.");
  projected_board_capture.fields_init()
      .field("light", &session::ProjectedBoardCapture::light,
             "the points found, the flat-lit image, warnings")
      .field("pattern", &session::ProjectedBoardCapture::pattern, "as used")
      .field("inputs", &session::ProjectedBoardCapture::inputs, "");

  function(m, "read_projected_board", &session::read_projected_board,
           "Reads the captures of `pattern`; empty: what session.json states, in the folder or\n"
           "the one above. Raises Error(kInput) for a pattern that is no projected board, for\n"
           "images of another size than the camera's, and where the pattern is not found.",
           py::arg("captures"), py::arg("pattern"), py::arg("projector_size"), py::arg("camera_size"));
}

void bind_shown_views(py::module_& m) {
  Record<session::ShownFlags> shown_flags(m, "ShownFlags", "What flags state of such a session.");
  shown_flags.fields_init()
      .field("shown", &session::ShownFlags::shown, "shown.json, or the frame that was shown in all views")
      .field("upright", &session::ShownFlags::upright, "");

  Record<session::PhotographedView> photographed_view(m, "PhotographedView",
                                                      "One photograph, and which board it shows.");
  photographed_view.fields_init()
      .field("name", &session::PhotographedView::name, "")
      .field("photograph", &session::PhotographedView::photograph, "")
      .field("unlit", &session::PhotographedView::unlit, "empty where there is none")
      .field("board", &session::PhotographedView::board, "index into ShownViews::boards");

  Record<session::ShownViews> shown_views(m, "ShownViews",
                                          "Photographs of shown frames, with the boards in them.");
  shown_views.fields_init()
      .field("boards", &session::ShownViews::boards, "")
      .field("views", &session::ShownViews::views, "")
      .field("files", &session::ShownViews::files, "shown.json and frames that were read")
      .field("projector_size", &session::ShownViews::projector_size, "")
      .field("upright", &session::ShownViews::upright, "");
}

void bind_coverage(py::module_& m) {
  Record<session::Coverage> coverage(m, "Coverage", "Which parts of a device's picture the views cover.");
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
}

}  // namespace

void bind_session_views(py::module_& m) {
  bind_change(m);
  bind_checks(m);
  bind_delay(m);
  bind_board_view(m);
  bind_projected_board_views(m);
  bind_shown_views(m);
  bind_coverage(m);
}

}  // namespace procam::python
