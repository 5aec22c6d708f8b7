#include "transform_buffer.hpp"

#include <algorithm>
#include <iterator>
#include <limits>
#include <vector>

#include "procam/core/base/limits.hpp"
#include "procam/core/geometry/se3.hpp"

namespace procam::dds::internal {
namespace {

bool is_odometry(const std::string& frame) {
  static const std::string kName = "odom";
  if (frame.size() < kName.size() || frame.compare(frame.size() - kName.size(), kName.size(), kName) != 0)
    return false;
  if (frame.size() == kName.size()) return true;
  const char before = frame[frame.size() - kName.size() - 1];
  return before == '/' || before == '_';
}

}  // namespace

bool TransformBuffer::reaches(const std::string& from, const std::string& ancestor) const {
  const std::string* at = &from;
  for (std::size_t steps = 0; steps <= edges_.size(); ++steps) {
    if (*at == ancestor) return true;
    const auto edge = edges_.find(*at);
    if (edge == edges_.end()) return false;
    at = &edge->second.parent;
  }
  return true;
}

const char* TransformBuffer::set(const track::StampedPose& edge, bool is_static) {
  if (reaches(edge.frame, edge.child)) return "loop of frames";
  auto found = edges_.find(edge.child);
  if (found == edges_.end()) {
    if (edges_.size() >= limits::kTransformFrames) return "too many frames";
    found = edges_.emplace(edge.child, Edge{}).first;
  }
  Edge& known = found->second;
  if (known.parent != edge.frame || known.is_static != is_static) {
    known.parent = edge.frame;
    known.is_static = is_static;
    known.samples.clear();
  }
  const Sample sample{edge.stamp.value_or(0), edge.frame_from_child};
  if (is_static) known.samples.clear();
  if (!known.samples.empty() && sample.stamp < known.samples.back().stamp - span_) known.samples.clear();
  auto at = known.samples.end();
  while (at != known.samples.begin() && (at - 1)->stamp > sample.stamp) --at;
  if (at != known.samples.begin() && (at - 1)->stamp == sample.stamp) {
    (at - 1)->parent_from_child = sample.parent_from_child;  // said again
    return nullptr;
  }
  known.samples.insert(at, sample);
  while (known.samples.size() > limits::kTransformStamps ||
         known.samples.front().stamp < known.samples.back().stamp - span_)
    known.samples.pop_front();
  return nullptr;
}

void TransformBuffer::forget_moving() {
  for (auto edge = edges_.begin(); edge != edges_.end();)
    edge = edge->second.is_static ? std::next(edge) : edges_.erase(edge);
}

/// Calls visit(edge, is_up) for each edge from both frames up to the one that they share; false when there is none.
template <typename Visit>
bool TransformBuffer::walk(const std::string& frame, const std::string& child, Visit visit) const {
  std::vector<const std::string*> above_child{&child};
  for (auto edge = edges_.find(child); edge != edges_.end(); edge = edges_.find(edge->second.parent))
    above_child.push_back(&edge->second.parent);
  // Up from the frame, until it is one of those above the child.
  std::vector<const Edge*> from_frame;
  const std::string* at = &frame;
  const auto meets = [&] {
    return std::find_if(above_child.begin(), above_child.end(),
                        [&](const auto* name) { return *name == *at; });
  };
  auto shared = meets();
  while (shared == above_child.end()) {
    const auto edge = edges_.find(*at);
    if (edge == edges_.end()) return false;
    from_frame.push_back(&edge->second);
    at = &edge->second.parent;
    shared = meets();
  }
  for (const Edge* edge : from_frame) visit(*edge, false);
  for (auto name = above_child.begin(); name != shared; ++name) visit(edges_.find(**name)->second, true);
  return true;
}

std::optional<double> TransformBuffer::latest(const std::string& frame, const std::string& child) const {
  double time = std::numeric_limits<double>::infinity();
  const bool connected = walk(frame, child, [&](const Edge& edge, bool) {
    if (!edge.is_static) time = std::min(time, edge.samples.back().stamp);
  });
  return connected ? std::optional(time) : std::nullopt;
}

std::optional<Pose> TransformBuffer::lookup(const std::string& frame, const std::string& child,
                                            double time) const {
  Pose shared_from_frame, shared_from_child;
  bool is_known = true;
  const auto at = [&](const Edge& edge) -> Pose {
    const std::deque<Sample>& samples = edge.samples;
    if (edge.is_static) return samples.front().parent_from_child;
    if (!(time >= samples.front().stamp && time <= samples.back().stamp)) {
      is_known = false;
      return {};
    }
    const auto after =
        std::lower_bound(samples.begin(), samples.end(), time,
                         [](const Sample& sample, double value) { return sample.stamp < value; });
    if (after->stamp == time) return after->parent_from_child;
    const Sample& before = *(after - 1);
    const double share = (time - before.stamp) / (after->stamp - before.stamp);
    return {
        before.parent_from_child.rotation.slerp(share, after->parent_from_child.rotation),
        (1 - share) * before.parent_from_child.translation + share * after->parent_from_child.translation};
  };
  const bool connected = walk(frame, child, [&](const Edge& edge, bool is_of_child) {
    Pose& chain = is_of_child ? shared_from_child : shared_from_frame;
    chain = at(edge) * chain;
  });
  if (!connected || !is_known) return std::nullopt;
  return (shared_from_frame.inverse() * shared_from_child).normalized();
}

std::optional<std::string> TransformBuffer::odometry_frame(const std::string& frame,
                                                           const std::string& child) const {
  if (!reaches(child, frame)) return std::nullopt;
  for (auto edge = edges_.find(child); edge != edges_.end(); edge = edges_.find(edge->second.parent)) {
    if (is_odometry(edge->second.parent)) return edge->second.parent;
    if (edge->second.parent == frame) return std::nullopt;
  }
  return std::nullopt;
}

double TransformBuffer::last_interval(const std::string& frame, const std::string& child) const {
  double longest = 0;
  walk(frame, child, [&](const Edge& edge, bool) {
    if (edge.is_static) return;
    const std::size_t count = edge.samples.size();
    longest = std::max(longest, count < 2 ? std::numeric_limits<double>::infinity()
                                          : edge.samples[count - 1].stamp - edge.samples[count - 2].stamp);
  });
  return longest;
}

std::optional<Vec6> TransformBuffer::twist(const std::string& frame, const std::string& child,
                                           double time) const {
  constexpr double kMinInterval = 0.05, kMaxInterval = 0.5;  // seconds
  const double interval = last_interval(frame, child);
  if (!(interval > 0 && interval < kMaxInterval)) return std::nullopt;
  const double h = std::max(interval, kMinInterval);
  const auto now = lookup(frame, child, time), before = lookup(frame, child, time - h),
             earlier = lookup(frame, child, time - 2 * h);
  if (!now || !before || !earlier) return std::nullopt;
  const Vec6 last = se3_log(before->inverse() * *now) / h, first = se3_log(earlier->inverse() * *before) / h;
  return Vec6(last + 0.5 * (last - first));
}

}  // namespace procam::dds::internal
