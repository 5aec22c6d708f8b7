#pragma once
/// How far a simulated session departs from what calibration assumes: lenses with more terms, a camera with a
/// response curve, scattered light, defocus, and mistakes in single views.
///
///   Conditions conditions = level_conditions(Level::kPaper);   // session.hpp
///   conditions.glare = 0;                                      // a study of one factor
///   SimulatedSession session = make_session(Level::kPaper, 7, {}, {}, conditions);
///
/// The seed draws from every range; a range of one value fixes it. plain_conditions() have none of these
/// effects.
#include <optional>
#include <string>

#include "procam/core/base/export.hpp"
#include "procam/core/geometry/pose.hpp"
#include "procam/core/rig/decoded_map.hpp"

namespace procam::simulate {

struct Range {
  double low = 0, high = 0;
  bool either_sign = false;  ///< low .. high or -high .. -low
};

struct Conditions {
  // Lenses; none: as in the level's recipe.
  std::optional<Range> camera_skew_px, projector_skew_px;  ///< K(0, 1)
  std::optional<Range> camera_k3, projector_k3;            ///< of the Brown-Conrady lens
  /// What the true lenses do beyond their models, RMS over the picture (lens_deviation.hpp), of sessions with boards.
  double camera_deviation_px = 0, projector_deviation_px = 0;

  // Light and sensor (capture.hpp).
  Range gamma{1, 1};      ///< of the camera
  double vignetting = 0;  ///< power of the cosine of the field angle
  double indirect = 0;    ///< light that surfaces reflect onto each other, share of the mean light around
  double glare = 0;       ///< light that the camera's lens scatters over its image, share
  /// Contrast of projected stripes of two pixels (Gray code's finest) where the projector is most out of
  /// focus within the level's working distances: (max - min) / (max + min). 1: in focus everywhere.
  double finest_contrast = 1;
  std::optional<NoiseModel> noise;  ///< of the linear grey value; none: as in the level's recipe
  double noise_factor = 1;          ///< on the standard deviation of the noise

  /// The sensor has colour filters, two of four pixels green: captures of three channels, each interpolated.
  bool colour_sensor = false;
  double lateral_colour = 0;  ///< share by which blue is larger than green; needs a colour sensor

  double projector_gamma = 1;  ///< of the projector: light = value^gamma; 1: linear
  /// 1: the lamp follows the mean of the frame (dynamic contrast, automatic iris); less: this power of it.
  double iris = 0;

  // Views.
  int views = 0;            ///< 0: as in the level's recipe
  int dark_views = 0;       ///< underexposed ones
  Range white{0.22, 0.35};  ///< their white paper, share of full scale in linear light
  int overexposed_views = 0;
  double overexposure = 1.6;     ///< their white paper, as a multiple of full scale
  int moved_views = 0;           ///< the board moves once during the sequence
  Range moved_by{0.003, 0.015};  ///< metres; it rotates by 0.1 degrees a millimetre as well
  int stale_views = 0;           ///< one capture still shows the frame before
  int missing_views = 0;         ///< one frame is missing, so that all later captures show the next frame
  int torn_views = 0;            ///< one capture shows the next frame in its lower rows

  // Faults of every view's sequence; 0: none.
  double auto_exposure = 0;       ///< 1: the exposure keeps the image's mean; less: this power of it
  double flicker = 0;             ///< amplitude over the rows, and from frame to frame
  double shake_px = 0;            ///< sigma of each frame's shift, an axis
  double drift_px = 0;            ///< of the camera's image over the sequence (stabiliser, soft tripod)
  double projector_drift_px = 0;  ///< of the projected frame over the sequence, projector pixels
  double focus_drift_px = 0;      ///< sigma of the camera's blur at the start, none at the end
  double lag = 0;                 ///< share of the light before that each capture still shows
  double spot = 0;                ///< reflection of a lamp on the board, multiple of full scale

  /// Metres by which the sheet rises half a metre from the print's middle, like a cylinder about an axis of any direction
  /// (core/geometry/bent_sheet.hpp).
  Range bend{0, 0, true};
  double flex = 0;  ///< RMS of the rise that the sheet has anew in each view, as `bend`, metres
  /// The camera focuses anew in each view, or a stabiliser displaces its image: RMS of the change of its focal length, as a share,
  /// and of the displacement, an axis.
  double refocus = 0, stabiliser_px = 0;
  double print_scale = 1;  ///< true size of the print / size that the session states
};

/// None of these effects: a linear camera without scattered light, lenses and views as in the recipe.
inline Conditions plain_conditions() {
  return {};
}

/// What is wrong with one view.
struct ViewDefects {
  std::optional<double> white;  ///< share of full scale of the brightest corner of the sheet, linear light
  /// At `share` of the sequence, 0 .. 1, the board moves to rig_from_board * board_from_moved.
  struct Move {
    double share = 0.5;
    Pose board_from_moved;
  };
  std::optional<Move> moved;
  std::optional<double> stale, missing, torn;  ///< at this share of the sequence

  bool empty() const { return !white && !moved && !stale && !missing && !torn; }
};

/// The frame at a share of a sequence, 1 .. frames - 1; 0 for a single frame.
PROCAM_EXPORT int frame_at(double share, int frames);

/// "white at 27 % of full scale, board moved by 7.1 mm before frame 12"; empty for none.
PROCAM_EXPORT std::string description(const ViewDefects& defects, int frames);

}  // namespace procam::simulate
