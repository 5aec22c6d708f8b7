#pragma once
/// A depth camera on the rig, as the source of the surfaces: what it sees becomes named planes that keep
/// their names and places while the robot drives and people pass (depth/plane_map.hpp).
///
///   DepthSurfaceSource watch([&] { return device::open_depth("watch:depth"); }, options);
///   watch.add(message);                       // as poses come
///   if (auto news = watch.take()) ...         // surfaces to show from now on, sentences for people
///
/// A picture that arrived at t shows the room of t - delay (of one that its sensor stamped, t is freed of the
/// jitter on its way: track/clock.hpp), seen from
///   world_from_camera = world_from_child(t - delay) * child_from_rig * rig_from_camera.
///
/// A lens that the camera states with its pictures (SeenDepth::camera) counts more than that of the rig file: it belongs to
/// pictures that were cropped, binned or rectified on the way.
///
/// All work is done on a thread of its own, at the camera's pace; where that is faster, pictures are passed
/// over. A camera that is gone is opened again every second.
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "height_content.hpp"
#include "procam/core/rig/rig.hpp"
#include "procam/depth/height_field.hpp"
#include "procam/depth/plane_map.hpp"
#include "procam/device/depth_source.hpp"
#include "procam/people/silhouette.hpp"
#include "procam/show/projection.hpp"
#include "procam/track/pose_track.hpp"

namespace procam::show {

/// One surface of any shape instead of planes: "shape" (depth/height_field.hpp).
struct ShapeOptions {
  std::optional<depth::PixelRegion> region;  ///< of the depth camera; none: its middle
  depth::HeightFieldOptions field;
};

/// A shape after one image, to be looked at for the time of a light.
struct RoomShape {
  depth::HeightField field;
  Pose world_from_reference;
};

inline constexpr const char* kShapeName = "shape";

/// Hands over a shape come nearer to it than people to a wall, are smaller, and their light matters less than the sand's
/// around them.
inline people::SilhouetteOptions shape_silhouettes() {
  people::SilhouetteOptions options;
  options.nearer = 0.06;
  options.margin = 0.03;
  options.speed = 1;
  return options;
}

struct RoomOptions {
  RigCamera camera;                ///< the depth camera
  double metres_per_unit = 0.001;  ///< where the sensor does not state it
  double delay = 0;                ///< from a picture's exposure to its arrival, seconds
  /// A rig that stands still: no poses are awaited.
  std::optional<Pose> world_from_rig;
  Pose child_from_rig;        ///< the rig's place on what the poses tell of
  track::TrackOptions track;  ///< as of the projection
  depth::PlaneOptions planes;
  depth::PlaneMapOptions map;
  /// A corner of some content moved by more than this, metres: told. Less changes no pixel, and every change
  /// is work for the loop.
  double news_from = 2e-4;
  /// Objects in front of the room are reported (DepthSurfaceTracker::silhouettes()), to be masked.
  std::optional<people::SilhouetteOptions> silhouettes;
  std::optional<ShapeOptions> shape;
};

/// What came before the room at a time, as the depth camera then stood.
struct RoomSilhouettes {
  people::Silhouettes in_camera;
  Pose world_from_camera;
  double time = 0;  ///< of the exposure, local clock
};

/// Blackens whatever came before the room, for the light of a time: through the room, so that it holds while
/// the robot turns. All of the frame for silhouettes that are null or old, and while where the rig stands is
/// not known (people/silhouette.hpp).
people::MaskResult darken_before_room(ImageView<std::uint8_t> frame, const Projection& projection,
                                      double light_time, const RoomSilhouettes* seen,
                                      const people::SilhouetteOptions& options = {});

/// The part without clock and thread: the same calls in the same order give the same surfaces.
class DepthSurfaceTracker {
 public:
  /// Throws std::invalid_argument for a camera without pixels or options out of range.
  explicit DepthSurfaceTracker(const RoomOptions& options);

  void add(const track::StampedPose& message);
  /// The surfaces of the world, when they are not as they were told last; nullopt also where no fresh pose is
  /// known for the picture, which is passed over then. Throws Error(kInput) for a picture of another size
  /// than the camera's.
  std::optional<SurfaceSet> look(const device::SeenDepth& seen);

  /// Of the last picture that the map took; null unless asked for, and before there is one.
  const std::shared_ptr<const RoomSilhouettes>& silhouettes() const { return silhouettes_; }

  const depth::PlaneMap& map() const { return map_; }
  /// All that is known, whether told before or not.
  SurfaceSet surfaces() const;
  /// As of the last image; null without RoomOptions::shape, and before there is one.
  const std::shared_ptr<const RoomShape>& shape() const { return shape_; }
  int looked() const { return looked_; }                            ///< pictures that the map took
  int frames_without_pose() const { return frames_without_pose_; }  ///< skipped without a pose

 private:
  double time_of(const device::SeenDepth& seen);
  void follow_lens(const Camera& lens);
  std::shared_ptr<const RoomSilhouettes> find(const depth::DepthImage& image, ViewF background,
                                              const Pose& world_from_camera, double time) const;
  void follow_shape(const depth::DepthImage& image, const Pose& world_from_camera, double time);

  RoomOptions options_;
  Camera lens_;  ///< the one that the pictures state, or the rig's
  depth::RayTable rays_;
  depth::PlaneMap map_;
  track::PoseTrack track_;
  track::Clock clock_;  ///< of a sensor that stamps its pictures
  double last_time_ = 0;
  int looked_ = 0, frames_without_pose_ = 0;
  SurfaceSet told_;
  std::shared_ptr<const RoomSilhouettes> silhouettes_;
  std::shared_ptr<const RoomShape> shape_;
};

struct DepthSurfaceSourceOptions {
  RoomOptions room;
  double lost_after = 0.5;     ///< seconds without a picture that could be placed
  bool blank_on_loss = false;  ///< no surfaces then; else they stay where they are
};

struct SurfaceUpdate {
  std::optional<SurfaceSet> surfaces;  ///< frame "world", without contents
  std::vector<std::string> words;      ///< what people should know
  /// Since the last update: images that cannot be used, failed attempts to open the camera, and its losses.
  std::uint64_t faults = 0;
};

class DepthSurfaceSource {
 public:
  using Open = std::function<std::unique_ptr<device::DepthSource>()>;
  /// Opens the camera at once and throws what that throws; later faults are reported, and it continues.
  DepthSurfaceSource(Open open, const DepthSurfaceSourceOptions& options);
  ~DepthSurfaceSource();
  DepthSurfaceSource(const DepthSurfaceSource&) = delete;
  DepthSurfaceSource& operator=(const DepthSurfaceSource&) = delete;

  void add(const track::StampedPose& message);
  /// What is new, if anything; never waits.
  std::optional<SurfaceUpdate> take();
  /// The shape at the time of a light, in the frame of its surface; null where there is none. Its contents show the heights
  /// of then, from now on.
  std::shared_ptr<const Mesh> shape_at(double light_time);
  /// Content made from these heights (height_content.hpp); null for any other, and before shape_at() has given a shape.
  std::shared_ptr<device::ContentSource> content(const std::string& text) const;
  /// Messages of its camera that were dropped, by cause.
  std::map<std::string, std::uint64_t> rejected() const;
  /// Of its camera.
  std::string description() const;
  /// darken_before_room() by the newest depth.
  people::MaskResult darken(ImageView<std::uint8_t> frame, const Projection& projection,
                            double light_time) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace procam::show
