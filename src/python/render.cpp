// procam.render
#include "procam/render.hpp"

#include "bind.hpp"
#include "components.hpp"

#include <mutex>

#include "scene.hpp"

namespace procam::python {

namespace {

/// A CpuRenderer for any thread, one at a time. It knows pictures by their addresses: those of the last frame live on, so
/// that no new array has the address of an old one.
class LockedRenderer {
 public:
  explicit LockedRenderer(const render::RenderOptions& options) : renderer_(options) {}

  template <typename Pixel>
  render::RenderWork render(const HeldScene& held, const Projector& projector, ImageView<Pixel> frame) {
    const Scene scene = scene_of(held);
    const py::list items = py::list(held.items);
    render::RenderWork work;
    {
      const py::gil_scoped_release released;
      const std::lock_guard<std::mutex> lock(mutex_);
      work = renderer_.render(scene, projector, frame);
      const py::gil_scoped_acquire gil;
      remember(items);
    }
    return work;
  }
  std::string device() const { return renderer_.device(); }

 private:
  void remember(const py::list& items) {
    for (std::size_t i = 0; i < items.size(); ++i) {
      const auto& item = items[i].cast<const HeldItem&>();
      if (i >= pictures_.size()) pictures_.emplace_back();
      pictures_[i] = {item.content, item.mask};
    }
  }

