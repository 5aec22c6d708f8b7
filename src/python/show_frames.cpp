// procam.show: the frames of a projector as files, without a display
#include "procam/show.hpp"

#include "bind.hpp"
#include "components.hpp"

namespace procam::python {

namespace {

void bind_show_options(py::module_& m) {
  Record<show::ViewerInput> viewer(
      m, "ViewerInput",
      "Virtual surfaces, drawn so that an eye sees them at their places behind or before the real ones.");
  viewer.fields_init()
      .field("eye", &show::ViewerInput::eye,
             "metres, in the world; in the rig where the real surfaces have no world")
      .field("things", &show::ViewerInput::things, "file of surface definitions in metres");

  using Options = show::FrameFilesOptions;
  Record<Options> options(m, "FrameFilesOptions", "What write_frames() draws, and into which files.");
  options.fields_init()
      .field("output", &Options::output,
             "A frame: .png, or its light as floats: .exr. With `seconds` frames, \"frame_%04d.png\"\n"
             "or .exr, or a video: .mkv (lossless), .mp4, .avi.")
      .field("time_s", &Options::time_s, "of the first frame since the content began, seconds")
      .field("seconds", &Options::seconds, "0: one frame")
      .field("fps", &Options::fps, "frames a second")
      .field("contents", &Options::contents, "by surface, instead of its own")
      .field("layouts", &Options::layouts, "by surface, instead of its own")
      .field("folder", &Options::folder, "the surfaces' own contents are relative to it")
      .field("viewer", &Options::viewer, "content on virtual surfaces, for an eye")
      .field("blend", &Options::blend, "this projector's set and map first")
      .field("gamma", &Options::gamma, "of the projector, light = value^gamma; 0: sRGB")
      .field("renderer", &Options::renderer, "cpu or gl")
      .field("rendering", &Options::rendering, "of the CPU renderer")
      .field("preview", &Options::preview,
             "also a picture of the room, .png: of the viewer, or of a person facing the surfaces")
      .field("weights", &Options::weights, "also the weights of `blend`, .png (8 bits) or .pfm");

  using Report = show::FrameFilesReport;
  Record<Report> report(m, "FrameFilesReport", "What write_frames() has written.");
  report.fields_init()
      .field("frames", &Report::frames, "number of frames")
      .field("surfaces", &Report::surfaces, "with content")
      .field("contents", &Report::contents, "theirs: \"picture.png, 800x600\"")
      .field("files", &Report::files, "that were written")
      .field("device", &Report::device, "of the renderer")
      .field("seen_share", &Report::seen_share, "of the light on the surfaces, what the viewer sees, 0 .. 1")
      .field("viewer_size", &Report::viewer_size, "of the viewer's picture, pixels")
      .field("diagnostics", &Report::diagnostics, "remarks");
}

}  // namespace

void bind_show_frames(py::module_& m) {
  bind_show_options(m);
  function(
      m, "write_frames",
      [](const Rig& rig, const SolvedSurfaceSet& solved, const show::FrameFilesOptions& options,
         const std::function<void(int, int)>& progress) {
        return show::write_frames(rig, solved, options, interruptible(progress));
      },
      "The frames of a projector as files: pictures, videos and colours on solved surfaces, as\n"
      "run() shows them at the same times. `progress` is called before each frame, with the\n"
      "number done and that of all. Raises Error(kInput) for options that contradict each\n"
      "other and for names of other kinds of file, Error(kDegenerate) for a viewer who sees none\n"
      "of the light, Error(kIo).",
      py::arg("rig"), py::arg("solved"), py::arg("options"), py::arg("progress") = py::none());
  function(
      m, Gil::kHeld, "to_jpeg",
      [](ViewU8 image, int max_width) {
        require(image.width > 0 && image.height > 0 && (image.channels == 1 || image.channels == 3) &&
                    max_width > 0,
                "to_jpeg: the image is empty or has not 1 or 3 channels, or the width is not positive");
        return py::bytes(show::to_jpeg(image, max_width));
      },
      "An image, uint8 (h, w) or (h, w, 3), as JPEG, reduced to that width.", py::arg("image"),
      py::arg("max_width") = 960);
  function(
      m, Gil::kHeld, "identification",
      [](ImageSize size, int number, const std::string& name) {
        require(size.width > 0 && size.height > 0 && size.width <= 16384 && size.height <= 16384,
                "identification: the size is not 1 to 16384 pixels a side");
        return show::identification(size, number, name);
      },
      "A grey frame with a display's number and name in it: uint8 (h, w, 3).", py::arg("size"),
      py::arg("number"), py::arg("name"));
  function(m, Gil::kHeld, "parse_screen", &show::parse_screen,
           "\"left=1\" or \"left=frames:out\": a projector, and its display or output. Raises\n"
           "Error(kInput).",
           py::arg("text"));
}

}  // namespace procam::python
