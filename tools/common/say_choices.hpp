#pragma once
/// What a calibration chose among, and what it would do next, in words and in the summary.
#include <optional>

#include "common/cli.hpp"
#include "procam/analyze/advice.hpp"
#include "procam/calibrate/result.hpp"

namespace procam::tools {

/// The lens models that were tried, device by device; `wall` is of no use without a projector.
void say_lens_models(Console& console, const calibrate::CalibrationResult& result, double wall);

/// What is wrong with each view that is not fine, and which to add; `located` is the error it reduces.
void say_views(Console& console, const calibrate::CalibrationResult& result,
               const std::optional<analyze::NextView>& next, analyze::SurfaceLocated located);

/// The shape of a board that is not flat.
void say_board_shape(Console& console, const calibrate::CalibrationResult& result);

/// The measurement of the board that images cannot replace.
void say_size_to_measure(Console& console, const calibrate::CalibrationResult& result);

}  // namespace procam::tools
