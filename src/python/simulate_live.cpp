// procam.simulate: a camera's view of a running show
#include "procam/simulate.hpp"

#include "bind.hpp"
#include "components.hpp"

namespace procam::python {

namespace {

/// A frame as light, ready for many images.
struct FrameLight {
  std::shared_ptr<const simulate::LiveView::Light> light;
};

/// Numbers of projectors are checked there.
template <typename F>
auto for_projector(const char* function, F f) {
  try {
    return f();
  } catch (const std::out_of_range&) {
    throw std::invalid_argument(std::string(function) + ": the view has no projector of that number");
  }
}

}  // namespace

void bind_simulate_live(py::module_& m) {
  Record<simulate::LiveViewOptions> options(m, "LiveViewOptions", "The camera of a LiveView.");
  options.fields_init()
      .field("view", &simulate::LiveViewOptions::view,
             "grey captures; colour, crosstalk, lens and the times are not used")
      .field("glare", &simulate::LiveViewOptions::glare,
             "light that the camera's lens scatters over its image, share, 0 .. 1");

  Record<FrameLight> light(m, "FrameLight",
                           "A frame as light, blurred: what LiveView.light_of() makes once for many images.");

  using simulate::LiveView;
  Record<LiveView> live(
      m, "LiveView",
      "A room as a camera sees it while projectors show one frame after the other. Its rays\n"
      "are followed once, so that an image takes some 30 ms at 1280 x 720; shadows and borders\n"
      "of bodies are right to a pixel. room_view() is exact, and takes seconds.");
  live.init(
          [](const simulate::Room& room, const Camera& camera, const Pose& room_from_camera,
             const std::vector<simulate::RoomLight>& lights, const simulate::LiveViewOptions& with) {
            const py::gil_scoped_release released;
            return std::make_unique<LiveView>(room, camera, room_from_camera, lights, with);
          },
          "Of the lights, the frames are not used. Raises ValueError as room_view() does.", py::arg("room"),
          py::arg("camera"), py::arg("room_from_camera"), py::arg("lights"),
          py::arg_v("options", simulate::LiveViewOptions{}, "LiveViewOptions()"))
      .method("exposure", &LiveView::exposure, "Grey levels per unit of light, as given or as found.")
      .method(
          "light",
          [](const LiveView& self, std::size_t projector) {
            return for_projector("LiveView.light", [&] { return self.light(projector); });
          },
          "The pixel of that projector that lights the point which the centre of each camera\n"
          "pixel sees, a copy.",
          py::arg("projector") = 0)
      .method(
          "light_of",
          [](const LiveView& self, ViewU8 frame, std::size_t projector) {
            const py::gil_scoped_release released;
            return for_projector("LiveView.light_of",
                                 [&] { return FrameLight{self.light_of(frame, projector)}; });
          },
          "A frame as light: uint8 (h, w) or (h, w, 3) of the projector's size.", py::arg("frame"),
          py::arg("projector") = 0)
      .method(
          "capture",
          [](const LiveView& self, const std::vector<FrameLight>& lights, std::uint64_t number) {
            std::vector<std::shared_ptr<const LiveView::Light>> each;
            for (const FrameLight& one : lights) each.push_back(one.light);
            const py::gil_scoped_release released;
            return self.capture(each, number);
          },
          "The camera's image, uint8 (h, w), while each projector shows its own frame. Noise\n"
          "differs by `number`. Raises ValueError unless there is one for each projector.",
          py::arg("lights"), py::arg("number") = 0);
}

}  // namespace procam::python
