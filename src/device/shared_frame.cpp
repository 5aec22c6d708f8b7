#include "procam/device/shared_frame.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <vector>

#include "procam/core/base/limits.hpp"
#include "sinks.hpp"

namespace procam::device {
namespace {

constexpr char kMagic[8] = {'P', 'R', 'O', 'C', 'A', 'M', 'F', '1'};
constexpr std::uint32_t kSharedSlots = 3;
constexpr std::size_t kHeader = 64;

struct Header {
  char magic[8];
  std::uint32_t width, height, channels, slots;
  std::uint64_t newest;
};
struct Slot {
  std::uint64_t number;
  double time_s;
};
static_assert(sizeof(Header) <= kHeader && sizeof(Slot) <= kHeader);

/// The memory's descriptor. It is read and written by calls and is not mapped: a mapping that another program
/// cuts short ends the process by a signal.
class SharedFile {
 public:
  explicit SharedFile(int number = -1) : number_(number) {}
  SharedFile(const SharedFile&) = delete;
  SharedFile& operator=(const SharedFile&) = delete;
  ~SharedFile() {
    if (number_ >= 0) ::close(number_);
  }
  int get() const { return number_; }
  struct stat status() const {
    struct stat about {};
    (void)::fstat(number_, &about);
    return about;
  }
  /// False where the memory ends before.
  bool read(std::size_t at, void* into, std::size_t size) const {
    for (auto* to = static_cast<char*>(into); size > 0;) {
      const ssize_t count = ::pread(number_, to, size, off_t(at));
      if (count < 0 && errno == EINTR) continue;
      if (count <= 0) return false;
      to += count, at += std::size_t(count), size -= std::size_t(count);
    }
    return true;
  }
  bool write(std::size_t at, const void* from, std::size_t size) const {
    for (const auto* bytes = static_cast<const char*>(from); size > 0;) {
      const ssize_t count = ::pwrite(number_, bytes, size, off_t(at));
      if (count < 0 && errno == EINTR) continue;
      if (count <= 0) return false;
      bytes += count, at += std::size_t(count), size -= std::size_t(count);
    }
    return true;
  }

 private:
  int number_;
};

std::size_t pixel_bytes(ImageSize size) {
  return std::size_t(size.width) * std::size_t(size.height) * 3;
}
std::size_t slot_bytes(ImageSize size) {
  return (kHeader + pixel_bytes(size) + 63) / 64 * 64;
}
std::size_t total_bytes(ImageSize size) {
  return kHeader + kSharedSlots * slot_bytes(size);
}

Error shared_error(const std::string& name, const std::string& why, const std::string& next) {
  return Error(ErrorKind::kDevice, "shared memory '" + name + "'", why, next);
}

std::string path_of(const std::string& name) {
  if (name.empty() || name.size() > 200 || name.find('/') != std::string::npos)
    throw Error(ErrorKind::kInput, "shm:" + name, "it is no name for shared memory",
                "give a word, e.g. shm:wall");
  return "/" + name;
}

std::size_t slot_at(ImageSize size, std::uint64_t number) {
  return kHeader + (number % kSharedSlots) * slot_bytes(size);
}

/// Makes the memory anew: readers of one that an earlier run left keep theirs, and see no frame of another size.
/// The writer holds a lock on its memory, which ends with the process.
int create_shared(const std::string& name, const std::string& path) {
  const auto in_use = [&] {
    return shared_error(name, "another program writes frames to it",
                        "end that program, or give another name");
  };
  {
    const SharedFile old(shm_open(path.c_str(), O_RDONLY, 0));
    if (old.get() >= 0 && flock(old.get(), LOCK_EX | LOCK_NB) != 0) throw in_use();
    shm_unlink(path.c_str());
  }
  const int file = shm_open(path.c_str(), O_CREAT | O_EXCL | O_RDWR, 0600);
  if (file < 0) throw shared_error(name, std::strerror(errno), "give another name");
  if (flock(file, LOCK_EX | LOCK_NB) == 0) return file;
  close(file);
  throw in_use();
}

class SharedFrameSink : public FrameSink {
 public:
  SharedFrameSink(const std::string& name, ImageSize size)
      : name_(name), path_(path_of(name)), size_(size), file_(create_shared(name, path_)) {
    // posix_fallocate, not ftruncate: memory that is not there is an error here, not in a later write.
    int failed = posix_fallocate(file_.get(), 0, off_t(total_bytes(size)));
    Header header{{}, std::uint32_t(size.width), std::uint32_t(size.height), 3, kSharedSlots, 0};
    std::memcpy(header.magic, kMagic, sizeof kMagic);
    if (failed == 0 && !file_.write(0, &header, sizeof header)) failed = errno;
    if (failed != 0) {
      shm_unlink(path_.c_str());
      throw shared_error(name, std::strerror(failed), "free some of /dev/shm");
    }
    pixels_.resize(pixel_bytes(size));
  }
  ~SharedFrameSink() override {
    // Only its own: the name may be another program's by now.
    const SharedFile now(shm_open(path_.c_str(), O_RDONLY, 0));
    if (now.get() >= 0 && now.status().st_ino == file_.status().st_ino) shm_unlink(path_.c_str());
  }
  SharedFrameSink(const SharedFrameSink&) = delete;
  SharedFrameSink& operator=(const SharedFrameSink&) = delete;

