#include "drift_check.hpp"

#include <algorithm>
#include <iterator>

#include "procam/analyze/verify.hpp"
#include "procam/core/base/clock.hpp"
#include "procam/core/base/words.hpp"
#include "procam/report/verify.hpp"
#include "wall.hpp"

namespace procam::studio {
namespace {

constexpr std::size_t kFewestMarks = 8;  // that analyze::verify() takes

std::vector<LightPoint> marks_on(const Surface& surface, const Rig& rig, const std::string& projector,
                                 const std::vector<LightPoint>& marks) {
  const Points2 outline = outline_in_frame(surface, rig, projector);
  std::vector<LightPoint> inside;
  std::copy_if(marks.begin(), marks.end(), std::back_inserter(inside),
               [&](const LightPoint& mark) { return contains(outline, mark.projector_pixel); });
  return inside;
}

Rig with_note(const Rig& corrected, const Rig& before, const std::string& note) {
  Rig rig = corrected;
  rig.provenance = before.provenance;
  std::string& notes = rig.provenance.options["corrected"];
  notes += (notes.empty() ? "" : "; ") + note;
  return rig;
}

/// The plane that each mark is on: the surface's own, or one that touches it.
std::vector<Pose> planes_of(const Surface& surface, const Rig& rig, const std::vector<LightPoint>& marks) {
  std::vector<Pose> planes;
  const bool is_flat = std::holds_alternative<PlanarSurface>(surface.geometry);
  for (const LightPoint& mark : marks)
    planes.push_back(is_flat ? place_of(surface.geometry)->frame_from_surface
                             : tangent_at(surface, rig, mark.camera_pixel));
  return planes;
}

/// By the marks of all walls together, which at several angles tell more than one: what the projector did, and the rig with it
/// there. Nothing where they say that something else has moved.
void correct_projector(const Rig& rig, const std::string& projector, const analyze::StatedSurface& walls,
                       const std::vector<LightPoint>& marks, Drift& drift) {
  analyze::VerifyOptions options;
  options.correct = analyze::Correct::kProjector;
  try {
    const analyze::VerifyResult result =
        analyze::verify(rig, rig.camera(), rig.projector(projector), walls, marks, options);
    if (!result.rig) return;
    const std::string words = report::description(result.projector_moved);
    for (WallDrift& wall : drift.walls)
      if (wall.moved) wall.remarks = words;
    drift.corrected = with_note(*result.rig, rig, "procam studio, " + utc_now() + ": " + words);
  } catch (const Error&) {  // each wall has its own cause
  }
}

/// The movement that explains the marks better.
std::string cause(const analyze::VerifyResult& result) {
  const bool is_wall =
      result.surface_moved && result.surface_moved->log_evidence > result.projector_moved.log_evidence;
  return report::description(is_wall ? *result.surface_moved : result.projector_moved);
}

}  // namespace

std::string to_sentence(const WallDrift& wall) {
  const std::string light = wall.projector.empty() ? "the light" : "the light of " + wall.projector;
  if (!wall.checked)
    return "'" + wall.surface + "'" + (wall.projector.empty() ? "" : ", " + light) + ": " + wall.remarks;
  return "'" + wall.surface + "': " + light + " is off by " + fixed(wall.rms_mm, 2) + " mm rms, " +
         fixed(wall.max_mm, 2) + " mm max (" + std::to_string(wall.marks) + " marks); " +
         (wall.moved ? "moved: " + wall.remarks : "nothing has moved");
}

bool Drift::moved() const {
  return std::any_of(walls.begin(), walls.end(), [](const WallDrift& wall) { return wall.moved; });
}

/// By the light of one projector.
static Drift check_projector(const Rig& rig, const SurfaceSet& surfaces, const std::string& projector,
                             const session::ProjectedBoardCapture& captured) {
  Drift drift;
  int checked = 0;
  analyze::StatedSurface walls{"walls", {}};
  std::vector<LightPoint> on_walls;
  for (const Surface& surface : surfaces.surfaces) {
    WallDrift wall;
    wall.surface = surface.name;
    wall.projector = projector;
    if (outline_in_frame(surface, rig, projector).empty()) {
      wall.remarks = "not checked: it is a mesh, or not in the rig's frame";
      drift.walls.push_back(std::move(wall));
      continue;
    }
    const std::vector<LightPoint> marks = marks_on(surface, rig, projector, captured.light.points);
    wall.marks = int(marks.size());
    if (marks.size() < kFewestMarks) {
      wall.remarks = "not checked: only " + std::to_string(marks.size()) + " marks of light fall on it";
      drift.walls.push_back(std::move(wall));
      continue;
    }
    analyze::StatedSurface stated{surface.name, {place_of(surface.geometry)->frame_from_surface}};
    stated.tangents = planes_of(surface, rig, marks);
    try {
      const analyze::VerifyResult result =
          analyze::verify(rig, rig.camera(), rig.projector(projector), stated, marks);
      ++checked;
      wall.checked = true;
      wall.rms_mm = 1e3 * result.rms;
      wall.max_mm = 1e3 * result.worst;
      wall.marks = result.used;
      wall.moved = result.alarm;
      if (result.alarm) wall.remarks = cause(result);
      walls.tangents.insert(walls.tangents.end(), stated.tangents.begin(), stated.tangents.end());
      on_walls.insert(on_walls.end(), marks.begin(), marks.end());
      walls.rig_from_surface.pose = stated.rig_from_surface.pose;
    } catch (const Error& error) {
      wall.remarks += (wall.remarks.empty() ? "" : "; ") + error.why();
    }
    drift.walls.push_back(std::move(wall));
  }
  if (drift.moved()) correct_projector(rig, projector, walls, on_walls, drift);
  if (checked == 0)
    throw Error(ErrorKind::kNotEnoughData, "drift check",
                surfaces.surfaces.empty() ? "there is no surface"
                                          : "no surface is checked: " + drift.walls.front().surface + ": " +
                                                drift.walls.front().remarks,
                "make a surface that the projector lights, and check again");
  return drift;
}

Drift check_drift(const Rig& rig, const SurfaceSet& surfaces, const std::vector<DriftCapture>& captured) {
  Drift all;
  std::optional<Error> unchecked;
  Rig now = rig;
  for (const DriftCapture& one : captured) {
    try {
      Drift drift = check_projector(now, surfaces, one.projector, one.captured);
      all.walls.insert(all.walls.end(), drift.walls.begin(), drift.walls.end());
      if (drift.corrected) all.corrected = now = std::move(*drift.corrected);
    } catch (const Error& error) {
      unchecked = error;
      WallDrift none;
      none.surface = "all surfaces", none.projector = one.projector, none.remarks = error.why();
      all.walls.push_back(std::move(none));
    }
  }
  const bool none =
      std::none_of(all.walls.begin(), all.walls.end(), [](const WallDrift& w) { return w.checked; });
  if (none && unchecked) throw *unchecked;
  return all;
}

}  // namespace procam::studio
