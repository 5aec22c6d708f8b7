#include "procam/people/skeleton_source.hpp"

#include <algorithm>
#include <chrono>
#include <thread>

#include "procam/core/base/error.hpp"
#include "procam/core/base/limits.hpp"
#include "procam/track/detail/parsed_source.hpp"
#include "procam/track/detail/recorded.hpp"
#include "skeleton_stream.hpp"
#include "vmc.hpp"

namespace procam::people {

namespace {

template <typename Parser>
std::unique_ptr<SkeletonSource> open_skeletons(const std::string& text, const track::SourceOptions& options) {
  return std::make_unique<
      track::internal::ParsedSource<SkeletonSource, SkeletonFrame, Parser, &ParsedSkeletons::frames>>(
      text, options);
}

}  // namespace

void SkeletonSource::wait(double seconds) {
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds > 0 ? std::min(seconds, 0.001) : 0));
}

std::unique_ptr<SkeletonSource> open_skeleton_source(const std::string& text,
                                                     const track::SourceOptions& options) {
  const std::size_t colon = text.find(':');
  const std::string kind = text.substr(0, colon), rest = colon == text.npos ? "" : text.substr(colon + 1);
  if (kind == "udp") return open_skeletons<track::internal::Stateless<parse_skeletons>>(text, options);
  if (kind == "vmc") return open_skeletons<VmcReader>("udp:" + rest, options);
  if (kind == "tcp" || kind == "tcp-listen") return open_skeletons<SkeletonStream>(text, options);
  if (kind == "log") {
    const track::internal::FileAndSpeed log = track::internal::parse_file_and_speed(rest);
    return std::make_unique<track::internal::Recorded<SkeletonFrame, SkeletonSource>>(
        read_skeleton_log(log.file), log.speed);
  }
  throw Error(ErrorKind::kInput, "skeleton source '" + text + "'", "no kind of source is called so",
              "use one of udp:[ADDRESS:]PORT, tcp:HOST:PORT, tcp-listen:[ADDRESS:]PORT, vmc:[ADDRESS:]PORT, "
              "log:FILE[@SPEED]");
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
  if (rest_.size() > limits::kSkeletonLineBytes || (skipping_ && !rest_.empty())) {
    if (!skipping_) {
      ++parsed.malformed;
      parsed.why = "a line is longer than 65536 bytes";
    }
    skipping_ = true;
    rest_.clear();
  }
  return parsed;
}

}  // namespace procam::people
