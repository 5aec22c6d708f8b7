#pragma once
/// The pictures of the report: each a <figure> with inline SVG and a caption that says what to look for.
#include <optional>
#include <string>
#include <vector>

#include "procam/analyze/advice.hpp"
#include "procam/analyze/light_error.hpp"
#include "procam/analyze/prediction.hpp"
#include "procam/calibrate/result.hpp"
#include "procam/core/rig/view_image.hpp"

namespace procam::report {

/// One colour a view, the same in every picture and in the table of views.
std::string view_color(int view);

/// All residuals of a device about zero, with rings at 1, 2, 3 sigma; outliers stay, as crosses.
std::string residual_scatter(const calibrate::CalibrationResult& result, int device);

/// Where a device was observed, over its picture's outline; cells nobody saw are tinted. `next` is where the
/// board should come next.
std::string coverage(const calibrate::CalibrationResult& result, const Correspondences& correspondences,
                     int device, const std::optional<analyze::NextView>& next);

/// Residuals as magnified lines at their pixels: all views over each other, then one picture a view.
std::string residual_quivers(const calibrate::CalibrationResult& result, int device);

/// The RMS residual of each view in a device as bars, largest first; rejected views, those far above the median and
/// those that lost many points are coloured.
std::string view_bars(const calibrate::CalibrationResult& result, int device);

/// The predicted errors on a wall over the projector's frame, pixel by pixel, with their RMS in the caption. Nothing
/// without a covariance.
std::string error_maps(const Rig& rig, const std::vector<analyze::LightErrors>& predicted);

/// At most twelve images of the views with found, projected and rejected points, rejected views first, then by RMS.
/// Nothing without images.
std::string view_captures(const calibrate::CalibrationResult& result, const Correspondences& data,
                          const std::vector<ViewImage>& images);

/// Maps of what differs from an earlier rig: the light on a wall so many metres away, and each lens; by devices of the
/// same name and size.
std::string rig_change(const Rig& rig, const Rig& earlier, double wall);

/// How the board's points lie off their printed places: discs for out of the plane, magnified lines for along
/// it. Nothing for a board that was taken as printed.
std::string board_shape(const calibrate::CalibrationResult& result, const Board& board);

/// The correlations of the covariance's parameters as a coloured lower triangle, with names. Nothing for less than two
/// parameters or more than 80.
std::string correlation_matrix(const NamedCovariance& covariance);

/// Residual::whitened of a device, x and y, with the normal curve. Nothing without residuals.
std::string residual_histogram(const calibrate::CalibrationResult& result, int device);

/// How a lens displaces a regular grid, magnified, with arrows. Nothing for a lens without distortion.
std::string lens_distortion(const Camera& lens, const std::string& name);

/// The lens models that were tried, as bars of their error on held-out views. Nothing when none were.
std::string lens_alternatives(const calibrate::CalibrationResult& result);

/// The rig and the boards in space, projected along a fixed direction; the page's script turns it. `next` is
/// where the board should come next.
std::string rig_in_space(const calibrate::CalibrationResult& result, const Board& board,
                         const std::optional<analyze::NextView>& next);

/// A flat thing in space.
struct SpaceOutline {
  std::string name;
  Points3 corners_in_rig;
  std::string color;
};

/// The rig and what it projects on, in the same way. Nothing when there is no device or no outline. `caption`
/// is HTML. One picture of this kind a page.
std::string surfaces_in_space(const Rig& rig, const std::vector<SpaceOutline>& outlines,
                              const std::string& caption);

/// Of a report page: each cause with what it does alone and what is left without it.
std::string cause_table(const std::vector<analyze::Cause>& causes);

}  // namespace procam::report
