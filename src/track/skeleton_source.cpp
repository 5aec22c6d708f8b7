#include "procam/track/skeleton_source.hpp"

#include "procam/core/error.hpp"
#include "sources.hpp"

namespace procam::track {
namespace {

/// A recorded run, due in its own time from the moment that it was opened.
class SkeletonLog : public SkeletonSource {
 public:
  explicit SkeletonLog(const internal::FileAndSpeed& log)
      : frames_(read_skeleton_log(log.file)), speed_(log.speed) {
    const double opened = steady_now(), first = frames_.front().arrival;
    if (speed_ > 0)
      for (SkeletonFrame& frame : frames_) frame.arrival = opened + (frame.arrival - first) / speed_;
  }
  void poll(std::vector<SkeletonFrame>& arrived) override {
    arrived.clear();
    const double now = steady_now();
    for (; next_ < frames_.size() && (speed_ == 0 || frames_[next_].arrival <= now); ++next_)
      arrived.push_back(frames_[next_]);
  }
  SourceStatus status() const override {
    SourceStatus status;
    status.connected = next_ < frames_.size();
    status.messages = next_;
    status.connections = 1;
    return status;
  }

 private:
  std::vector<SkeletonFrame> frames_;
  double speed_;
  std::size_t next_ = 0;
};

}  // namespace

std::unique_ptr<SkeletonSource> open_skeleton_source(const std::string& text, const SourceOptions& options) {
  const std::size_t colon = text.find(':');
  const std::string kind = text.substr(0, colon), rest = colon == text.npos ? "" : text.substr(colon + 1);
  if (kind == "udp") return internal::open_skeletons_udp(rest, options);
  if (kind == "tcp") return internal::open_skeletons_tcp(rest, options);
  if (kind == "tcp-listen") return internal::open_skeletons_tcp_listener(rest, options);
  if (kind == "log") return std::make_unique<SkeletonLog>(internal::parse_file_and_speed(rest));
  throw Error(ErrorKind::kInput, "skeleton source '" + text + "'", "no kind of source is called so",
              "say one of udp:[ADDRESS:]PORT, tcp:HOST:PORT, tcp-listen:[ADDRESS:]PORT, log:FILE[@SPEED]");
}

ParsedSkeletons SkeletonStream::parse(std::string_view bytes) {
  rest_ += bytes;
  ParsedSkeletons parsed;
  const std::size_t last = rest_.rfind('\n');
  if (last != rest_.npos) {
    std::string_view lines(rest_.data(), last + 1);
    // What is left of a line that was given up.
    if (skipping_) lines.remove_prefix(lines.find('\n') + 1);
    skipping_ = false;
    parsed = parse_skeletons(lines);
    rest_.erase(0, last + 1);
  }
  if (rest_.size() > kLongestSkeletonLine || (skipping_ && !rest_.empty())) {
    if (!skipping_) {
      ++parsed.malformed;
      parsed.why = "a line is longer than 65536 bytes";
    }
    skipping_ = true;
    rest_.clear();
  }
  return parsed;
}

}  // namespace procam::track
