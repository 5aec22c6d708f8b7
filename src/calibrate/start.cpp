#include "start.hpp"

#include <algorithm>
#include <cmath>

#include "procam/calibrate/initial.hpp"
#include "procam/core/homography_fit.hpp"
#include "procam/core/planar_pose.hpp"
#include "residual_blocks.hpp"

namespace procam::calibrate {
namespace {

constexpr int kMinPointsPerView = 6;  ///< four fix a homography; two more let it be checked
constexpr std::size_t kMinViews = 3;

/// Board points (metres on z = 0) and their pixels, of one device in one view.
struct Pairs {
  Points2 points;
  Points2 pixels;
};

Pairs pairs_of(const Correspondences& data, const Points3& board, std::size_t view, std::size_t device) {
  Pairs pairs;
  for (const Observation& o : data.views[view].observations[device]) {
    pairs.points.push_back(board[std::size_t(o.point)].head<2>());
    pairs.pixels.push_back(o.pixel);
  }
  return pairs;
}

/// The board's pose before the camera from its known lens; nullopt when no pose explains the pixels.
std::optional<Pose> board_pose(const Camera& lens, const Pairs& pairs) {
  Points2 points, normalized;
  for (std::size_t i = 0; i < pairs.points.size(); ++i) {
    const auto bearing = lens.unproject(pairs.pixels[i]);
    if (!bearing || bearing->z() <= 0) continue;
    points.push_back(pairs.points[i]);
    normalized.push_back(bearing->hnormalized());
  }
  if (points.size() < 4) return std::nullopt;
  try {
    return planar_pose(points, normalized).best().camera_from_plane;
  } catch (const Error&) {
    return std::nullopt;
  }
}

/// One view's points of a device in the rig's frame, in the order given and turned by 180 degrees.
struct Lit {
  std::size_t view;
  Points3 as_given, turned;
  Points2 pixels;
};

std::vector<Lit> lit_points(const Correspondences& data, const Start& start, const Points3& board,
                            std::size_t device) {
  std::vector<Lit> lit;
  for (std::size_t v = 0; v < data.views.size(); ++v) {
    const auto& observations = data.views[v].observations[device];
    if (!start.view_used[v]) continue;
    Lit one;
    one.view = v;
    for (const Observation& o : observations) {
      one.as_given.push_back(start.state.rig_from_board[v] * board[std::size_t(o.point)]);
      one.turned.push_back(start.state.rig_from_board[v] * board[board.size() - 1 - std::size_t(o.point)]);
      one.pixels.push_back(o.pixel);
    }
    for (const LightPoint& light : data.views[v].light_points) {
      if (light.projector != int(device)) continue;
      const auto place = place_in_rig(start.state, int(v), light);
      if (!place) continue;
      one.as_given.push_back(*place);
      one.turned.push_back(*place);
      one.pixels.push_back(light.projector_pixel);
    }
    if (int(one.pixels.size()) >= kMinPointsPerView) lit.push_back(std::move(one));
  }
  return lit;
}

double rms_under(const Resection& resection, const Points3& points, const Points2& pixels) {
  double sum = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto pixel = project<NoDistortion>(resection.intrinsics, static_cast<const double*>(nullptr),
                                             Vec3(resection.device_from_points * points[i]));
    if (!pixel) return 1e300;
    sum += (*pixel - pixels[i]).squaredNorm();
  }
  return std::sqrt(sum / double(points.size()));
}

void add(const Lit& one, bool turn, Points3& points, Points2& pixels) {
  const Points3& of_view = turn ? one.turned : one.as_given;
  points.insert(points.end(), of_view.begin(), of_view.end());
  pixels.insert(pixels.end(), one.pixels.begin(), one.pixels.end());
}

Resection resect_views(const std::vector<Lit>& lit, const std::vector<bool>& turned,
                       const std::vector<std::size_t>& views, const std::string& name) {
  Points3 points;
  Points2 pixels;
  for (const std::size_t i : views) add(lit[i], turned[i], points, pixels);
  return resect(points, pixels, name);
}

/// A view is far off when a start that holds for the others misses it this many times as far as its median
/// view, and by more than a few pixels: distortion alone, which the start ignores, misses by so much.
constexpr double kFarOff = 3, kFewPixels = 3;

/// One view of another board or with stale frames would spoil a linear solve of all. If the solve of all
/// leaves a view far off, triples of views compete by the error of the median view, and the winner's solve is
/// repeated with all views that it holds for.
struct Agreement {
  Resection resection;
  std::vector<std::size_t> views;  ///< that it holds for; indices into the lit views
};
Agreement resect_those_that_agree(const std::vector<Lit>& lit, const std::vector<bool>& turned,
                                  const std::string& name) {
  const auto errors = [&](const Resection& resection) {
    std::vector<double> rms;
    for (std::size_t i = 0; i < lit.size(); ++i)
      rms.push_back(rms_under(resection, turned[i] ? lit[i].turned : lit[i].as_given, lit[i].pixels));
    return rms;
  };
  const auto median = [](std::vector<double> values) {
    const auto middle = values.begin() + long((values.size() - 1) / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
  };
  const auto holding = [&](const std::vector<double>& rms) {
    const double limit = std::max(kFarOff * median(rms), kFewPixels);
    std::vector<std::size_t> views;
    for (std::size_t i = 0; i < rms.size(); ++i)
      if (rms[i] <= limit) views.push_back(i);
    return views;
  };
  std::vector<std::size_t> all(lit.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = i;
  std::optional<Resection> best;
  double least = 1e300;
  std::string why;
  const auto compete = [&](const std::vector<std::size_t>& views) {
    try {
      const Resection trial = resect_views(lit, turned, views, name);
      const double error = median(errors(trial));
      if (error < least) least = error, best = trial;
    } catch (const Error& error) {
      if (error.kind() != ErrorKind::kDegenerate && error.kind() != ErrorKind::kNotConverged) throw;
    }
  };
  compete(all);
  if (lit.size() <= 3 || (best && least < kFewPixels && holding(errors(*best)).size() == lit.size())) {
    if (!best) best = resect_views(lit, turned, all, name);  // throws, with its reason
    return {*best, all};
  }
  // All triples of a dozen views, or every n-th of more.
  std::vector<std::vector<std::size_t>> triples;
  for (std::size_t i = 0; i < lit.size(); ++i)
    for (std::size_t j = i + 1; j < lit.size(); ++j)
      for (std::size_t k = j + 1; k < lit.size(); ++k) triples.push_back({i, j, k});
  const std::size_t every = triples.size() / 250 + 1;
  for (std::size_t t = 0; t < triples.size(); t += every) compete(triples[t]);
  if (!best) best = resect_views(lit, turned, all, name);
  const std::vector<std::size_t> agreeing = holding(errors(*best));
  if (agreeing.size() < 3) return {*best, all};
  compete(agreeing);
  return {*best, agreeing};
}

/// Resects a device from all its views. With `settle`, each view is taken in whichever of its two orders
/// fits: the two views whose planes differ most are tried in all four combinations, the others join one by
/// one.
Agreement resect_device(const std::vector<Lit>& lit, bool settle, const std::string& name,
                        std::vector<bool>& turned) {
  turned.assign(lit.size(), false);
  Points3 points;
  Points2 pixels;
  if (!settle || lit.size() < 2) return resect_those_that_agree(lit, turned, name);
  const auto normal = [](const Lit& one) {
    return (one.as_given.back() - one.as_given.front())
        .cross(one.as_given[one.as_given.size() / 2 + 1] - one.as_given.front())
        .normalized();
  };
  std::size_t first = 0, second = 1;
  double widest = 2;
  for (std::size_t i = 0; i < lit.size(); ++i)
    for (std::size_t j = i + 1; j < lit.size(); ++j) {
      const double c = std::abs(normal(lit[i]).dot(normal(lit[j])));
      if (c < widest) widest = c, first = i, second = j;
    }
  double least = 1e300;
  Resection best;
  for (int combination = 0; combination < 4; ++combination) {
    points.clear(), pixels.clear();
    add(lit[first], combination & 1, points, pixels);
    add(lit[second], combination & 2, points, pixels);
    try {
      const Resection trial = resect(points, pixels, name);
      // Two planes leave the linear solve some freedom: judge it by its pixels and by a plausible shape of
      // pixel.
      const double misfit =
          trial.rms_px * (1 + 100 * std::abs(std::log(trial.intrinsics.fx / trial.intrinsics.fy)));
      if (misfit < least)
        least = misfit, best = trial, turned[first] = combination & 1, turned[second] = combination & 2;
    } catch (const Error&) {
      continue;
    }
  }
  if (least == 1e300) return resect_those_that_agree(lit, turned, name);
  points.clear(), pixels.clear();
  add(lit[first], turned[first], points, pixels);
  add(lit[second], turned[second], points, pixels);
  for (std::size_t i = 0; i < lit.size(); ++i) {
    if (i == first || i == second) continue;
    turned[i] =
        rms_under(best, lit[i].turned, lit[i].pixels) < rms_under(best, lit[i].as_given, lit[i].pixels);
    add(lit[i], turned[i], points, pixels);
    best = resect(points, pixels, name);
  }
  return resect_those_that_agree(lit, turned, name);
}

void require_views(const Start& start, const Correspondences& data) {
  const auto usable = std::size_t(std::count(start.view_used.begin(), start.view_used.end(), true));
  if (usable >= kMinViews) return;
  std::string why = std::to_string(usable) + " of " + std::to_string(data.views.size()) +
                    " views are usable, " + std::to_string(kMinViews) + " are needed";
  for (std::size_t v = 0; v < data.views.size(); ++v)
    if (!start.view_used[v]) why += "; " + data.views[v].name + " " + start.notes[v];
  throw Error(ErrorKind::kNotEnoughData, "calibration", why,
              "capture at least three (better eight) views with the board tilted and at other distances");
}

/// The first camera's lens and every view's board pose.
void start_camera(const Correspondences& data, const Points3& board,
                  const std::optional<Camera>& known_camera, const Options& options, Start& start) {
  const ImageSize size = data.devices[0].size;
  Camera& lens = start.state.lenses[0];
  if (known_camera) {
    lens = *known_camera;
    start.bundle_options.held[0] = parameter_names(lens);
  } else {
    std::vector<Mat3> homographies;
    for (std::size_t v = 0; v < data.views.size(); ++v) {
      if (!start.view_used[v]) continue;
      const Pairs pairs = pairs_of(data, board, v, 0);
      try {
        homographies.push_back(fit_homography(pairs.points, pairs.pixels).destination_from_source.matrix());
      } catch (const Error& error) {
        start.view_used[v] = false;
        start.notes[v] = std::string("left out: ") + error.what();
      }
    }
    require_views(start, data);
    const auto intrinsics = initial_camera_intrinsics(homographies, size);
    if (!intrinsics)
      throw Error(ErrorKind::kDegenerate, data.devices[0].name,
                  "the boards are all parallel to the image, which leaves the focal length open",
                  "capture views with the board tilted 20 to 40 degrees, about both axes");
    lens = Camera{size, *intrinsics, options.camera.model};
  }
  for (std::size_t v = 0; v < data.views.size(); ++v) {
    if (!start.view_used[v]) continue;
    const auto pose = board_pose(lens, pairs_of(data, board, v, 0));
    if (pose) {
      start.state.rig_from_board[v] = *pose;
    } else {
      start.view_used[v] = false;
      start.notes[v] = "left out: no pose of the board explains its corners";
    }
  }
}

/// Boards that all stand alike leave the focal length open, and the solver wandering.
void require_tilted(const Start& start, const std::string& camera) {
  constexpr double kLeastTilt = 6 * 3.14159265358979323846 / 180;
  double widest = 0;
  for (std::size_t i = 0; i < start.view_used.size(); ++i)
    for (std::size_t j = i + 1; j < start.view_used.size(); ++j)
      if (start.view_used[i] && start.view_used[j])
        widest = std::max(widest,
                          std::acos(std::clamp(start.state.rig_from_board[i]
                                                   .rotate(Vec3::UnitZ())
                                                   .dot(start.state.rig_from_board[j].rotate(Vec3::UnitZ())),
                                               -1.0, 1.0)));
  if (widest < kLeastTilt)
    throw Error(ErrorKind::kDegenerate, camera,
                "the boards are all parallel to each other, which leaves the focal length open",
                "capture views with the board tilted 20 to 40 degrees, about both axes");
}

}  // namespace

Start find_start(Correspondences& data, const std::optional<Camera>& known_camera, const Options& options) {
  const std::size_t num_devices = data.devices.size(), num_views = data.views.size();
  const Points3 board = points_in_board(data.board);
  Start start;
  start.used = use_all(data);
  start.view_used.assign(num_views, true);
  start.notes.assign(num_views, "");
  start.state.lenses.resize(num_devices);
  start.state.device_from_rig.resize(num_devices);
  start.state.rig_from_board.resize(num_views);
  start.state.points_in_board = board;
  start.state.light_read_at_corners = options.light_read_at_corners;
  start.bundle_options.noise.resize(num_devices);
  start.bundle_options.hold_pose.assign(num_devices, false);
  for (const Device& device : data.devices) {
    const LensOptions& lens = device.kind == DeviceKind::kCamera ? options.camera : options.projector;
    start.bundle_options.held.push_back(lens.held);
    start.bundle_options.priors.push_back(lens.priors);
  }

  for (std::size_t v = 0; v < num_views; ++v)
    if (int(data.views[v].observations[0].size()) < kMinPointsPerView) {
      start.view_used[v] = false;
      start.notes[v] = "left out: " + data.devices[0].name + " sees " +
                       std::to_string(data.views[v].observations[0].size()) + " of the board's points";
    }
  require_views(start, data);
  start_camera(data, board, known_camera, options, start);
  require_views(start, data);

  const auto mask_unused_views = [&](UsedMask& mask) {
    for (std::size_t v = 0; v < num_views; ++v)
      if (!start.view_used[v])
        for (auto& of_device : mask[v]) std::fill(of_device.begin(), of_device.end(), char(0));
  };
  mask_unused_views(start.used);

  // The camera alone first: its own noise is small, and its poses carry everything that follows.
  UsedMask camera_only = start.used;
  for (std::size_t v = 0; v < num_views; ++v)
    for (std::size_t d = 1; d < num_devices; ++d)
      std::fill(camera_only[v][d].begin(), camera_only[v][d].end(), char(0));
  BundleOptions roughly = start.bundle_options;
  roughly.tolerance = 1e-5;
  start.state = bundle_adjust(data, camera_only, start.state, roughly).state;
  if (!known_camera) require_tilted(start, data.devices[0].name);
  start.first = start.used;

  for (std::size_t d = 1; d < num_devices; ++d) {
    const Device& device = data.devices[d];
    const std::vector<Lit> lit = lit_points(data, start, board, d);
    if (lit.size() < kMinViews)
      throw Error(ErrorKind::kNotEnoughData, device.name,
                  std::to_string(lit.size()) + " views have at least " + std::to_string(kMinPointsPerView) +
                      " of the board's points for it, " + std::to_string(kMinViews) + " are needed",
                  "place the board inside the projector's light, and check that its size and the order of "
                  "frames are right");
    std::vector<bool> turned;
    const auto [resection, agreeing] = resect_device(lit, looks_same_turned(data.board), device.name, turned);
    for (std::size_t i = 0; i < lit.size(); ++i)
      if (std::count(agreeing.begin(), agreeing.end(), i) == 0)
        std::fill(start.first[lit[i].view][d].begin(), start.first[lit[i].view][d].end(), char(0));
    for (std::size_t i = 0; i < lit.size(); ++i) {
      if (!turned[i]) continue;
      for (Observation& o : data.views[lit[i].view].observations[d])
        o.point = int(board.size()) - 1 - o.point;
      start.notes[lit[i].view] = "order of " + device.name + "'s corners turned by 180 degrees";
      start.diagnostics.note("order_turned", "view " + data.views[lit[i].view].name + ": " +
                                                 start.notes[lit[i].view] + ", as its residual asked");
    }
    Camera& lens = start.state.lenses[d];
    const LensOptions& lens_options = device.kind == DeviceKind::kCamera ? options.camera : options.projector;
    lens = Camera{device.size, resection.intrinsics, lens_options.model};
    if (std::count(lens_options.held.begin(), lens_options.held.end(), "skew") > 0) lens.intrinsics.skew = 0;
    start.state.device_from_rig[d] = resection.device_from_points;
  }
  return start;
}

}  // namespace procam::calibrate
