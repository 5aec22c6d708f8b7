#pragma once
/// Surfaces changed by hand while they are shown: corners dragged and nudged, surfaces added, renamed and
/// removed, with undo.
///
///   Editor editor(io::load_surfaces(file));
///   editor.apply({"move", "wall", 2, {812.5, 40.1}, "drag 7"}, projection.projector(), projection.solved());
///   editor.undo();
///
/// A surface's points are its destination points, in the order of its pairs. They are moved in the frame's
/// pixels: those of a pixel surface as they are; those of a plane to where the light of that pixel lands on
/// the plane now,
///   point = (x, y) of  land(pixel, plane z = 0 of projector_from_surface),
/// through the lens. Grids and Bezier patches in pixels have their points moved likewise. Other geometries have no such points: what they are is in their files.
#include <optional>
#include <string>
#include <vector>

#include "procam/core/lens/projector.hpp"
#include "procam/core/surface/surface.hpp"

namespace procam::show {

/// What a person asks for, at the page or at the keyboard.
struct Command {
  /// "move", "nudge" (a point, to or by `pixels`), "place" (a point, to `pixels` in the surface's own units: pixels, or
  /// metres of a plane), "add", "remove", "rename" (to `text`), "content" (`text`),
  /// "mask" (`ring` of frame pixels stays dark), "hole" (the same in content coordinates), "unmask" (`point`: which; -1:
  /// all), "shape" of a surface in pixels (`text`: "flat", "grid 5x4", "bezier 4x4"),
  /// "undo", "redo"; the loop knows others (loop.hpp).
  std::string verb;
  std::string surface;
  int point = -1;  ///< of the surface's pairs; -1 with "nudge": all of them
  Vec2 pixels = Vec2::Zero();
  std::string text;
  /// Moves that belong together (one drag) carry one name and are undone in one step; empty: a step of its
  /// own.
  std::string gesture;
  Points2 ring = {};  ///< of a mask
};

/// Corners that a mask of a command may have.
inline constexpr std::size_t kMaskCorners = 64;

class Editor {
 public:
  explicit Editor(SurfaceSet surfaces);

  const SurfaceSet& surfaces() const { return surfaces_; }
  /// Changed since it was loaded or mark_saved()?
  bool is_unsaved() const { return unsaved_; }
  bool can_undo() const { return !before_.empty(); }
  bool can_redo() const { return !after_.empty(); }

  /// Changes the surfaces. Throws Error(kInput) for what cannot be done, which then changes nothing; the
  /// caller solves the result, and calls revoke() if that fails.
  void apply(const Command& command, const Projector& projector, const SolvedSurfaceSet& solved);
  /// The last apply() did not happen.
  void revoke();
  /// Another set: a step that can be undone. `saved`: of a file that another program changed; a correction is not saved.
  void replace(SurfaceSet surfaces, bool saved);
  bool undo();
  bool redo();
  void mark_saved() { unsaved_ = false; }
  /// The surfaces as they are read from a file: no step of its own.
  void set_read_back(SurfaceSet surfaces) { surfaces_ = std::move(surfaces); }

 private:
  void begin_step(const std::string& gesture);
  Surface& find(const std::string& name);

  SurfaceSet surfaces_;
  std::vector<SurfaceSet> before_, after_;
  std::optional<SurfaceSet> last_;  ///< for revoke()
  std::string gesture_;
  bool unsaved_ = false;
};

}  // namespace procam::show