  render::CpuRenderer renderer_;
  std::mutex mutex_;
  std::vector<std::array<py::object, 2>> pictures_;
};

void bind_render_options(py::module_& m) {
  Enum<render::Filter>(m, "Filter", "How content is sampled: area (several samples a pixel) or bilinear.")
      .value("kArea", render::Filter::kArea, "the mean over the pixel's footprint: no aliasing")
      .value("kBilinear", render::Filter::kBilinear,
             "one sample at the pixel's centre, as most warps do: faster, and aliases where it\n"
             "minifies");

  Record<render::RenderOptions> render_options(m, "RenderOptions", "How render() samples and shades.");
  render_options.fields_init()
      .field("filter", &render::RenderOptions::filter, "")
      .field("linear_light", &render::RenderOptions::linear_light,
             "Average light rather than numbers: 8-bit values are taken as sRGB, decoded,\n"
             "averaged, encoded. A wall averages light, so fine black and white lines seen from\n"
             "afar keep their brightness only this way. Off for content whose numbers are not\n"
             "colours (codes, masks), which is then averaged as it stands; with Filter::kBilinear\n"
             "that is the fastest way to draw.")
      .field("threads", &render::RenderOptions::threads, "0: as many as the machine has")
      .field("vector_bits", &render::RenderOptions::vector_bits,
             "Vectors of at most so many bits, of those that the machine has: 512 (AVX-512), 256\n"
             "(AVX2) or 0 (plain code). Fewer are slower; for comparing, as the pixels are the\n"
             "same.");

  Record<render::RenderWork> render_work(
      m, "RenderWork", "What had to be made anew for a frame; nothing for a scene that stands still.");
  render_work.fields_init()
      .field("contents", &render::RenderWork::contents, "pictures prepared for sampling")
      .field("maps", &render::RenderWork::maps, "surfaces whose way to the pixels was found");
}

void bind_cpu_renderer(py::module_& m) {
  Record<LockedRenderer> cpu_renderer(
      m, "CpuRenderer",
      "Draws frame after frame and keeps what the next one can use: pictures ready to be\n"
      "sampled, the lens map and every surface's warp map, threads and memory. Nothing is\n"
      "allocated for a frame that needs nothing anew, or whose new pictures have the size\n"
      "of the old; where pixels are cast at one by one (meshes, planes that cut each other)\n"
      "memory is taken until there is enough.\n"
      "\n"
      "Items are recognised by their place in the scene. A picture is prepared again when\n"
      "its view points elsewhere or its content_revision differs; pixels changed behind an\n"
      "unchanged view and revision are not noticed. A surface that moves makes its own map\n"
      "again, and no other; a change of the projector's lens or size makes all. Tiles\n"
      "rendered by ray casting are cached once two consecutive frames needed the same one.");
  cpu_renderer
      .init([](const render::RenderOptions& options) { return std::make_unique<LockedRenderer>(options); },
            "", py::arg_v("options", render::RenderOptions{}, "RenderOptions()"))
      .method(
          "render",
          [](LockedRenderer& self, const HeldScene& scene, const Projector& projector,
             ImageView<std::uint8_t> frame) { return self.render(scene, projector, frame); },
          "Draws into a uint8 array of the projector's size, (h, w, 3); every pixel is written.",
          py::arg("scene"), py::arg("projector"), py::arg("frame"))
      .method(
          "render_light",
          [](LockedRenderer& self, const HeldScene& scene, const Projector& projector,
             ImageView<float> frame) { return self.render(scene, projector, frame); },
          "The same as light, 0 dark .. 1 full, into a float32 array (h, w, 3).", py::arg("scene"),
          py::arg("projector"), py::arg("frame"))
      .method(
          "device", [](const LockedRenderer& self) { return self.device(); }, "\"cpu\"");
}

void bind_render_functions(py::module_& m) {
  function(m, "require_drawable", &render::require_drawable,
           "Raises Error(kInput) for a frame with a side above limits::kFrameSide; call it\n"
           "before taking memory for one.",
           py::arg("frame"));
  function(
      m, Gil::kHeld, "render",
      [](const HeldScene& held, const Projector& projector, const render::RenderOptions& options) {
        const Scene scene = scene_of(held);
        const py::gil_scoped_release released;
        return render::render(scene, projector, options);
      },
      "One frame of the projector's size: uint8 array (h, w, 3), RGB.", py::arg("scene"),
      py::arg("projector"), py::arg_v("options", render::RenderOptions{}, "RenderOptions()"));
  function(
      m, Gil::kHeld, "render",
      [](const HeldScene& held, const Projector& projector, ImageView<std::uint8_t> frame,
         const render::RenderOptions& options) {
        const Scene scene = scene_of(held);
        const py::gil_scoped_release released;
        render::render(scene, projector, frame, options);
      },
      "Into a uint8 array of the projector's size, (h, w, 3); every pixel is written.", py::arg("scene"),
      py::arg("projector"), py::arg("frame"),
      py::arg_v("options", render::RenderOptions{}, "RenderOptions()"));
  m.attr("kLensTolerancePx") = render::kLensTolerancePx;
}

void bind_viewpoint(py::module_& m) {
  Record<render::Viewpoint> viewpoint(m, "Viewpoint", "An eye with its picture, in optical axes.");
  viewpoint.fields_init()
      .field("camera", &render::Viewpoint::camera, "")
      .field("camera_from_projector", &render::Viewpoint::camera_from_projector, "");

  function(
      m, Gil::kHeld, "facing_viewpoint",
      [](const HeldScene& scene, ImageSize size) { return render::facing_viewpoint(scene_of(scene), size); },
      "In front of the scene's surfaces, looking along their mean normal from the side they\n"
      "are read from, upright as they are read, far enough back to see all of them. None\n"
      "when all are pixel surfaces.",
      py::arg("scene"), py::arg_v("size", ImageSize{960, 640}, "ImageSize(960, 640)"));
  function(
      m, Gil::kHeld, "seen_from",
      [](const Pose& other_from_projector, const HeldScene& scene) {
        return held_scene(render::seen_from(other_from_projector, scene_of(scene)), scene);
      },
      "The same surfaces with the same content in another frame: what a renderer draws for\n"
      "a device that stands there. Pixel surfaces belong to the projector's picture and are\n"
      "skipped.",
      py::arg("other_from_projector"), py::arg("scene"));
}

void bind_viewer_eye(py::module_& m) {
  Record<render::ViewerEyeOptions> viewer_eye_options(m, "ViewerEyeOptions",
                                                      "How large a picture viewer_eye() makes.");
  viewer_eye_options.fields_init()
      .field("widest_deg", &render::ViewerEyeOptions::widest_deg,
             "A picture on a plane cannot hold all directions: light that lands farther than half\n"
             "of this from the direction of its middle is left dark.")
      .field("max_pixels", &render::ViewerEyeOptions::max_pixels,
             "Of the eye's picture. Enough for each projector pixel to see its own, save where one\n"
             "is very fine beside the others; with fewer the picture is coarser.");

  Record<render::ViewerEye> viewer_eye(m, "ViewerEye",
                                       "The picture of an eye that sees what the projector lights.");
  viewer_eye.fields_init()
      .field("viewpoint", &render::ViewerEye::viewpoint, "")
      .field("finest_share", &render::ViewerEye::finest_share,
             "Pixels of the eye's picture a projector pixel, along its finer side, where the\n"
             "projector is finest.")
      .field("diagnostics", &render::ViewerEye::diagnostics,
             "warnings \"viewer_field_cut\", \"viewer_picture_coarse\"");

  function(
      m, Gil::kHeld, "viewer_eye",
      [](const Vec3& eye_in_projector, const HeldScene& room, const Projector& projector,
         const render::ViewerEyeOptions& options) {
        return render::viewer_eye(eye_in_projector, scene_of(room), projector, options);
      },
      "The picture of an eye that holds all that the projector lights of the room, such\n"
      "that the projector's finest pixels (all but the finest twentieth) see a pixel of it\n"
      "each. None where no light lands in sight. The real surfaces are those of `room`;\n"
      "their content is not looked at.",
      py::arg("eye_in_projector"), py::arg("room"), py::arg("projector"),
      py::arg_v("options", render::ViewerEyeOptions{}, "ViewerEyeOptions()"));
}

}  // namespace

void bind_render(py::module_& m) {
  bind_render_options(m);
  bind_cpu_renderer(m);
  bind_render_functions(m);
  bind_viewpoint(m);
  bind_viewer_eye(m);
}

}  // namespace procam::python
