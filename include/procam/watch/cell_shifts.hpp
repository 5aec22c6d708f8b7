#pragma once
/// How far the light of ordinary content is from where rig and surfaces predict it, cell by cell of the camera's image.
///
/// The frame on the wall is taken to the camera (light_geometry.hpp) as linear light L, averaged over a working pixel's
/// share. What the camera makes of it is known only roughly: T = (ambient + L)^(1 / gamma), and each cell has a gain and an
/// offset of its own,
///
///   image(x + d) = a T(x) + b + noise.
///
/// Image and T are both smoothed by a binomial filter (sigma 1), so that an unknown blur of the lenses weighs less. d, a, b
/// minimise the squares over the cell, by Gauss-Newton with the derivatives of T, which stay the same in each step (inverse
/// compositional). The information of d is that of the noise that is left,
///
///   a^2 S / (kappa s^2),   S the structure tensor of T orthogonal to T and 1,   kappa = 4 pi: the noise is smooth.
///
/// While content moves, a frame seen later than assumed looks displaced: `by_delay` says by how much a second.
///
/// Sources: prediction of the camera's image from the projected one, without patterns: R. Yang and G. Welch, "Automatic and
/// continuous projector display surface calibration using every-day imagery", WSCG 2001; T. Johnson and H. Fuchs, "Real-time
/// projector tracking on complex geometry using ordinary imagery", ProCams 2007. Alignment: S. Baker and I. Matthews,
/// "Lucas-Kanade 20 years on: a unifying framework", IJCV 56(3), 2004; gain and offset are eliminated linearly.
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/base/image.hpp"
#include "procam/watch/light_geometry.hpp"

namespace procam::watch {

/// The light that the camera sees: (1 - share) of one frame and `share` of the next one, which comes `interval` later. A
/// frame that stands still is given twice.
struct ShownLight {
  ViewU8 frame, next;   ///< projector's size; grey or RGB
  double share = 0;     ///< 0..1
  double interval = 0;  ///< seconds from one to the next; 0: unknown, or the same
};

/// grey ~ (ambient + light)^(1 / gamma), full projected light being 1.
struct CameraTone {
  double gamma = 1, ambient = 0.05;
};

struct CompareOptions {
  CameraTone tone;
  double noise = 2;       ///< standard deviation of a camera pixel, grey levels: the least that is assumed
  double max_shift = 12;  ///< of the search about the start, working pixels
  double max_sigma =
      0.35;  ///< a cell is textured if its better direction can be measured to this, working pixels
  double max_misfit =
      0.45;  ///< residual RMS over the fitted contrast: above it the cell shows something else
  int max_steps = 8;
};

enum class CellState {
  kMeasured,
  kFlat,      ///< the frame has no texture there
  kClipped,   ///< the camera is overexposed there
  kMismatch,  ///< the camera sees something else there: a person, an object; or dimmer light: a shadow, an edge at the border
};

struct CellShift {
  int cell = 0;  ///< in LightGeometry::cells
  CellState state = CellState::kFlat;
  Vec2 shift = Vec2::Zero();        ///< where the light is minus where it was predicted, working pixels
  Mat2 information = Mat2::Zero();  ///< of the shift; one eigenvalue is small where the texture is an edge
  Vec2 by_delay = Vec2::Zero();     ///< apparent shift if the frame was seen a second later than assumed
  double gain = 0, offset = 0;      ///< a, b in grey levels
  double misfit = 0;                ///< residual RMS over the RMS of a T
};

struct ImageComparison {
  std::vector<CellShift> cells;  ///< one for each cell of the geometry
  int textured = 0;              ///< cells that are not flat
  int measured = 0;
  double gain = 0;  ///< over all textured cells, grey levels per unit of T; near 0: the light is not seen
  double correlation = 0;                      ///< of image and prediction there, at the start
  double offset = 0;                           ///< median b of the measured cells
  double image_mean = 0, image_deviation = 0;  ///< grey levels, over lit pixels
  Vec2 start = Vec2::Zero();                   ///< the common shift at which the search began
};

/// `start`: a common shift to begin with. If few cells agree there, a coarse search over +-32 working pixels gives another.
/// Throws std::invalid_argument for images of other sizes than the geometry's.
PROCAM_EXPORT ImageComparison compare(const LightGeometry& geometry, const ShownLight& light, ViewU8 image,
                                      const Vec2& start = Vec2::Zero(), const CompareOptions& options = {});

/// The tone of a few candidates that explains the image best; that of the options without texture.
PROCAM_EXPORT CameraTone fit_tone(const LightGeometry& geometry, const ShownLight& light, ViewU8 image,
                                  const Vec2& start = Vec2::Zero(), const CompareOptions& options = {});

}  // namespace procam::watch
