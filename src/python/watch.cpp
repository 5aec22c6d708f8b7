// procam.watch: where the light of a running show is
#include "procam/watch/watch.hpp"

#include "bind.hpp"
#include "components.hpp"
#include "procam/watch/correction.hpp"
#include "procam/watch/marks.hpp"
#include "scene.hpp"

namespace procam::python {
namespace {

/// The arrays live as long as the light.
struct HeldLight {
  py::array frame, next;
  watch::ShownLight light;
};

ViewU8 held_frame(py::array& held, const Arg<ViewU8>& given, const char* name) {
  const Where where{"ShownLight", name};
  held = image_array<std::uint8_t>(given.object, where, image_expected<std::uint8_t>());
  if (!is_image_in_place(held)) held = py::array_t<std::uint8_t, py::array::c_style>(held);
  return view_in_place<const std::uint8_t>(held, static_cast<const std::uint8_t*>(held.data()));
}

void bind_light(py::module_& m) {
  Record<HeldLight>(
      m, "ShownLight",
      "The light that the camera sees: (1 - share) of one frame and `share` of the next one, which\n"
      "comes `interval` seconds later. Frames have the projector's size, grey or RGB; they are looked\n"
      "at in place.")
      .init(
          [](const Arg<ViewU8>& frame, const std::optional<Arg<ViewU8>>& next, double share,
             double interval) {
            HeldLight made;
            made.light.frame = held_frame(made.frame, frame, "frame");
            made.light.next = next ? held_frame(made.next, *next, "next") : made.light.frame;
            made.light.share = share;
            made.light.interval = interval;
            return made;
          },
          "Without `next` the frame stands still.", py::arg("frame"), py::arg_v("next", py::none()),
          py::arg_v("share", 0.0), py::arg_v("interval", 0.0));
}

void bind_geometry(py::module_& m) {
  Record<watch::WatchedSurface>(m, "WatchedSurface", "A plane surface that light falls on.")
      .fields_init()
      .field("name", &watch::WatchedSurface::name, "")
      .field("rig_from_surface", &watch::WatchedSurface::rig_from_surface, "x, y on it, z into the wall")
      .field("outline", &watch::WatchedSurface::outline,
             "a simple polygon on z = 0, metres: where light is certain to fall on it");
  Record<watch::GeometryOptions>(m, "GeometryOptions", "How the light's geometry is divided into cells.")
      .fields_init()
      .field("max_width", &watch::GeometryOptions::max_width, "of the working image, pixels")
      .field("cell", &watch::GeometryOptions::cell, "side of a cell, working pixels")
      .field("cell_spacing", &watch::GeometryOptions::cell_spacing,
             "between the centres of neighbouring cells");
  Record<watch::LitCell>(m, "LitCell", "Centre of a cell.")
      .fields_init()
      .field("pixel", &watch::LitCell::pixel, "working pixel of the centre; whole numbers")
      .field("projector_pixel", &watch::LitCell::projector_pixel, "that lights it")
      .field("surface", &watch::LitCell::surface, "its index")
      .field("point_in_rig", &watch::LitCell::point_in_rig, "metres")
      .field("ray_in_rig", &watch::LitCell::ray_in_rig, "direction of its light, unit length")
      .field("normal_in_rig", &watch::LitCell::normal_in_rig, "of the surface")
      .field("pixel_by_point", &watch::LitCell::pixel_by_point,
             "d (working pixel) / d (point in the rig's frame), per metre, (2, 3)")
      .method("by_projector", &watch::LitCell::by_projector,
              "Displacement of the light on the wall by a left increment of the projector's pose, (3, 6).")
      .method("by_surface", &watch::LitCell::by_surface, "... and of its surface's pose, (3, 6).")
      .method("across_surface", &watch::LitCell::across_surface,
              "Displacement of the light across the surface when the surface moves, (3, 6).");
  Record<watch::LightGeometry>(
      m, "LightGeometry", "Where a camera of the rig sees each projector pixel's light on known surfaces.")
      .constant("camera_size", &watch::LightGeometry::camera_size, "")
      .constant("working_size", &watch::LightGeometry::working_size, "")
      .constant("projector_size", &watch::LightGeometry::projector_size, "")
      .constant("average", &watch::LightGeometry::average, "camera pixels a working pixel, along a side")
      .constant("projector_px_per_px", &watch::LightGeometry::projector_px_per_px,
                "projector pixels a working pixel, median over the cells")
      .constant("half_cell", &watch::LightGeometry::half_cell, "working pixels")
      .constant("node_pixel", &watch::LightGeometry::node_pixel,
                "float32 (rows, columns, 2): projector pixel at each node, every 8 working pixels")
      .constant("node_surface", &watch::LightGeometry::node_surface,
                "int16 (rows, columns): index of the surface; -1: no known light there")
      .constant("surfaces", &watch::LightGeometry::surfaces, "names")
      .constant("cells", &watch::LightGeometry::cells, "")
      .method("is_lit", &watch::LightGeometry::is_lit,
              "Is the working pixel between four nodes of one surface?", py::arg("x"), py::arg("y"));
  function(m, "watched_surfaces", &watch::watched_surfaces,
           "The plane surfaces of a set, with the quadrilateral of their content.", py::arg("solved"),
           py::arg("projector"));
  function(m, "light_geometry", &watch::light_geometry, "ValueError for options out of range.",
           py::arg("camera"), py::arg("projector"), py::arg("surfaces"),
           py::arg_v("options", watch::GeometryOptions{}, "GeometryOptions()"));
}

void bind_cells(py::module_& m) {
  Enum<watch::CellState>(m, "CellState", "What a cell of the image tells.")
      .value("kMeasured", watch::CellState::kMeasured)
      .value("kFlat", watch::CellState::kFlat, "the frame has no texture there")
      .value("kClipped", watch::CellState::kClipped, "the camera is overexposed there")
      .value("kMismatch", watch::CellState::kMismatch, "the camera sees something else there");
  Record<watch::CameraTone>(m, "CameraTone",
                            "grey ~ (ambient + light)^(1 / gamma), full projected light being 1.")
      .fields_init()
      .field("gamma", &watch::CameraTone::gamma, "grey ~ light^(1 / gamma)")
      .field("ambient", &watch::CameraTone::ambient,
             "light beside the projector's, full projected light being 1");
  Record<watch::CompareOptions>(m, "CompareOptions",
                                "How an image is compared with the light that was predicted.")
      .fields_init()
      .field("tone", &watch::CompareOptions::tone, "")
      .field("noise", &watch::CompareOptions::noise,
             "standard deviation of a camera pixel, grey levels: the least that is assumed")
      .field("max_shift", &watch::CompareOptions::max_shift, "of the search about the start, working pixels")
      .field("max_sigma", &watch::CompareOptions::max_sigma,
             "a cell is textured if its better direction can be measured to this, working pixels")
      .field("max_misfit", &watch::CompareOptions::max_misfit, "residual RMS over the fitted contrast")
      .field("max_steps", &watch::CompareOptions::max_steps, "");
  Record<watch::CellShift>(m, "CellShift",
                           "How far the light of one cell is from its predicted place, working pixels.")
      .fields_init()
      .field("cell", &watch::CellShift::cell, "in LightGeometry.cells")
      .field("state", &watch::CellShift::state, "")
      .field("shift", &watch::CellShift::shift,
             "where the light is minus where it was predicted, working pixels")
      .field("information", &watch::CellShift::information, "of the shift, (2, 2)")
      .field("by_delay", &watch::CellShift::by_delay,
             "apparent shift if the frame was seen a second later than assumed")
      .field("gain", &watch::CellShift::gain, "grey levels")
      .field("offset", &watch::CellShift::offset, "grey levels")
      .field("misfit", &watch::CellShift::misfit, "residual RMS over the contrast");
  Record<watch::ImageComparison>(m, "ImageComparison", "The shifts of all cells of one image.")
      .fields_init()
      .field("cells", &watch::ImageComparison::cells, "one for each cell of the geometry")
      .field("textured", &watch::ImageComparison::textured, "cells that are not flat")
      .field("measured", &watch::ImageComparison::measured, "")
      .field("gain", &watch::ImageComparison::gain, "near 0: the light is not seen")
      .field("correlation", &watch::ImageComparison::correlation, "of image and prediction, at the start")
      .field("offset", &watch::ImageComparison::offset, "median of the measured cells")
      .field("image_mean", &watch::ImageComparison::image_mean, "grey levels, over lit pixels")
      .field("image_deviation", &watch::ImageComparison::image_deviation, "grey levels, over lit pixels")
      .field("start", &watch::ImageComparison::start, "the common shift at which the search began");
  function(
      m, "compare",
      [](const watch::LightGeometry& geometry, const HeldLight& light, ViewU8 image, const Vec2& start,
         const watch::CompareOptions& options) {
        return watch::compare(geometry, light.light, image, start, options);
      },
      "How far the light is from where it was predicted, cell by cell of the camera's image.\n"
      "ValueError for images of other sizes than the geometry's.",
      py::arg("geometry"), py::arg("light"), py::arg("image"),
      py::arg_v("start", Vec2(Vec2::Zero()), "zeros(2)"),
      py::arg_v("options", watch::CompareOptions{}, "CompareOptions()"));
  function(
      m, "fit_tone",
      [](const watch::LightGeometry& geometry, const HeldLight& light, ViewU8 image, const Vec2& start,
         const watch::CompareOptions& options) {
        return watch::fit_tone(geometry, light.light, image, start, options);
      },
      "The tone of a few candidates that explains the image best; that of the options without texture.",
      py::arg("geometry"), py::arg("light"), py::arg("image"),
      py::arg_v("start", Vec2(Vec2::Zero()), "zeros(2)"),
      py::arg_v("options", watch::CompareOptions{}, "CompareOptions()"));
}

void bind_movement(py::module_& m) {
  Enum<watch::MovedThing>(m, "MovedThing", "What moved.")
      .value("kNothing", watch::MovedThing::kNothing)
      .value("kProjector", watch::MovedThing::kProjector)
      .value("kSurface", watch::MovedThing::kSurface)
      .value("kRig", watch::MovedThing::kRig);
  Record<watch::Explanation>(m, "Explanation", "One explanation of the shifts.")
      .fields_init()
      .field("thing", &watch::Explanation::thing, "")
      .field("name", &watch::Explanation::name, "the projector's, the surface's, \"rig\", or \"nothing\"")
      .field("moved", &watch::Explanation::moved,
             "Left increment in the rig's frame: true rig_from_thing = exp(moved) rig_from_thing; of the\n"
             "rig in the room, that of all surfaces.")
      .field("covariance", &watch::Explanation::covariance, "of `moved`")
      .field("shift", &watch::Explanation::shift, "of the thing's centre, metres")
      .field("cost", &watch::Explanation::cost, "of the best fit; differences count")
      .field("log_evidence", &watch::Explanation::log_evidence, "differences count")
      .field("probability", &watch::Explanation::probability,
             "among the explanations, all as probable before")
      .field("error", &watch::Explanation::error, "of the light across its surface, metres RMS")
      .field("error_sigma", &watch::Explanation::error_sigma, "its standard deviation, metres")
      .field("is_before", &watch::Explanation::is_before,
             "of a surface: nearer by 0.1 m or more, maybe something that stands before it");
  Record<watch::MovementOptions>(m, "MovementOptions",
                                 "Which movements are considered, and when they are believed.")
      .fields_init()
      .field("bump_rotation", &watch::MovementOptions::bump_rotation,
             "one standard deviation an axis, radians")
      .field("bump_translation", &watch::MovementOptions::bump_translation, "metres")
      .field("projector_covariance", &watch::MovementOptions::projector_covariance,
             "of rig_from_projector relative to the camera, left increments")
      .field("model_rotation", &watch::MovementOptions::model_rotation, "left by the models, radians")
      .field("model_translation", &watch::MovementOptions::model_translation, "left by the models, metres")
      .field("surface_rotation", &watch::MovementOptions::surface_rotation, "to which each surface is known")
      .field("surface_translation", &watch::MovementOptions::surface_translation,
             "to which each surface is known")
      .field("delay_sigma", &watch::MovementOptions::delay_sigma,
             "of the moment that the camera saw, seconds")
      .field("cell_sigma", &watch::MovementOptions::cell_sigma,
             "systematic error of a cell, working pixels, an axis")
      .field("rejection", &watch::MovementOptions::rejection,
             "chi-square of a cell above which it is rejected");
  Record<watch::MovementEstimate>(m, "MovementEstimate", "What moved, by the shifts of many cells.")
      .fields_init()
      .field("cells", &watch::MovementEstimate::cells, "that take part")
      .field("rejected", &watch::MovementEstimate::rejected, "measured cells that contradict the others")
      .field("chi2", &watch::MovementEstimate::chi2, "of the test")
      .field("degrees_of_freedom", &watch::MovementEstimate::degrees_of_freedom,
             "0: the cells determine nothing")
      .field("probability", &watch::MovementEstimate::probability, "of a chi2 as large without a movement")
      .field("of_others", &watch::MovementEstimate::of_others,
             "the largest probability without a neighbourhood of 3 x 3 cells")
      .field("scatter", &watch::MovementEstimate::scatter, "residuals over their expected size, at least 1")
      .field("delay", &watch::MovementEstimate::delay, "seconds: the camera saw later than assumed")
      .field("explanations", &watch::MovementEstimate::explanations, "the most probable first")
      .field("weights", &watch::MovementEstimate::weights, "of each given shift, 0: rejected or not measured")
      .method(
          "plausible",
          [](const watch::MovementEstimate& self, double more) {
            std::vector<watch::Explanation> found;
            for (const watch::Explanation* one : self.plausible(more)) found.push_back(*one);
            return found;
          },
          "Explanations whose cost is at most so much above the smallest, the best fit first.",
          py::arg_v("more", 16.0));
  Record<watch::RigInformation>(m, "RigInformation",
                                "log p(shifts | x) = score . x - x^T information x / 2 + const, for\n"
                                "rig_from_world = exp(x) rig_from_world.")
      .fields_init()
      .field("information", &watch::RigInformation::information, "(6, 6)")
      .field("score", &watch::RigInformation::score, "(6,)")
      .field("cells", &watch::RigInformation::cells, "that take part; 0: none is known");
  function(m, "estimate_movement", &watch::estimate_movement,
           "What moved: the projector in the rig, one surface, or the rig in the room.", py::arg("geometry"),
           py::arg("projector"), py::arg("shifts"),
           py::arg_v("options", watch::MovementOptions{}, "MovementOptions()"));
  function(m, "rig_information", &watch::rig_information,
           "What one image tells of the rig's pose in the room, if nothing else has moved.",
           py::arg("geometry"), py::arg("shifts"),
           py::arg_v("options", watch::MovementOptions{}, "MovementOptions()"));
  function(m, "agreeing_cells", &watch::agreeing_cells,
           "1 for each measured cell that agrees with the others on some movement, else 0.",
           py::arg("geometry"), py::arg("shifts"),
           py::arg_v("options", watch::MovementOptions{}, "MovementOptions()"));
  function(
      m, "projector_covariance", &watch::projector_covariance,
      "Covariance (6, 6) of the projector's pose relative to a camera of the rig; zero for a rig without one.",
      py::arg("rig"), py::arg("projector"), py::arg("camera"));
}

void bind_watch_class(py::module_& m) {
  Enum<watch::WatchState>(m, "WatchState", "What the watch believes.")
      .value("kStarting", watch::WatchState::kStarting, "no window is complete yet")
      .value("kOk", watch::WatchState::kOk, "the light is where it should be")
      .value("kSuspected", watch::WatchState::kSuspected, "one window is beyond the limit")
      .value("kMoved", watch::WatchState::kMoved, "alarm, with one plausible cause")
      .value("kInseparable", watch::WatchState::kInseparable, "alarm, with several plausible causes")
      .value("kNoTexture", watch::WatchState::kNoTexture, "the content has too little texture")
      .value("kNotSeen", watch::WatchState::kNotSeen, "the camera is covered, or sees something else")
      .value("kProjectorOff", watch::WatchState::kProjectorOff,
             "the camera sees the room without the content")
      .value("kLightSwitched", watch::WatchState::kLightSwitched, "the room's light has changed");
  function(m, "to_string", &watch::to_string, "As in logs and metrics.", py::arg("state"));
  Record<watch::WatchOptions>(m, "WatchOptions", "Times and limits of the watch.")
      .fields_init()
      .field("geometry", &watch::WatchOptions::geometry, "")
      .field("compare", &watch::WatchOptions::compare, "")
      .field("movement", &watch::WatchOptions::movement, "")
      .field("window", &watch::WatchOptions::window, "seconds")
      .field("false_alarms_a_week", &watch::WatchOptions::false_alarms_a_week,
             "expected number without any movement")
      .field("smallest_error", &watch::WatchOptions::smallest_error,
             "metres RMS on the surfaces: less is no alarm, however certain")
      .field("min_cells", &watch::WatchOptions::min_cells, "textured cells that are needed")
      .field("max_drift_step", &watch::WatchOptions::max_drift_step,
             "metres RMS from one window to the next: more is a bump")
      .field("locates_rig", &watch::WatchOptions::locates_rig,
             "a localiser places the rig: each image tells where it is, and no window is tested");
  Record<watch::WatchReport>(m, "WatchReport", "What the watch found by one image: a state and a sentence.")
      .fields_init()
      .field("time", &watch::WatchReport::time, "of the image, seconds")
      .field("state", &watch::WatchReport::state, "")
      .field("is_alarm", &watch::WatchReport::is_alarm, "moved or inseparable")
      .field("is_drift", &watch::WatchReport::is_drift, "alarm, and the error has grown slowly")
      .field("sentence", &watch::WatchReport::sentence, "for people")
      .field("textured", &watch::WatchReport::textured, "cells of this image")
      .field("measured", &watch::WatchReport::measured, "cells of this image")
      .field("median_shift", &watch::WatchReport::median_shift, "of the measured cells, camera pixels")
      .field("rig", &watch::WatchReport::rig, "with WatchOptions.locates_rig")
      .field("window_time", &watch::WatchReport::window_time, "end of the last complete window; 0: none yet")
      .field("error", &watch::WatchReport::error, "of the light on the surfaces, metres RMS")
      .field("error_sigma", &watch::WatchReport::error_sigma, "metres")
      .field("probability", &watch::WatchReport::probability, "of the test")
      .field("estimate", &watch::WatchReport::estimate, "of the last complete window");
  Record<watch::Watch>(
      m, "Watch",
      "Where the light of a running show is: image after image, without a pattern, with a stated rate\n"
      "of false alarms. The same calls in the same order give the same reports.")
      .init([](const RigCamera& camera, const RigProjector& projector,
               const watch::WatchOptions& options) { return watch::Watch(camera, projector, options); },
            "ValueError for options out of range.", py::arg("camera"), py::arg("projector"),
            py::arg_v("options", watch::WatchOptions{}, "WatchOptions()"))
      .method("place", &watch::Watch::place, "Surfaces as the projector lights them from now on.",
              py::arg("surfaces"))
      .method(
          "correct",
          [](watch::Watch& self, const RigProjector& projector, const std::optional<Mat6>& covariance) {
            self.correct(projector, covariance);
          },
          "The projector as it is now known. The alarm ends.", py::arg("projector"),
          py::arg_v("covariance", py::none()))
      .method(
          "correct",
          [](watch::Watch& self, const std::string& surface, const Vec6& moved) {
            self.correct(surface, moved);
          },
          "A surface as it is now known: exp(moved) rig_from_surface. ValueError for an unknown name.",
          py::arg("surface"), py::arg("moved"))
      .method("surfaces", &watch::Watch::surfaces, "The surfaces as they are watched now, copies.")
      .method(
          "add",
          [](watch::Watch& self, double time, const HeldLight& light, ViewU8 image) {
            const py::gil_scoped_release released;
            return self.add(time, light.light, image);
          },
          "The camera's image at `time` (seconds, growing) and the light that was shown then.",
          py::arg("time"), py::arg("light"), py::arg("image"))
      .method("geometry", &watch::Watch::geometry, "The light's geometry, a copy.")
      .method("projector", &watch::Watch::projector, "The projector as it is watched now, a copy.")
      .method("window_limit", &watch::Watch::window_limit,
              "Probability below which a window counts as moved.");
}

void bind_correction(py::module_& m) {
  Record<watch::CorrectionOptions>(m, "CorrectionOptions", "Which corrections are made.")
      .fields_init()
      .field("max_rotation", &watch::CorrectionOptions::max_rotation, "radians; more is another set-up")
      .field("max_shift", &watch::CorrectionOptions::max_shift, "metres; more is another set-up")
      .field("max_sigma", &watch::CorrectionOptions::max_sigma,
             "of the error, as a share of it: less certain waits")
      .field("surfaces", &watch::CorrectionOptions::surfaces,
             "a surface that has moved is corrected as well");
  Record<watch::Correction>(m, "Correction",
                            "The projector or surface as it stands now, with the covariance of its movement.")
      .fields_init()
      .field("projector", &watch::Correction::projector, "as it stands now")
      .field("covariance", &watch::Correction::covariance, "of `moved`")
      .field("surface", &watch::Correction::surface, "the one that moved; empty: the projector")
      .field("moved", &watch::Correction::moved, "left increment in the rig's frame")
      .field("error", &watch::Correction::error, "of the light before the correction, metres RMS")
      .field("sentence", &watch::Correction::sentence, "for people")
      .method("is_possible", &watch::Correction::is_possible, "Is there a correction?");
  Record<watch::Glide>(m, "Glide",
                       "From one pose to another, in a time in which the light moves no faster than `rate`.")
      .init([](const Pose& from, const Pose& to, double error, double begin,
               double rate) { return watch::Glide(from, to, error, begin, rate); },
            "`error`: how far the light moves, metres; `rate`: metres a second.", py::arg("from_"),
            py::arg("to"), py::arg("error"), py::arg("begin"), py::arg_v("rate", 0.005))
      .method("at", &watch::Glide::at, "The pose at this time, seconds.", py::arg("time"))
      .method("is_over", &watch::Glide::is_over, "Has it arrived at this time, seconds?", py::arg("time"));
  function(m, "correction_of", &watch::correction_of,
           "What to do about an alarm. Without an alarm nothing, and no sentence.", py::arg("report"),
           py::arg("projector"), py::arg_v("options", watch::CorrectionOptions{}, "CorrectionOptions()"));
  function(m, "corrected_rig", &watch::corrected_rig,
           "The rig with the corrected projector (not for a surface).", py::arg("rig"), py::arg("correction"),
           py::arg("camera"));
}

void bind_marks(py::module_& m) {
  Record<watch::MarkOptions>(m, "MarkOptions", "Size and contrast of marks that are added to a frame.")
      .fields_init()
      .field("diameter", &watch::MarkOptions::diameter, "share of the frame's width")
      .field("contrast", &watch::MarkOptions::contrast, "sRGB levels of 255, up and down")
      .field("fade", &watch::MarkOptions::fade, "seconds from nothing to full contrast");
  Record<watch::Marks>(m, "Marks", "Small marks on plane surfaces, where the content has no texture.")
      .init([](const watch::MarkOptions& options) { return watch::Marks(options); },
            "ValueError for options out of range.",
            py::arg_v("options", watch::MarkOptions{}, "MarkOptions()"))
      .method(
          "draw",
          [](watch::Marks& self, double time, const HeldScene& scene, const Projector& projector,
             ImageView<std::uint8_t> frame) { self.draw(time, scene_of(scene), projector, frame); },
          "Draws into the rendered frame of this scene; `time` in seconds.", py::arg("time"),
          py::arg("scene"), py::arg("projector"), py::arg("frame"));
}

}  // namespace

void bind_watch(py::module_& m) {
  bind_light(m);
  bind_geometry(m);
  bind_cells(m);
  bind_movement(m);
  bind_watch_class(m);
  bind_correction(m);
  bind_marks(m);
}

}  // namespace procam::python
