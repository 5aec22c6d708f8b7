#include "observability.hpp"
#include "procam/core/base/words.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace procam::calibrate {
namespace {

/// The views say little when they leave more than this share of what is known of any lens.
constexpr double kSayLittle = 0.3;
constexpr double kFocalShare = 0.05, kCameraCentreShare = 0.05, kProjectorCentreShare = 0.25;
constexpr double kCornerShare = 0.15, kTangential = 0.005;
/// Spreads below these are what is missing.
constexpr double kEnoughReach = 0.6, kEnoughTiltDeg = 20;

/// What the device saw: how far off its axis, and how far the boards were tilted about their two axes.
struct Seen {
  double reach = 0;               ///< farthest point from the axis, over the farthest corner's distance
  double corner = 1;              ///< that distance, normalised
  double about_vertical_deg = 0;  ///< between the boards that differ most, in the device's frame
  double about_horizontal_deg = 0;
};

Seen seen_by(const Solution& solution, const Correspondences& data, std::size_t device) {
  const BundleState& state = solution.state();
  const Camera& lens = state.lenses[device];
  const auto radius = [&](const Vec2& pixel) { return lens.intrinsics.normalized_from_pixel(pixel).norm(); };
  Seen seen;
  double farthest = 0;
  for (const double x : {-0.5, lens.size.width - 0.5})
    for (const double y : {-0.5, lens.size.height - 0.5}) farthest = std::max(farthest, radius(Vec2(x, y)));
  seen.corner = farthest;
  Vec2 low = Vec2::Constant(90), high = Vec2::Constant(-90);
  for (std::size_t v = 0; v < data.views.size(); ++v) {
    bool used = false;
    for (const Measurement& m : measurements_of(data, int(v), int(device))) {
      if (!solution.used[v][device][std::size_t(m.index)]) continue;
      used = true;
      seen.reach = std::max(seen.reach, radius(m.pixel()) / farthest);
    }
    if (!used) continue;
    const Vec3 n = (state.device_from_rig[device] * state.rig_from_board[v]).rotate(Vec3::UnitZ());
    const Vec2 tilt = Vec2(std::atan2(n.x(), std::abs(n.z())), std::atan2(n.y(), std::abs(n.z()))) / kDegree;
    low = low.cwiseMin(tilt), high = high.cwiseMax(tilt);
  }
  seen.about_vertical_deg = std::max(0.0, high.x() - low.x());
  seen.about_horizontal_deg = std::max(0.0, high.y() - low.y());
  return seen;
}

std::string whole(double value) {
  return format("%.0f", value);
}

/// Distortion coefficients and rotations have none that a reader would expect.
const char* unit_of(const std::string& parameter) {
  const bool is_in_px =
      parameter == "fx" || parameter == "fy" || parameter == "cx" || parameter == "cy" || parameter == "skew";
  return is_in_px ? " px" : "";
}

std::string about_axis(double spread_deg, const std::string& axis) {
  if (spread_deg < kEnoughTiltDeg)
    return "the boards' tilts about the " + axis + " axis differ by " + whole(spread_deg) +
           " degrees only: add views with the board tilted 20 to 40 degrees about its " + axis +
           " axis, both ways";
  return "add closer views, tilted 20 to 40 degrees about the board's " + axis + " axis, both ways";
}

}  // namespace

