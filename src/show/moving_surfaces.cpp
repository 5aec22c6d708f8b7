#include "moving_surfaces.hpp"

#include <algorithm>
#include <cmath>

#include "light_shift.hpp"

namespace procam::show {
namespace {

/// Border of the light on a marker, share of its side: its white rim, and what a prediction is off by.
constexpr double kMarkerBorder = 0.25;

std::optional<std::size_t> number_of(const SurfaceSet& set, const std::string& name) {
  for (std::size_t i = 0; i < set.surfaces.size(); ++i)
    if (set.surfaces[i].name == name) return i;
  return std::nullopt;
}

const InRoom& place_of_moving(const Surface& surface) {
  const InRoom* place = place_of(surface.geometry);
  if (place == nullptr)
    throw Error(ErrorKind::kInput, "surface '" + surface.name + "'",
                "it is tracked, and given in projector pixels, which do not move with it",
                "define it in metres, in the frame of its markers");
  return *place;
}

Placement marker_patch(const PlacedMarker& marker, const Pose& projector_from_first) {
  const double half = (0.5 + kMarkerBorder) * marker.size;
  PlacedPlane plane;
  plane.plane_from_content << 2 * half, 0, -half, 0, 2 * half, -half, 0, 0, 1;
  plane.projector_from_surface = projector_from_first * marker.world_from_marker;
  return plane;
}

}  // namespace

MovingSurfaces::MovingSurfaces(const MovingOptions& options, bool blank_on_stale)
    : options_(options), blank_on_stale_(blank_on_stale) {
  require(options.marker_light >= -1 && options.marker_light <= 255,
          "MovingOptions: marker_light is a grey value, or -1");
  require(options.search_light >= 0 && options.search_light <= 255,
          "MovingOptions: search_light is a grey value");
  marker_light_ =
      options.marker_light < 0 && options.search_light > 0 ? options.search_light : options.marker_light;
  light_value_ = std::uint8_t(std::max(0, marker_light_));
  for (const MovingSurface& what : options.surfaces) {
    require(!what.surfaces.empty(), "MovingSurface: no surface is named");
    track::TrackOptions track = options.track;
    track.frame = "rig";
    track.child = what.surfaces.front();
    bodies_.push_back({what, track::PoseTrack(track)});
  }
}

void MovingSurfaces::take(const SurfaceSet& set) {
  std::vector<Shown> shown;
  std::vector<MovingState> states;
  std::vector<int> body_of(set.surfaces.size(), -1);
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const std::vector<std::string>& names = bodies_[b].what.surfaces;
    const std::optional<std::size_t> first = number_of(set, names.front());
    if (!first) continue;
    const InRoom& place = place_of_moving(set.surfaces[*first]);
    Shown body;
    body.body = b;
    for (const std::string& name : names) {
      const std::optional<std::size_t> i = number_of(set, name);
      if (!i) continue;
      const InRoom& other = place_of_moving(set.surfaces[*i]);
      if (other.frame != place.frame)
        throw Error(ErrorKind::kInput, "surface '" + name + "'",
                    "it moves with '" + names.front() + "', and is placed in another frame",
                    "place both in one frame, e.g. the rig");
      body.members.push_back({*i, place.frame_from_surface.inverse() * other.frame_from_surface});
      body_of[*i] = int(shown.size());
    }
    shown.push_back(std::move(body));
    states.emplace_back().surface = names.front();
  }
  shown_ = std::move(shown);
  states_ = std::move(states);
  body_of_ = std::move(body_of);
}

void MovingSurfaces::add(const track::StampedPose& message) {
  for (Body& body : bodies_)
    if (body.what.surfaces.front() == message.child) body.track.add(message), body.is_sighted = true;
}

void MovingSurfaces::place(double light_time, const Pose& rig_from_projector, SolvedSurfaceSet& solved) {
  dark_count_ = 0;
  for (std::size_t b = 0; b < shown_.size(); ++b) {
    Shown& body = shown_[b];
    MovingState& state = states_[b];
    state.seen = bodies_[body.body].track.at(light_time);
    state.is_dark = state.seen.state == track::TrackState::kNone ||
                    (state.seen.state == track::TrackState::kStale && blank_on_stale_);
    state.error = 0;
    dark_count_ += state.is_dark ? 1 : 0;
    if (state.is_dark) continue;
    body.projector_from_first = (rig_from_projector.inverse() * state.seen.frame_from_child).normalized();
    for (const Member& member : body.members) {
      Placement& placement = solved.surfaces[member.surface].placement;
      const Pose moved = (body.projector_from_first * member.first_from_surface).normalized();
      if (auto* mesh = std::get_if<PlacedMesh>(&placement)) mesh->projector_from_surface = moved;
      auto* plane = std::get_if<PlacedPlane>(&placement);
      if (plane == nullptr) continue;
      plane->projector_from_surface = moved;
      judge(bodies_[body.body], *plane, rig_from_projector, state);
    }
    bodies_[body.body].is_sighted = false;
    if (state.seen.state == track::TrackState::kFresh)
      bodies_[body.body].check.predicted(light_time, state.seen);
  }
}

/// The error of a plane surface, from the covariance of the newest pose and what predictions have added to it before.
void MovingSurfaces::judge(Body& body, const PlacedPlane& plane, const Pose& rig_from_projector,
                           MovingState& state) const {
  if (body.is_sighted) body.check.compare(body.track, plane, rig_from_projector);
  body.is_sighted = false;  // one plane of the body is enough
  const Mat6 known = body.track.at(body.track.newest_time()).covariance;
  const double of_known = mean_square_shift(plane, rig_from_projector, known);
  const double added = mean_square_shift(plane, rig_from_projector, state.seen.covariance) - of_known;
  const double square = of_known + body.check.ratio() * std::max(0.0, added);
  state.error = std::max(state.error, std::sqrt(std::max(0.0, square)));
}

std::uint8_t MovingSurfaces::search_light() const {
  const bool all_seen = std::all_of(states_.begin(), states_.end(), [](const MovingState& state) {
    return state.seen.state == track::TrackState::kFresh;
  });
  return all_seen ? 0 : std::uint8_t(options_.search_light);
}

void MovingSurfaces::light_markers(const std::vector<SurfaceLight>& light, Scene& scene) const {
  if (marker_light_ < 0) return;
  for (const Shown& body : shown_) {
    if (std::none_of(body.members.begin(), body.members.end(),
                     [&](const Member& member) { return light[member.surface] == SurfaceLight::kShown; }))
      continue;
    for (const PlacedMarker& marker : bodies_[body.body].what.markers.markers) {
      SceneItem& item = scene.items.emplace_back();
      item.placement = marker_patch(marker, body.projector_from_first);
      item.content = ViewU8(&light_value_, 1, 1, 1);
      item.content_revision = std::uint64_t(light_value_);
    }
  }
}

}  // namespace procam::show
