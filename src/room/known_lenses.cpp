/// Known lenses of a room's cameras: does the light agree with them, and what do they leave uncertain?
#include <algorithm>
#include <cmath>

#include "procam/core/base/words.hpp"
#include "route.hpp"

namespace procam::room {

std::vector<char> Route::known_lenses(bool unstated) const {
  std::vector<char> chosen(plan_.lenses.size(), 0);
  for (std::size_t lens = 0; lens < chosen.size(); ++lens)
    chosen[lens] = !plan_.guess[lens] && (plan_.unstated[lens] != 0) == unstated;
  return chosen;
}

std::string Route::disagreement_words(const LensDisagreement& disagrees) const {
  const Camera& known = plan_.lenses[std::size_t(disagrees.lens)];
  const double corner = known.intrinsics.normalized_from_pixel(Vec2(-0.5, -0.5)).squaredNorm();
  const int i = disagrees.parameter;
  const double unit = i < 4 ? 1 : known.intrinsics.fx * std::pow(corner, i == 5 ? 1.5 : 2.5);
  return "camera '" + points_.cameras[std::size_t(disagrees.lens)].name +
         "': the light of the room puts its " +
         (i == 0   ? "focal length "
          : i == 2 ? "principal point (x) "
          : i == 3 ? "principal point (y) "
                   : "distortion in the corner ") +
         fixed(disagrees.off * unit, 1) + " px (+-" + significant(disagrees.sigma * unit, 2) +
         ") from the known lens";
}

bool Route::check_sheets() {
  std::vector<char> chosen(plan_.lenses.size(), 0);
  for (std::size_t p = 0; p < points_.projectors.size(); ++p)
    chosen[points_.cameras.size() + p] = options_.projectors.count(points_.projectors[p].name) > 0;
  const auto departs = departure(plan_, state_, chosen);
  if (!departs) return true;
  const auto lens = std::size_t(departs->lens);
  const std::string& name = points_.projectors[lens - points_.cameras.size()].name;
  const Camera& given = plan_.lenses[lens];
  const bool is_focal = departs->parameter == 0;
  const double unit = 1.0 / (departs->parameter == 3 ? given.size.height : given.size.width);
  result_.diagnostics.fail(
      "sheet_disagrees", "projector '" + name + "': the light puts its " +
                             (is_focal                  ? "throw ratio "
                              : departs->parameter == 2 ? "lens shift (x) "
                                                        : "lens shift (y) ") +
                             format("%+.3f", departs->off * unit) + " (+-" +
                             significant(departs->sigma * unit, 2) +
                             ") from the stated one; check the data sheet and the zoom, " +
                             (is_focal ? "the throw ratio is the distance over the picture's width"
                                       : "a lens shift is a share of the whole picture's width and height") +
                             ", or state neither");
  return false;
}

void Route::check_stated_lenses() {
  const std::vector<char> stated = known_lenses(false);
  if (!any(stated)) return;
  const char* const kNext = "; check that --known-camera is this camera at this zoom, focus and resolution";
  if (const auto departs = departure(plan_, state_, stated)) {
    result_.diagnostics.fail("known_lens_disagrees", disagreement_words(*departs) + kNext);
    return;
  }
  if (positions() < 2 || result_.planar) return;
  const FreedRig rig =
      free_lenses(points_, widened(plan_, stated), stated, state_, in_use(), options_.threads);
  const auto disagrees = disagreement(plan_, rig, stated);
  if (!disagrees) return;
  if (disagrees->is_certain()) {
    result_.diagnostics.fail("known_lens_disagrees", disagreement_words(*disagrees) + kNext);
    return;
  }
  doubt_ = disagreement_words(*disagrees);
  covariance_ = kept_covariance(rig, state_);
  layout_ = rig.layout;
}

void Route::check_unstated_lenses() {
  const std::vector<char> unstated = known_lenses(true);
  if (!any(unstated)) return;
  const double by_given = result_.wall_sigma;
  const LensPlan wide = widened(plan_, unstated);
  const bool trusted = positions() > 1 && !result_.planar;
  const FreedRig rig = trusted ? free_lenses(points_, wide, unstated, state_, in_use(), options_.threads)
                               : open_lenses(points_, wide, state_, in_use(), options_.threads);
  auto disagrees = trusted ? disagreement(plan_, rig, unstated) : std::nullopt;
  if (disagrees && !disagrees->is_certain()) disagrees.reset();  // the deviations hold it
  std::string words;
  if (disagrees) {
    words = disagreement_words(*disagrees);
    plan_ = wide;
    state_ = rig.state;
    result_.outliers = result_.points = 0;
    reject();
    fit_without_loss();
    check_fit();
    find_covariance();
    result_.diagnostics.warn("known_lens_disagrees",
                             words +
                                 ", of which no deviation is stated: the light's own estimate is in use; "
                                 "calibrate the camera by calibrate-camera for a more certain result");
  } else {
    covariance_ =
        trusted ? kept_covariance(rig, state_) : considered_covariance(wide, rig, layout_, covariance_);
    layout_ = rig.layout;
  }
  find_scale();
  measure_walls();
  if (disagrees) return refuse_uncertain(words);
  constexpr double kMaterial = 2;
  if (!(result_.wall_sigma > kMaterial * by_given)) return;
  words =
      "no deviation is stated of a known camera's lens, and the light determines it no better: taken as a data "
      "sheet's (10 % of the focal length), it leaves the walls uncertain by " +
      mm(result_.wall_sigma) + ", as an exact lens by " + mm(by_given) +
      "; give a calibrate-camera result, or --lens-sigma";
  if (result_.wall_sigma_share < options_.max_wall_sigma)
    result_.diagnostics.note("lens_unchecked", words);
  else
    result_.diagnostics.warn("lens_unchecked", words);
}

}  // namespace procam::room