std::vector<WeaklyObservable> weakly_observable(const Solution& solution, const Correspondences& data,
                                                const NamedCovariance& covariance) {
  std::vector<WeaklyObservable> all;
  for (std::size_t d = 0; d < data.devices.size(); ++d) {
    const Camera& lens = solution.state().lenses[d];
    const Seen seen = seen_by(solution, data, d);
    const double centre =
        data.devices[d].kind == DeviceKind::kCamera ? kCameraCentreShare : kProjectorCentreShare;
    const VecX values = parameters_of(lens);
    const std::vector<std::string> names = parameter_names(lens);
    for (std::size_t i = 0; i < names.size(); ++i) {
      const std::string& name = names[i];
      WeaklyObservable one;
      one.device = int(d);
      one.parameter = name;
      one.sigma = covariance.sigma(data.devices[d].name + "." + name);
      one.distortion = int(i) >= Intrinsics::kNumParameters;
      double beforehand = 0, value = values[Eigen::Index(i)];
      if (name == "fx" || name == "fy") {
        beforehand = kFocalShare * value;
      } else if (name == "cx") {
        beforehand = centre * lens.size.width;
      } else if (name == "cy") {
        beforehand = centre * lens.size.height;
      } else if (name == "p1" || name == "p2") {
        beforehand = kTangential;
      } else if (name == "k1" || name == "k2") {
        beforehand = kCornerShare / std::pow(seen.corner, 2 * (name[1] - '0'));
      } else {
        continue;  // skew, k3 and the further terms of larger models are small or trade off against the
                   // others
      }
      if (!(one.sigma > kSayLittle * beforehand)) continue;
      one.beforehand = {{{name, 1.0}}, one.distortion ? 0 : value, beforehand};
      const bool along_x = name == "fx" || name == "cx" || name == "p2";
      const double tilts = along_x ? seen.about_vertical_deg : seen.about_horizontal_deg;
      // Tangential terms trade off against the principal point where tilts are missing.
      if (name[0] == 'k' || (name[0] == 'p' && tilts >= kEnoughTiltDeg))
        one.motion = seen.reach < kEnoughReach
                         ? "its points reach " + whole(100 * seen.reach) +
                               " % of the way to the image's farthest corner: bring the board to the "
                               "image's edges and corners, and closer"
                         : "add views with the board in the image's corners, and closer";
      else
        one.motion = about_axis(tilts, along_x ? "vertical" : "horizontal");
      all.push_back(one);
    }
  }
  return all;
}

std::vector<std::string> in_words(const std::vector<WeaklyObservable>& parameters,
                                  const Correspondences& data) {
  std::vector<std::string> sentences;
  std::vector<const WeaklyObservable*> left;
  for (const WeaklyObservable& one : parameters) left.push_back(&one);
  while (!left.empty()) {
    const WeaklyObservable first = *left.front();
    std::string names, spreads;
    const auto alike = [&](const WeaklyObservable* other) {
      return other->device == first.device && other->motion == first.motion &&
             other->at_prior == first.at_prior;
    };
    for (const WeaklyObservable* one : left) {
      if (!alike(one)) continue;
      names += (names.empty() ? "" : ", ") + one->parameter;
      spreads += (spreads.empty() ? "" : ", ") + format("%.2g", one->sigma) + unit_of(one->parameter);
    }
    left.erase(std::remove_if(left.begin(), left.end(), alike), left.end());
    const bool is_one = names.find(',') == std::string::npos;
    const std::string& device = data.devices[std::size_t(first.device)].name;
    sentences.push_back(device + " " + names +
                        (first.at_prior
                             ? std::string(is_one ? " is" : " are") +
                                   " not determined by these views and kept near zero (1 sigma = "
                             : std::string(is_one ? " is" : " are") + " poorly constrained (1 sigma = ") +
                        spreads + "): " + first.motion);
  }
  return sentences;
}

std::string in_first_part(const Correspondences& data, const UsedMask& used) {
  constexpr double kPart = 0.6;
  std::string sentences;
  for (std::size_t d = 0; d < data.devices.size(); ++d) {
    const Device& device = data.devices[d];
    if (device.kind != DeviceKind::kProjector) continue;
    Vec2 last = Vec2::Constant(-1);
    for (std::size_t v = 0; v < data.views.size(); ++v)
      for (std::size_t i = 0; i < data.views[v].observations[d].size(); ++i)
        if (used[v][d][i]) last = last.cwiseMax(data.views[v].observations[d][i].pixel);
    if (last.minCoeff() < 0 || last.x() >= kPart * device.size.width ||
        last.y() >= kPart * device.size.height)
      continue;
    sentences +=
        (sentences.empty() ? "" : "; ") +
        format(
            "all of %s's points lie in the first %.0f x %.0f of %d x %d pixels: check the size of its "
            "frame, for a smaller one fits another lens as well; if it is right, light the board with "
            "the other parts, too",
            device.name.c_str(), last.x() + 1, last.y() + 1, device.size.width, device.size.height);
  }
  return sentences;
}

}  // namespace procam::calibrate
