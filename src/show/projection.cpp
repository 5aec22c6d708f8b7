#include "procam/show/projection.hpp"

#include <algorithm>
#include <chrono>
#include <cstring>

#include "light_shift.hpp"
#include "moving_surfaces.hpp"
#include "procam/core/base/parallel.hpp"
#include "procam/render/cpu.hpp"
#include "procam/surface/lay_out.hpp"
#include "procam/surface/solve.hpp"
#include "procam/watch/marks.hpp"

namespace procam::show {
namespace {

/// Lines, a frame, and a cross from corner to corner: what is bent, turned or mirrored is seen at once.
ImageU8 grid_picture() {
  constexpr int kSize = 641, kStep = 80;
  ImageU8 picture(kSize, kSize, 3);
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) {
      const bool edge = x < 8 || y < 8 || x >= kSize - 8 || y >= kSize - 8;
      const bool line = x % kStep < 3 || y % kStep < 3;
      const bool cross = std::abs(x - y) < 3 || std::abs(x + y - kSize + 1) < 3;
      // The content's first quarter is marked, so that a turned surface shows.
      const bool first = x < kSize / 4 && y < kSize / 4;
      std::uint8_t* pixel = picture.row(y) + 3 * x;
      pixel[0] = edge || line ? 255 : (cross ? 200 : (first ? 90 : 20));
      pixel[1] = edge ? 160 : (line ? 255 : (cross ? 60 : 20));
      pixel[2] = edge ? 0 : (line ? 255 : (cross ? 60 : 20));
    }
  return picture;
}

double rms_of_light(const PlacedPlane& plane, const Pose& world_from_projector, const Mat6& covariance) {
  const std::optional<Mat3> shift = light_shift(plane, world_from_projector, covariance);
  return shift ? std::sqrt(std::max(0.0, shift->trace())) : 0;
}

/// Each row by one of several threads, where there is enough to do for them.
void apply_by_rows(const surface::FrameBlend& blend, ImageView<std::uint8_t> frame, int threads) {
  constexpr int kMaxThreads = 4;
  constexpr double kFewPixels = 50000;
  const bool few = blend.changed_share() * frame.width * frame.height < kFewPixels;
  parallel_for(frame.height, few ? 1 : std::min(kMaxThreads, thread_count(threads)),
               [&](int first, int last) { blend.apply(frame, first, last); });
}

void make_black(ImageView<std::uint8_t> frame) {
  for (int y = 0; y < frame.height; ++y)
    std::memset(frame.row(y), 0, std::size_t(frame.width) * std::size_t(frame.channels));
}

/// What a layout does not change: where the surface is.
void take_pose(const Placement& from, Placement& into) {
  if (const auto* plane = std::get_if<PlacedPlane>(&from))
    std::get<PlacedPlane>(into).projector_from_surface = plane->projector_from_surface;
  if (const auto* mesh = std::get_if<PlacedMesh>(&from))
    std::get<PlacedMesh>(into).projector_from_surface = mesh->projector_from_surface;
}

bool stands_in_world(const Surface& surface) {
  const InRoom* place = place_of(surface.geometry);
  return place != nullptr && place->frame == "world";
}

}  // namespace

struct Projection::State {
  RigProjector projector;
  ProjectionOptions options;
  track::PoseTrack track;
  Show show;
  SolvedSurfaceSet solved;
  TestPattern picture = TestPattern::kContent;
  ImageU8 grid = grid_picture(), white = ImageU8(8, 8, 1, 255);
  Scene scene;
  watch::Marks marks;
  MovingSurfaces moving;
  /// One a surface: how a picture of this size lies on it.
  struct Laid {
    ImageSize picture;
    surface::LaidOut layout;
    std::uint64_t number = 0;
  };
  std::vector<Laid> laid;
  /// One a surface: a number that no other content has had. Memory of one that is gone may come again with
  /// the next, and the renderer knows pictures by their memory and revision.
  std::vector<std::uint64_t> serials;
  std::vector<std::string> dark;                              ///< names
  std::vector<SurfaceLight> light;                            ///< one a surface
  std::vector<std::optional<device::ContentFrame>> pictures;  ///< one a surface
  std::uint64_t next_serial = 1;
  std::optional<Pose> rig_from_world;  ///< of a projector that stands still
  std::shared_ptr<const surface::FrameBlend> blend;

  State(const Rig& rig, ProjectionOptions given)
      : projector(rig.projector(given.projector)),
        options(std::move(given)),
        track(options.track),
        moving(options.moving, options.blank_on_stale) {
    if (!options.renderer) options.renderer = std::make_shared<render::CpuRenderer>();
    if (options.projector_from_world)
      rig_from_world = projector.rig_from_projector * *options.projector_from_world;
  }

