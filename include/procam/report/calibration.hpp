#pragma once
/// The report of a calibration: one HTML page for the person who must decide whether to use the rig.
///
/// The page is complete in itself: no file, font, script or address outside it, so it works from a stick,
/// prints, and can be mailed. It opens with the verdict, the predicted error and what to do, then the checks,
/// the views, figures (inline SVG) in which wrong views, wrong lenses and thin coverage show, and the
/// parameters with their sigmas. Notes are folded at the end. Everything is
/// readable without script; script only turns the picture of the rig.
#include <string>
#include <vector>

#include "procam/analyze/accept.hpp"
#include "procam/analyze/advice.hpp"
#include "procam/calibrate/result.hpp"

namespace procam::report {

/// What a report may hold beyond the calibration itself.
struct ReportInput {
  std::string title = "Projector calibration";
  std::vector<analyze::LightErrors> predicted;  ///< from the covariance, one a distance and projector
  analyze::AcceptedError accepted;              ///< the kind of error that leads the page, and its limit
  std::optional<analyze::NextView> next_view;   ///< drawn and described
  std::vector<analyze::LightErrors> truth;      ///< where the true rig is known (a simulated session)
};

/// The page as UTF-8 text. The same input gives the same text, byte by byte, in every locale; a number that
/// is not finite reads "-". The correspondences are those the result was made from: their board and the views
/// that were rejected are drawn. Throws std::invalid_argument when the two do not belong together.
std::string calibration_report(const calibrate::CalibrationResult& result,
                               const Correspondences& correspondences, const ReportInput& input = {});

}  // namespace procam::report
