#include "consistency.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "procam/core/base/stats.hpp"
#include "procam/core/base/words.hpp"

namespace procam::scan {
namespace {

constexpr double kMedianOfNoise = 0.67448975;  // of |N(0, 1)|
// The noise itself may be off by this factor: calibrated rigs have 0.6 to 1.8 of it, the most with phase shift.
constexpr double kNoiseFactor = 2;
// Only the error across the epipolar line is seen, and the depth's comes from that along it. A rotation or a shift along the
// base line moves light along the line about twice as far as across it, where the base line is 20 to 25 degrees oblique.
constexpr double kAlongOverAcross = 2;
// The check fails above all of these. Correct rigs have 0.1 px and 0.6 sigmas; the rig's covariance is one draw, hence four of it.
constexpr double kFailPx = 1, kFailSigmas = 10, kFailOfRig = 4;
// Of the projector frame's diagonal: no bump moves a device so far.
constexpr double kNothingFits = 0.02;
constexpr double kMuchBetter = 0.2;  // of the inconsistency: the images were changed
constexpr int kSampleStep = 4;       // pixels between those that a changed image is tried at

const char* const kCauses =
    "a rig that was bumped since its calibration, a rig of another session, or a camera that moved during the frames";

std::string projector_pixels(double px) {
  return format(px < 10 ? "%.2g projector pixels" : "%.0f projector pixels", px);
}

/// Median of what is left in projector pixels, where pixel (x, y) was pixel (w - 1 - x, y), (x, h - 1 - y) or both. Infinite where
/// most of the light would come from behind a device.
double median_left(const LightMap& light, const DepthSolver& solver, const ImageF& rays, bool flip_x,
                   bool flip_y) {
  std::vector<double> left;
  for (int y = 0; y < rays.height(); y += kSampleStep)
    for (int x = 0; x < rays.width(); x += kSampleStep) {
      if (!light.decoded(x, y)) continue;
      const int i = flip_x ? rays.width() - 1 - x : x, j = flip_y ? rays.height() - 1 - y : y;
      const Depth depth =
          solver.solve(rays.at(i, j, 0), rays.at(i, j, 1), light.pixel.at(x, y, 0), light.pixel.at(x, y, 1),
                       light.sigma.at(x, y, 0), light.sigma.at(x, y, 1));
      left.push_back(depth.z > 0 ? depth.left_px : std::numeric_limits<double>::max());
    }
  return left.empty() ? std::numeric_limits<double>::max() : median(left);
}

[[noreturn]] void refuse_misfit(const Scan& scan, const std::string& change) {
  const std::string why = "columns and rows of the light miss the camera's rays by " +
                          projector_pixels(scan.consistency_px) + ": captures and rig do not belong together";
  if (!change.empty())
    throw Error(ErrorKind::kNotEnoughData, "scan",
                why + ", but they fit when the camera's images are " + change,
                "give the images as the camera had them at the calibration");
  throw Error(ErrorKind::kNotEnoughData, "scan", why,
              std::string("use the rig of these devices in these positions; the usual causes are ") +
                  kCauses + ", and images that were cropped or changed since the calibration");
}

}  // namespace

void measure_consistency(const RawDepths& raw, Scan& scan) {
  std::vector<float> left;
  double squares = 0;
  for (int y = 0; y < scan.depth.height(); ++y)
    for (int x = 0; x < scan.depth.width(); ++x)
      if (scan.depth.at(x, y) > 0) left.push_back(raw.left.at(x, y));
  if (left.empty()) return;
  const double median = quantile(left, 0.5);
  scan.consistency = median / kMedianOfNoise;
  // Over those that are not far off, so that wrongly decoded pixels do not hide the rig.
  std::size_t counted = 0;
  for (int y = 0; y < scan.depth.height(); ++y)
    for (int x = 0; x < scan.depth.width(); ++x)
      if (scan.depth.at(x, y) > 0 && raw.left.at(x, y) <= 4 * median) {
        squares += double(raw.left_px.at(x, y)) * double(raw.left_px.at(x, y));
        ++counted;
      }
  scan.consistency_px = std::sqrt(squares / double(std::max<std::size_t>(counted, 1)));
}

void set_misfit_sigma(const RawDepths& raw, Scan& scan) {
  const double noise = scan.consistency_px * kNoiseFactor / std::max(scan.consistency, 1e-9);
  const double squares = scan.consistency_px * scan.consistency_px - noise * noise -
                         scan.consistency_px_of_rig * scan.consistency_px_of_rig;
  if (!(squares > 0)) return;
  const double along = kAlongOverAcross * std::sqrt(squares);
  scan.misfit_sigma = ImageF(scan.depth.size());
  for (int y = 0; y < scan.depth.height(); ++y)
    for (int x = 0; x < scan.depth.width(); ++x)
      if (scan.measured(x, y)) scan.misfit_sigma.at(x, y) = float(along * double(raw.by_px.at(x, y)));
}

void check_consistency(const LightMap& light, const DepthSolver& solver, const ImageF& rays, Scan& scan) {
  const bool fails = scan.consistency_px > kFailPx && scan.consistency > kFailSigmas &&
                     scan.consistency_px > kFailOfRig * scan.consistency_px_of_rig;
  const double frame = std::hypot(light.projector_size.width, light.projector_size.height);
  if (fails && scan.consistency_px > kNothingFits * frame)
    refuse_misfit(scan, image_change(light, solver, rays));
  const std::string miss = "columns and rows of the light miss the camera's rays by " +
                           projector_pixels(scan.consistency_px) +
                           format(" (%.0f times their noise)", scan.consistency);
  if (fails)
    scan.diagnostics.fail(
        "rig_inconsistent",
        miss + ": " + kCauses + "; calibrate again, or capture again with all devices fixed");
  else if (scan.consistency > 3 && scan.consistency_px > 0.3 && !scan.misfit_sigma.empty())
    scan.diagnostics.warn(
        "rig_inconsistent",
        miss +
            ": the rig has moved since its calibration, or its lenses are wrong; the standard "
            "deviations are larger by that, calibrate it again");
}

std::string image_change(const LightMap& light, const DepthSolver& solver, const ImageF& rays) {
  struct Change {
    bool flip_x, flip_y;
    const char* words;
  };
  constexpr Change kChanges[] = {{true, false, "mirrored left to right"},
                                 {false, true, "mirrored top to bottom"},
                                 {true, true, "rotated by 180 degrees"}};
  const double frame = std::hypot(light.projector_size.width, light.projector_size.height);
  double limit = kMuchBetter * std::min(median_left(light, solver, rays, false, false), frame);
  std::string best;
  for (const Change& change : kChanges) {
    const double left = median_left(light, solver, rays, change.flip_x, change.flip_y);
    if (left >= std::min(limit, 0.5 * kNothingFits * frame)) continue;
    limit = left;
    best = change.words;
  }
  return best;
}

}  // namespace procam::scan
