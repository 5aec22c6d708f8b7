#include "causes.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>

#include "procam/core/base/stats.hpp"
#include "procam/core/base/words.hpp"
#include "procam/core/geometry/se3.hpp"
#include "rig_motion.hpp"

namespace procam::calibrate {
namespace {

/// A fit this much better than the limit for outliers explains what the rig does not.
constexpr double kExplained = 3;
constexpr double kSamePixel = 1;  ///< pixels: light that has not moved between views
/// Of the RMS as given: another order or view explains the pixels, though a board's pose is known from few corners.
constexpr double kFarBetter = 0.02;

std::string amount(const Pose& motion) {
  return format("%.1f mm and %.2f degrees", 1e3 * motion.translation.norm(),
                se3_log(motion).head<3>().norm() / kDegree);
}

/// Nothing turns by so much between two frames: an image was rotated.
bool may_have_moved(const Pose& motion) {
  return se3_log(motion).head<3>().norm() < 100 * kDegree;
}

/// RMS that the device has in the views that agree: what a good explanation comes near to.
double usual_rms(const Correspondences& data, const Solution& solution, int device) {
  return std::max(spread_of(data, solution.state(), solution.used, device).rms_px, 0.02);
}

std::map<int, Vec2> pixels_by_point(const View& view, int device) {
  std::map<int, Vec2> pixels;
  for (const Observation& o : view.observations[std::size_t(device)]) pixels[o.point] = o.pixel;
  return pixels;
}

/// Median distance of the points that two views share; nullopt when they share too few.
std::optional<double> typical_distance(const std::map<int, Vec2>& a, const std::map<int, Vec2>& b) {
  std::vector<double> distances;
  for (const auto& [point, pixel] : a)
    if (const auto other = b.find(point); other != b.end())
      distances.push_back((pixel - other->second).norm());
  if (distances.size() < 6) return std::nullopt;
  return median(std::move(distances));
}

/// The board's pose that one device alone asks for, and how well it explains its pixels.
struct OwnPose {
  Pose rig_from_board;
  double rms_px = 0;
};
OwnPose own_pose(const Correspondences& data, const UsedMask& everything, const Solution& solution, int view,
                 int device) {
  const UsedMask only = only_view(everything, std::size_t(view), device);
  BundleOptions options = hold_devices(solution.options, solution.state());
  options.tolerance = 1e-9;
  const BundleState state = bundle_adjust(data, only, solution.state(), options).state;
  return {state.rig_from_board[std::size_t(view)], spread_of(data, state, only).rms_px};
}

/// As own_pose, nullopt where nothing is there to fit or the fit fails.
std::optional<OwnPose> try_own_pose(const Correspondences& data, const UsedMask& everything,
                                    const Solution& solution, int view, int device) {
  if (data.views[std::size_t(view)].observations[std::size_t(device)].size() < 6) return std::nullopt;
  try {
    return own_pose(data, everything, solution, view, device);
  } catch (const Error&) {
    return std::nullopt;
  }
}

/// Another camera of the same size with which this one agrees on the view once their pictures are exchanged.
std::optional<std::string> exchanged_with(const Correspondences& data, const UsedMask& everything,
                                          const Solution& solution, int view, int device, double explained) {
  const auto d = std::size_t(device);
  for (std::size_t e = 0; e < data.devices.size(); ++e) {
    if (e == d || data.devices[e].kind != DeviceKind::kCamera ||
        data.devices[d].kind != DeviceKind::kCamera || data.devices[e].size != data.devices[d].size)
      continue;
    Correspondences other = data;
    auto& observations = other.views[std::size_t(view)].observations;
    std::swap(observations[d], observations[e]);
    UsedMask mask = everything;
    std::swap(mask[std::size_t(view)][d], mask[std::size_t(view)][e]);
    const auto own = try_own_pose(other, mask, solution, view, device);
    if (!own || own->rms_px > explained) continue;
    // Any board fits some pose: exchanged, it must be one pose for both.
    UsedMask both = only_view(mask, std::size_t(view), device);
    both[std::size_t(view)][e] = mask[std::size_t(view)][e];
    BundleState state = solution.state();
    state.rig_from_board[std::size_t(view)] = own->rig_from_board;
    state = bundle_adjust(other, both, state, hold_devices(solution.options, state)).state;
    if (spread_of(other, state, both).rms_px < explained) return data.devices[e].name;
  }
  return std::nullopt;
}

/// The view with its points taken in another order of the board's rows and columns.
std::optional<double> rms_in_order(const Correspondences& data, const UsedMask& everything,
                                   const Solution& solution, int view, int device,
                                   const std::vector<int>& order) {
  Correspondences other = data;
  for (Observation& o : other.views[std::size_t(view)].observations[std::size_t(device)])
    o.point = order[std::size_t(o.point)];
  // Against the pose that the other devices give: an order is wrong for the device, not for the view.
  if (takes_part(solution.used, std::size_t(view)))
    return spread_of(other, solution.state(), everything, device, view).rms_px;
  const auto own = try_own_pose(other, everything, solution, view, device);
  if (!own) return std::nullopt;
  return own->rms_px;
}

/// The view whose projected board this view fits: light points with the projector pixels that the same points
/// have in another view, on the board's pose that the camera gives. The best of all views, nullopt when none
/// explains the light.
std::optional<std::string> shown_in_other_view(const Correspondences& data, const UsedMask& everything,
                                               const Solution& solution, int view, int device,
                                               double explained) {
  std::optional<std::string> best;
  double best_px = explained;
  // Backwards from the view itself: of views that showed the same, the last one before it is named.
  const int views = int(data.views.size());
  for (int back = 1; back < views; ++back) {
    const int v = (view - back + views) % views;
    std::map<int, Vec2> shown;
    for (const LightPoint& light : data.views[std::size_t(v)].light_points)
      if (light.projector == device && light.point >= 0) shown[light.point] = light.projector_pixel;
    Correspondences other = data;
    UsedMask mask = everything;
    int moved = 0;
    std::size_t at = other.views[std::size_t(view)].observations[std::size_t(device)].size();
    for (LightPoint& light : other.views[std::size_t(view)].light_points) {
      if (light.projector != device) continue;
      const auto found = shown.find(light.point);
      char& used = mask[std::size_t(view)][std::size_t(device)][at++];
      if (found == shown.end()) {
        used = 0;
        continue;
      }
      moved += used != 0 && (found->second - light.projector_pixel).norm() > kSamePixel;
      light.projector_pixel = found->second;
    }
    if (moved < 6) continue;
    const Spread spread = spread_of(other, solution.state(), mask, device, view);
    if (2 * spread.count < moved || spread.rms_px >= best_px) continue;
    best_px = spread.rms_px;
    best = data.views[std::size_t(v)].name;
  }
  return best;
}

/// Another view on whose board, as the other devices have it, this view's pixels of the device lie. The best of all
/// views, nullopt when none is below `limit_px`.
std::optional<std::string> belongs_to_view(const Correspondences& data, const UsedMask& everything,
                                           const Solution& solution, int view, int device, double limit_px) {
  const auto d = std::size_t(device);
  const View& here = data.views[std::size_t(view)];
  if (here.observations[d].size() < 6) return std::nullopt;
  std::optional<std::string> best;
  double best_px = limit_px;
  for (std::size_t v = 0; v < data.views.size(); ++v) {
    if (int(v) == view || posing_camera(data, solution.used, v, device) < 0) continue;
    Correspondences other = data;
    other.views[v] = here;
    UsedMask mask = everything;
    mask[v] = mask[std::size_t(view)];
    const Spread spread = spread_of(other, solution.state(), mask, device, int(v));
    if (spread.count < 6 || spread.rms_px >= best_px) continue;
    best_px = spread.rms_px;
    best = data.views[v].name;
  }
  return best;
}

/// For each of the board's points the point in its place once the board is turned by 180 degrees, or is seen in a
/// mirror that exchanges left and right (`flip` = (-1, 1)) or top and bottom.
std::vector<int> exchanged_order(const Points3& board, const Vec2& flip) {
  Vec2 low = board.front().head<2>(), high = low;
  for (const Vec3& point : board) {
    low = low.cwiseMin(Vec2(point.head<2>()));
    high = high.cwiseMax(Vec2(point.head<2>()));
  }
  const Vec2 middle = 0.5 * (low + high);
  std::vector<int> order;
  for (const Vec3& point : board) {
    const Vec2 place = middle + flip.cwiseProduct(Vec2(point.head<2>()) - middle);
    const auto nearest = std::min_element(board.begin(), board.end(), [&](const Vec3& a, const Vec3& b) {
      return (a.head<2>() - place).squaredNorm() < (b.head<2>() - place).squaredNorm();
    });
    order.push_back(int(nearest - board.begin()));
  }
  return order;
}

}  // namespace

namespace {

/// Nothing where none of the causes explains the pixels.
std::optional<std::string> explained_disagreement(const Correspondences& data, const UsedMask& everything,
                                                  const Solution& solution, int view, int device) {
  const std::string& name = data.devices[std::size_t(device)].name;
  const View& here = data.views[std::size_t(view)];
  const auto pixels = pixels_by_point(here, device);
  const double explained = kExplained * usual_rms(data, solution, device);

  const bool projects = data.devices[std::size_t(device)].kind == DeviceKind::kProjector;
  const int other = posing_camera(data, everything, std::size_t(view), device);
  for (std::size_t v = 0; v < data.views.size() && other >= 0; ++v) {
    if (int(v) == view) continue;
    const auto same = typical_distance(pixels, pixels_by_point(data.views[v], device));
    const auto board = typical_distance(pixels_by_point(here, other), pixels_by_point(data.views[v], other));
    if (same && board && *same < kSamePixel && 3 * kSamePixel < *board)
      return (projects ? "its light is that of view " : "its picture is that of view ") + data.views[v].name +
             ": stale frames; wait for the picture to change before each capture, and capture the view again";
  }
  if (projects && posing_camera(data, solution.used, std::size_t(view)) >= 0)
    if (const auto earlier = shown_in_other_view(data, everything, solution, view, device, explained))
      return "its light is what was shown in view " + *earlier +
             ": a stale frame, the projector had not changed yet; wait for the picture to change before each "
             "photograph, and take the view again";
  if (const auto twin = exchanged_with(data, everything, solution, view, device, explained))
    return "its pictures are those of " + *twin +
           ": the folders of two cameras were exchanged; put each camera's frames into its own folder";

  const double as_given = takes_part(solution.used, std::size_t(view))
                              ? spread_of(data, solution.state(), everything, device, view).rms_px
                              : 0;
  const double fits = std::max(explained, kFarBetter * as_given);
  if (const auto owner = belongs_to_view(data, everything, solution, view, device, fits))
    return (projects ? "its light is that of view " : "its picture is that of view ") + *owner +
           ": the frames of two views were exchanged, or not renewed; put each view's frames into its own folder, or "
           "capture the view again";

  const Points3 board = points_in_board(data.board);
  // A view that takes no part has no pose to compare with; in the order as given, a wrong order fits none.
  const auto own_as_given = takes_part(solution.used, std::size_t(view))
                                ? std::nullopt
                                : try_own_pose(data, everything, solution, view, device);
  const auto fits_in_order = [&](const Vec2& flip) {
    const auto rms = rms_in_order(data, everything, solution, view, device, exchanged_order(board, flip));
    return rms && *rms < fits && !(own_as_given && kFarBetter * own_as_given->rms_px < *rms);
  };
  if (fits_in_order(Vec2(-1, -1)))
    return "the order of its points is turned by 180 degrees in " + name +
           "; keep the board the same way up in all views";
  if (fits_in_order(Vec2(-1, 1)) || fits_in_order(Vec2(1, -1)))
    return "the order of its points is mirrored in " + name +
           "; switch the mirroring of camera and projector off, and capture the view again";

  if (const auto own = try_own_pose(data, everything, solution, view, device);
      own && own->rms_px < explained) {
    const Pose motion = own->rig_from_board * solution.state().rig_from_board[std::size_t(view)].inverse();
    if (takes_part(solution.used, std::size_t(view)) && may_have_moved(motion))
      return "the board, or the " + name + ", moved by " + amount(motion) +
             (projects ? " between the camera's picture and the patterns, or a lens"
                       : " between the cameras' pictures, or a lens") +
             " was zoomed or refocused; hold it "
             "still, leave the lenses alone, and capture the view again";
  }
  return std::nullopt;
}

std::string unexplained_disagreement(const std::string& device) {
  return "its points are not where this board would have them in " + device +
         ": another board, a lens that was zoomed or refocused, an image that was rotated, mirrored or cut, or frames of "
         "another capture";
}

}  // namespace

std::string cause_of_disagreement(const Correspondences& data, const UsedMask& everything,
                                  const Solution& solution, int view, int device) {
  const auto explained = explained_disagreement(data, everything, solution, view, device);
  return explained ? *explained : unexplained_disagreement(data.devices[std::size_t(device)].name);
}

bool agrees_with_camera(const Correspondences& data, const UsedMask& everything, const Solution& all,
                        const Correspondences& other_data, const Solution& others, std::size_t view) {
  constexpr double kAgrees = 2;
  const int camera = posing_camera(data, all.used, view);
  if (camera < 0) return false;
  Solution of_others = others;
  of_others.bundle.state.rig_from_board[view] = all.state().rig_from_board[view];
  const auto own = try_own_pose(data, everything, of_others, int(view), camera);
  return own && own->rms_px < kAgrees * usual_rms(other_data, others, camera);
}

std::vector<ForeignView> views_of_another_capture(const Correspondences& data, const UsedMask& everything,
                                                  const Solution& solution) {
  std::vector<ForeignView> foreign;
  std::size_t views = 0;
  for (std::size_t v = 0; v < data.views.size(); ++v) {
    if (!takes_part(solution.used, v)) continue;
    ++views;
    const int camera = posing_camera(data, solution.used, v);
    // Two cameras that agree on a view are right about it.
    if (camera < 0 || posing_camera(data, solution.used, v, camera) >= 0) continue;
    for (std::size_t d = 0; d < data.devices.size(); ++d) {
      if (data.devices[d].kind != DeviceKind::kProjector || !solution.rejected[v][d]) continue;
      if (explained_disagreement(data, everything, solution, int(v), int(d))) break;
      foreign.push_back({v, unexplained_disagreement(data.devices[d].name)});
      break;
    }
  }
  // Of many, nobody knows which are of the same capture.
  constexpr std::size_t kMaxShare = 3;
  if (kMaxShare * foreign.size() > views) foreign.clear();
  return foreign;
}

namespace {

/// One change of the device for all of its views in the mask: the boards stay with the cameras. A change of its
/// own for each view would fit anything, and is poorly constrained by one board. nullopt where the fit fails.
std::optional<BundleState> with_change(const Correspondences& data, const UsedMask& mask,
                                       const Solution& solution, std::size_t device, bool of_lens) {
  BundleOptions options = hold_devices(solution.options, solution.state());
  if (of_lens)
    for (const char* parameter : {"fx", "fy", "cx", "cy"})
      options.held[device].erase(
          std::remove(options.held[device].begin(), options.held[device].end(), parameter),
          options.held[device].end());
  else
    options.hold_pose[device] = false;
  try {
    return bundle_adjust(data, mask, solution.state(), options).state;
  } catch (const Error&) {
    return std::nullopt;
  }
}

/// (g, x, y) of costs/image_change.hpp.
Vec3 image_change_between(const Intrinsics& before, const Intrinsics& after) {
  return {0.5 * (after.fx / before.fx + after.fy / before.fy) - 1, after.cx - before.cx,
          after.cy - before.cy};
}

}  // namespace

std::optional<ChangedDevice> changed_device(const Correspondences& data, const UsedMask& everything,
                                            const Solution& solution, int device) {
  if (device == 0) return std::nullopt;
  const auto d = std::size_t(device);
  UsedMask changed = only_view(solution.used, data.views.size());  // no view yet
  int views = 0;
  std::string names;
  for (std::size_t v = 0; v < data.views.size(); ++v) {
    if (!solution.rejected[v][d] || !takes_part(solution.used, v)) continue;
    if (data.views[v].observations[d].size() < 6) continue;
    changed[v] = solution.used[v];
    changed[v][d] = everything[v][d];
    ++views;
    names += (names.empty() ? "" : ", ") + data.views[v].name;
  }
  if (views < 2) return std::nullopt;
  const auto moved = with_change(data, changed, solution, d, false);
  const auto zoomed = with_change(data, changed, solution, d, true);
  const auto rms = [&](const std::optional<BundleState>& state) {
    return state ? spread_of(data, *state, changed, device).rms_px : std::numeric_limits<double>::infinity();
  };
  const double explained = kExplained * usual_rms(data, solution, device);
  if (std::min(rms(zoomed), rms(moved)) > explained) return std::nullopt;
  const std::string& name = data.devices[d].name;
  if (rms(zoomed) < rms(moved)) {
    const Vec3 change =
        image_change_between(solution.state().lenses[d].intrinsics, zoomed->lenses[d].intrinsics);
    if (is_zoom(change, data.devices[d].size))
      return ChangedDevice{true, name + " has another lens in views " + names + " (" +
                                     image_change_in_words(change) +
                                     "): it was zoomed or refocused; fix zoom and focus and capture these "
                                     "views again"};
    if (rms(moved) > explained) return std::nullopt;
  }
  const Pose motion = moved->device_from_rig[d] * solution.state().device_from_rig[d].inverse();
  if (!may_have_moved(motion)) return std::nullopt;
  return ChangedDevice{
      false, name + " stands elsewhere in views " + names + ", by " + amount(motion) +
                 ": it was moved against the camera, or its lens was shifted; fix both to each other "
                 "and capture these views again"};
}

namespace {

/// Where a projector's light should be in one view, and what remains there.
struct ViewResiduals {
  Points2 places, residuals;
};

/// Without the polynomial of second degree in the place that explains most of them: a board or lens elsewhere in this
/// view changes all of its points alike, and that repeats at no pixel.
void remove_trend(ViewResiduals& of) {
  constexpr int kTerms = 6;
  if (of.places.size() < 2 * kTerms) {
    of = {};
    return;
  }
  Vec2 middle = Vec2::Zero();
  for (const Vec2& p : of.places) middle += p / double(of.places.size());
  Eigen::MatrixXd terms(Eigen::Index(of.places.size()), kTerms);
  Eigen::MatrixXd values(Eigen::Index(of.places.size()), 2);
  for (std::size_t i = 0; i < of.places.size(); ++i) {
    const Vec2 d = (of.places[i] - middle) / 100;
    terms.row(Eigen::Index(i)) << 1, d.x(), d.y(), d.x() * d.x(), d.x() * d.y(), d.y() * d.y();
    values.row(Eigen::Index(i)) = of.residuals[i].transpose();
  }
  const Eigen::MatrixXd left = values - terms * terms.colPivHouseholderQr().solve(values);
  for (std::size_t i = 0; i < of.places.size(); ++i) of.residuals[i] = left.row(Eigen::Index(i)).transpose();
}

}  // namespace

std::string resampled_picture(const Correspondences& data, const Solution& solution, int device) {
  const Device& projector = data.devices[std::size_t(device)];
  // Less than this is not worth a remark, and the search costs as much as the solve.
  constexpr double kWorthLooking = 0.08;
  if (projector.kind != DeviceKind::kProjector ||
      solution.options.noise[std::size_t(device)].floor_px < kWorthLooking)
    return "";
  std::vector<ViewResiduals> views(data.views.size());
  Vec2 whole_power = Vec2::Zero();
  for (std::size_t v = 0; v < data.views.size(); ++v) {
    for (const Measurement& m : measurements_of(data, int(v), device)) {
      if (!solution.used[v][std::size_t(device)][std::size_t(m.index)]) continue;
      // Points of a projected board lie on a grid, where one period cannot be told from others and from a lens's trend.
      if (m.light != nullptr) continue;
      const auto r = reprojection_residual(solution.state(), m);
      if (!r) continue;
      // Where the light should be: what was read may lie on a grid of its own.
      views[v].places.push_back(m.pixel() + *r);
      views[v].residuals.push_back(*r);
      whole_power += r->cwiseAbs2();
    }
    remove_trend(views[v]);
  }
  for (const int axis : {0, 1}) {
    std::vector<std::pair<double, double>> residual_at;
    double power = 0;
    for (const ViewResiduals& view : views)
      for (std::size_t i = 0; i < view.places.size(); ++i) {
        residual_at.emplace_back(view.places[i][axis], view.residuals[i][axis]);
        power += view.residuals[i][axis] * view.residuals[i][axis];
      }
    // N. Lomb, "Least-squares frequency analysis of unequally spaced data", 1976: under noise alone
    // |sum r e^{i 2 pi f x}|^2 / sum r^2 is exponential with mean one. Periods from 2.2 to 40 pixels; what
    // lenses do is longer.
    const double span = axis == 0 ? projector.size.width : projector.size.height;
    constexpr double kChance = 1e-6, kShortest = 2.2, kLongest = 40;
    const double step = 0.5 / span, frequencies = (1 / kShortest - 1 / kLongest) / step;
    double strongest = 0, period = 0;
    for (double f = 1 / kLongest; f < 1 / kShortest; f += step) {
      double c = 0, s = 0;
      for (const auto& [x, r] : residual_at) {
        c += r * std::cos(2 * 3.14159265358979323846 * f * x);
        s += r * std::sin(2 * 3.14159265358979323846 * f * x);
      }
      if (c * c + s * s > strongest) strongest = c * c + s * s, period = 1 / f;
    }
    if (residual_at.size() < 50 || frequencies * std::exp(-strongest / power) > kChance) continue;
    // What repeats is the cause only where it is a good part of what does not fit.
    constexpr double kPart = 0.1;
    if (2 * strongest / double(residual_at.size()) < kPart * whole_power[axis]) continue;
    char text[200];
    std::snprintf(
        text, sizeof text,
        "%s's residuals repeat every %.1f pixels along its %s: its picture is scaled on the way to the "
        "light; send its native resolution, with keystone and overscan off",
        projector.name.c_str(), period, axis == 0 ? "rows" : "columns");
    return text;
  }
  return "";
}

}  // namespace procam::calibrate
