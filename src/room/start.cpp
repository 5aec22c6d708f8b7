#include "start.hpp"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>

#include "epipolar.hpp"
#include "procam/core/base/error.hpp"
#include "procam/core/base/stats.hpp"
#include "procam/core/base/words.hpp"
#include "procam/core/geometry/homography_robust.hpp"

namespace procam::room {
namespace {

constexpr int kSearchPoints = 500, kPairs = 1200, kFewestShared = 40;
constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();

std::optional<Vec2> ray_at(const Camera& lens, const Vec2& pixel) {
  const std::optional<Vec3> bearing = lens.unproject(pixel);
  if (!bearing || !(bearing->z() > 1e-6)) return std::nullopt;
  return Vec2(bearing->head<2>() / bearing->z());
}

class Builder {
 public:
  Builder(const RoomPoints& points, const LensPlan& plan, int threads)
      : points_(points), plan_(plan), threads_(threads) {}

  Started run() {
    Started best;
    best.merit = std::numeric_limits<double>::infinity();
    for (RoomState& state : first_devices()) {
      Started trial{std::move(state), 0};
      trial.merit = adjust(trial.state, kFocalAndCentre);
      if (trial.merit < best.merit) best = std::move(trial);
    }
    if (!std::isfinite(best.merit))
      refuse_room(points_, plan_, "no two devices fit the light that they share");
    adjust(best.state, kRadial);
    while (add_device(best.state)) {
    }
    for (std::size_t i = 0; i < best.state.solved.size(); ++i)
      if (!best.state.solved[i]) refuse_unconnected(best.state, int(i));
    best.merit = adjust(best.state, kRadial);
    return best;
  }

 private:
  enum Stage { kFocalAndCentre, kRadial };

  int cameras() const { return int(points_.cameras.size()); }
  int positions() const { return int(points_.positions.size()); }
  const MapDevices& devices(const LightReading& reading) const {
    return points_.maps[std::size_t(reading.map)];
  }
  int anchor(const RoomPoint& point) const { return devices(point.readings[0]).position; }
  const Camera& lens_of_position(const RoomState& state, int position) const {
    return state.lenses[std::size_t(points_.positions[std::size_t(position)].camera)];
  }

  RoomState empty_state() const {
    RoomState state;
    state.lenses = plan_.lenses;
    state.rig_from_device.resize(std::size_t(positions()) + points_.projectors.size());
    state.solved.assign(state.rig_from_device.size(), 0);
    state.inverse_depth.assign(points_.points.size(), kNothing);
    return state;
  }

  AdjustOptions options(Stage stage) const {
    AdjustOptions out;
    out.known = plan_.known;
    out.threads = threads_;
    out.free = plan_.free;
    for (std::size_t l = 0; l < out.free.size(); ++l) {
      if (!plan_.guess[l]) {  // known: as it is, for now
        std::fill(out.free[l].begin(), out.free[l].end(), 0);
        continue;
      }
      for (std::size_t i = 4; i < out.free[l].size(); ++i)
        out.free[l][i] = stage == kRadial && (i == 5 || i == 6);
    }
    return out;
  }

  /// Places depths and improves all that is solved, by a part of the points. Returns Started::merit.
  double adjust(RoomState& state, Stage stage) const {
    to_first(state);
    Adjustment adjustment(points_, options(stage));
    std::fill(adjustment.used.begin(), adjustment.used.end(), 0);
    std::vector<int> usable;
    for (int i = 0; i < int(points_.points.size()); ++i) {
      double& w = state.inverse_depth[std::size_t(i)];
      if (!std::isfinite(w) && !adjustment.start_depth(state, i)) continue;
      if (adjustment.fit(state, i).freedom > 0) usable.push_back(i);
    }
    if (int(usable.size()) < kFewestShared) return std::numeric_limits<double>::infinity();
    const double step =
        std::max(1.0, double(usable.size()) / (kSearchPoints * std::max(2, solved(state) - 1)));
    for (double at = 0; at < double(usable.size()); at += step)
      adjustment.used[std::size_t(usable[std::size_t(at)])] = 1;
    const double scatter = std::max(adjustment.solve(state), 1e-6);
    const double merit = 2 * kSearchPoints * std::log(scatter) + adjustment.prior(state);
    for (const int i : usable) {
      if (adjustment.used[std::size_t(i)]) continue;
      if (!adjustment.refine_depth(state, i)) adjustment.start_depth(state, i);
    }
    return merit;
  }

