#pragma once
/// Frames in shared memory, for another program on this machine (a media server, a test, a robot's screen).
///
/// The memory /NAME (on Linux the file /dev/shm/NAME) holds, all little-endian:
///
///   offset  0   "PROCAMF1"
///           8   uint32 width, uint32 height, uint32 channels (3: R G B), uint32 slots (3)
///          24   uint64 newest: number of the newest whole frame, from 1; 0 before the first
///          64   slots, each slot_bytes apart (64 + width * height * 3, up to the next multiple of 64):
///                 0  uint64 number of the frame that is here; 0 while it is being written
///                 8  float64 time of writing, seconds of the steady clock
///                64  pixels, rows without gaps
///
/// Frame n is in slot n modulo 3. A reader copies the slot of `newest` and looks at the slot's number before
/// and after: equal to `newest` both times means a whole frame. The writer needs two more frames to come
/// round to that slot. Read by pread() rather than through a mapping, the memory can be cut short by its owner
/// without harm to the reader. The writer holds an exclusive flock() on it: a second writer of the name is
/// refused while the first lives.
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "procam/core/base/export.hpp"
#include "procam/core/base/image.hpp"

namespace procam::device {

/// Reads what a sink "shm:NAME" writes. As content: open_content("shm:NAME") (content_source.hpp).
class PROCAM_EXPORT SharedFrameReader {
 public:
  struct Frame {
    std::uint64_t number = 0;
    double time_s = 0;
    ImageU8 image;
  };
  /// Throws Error(kDevice) when there is no such memory or it holds something else.
  explicit SharedFrameReader(const std::string& name);
  ~SharedFrameReader();
  SharedFrameReader(const SharedFrameReader&) = delete;
  SharedFrameReader& operator=(const SharedFrameReader&) = delete;

  ImageSize size() const;
  /// The newest frame if its number is above `after`; nullopt otherwise.
  std::optional<Frame> newest(std::uint64_t after = 0) const;
  /// The same into a frame whose memory is used again; false: there is none, and its pixels may be torn.
  bool read_newest(std::uint64_t after, Frame& into) const;
  /// The writer has gone, another has begun anew under the name, or the memory was cut short: no more frames
  /// come here.
  bool is_orphan() const;

 private:
  struct Memory;
  std::unique_ptr<Memory> memory_;
};

}  // namespace procam::device
