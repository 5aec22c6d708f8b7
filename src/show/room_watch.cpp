#include "room_watch.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <limits>
#include <mutex>
#include <thread>

#include "depth_surfaces.hpp"
#include "procam/depth/room_depth.hpp"
#include "procam/device/frame_sink.hpp"
#include "rejected_counts.hpp"
#include "thread_share.hpp"

namespace procam::show {
namespace {

/// Where a plane's content lies in the world.
Points3 corners_of(const Surface& surface) {
  const auto& plane = std::get<PlanarSurface>(surface.geometry);
  Points3 corners;
  for (const Vec2& p : plane.points) corners.push_back(plane.frame_from_surface * Vec3(p.x(), p.y(), 0));
  return corners;
}

bool is_news(const SurfaceSet& told, const SurfaceSet& now, double distance) {
  if (told.surfaces.size() != now.surfaces.size()) return true;
  for (std::size_t i = 0; i < now.surfaces.size(); ++i) {
    if (told.surfaces[i].name != now.surfaces[i].name) return true;
    const Points3 before = corners_of(told.surfaces[i]), after = corners_of(now.surfaces[i]);
    for (std::size_t k = 0; k < after.size(); ++k)
      if ((after[k] - before[k]).norm() > distance) return true;
  }
  return false;
}

}  // namespace

DepthSurfaceTracker::DepthSurfaceTracker(const RoomOptions& options)
    : options_(options),
      lens_(options.camera.camera),
      rays_(lens_),
      map_(options.map),
      track_(options.track) {
  require(options.delay >= 0 && options.news_from >= 0,
          "DepthSurfaceTracker: delay and news_from must not be negative");
}

void DepthSurfaceTracker::add(const track::StampedPose& message) {
  track_.add(message);
}

double DepthSurfaceTracker::time_of(const device::SeenDepth& seen) {
  if (!seen.stamp_s || !std::isfinite(*seen.stamp_s)) return seen.time_s;
  if (clock_.observe(*seen.stamp_s, seen.time_s) == track::ClockVerdict::kDoubtful) return seen.time_s;
  return std::min(clock_.time(*seen.stamp_s), seen.time_s);
}

std::shared_ptr<const RoomSilhouettes> DepthSurfaceTracker::find(const depth::DepthImage& image,
                                                                 ViewF background,
                                                                 const Pose& world_from_camera,
                                                                 double time) const {
  ImageF metres;
  if (image.units.data) {
    metres = ImageF(image.size().width, image.size().height);
    for (int y = 0; y < metres.height(); ++y)
      for (int x = 0; x < metres.width(); ++x) metres.at(x, y) = image.at(x, y);
  }
  const people::SilhouetteInput view{lens_, image.units.data ? metres.view() : image.metres, background};
  return std::make_shared<const RoomSilhouettes>(
      RoomSilhouettes{people::find_silhouettes(view, *options_.silhouettes), world_from_camera, time});
}

void DepthSurfaceTracker::follow_lens(const Camera& lens) {
  if (lens.size == lens_.size && lens.distortion.index() == lens_.distortion.index() &&
      parameters_of(lens) == parameters_of(lens_))
    return;
  lens_ = lens;
  rays_ = depth::RayTable(lens_);
}

std::optional<SurfaceSet> DepthSurfaceTracker::look(const device::SeenDepth& seen) {
  const ImageSize size = size_of(seen.pixels);
  follow_lens(seen.camera.value_or(options_.camera.camera));
  if (size != rays_.size())
    throw Error(ErrorKind::kInput, "depth camera " + options_.camera.name,
                "its pictures have " + std::to_string(size.width) + "x" + std::to_string(size.height) +
                    " pixels, the rig file says " + std::to_string(rays_.size().width) + "x" +
                    std::to_string(rays_.size().height),
                "set its mode to that of the rig file, or name the right camera of the rig");
  const double time = time_of(seen) - options_.delay;
  if (looked_ > 0 && !(time > last_time_)) return std::nullopt;
  PoseWithCovariance world_from_rig;
  if (options_.world_from_rig) {
    world_from_rig.pose = *options_.world_from_rig;
  } else {
    const track::TrackedPose child = track_.at(time);
    if (child.state != track::TrackState::kFresh) {
      ++frames_without_pose_;
      return std::nullopt;
    }
    world_from_rig =
        compose({child.frame_from_child, child.covariance}, {options_.child_from_rig, Mat6::Zero()});
  }
  const PoseWithCovariance world_from_camera =
      compose(world_from_rig, {options_.camera.rig_from_camera, Mat6::Zero()});
  const depth::DepthImage image(seen.pixels, seen.metres_per_unit.value_or(options_.metres_per_unit));
  if (options_.shape)
    follow_shape(image, world_from_camera.pose, time);
  else
    map_.update(depth::find_planes(image, rays_, options_.planes), image, rays_, world_from_camera, time);
  last_time_ = time;
  ++looked_;
  if (options_.silhouettes) {
    const Pose& pose = world_from_camera.pose;
    depth::RoomDepthOptions room;
    room.within = options_.silhouettes->nearer;
    const ImageF background =
        shape_ ? shape_->field.background(image, rays_, shape_->world_from_reference.inverse() * pose)
               : depth::room_depth(map_, image, rays_, pose, room);
    silhouettes_ = find(image, background.view(), pose, time);
  }
  // A shape is reported once. Each frame asks for its heights (shape_at()).
  if (shape_ && !told_.surfaces.empty()) return std::nullopt;
  SurfaceSet now = surfaces();
  if (shape_ ? now.surfaces.empty() : !is_news(told_, now, options_.news_from)) return std::nullopt;
  told_ = now;
  return now;
}

void DepthSurfaceTracker::follow_shape(const depth::DepthImage& image, const Pose& world_from_camera,
                                       double time) {
  // Frames look at the last one meanwhile.
  std::shared_ptr<RoomShape> next;
  if (shape_) {
    next = std::make_shared<RoomShape>(*shape_);
  } else {
    const depth::ReferencePlane plane = depth::fit_reference_plane(image, rays_, options_.shape->region);
    constexpr double kMaxCells = 40000;  // of which a frame of the show can draw all
    depth::HeightFieldOptions field = options_.shape->field;
    field.cell = std::max(field.cell, std::sqrt(plane.size.x() * plane.size.y() / kMaxCells));
    next = std::make_shared<RoomShape>(
        RoomShape{depth::HeightField(plane.size, field), world_from_camera * plane.camera_from_reference});
  }
  next->field.update(image, rays_, next->world_from_reference.inverse() * world_from_camera, time);
  shape_ = std::move(next);
}

SurfaceSet DepthSurfaceTracker::surfaces() const {
  if (!options_.shape) return map_.surfaces();
  SurfaceSet set;
  if (!shape_) return set;
  MeshSurface shape;
  shape.frame = "world";
  shape.frame_from_surface = shape_->world_from_reference;
  shape.mesh = depth::mesh_of(shape_->field.at(last_time_));
  if (!shape.mesh->triangles.empty()) set.surfaces.push_back({kShapeName, shape, {}, ""});
  return set;
}

struct DepthSurfaceSource::State {
  State(Open how, const DepthSurfaceSourceOptions& what)
      : open(std::move(how)), options(what), view(what.room) {}

