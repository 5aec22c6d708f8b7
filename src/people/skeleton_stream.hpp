#pragma once
/// JSON lines of skeletons from a stream.
#include "procam/people/skeleton_source.hpp"

namespace procam::people {

/// A stream of JSON lines, cut where it likes. A line longer than limits::kSkeletonLineBytes is counted once and
/// skipped.
class SkeletonStream {
 public:
  ParsedSkeletons parse(std::string_view bytes);

 private:
  std::string rest_;
  bool skipping_ = false;
};

}  // namespace procam::people