  static int solved(const RoomState& state) {
    return int(std::count(state.solved.begin(), state.solved.end(), 1));
  }

  /// The first device that has a place becomes the rig's frame.
  void to_first(RoomState& state) const {
    const auto first = std::find(state.solved.begin(), state.solved.end(), 1) - state.solved.begin();
    const Pose frame = state.rig_from_device[std::size_t(first)].inverse();
    for (std::size_t i = 0; i < state.solved.size(); ++i)
      if (state.solved[i]) state.rig_from_device[i] = (frame * state.rig_from_device[i]).normalized();
    state.rig_from_device[std::size_t(first)] = Pose::identity();
  }

  // ---- two devices

  struct PositionPair {
    int a = 0, b = 0;
    std::vector<ImagePair> rays;
    std::vector<Pose> poses;  ///< b_from_a that agree
    double merit = 0;
  };

  /// Pairs of camera positions that see the same light.
  std::vector<PositionPair> position_pairs() const {
    std::vector<PositionPair> pairs;
    for (int a = 0; a < positions(); ++a)
      for (int b = a + 1; b < positions(); ++b) {
        PositionPair pair{a, b, {}, {}, 0};
        for (const RoomPoint& point : points_.points) {
          const int from = anchor(point);
          if (from != a && from != b) continue;
          for (std::size_t r = 1; r < point.readings.size(); ++r) {
            const int to = devices(point.readings[r]).position;
            if (to == from || (to != a && to != b)) continue;
            const auto x = ray_at(plan_.lenses[std::size_t(points_.positions[std::size_t(from)].camera)],
                                  point.readings[0].camera_pixel),
                       y = ray_at(plan_.lenses[std::size_t(points_.positions[std::size_t(to)].camera)],
                                  point.readings[r].camera_pixel);
            if (x && y) pair.rays.push_back(from == a ? ImagePair{*x, *y} : ImagePair{*y, *x});
            break;
          }
        }
        if (int(pair.rays.size()) < kFewestShared) continue;
        thin(pair.rays);
        solve_pair(pair);
        if (!pair.poses.empty()) pairs.push_back(std::move(pair));
      }
    std::sort(pairs.begin(), pairs.end(), [](const auto& x, const auto& y) { return x.merit > y.merit; });
    return pairs;
  }

  static void thin(std::vector<ImagePair>& rays) {
    if (int(rays.size()) <= kPairs) return;
    std::vector<ImagePair> kept;
    for (int i = 0; i < kPairs; ++i) kept.push_back(rays[rays.size() * std::size_t(i) / kPairs]);
    rays = std::move(kept);
  }

  void solve_pair(PositionPair& pair) const {
    const double focal = lens_focal(pair.a), threshold = (plan_.cameras_known ? 1.0 : 6.0) / focal;
    const std::size_t shared = pair.rays.size();
    if (rotation_error(pair.rays) < (plan_.cameras_known ? 6e-4 : 4e-3))
      return;  // no parallax: any translation fits
    const auto take = [&](const std::vector<Pose>& poses, std::size_t max_count) {
      std::vector<std::pair<double, Pose>> ranked;
      for (const Pose& pose : poses)
        if (const double share = share_in_front(pose, pair.rays); share > 0.8)
          ranked.emplace_back(share, pose);
      std::stable_sort(ranked.begin(), ranked.end(),
                       [](const auto& x, const auto& y) { return x.first > y.first; });
      for (std::size_t i = 0; i < std::min(max_count, ranked.size()); ++i)
        pair.poses.push_back(ranked[i].second);
    };
    if (const auto geometry = find_epipolar(pair.rays, threshold))
      take(poses_of_essential(geometry->fundamental), 2);
    if (const std::optional<Mat3> plane = homography(pair.rays, 2 * threshold))
      take(poses_of_homography(*plane), 2);
    if (pair.poses.empty()) return;
    pair.merit = double(shared) * std::min(0.35, parallax(pair.poses.front(), pair.rays));
  }