  Open open;
  DepthSurfaceSourceOptions options;
  std::unique_ptr<device::DepthSource> source;
  std::string description;  ///< of the first
  DepthSurfaceTracker view;
  std::mutex mutex;  ///< of the four below
  std::vector<track::StampedPose> poses;
  SurfaceUpdate news;
  std::shared_ptr<const RoomSilhouettes> silhouettes;
  std::shared_ptr<const RoomShape> shape;
  std::shared_ptr<ShownHeights> shown = std::make_shared<ShownHeights>();  ///< the show's thread's own
  RejectedCounts rejected;
  std::atomic<bool> ends{false};
  std::thread thread;

  // The thread's own.
  bool lost = false;
  double last_good = 0;
  std::string last_fault;

  void tell(std::optional<SurfaceSet> surfaces, const std::string& words = "") {
    const std::lock_guard<std::mutex> lock(mutex);
    if (surfaces) news.surfaces = std::move(surfaces);
    if (!words.empty()) news.words.push_back(words);
  }
  /// The same words once, however often it happens.
  void tell_fault(const std::string& words) {
    if (words != last_fault) tell(std::nullopt, words);
    last_fault = words;
  }
  void count_fault() {
    const std::lock_guard<std::mutex> lock(mutex);
    ++news.faults;
  }

  void run() {
    let_the_show_go_first();
    double after = 0;
    last_good = device::now_s();
    while (!ends) {
      try {
        if (!source) source = open();
        std::optional<device::SeenDepth> seen = source->next(after, 0.1);
        rejected.note(source->rejected());
        while (auto newer = seen && !ends ? source->next(seen->time_s, 0) : std::nullopt)
          seen = std::move(newer);
        if (seen) {
          after = seen->time_s;
          look(*seen);
        }
      } catch (const std::exception& error) {
        count_fault();
        tell_fault(error.what());
        if (source) rejected.note(source->rejected());
        source.reset();
        rejected.closed();
        for (int i = 0; i < 20 && !ends; ++i) {
          watch_for_loss();
          std::this_thread::sleep_for(std::chrono::milliseconds(50));
        }
      }
      watch_for_loss();
    }
  }

