#pragma once
/// A calibration for people: the fields of its JSON, the lines of a console, and the report, one HTML page for
/// the person who must decide whether to use the rig.
///
/// The page is complete in itself: no file, font, script or address outside it, so it works from a stick,
/// prints, and can be mailed. It opens with the verdict, the predicted error and what to do, then the checks,
/// the views, figures (inline SVG, captures as JPEG in them) in which wrong views, wrong lenses and thin coverage
/// show, and the parameters with their sigmas. Notes are folded at the end. Everything is readable without script;
/// script only turns the picture of the rig and marks tables that scroll.
#include <optional>
#include <string>
#include <vector>

#include "procam/analyze/accept.hpp"
#include "procam/analyze/advice.hpp"
#include "procam/calibrate/points.hpp"
#include "procam/calibrate/result.hpp"
#include "procam/calibrate/update.hpp"
#include "procam/core/base/export.hpp"
#include "procam/core/rig/view_image.hpp"

namespace procam::report {

/// What a report may hold beyond the calibration itself.
struct ReportInput {
  std::string title = "Projector calibration";
  std::vector<analyze::LightErrors> predicted;  ///< from the covariance, one a distance and projector
  analyze::AcceptedError accepted;              ///< the kind of error that leads the page, and its limit
  std::optional<analyze::NextView> next_view;   ///< drawn and described
  /// Where the true rig is known (a simulated session): the errors by projector, and the parameters.
  std::vector<analyze::LightErrors> truth;
  analyze::WithinTruth within_truth;
  double wall = 2;  ///< metres, for which lens models are compared
  int views = 0;    ///< that were given; 0: as many as the result has
  std::vector<ViewImage>
      images;  ///< of the session's views (SessionContents::view_images); none: no captures drawn
  /// A rig of the same devices from before: what differs is drawn, the light on the wall and each lens.
  std::optional<Rig> earlier;
};

/// What a report about a fresh calibration holds: predicts the errors on a wall, adds their checks to
/// result.rig.quality (a failed one to result.diagnostics), finds the view that reduces the error most, and
/// compares with the true rig where one is given. A rig without projectors gets none of it.
PROCAM_EXPORT ReportInput judge(calibrate::CalibrationResult& result, double wall,
                                const analyze::AcceptedError& accepted,
                                const std::optional<Rig>& truth = std::nullopt);

/// The predicted errors of a rig alone, and their checks.
PROCAM_EXPORT ReportInput judge(const Rig& rig, double wall, const analyze::AcceptedError& accepted,
                                std::vector<Gate>& gates, Diagnostics& diagnostics);

/// Compares with the true rig, on the wall of `input`.
PROCAM_EXPORT void add_truth(const Rig& rig, const Rig& truth, ReportInput& input);

/// The fields of a calibration as JSON text. Figures of one projector stand in "wall", "truth" and at the top; of
/// several, each under its name.
PROCAM_EXPORT std::string to_json(const calibrate::CalibrationResult& result, const ReportInput& input);
/// Of a projector alone, calibrated from points.
PROCAM_EXPORT std::string to_json(const calibrate::PointsResult& result, const ReportInput& input);
/// Of a rig that was refreshed.
PROCAM_EXPORT std::string to_json(const calibrate::UpdateResult& result, const ReportInput& input);
/// Of a rig whose stored numbers were checked.
PROCAM_EXPORT std::string to_json(const Rig& rig, const RigQuality& quality, const ReportInput& input);

/// The first lines of a console: may the rig be used, and its predicted errors.
PROCAM_EXPORT std::vector<std::string> headline(const calibrate::CalibrationResult& result,
                                                const ReportInput& input);
PROCAM_EXPORT std::vector<std::string> headline(const Rig& rig, const RigQuality& quality,
                                                const ReportInput& input);
/// The lines below it.
PROCAM_EXPORT std::vector<std::string> lines(const calibrate::CalibrationResult& result,
                                             const ReportInput& input);
PROCAM_EXPORT std::vector<std::string> lines(const calibrate::PointsResult& result,
                                             const std::vector<PointPair>& pairs, const ReportInput& input);
PROCAM_EXPORT std::vector<std::string> lines(const calibrate::UpdateResult& result, const ReportInput& input);
PROCAM_EXPORT std::vector<std::string> lines(const Rig& rig, const RigQuality& quality);

/// What was found and used of a device.
struct DeviceCounts {
  int views_used = 0, points_found = 0, points_used = 0;
};
PROCAM_EXPORT DeviceCounts device_counts(const calibrate::CalibrationResult& result, int device);

/// The page as UTF-8 text. The same input gives the same text, byte by byte, in every locale; a number that
/// is not finite reads "-". The correspondences are those the result was made from: their board and the views
/// that were rejected are drawn. Throws std::invalid_argument when the two do not belong together.
PROCAM_EXPORT std::string calibration_report(const calibrate::CalibrationResult& result,
                                             const Correspondences& correspondences,
                                             const ReportInput& input = {});

}  // namespace procam::report
