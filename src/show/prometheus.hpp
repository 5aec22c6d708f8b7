#pragma once
/// Metrics as the text that Prometheus reads.
#include "procam/show/metrics.hpp"
#include "procam/track/pose_track.hpp"

namespace procam::show {

/// The text form that Prometheus and its kind read (exposition format 0.0.4): counters, and summaries with
/// quantiles 0.5, 0.9, 0.99.
std::string to_prometheus(const Metrics& metrics, const track::Faults& poses);

}  // namespace procam::show
