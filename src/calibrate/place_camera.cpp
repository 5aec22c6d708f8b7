#include "place_camera.hpp"

#include <algorithm>
#include <cmath>

#include "initial.hpp"
#include "joined.hpp"
#include "procam/core/base/stats.hpp"
#include "procam/core/base/words.hpp"
#include "procam/core/geometry/homography_fit.hpp"
#include "procam/core/geometry/planar_pose.hpp"

namespace procam::calibrate {
namespace {

constexpr std::size_t kMinViews = 3;
constexpr const char* kOtherOrder = "its points are not in the board's order";

/// Correspondences of one device alone.
Correspondences only_device(const Correspondences& data, std::size_t device) {
  Correspondences only{data.board, {data.devices[device]}, {}, {}};
  for (const View& view : data.views) only.views.push_back({view.name, {view.observations[device]}});
  return only;
}

std::size_t poses_in(const CameraAlone& alone) {
  return std::size_t(std::count_if(alone.camera_from_board.begin(), alone.camera_from_board.end(),
                                   [](const auto& pose) { return pose.has_value(); }));
}

void require_views(const CameraAlone& alone, const Correspondences& data, std::size_t camera) {
  const std::size_t usable = poses_in(alone);
  if (usable >= kMinViews) return;
  std::string why = std::to_string(usable) + " of " + std::to_string(data.views.size()) +
                    " views are usable, " + std::to_string(kMinViews) + " are needed";
  for (std::size_t v = 0; v < data.views.size(); ++v)
    if (!alone.camera_from_board[v]) why += "; " + data.views[v].name + " rejected: " + alone.why[v];
  throw Error(
      ErrorKind::kNotEnoughData, camera == 0 ? "calibration" : data.devices[camera].name, why,
      why.find(kOtherOrder) != std::string::npos
          ? "number the points row by row from the board's first corner, from 0, and check the board's counts"
          : "capture at least three (better eight) views with the board tilted and at other distances");
}

/// Boards that all stand alike leave the focal length open, and the solver wandering.
void require_tilted(const CameraAlone& alone, const std::string& camera) {
  constexpr double kMinTilt = 6 * kDegree;
  std::vector<Vec3> normals;
  for (const auto& pose : alone.camera_from_board)
    if (pose) normals.push_back(pose->rotate(Vec3::UnitZ()));
  double widest = 0;
  for (const Vec3& a : normals)
    for (const Vec3& b : normals) widest = std::max(widest, std::acos(std::clamp(a.dot(b), -1.0, 1.0)));
  if (widest < kMinTilt)
    throw Error(ErrorKind::kDegenerate, camera,
                "the boards are all parallel to each other, which leaves the focal length open",
                "capture views with the board tilted 20 to 40 degrees, about both axes");
}

/// The homography's residual over the spread of the pixels about their mean, both RMS. Of a board in order it is below 0.18, also
/// through a fisheye of 120 degrees; with all points numbered one too far, or by columns instead of rows, above 0.6.
double misfit(const Homography& pixel_from_board, const Points2& points, const Points2& pixels) {
  Vec2 mean = Vec2::Zero();
  for (const Vec2& pixel : pixels) mean += pixel / double(pixels.size());
  double residual = 0, spread = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3 image = pixel_from_board.matrix() * points[i].homogeneous();
    residual += (image.hnormalized() - pixels[i]).squaredNorm();
    spread += (pixels[i] - mean).squaredNorm();
  }
  return std::sqrt(residual / spread);
}

/// Above it the points are not in the board's order.
constexpr double kMaxMisfit = 0.3;

/// Why no focal length follows from the views' homographies: boards parallel to the image, unless the images are smaller than
/// stated, or many points are wrong.
[[noreturn]] void fail_without_focal_length(const Correspondences& data, std::size_t camera,
                                            const std::vector<double>& misfits) {
  const Device& device = data.devices[camera];
  Vec2 last = Vec2::Zero();
  for (const View& view : data.views)
    for (const Observation& o : view.observations[camera]) last = last.cwiseMax(o.pixel);
  constexpr double kPart = 0.6, kManyWrong = 0.04;
  if (last.x() < kPart * device.size.width && last.y() < kPart * device.size.height)
    throw Error(
        ErrorKind::kDegenerate, device.name,
        format(
            "all of its points lie in the first %.0f x %.0f of %d x %d pixels, and no focal length explains them",
            last.x() + 1, last.y() + 1, device.size.width, device.size.height),
        "give the size of its images; if it is right, move the board to the image's other parts, tilted 20 to 40 degrees");
  if (median(misfits) > kManyWrong)
    throw Error(
        ErrorKind::kDegenerate, device.name,
        format("its points are %.0f %% of a board's extent off their board (RMS, median of the views)",
               100 * median(misfits)),
        "many of them are wrong: check how they were found, their order, and that u runs to the right and v downwards");
  throw Error(ErrorKind::kDegenerate, device.name,
              "the boards are all parallel to the image, which leaves the focal length open",
              "capture views with the board tilted 20 to 40 degrees, about both axes");
}

Camera zhang_lens(const Correspondences& data, const Points3& board, std::size_t camera,
                  const Options& options, CameraAlone& alone) {
  std::vector<Mat3> homographies;
  std::vector<double> misfits;
  for (std::size_t v = 0; v < data.views.size(); ++v) {
    if (!alone.camera_from_board[v]) continue;
    Points2 points, pixels;
    for (const Observation& o : data.views[v].observations[camera]) {
      points.push_back(board[std::size_t(o.point)].head<2>());
      pixels.push_back(o.pixel);
    }
    try {
      const Homography pixel_from_board = fit_homography(points, pixels).destination_from_source;
      if (const double off = misfit(pixel_from_board, points, pixels); off < kMaxMisfit) {
        misfits.push_back(off);
        homographies.push_back(pixel_from_board.matrix());
        continue;
      }
      alone.camera_from_board[v].reset();
      alone.why[v] = kOtherOrder;
    } catch (const Error& error) {
      alone.camera_from_board[v].reset();
      alone.why[v] = error.what();
    }
  }
  require_views(alone, data, camera);
  const Device& device = data.devices[camera];
  const auto intrinsics = initial_camera_intrinsics(homographies, device.size);
  if (!intrinsics) fail_without_focal_length(data, camera, misfits);
  return Camera{device.size, *intrinsics, options.camera.model};
}

/// The same sheet with its points numbered from the other end: p -> first + last - p in the plane.
Pose turned_board(const Points3& board) {
  return Pose(Eigen::Quaterniond(0, 0, 0, 1), board.front() + board.back());
}

double rms_at(const Camera& lens, const Pose& camera_from_board, const Points3& board,
              const std::vector<Observation>& observations) {
  double sum = 0;
  for (const Observation& o : observations) {
    const auto pixel = lens.project(camera_from_board * board[std::size_t(o.point)]);
    if (!pixel) return 1e300;
    sum += (*pixel - o.pixel).squaredNorm();
  }
  return std::sqrt(sum / double(observations.size()));
}

/// A shared view is far off when a place misses it this many times as far as its median view, and by more
/// than a few pixels: the pose of one board is no more accurate.
constexpr double kFarOffPlace = 3, kFewPixelsOff = 5;

}  // namespace

