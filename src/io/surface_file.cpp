#include "procam/io/surface_file.hpp"

#include <algorithm>
#include <set>

#include "document/shared_fields.hpp"
#include "mesh/mesh_file.hpp"
#include "procam/core/base/limits.hpp"
#include "procam/io/image/images.hpp"

namespace procam::io {
namespace {

// The unit of a destination is in the field's name: metres on a planar surface, pixels in the picture.
struct Metres {
  static constexpr const char* kAt = "at_m";
};
struct Pixels {
  static constexpr const char* kAt = "at_px";
};

/// One source and destination, side by side in the file as a person measures them.
template <typename Unit>
struct PointPair {
  Vec2 content = Vec2::Zero();
  Vec2 at = Vec2::Zero();
  std::optional<double> weight;
};

}  // namespace

template <typename Unit>
static void fields(Fields& f, PointPair<Unit>& pair) {
  f.field("content", pair.content);
  f.field(Unit::kAt, pair.at);
  f.optional("weight", pair.weight);
  f.check(!pair.weight || *pair.weight > 0, "weight", "it is not positive",
          "give 1/sigma^2, or leave out the pair");
}

template <typename Unit>
static void point_fields(Fields& f, Points2& content, Points2& at, std::vector<double>& weights) {
  std::vector<PointPair<Unit>> pairs;
  if (!f.reading()) {
    require(content.size() == at.size() && (weights.empty() || weights.size() == at.size()),
            "save_surfaces: content, points and weights differ in number");
    for (std::size_t i = 0; i < content.size(); ++i)
      pairs.push_back({content[i], at[i], weights.empty() ? std::nullopt : std::optional(weights[i])});
  }
  f.list("points", "point", pairs);
  if (!f.reading()) return;
  for (const PointPair<Unit>& pair : pairs) {
    content.push_back(pair.content);
    at.push_back(pair.at);
    if (pair.weight) weights.push_back(*pair.weight);
  }
  f.check(weights.empty() || weights.size() == pairs.size(), "points",
          std::to_string(weights.size()) + " of " + std::to_string(pairs.size()) + " points have a weight",
          "give every point of the surface a weight, or none");
}

static void place_fields(Fields& f, InRoom& place) {
  const std::vector<std::string> frames{"world", "rig", "projector"};
  const auto frame = std::size_t(std::find(frames.begin(), frames.end(), place.frame) - frames.begin());
  require(frame < frames.size(), "save_surfaces: there is no frame '" + place.frame + "'");
  place.frame = frames[f.choice("frame", frames, frame)];
  f.field("frame_from_surface", place.frame_from_surface);
}

/// Two ends of a range, in the file's unit: `value` = `unit` * number. Written to 1e-10 of the unit, so that
/// 71 degrees stay 71.
static void range_field(Fields& f, const char* name, double unit, double& first, double& last) {
  Vec2 ends(std::round(first / unit * 1e10) / 1e10, std::round(last / unit * 1e10) / 1e10);
  f.field(name, ends);
  if (!f.reading()) return;
  first = unit * ends.x();
  last = unit * ends.y();
}

static void side_field(Fields& f, SeenFrom& side) {
  side = SeenFrom(f.choice("seen_from", {"outside", "inside"}, std::size_t(side)));
}

static void shape_fields(Fields& f, Surface& surface, PlanarSurface& planar) {
  point_fields<Metres>(f, planar.content, planar.points, surface.weights);
}
/// The points of a grid or a Bezier patch, in place of pairs.
static void curve_fields(Fields& f, PixelSurface& pixels) {
  f.field("columns", pixels.columns);
  f.field("rows", pixels.rows);
  f.field("points_px", pixels.pixels);
  if (const char* fault = pixels.fault()) f.check(false, "points_px", fault, "correct the surface's numbers");
}
static void shape_fields(Fields& f, Surface& surface, PixelSurface& pixels) {
  // Flat without it, as all were before there were others.
  constexpr auto kFirst = std::size_t(PixelShape::kGrid);
  if (f.reading() ? f.has("shape") : pixels.is_curved())
    pixels.shape = PixelShape(
        kFirst + f.choice("shape", {"grid", "bezier"}, f.reading() ? 0 : std::size_t(pixels.shape) - kFirst));
  if (pixels.is_curved()) return curve_fields(f, pixels);
  point_fields<Pixels>(f, pixels.content, pixels.pixels, surface.weights);
}
static void shape_fields(Fields& f, Surface&, GridSurface& grid) {
  f.field("columns", grid.columns);
  f.field("rows", grid.rows);
  f.field("points_m", grid.points);
}
static void shape_fields(Fields& f, Surface&, BezierSurface& bezier) {
  f.field("columns", bezier.columns);
  f.field("rows", bezier.rows);
  f.field("control_points_m", bezier.control_points);
}
static void shape_fields(Fields& f, Surface&, CylinderSurface& cylinder) {
  f.field("radius_m", cylinder.radius);
  range_field(f, "left_right_deg", kDegree, cylinder.left, cylinder.right);
  range_field(f, "top_bottom_m", 1, cylinder.top, cylinder.bottom);
  side_field(f, cylinder.seen_from);
}
static void shape_fields(Fields& f, Surface&, SphereSurface& sphere) {
  f.field("radius_m", sphere.radius);
  range_field(f, "left_right_deg", kDegree, sphere.left, sphere.right);
  range_field(f, "top_bottom_deg", kDegree, sphere.top, sphere.bottom);
  side_field(f, sphere.seen_from);
}
static void shape_fields(Fields& f, Surface&, MeshSurface& mesh) {
  f.field("file", mesh.file);
  f.field("metres_per_unit", mesh.metres_per_unit);
  f.check(!mesh.file.empty(), "file", "it is empty", "name an .obj or .ply file");
  f.check(mesh.metres_per_unit > 0, "metres_per_unit", "it is not positive",
          "give e.g. 0.001 for a file in mm");
}

namespace {
struct Ring {
  Points2 corners;
};

/// What the file has in one group: how a picture lies there, and which part of the surface shows it.
struct Shown {
  ContentLayout layout;
  ContentShape shape;
};
}  // namespace

static void fields(Fields& f, Ring& ring) {
  f.field("corners", ring.corners);
}

static void fields(Fields& f, Shown& shown) {
  ContentLayout& layout = shown.layout;
  if (f.reading() ? f.has("fit") : layout.fit != Fit::kStretch)
    layout.fit = Fit(f.choice("fit", {"stretch", "contain", "cover"}, std::size_t(layout.fit)));
  std::vector<double> crop;
  if (layout.crop_from != Vec2(0, 0) || layout.crop_to != Vec2(1, 1))
    crop = {layout.crop_from.x(), layout.crop_from.y(), layout.crop_to.x(), layout.crop_to.y()};
  f.optional("crop", crop);
  if (!crop.empty()) {
    const char* const next = "give left, top, right, bottom, as fractions of the picture from 0 to 1";
    f.check(crop.size() == 4, "crop", "it does not have 4 numbers", next);
    crop.resize(4);
    f.check(crop[0] >= 0 && crop[1] >= 0 && crop[2] <= 1 && crop[3] <= 1 && crop[0] < crop[2] &&
                crop[1] < crop[3],
            "crop", "it has no area, or goes beyond the picture", next);
    layout.crop_from = {crop[0], crop[1]};
    layout.crop_to = {crop[2], crop[3]};
  }
  ContentShape& shape = shown.shape;
  f.optional("outline", shape.outline);
  std::vector<Ring> holes;
  for (const Points2& hole : shape.holes) holes.push_back({hole});
  if (f.reading() ? f.has("holes") : !holes.empty()) f.list("holes", "hole", holes);
  f.optional("mask", shape.mask_file);
  if (f.reading())
    for (Ring& hole : holes) shape.holes.push_back(std::move(hole.corners));
  if (const auto fault = fault_of(shape))
    f.check(false, shape.outline.empty() ? "holes" : "outline", *fault, "correct the corners");
}

/// Absent where it says no more than the default.
static void layout_field(Fields& f, Surface& surface) {
  const ContentLayout& layout = surface.layout;
  const ContentShape& shape = surface.shape;
  std::optional<Shown> shown;
  if (layout.fit != Fit::kStretch || layout.crop_from != Vec2(0, 0) || layout.crop_to != Vec2(1, 1) ||
      !shape.outline.empty() || !shape.holes.empty() || !shape.mask_file.empty())
    shown = Shown{layout, shape};
  f.optional("layout", shown);
  if (!f.reading() || !shown) return;
  surface.layout = shown->layout;
  surface.shape = shown->shape;
}

template <typename Geometry>
static void geometry_fields(Fields& f, Surface& surface) {
  Geometry geometry = f.reading() ? Geometry{} : std::get<Geometry>(surface.geometry);
  if constexpr (std::is_base_of_v<InRoom, Geometry>) place_fields(f, geometry);
  shape_fields(f, surface, geometry);
  // A mesh's fault is its file's, told when that is read.
  if constexpr (!std::is_same_v<Geometry, PlanarSurface> && !std::is_same_v<Geometry, PixelSurface> &&
                !std::is_same_v<Geometry, MeshSurface>)
    if (const char* fault = geometry.fault()) f.check(false, "kind", fault, "correct the surface's numbers");
  surface.geometry = std::move(geometry);
}

static void fields(Fields& f, Surface& surface) {
  f.field("name", surface.name);
  f.check(!surface.name.empty(), "name", "it is empty", "give every surface a name");
  const std::size_t kind = f.choice(
      "kind", {"planar", "pixels", "grid", "bezier", "cylinder", "sphere", "mesh"}, surface.geometry.index());
  f.optional("content", surface.content);
  layout_field(f, surface);
  constexpr void (*kFields[])(Fields&, Surface&) = {
      geometry_fields<PlanarSurface>, geometry_fields<PixelSurface>,    geometry_fields<GridSurface>,
      geometry_fields<BezierSurface>, geometry_fields<CylinderSurface>, geometry_fields<SphereSurface>,
      geometry_fields<MeshSurface>};
  static_assert(std::size(kFields) == std::variant_size_v<SurfaceGeometry>);
  kFields[kind](f, surface);
}

static void fields(Fields& f, Placement& placement) {
  const std::size_t kind = f.choice("kind", {"planar", "pixels", "mesh"}, placement.index());
  if (kind == 0) {
    PlacedPlane plane = f.reading() ? PlacedPlane{} : std::get<PlacedPlane>(placement);
    f.field("plane_from_content", plane.plane_from_content);
    f.field("projector_from_surface", plane.projector_from_surface);
    placement = plane;
  } else if (kind == 1) {
    PlacedPixels pixels = f.reading() ? PlacedPixels{} : std::get<PlacedPixels>(placement);
    f.field("pixel_from_content", pixels.pixel_from_content);
    placement = pixels;
  } else {
    // The triangles follow from the surface's definition (load_solved_surfaces).
    PlacedMesh mesh = f.reading() ? PlacedMesh{} : std::get<PlacedMesh>(placement);
    f.field("projector_from_surface", mesh.projector_from_surface);
    placement = std::move(mesh);
  }
}

static void fields(Fields& f, Visibility& visibility) {
  f.field("covered_share", visibility.covered_share);
  f.field("facing", visibility.facing);
  f.field("incidence_deg", visibility.incidence_deg);
  f.field("mm_per_pixel_min", visibility.mm_per_pixel_min);
  f.field("mm_per_pixel_max", visibility.mm_per_pixel_max);
}

static void fields(Fields& f, Diagnostic& diagnostic) {
  diagnostic.severity =
      Severity(f.choice("severity", {"note", "warning", "failure"}, std::size_t(diagnostic.severity)));
  f.field("code", diagnostic.code);
  f.field("message", diagnostic.message);
}

static void fields(Fields& f, SolvedSurface& solved) {
  f.field("surface", solved.surface);
  f.field("placement", solved.placement);
  f.check(solved.placement.index() == std::min<std::size_t>(solved.surface.geometry.index(), 2), "placement",
          "it is not of the surface's kind", "solve the surface again");
  f.field("rms", solved.rms);
  f.field("residuals", solved.residuals);
  f.optional("corners_px", solved.corners_px);
  f.check(!solved.corners_px || solved.corners_px->size() == 4, "corners_px", "it does not have 4 points",
          "give the corners (0,0) (1,0) (1,1) (0,1), or leave the field out");
  f.field("visibility", solved.visibility);
  f.list("diagnostics", "diagnostic", solved.diagnostics.items);
}

/// Content is assigned to surfaces by name, so a name must mean one.
template <typename Item, typename NameOf>
static void check_names(const Fields& f, const std::vector<Item>& items, NameOf name_of) {
  f.check(items.size() <= limits::kSurfaces, "surfaces",
          "it has " + std::to_string(items.size()) + " surfaces, and a set at most " +
              std::to_string(limits::kSurfaces),
          "join neighbours to one surface, or share them out over several files");
  std::set<std::string> names;
  for (const Item& item : items)
    f.check(names.insert(name_of(item)).second, "surfaces", "two surfaces are named '" + name_of(item) + "'",
            "give every surface a name of its own");
}

static void fields(Fields& f, SurfaceSet& set) {
  header(f, "procam-surfaces", 1);
  f.list("surfaces", "surface", set.surfaces);
  check_names(f, set.surfaces, [](const Surface& surface) { return surface.name; });
}

static void fields(Fields& f, SolvedSurfaceSet& set) {
  header(f, "procam-solved-surfaces", 1);
  f.field("projector", set.projector);
  f.optional("projector_from_world", set.projector_from_world);
  f.list("surfaces", "solved_surface", set.surfaces);
  check_names(f, set.surfaces, [](const SolvedSurface& solved) { return solved.surface.name; });
}

/// Loads the mask and the mesh of a surface (named beside the file that names it) and, for a solved one,
/// makes the triangles that it is drawn as. What is wrong is told with that file's name first.
static void make_drawable(Surface& surface, Placement* placement, const std::filesystem::path& path) {
  try {
    if (!surface.shape.mask_file.empty())
      surface.shape.mask = std::make_shared<const ImageU8>(
          to_gray(load_image(path.parent_path() / surface.shape.mask_file).image));
    if (auto* shape = std::get_if<MeshSurface>(&surface.geometry)) {
      Mesh mesh = load_mesh(path.parent_path() / shape->file);
      for (Vec3& vertex : mesh.vertices) vertex *= shape->metres_per_unit;
      shape->mesh = std::make_shared<const Mesh>(std::move(mesh));
    }
    if (auto* placed = placement ? std::get_if<PlacedMesh>(placement) : nullptr)
      placed->mesh = mesh_of(surface);
    if (auto* placed = placement ? std::get_if<PlacedPixels>(placement) : nullptr)
      placed->mesh = mesh_of(surface);
  } catch (const Error& error) {
    throw Error(error.kind(), path.string() + ": " + error.subject(), error.why(), error.next());
  }
}

SurfaceSet load_surfaces(const std::filesystem::path& path) {
  SurfaceSet set = load_noun<SurfaceSet>(path, syntax_of(path));
  for (Surface& surface : set.surfaces) make_drawable(surface, nullptr, path);
  return set;
}

void save_surfaces(const std::filesystem::path& path, const SurfaceSet& surfaces) {
  save_noun(path, syntax_of(path), surfaces);
}

std::string surfaces_to_text(SurfaceSet surfaces) {
  Node document;
  write(surfaces, document, "");
  return to_json(document);
}

SurfaceSet surfaces_from_text(const std::string& text, const std::filesystem::path& beside) {
  const std::string file = beside.string();
  const Node document = parse_json(text, file);
  SurfaceSet set{};
  read(Value{&document, &file, ""}, set);
  for (Surface& surface : set.surfaces) make_drawable(surface, nullptr, beside);
  return set;
}

SolvedSurfaceSet load_solved_surfaces(const std::filesystem::path& path) {
  SolvedSurfaceSet set = load_noun<SolvedSurfaceSet>(path, syntax_of(path));
  for (SolvedSurface& solved : set.surfaces) make_drawable(solved.surface, &solved.placement, path);
  return set;
}

void save_solved_surfaces(const std::filesystem::path& path, const SolvedSurfaceSet& surfaces) {
  save_noun(path, syntax_of(path), surfaces);
}

}  // namespace procam::io