  Pose projector_from_world(const Pose& world_from_child) const {
    return (world_from_child * options.child_from_rig * projector.rig_from_projector).inverse().normalized();
  }

  bool is_dark(std::size_t i) const {
    return std::find(dark.begin(), dark.end(), solved.surfaces[i].surface.name) != dark.end();
  }

  void add_item(std::size_t i, double content_time) {
    ViewU8 shown;
    std::uint64_t revision = 0;
    switch (picture) {
      case TestPattern::kContent: {
        if (!show.contents[i]) return;
        const device::ContentFrame frame = show.contents[i]->at(content_time);
        pictures[i] = frame;
        shown = frame.view;
        revision = (serials[i] << 40) + frame.revision;
        break;
      }
      case TestPattern::kGrid:
        shown = grid.view();
        break;
      case TestPattern::kMask:
        shown = white.view();
        break;
    }
    const Placement& placement = solved.surfaces[i].placement;
    const auto* mesh = std::get_if<PlacedMesh>(&placement);
    if (mesh != nullptr && mesh->mesh->triangles.empty()) return;
    Laid& way = laid[i];
    if (way.picture != shown.size()) {
      way.layout = surface::lay_out(placement, solved.surfaces[i].surface, shown.size());
      way.picture = shown.size();
      way.number = next_serial++;
    }
    take_pose(placement, way.layout.placement);
    SceneItem& item = scene.items.emplace_back();
    item.placement = way.layout.placement;
    item.content = way.layout.part(shown);
    item.content_revision = revision;
    item.mask = way.layout.mask;
    item.mask_revision = way.number;
  }
};

Projection::Projection(const Rig& rig, ProjectionOptions options)
    : state_(std::make_unique<State>(rig, std::move(options))) {
  state_->solved.projector = state_->projector.name;
}
Projection::~Projection() = default;
Projection::Projection(Projection&&) noexcept = default;
Projection& Projection::operator=(Projection&&) noexcept = default;

ImageSize Projection::frame_size() const {
  return state_->projector.projector.size();
}
const Projector& Projection::projector() const {
  return state_->projector.projector;
}

void Projection::set_show(Show show) {
  require(show.contents.size() == show.surfaces.surfaces.size(),
          "Projection: give a content, or null, for each surface");
  // Where the projector stands is of no matter for what is kept of the solution; draw() moves it there.
  Pose somewhere;
  if (state_->options.projector_from_world)
    somewhere = *state_->options.projector_from_world;
  else if (state_->solved.projector_from_world)
    somewhere = *state_->solved.projector_from_world;
  surface::SolveOptions solving;
  solving.visibility = false;
  SolvedSurfaceSet solved = surface::solve_surfaces(show.surfaces, state_->projector, somewhere, solving);
  state_->moving.take(show.surfaces);
  state_->solved = std::move(solved);
  std::vector<std::uint64_t> serials;
  for (const auto& content : show.contents) {
    const auto& before = state_->show.contents;
    const auto same = std::find(before.begin(), before.end(), content);
    serials.push_back(same == before.end() ? state_->next_serial++
                                           : state_->serials[std::size_t(same - before.begin())]);
  }
  state_->serials = std::move(serials);
  state_->laid.assign(show.contents.size(), {});
  state_->light.assign(show.contents.size(), SurfaceLight::kNone);
  state_->pictures.assign(show.contents.size(), std::nullopt);
  state_->show = std::move(show);
}
const Show& Projection::show() const {
  return state_->show;
}
const SolvedSurfaceSet& Projection::solved() const {
  return state_->solved;
}

SolvedSurfaceSet Projection::solve_again() const {
  return surface::solve_surfaces(state_->show.surfaces, state_->projector,
                                 state_->solved.projector_from_world.value_or(Pose()));
}

bool Projection::set_mesh(const std::string& surface, std::shared_ptr<const Mesh> mesh) {
  for (std::size_t i = 0; i < state_->solved.surfaces.size(); ++i) {
    SolvedSurface& solved = state_->solved.surfaces[i];
    auto* placed = std::get_if<PlacedMesh>(&solved.placement);
    if (placed == nullptr || solved.surface.name != surface) continue;
    placed->mesh = std::move(mesh);
    state_->laid[i] = {};
    return true;
  }
  return false;
}

void Projection::move_projector(const Pose& rig_from_projector) {
  State& s = *state_;
  require(rig_from_projector.is_finite(), "Projection: the projector's pose is not finite");
  s.projector.rig_from_projector = rig_from_projector;
  if (s.rig_from_world)
    s.options.projector_from_world = (rig_from_projector.inverse() * *s.rig_from_world).normalized();
  surface::move_in_rig(s.solved, s.projector);
}
const Pose& Projection::rig_from_projector() const {
  return state_->projector.rig_from_projector;
}

