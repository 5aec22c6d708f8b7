#pragma once
/// How far from its place the light lands on a surface, and because of what: closed form.
///
/// The light of a fixed pixel u lands where f(theta, X + E a) = u, with theta all that the chain depends on
/// (error_sources.hpp), E the surface's x and y axes and a the offset on the surface, metres. The implicit
/// function theorem gives, to first order in the errors d theta of mean mu and covariance C,
///
///   a = A d theta,  A = -(df/da)^-1 df/dtheta,     bias = A mu,     covariance = A C A^T.
///
/// Exact derivatives, through core's dual numbers and the geometry of increments. What a drive does to the
/// mean is followed exactly, and the derivatives are taken where it leads. First order fails where the light
/// grazes (a goes with 1 / cos^2 of the incidence): the second-order term, half of what each error does in
/// both directions together, is computed beside it from exact landings and says so.
#include <string>
#include <vector>

#include "procam/analyze/error_sources.hpp"
#include "procam/core/base/export.hpp"

namespace procam::analyze {

struct PROCAM_EXPORT LandingError {
  /// One cause's share. Offsets on the surface, along its x and y, metres.
  struct SourceError {
    std::string name;  ///< "calibration", "rig pose", "map", "delay", "pixels"
    Vec2 bias = Vec2::Zero();
    Mat2 covariance = Mat2::Zero();
    /// The same cause taken apart: "lens", "mount" and "camera" (through
    /// which the pose was measured); "position", "rotation". What correlates between parts is in
    /// the whole only, so parts need not add up.
    std::vector<SourceError> parts;

    /// Root of the mean squared distance between true and intended place.
    double rms() const { return std::sqrt(bias.squaredNorm() + covariance.trace()); }
  };
  Vec2 on_surface;                   ///< the intended place, metres along the surface's x and y
  Vec2 pixel;                        ///< that is to light it
  double incidence_deg = 0;          ///< angle of the light to the surface's normal
  std::vector<SourceError> sources;  ///< those that take part, independent of each other
  SourceError total;                 ///< "total": their sum
  Vec2 second_order = Vec2::Zero();  ///< shift of the mean of higher orders, metres

  /// Is first order good enough here: incidence at most 75 degrees and the second-order shift at most a tenth
  /// of total.rms()?
  bool first_order_holds() const;
};

/// nullopt where no light of the projector can reach the point, or the drive takes it away from the surface.
/// Throws Error(kInput) when the calibration's
/// covariance lacks the projector, std::invalid_argument for covariances that are not symmetric, positive
/// semidefinite and finite, or a negative sigma.
PROCAM_EXPORT std::optional<LandingError> landing_error(const LightPath& path, const ErrorSources& sources,
                                                        const Vec2& on_surface);

/// A 95 % region's half axes and the angle of the longer one to the surface's x axis: chi-square of two
/// degrees of freedom, 5.99.
struct Ellipse {
  double semi_major = 0, semi_minor = 0, angle = 0;
};
PROCAM_EXPORT Ellipse region95(const Mat2& covariance);

}  // namespace procam::analyze
