#include "editor.hpp"

#include <algorithm>
#include <array>
#include <map>

#include "document/document.hpp"
#include "editor_points.hpp"
#include "editor_shapes.hpp"
#include "procam/core/base/limits.hpp"
#include "procam/core/base/words.hpp"
#include "uncalibrated.hpp"

namespace procam::show {
namespace {

constexpr int kCurvedSteps = 12;  ///< of a side of a curved outline

Error refuse(const Command& command, const std::string& why, const std::string& next) {
  return Error(ErrorKind::kInput,
               command.verb + (command.surface.empty() ? "" : " '" + command.surface + "'"), why, next);
}

void require_name(const Command& command, const std::string& name, const SurfaceSet& surfaces) {
  if (name.empty() || name.size() > limits::kSurfaceNameBytes)
    throw refuse(command, "a surface needs a name of at most 64 letters", "give another name");
  if (!io::is_plain_text(name) || name.find_first_of("\t\n\r") != name.npos)
    throw refuse(command, "the name is not UTF-8 or has letters that do not print", "give another name");
  for (const Surface& surface : surfaces.surfaces)
    if (surface.name == name)
      throw refuse(command, "there is a surface '" + name + "' already", "give another name");
}

Points2* points_of(SurfaceGeometry& geometry) {
  return const_cast<Points2*>(edited_points(geometry));
}

/// The place of a point in the surface's own units.
void require_place(const Command& command, const Points2* points) {
  if (!command.pixels.allFinite() || command.pixels.cwiseAbs().maxCoeff() > 1e5)
    throw refuse(command, "the place is no number, or far away", "give a place on the surface");
  if (points == nullptr || command.point < 0 || command.point >= int(points->size()))
    throw refuse(command, "it has no point " + std::to_string(command.point), "name one that it has");
}

Vec2 on_plane(const Command& command, const Vec2& pixel, const Pose& projector_from_surface,
              const Projector& projector) {
  // The plane z = 0 in the surface's own frame, met by the ray brought there.
  const std::optional<Ray> ray = projector.emit(pixel);
  std::optional<Vec3> met;
  if (ray) {
    const Pose surface_from_projector = projector_from_surface.inverse();
    const Vec3 origin = surface_from_projector * ray->origin,
               direction = surface_from_projector.rotate(ray->direction);
    const double along = -origin.z() / direction.z();
    if (along > 0 && std::isfinite(along)) met = origin + along * direction;
  }
  if (!met || met->norm() > 1e4)
    throw refuse(command, "the light of that pixel does not meet the surface's plane",
                 "drop the corner on the surface");
  return met->head<2>();
}

const SolvedSurface& solved_of(const Command& command, const SolvedSurfaceSet& solved) {
  if (const SolvedSurface* found = find_solved(solved, command.surface)) return *found;
  throw refuse(command, "it is not shown", "name one that is shown");
}

void move_points(const Command& command, const Projector& projector, const SolvedSurfaceSet& solved,
                 Surface& changed) {
  if (!command.pixels.allFinite() || command.pixels.cwiseAbs().maxCoeff() > 1e5)
    throw refuse(command, "the place is no number, or far away", "give a pixel of the frame");
  Points2* points = points_of(changed.geometry);
  const SolvedSurface* placed = find_solved(solved, command.surface);
  if (points == nullptr || placed == nullptr)
    throw refuse(command, "this kind of surface has no corners to drag", "change its file");
  const int count = int(points->size()), first = command.verb == "nudge" ? -1 : 0;
  if (command.point >= count || command.point < first)
    throw refuse(command, "it has no point " + std::to_string(command.point),
                 "name 0 to " + std::to_string(count - 1));
  const auto* plane = std::get_if<PlacedPlane>(&placed->placement);
  const std::vector<std::optional<Vec2>> shown = points_in_frame(*placed, projector);
  for (int i = 0; i < count; ++i) {
    if (command.point >= 0 && i != command.point) continue;
    Vec2 pixel = command.pixels;
    if (command.verb == "nudge") {
      if (std::size_t(i) >= shown.size() || !shown[std::size_t(i)])
        throw refuse(command, "that point is not in the projector's sight", "move it there first");
      pixel += *shown[std::size_t(i)];
    }
    (*points)[std::size_t(i)] =
        plane == nullptr ? pixel : on_plane(command, pixel, plane->projector_from_surface, projector);
  }
}

void place_point(const Command& command, const Projector&, const SolvedSurfaceSet&, Surface& changed) {
  Points2* points = points_of(changed.geometry);
  require_place(command, points);
  (*points)[std::size_t(command.point)] = command.pixels;
}

void make_hole(const Command& command, Points2 ring, Surface& changed) {
  try {
    add_hole(changed.shape, std::move(ring));
  } catch (const std::invalid_argument& fault) {
    throw refuse(command, fault.what(), "give the mask's corners in order, apart from other masks");
  }
}

void add_mask(const Command& command, const Projector& projector, const SolvedSurfaceSet& solved,
              Surface& changed) {
  const SolvedSurface& placed = solved_of(command, solved);
  Points2 ring;
  for (const Vec2& pixel : command.ring) {
    const std::optional<Vec2> uv = content_at(placed, projector, pixel);
    if (!uv) throw refuse(command, "the light of a corner does not meet the surface", "click on the surface");
    ring.push_back(*uv);
  }
  make_hole(command, std::move(ring), changed);
}

void take_hole(const Command& command, const Projector&, const SolvedSurfaceSet&, Surface& changed) {
  make_hole(command, command.ring, changed);
}

void remove_masks(const Command& command, const Projector&, const SolvedSurfaceSet&, Surface& changed) {
  std::vector<Points2>& holes = changed.shape.holes;
  if (command.point >= int(holes.size()))
    throw refuse(command, "it has no mask " + std::to_string(command.point),
                 "name one of its " + std::to_string(holes.size()) + " from 0, or none for all");
  if (command.point < 0)
    holes.clear();
  else
    holes.erase(holes.begin() + command.point);
}

void change_shape(const Command& command, const Projector&, const SolvedSurfaceSet& solved,
                  Surface& changed) {
  auto* pixels = std::get_if<PixelSurface>(&changed.geometry);
  const auto* placed = std::get_if<PlacedPixels>(&solved_of(command, solved).placement);
  if (pixels == nullptr || placed == nullptr)
    throw refuse(command, "it is not in projector pixels", "change its file, or add another surface");
  try {
    *pixels = reshaped(*pixels, *placed, command.text);
  } catch (const std::invalid_argument& fault) {
    throw refuse(command, fault.what(), "name another shape");
  }
  changed.weights.clear();
}

void change_content(const Command& command, const Projector&, const SolvedSurfaceSet&, Surface& changed) {
  changed.content = command.text;
}

/// Of one surface; they throw before they change anything.
using Change = void (*)(const Command&, const Projector&, const SolvedSurfaceSet&, Surface&);
const std::map<std::string, Change>& changes() {
  static const std::map<std::string, Change> changes = {
      {"move", move_points}, {"nudge", move_points},   {"place", place_point},  {"mask", add_mask},
      {"hole", take_hole},   {"unmask", remove_masks}, {"shape", change_shape}, {"content", change_content}};
  return changes;
}

}  // namespace

Editor::Editor(SurfaceSet surfaces) : surfaces_(std::move(surfaces)) {}

Surface& Editor::find(const std::string& name) {
  for (Surface& surface : surfaces_.surfaces)
    if (surface.name == name) return surface;
  throw Error(ErrorKind::kInput, "surface '" + name + "'", "there is none of this name",
              "name one that is shown");
}

void Editor::begin_step(const std::string& gesture) {
  last_ = surfaces_;
  const bool same_step = !gesture.empty() && gesture == gesture_ && !before_.empty();
  gesture_ = gesture;
  if (same_step) return;
  before_.push_back(surfaces_);
  if (before_.size() > limits::kEditSteps) before_.erase(before_.begin());
  after_.clear();
}

void Editor::apply(const Command& command, const Projector& projector, const SolvedSurfaceSet& solved) {
  const std::string& verb = command.verb;
  if (!io::is_plain_text(command.text))
    throw refuse(command, "the text is not UTF-8 or has control characters", "give another text");
  if (const auto change = changes().find(verb); change != changes().end()) {
    Surface changed = find(command.surface);
    change->second(command, projector, solved, changed);
    begin_step(command.gesture);
    find(command.surface) = std::move(changed);
  } else if (verb == "add") {
    require_name(command, command.surface, surfaces_);
    if (surfaces_.surfaces.size() >= limits::kEditedSurfaces)
      throw refuse(command, "there are 64 surfaces already", "remove one first");
    begin_step("");
    const Vec2 frame(projector.size().width, projector.size().height);
    surfaces_.surfaces.push_back(
        {command.surface, pixel_rectangle(0.25 * frame, 0.5 * frame), {}, command.text});
  } else if (verb == "remove") {
    const Surface* gone = &find(command.surface);
    begin_step("");
    surfaces_.surfaces.erase(surfaces_.surfaces.begin() + (gone - surfaces_.surfaces.data()));
  } else if (verb == "rename") {
    Surface& renamed = find(command.surface);
    require_name(command, command.text, surfaces_);
    begin_step("");
    renamed.name = command.text;
  } else {
    throw refuse(command, "there is no such command", "see docs/live.md");
  }
  unsaved_ = true;
}

void Editor::revoke() {
  if (!last_) return;
  surfaces_ = std::move(*last_);
  last_.reset();
}

void Editor::replace(SurfaceSet surfaces, bool saved) {
  begin_step("");
  surfaces_ = std::move(surfaces);
  unsaved_ = !saved;
}

bool Editor::undo() {
  if (before_.empty()) return false;
  after_.push_back(std::move(surfaces_));
  surfaces_ = std::move(before_.back());
  before_.pop_back();
  gesture_.clear();
  return unsaved_ = true;
}

bool Editor::redo() {
  if (after_.empty()) return false;
  before_.push_back(std::move(surfaces_));
  surfaces_ = std::move(after_.back());
  after_.pop_back();
  gesture_.clear();
  return unsaved_ = true;
}

const SolvedSurface* find_solved(const SolvedSurfaceSet& solved, const std::string& name) {
  for (const SolvedSurface& surface : solved.surfaces)
    if (surface.surface.name == name) return &surface;
  return nullptr;
}

const Points2* edited_points(const SurfaceGeometry& geometry) {
  if (const auto* pixels = std::get_if<PixelSurface>(&geometry)) return &pixels->pixels;
  if (const auto* plane = std::get_if<PlanarSurface>(&geometry)) return &plane->points;
  return nullptr;
}

std::vector<std::optional<Vec2>> points_in_frame(const SolvedSurface& surface, const Projector& projector) {
  std::vector<std::optional<Vec2>> shown;
  if (const auto* pixels = std::get_if<PixelSurface>(&surface.surface.geometry))
    shown.assign(pixels->pixels.begin(), pixels->pixels.end());
  const auto* plane = std::get_if<PlanarSurface>(&surface.surface.geometry);
  const auto* placed = std::get_if<PlacedPlane>(&surface.placement);
  if (plane != nullptr && placed != nullptr)
    for (const Vec2& point : plane->points)
      shown.push_back(projector.project(placed->projector_from_surface * Vec3(point.x(), point.y(), 0)));
  return shown;
}

std::vector<std::optional<Vec2>> outline_in_frame(const SolvedSurface& surface, const Projector& projector) {
  std::vector<std::optional<Vec2>> outline;
  if (edited_points(surface.surface.geometry) == nullptr) return outline;
  const auto* pixels = std::get_if<PixelSurface>(&surface.surface.geometry);
  const int steps = pixels != nullptr && pixels->is_curved() ? kCurvedSteps : 1;
  const std::array<Vec2, 5> corners = {Vec2(0, 0), Vec2(1, 0), Vec2(1, 1), Vec2(0, 1), Vec2(0, 0)};
  for (std::size_t side = 0; side < 4; ++side)
    for (int i = 0; i < steps; ++i)
      outline.push_back(frame_at(surface, projector,
                                 corners[side] + double(i) / steps * (corners[side + 1] - corners[side])));
  return outline;
}

std::vector<std::vector<std::optional<Vec2>>> masks_in_frame(const SolvedSurface& surface,
                                                             const Projector& projector) {
  std::vector<std::vector<std::optional<Vec2>>> masks;
  for (const Points2& hole : surface.surface.shape.holes) {
    std::vector<std::optional<Vec2>>& mask = masks.emplace_back();
    for (const Vec2& uv : hole) mask.push_back(frame_at(surface, projector, uv));
  }
  return masks;
}

std::string fit_sentence(const SolvedSurface& surface) {
  constexpr std::size_t kExact = 4;
  const Points2* points = edited_points(surface.surface.geometry);
  if (points == nullptr || points->size() <= kExact || surface.residuals.empty()) return "";
  const double largest = *std::max_element(surface.residuals.begin(), surface.residuals.end());
  const bool in_pixels = std::holds_alternative<PixelSurface>(surface.surface.geometry);
  return std::to_string(points->size()) + " points: fitted, up to " +
         (in_pixels ? fixed(largest, 1) + " px off" : fixed(1e3 * largest, 1) + " mm off");
}

}  // namespace procam::show
