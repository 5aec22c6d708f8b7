// procam.surface
#include "procam/surface.hpp"

#include "bind.hpp"
#include "components.hpp"

namespace procam::python {

namespace {

struct HeldBlendInput {
  Projector projector;
  SolvedSurfaceSet surfaces;
  double brightness = 1, black = 0;
};

/// With its set, which a VisiblePart only looks at.
struct HeldPart {
  SolvedSurfaceSet set;
  surface::VisiblePart part;

  HeldPart(const SolvedSurfaceSet& solved, const Projector& projector, std::optional<std::size_t> index)
      : set(solved), part(set, projector, chosen(set, index)) {}
  HeldPart(const HeldPart&) = delete;
  HeldPart& operator=(const HeldPart&) = delete;

  static const SolvedSurface* chosen(const SolvedSurfaceSet& set, std::optional<std::size_t> index) {
    if (!index) return nullptr;
    require(*index < set.surfaces.size(),
            "VisiblePart: surface " + std::to_string(*index) + " of " + std::to_string(set.surfaces.size()));
    return &set.surfaces[*index];
  }
};

void bind_visible_part(py::module_& m) {
  Record<HeldPart> visible_part(
      m, "VisiblePart",
      "One surface of a set, or all of it, as its light meets it: what other surfaces hide\n"
      "is not shown.");
  visible_part
      .init(
          [](const SolvedSurfaceSet& set, const Projector& projector, std::optional<std::size_t> surface) {
            return std::make_unique<HeldPart>(set, projector, surface);
          },
          "`surface`: the index of one in the set, or None for all of it.", py::arg("set"),
          py::arg("projector"), py::arg("surface") = py::none())
      .method(
          "has",
          [](const HeldPart& self, int x, int y) {
            require_pixel(self.part.nearest.size(), x, y, "VisiblePart.has");
            return self.part.has(x, y);
          },
          "Is the part shown by the pixel?", py::arg("x"), py::arg("y"))
      .method(
          "share", [](const HeldPart& self) { return self.part.share(); },
          "Of the projector's pixels, those that show it.");
}

void bind_blend_maps(py::module_& m) {
  Record<surface::BlendMap> blend_map(
      m, "BlendMap",
      "Of each of the projector's pixels, one channel each; where no surface is, nor beside\n"
      "the pixel: 0, 1, 0.");
  blend_map.fields_init()
      .field("weight", &surface::BlendMap::weight, "")
      .field("gain", &surface::BlendMap::gain, "")
      .field("lift", &surface::BlendMap::lift, "");

  Record<surface::Blend> blend(m, "Blend", "Maps that make several projectors one even picture.");
  blend.fields_init()
      .field("maps", &surface::Blend::maps, "in the order of the projectors")
      .field("diagnostics", &surface::Blend::diagnostics,
             "\"no_place\" for pixel surfaces, \"stays_dark\" where min_gain held E_0 up")
      .field("neighbours", &surface::Blend::neighbours,
             "Of each projector with a map: those whose light reaches a place that it lights as well.");

  Record<surface::BlendedSets> blended_sets(
      m, "BlendedSets", "What each projector of a group shows, and its maps, in one order.");
  blended_sets.fields_init()
      .field("sets", &surface::BlendedSets::sets, "")
      .field("maps", &surface::BlendedSets::maps, "")
      .field("brightness", &surface::BlendedSets::brightness, "of each projector, relative")
      .field("black", &surface::BlendedSets::black,
             "light of each projector's black, share of its full light, 0 .. 1");

  Record<HeldBlendInput> blend_input(m, "BlendInput", "A projector of a group and its surfaces.");
  blend_input.fields_init()
      .field("projector", &HeldBlendInput::projector, "")
      .field("surfaces", &HeldBlendInput::surfaces,
             "Its surfaces; those of the same name in the others' sets are the same.")
      .field("brightness", &HeldBlendInput::brightness, "light of its white, to a common factor (lumens)")
      .field("black", &HeldBlendInput::black,
             "light of its black over that of its white: 0.001 for a contrast of 1000 : 1");

  Record<surface::BlendOptions> blend_options(m, "BlendOptions",
                                              "How the light of overlapping projectors is shared.");
  blend_options.fields_init()
      .field("compensate", &surface::BlendOptions::compensate,
             "Off: all as bright as they are. On: places become as dark as the darkest; see\n"
             "min_gain.")
      .field("min_gain", &surface::BlendOptions::min_gain,
             "No less than this share of what the brightest 1 % could show.")
      .field("one_level", &surface::BlendOptions::one_level,
             "One level for all surfaces, as for the walls of a room; else one for each.")
      .field("only", &surface::BlendOptions::only,
             "The map of this projector alone, for less time; those of the others stay empty.")
      .field("threads", &surface::BlendOptions::threads, "0: as many as the machine has");

  function(
      m, "blend_maps",
      [](const std::vector<HeldBlendInput>& projectors, const surface::BlendOptions& options,
         const std::map<std::string, ImageF>& reflectance) {
        std::vector<surface::BlendInput> inputs;
        for (const HeldBlendInput& one : projectors)
          inputs.push_back({one.projector, &one.surfaces, one.brightness, one.black});
        surface::BlendOptions with = options;
        for (const auto& [name, image] : reflectance) with.reflectance[name] = image.view();
        return surface::blend_maps(inputs, with);
      },
      "Weights, gains and lifts of projectors that overlap. `reflectance`: as captured,\n"
      "over the content's area of surfaces by name, float32 (h, w), linear; needs\n"
      "`compensate`.",
      py::arg("projectors"), py::arg_v("options", surface::BlendOptions{}, "BlendOptions()"),
      py::arg_v("reflectance", std::map<std::string, ImageF>{}, "{}"));
}

void bind_frame_blend(py::module_& m) {
  Record<surface::FrameBlend> blend(
      m, "FrameBlend",
      "A map of a blend made ready for frame after frame: apply_blend() for less time, bit for\n"
      "bit the same.");
  blend
      .init([](const surface::BlendMap& map, double gamma) { return surface::FrameBlend(map, gamma); },
            "`gamma` 0: sRGB. Raises ValueError as apply_blend() does.", py::arg("map"),
            py::arg("gamma") = 0.0)
      .method("size", &surface::FrameBlend::size, "Size of its frames, pixels.")
      .method("changed_share", &surface::FrameBlend::changed_share,
              "Share of the pixels that it changes, 0 .. 1.")
      .method(
          "apply",
          [](const surface::FrameBlend& self, ImageView<std::uint8_t> frame, int first, int last) {
            const py::gil_scoped_release released;
            self.apply(frame, first, last < 0 ? frame.height : last);
          },
          "In place, to the rows first .. last - 1 of a frame of values: uint8 (h, w, 3). Raises\n"
          "ValueError for a frame of another size and rows that it does not have.",
          py::arg("frame"), py::arg("first") = 0, py::arg("last") = -1);
}

void bind_blend(py::module_& m) {
  function(
      m, "apply_blend",
      [](const surface::BlendMap& map, ImageView<std::uint8_t> frame, double gamma) {
        surface::apply_blend(map, frame, gamma);
      },
      "In place, to a frame of values: uint8 (h, w, c). `gamma` 0: sRGB.", py::arg("map"), py::arg("frame"),
      py::arg("gamma") = 0.0);
  function(
      m, "apply_blend_light",
      [](const surface::BlendMap& map, ImageView<float> frame) { surface::apply_blend(map, frame); },
      "In place, to a frame of light: float32 (h, w, c).", py::arg("map"), py::arg("frame"));
  function(
      m, "alpha_map",
      [](const HeldPart& part, const std::optional<ImageF>& weight) {
        return surface::alpha_map(part.part, weight ? &*weight : nullptr);
      },
      "1, or `weight`, where the part is shown, else 0: float32 (h, w).", py::arg("part"),
      py::arg("weight") = py::none());
}

void bind_lay_out(py::module_& m) {
  Record<surface::LaidOut> laid_out(m, "LaidOut",
                                    "The part of a picture that shows on a surface, and its place.");
  laid_out.fields_init()
      .field("placement", &surface::LaidOut::placement, "of the part of the picture that shows")
      .field("x", &surface::LaidOut::x, "the part's first pixel")
      .field("y", &surface::LaidOut::y, "the part's first pixel")
      .field("size", &surface::LaidOut::size, "the part's")
      .field("mask", &surface::LaidOut::mask, "alpha over the part; empty without outline, holes and mask")
      .method(
          "part",
          [](const surface::LaidOut& self, ViewU8 picture) {
            require(self.x >= 0 && self.y >= 0 && self.x + self.size.width <= picture.width &&
                        self.y + self.size.height <= picture.height,
                    "LaidOut.part: the picture is smaller than the one that was laid out");
            return self.part(picture);
          },
          "Of a picture of the size that was laid out.", py::arg("picture"));

  function(m, "lay_out", py::overload_cast<const Placement&, const Surface&, ImageSize>(&surface::lay_out),
           "The crop is taken to whole pixels of the picture, half a pixel off at most, and what\n"
           "is left then fills its place exactly. A picture of one pixel (a colour) fills the\n"
           "area with every fit, and so does any picture on a surface without an aspect.\n"
           "\n"
           "The mask holds the exact share of each of its pixels inside the outline and outside\n"
           "the holes, times the mask picture there. Sampled like a picture, an edge lies where\n"
           "it belongs to some hundredths of a mask pixel and is as soft as one or two of them.\n"
           "\n"
           "Raises Error(kInput), naming the surface, for a crop without area or beyond the\n"
           "picture and for a shape with a fault; ValueError for an empty picture.",
           py::arg("placement"), py::arg("surface"), py::arg("picture"));
  function(m, "lay_out", py::overload_cast<const SolvedSurface&, ImageSize>(&surface::lay_out),
           "Of a solved surface.", py::arg("solved"), py::arg("picture"));
  m.attr("kMaskSide") = surface::kMaskSide;
}

void bind_solve(py::module_& m) {
  Record<surface::SolveOptions> solve_options(m, "SolveOptions",
                                              "How surfaces are solved from their points.");
  solve_options.fields_init()
      .field("visibility", &surface::SolveOptions::visibility,
             "Without it `SolvedSurface::visibility`, `corners_px` and the remarks on them stay\n"
             "empty, which takes a hundredth of the time: for a running show.")
      .field("min_covered_share", &surface::SolveOptions::min_covered_share,
             "Below this share of the content inside the projector's picture a warning is given.")
      .field("largest_incidence_deg", &surface::SolveOptions::largest_incidence_deg,
             "Warn when light meets the surface at a larger angle to its normal: errors in the\n"
             "pose grow with 1 / cos^2.")
      .field("false_alarm_rate", &surface::SolveOptions::false_alarm_rate,
             "Rate at which good pairs with Gaussian errors get an \"outlying_pair\" warning, a\n"
             "surface.")
      .field("smallest_outlier_mm", &surface::SolveOptions::smallest_outlier_mm,
             "Deviations below these are never called out: files carry rounded numbers.")
      .field("smallest_outlier_px", &surface::SolveOptions::smallest_outlier_px,
             "residuals below it are never rejected, pixels");

  function(m, "solve_surfaces", &surface::solve_surfaces,
           "Any number of surfaces; an empty set gives an empty result.\n"
           "\n"
           "Raises Error naming the surface: kInput for an empty or repeated name, values that\n"
           "are not finite, lists of different lengths, an unknown frame, an outline with a\n"
           "fault, or frame \"world\" without `projector_from_world`; kNotEnoughData for fewer\n"
           "than four pairs; kDegenerate for collinear or repeated points and points on both\n"
           "sides of the horizon.\n"
           "\n"
           "Diagnostics, a surface each (`SolvedSurface::diagnostics`): failures\n"
           "\"behind_projector\" and \"edge_on\", no light can land, and \"too_small\", all of it\n"
           "within 4 projector pixels; warnings \"outside_picture\", \"partly_outside\",\n"
           "\"seen_from_behind\", \"mirrored\", \"grazing\", \"outlying_pair\",\n"
           "\"implausible_units\" (farther than 200 m, wider than 100 m, content coordinates in\n"
           "pixels).",
           py::arg("set"), py::arg("projector"), py::arg("projector_from_world") = py::none(),
           py::arg_v("options", surface::SolveOptions{}, "SolveOptions()"));
  function(m, "move_to", &surface::move_to,
           "The same surfaces from another pose of the projector: what stands in the world\n"
           "moves, homographies and meshes stay. For every frame of a drive: visibility, corners\n"
           "and remarks are left as they were solved, and nothing is allocated.",
           py::arg("solved"), py::arg("projector"), py::arg("projector_from_world"));
  function(m, "move_in_rig", &surface::move_in_rig,
           "The same surfaces after the projector was moved in its rig: those in the frame of the\n"
           "rig move in the projector's. Surfaces in the world are left to move_to().",
           py::arg("solved"), py::arg("projector"));
  function(m, "diagnostics_of", &surface::diagnostics_of,
           "All diagnostics of the set, each message beginning with its surface's name.", py::arg("solved"));
}

void bind_warp_files(py::module_& m) {
  Record<surface::MeshGrid> mesh_grid(m, "MeshGrid",
                                      "Cells of the content across and down; each becomes two triangles.");
  mesh_grid.fields_init()
      .field("columns", &surface::MeshGrid::columns, "")
      .field("rows", &surface::MeshGrid::rows, "");

  Record<surface::WarpGrid> warp_grid(
      m, "WarpGrid", "A mesh that warps content into a projector's frame, and its largest error.");
  warp_grid.fields_init()
      .field("mesh", &surface::WarpGrid::mesh, "")
      .field("largest_error_px", &surface::WarpGrid::largest_error_px,
             "How far, in projector pixels, linear interpolation puts places between the corners\n"
             "from where they belong, at worst over those that belong into the picture. It falls\n"
             "with the square of the triangles' size.");

  function(m, "warp_map", py::overload_cast<const Placement&, const Projector&>(&surface::warp_map),
           "Of one placement.", py::arg("placement"), py::arg("projector"));
  function(m, "position_map",
           py::overload_cast<const Placement&, const Projector&, const Pose&>(&surface::position_map),
           "Where each pixel's light lands on the content: x, y, z in metres in the target\n"
           "frame, NaN in all three where the content is not shown. Raises Error(kUnsupported)\n"
           "for a pixel surface, which has no place in the room.",
           py::arg("placement"), py::arg("projector"), py::arg_v("target_from_projector", Pose(), "Pose()"));
  function(m, "nearest_surfaces", &surface::nearest_surfaces,
           "Which surface the light of each pixel meets first, by its place in the set; -1:\n"
           "none. As renderers have it: by distance, of two that lie together (within a\n"
           "thousandth of it) the later; a pixel surface covers what is before it in the set and\n"
           "is covered by what comes after. Outside its outline and in its holes a surface is\n"
           "not there.",
           py::arg("solved"), py::arg("projector"));
  function(m, "warp_mesh", &surface::warp_mesh,
           "Planes and pixel surfaces: a regular grid over the content; cells with a corner that\n"
           "no light can reach are skipped. Curved surfaces and meshes: the triangles that they\n"
           "are made of (`grid` is ignored then), the farthest first, so that the nearer cover\n"
           "them. Raises ValueError unless there are 1 to 1024 columns and rows.",
           py::arg("placement"), py::arg("projector"), py::arg_v("grid", surface::MeshGrid{}, "MeshGrid()"));
  function(
      m, "warp_map",
      [](const HeldPart& part, const Projector& projector) {
        return surface::warp_map(part.part, projector);
      },
      "Of the chosen surface without what others hide.", py::arg("part"), py::arg("projector"));
  function(
      m, "position_map",
      [](const HeldPart& part, const Projector& projector, const Pose& target_from_projector) {
        return surface::position_map(part.part, projector, target_from_projector);
      },
      "Of each surface where it is the nearest: float32 (h, w, 3), metres, NaN where none\n"
      "is.",
      py::arg("part"), py::arg("projector"), py::arg("target_from_projector"));
}

}  // namespace

void bind_surface(py::module_& m) {
  bind_visible_part(m);
  bind_blend_maps(m);
  bind_frame_blend(m);
  bind_blend(m);
  bind_lay_out(m);
  bind_solve(m);
  bind_warp_files(m);
}

}  // namespace procam::python
