#pragma once
/// Live pictures as content.
#include <map>
#include <memory>
#include <string>

#include "procam/device/content_source.hpp"

namespace procam::device::internal {

/// Where they come from; used by one thread, but for none() and rejected().
class LivePictures {
 public:
  virtual ~LivePictures() = default;
  /// Waits for the next picture; false: there is none yet. Throws Error when none will come.
  virtual bool next(ImageU8& picture) = 0;
  /// After an error, a second later.
  virtual void reopen() = 0;
  /// Why there is no first picture.
  virtual Error none() const = 0;
  virtual std::map<std::string, std::uint64_t> rejected() const { return {}; }
};

/// A thread fetches them. Throws what next() throws first, and none() after options.camera_patience_s.
std::unique_ptr<ContentSource> show_live(std::unique_ptr<LivePictures> pictures,
                                         const ContentOptions& options);

}  // namespace procam::device::internal
