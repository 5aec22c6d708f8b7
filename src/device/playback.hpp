#pragma once
/// Recorded pictures, decoded ahead by a thread of their own.
#include "procam/device/content_source.hpp"

namespace procam::device::internal {

/// A recording, picture after picture; used by one thread at a time. All may throw Error.
class PictureReader {
 public:
  virtual ~PictureReader() = default;
  virtual const std::string& name() const = 0;
  /// The next picture, into memory that is used again where it has the right size; false at the end.
  virtual bool read(ImageU8& picture) = 0;
  /// Passes over the next picture; false at the end.
  virtual bool skip() = 0;
  virtual void rewind() = 0;
  /// On the first picture, once it was read.
  virtual const Diagnostics& remarks() const {
    static const Diagnostics none;
    return none;
  }
};

/// Throws what reading the first picture throws.
std::unique_ptr<ContentSource> play(std::unique_ptr<PictureReader> reader, double rate_hz,
                                    const ContentOptions& options);

}  // namespace procam::device::internal