std::optional<Pose> board_pose(const Camera& lens, const Points3& board,
                               const std::vector<Observation>& observations) {
  Points2 points, normalized;
  for (const Observation& o : observations) {
    const auto bearing = lens.unproject(o.pixel);
    if (!bearing || bearing->z() <= 0) continue;
    points.push_back(board[std::size_t(o.point)].head<2>());
    normalized.push_back(bearing->hnormalized());
  }
  if (points.size() < 4) return std::nullopt;
  try {
    return planar_pose(points, normalized).best().camera_from_plane;
  } catch (const Error&) {
    return std::nullopt;
  }
}

CameraAlone calibrate_alone(const Correspondences& data, std::size_t camera,
                            const std::optional<Camera>& known, const Options& options) {
  const Points3 board = points_in_board(data.board);
  const Device& device = data.devices[camera];
  CameraAlone alone;
  alone.why.resize(data.views.size());
  for (std::size_t v = 0; v < data.views.size(); ++v) {
    const auto count = data.views[v].observations[camera].size();
    alone.camera_from_board.emplace_back();
    if (int(count) >= kMinPointsPerView)
      alone.camera_from_board.back() = Pose();  // to be found
    else
      alone.why[v] = device.name + " sees " + std::to_string(count) + " of the board's points";
  }
  require_views(alone, data, camera);
  alone.lens = known ? *known : zhang_lens(data, board, camera, options, alone);
  for (std::size_t v = 0; v < data.views.size(); ++v) {
    if (!alone.camera_from_board[v]) continue;
    alone.camera_from_board[v] = board_pose(alone.lens, board, data.views[v].observations[camera]);
    if (!alone.camera_from_board[v]) alone.why[v] = "no pose of the board explains its corners";
  }
  require_views(alone, data, camera);

  // Its own noise is small, and its poses carry everything that follows.
  const Correspondences only = only_device(data, camera);
  BundleState state{{alone.lens}, {Pose()}, std::vector<Pose>(data.views.size()), board};
  UsedMask used = use_all(only);
  for (std::size_t v = 0; v < data.views.size(); ++v) {
    if (alone.camera_from_board[v])
      state.rig_from_board[v] = *alone.camera_from_board[v];
    else
      std::fill(used[v][0].begin(), used[v][0].end(), char(0));
  }
  BundleOptions roughly;
  roughly.held = {known ? parameter_names(*known) : options.camera.held};
  roughly.priors = {options.camera.priors};
  roughly.noise.resize(1);
  roughly.hold_pose = {true};
  roughly.tolerance = 1e-5;
  state = bundle_adjust(only, used, state, roughly).state;
  alone.lens = state.lenses[0];
  for (std::size_t v = 0; v < data.views.size(); ++v)
    if (alone.camera_from_board[v]) alone.camera_from_board[v] = state.rig_from_board[v];
  if (!known) require_tilted(alone, device.name);
  return alone;
}