  void look(const device::SeenDepth& seen) {
    std::vector<track::StampedPose> arrived;
    {
      const std::lock_guard<std::mutex> lock(mutex);
      arrived.swap(poses);
    }
    for (const track::StampedPose& message : arrived) view.add(message);
    const int before = view.looked();
    std::optional<SurfaceSet> surfaces = view.look(seen);
    if (view.looked() == before) {
      if (view.frames_without_pose() > 0)
        tell_fault("depth pictures come without a fresh pose: they are passed over");
      return;
    }
    last_good = device::now_s();
    last_fault.clear();
    {
      const std::lock_guard<std::mutex> lock(mutex);
      silhouettes = view.silhouettes();
      shape = view.shape();
    }
    if (lost) {
      lost = false;
      tell(view.surfaces(), "the depth camera sees again");
    } else if (surfaces) {
      tell(std::move(surfaces));
    }
  }

  void watch_for_loss() {
    if (lost || device::now_s() - last_good < options.lost_after) return;
    lost = true;
    count_fault();
    if (options.blank_on_loss)
      tell(SurfaceSet{}, "the depth camera is silent: its surfaces are black until it sees again");
    else
      tell(std::nullopt, "the depth camera is silent: its surfaces stay where they are");
  }
};

DepthSurfaceSource::DepthSurfaceSource(Open open, const DepthSurfaceSourceOptions& options)
    : state_(std::make_unique<State>(std::move(open), options)) {
  require(options.lost_after > 0, "DepthSurfaceSource: lost_after must be positive");
  state_->source = state_->open();
  state_->description = state_->source->description();
  state_->thread = std::thread([state = state_.get()] { state->run(); });
}

DepthSurfaceSource::~DepthSurfaceSource() {
  state_->ends = true;
  state_->thread.join();
}

void DepthSurfaceSource::add(const track::StampedPose& message) {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  // Without pictures nobody fetches them: the newest are enough.
  constexpr std::size_t kMax = 4096;
  if (state_->poses.size() >= kMax)
    state_->poses.erase(state_->poses.begin(), state_->poses.begin() + std::ptrdiff_t(kMax / 2));
  state_->poses.push_back(message);
}

std::optional<SurfaceUpdate> DepthSurfaceSource::take() {
  const std::unique_lock<std::mutex> lock(state_->mutex, std::try_to_lock);
  const SurfaceUpdate& news = state_->news;
  if (!lock || (!news.surfaces && news.words.empty() && news.faults == 0)) return std::nullopt;
  return std::exchange(state_->news, {});
}

std::shared_ptr<const Mesh> DepthSurfaceSource::shape_at(double light_time) {
  std::shared_ptr<const RoomShape> newest;
  {
    const std::lock_guard<std::mutex> lock(state_->mutex);
    newest = state_->shape;
  }
  if (!newest) return nullptr;
  state_->shown->map = newest->field.at(light_time);
  return depth::mesh_of(state_->shown->map);
}

std::shared_ptr<device::ContentSource> DepthSurfaceSource::content(const std::string& text) const {
  if (!is_height_content(text) || state_->shown->map.height.empty()) return nullptr;
  return height_content(text, state_->shown);
}

std::string DepthSurfaceSource::description() const {
  return state_->description;
}

std::map<std::string, std::uint64_t> DepthSurfaceSource::rejected() const {
  return state_->rejected.counts();
}

people::MaskResult DepthSurfaceSource::darken(ImageView<std::uint8_t> frame, const Projection& projection,
                                              double light_time) const {
  std::shared_ptr<const RoomSilhouettes> newest;
  {
    const std::lock_guard<std::mutex> lock(state_->mutex);
    newest = state_->silhouettes;
  }
  return darken_before_room(frame, projection, light_time, newest.get(),
                            state_->options.room.silhouettes.value_or(people::SilhouetteOptions{}));
}

people::MaskResult darken_before_room(ImageView<std::uint8_t> frame, const Projection& projection,
                                      double light_time, const RoomSilhouettes* seen,
                                      const people::SilhouetteOptions& options) {
  // A place that is not finite darkens all, and so does an age that is none.
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  Pose projector_from_camera(Eigen::Quaterniond::Identity(), Vec3::Constant(kUnknown));
  const auto projector_from_world = projection.projector_from_world(light_time);
  if (seen != nullptr && projector_from_world)
    projector_from_camera = *projector_from_world * seen->world_from_camera;
  static const people::Silhouettes nobody;
  return people::darken_silhouettes(frame, projection.projector(), projector_from_camera,
                                    seen != nullptr ? seen->in_camera : nobody,
                                    seen != nullptr ? light_time - seen->time : kUnknown, options);
}

}  // namespace procam::show