  double lens_focal(int position) const {
    const Intrinsics& k =
        plan_.lenses[std::size_t(points_.positions[std::size_t(position)].camera)].intrinsics;
    return std::sqrt(std::abs(k.fx * k.fy));
  }

  static double parallax(const Pose& b_from_a, const std::vector<ImagePair>& rays) {
    std::vector<double> angles;
    for (const ImagePair& pair : rays) {
      const Vec3 d = b_from_a.rotation * Vec3(pair.first.x(), pair.first.y(), 1),
                 e(pair.second.x(), pair.second.y(), 1);
      angles.push_back(std::atan2(d.cross(e).norm(), d.dot(e)));
    }
    return median_or(angles, 0.0);
  }

  /// Of most pairs, where one is.
  static std::optional<Mat3> homography(const std::vector<ImagePair>& pairs, double threshold) {
    Points2 first, second;
    for (const ImagePair& pair : pairs) first.push_back(pair.first), second.push_back(pair.second);
    try {
      RobustHomographyOptions options;
      options.sigma = threshold / 3;
      options.max_samples = 500;
      const HomographyFit fit = fit_homography_robust(first, second, options);
      const auto inliers = std::count(fit.inliers.begin(), fit.inliers.end(), true);
      if (double(inliers) < 0.6 * double(pairs.size())) return std::nullopt;
      return fit.destination_from_source.matrix();
    } catch (const Error&) {
      return std::nullopt;
    }
  }

  std::vector<RoomState> first_devices() const {
    std::vector<RoomState> states;
    const std::vector<PositionPair> pairs = position_pairs();
    for (std::size_t i = 0; i < std::min<std::size_t>(2, pairs.size()); ++i)
      begin_with_positions(pairs[i], states);
    if (states.empty()) begin_with_projector(states);
    return states;
  }

  void begin_with_positions(const PositionPair& pair, std::vector<RoomState>& states) const {
    for (const Pose& b_from_a : pair.poses) {
      RoomState state = empty_state();
      state.solved[std::size_t(pair.a)] = state.solved[std::size_t(pair.b)] = 1;
      state.rig_from_device[std::size_t(pair.b)] = b_from_a.inverse();
      const Adjustment depths(points_, options(kFocalAndCentre));
      for (int i = 0; i < int(points_.points.size()); ++i) depths.start_depth(state, i);
      std::vector<int> shared(points_.projectors.size());
      for (int i = 0; i < int(points_.points.size()); ++i)
        if (std::isfinite(state.inverse_depth[std::size_t(i)]))
          ++shared[std::size_t(devices(points_.points[std::size_t(i)].readings[0]).projector)];
      const int projector = int(std::max_element(shared.begin(), shared.end()) - shared.begin());
      for (RoomState& with : with_projector(state, projector)) states.push_back(std::move(with));
    }
  }

