// procam: surfaces, what is on them, and scenes, as procam/core/surface has them.
#include "procam/core.hpp"

#include "bind.hpp"
#include "components.hpp"
#include "scene.hpp"

namespace procam::python {

namespace {

/// An array that a scene's item may hold: in place where its layout permits, else a copy.
py::object picture_to_hold(py::handle object, const char* name) {
  if (object.is_none()) return py::none();
  py::array array = image_array<std::uint8_t>(object, {"SceneItem", name}, image_expected<std::uint8_t>());
  if (!is_image_in_place(array)) array = py::array_t<std::uint8_t, py::array::c_style>(array);
  return std::move(array);
}

void bind_flat_surfaces(py::module_& m) {
  Enum<PixelShape>(m, "PixelShape", "How a surface in projector pixels is given.")
      .value("kFlat", PixelShape::kFlat, "a homography through pairs")
      .value("kGrid", PixelShape::kGrid, "columns x rows points, bilinear between")
      .value("kBezier", PixelShape::kBezier, "columns x rows control points of one smooth patch");
  Record<PixelSurface> pixel_surface(
      m, "PixelSurface",
      "N >= 4 pairs of content coordinates and projector pixels, as clicked or dragged: a\n"
      "pure homography, right for one placement of the projector. The projector's lens is\n"
      "not applied: whoever dragged the corners saw it already. A grid or a Bezier patch has\n"
      "columns x rows pixels, row by row from (u, v) = (0, 0), and no content.");
  pixel_surface.fields_init()
      .field("content", &PixelSurface::content, "source (u, v)")
      .field("pixels", &PixelSurface::pixels, "destination, projector pixels")
      .field("shape", &PixelSurface::shape, "")
      .field("columns", &PixelSurface::columns, "of a grid or a Bezier patch, 2 to 16")
      .field("rows", &PixelSurface::rows, "")
      .method("is_curved", &PixelSurface::is_curved,
              "Is it more than one flat quadrilateral of projector pixels?")
      .method(
          "point",
          [](const PixelSurface& self, const Vec2& uv) {
            require(self.is_curved() && self.fault() == nullptr,
                    "PixelSurface.point: the surface is flat or has a fault");
            return self.point(uv);
          },
          "the projector pixel of a content position, of a grid or a Bezier patch", py::arg("uv"))
      .method("fault", &PixelSurface::fault, "What is wrong with its shape, in words; empty for a sound one.")
      .method("as_grid", &PixelSurface::as_grid, "points (x, y, 0), pixels instead of metres")
      .method("as_bezier", &PixelSurface::as_bezier, "points (x, y, 0), pixels instead of metres");

  Record<PlacedPixels> placed_pixels(m, "PlacedPixels", "A pixel surface, solved.");
  placed_pixels.fields_init().field("pixel_from_content", &PlacedPixels::pixel_from_content,
                                    "(u, v, 1) -> projector pixel; of a curved one not used");
  placed_pixels.type.def_property(
      "mesh",
      [](const PlacedPixels& self) { return self.mesh ? std::optional<Mesh>(*self.mesh) : std::nullopt; },
      [](PlacedPixels& self, const std::optional<Mesh>& mesh) {
        self.mesh = mesh ? std::make_shared<const Mesh>(*mesh) : nullptr;
      },
      "of a curved one, else None: vertices (x, y, 0) in projector pixels");

  Record<PlanarSurface, InRoom> planar_surface(
      m, "PlanarSurface",
      "N >= 4 pairs of content coordinates and points on a placed plane. Works with any\n"
      "pose of the projector.");
  planar_surface.fields_init()
      .field("content", &PlanarSurface::content, "source (u, v)")
      .field("points", &PlanarSurface::points, "destination, metres in the surface's own plane z = 0");

  Record<PlacedPlane> placed_plane(
      m, "PlacedPlane",
      "A planar surface, solved: content -> plane by a homography, plane -> pixel by the\n"
      "full projector model.");
  placed_plane.fields_init()
      .field("plane_from_content", &PlacedPlane::plane_from_content, "(u, v, 1) -> metres on z = 0")
      .field("projector_from_surface", &PlacedPlane::projector_from_surface, "");
}

void bind_curved_surfaces(py::module_& m) {
  Record<BezierSurface, InRoom> bezier_surface(
      m, "BezierSurface",
      "Tensor-product Bezier patch (Farin, Curves and Surfaces for CAGD, 5th ed., ch. 14)\n"
      "of degrees columns - 1 and rows - 1:\n"
      "\n"
      "  point(u, v) = sum_ij B_i(u) B_j(v) p_ij,   B the Bernstein polynomials.\n"
      "\n"
      "It passes through its four corner points. Control points row by row, the first at\n"
      "(u, v) = (0, 0).");
  bezier_surface.fields_init()
      .field("columns", &BezierSurface::columns, "")
      .field("rows", &BezierSurface::rows, "")
      .field("control_points", &BezierSurface::control_points, "metres")
      .method(
          "point",
          [](const BezierSurface& self, const Vec2& uv) {
            require(self.fault() == nullptr, "BezierSurface.point: the surface has a fault");
            return self.point(uv);
          },
          "Point of the surface at content position uv (2,), 0 .. 1: (3,), metres, in the\n"
          "surface\'s frame.",
          py::arg("uv"))
      .method("cells", &BezierSurface::cells, "Columns and rows of the quadrilaterals that draw it.")
      .method("fault", &BezierSurface::fault,
              "What is wrong with its shape, in words; empty for a sound one.");

  Record<GridSurface, InRoom> grid_surface(
      m, "GridSurface",
      "`columns` x `rows` points, row by row, the first at (u, v) = (0, 0), the last at (1,\n"
      "1); bilinear between.");
  grid_surface.fields_init()
      .field("columns", &GridSurface::columns, "")
      .field("rows", &GridSurface::rows, "")
      .field("points", &GridSurface::points, "metres")
      .method(
          "point",
          [](const GridSurface& self, const Vec2& uv) {
            require(self.fault() == nullptr, "GridSurface.point: the surface has a fault");
            return self.point(uv);
          },
          "Point of the surface at content position uv (2,), 0 .. 1: (3,), metres, in the\n"
          "surface\'s frame.",
          py::arg("uv"))
      .method("cells", &GridSurface::cells, "Columns and rows of the quadrilaterals that draw it.")
      .method("fault", &GridSurface::fault, "What is wrong with its shape, in words; empty for a sound one.");
}

void bind_round_surfaces(py::module_& m) {
  Enum<SeenFrom>(m, "SeenFrom", "Which side of a curved surface the content is read from.")
      .value("kOutside", SeenFrom::kOutside)
      .value("kInside", SeenFrom::kInside);

  Record<CylinderSurface, InRoom> cylinder_surface(
      m, "CylinderSurface",
      "The axis is the surface frame's y axis (down). With the angle a = left + u (right -\n"
      "left), which grows to the reader's right and is 0 in the middle of what a reader on\n"
      "the -z side sees,\n"
      "\n"
      "  point(u, v) = (r sin a, top + v (bottom - top), -+ r cos a),   - seen from outside, + from inside.");
  cylinder_surface.fields_init()
      .field("radius", &CylinderSurface::radius, "metres")
      .field("left", &CylinderSurface::left, "radians, left < right <= left + 2 pi")
      .field("right", &CylinderSurface::right, "radians, left < right <= left + 2 pi")
      .field("top", &CylinderSurface::top, "metres along y, top < bottom")
      .field("bottom", &CylinderSurface::bottom, "metres along y, top < bottom")
      .field("seen_from", &CylinderSurface::seen_from, "")
      .method("point", &CylinderSurface::point,
              "Point of the surface at content position uv (2,), 0 .. 1: (3,), metres, in the\n"
              "surface's frame.",
              py::arg("uv"))
      .method("cells", &CylinderSurface::cells, "Columns and rows of the quadrilaterals that draw it.")
      .method("fault", &CylinderSurface::fault,
              "What is wrong with its shape, in words; empty for a sound one.");

  Record<SphereSurface, InRoom> sphere_surface(
      m, "SphereSurface",
      "About the surface frame's origin. With the longitude l = left + u (right - left),\n"
      "which grows to the reader's right, and the latitude b = top + v (bottom - top),\n"
      "which is positive above the middle (y < 0),\n"
      "\n"
      "  point(u, v) = r (cos b sin l, -sin b, -+ cos b cos l),   - seen from outside, + from inside.");
  sphere_surface.fields_init()
      .field("radius", &SphereSurface::radius, "metres")
      .field("left", &SphereSurface::left, "longitudes, radians, left < right <= left + 2 pi")
      .field("right", &SphereSurface::right, "longitudes, radians, left < right <= left + 2 pi")
      .field("top", &SphereSurface::top, "latitudes, radians, pi/2 >= top > bottom >= -pi/2")
      .field("bottom", &SphereSurface::bottom, "latitudes, radians, pi/2 >= top > bottom >= -pi/2")
      .field("seen_from", &SphereSurface::seen_from, "")
      .method("point", &SphereSurface::point,
              "Point of the surface at content position uv (2,), 0 .. 1: (3,), metres, in the\n"
              "surface's frame.",
              py::arg("uv"))
      .method("cells", &SphereSurface::cells, "Columns and rows of the quadrilaterals that draw it.")
      .method("fault", &SphereSurface::fault,
              "What is wrong with its shape, in words; empty for a sound one.");
}

void bind_mesh_surface(py::module_& m) {
  Record<MeshSurface, InRoom> mesh_surface(m, "MeshSurface", "A surface of triangles, of a file.");
  mesh_surface.fields_init()
      .field("file", &MeshSurface::file, ".obj or .ply, beside the surfaces file")
      .field("metres_per_unit", &MeshSurface::metres_per_unit, "of the file's numbers")
      .method("fault", &MeshSurface::fault, "What is wrong with its shape, in words; empty for a sound one.");
  mesh_surface.type.def_property(
      "mesh",
      [](const MeshSurface& self) { return self.mesh ? std::optional<Mesh>(*self.mesh) : std::nullopt; },
      [](MeshSurface& self, const std::optional<Mesh>& mesh) {
        self.mesh = mesh ? std::make_shared<const Mesh>(*mesh) : nullptr;
      },
      "as loaded, metres; set by io.load_surfaces");

  Record<PlacedMesh> placed_mesh(
      m, "PlacedMesh",
      "A surface of triangles, solved: they are placed, and seen by the full projector\n"
      "model.");
  placed_mesh.fields_init()
      .field("projector_from_surface", &PlacedMesh::projector_from_surface, "")
      .field("content_from_point", &PlacedMesh::content_from_point,
             "Content coordinates by a projection, (3, 4), instead of the mesh's uv.");
  placed_mesh.type.def_property(
      "mesh",
      [](const PlacedMesh& self) { return self.mesh ? std::optional<Mesh>(*self.mesh) : std::nullopt; },
      [](PlacedMesh& self, const std::optional<Mesh>& mesh) {
        self.mesh = mesh ? std::make_shared<const Mesh>(*mesh) : nullptr;
      },
      "in the surface's frame");
}

void bind_tessellation(py::module_& m) {
  const auto tessellated = [&m](auto shape) {
    function(
        m, "tessellate",
        [](const decltype(shape)& surface, double tolerance) {
          require(surface.fault() == nullptr,
                  std::string("tessellate: ") + (surface.fault() != nullptr ? surface.fault() : ""));
          return tessellate(surface, tolerance);
        },
        "Triangles of a curved surface, none farther from it than `tolerance` metres.", py::arg("shape"),
        py::arg("tolerance"));
  };
  tessellated(GridSurface());
  tessellated(BezierSurface());
  tessellated(CylinderSurface());
  tessellated(SphereSurface());
  m.attr("kTessellationTolerance") = procam::kTessellationTolerance;
  m.attr("kPixelTolerance") = procam::kPixelTolerance;
}

void bind_content_layout(py::module_& m) {
  Enum<Fit>(m, "Fit", "For a picture whose width over height is not that of the content's area.")
      .value("kStretch", Fit::kStretch,
             "the picture's corners on the area's corners, whatever that does to circles")
      .value("kContain", Fit::kContain,
             "all of the picture, undistorted and in the middle; beside it nothing is drawn")
      .value("kCover", Fit::kCover, "all of the area, undistorted; what stands over on two sides is cut off");

  Record<ContentLayout> content_layout(m, "ContentLayout",
                                       "How content fills a surface: its fit, margins and rotation.");
  content_layout.fields_init()
      .field("fit", &ContentLayout::fit, "")
      .field("crop_from", &ContentLayout::crop_from,
             "The part of the picture that is shown, in fractions of the picture; fitted as if it\n"
             "were the picture.")
      .field("crop_to", &ContentLayout::crop_to,
             "The part of the picture that is shown, in fractions of the picture; fitted as if it\n"
             "were the picture.");
}

void bind_content_shape(py::module_& m) {
  Record<ContentShape> content_shape(
      m, "ContentShape",
      "Where on the surface content may be: all of [0, 1] x [0, 1], or inside an outline,\n"
      "outside holes, and with a mask's alpha.");
  content_shape.fields_init()
      .field("outline", &ContentShape::outline, "empty: the whole area")
      .field("holes", &ContentShape::holes, "corners in content coordinates, 0 .. 1")
      .field("mask_file", &ContentShape::mask_file, "beside the surfaces file; may be empty")
      .method("is_whole", &ContentShape::is_whole,
              "Does all of the content show: no outline, no holes, no mask?");
  content_shape.type.def_property(
      "mask",
      [](const ContentShape& self) { return self.mask ? std::optional<ImageU8>(*self.mask) : std::nullopt; },
      [](ContentShape& self, py::handle mask) {
        self.mask =
            mask.is_none()
                ? nullptr
                : std::make_shared<const ImageU8>(Loader<ImageU8>::from(mask, {"ContentShape", "mask"}));
      },
      "uint8 (h, w), grey, its corners on the area's; set by io.load_surfaces");

  function(m, Gil::kHeld, "twice_area", &procam::twice_area,
           "Twice the signed area of a ring; positive clockwise as seen (v runs down).", py::arg("ring"));
  function(m, Gil::kHeld, "contains", &procam::contains,
           "Even-odd rule, a ring's border counts to either side.", py::arg("ring"), py::arg("point"));
  function(m, Gil::kHeld, "in_shape", &procam::in_shape,
           "Is there content at this place, by outline and holes?", py::arg("shape"), py::arg("uv"));
  function(m, Gil::kHeld, "segments_meet", &procam::segments_meet,
           "Do the segments ab and cd have a point in common?", py::arg("a"), py::arg("b"), py::arg("c"),
           py::arg("d"));
  function(m, Gil::kHeld, "fault_of", py::overload_cast<const ContentShape&>(&procam::fault_of),
           "Why nothing can be cut out by it, in words; None for a good shape.", py::arg("shape"));
}

void bind_surface_definitions(py::module_& m) {
  Record<Surface> surface_(m, "Surface",
                           "A surface as its file describes it: name, geometry, place, and the points that\n"
                           "define it.");
  surface_.fields_init()
      .field("name", &Surface::name, "")
      .field("geometry", &Surface::geometry, "")
      .field("weights", &Surface::weights, "one a pair, 1/sigma^2 up to a common factor; empty: all equal")
      .field("content", &Surface::content, "file shown when the tool is given none; may be empty")
      .field("layout", &Surface::layout, "")
      .field("shape", &Surface::shape, "");

  Record<SurfaceSet> surface_set(
      m, "SurfaceSet",
      "Surfaces in the room hide each other as the projector sees them; where two lie\n"
      "together (closer than a thousandth of their distance), and for pixel surfaces, the\n"
      "later covers the earlier.");
  surface_set.fields_init().field("surfaces", &SurfaceSet::surfaces, "");

  function(
      m, Gil::kHeld, "mesh_of",
      [](const Surface& surface) {
        const auto mesh = mesh_of(surface);
        return mesh ? std::optional<Mesh>(*mesh) : std::nullopt;
      },
      "A surface's triangles in its own frame; of a curved pixel surface (x, y, 0) in projector\n"
      "pixels. None for planes and flat pixel surfaces.",
      py::arg("surface"));
  function(
      m, Gil::kHeld, "pixel_at",
      [](const PlacedPixels& placed, const Vec2& uv) { return pixel_at(placed, uv); },
      "The projector pixel of a content position (it may lie outside the frame); None on and\n"
      "beyond the horizon, and outside a curved surface's triangles.",
      py::arg("placed"), py::arg("uv"));
  function(
      m, Gil::kHeld, "mesh_on_rays",
      [](const PlacedPixels& placed, const Projector& projector) { return mesh_on_rays(placed, projector); },
      "A curved pixel surface as light: each vertex on the ray of its pixel, in the projector's\n"
      "frame, one metre along the axis.",
      py::arg("placed"), py::arg("projector"));
  function(
      m, Gil::kHeld, "place_of",
      [](const SurfaceGeometry& geometry) {
        const InRoom* place = place_of(geometry);
        return place != nullptr ? std::optional<InRoom>(*place) : std::nullopt;
      },
      "Where the surface is in the room; None for pixel surfaces.", py::arg("geometry"));
}

void bind_solved_surfaces(py::module_& m) {
  Record<Visibility> visibility(m, "Visibility", "How a surface looks from the projector.");
  visibility.fields_init()
      .field("covered_share", &Visibility::covered_share,
             "of the content's area (inside outline and mask) that falls inside")
      .field("facing", &Visibility::facing, "the projector stands on the side that content is read from")
      .field("incidence_deg", &Visibility::incidence_deg,
             "angle between light and surface normal at the content's centre")
      .field("mm_per_pixel_min", &Visibility::mm_per_pixel_min,
             "size of a projector pixel on the surface: the finest and")
      .field("mm_per_pixel_max", &Visibility::mm_per_pixel_max,
             "the coarsest direction over the content (0 for pixel surfaces; of curved surfaces\n"
             "and meshes where light meets them at less than 80 degrees)");

  Record<SolvedSurface> solved_surface(m, "SolvedSurface",
                                       "A surface whose content has its place in the projector's frame.");
  solved_surface.fields_init()
      .field("surface", &SolvedSurface::surface, "")
      .field("placement", &SolvedSurface::placement, "")
      .field("rms", &SolvedSurface::rms, "of the homography's pairs: metres (planar) or pixels")
      .field("residuals", &SolvedSurface::residuals, "a pair each, same unit")
      .field("corners_px", &SolvedSurface::corners_px,
             "projector pixels of the content's corners (0,0) (1,0) (1,1) (0,1), if all exist")
      .field("visibility", &SolvedSurface::visibility, "")
      .field("diagnostics", &SolvedSurface::diagnostics, "");

  Record<SolvedSurfaceSet> solved_surface_set(
      m, "SolvedSurfaceSet", "Surfaces solved for one placement of one projector; complete in itself.");
  solved_surface_set.fields_init()
      .field("projector", &SolvedSurfaceSet::projector, "its name in the rig")
      .field("projector_from_world", &SolvedSurfaceSet::projector_from_world,
             "absent when no surface needed it")
      .field("surfaces", &SolvedSurfaceSet::surfaces, "");
}

void bind_warps(py::module_& m) {
  Record<WarpMap> warp_map(m, "WarpMap",
                           "For the centre of every projector pixel, the content coordinates that its light\n"
                           "shows.");
  warp_map.fields_init()
      .field("content", &WarpMap::content,
             "the projector's size, 3 channels: u, v, and 1 where the content is shown; else 0 0 0")
      .method("size", &WarpMap::size, "Size of the map: that of the projector's frame, pixels.")
      .method(
          "shows",
          [](const WarpMap& self, int x, int y) {
            require_pixel(self.content.size(), x, y, "WarpMap.shows");
            require(self.content.channels() == 3, "WarpMap.shows: content needs three channels");
            return self.shows(x, y);
          },
          "Does projector pixel (x, y) show content?", py::arg("x"), py::arg("y"))
      .method(
          "at",
          [](const WarpMap& self, int x, int y) {
            require_pixel(self.content.size(), x, y, "WarpMap.at");
            require(self.content.channels() == 3, "WarpMap.at: content needs three channels");
            return self.at(x, y);
          },
          "Content position (2,) that projector pixel (x, y) shows, 0 .. 1.", py::arg("x"), py::arg("y"));

  Record<WarpMesh> warp_mesh(
      m, "WarpMesh",
      "Triangles over the content, with the projector pixel of each corner (it may lie\n"
      "outside the picture). Between the corners a renderer interpolates linearly: see\n"
      "surface/warp.hpp for the error of that.");
  warp_mesh.fields_init()
      .field("projector", &WarpMesh::projector, "")
      .field("content", &WarpMesh::content, "content position of each corner, 0 .. 1")
      .field("pixels", &WarpMesh::pixels, "one a content point")
      .field("triangles", &WarpMesh::triangles, "indices of points");
}

void bind_scene(py::module_& m) {
  Record<HeldItem> scene_item(m, "SceneItem", "A placed surface with a picture on it.");
  scene_item
      .init(
          [](const Placement& placement, const py::object& content, std::uint64_t content_revision,
             const py::object& mask, std::uint64_t mask_revision) {
            return HeldItem{placement, picture_to_hold(content, "content"), content_revision,
                            picture_to_hold(mask, "mask"), mask_revision};
          },
          "content: uint8 array, (h, w) grey, (h, w, 3) RGB or (h, w, 4) RGBA with straight\n"
          "alpha; looked at in place, not copied.",
          py::arg("placement"), py::arg("content"), py::arg("content_revision") = 0,
          py::arg("mask") = py::none(), py::arg("mask_revision") = 0)
      .field("placement", &HeldItem::placement, "")
      .field("content_revision", &HeldItem::content_revision,
             "Another number when the pixels of the same array have changed (a video's frame\n"
             "number).")
      .field("mask_revision", &HeldItem::mask_revision, "as content_revision");
  scene_item.type
      .def_property(
          "content", [](const HeldItem& self) { return self.content; },
          [](HeldItem& self, const py::object& array) { self.content = picture_to_hold(array, "content"); },
          "uint8 array, held by the item")
      .def_property(
          "mask", [](const HeldItem& self) { return self.mask; },
          [](HeldItem& self, const py::object& array) { self.mask = picture_to_hold(array, "mask"); },
          "Alpha of the content over the same area: uint8 array, (h, w) of any resolution, or\n"
          "None.");

  Record<HeldScene> scene(m, "Scene",
                          "What a projector is asked to draw: placed surfaces, each with the picture on it,\n"
                          "back to front.");
  scene
      .init(
          [](const py::iterable& items, const std::array<std::uint8_t, 3>& background) {
            return HeldScene{py::list(items), background};
          },
          "", py::arg("items") = py::tuple(), py::arg("background") = std::array<std::uint8_t, 3>{})
      .field("background", &HeldScene::background, "RGB where nothing is drawn: no light");
  scene.type.def_property(
      "items", [](const HeldScene& self) { return self.items; },
      [](HeldScene& self, const py::iterable& items) { self.items = py::list(items); },
      "list of SceneItem; later ones cover earlier ones");
}

}  // namespace

void bind_core_surface(py::module_& m) {
  Record<InRoom> in_room(m, "InRoom",
                         "Where a surface is: the frame that it is given in, and its pose there.");
  in_room.fields_init()
      .field("frame", &InRoom::frame,
             "the frame the surface is placed in: \"world\", \"rig\", or \"projector\"")
      .field("frame_from_surface", &InRoom::frame_from_surface, "");
  bind_curved_surfaces(m);
  bind_flat_surfaces(m);
  bind_round_surfaces(m);
  bind_mesh_surface(m);
  bind_tessellation(m);
  bind_content_layout(m);
  bind_content_shape(m);
  bind_surface_definitions(m);
  bind_solved_surfaces(m);
  bind_warps(m);
  bind_scene(m);
}

}  // namespace procam::python
