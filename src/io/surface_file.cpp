#include "procam/io/surface_file.hpp"

#include <algorithm>
#include <set>

#include "shared_fields.hpp"

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

static void fields(Fields& f, Surface& surface) {
  f.field("name", surface.name);
  f.check(!surface.name.empty(), "name", "it is empty", "give every surface a name");
  const std::size_t kind = f.choice("kind", {"planar", "pixels"}, surface.geometry.index());
  f.optional("content", surface.content);
  if (kind == 0) {
    PlanarSurface planar = f.reading() ? PlanarSurface{} : std::get<PlanarSurface>(surface.geometry);
    const std::vector<std::string> frames{"world", "rig", "projector"};
    const auto frame = std::size_t(std::find(frames.begin(), frames.end(), planar.frame) - frames.begin());
    require(frame < frames.size(), "save_surfaces: there is no frame '" + planar.frame + "'");
    planar.frame = frames[f.choice("frame", frames, frame)];
    f.field("frame_from_surface", planar.frame_from_surface);
    point_fields<Metres>(f, planar.content, planar.points, surface.weights);
    surface.geometry = planar;
  } else {
    PixelSurface pixels = f.reading() ? PixelSurface{} : std::get<PixelSurface>(surface.geometry);
    point_fields<Pixels>(f, pixels.content, pixels.pixels, surface.weights);
    surface.geometry = pixels;
  }
}

static void fields(Fields& f, Placement& placement) {
  if (f.choice("kind", {"planar", "pixels"}, placement.index()) == 0) {
    PlacedPlane plane = f.reading() ? PlacedPlane{} : std::get<PlacedPlane>(placement);
    f.field("plane_from_content", plane.plane_from_content);
    f.field("projector_from_surface", plane.projector_from_surface);
    placement = plane;
  } else {
    PlacedPixels pixels = f.reading() ? PlacedPixels{} : std::get<PlacedPixels>(placement);
    f.field("pixel_from_content", pixels.pixel_from_content);
    placement = pixels;
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
  f.check(solved.placement.index() == solved.surface.geometry.index(), "placement",
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

SurfaceSet load_surfaces(const std::filesystem::path& path) {
  return load_noun<SurfaceSet>(path, syntax_of(path));
}

void save_surfaces(const std::filesystem::path& path, const SurfaceSet& surfaces) {
  save_noun(path, syntax_of(path), surfaces);
}

SolvedSurfaceSet load_solved_surfaces(const std::filesystem::path& path) {
  return load_noun<SolvedSurfaceSet>(path, syntax_of(path));
}

void save_solved_surfaces(const std::filesystem::path& path, const SolvedSurfaceSet& surfaces) {
  save_noun(path, syntax_of(path), surfaces);
}

}  // namespace procam::io
