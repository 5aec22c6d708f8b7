#pragma once
/// From poses, surfaces and contents to a frame, for one moment of light.
///
///   Projection projection(rig, options);
///   projection.set_show(show);
///   projection.add(message);                                  // as poses come
///   projection.draw(now + delay, now - begin, frame);         // as frames are due
///
/// The poses tell where the robot stands: world_from_child, the surfaces' "world" being the poses' frame.
/// With the rig's place on it,
///
///   projector_from_world = (world_from_child(light) * child_from_rig * rig_from_projector)^-1,
///
/// predicted to the moment at which the frame's light leaves the projector (track/pose_track.hpp).
///
/// Surfaces that move on their own (ProjectionOptions::moving) have poses in the rig, from add_sighting(), which are predicted
/// to that moment as well:
///
///   projector_from_surface = rig_from_projector^-1 * rig_from_surface(light).
///
/// The frame depends on what went in and the two times alone: the same calls in the same order give the same
/// frames, bit for bit. No clock is read here, nothing waits, and nothing is allocated for a frame in which
/// nothing but the pose changes and that is not blended (docs/render.md lists the caches of a renderer).
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/board/marker.hpp"
#include "procam/core/rig/rig.hpp"
#include "procam/core/surface/scene.hpp"
#include "procam/core/surface/surface.hpp"
#include "procam/device/content_source.hpp"
#include "procam/render/renderer.hpp"
#include "procam/surface/blend.hpp"
#include "procam/track/pose_track.hpp"

namespace procam::show {

/// What is shown: surfaces, and the content of each.
struct Show {
  SurfaceSet surfaces;
  /// One a surface; null: it stays dark.
  std::vector<std::shared_ptr<device::ContentSource>> contents;
};

/// What the surfaces carry.
enum class TestPattern {
  kContent,
  kGrid,  ///< a grid with the surface's outline, for aligning
  kMask   ///< white: where light goes at all
};

/// Of a surface in the frame drawn last.
enum class SurfaceLight {
  kNone,  ///< it cannot be shown: no content, no image of it, no pose
  kDark,  ///< it could be shown, and is kept dark (Projection::set_dark)
  kShown
};

/// Surfaces that move on their own as one body: a cart, a door, a parcel.
struct MovingSurface {
  /// The first one is the one that is sighted. Others keep the place beside it that the surface set gives them.
  std::vector<std::string> surfaces;
  MarkerMap markers;  ///< in the frame of the first one
};

struct MovingOptions {
  std::vector<MovingSurface> surfaces;
  track::TrackOptions track;
  /// Grey value of the light on each marker and a border of a quarter of its side, instead of the content's; -1: the
  /// content's.
  int marker_light = -1;
  /// Grey value of all light around the surfaces while one of them is not seen, so that its markers are found in the dark;
  /// 0: none. With it the default of `marker_light` is this value: markers that are found stay lit.
  int search_light = 0;
};

/// Of a MovingSurface in the frame drawn last.
struct MovingState {
  std::string surface;      ///< the first one
  track::TrackedPose seen;  ///< rig_from_surface at the light
  bool is_dark = true;      ///< never sighted; or not any more, and stale surfaces are dark
  /// Root mean square distance of the light from its place, as DrawnFrame::pose_error: the largest over the plane surfaces.
  double error = 0;
};

class Projection;
/// What is drawn over every frame that has light in it, last, for the light of a time: an eye-safe mask.
using DrawOver = std::function<void(const Projection&, double light_time, ImageView<std::uint8_t>)>;

struct ProjectionOptions {
  std::string projector;  ///< its name in the rig; may be empty when the rig has one
  /// A projector that stands still: no poses are awaited. Without it, surfaces in the world stay dark until a
  /// pose has come.
  std::optional<Pose> projector_from_world;
  Pose child_from_rig;  ///< the rig's place on what the poses tell of
  track::TrackOptions track;
  /// When no news has come for track.stale_after: black (true), or drawn from where the robot was then.
  bool blank_on_stale = false;
  /// `blank_on_stale` counts for each of them alone.
  MovingOptions moving;
  std::shared_ptr<render::Renderer> renderer;  ///< null: a CpuRenderer of its own
  bool marks = false;  ///< watch::Marks, small marks where the content of a plane surface has no texture
  int threads = 0;     ///< of the blend; 0: as many as the machine has, four at most
  DrawOver over;       ///< may be empty
};

struct DrawnFrame {
  track::TrackedPose pose;  ///< world_from_child at the light; kNone for a projector that stands still
  bool blanked = false;     ///< black because the pose is stale or has never come
  bool waiting = false;     ///< surfaces in the world are dark because no pose has come yet
  int unseen = 0;           ///< moving surfaces that are dark, since they are not sighted
  double render_s = 0;      ///< spent in the renderer and the blend
  /// Why a content gave no image, with its surface, which is dark in this frame; of the last one. Empty: all did.
  std::string content_fault;
  /// Root mean square distance of the light from its place that the pose's covariance predicts, metres: the
  /// largest over the centres of the plane surfaces in the world. To first order, for a point p on a plane
  /// with normal n lit along d, all in the world, and the pose's left increment [w, v]:
  ///   shift = (I - d n^T / (n . d)) (w x p + v).
  double pose_error = 0;
};

class PROCAM_EXPORT Projection {
 public:
  /// Throws Error(kInput) for a projector that the rig does not have.
  Projection(const Rig& rig, ProjectionOptions options);
  ~Projection();
  Projection(Projection&&) noexcept;
  Projection& operator=(Projection&&) noexcept;

