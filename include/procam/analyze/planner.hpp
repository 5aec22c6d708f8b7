#pragma once
/// What a projector will do on a wall, from its data sheet and its place, before it is bought.
///
/// The projector is core's, without lens distortion: fx = fy = throw_ratio * W, cx = (W - 1)/2 + W shift_x,
/// cy = (H - 1)/2 + H shift_y; all light goes through its verbs.
///
/// Wall frame: x right and y down as a reader sees it, z into the wall; the wall is z = 0, metres. Depth is
/// measured along the optical axis. With h the lens' distance from the wall and z the depth of the lit point:
///
///   pixel on the wall    dX = z (dd - d (n . dd) / (n . d)),   d = K^-1 (u, v, 1), n the wall's normal;
///                        the singular values of dX / d(u, v) are its finest and coarsest direction,
///                        |det| = z^3 / (fx fy h) its area
///   illuminance          E = lumens / (W H) * fx fy h / z^3
///                        = intensity * cos(incidence) / r^2,   intensity = lumens / (W H) * fx fy / cos^3 a
///   blur in pixels       b = A fx |1/focus - 1/z|,  A = focal length / f-number
///   text height          max(9 coarsest pixels, 2 viewer_distance tan(16'/2))
///
/// Illuminance: every pixel sends out the same flux, so that a screen across the axis is evenly lit; a pixel
/// covers the solid angle cos^3 a / (fx fy), `a` its angle to the axis. (A lens that darkens its corners
/// makes the middle brighter and the corners darker than this.) Depth of field: a thin lens' cone of light,
/// A wide at the lens and a point at the focused depth, may be one pixel wide where it lands. Both the
/// f-number and the focal length are needed: together they say how wide the lens is open. Text: the height of
/// capitals. ISO 9241-3 asks for a matrix of at least 7 x 9 pixels a character in text that is read (5 x 7 in
/// capitals alone), and ISO 9241-303 for at least 16 minutes of arc (20 to 22 preferred).
#include <optional>

#include "procam/core/base/error.hpp"
#include "procam/core/base/export.hpp"
#include "procam/core/lens/projector.hpp"

namespace procam::analyze {

/// As printed by the maker; of a zoom lens, the values at the zoom that is meant.
struct DataSheet {
  ImageSize resolution;
  double throw_ratio = 0;              ///< distance over picture width
  Vec2 lens_shift = Vec2::Zero();      ///< as Projector::lens_shift(): (0, 0.5): the axis at the bottom edge
  std::optional<double> lumens;        ///< of a white picture
  std::optional<double> f_number;      ///< for the depth of field, with
  std::optional<double> focal_length;  ///< metres
};

/// The projector that the data sheet describes. Throws Error(kInput) for values that no projector has.
PROCAM_EXPORT Projector projector_of(const DataSheet& sheet);

/// projector_from_wall of a projector whose lens is `distance` metres from the wall. The wall's origin is
/// then the foot of the lens, where a plumb line from the lens meets the wall. Turned from looking straight
/// at the wall, radians: first `yaw` to its right, then `pitch` upwards, then `roll` clockwise as seen from
/// behind it. Throws Error(kInput) unless the distance is positive and the angles are finite.
PROCAM_EXPORT Pose pose_before_wall(double distance, double yaw = 0, double pitch = 0, double roll = 0);

/// A rectangle parallel to the wall's axes.
struct PROCAM_EXPORT WallRectangle {
  Vec2 centre = Vec2::Zero(), size = Vec2::Zero();  ///< metres

  /// Top left, top right, bottom right, bottom left.
  Points2 corners() const;
};

/// What shall be covered.
struct WallTarget {
  Vec2 size = Vec2::Zero();    ///< metres
  std::optional<Vec2> centre;  ///< absent: wherever it fits best, at the centre of the largest rectangle
};

/// Where the projector stands, and what for.
struct Site {
  Pose projector_from_wall;
  std::optional<WallTarget> target;
  std::optional<double> viewer_distance;  ///< metres from the reader's eyes to the wall
  std::optional<double> text_height;      ///< of the capitals that are to be read, metres
};

/// Where one pixel's light lands, and how.
struct LightOnWall {
  Vec2 on_wall;                 ///< metres
  double depth = 0;             ///< metres along the optical axis
  double incidence_deg = 0;     ///< angle between the light and the wall's normal
  double mm_per_pixel_min = 0;  ///< size of the pixel on the wall: finest
  double mm_per_pixel_max = 0;  ///< and coarsest direction
  double lux_per_lumen = 0;     ///< illuminance for a projector of one lumen
};

/// nullopt where the light misses the wall. The projector's lens must have no distortion and no skew, as
/// projector_of() makes it.
PROCAM_EXPORT std::optional<LightOnWall> light_on_wall(const Projector& projector,
                                                       const Pose& projector_from_wall, const Vec2& pixel);

/// The lens focused on the middle of the picture. That is the best place: 1 / depth changes evenly over the
/// picture, so the nearest and the farthest corner are blurred alike. Depths along the optical axis, metres.
struct DepthOfField {
  double focus = 0;                  ///< depth of the picture's middle
  double near = 0, far = 0;          ///< blur is at most one pixel between them; far may be infinite
  double nearest = 0, farthest = 0;  ///< what the picture reaches from, to: opposite corners
  double blur_max_px = 0;            ///< at those corners
};

struct PROCAM_EXPORT ProjectionPlan {
  struct TargetCoverage {
    WallRectangle rectangle;
    double covered_share = 0;  ///< of its area, 0..1
    bool whole = false;
  };
  /// Lux, on the wall. The extremes lie at corners of the picture.
  struct Illuminance {
    double middle = 0, darkest = 0, brightest = 0;
  };
  Projector projector;
  Pose projector_from_wall;
  Points2
      corners;  ///< of the lit area on the wall: the picture's top left, top right, bottom right, bottom left
  Vec2 middle;  ///< where the light of the picture's middle lands
  double mm_per_pixel_min = 0, mm_per_pixel_max = 0;  ///< over the picture
  double incidence_deg = 0, incidence_max_deg = 0;    ///< at the picture's middle and at its worst corner
  std::optional<Illuminance> lux;
  std::optional<DepthOfField> depth_of_field;
  double text_height_by_pixels = 0;  ///< metres: nine of the coarsest pixels in the target's lit part,
                                     ///< or of the picture where there is none
  std::optional<double> text_height_by_eye;  ///< metres: 16 minutes of arc for the viewer
  WallRectangle undistorted;  ///< the largest in the lit area, of the target's aspect or else the picture's
  double undistorted_pixel_share = 0;  ///< of the projector's pixels that light it
  std::optional<TargetCoverage> target;
  Diagnostics diagnostics;

  /// The smallest capitals that can be read everywhere in the target, or else in the picture; metres.
  double readable_text_height() const;
};

/// Diagnostics, all warnings: "grazing" (incidence above 70 degrees somewhere), "target_not_covered",
/// "text_unreadable", "out_of_focus" (a corner outside the depth of field); note "depth_of_field_unknown"
/// when only one of f-number and focal length is given.
///
/// Throws Error(kInput) for values that are not finite or not positive and for a lens in or behind the wall,
/// Error(kDegenerate) when the light of the picture or of a corner never meets the wall.
PROCAM_EXPORT ProjectionPlan plan_projection(const DataSheet& sheet, const Site& site);

/// The figures as people read them: a name and a value a line, ASCII.
struct PlanFigure {
  std::string name, value;
};
PROCAM_EXPORT std::vector<PlanFigure> figures_of(const analyze::ProjectionPlan& plan);

}  // namespace procam::analyze
