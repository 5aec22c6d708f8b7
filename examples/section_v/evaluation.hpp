#pragma once
/// The experiment with a sheet of paper: where do its four corners land when they are projected on it?
///
/// A sheet stands at a known distance and angle, its corners are projected, and somebody measures where each
/// lands on it. Repeated over placements that gives the table of the original system: the physical corner,
/// the median of the projected ones, their standard deviation, and the distance of the two.
///
/// The sheet's frame: origin in its middle, x to the right, y down, z into it, metres.
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "procam/analyze/landing_error.hpp"
#include "procam/analyze/prediction.hpp"

namespace procam::section_v {

struct Sheet {
  std::string name;
  Vec2 size = Vec2::Zero();  ///< metres, width and height
  double incidence_deg = 0;  ///< of the light that meets its middle
};

/// Clockwise from the top left.
std::array<Vec2, 4> sheet_corners(const Sheet& sheet);

struct Landing {
  int corner = 0;                                  ///< 0 top left, 1 top right, 2 bottom right, 3 bottom left
  Vec2 physical = Vec2::Zero();                    ///< where the corner is, metres on the sheet
  Vec2 projected = Vec2::Zero();                   ///< where its light landed
  std::optional<analyze::LandingError> predicted;  ///< what the calibration and the pose promised
};

/// One position of one sheet.
struct SheetPlacement {
  int sheet = 0;
  double distance = 0;        ///< from the projector to the sheet's middle, metres
  Pose projector_from_sheet;  ///< as it truly is, or as good as it was measured
  std::vector<Landing> landings;
};

/// A sheet whose middle is lit by `pixel`, at that distance along the light, turned about the picture's
/// vertical so that the light meets it at its angle (`to_right`: its right edge is the far one), then in its
/// own plane by `roll` radians. Throws std::invalid_argument for a pixel that the lens does not know or an
/// angle outside [0, 90) degrees.
Pose place_sheet(const Projector& projector, const Sheet& sheet, const Vec2& pixel, double distance,
                 bool to_right, double roll);

/// The sheets of the original: 20.2 x 21.1 cm at 47 degrees, 14.85 x 21.1 cm at 60.
std::vector<Sheet> original_sheets();
/// A sheet of the original's larger size at another angle, of its own at 47 and 60 degrees.
Sheet sheet_at(double incidence_deg);

/// Which sheets stand where. The defaults are those of the original.
struct SheetLayout {
  std::vector<Sheet> sheets = original_sheets();
  int placements = 11;                              ///< of each sheet
  std::vector<double> distances = {1.2, 1.6, 2.2};  ///< in turn, metres
};

/// Each sheet at the distances in turn, lit from the middle third of the frame, rotated to either side and by up to 5 degrees
/// in its plane. No landings yet. Reproducible by seed.
std::vector<SheetPlacement> draw_placements(const Projector& projector, const SheetLayout& layout,
                                            std::uint64_t seed);

/// One row of the table: a corner over all placements of its sheet. Metres.
struct CornerRow {
  Vec2 physical = Vec2::Zero();
  Vec2 median = Vec2::Zero();              ///< of the projected, each axis
  Vec2 standard_deviation = Vec2::Zero();  ///< each axis, n - 1
  double error = 0;                        ///< |median - physical|
  int count = 0;
};

/// A small turn of all the light about the projector that explains the landings best, in least squares: a
/// wrong rotation of the projector in the rig, or of the rig.
struct LightTurn {
  Vec3 rotation = Vec3::Zero();  ///< in the projector's frame, radians
  double explained = 0;          ///< share of the sum of squared distances that it explains, 0..1
  double rest_mm = 0;            ///< rms distance without it
};

struct SheetEvaluation {
  Sheet sheet;
  std::array<CornerRow, 4> corners;
  int placements = 0, landings = 0;
  double mean_mm = 0, median_mm = 0, rms_mm = 0, worst_mm = 0;  ///< distance of projected from physical
  double predicted_rms_mm = 0;                                  ///< of the same corners; 0: no prediction
  double inside_95 = 0;                ///< share of the landings inside their predicted 95 % regions
  std::vector<analyze::Cause> causes;  ///< of the predicted error, largest first
  double pose_rms_mm = 0;  ///< of the pose's position and rotation together, whose errors are correlated
  std::optional<LightTurn> turn;  ///< nullopt: fewer than three landings
  double mm_per_pixel = 0;  ///< rms over directions and landings: what one pixel of reprojection error is
};

struct Evaluation {
  Rig rig;  ///< for the picture; its first projector is the one of the placements. May be empty
  std::vector<Sheet> sheets;
  std::vector<SheetPlacement> placements;
  std::vector<SheetEvaluation> results;  ///< one a sheet that has landings
};

/// `projector` gives the light's geometry (mm per pixel). Throws Error(kNotEnoughData) when there is no
/// landing, std::invalid_argument for a landing that is not finite or of no sheet or corner.
Evaluation evaluate(const std::vector<Sheet>& sheets, const std::vector<SheetPlacement>& placements,
                    const Projector& projector);

/// A calibration as the original's: each corner's pixel is off by `pixel_rms` (root of the mean squared
/// distance), and all light of a sheet's session is turned by `turn` radians about an axis across the
/// projector's, whose direction is drawn for each session.
struct CrudeCalibration {
  double pixel_rms = 0;
  std::vector<double> turn;  ///< one a sheet
};

/// Fills the landings: where the light of a crude calibration falls. Corners whose light misses the sheet's
/// plane are rejected.
void draw_crude_landings(std::vector<SheetPlacement>& placements, const std::vector<Sheet>& sheets,
                         const Projector& projector, const CrudeCalibration& crude, std::uint64_t seed);

/// The turn that makes the mean distance of a sheet's corners `mean_mm` in the session that
/// draw_crude_landings() draws with that seed, when each pixel is off by `pixel_rms`; 0 when the pixels alone
/// explain more. Bisection up to 5 degrees.
double turn_explaining(const std::vector<SheetPlacement>& placements, const std::vector<Sheet>& sheets,
                       int sheet, const Projector& projector, double pixel_rms, double mean_mm,
                       std::uint64_t seed);

}  // namespace procam::section_v