  ImageSize frame_size() const;
  const Projector& projector() const;

  /// Throws Error when the surfaces cannot be solved (surface/solve.hpp), and std::invalid_argument unless
  /// there is a content or null for each, Error(kInput) for a moving surface in projector pixels and for moving ones that are
  /// joined and in several frames; the show from before goes on then.
  void set_show(Show show);
  const Show& show() const;
  /// As they were last drawn.
  const SolvedSurfaceSet& solved() const;

  /// Another shape of a surface in the room that is drawn as triangles, with the same content: solved() has it, show() stays
  /// as it was given. A mesh without triangles is dark. false: there is no such surface.
  bool set_mesh(const std::string& surface, std::shared_ptr<const Mesh> mesh);

  /// The projector where it stands in the rig from now on: after a bump, say. The rig stays where it is in the world, and
  /// so do surfaces in the world and in the rig.
  void move_projector(const Pose& rig_from_projector);
  const Pose& rig_from_projector() const;

  void add(const track::StampedPose& message);
  const track::PoseTrack& track() const;
  /// Where the projector stands at a time; nullopt before the first pose.
  std::optional<Pose> projector_from_world(double time) const;

  /// rig_from_surface of a moving surface, the message's child being its name. Others count as foreign.
  void add_sighting(const track::StampedPose& message);
  /// In the order of MovingOptions::surfaces, those that the show has.
  const std::vector<MovingState>& moving() const;

  /// The surfaces of these names stay dark from the next draw() on. Their contents go on, so that they can be shown in any
  /// frame.
  void set_dark(std::vector<std::string> surfaces);
  /// Of the surface of this number in solved().
  SurfaceLight light(std::size_t surface) const;

  /// The content's picture on the surface of this number in the frame drawn last; nullopt: there was none, or a test pattern.
  /// Valid as long as the source's view is.
  std::optional<device::ContentFrame> picture_of(std::size_t surface) const;

  /// Draws over a frame again, for the light of another time (ProjectionOptions::over): of a picture that is
  /// held, a mask goes on. false: there is nothing to draw over it.
  bool draw_over(double light_time, ImageView<std::uint8_t> frame) const;

  /// All that is drawn from now on, test patterns and marks as well, is shown with this projector's share of the light, its
  /// black lifted as the map has it; what is drawn over frames (ProjectionOptions::over) comes after it. Null: as it is
  /// drawn. Black frames stay black. Throws std::invalid_argument for one of another size.
  void set_blend(std::shared_ptr<const surface::FrameBlend> blend);

  void set_picture(TestPattern picture);
  TestPattern picture() const;

  /// The surfaces as the projector sees them from where the last frame was drawn, with their visibility: solved
  /// anew, which is slow.
  SolvedSurfaceSet solve_again() const;

  /// Draws into a frame of frame_size() with 3 channels. A content that throws leaves its surface dark.
  DrawnFrame draw(double light_time, double content_time, ImageView<std::uint8_t> frame);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace procam::show