std::optional<CameraPlace> place_camera(const Correspondences& data, std::size_t camera,
                                        const CameraAlone& alone,
                                        const std::vector<std::optional<Pose>>& rig_from_board) {
  const Points3 board = points_in_board(data.board);
  const bool may_turn = is_symmetric_180(data.board);
  const Pose turn = turned_board(board);
  std::vector<std::size_t> shared;
  std::vector<Pose> candidates;
  for (std::size_t v = 0; v < rig_from_board.size(); ++v) {
    if (!alone.camera_from_board[v] || !rig_from_board[v]) continue;
    shared.push_back(v);
    candidates.push_back(*alone.camera_from_board[v] * rig_from_board[v]->inverse());
  }
  if (shared.empty()) return std::nullopt;
  // One shared view cannot tell a turned order; the one given is as good as the other.
  for (std::size_t i = 0; may_turn && shared.size() > 1 && i < shared.size(); ++i)
    candidates.push_back(*alone.camera_from_board[shared[i]] * turn * rig_from_board[shared[i]]->inverse());

  struct Fit {
    double rms = 1e300;
    bool turned = false;
  };
  CameraPlace best;
  double least = 1e301;
  for (const Pose& camera_from_rig : candidates) {
    std::vector<Fit> fits;
    std::vector<double> sorted;
    for (const std::size_t v : shared) {
      const Pose camera_from_board = camera_from_rig * *rig_from_board[v];
      const auto& seen = data.views[v].observations[camera];
      Fit fit{rms_at(alone.lens, camera_from_board, board, seen), false};
      if (may_turn && shared.size() > 1)
        if (const double rms = rms_at(alone.lens, camera_from_board * turn, board, seen); rms < fit.rms)
          fit = {rms, true};
      fits.push_back(fit);
      sorted.push_back(fit.rms);
    }
    const double typical = at_rank(sorted, sorted.size() / 2);
    if (!(typical < least)) continue;
    least = typical;
    best = {camera_from_rig, {}, {}};
    for (std::size_t i = 0; i < shared.size(); ++i) {
      if (fits[i].rms <= std::max(kFarOffPlace * least, kFewPixelsOff)) best.agreeing.push_back(shared[i]);
      if (fits[i].turned) best.turned.push_back(shared[i]);
    }
  }
  return best;
}

}  // namespace procam::calibrate