  ImageSize size() const override { return size_; }
  double show(ViewU8 picture) override {
    internal::require_frame(picture, size_);
    internal::copy_rgb(picture, pixels_.data());
    const std::size_t at = slot_at(size_, ++number_);
    Slot slot{0, 0};
    bool written = file_.write(at, &slot.number, sizeof slot.number);
    std::atomic_thread_fence(std::memory_order_release);  // the zero before the pixels
    written = written && file_.write(at + kHeader, pixels_.data(), pixels_.size());
    slot = {number_, now_s()};
    written = written && file_.write(at + offsetof(Slot, time_s), &slot.time_s, sizeof slot.time_s);
    std::atomic_thread_fence(std::memory_order_release);
    written = written && file_.write(at, &slot.number, sizeof slot.number);
    std::atomic_thread_fence(std::memory_order_release);
    written = written && file_.write(offsetof(Header, newest), &number_, sizeof number_);
    if (!written) throw shared_error(name_, std::strerror(errno), "free some of /dev/shm");
    return slot.time_s;
  }

 private:
  std::string name_, path_;
  ImageSize size_;
  SharedFile file_;
  std::vector<std::uint8_t> pixels_;  ///< of the frame that is written
  std::uint64_t number_ = 0;
};

}  // namespace

std::unique_ptr<FrameSink> internal::open_shared(const std::string& name, const SinkOptions& options) {
  return std::make_unique<SharedFrameSink>(name, options.size);
}

struct SharedFrameReader::Memory {
  explicit Memory(const std::string& name)
      : path(path_of(name)), file(shm_open(path.c_str(), O_RDONLY, 0)), error(errno) {}
  const std::string path;
  const SharedFile file;
  const int error;  ///< of opening it
  ImageSize size;
};

SharedFrameReader::SharedFrameReader(const std::string& name) : memory_(std::make_unique<Memory>(name)) {
  if (memory_->file.get() < 0)
    throw shared_error(name, std::strerror(memory_->error), "start what writes it first");
  Header header{};
  const bool good = memory_->file.read(0, &header, sizeof header) &&
                    std::memcmp(header.magic, kMagic, sizeof kMagic) == 0 && header.channels == 3 &&
                    header.slots == kSharedSlots && header.width > 0 && header.height > 0 &&
                    header.width <= limits::kImagePixels && header.height <= limits::kImagePixels &&
                    std::int64_t(header.width) * header.height <= limits::kImagePixels;
  if (good) memory_->size = {int(header.width), int(header.height)};
  if (!good || total_bytes(memory_->size) != std::size_t(memory_->file.status().st_size))
    throw shared_error(name, "it does not hold frames of procam",
                       "name what project-live --output shm:NAME wrote");
}

SharedFrameReader::~SharedFrameReader() = default;

ImageSize SharedFrameReader::size() const {
  return memory_->size;
}

bool SharedFrameReader::is_orphan() const {
  const SharedFile now(shm_open(memory_->path.c_str(), O_RDONLY, 0));
  if (now.get() < 0) return true;
  const struct stat about = now.status();
  return about.st_ino != memory_->file.status().st_ino ||
         std::size_t(about.st_size) != total_bytes(memory_->size);
}

bool SharedFrameReader::read_newest(std::uint64_t after, SharedFrameReader::Frame& into) const {
  if (into.image.size() != memory_->size || into.image.channels() != 3)
    into.image = ImageU8(memory_->size, 3);
  const SharedFile& file = memory_->file;
  // A writer that overtakes a copy makes it void; five times in a row only one that never rests.
  for (int attempt = 0; attempt < 5; ++attempt) {
    std::uint64_t number = 0, still = 0;
    if (!file.read(offsetof(Header, newest), &number, sizeof number) || number <= after) return false;
    std::atomic_thread_fence(std::memory_order_acquire);
    const std::size_t at = slot_at(memory_->size, number);
    Slot slot{};
    if (!file.read(at, &slot, sizeof slot)) return false;
    if (slot.number != number) continue;
    std::atomic_thread_fence(std::memory_order_acquire);
    if (!file.read(at + kHeader, into.image.data(), pixel_bytes(memory_->size))) return false;
    std::atomic_thread_fence(std::memory_order_acquire);
    if (!file.read(at, &still, sizeof still)) return false;
    if (still != number) continue;
    into.time_s = slot.time_s;
    into.number = number;
    return true;
  }
  return false;
}

std::optional<SharedFrameReader::Frame> SharedFrameReader::newest(std::uint64_t after) const {
  SharedFrameReader::Frame frame;
  if (!read_newest(after, frame)) return std::nullopt;
  return frame;
}

}  // namespace procam::device
