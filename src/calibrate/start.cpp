#include "start.hpp"

#include <algorithm>

#include "joined.hpp"
#include "place_camera.hpp"
#include "prior_terms.hpp"
#include "resect_views.hpp"
#include "residual_blocks.hpp"

namespace procam::calibrate {
namespace {

constexpr std::size_t kMinLitViews = 3;

/// Everything while the rig grows, device by device.
struct Growing {
  Correspondences& data;
  const Options& options;
  const Points3 board;
  Start start;
  std::vector<std::optional<CameraAlone>> alone;         ///< by device; of cameras
  std::vector<std::optional<Pose>> rig_from_board = {};  ///< by view: those posed so far
  std::vector<bool> placed = {};                         ///< by device

  bool is_camera(std::size_t d) const { return data.devices[d].kind == DeviceKind::kCamera; }
};

std::vector<Lit> lit_points(const Growing& rig, std::size_t device) {
  const BundleState& state = rig.start.state;
  std::vector<Lit> lit;
  for (std::size_t v = 0; v < rig.data.views.size(); ++v) {
    if (!rig.rig_from_board[v]) continue;
    const Pose& rig_from_board = *rig.rig_from_board[v];
    Lit one;
    one.view = v;
    for (const Observation& o : rig.data.views[v].observations[device]) {
      one.as_given.push_back(rig_from_board * rig.board[std::size_t(o.point)]);
      one.turned.push_back(rig_from_board * rig.board[rig.board.size() - 1 - std::size_t(o.point)]);
      one.pixels.push_back(o.pixel);
    }
    for (const LightPoint& light : rig.data.views[v].light_points) {
      if (light.projector != int(device) || !rig.placed[std::size_t(light.camera)]) continue;
      const auto place = place_in_rig(state, int(v), light);
      if (!place) continue;
      one.as_given.push_back(*place);
      one.turned.push_back(*place);
      one.pixels.push_back(light.projector_pixel);
    }
    if (int(one.pixels.size()) >= kMinPointsPerView) lit.push_back(std::move(one));
  }
  return lit;
}

void begin_without(Start& start, std::size_t view, std::size_t device) {
  std::fill(start.first[view][device].begin(), start.first[view][device].end(), char(0));
}

/// Numbers a view's points of one device from the other end; a camera's carries along what it read.
void turn_order(Growing& rig, std::size_t view, std::size_t device) {
  View& of = rig.data.views[view];
  const auto turn = [&](Observation& o) { o.point = int(rig.board.size()) - 1 - o.point; };
  for (Observation& o : of.observations[device]) turn(o);
  for (std::size_t d = 0; rig.is_camera(device) && d < rig.data.devices.size(); ++d)
    for (Observation& o : of.observations[d])
      if (!rig.is_camera(d) && o.camera == int(device)) turn(o);
  std::string& note = rig.start.notes[view];
  note += (note.empty() ? "" : "; ") + ("order of " + rig.data.devices[device].name) +
          "'s corners turned by 180 degrees";
  rig.start.diagnostics.note("order_turned", "view " + of.name + ": " + note + ", as its residual asked");
}

/// The device has its pose: it sets the poses of views without one.
void place(Growing& rig, std::size_t device, const Camera& lens, const Pose& device_from_rig) {
  rig.placed[device] = true;
  BundleState& state = rig.start.state;
  state.lenses[device] = lens;
  state.device_from_rig[device] = device_from_rig;
  for (std::size_t v = 0; v < rig.data.views.size(); ++v) {
    if (rig.rig_from_board[v]) continue;
    const auto& observations = rig.data.views[v].observations[device];
    std::optional<Pose> pose;
    if (rig.is_camera(device))
      pose = rig.alone[device]->camera_from_board[v];
    else if (int(observations.size()) >= kMinPointsPerView)
      pose = board_pose(lens, rig.board, observations);
    if (!pose) continue;
    rig.rig_from_board[v] = state.rig_from_board[v] = device_from_rig.inverse() * *pose;
  }
}

/// All cameras that stand, together: one board's pose tells a place by some pixels only, and the chain goes
/// on from here.
void settle_cameras(Growing& rig) {
  Start& start = rig.start;
  UsedMask used = start.first;
  for (std::size_t v = 0; v < rig.data.views.size(); ++v)
    for (std::size_t d = 0; d < rig.data.devices.size(); ++d)
      if (!rig.placed[d] || !rig.is_camera(d) || !rig.rig_from_board[v])
        std::fill(used[v][d].begin(), used[v][d].end(), char(0));
  BundleOptions roughly = start.bundle_options;
  roughly.tolerance = 1e-5;
  start.state = bundle_adjust(rig.data, used, start.state, roughly).state;
  for (std::size_t v = 0; v < rig.data.views.size(); ++v)
    if (rig.rig_from_board[v]) rig.rig_from_board[v] = start.state.rig_from_board[v];
}

void add_camera(Growing& rig, std::size_t d) {
  const CameraPlace found = *place_camera(rig.data, d, *rig.alone[d], rig.rig_from_board);
  for (std::size_t v = 0; v < rig.data.views.size(); ++v) {
    const bool shared = rig.rig_from_board[v] && rig.alone[d]->camera_from_board[v];
    if (shared && std::count(found.agreeing.begin(), found.agreeing.end(), v) == 0)
      begin_without(rig.start, v, d);
  }
  for (const std::size_t v : found.turned) turn_order(rig, v, d);
  if (found.agreeing.size() < 2)
    rig.start.diagnostics.warn(
        "joined_by_one_view",
        "one view alone joins " + rig.data.devices[d].name +
            " to the rest: an error in it would go unseen; capture more views that both see");
  place(rig, d, rig.alone[d]->lens, found.camera_from_rig);
  settle_cameras(rig);
}

void add_projector(Growing& rig, std::size_t d, const std::vector<Lit>& lit) {
  const Device& device = rig.data.devices[d];
  std::vector<bool> turned;
  const auto [resection, agreeing] =
      resect_device(lit, is_symmetric_180(rig.data.board), device.name, turned);
  for (std::size_t i = 0; i < lit.size(); ++i) {
    if (std::count(agreeing.begin(), agreeing.end(), i) == 0) begin_without(rig.start, lit[i].view, d);
    if (turned[i]) turn_order(rig, lit[i].view, d);
  }
  Camera lens{device.size, resection.intrinsics, rig.options.projector.model};
  const auto& held = rig.options.projector.held;
  if (std::count(held.begin(), held.end(), "skew") > 0) lens.intrinsics.skew = 0;
  place(rig, d, lens, resection.device_from_points);
}

/// The camera that shares most views with those that stand; without one, the projector. False when all stand
/// or none can be added.
bool add_next(Growing& rig) {
  const std::size_t num_devices = rig.data.devices.size();
  std::size_t most = 0, next = num_devices;
  for (std::size_t d = 0; d < num_devices; ++d) {
    if (rig.placed[d] || !rig.is_camera(d)) continue;
    std::size_t shared = 0;
    for (std::size_t v = 0; v < rig.data.views.size(); ++v)
      shared += rig.rig_from_board[v] && rig.alone[d]->camera_from_board[v];
    if (shared > most) most = shared, next = d;
  }
  if (next < num_devices) return add_camera(rig, next), true;

  std::vector<Lit> lit;
  for (std::size_t d = 0; d < num_devices; ++d) {
    if (rig.placed[d] || rig.is_camera(d)) continue;
    std::vector<Lit> of_device = lit_points(rig, d);
    if (of_device.size() > lit.size()) lit = std::move(of_device), next = d;
  }
  if (lit.size() < kMinLitViews) return false;
  add_projector(rig, next, lit);
  return true;
}

/// Views of which only the camera's corners are used, and the remark of the first of them, which names the cause; empty
/// without any.
std::string rejected_views(const Diagnostics& remarks) {
  int count = 0;
  std::string cause;
  for (std::size_t i = 0; i < remarks.items.size(); ++i) {
    if (remarks.items[i].code != "projector_rejected") continue;
    if (++count == 1 && i > 0) cause = remarks.items[i - 1].message;
  }
  if (count == 0) return "";
  return "; the frames of " + std::to_string(count) + (count == 1 ? " view do" : " views do") +
         " not belong together" + (cause.empty() ? "" : ": " + cause);
}

void require_all_placed(const Growing& rig) {
  for (std::size_t d = 0; d < rig.data.devices.size(); ++d) {
    if (rig.placed[d]) continue;
    const std::string rejected = rejected_views(rig.data.diagnostics);
    throw Error(
        ErrorKind::kNotEnoughData, rig.data.devices[d].name,
        std::to_string(lit_points(rig, d).size()) + " views have at least " +
            std::to_string(kMinPointsPerView) + " of the board's points for it, " +
            std::to_string(kMinLitViews) + " are needed" + rejected,
        rejected.empty()
            ? "see the warnings of its views; without any, place the board inside the projector's light, and "
              "check that its size and the order of frames are right"
            : "see the warnings of its views, and capture them again: fix board and camera until the last frame "
              "is captured, and wait for each frame");
  }
}

/// A wrong point may put a board's first pose where a ray misses the board. Points that cannot be projected there
/// wait for the solution of the others, which judges them again.
void begin_without_unprojectable(const Correspondences& data, Start& start) {
  for (std::size_t d = 0; d < data.devices.size(); ++d) {
    std::size_t views = 0;
    std::string without;
    for (std::size_t v = 0; v < data.views.size(); ++v) {
      int begun = 0, dropped = 0;
      for (const Measurement& m : measurements_of(data, int(v), int(d))) {
        char& used = start.first[v][d][std::size_t(m.index)];
        if (!used) continue;
        used = judged_residual(start.state, m).has_value();
        ++(used ? begun : dropped);
      }
      views += begun >= kMinPointsPerView;
      if (dropped == 0) continue;
      without += (without.empty() ? "" : ", ") + data.views[v].name + " (" + std::to_string(dropped) +
                 " of " + std::to_string(begun + dropped) + ")";
    }
    if (without.empty() || views >= kMinLitViews) continue;
    throw Error(
        ErrorKind::kDegenerate, data.devices[d].name,
        "its points miss the board, whose first pose follows from the camera's corners, in " + without,
        "look at the board's corners in these views: with few of them, or in another order, the pose is "
        "wrong; light the board evenly, below full scale, and check that board and image sizes are "
        "those of the session");
  }
}

/// Why no device poses the view.
std::string rejection_reason(const Growing& rig, std::size_t view) {
  std::string why;
  for (const auto& alone : rig.alone)
    if (alone) why += (why.empty() ? "" : ", ") + alone->why[view];
  return "rejected: " + why;
}

Growing begin(Correspondences& data, const Options& options) {
  Growing rig{data, options, points_in_board(data.board), {}, {}};
  const std::size_t num_devices = data.devices.size(), num_views = data.views.size();
  rig.alone.resize(num_devices);
  rig.placed.assign(num_devices, false);
  rig.rig_from_board.resize(num_views);
  Start& start = rig.start;
  start.used = start.first = use_all(data);
  start.view_used.assign(num_views, true);
  start.notes.assign(num_views, "");
  start.state.lenses.resize(num_devices);
  start.state.device_from_rig.resize(num_devices);
  start.state.rig_from_board.resize(num_views);
  start.state.points_in_board = rig.board;
  start.state.sheet = flat_sheet(rig.board);
  start.bundle_options.noise.resize(num_devices);
  start.bundle_options.hold_pose.assign(num_devices, false);
  for (const Device& device : data.devices) {
    const LensOptions& lens = device.kind == DeviceKind::kCamera ? options.camera : options.projector;
    start.bundle_options.held.push_back(lens.held);
    start.bundle_options.priors.push_back(lens.priors);
  }
  return rig;
}

/// What its covariance does not name is held; the rest stays within it.
void know_first_camera(const KnownLens& known, BundleOptions& options) {
  options.held[0] = parameter_names(known.lens);
  if (known.covariance.empty()) return;
  const auto is_open = [&](const std::string& name) { return known.covariance.index_of(name).has_value(); };
  auto& held = options.held[0];
  held.erase(std::remove_if(held.begin(), held.end(), is_open), held.end());
  options.priors[0] = known_lens_priors(known);
}

}  // namespace

Start find_start(Correspondences& data, const std::optional<KnownLens>& known_camera,
                 const Options& options) {
  Growing rig = begin(data, options);
  for (std::size_t d = 0; d < data.devices.size(); ++d)
    if (rig.is_camera(d))
      rig.alone[d] = calibrate_alone(
          data, d, d == 0 && known_camera ? std::optional(known_camera->lens) : std::nullopt, options);
  if (known_camera) know_first_camera(*known_camera, rig.start.bundle_options);
  require_joined(data, rig.start.used);
  place(rig, 0, rig.alone[0]->lens, Pose());
  while (add_next(rig)) continue;
  require_all_placed(rig);

  Start& start = rig.start;
  for (std::size_t v = 0; v < data.views.size(); ++v) {
    if (rig.rig_from_board[v]) continue;
    start.view_used[v] = false;
    start.notes[v] = rejection_reason(rig, v);
    for (UsedMask* mask : {&start.used, &start.first})
      for (auto& of_device : (*mask)[v]) std::fill(of_device.begin(), of_device.end(), char(0));
  }
  begin_without_unprojectable(data, start);
  return std::move(start);
}

}  // namespace procam::calibrate
