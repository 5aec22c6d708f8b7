#pragma once
/// Field lists of nouns that several files hold.
#include "document/fields.hpp"
#include "procam/core/geometry/pose.hpp"

namespace procam::io {

/// translation, rotation_xyzw (unit within 1e-6, then normalised).
void fields(Fields& f, Pose& pose);

/// A field that holds a covariance: symmetric, no negative variance, positive semi-definite, each within what
/// the inverse of an ill-conditioned matrix leaves of it.
void check_covariance(const Fields& f, const char* name, const MatX& covariance);

}  // namespace procam::io
