#include "document/shared_fields.hpp"

#include <Eigen/Eigenvalues>

namespace procam::io {

namespace {

/// What to do with a file of another format.
std::string next_for(const std::string& found, const std::string& expected) {
  if (found == "procam-surfaces" && expected == "procam-solved-surfaces")
    return "run solve-surfaces on it first: solve-surfaces --rig rig.json --surfaces FILE -o solved.json";
  if (found == "procam-solved-surfaces" && expected == "procam-surfaces")
    return "give the file that solve-surfaces read, not the one that it wrote";
  return "give a " + expected + " file";
}

}  // namespace

void header(Fields& f, const char* format, int newest) {
  std::string found_format = format;
  int version = newest;
  f.field("format", found_format);
  f.check(found_format == format, "format", "the file is a '" + found_format + "' and not a '" + format + "'",
          next_for(found_format, format));
  f.field("version", version);
  f.check(version <= newest, "version",
          "version " + std::to_string(version) + " was written by a newer procam; this one reads up to " +
              std::to_string(newest),
          "update procam, or write the file again with this one", ErrorKind::kUnsupported);
  f.check(version >= 1, "version", "there is no version " + std::to_string(version), "versions begin at 1");
}

void fields(Fields& f, Pose& pose) {
  Vec4 xyzw = pose.rotation.coeffs();
  f.field("translation", pose.translation);
  f.field("rotation_xyzw", xyzw);
  const double off_unit = std::abs(xyzw.norm() - 1);
  f.check(off_unit <= 1e-6, "rotation_xyzw", "the quaternion has length " + std::to_string(xyzw.norm()),
          "give a unit quaternion in the order x, y, z, w");
  if (!f.reading()) return;
  pose.rotation.coeffs() = xyzw;
  // Below this a normalisation would only change the last digit, and a file would not read back as written.
  if (off_unit > 1e-14) pose.rotation.normalize();
}

void check_covariance(const Fields& f, const char* name, const MatX& covariance) {
  constexpr double kTolerance = 1e-6;
  const Eigen::Index n = covariance.rows();
  const char* const next = "take the matrix from the solver unchanged, rows in the order of the names";
  VecX inverse_sigmas(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    f.check(covariance(i, i) >= 0, name, "row " + std::to_string(i) + " has a negative variance", next);
    inverse_sigmas[i] = covariance(i, i) > 0 ? 1 / std::sqrt(covariance(i, i)) : 0;
  }
  // Parameters have units of their own: only the correlations can be compared with one tolerance.
  const MatX correlation = inverse_sigmas.asDiagonal() * covariance * inverse_sigmas.asDiagonal();
  for (Eigen::Index r = 0; r < n; ++r)
    for (Eigen::Index c = 0; c < n; ++c) {
      f.check(covariance(r, r) > 0 || covariance(r, c) == 0, name,
              "row " + std::to_string(r) + " has no variance but a covariance", next);
      f.check(std::abs(correlation(r, c) - correlation(c, r)) <= kTolerance, name,
              "row " + std::to_string(r) + ", column " + std::to_string(c) + " is not symmetric", next);
    }
  if (n == 0 || !correlation.allFinite()) return f.check(n == 0, name, "its numbers overflow", next);
  const double smallest =
      Eigen::SelfAdjointEigenSolver<MatX>(correlation, Eigen::EigenvaluesOnly).eigenvalues()[0];
  f.check(smallest >= -kTolerance, name, "it is not positive semi-definite", next);
}

}  // namespace procam::io
