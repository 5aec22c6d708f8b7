#pragma once
/// What the tests of homographies share.
#include <gtest/gtest.h>

#include <string>

#include "procam/core/geometry/homography.hpp"

namespace procam::test {

/// Sheared, off-centre, in perspective about no axis.
inline Homography lopsided() {
  Mat3 matrix;
  matrix << 1.1, 0.08, 30.0, -0.05, 0.93, 12.0, 1.2e-4, -2.1e-4, 1.0;
  return Homography(matrix);
}

inline double distance_between(const Homography& a, const Homography& b) {
  return (a.normalised().matrix() - b.normalised().matrix()).norm();
}

/// Why `call` was refused with an error of that kind, or a failure.
template <typename Call>
std::string refusal(Call call, ErrorKind kind) {
  try {
    call();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), kind) << error.what();
    return error.why();
  }
  ADD_FAILURE() << "not refused";
  return "";
}

inline bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace procam::test
