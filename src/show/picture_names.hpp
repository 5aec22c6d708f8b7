#pragma once
/// The names of the test patterns in commands, at the control page and in the log of a run.

namespace procam::show {

/// By TestPattern.
inline constexpr const char* kPictureNames[] = {"content", "grid", "mask"};

}  // namespace procam::show
