#pragma once
/// Is there light in the frames of a running show, and why not?
#include <optional>
#include <string>
#include <vector>

#include "procam/show/metrics.hpp"
#include "procam/show/projection.hpp"
#include "procam/track/pose_source.hpp"

namespace procam::show {

/// Why surfaces in the world are dark before the first pose: no source, or what `names` have sent so far.
std::string waiting_reason(const std::vector<track::PoseSource*>& sources, const std::string& names);

class LightCheck {
 public:
  /// Looks at a frame, one a second from the first second on, while surfaces are placed, and counts it. The
  /// reason why it has no light, once for these surfaces: no content, surfaces outside of the projector's
  /// picture (with the likely cause), or black content.
  std::optional<std::string> check(double now, const DrawnFrame& drawn, const Projection& projection,
                                   const ImageU8& frame, Metrics& metrics);
  /// Other surfaces, which have their own reason.
  void show_changed() { reported_ = false; }

 private:
  double checked_ = 0;
  bool reported_ = false;
};

}  // namespace procam::show