void Projection::add(const track::StampedPose& message) {
  state_->track.add(message);
}
const track::PoseTrack& Projection::track() const {
  return state_->track;
}
std::optional<Pose> Projection::projector_from_world(double time) const {
  if (state_->options.projector_from_world) return state_->options.projector_from_world;
  const track::TrackedPose pose = state_->track.at(time);
  if (pose.state == track::TrackState::kNone) return std::nullopt;
  return state_->projector_from_world(pose.frame_from_child);
}

void Projection::add_sighting(const track::StampedPose& message) {
  state_->moving.add(message);
}
const std::vector<MovingState>& Projection::moving() const {
  return state_->moving.states();
}

void Projection::set_dark(std::vector<std::string> surfaces) {
  state_->dark = std::move(surfaces);
}
SurfaceLight Projection::light(std::size_t surface) const {
  return state_->light.at(surface);
}

std::optional<device::ContentFrame> Projection::picture_of(std::size_t surface) const {
  return state_->pictures.at(surface);
}

bool Projection::draw_over(double light_time, ImageView<std::uint8_t> frame) const {
  if (!state_->options.over) return false;
  state_->options.over(*this, light_time, frame);
  return true;
}

void Projection::set_blend(std::shared_ptr<const surface::FrameBlend> blend) {
  require(!blend || blend->size() == frame_size(), "Projection: a blend of another size than the frame's");
  state_->blend = std::move(blend);
}

void Projection::set_picture(TestPattern picture) {
  state_->picture = picture;
}
TestPattern Projection::picture() const {
  return state_->picture;
}

DrawnFrame Projection::draw(double light_time, double content_time, ImageView<std::uint8_t> frame) {
  State& s = *state_;
  DrawnFrame drawn;
  bool placed = s.options.projector_from_world.has_value();
  if (placed) {
    surface::move_to(s.solved, s.projector, *s.options.projector_from_world);
  } else {
    drawn.pose = s.track.at(light_time);
    placed = drawn.pose.state != track::TrackState::kNone;
    if (placed) surface::move_to(s.solved, s.projector, s.projector_from_world(drawn.pose.frame_from_child));
    drawn.blanked = drawn.pose.state == track::TrackState::kStale && s.options.blank_on_stale;
  }

  s.moving.place(light_time, s.projector.rig_from_projector, s.solved);
  drawn.unseen = s.moving.dark_count();

  s.scene.items.clear();
  std::fill(s.light.begin(), s.light.end(), SurfaceLight::kNone);
  std::fill(s.pictures.begin(), s.pictures.end(), std::nullopt);
  for (std::size_t i = 0; i < s.solved.surfaces.size() && !drawn.blanked; ++i) {
    const SolvedSurface& surface = s.solved.surfaces[i];
    if (s.moving.is_dark(i)) continue;
    const bool of_pose = stands_in_world(surface.surface) && !s.moving.moves(i);
    if (!placed && of_pose) {
      drawn.waiting = true;
      continue;
    }
    const std::size_t items = s.scene.items.size();
    try {
      s.add_item(i, content_time);
    } catch (const std::exception& error) {
      drawn.content_fault = "surface '" + surface.surface.name + "' is dark: " + error.what();
      continue;
    }
    if (s.scene.items.size() == items) continue;
    s.light[i] = s.is_dark(i) ? SurfaceLight::kDark : SurfaceLight::kShown;
    if (s.light[i] == SurfaceLight::kDark) {
      s.scene.items.pop_back();
      continue;
    }
    const auto* plane = std::get_if<PlacedPlane>(&surface.placement);
    if (plane != nullptr && drawn.pose.state != track::TrackState::kNone && of_pose)
      drawn.pose_error =
          std::max(drawn.pose_error,
                   rms_of_light(*plane, s.solved.projector_from_world->inverse(), drawn.pose.covariance));
  }
  const std::uint8_t search_light = drawn.blanked ? 0 : s.moving.search_light();
  std::fill(std::begin(s.scene.background), std::end(s.scene.background), search_light);
  if (s.scene.items.empty() && search_light == 0) {
    drawn.blanked = drawn.blanked || drawn.waiting;
    make_black(frame);
    return drawn;
  }
  s.moving.light_markers(s.light, s.scene);
  const auto begin = std::chrono::steady_clock::now();
  s.options.renderer->render(s.scene, s.projector.projector, frame);
  if (s.options.marks && s.picture == TestPattern::kContent)
    s.marks.draw(light_time, s.scene, s.projector.projector, frame);
  if (s.blend) apply_by_rows(*s.blend, frame, s.options.threads);
  draw_over(light_time, frame);
  drawn.render_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return drawn;
}

}  // namespace procam::show
