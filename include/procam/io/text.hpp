#pragma once
/// Values as people type them in flags and session files: every length and angle with its unit.
///
/// Parsing throws Error(kInput) that quotes the text and the expected form. What format_x() writes,
/// parse_x() reads back as the same value.
#include <string>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/base/types.hpp"
#include "procam/core/board/board.hpp"
#include "procam/core/rig/observation.hpp"

namespace procam::io {

/// "1024x768": width x height, both positive, at most limits::kImagePixels together.
PROCAM_EXPORT ImageSize parse_size(const std::string& text);
PROCAM_EXPORT std::string format_size(ImageSize size);

/// "25mm", "2.5cm", "0.025m", "1in" -> metres. The unit is required; the length may be negative or
/// zero, and is at most limits::kLengthM.
PROCAM_EXPORT double parse_length(const std::string& text);
PROCAM_EXPORT std::string format_length(double metres);

/// "30deg", "0.5rad" -> radians. The unit is required.
PROCAM_EXPORT double parse_angle(const std::string& text);

/// "3px", "-1.5px" -> pixels. The unit is required.
PROCAM_EXPORT double parse_pixels(const std::string& text);
/// "4%" or "0.04" -> 0.04; any finite number.
PROCAM_EXPORT double parse_share(const std::string& text);

/// "50ms", "0.05s" -> seconds from 0 to limits::kDurationS. The unit is required.
PROCAM_EXPORT double parse_duration(const std::string& text);
/// The same for the delay of a device: at most limits::kDelayS.
PROCAM_EXPORT double parse_delay(const std::string& text);

/// "10mm,0.5deg" -> metres and radians; one of them alone leaves the other 0. None may be negative: these are
/// sigmas.
struct LengthAndAngle {
  double length = 0, angle = 0;
};
PROCAM_EXPORT LengthAndAngle parse_length_and_angle(const std::string& text);
/// "0.5m/s,30deg/s" -> m/s and rad/s, likewise.
PROCAM_EXPORT LengthAndAngle parse_speed(const std::string& text);

/// "0,0,1" -> a unit vector. Throws also for 0,0,0.
PROCAM_EXPORT Vec3 parse_direction(const std::string& text);
/// "0.4m,-120mm,2m" -> metres, each with its unit.
PROCAM_EXPORT Vec3 parse_position(const std::string& text);

/// "1.4" or "1.4+-0.02" -> a value and its standard deviation, zero when it is not stated.
struct Uncertain {
  double value = 0, sigma = 0;
};
PROCAM_EXPORT Uncertain parse_uncertain(const std::string& text);

/// "did you mean 'fx'? known here: fx, fy" for a name that is not among the known ones.
PROCAM_EXPORT std::string suggest(const std::string& name, const std::vector<std::string>& known);

/// How a board's lengths are typed: each with its metric unit, or as projector pixels ("64px"), for boards of
/// light.
enum class BoardUnit { kMetric, kPixel };

/// A board as it is typed:
///   chessboard:7x9:75mm                   7 inner corners a row, 9 rows of them, squares of 75 mm
///   charuco:5x7:40mm:30mm:5x5_100         5 squares a row, 7 rows; square, marker, dictionary
///   charuco:5x6:40mm:30mm:5x5_100:marker-first   the top-left square holds a marker
///   markers:4x5:30mm:8mm:apriltag_36h11   4 markers a row, 5 rows; marker, gap, dictionary
///   circles:7x9:25mm:15mm                 7 circles a row, 9 rows; spacing, diameter
///   asymmetric-circles:4x11:20mm:12mm     staggered; spacing from row to row
/// See docs/boards.md. A board file is read by read_board() (io/board_file.hpp).
PROCAM_EXPORT Board parse_board(const std::string& text, BoardUnit unit = BoardUnit::kMetric);
PROCAM_EXPORT std::string format_board(const Board& board, BoardUnit unit = BoardUnit::kMetric);

/// "1280x1024", the size of the device `kind` ("camera"), or "left=1280x1024", of the one called left. Throws
/// Error(kInput).
PROCAM_EXPORT Device parse_device(const std::string& text, DeviceKind kind);

}  // namespace procam::io