  /// A camera position and a projector: the fundamental matrix, and a grid of lenses for the projector.
  void begin_with_projector(std::vector<RoomState>& states) const {
    std::vector<int> count(points_.maps.size());
    for (const RoomPoint& point : points_.points) ++count[std::size_t(point.readings[0].map)];
    const int map = int(std::max_element(count.begin(), count.end()) - count.begin());
    const MapDevices& pair = points_.maps[std::size_t(map)];
    const std::size_t lens = std::size_t(cameras() + pair.projector);
    const LensGuess& guess = *plan_.guess[lens];
    std::vector<ImagePair> images;  // rays and projector pixels over the width
    for (const RoomPoint& point : points_.points) {
      if (point.readings[0].map != map) continue;
      const auto ray = ray_at(plan_.lenses[std::size_t(points_.positions[std::size_t(pair.position)].camera)],
                              point.readings[0].camera_pixel);
      if (ray) images.push_back({*ray, point.readings[0].projector_pixel / guess.size.width});
    }
    thin(images);
    const double threshold = 4.0 / guess.size.width;
    const auto geometry = find_epipolar(images, threshold);
    const std::optional<Mat3> plane = homography(images, threshold);
    struct Candidate {
      double merit;
      Intrinsics lens;
      Pose pose;
    };
    std::vector<Candidate> candidates;
    for (const Intrinsics& lens_try : lens_grid(guess)) {
      Mat3 k = lens_try.matrix();
      k.topRows<2>() /= guess.size.width;
      std::vector<ImagePair> rays = images;
      for (ImagePair& image : rays)
        image.second = lens_try.normalized_from_pixel(image.second * guess.size.width);
      std::vector<ImagePair> few;
      for (std::size_t i = 0; i < rays.size(); i += 1 + rays.size() / 80) few.push_back(rays[i]);
      const double unlikely = std::pow(std::log(lens_try.fx / guess.focal) / guess.focal_sigma, 2) +
                              std::pow((lens_try.cx - guess.centre.x()) / guess.centre_sigma.x(), 2) +
                              std::pow((lens_try.cy - guess.centre.y()) / guess.centre_sigma.y(), 2);
      if (geometry) {
        const Mat3 essential = k.transpose() * geometry->fundamental;
        const Vec3 values = Eigen::JacobiSVD<Mat3>(essential).singularValues();
        for (const Pose& pose : poses_of_essential(essential))
          if (share_in_front(pose, few) > 0.9)
            candidates.push_back({(values[0] - values[1]) / values[0] + 0.003 * unlikely, lens_try, pose});
      }
      if (plane)
        for (const Pose& pose : poses_of_homography(Mat3(k.inverse() * *plane)))
          if (share_in_front(pose, few) > 0.9) candidates.push_back({0.02 + 0.02 * unlikely, lens_try, pose});
    }
    std::stable_sort(candidates.begin(), candidates.end(),
                     [](const Candidate& a, const Candidate& b) { return a.merit < b.merit; });
    constexpr std::size_t kTried = 16;
    for (std::size_t i = 0; i < std::min(kTried, candidates.size()); ++i) {
      RoomState state = empty_state();
      const std::size_t projector = std::size_t(positions() + pair.projector);
      state.solved[std::size_t(pair.position)] = state.solved[projector] = 1;
      state.rig_from_device[projector] = candidates[i].pose.inverse();
      state.lenses[lens].intrinsics = candidates[i].lens;
      states.push_back(std::move(state));
    }
  }

  // ---- one more device

  /// Points that have a place, and where a device has their image.
  struct SharedImages {
    Points3 places;
    Points2 images;
  };
  /// image(point): std::optional<Vec2>. None where fewer points are shared than a pose needs.
  template <typename Image>
  std::optional<SharedImages> shared_images(const RoomState& state, const Image& image) const {
    SharedImages shared;
    for (std::size_t i = 0; i < points_.points.size(); ++i) {
      const RoomPoint& point = points_.points[i];
      const double w = state.inverse_depth[i];
      if (!std::isfinite(w)) continue;
      const auto ray = ray_at(lens_of_position(state, anchor(point)), point.readings[0].camera_pixel);
      const std::optional<Vec2> at = ray ? image(point) : std::nullopt;
      if (!at) continue;
      shared.places.push_back(state.rig_from_device[std::size_t(anchor(point))] *
                              Vec3(Vec3(ray->x(), ray->y(), 1) / w));
      shared.images.push_back(*at);
    }
    if (int(shared.places.size()) < kFewestShared) return std::nullopt;
    keep_some(shared.places, shared.images);
    return shared;
  }

  std::vector<RoomState> with_projector(const RoomState& state, int projector) const {
    std::vector<RoomState> out;
    const auto shared = shared_images(state, [&](const RoomPoint& point) -> std::optional<Vec2> {
      for (const LightReading& reading : point.readings)
        if (devices(reading).projector == projector && state.solved[std::size_t(devices(reading).position)])
          return reading.projector_pixel;
      return std::nullopt;
    });
    if (!shared) return out;
    const std::size_t lens = std::size_t(cameras() + projector);
    for (const Resection& resection : resect_with_lens(shared->places, shared->images, *plan_.guess[lens])) {
      RoomState next = state;
      next.solved[std::size_t(positions() + projector)] = 1;
      next.rig_from_device[std::size_t(positions() + projector)] = resection.device_from_rig.inverse();
      next.lenses[lens].intrinsics = resection.lens;
      out.push_back(std::move(next));
    }
    return out;
  }

  std::vector<RoomState> with_position(const RoomState& state, int position) const {
    std::vector<RoomState> out;
    const auto shared = shared_images(state, [&](const RoomPoint& point) -> std::optional<Vec2> {
      for (std::size_t r = 1; r < point.readings.size(); ++r)
        if (devices(point.readings[r]).position == position)
          return ray_at(lens_of_position(state, position), point.readings[r].camera_pixel);
      return std::nullopt;
    });
    if (!shared) return out;
    for (const Resection& resection : resect_known(shared->places, shared->images, lens_focal(position))) {
      RoomState next = state;
      next.solved[std::size_t(position)] = 1;
      next.rig_from_device[std::size_t(position)] = resection.device_from_rig.inverse();
      out.push_back(std::move(next));
    }
    return out;
  }

  static void keep_some(Points3& places, Points2& images) {
    constexpr std::size_t kMax = 400;
    if (places.size() <= kMax) return;
    for (std::size_t i = 0; i < kMax; ++i) {
      const std::size_t from = places.size() * i / kMax;
      places[i] = places[from];
      images[i] = images[from];
    }
    places.resize(kMax);
    images.resize(kMax);
  }

  /// Points with a depth that each device without a place shares.
  std::vector<int> shared_points(const RoomState& state) const {
    std::vector<int> count(state.solved.size());
    for (std::size_t i = 0; i < points_.points.size(); ++i) {
      if (!std::isfinite(state.inverse_depth[i])) continue;
      std::vector<char> seen(state.solved.size());
      for (const LightReading& reading : points_.points[i].readings) {
        seen[std::size_t(devices(reading).position)] = 1;
        if (state.solved[std::size_t(devices(reading).position)])
          seen[std::size_t(positions() + devices(reading).projector)] = 1;
      }
      for (std::size_t d = 0; d < seen.size(); ++d) count[d] += seen[d];
    }
    return count;
  }

  bool add_device(RoomState& state) const {
    std::vector<int> count = shared_points(state);
    for (std::size_t i = 0; i < count.size(); ++i)
      if (state.solved[i]) count[i] = 0;
    while (true) {
      const auto most = std::max_element(count.begin(), count.end());
      if (*most < kFewestShared) return false;
      const int device = int(most - count.begin());
      Started best;
      best.merit = std::numeric_limits<double>::infinity();
      for (RoomState& trial : device < positions() ? with_position(state, device)
                                                   : with_projector(state, device - positions())) {
        Started started{std::move(trial), 0};
        started.merit = adjust(started.state, kFocalAndCentre);
        if (started.merit < best.merit) best = std::move(started);
      }
      if (std::isfinite(best.merit)) {
        state = std::move(best.state);
        adjust(state, kRadial);
        return true;
      }
      *most = 0;
    }
  }

  [[noreturn]] void refuse_unconnected(const RoomState& state, int device) const {
    const int count = shared_points(state)[std::size_t(device)];
    if (count >= kFewestShared)
      refuse_room(points_, plan_, "no place of a device fits the light that it shares");
    const bool is_projector = device >= positions();
    const std::string name =
        is_projector
            ? "projector '" + points_.projectors[std::size_t(device - positions())].name + "'"
            : "camera '" + points_.cameras[std::size_t(points_.positions[std::size_t(device)].camera)].name +
                  "' in view '" + points_.positions[std::size_t(device)].view + "'";
    throw Error(ErrorKind::kNotEnoughData, name,
                "it shares " + std::to_string(count) + " measured points with the other devices, and " +
                    std::to_string(kFewestShared) + " are needed",
                is_projector ? "let a part of its picture fall on what two of the cameras' positions see"
                             : "let it see a part of a picture that another camera position sees");
  }

  const RoomPoints& points_;
  const LensPlan& plan_;
  int threads_;
};

}  // namespace

Started start_room(const RoomPoints& points, const LensPlan& plan, int threads) {
  return Builder(points, plan, threads).run();
}

}  // namespace procam::room
