#include "procam/device/shared_frame.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>

#include "sinks.hpp"

namespace procam::device {
namespace {

constexpr char kMagic[8] = {'P', 'R', 'O', 'C', 'A', 'M', 'F', '1'};
constexpr std::uint32_t kSharedSlots = 3;
constexpr std::size_t kHeader = 64;

struct Header {
  char magic[8];
  std::uint32_t width, height, channels, slots;
  std::atomic<std::uint64_t> newest;
};
struct Slot {
  std::atomic<std::uint64_t> number;
  double time_s;
};
static_assert(sizeof(Header) <= kHeader && sizeof(Slot) <= kHeader);
static_assert(std::atomic<std::uint64_t>::is_always_lock_free);

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

Slot& slot_of(void* memory, ImageSize size, std::uint64_t number) {
  return *reinterpret_cast<Slot*>(static_cast<char*>(memory) + kHeader +
                                  (number % kSharedSlots) * slot_bytes(size));
}
char* pixels_of(Slot& slot) {
  return reinterpret_cast<char*>(&slot) + kHeader;
}

class SharedFrameSink : public FrameSink {
 public:
  SharedFrameSink(const std::string& name, ImageSize size) : name_(path_of(name)), size_(size) {
    // A new object: readers of one that an earlier run left keep theirs, and see no frame of another size.
    shm_unlink(name_.c_str());
    const int file = shm_open(name_.c_str(), O_CREAT | O_EXCL | O_RDWR, 0600);
    if (file < 0) throw shared_error(name, std::strerror(errno), "give another name");
    const std::size_t bytes = total_bytes(size);
    // posix_fallocate, not ftruncate: memory that is not there is told now, and not by a signal.
    const int failed = posix_fallocate(file, 0, off_t(bytes));
    if (failed == 0) memory_ = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    close(file);
    if (failed != 0 || memory_ == MAP_FAILED) {
      shm_unlink(name_.c_str());
      throw shared_error(name, std::strerror(failed != 0 ? failed : errno), "free some of /dev/shm");
    }
    auto* header = static_cast<Header*>(memory_);
    header->width = std::uint32_t(size.width);
    header->height = std::uint32_t(size.height);
    header->channels = 3;
    header->slots = kSharedSlots;
    std::memcpy(header->magic, kMagic, sizeof kMagic);
  }
  ~SharedFrameSink() override {
    munmap(memory_, total_bytes(size_));
    shm_unlink(name_.c_str());
  }
  SharedFrameSink(const SharedFrameSink&) = delete;
  SharedFrameSink& operator=(const SharedFrameSink&) = delete;

  ImageSize size() const override { return size_; }
  double show(ViewU8 picture) override {
    internal::require_frame(picture, size_);
    Slot& slot = slot_of(memory_, size_, ++number_);
    slot.number.store(0, std::memory_order_relaxed);
    std::atomic_thread_fence(std::memory_order_release);  // the zero before the pixels
    internal::copy_rgb(picture, reinterpret_cast<std::uint8_t*>(pixels_of(slot)));
    slot.time_s = now_s();
    slot.number.store(number_, std::memory_order_release);
    static_cast<Header*>(memory_)->newest.store(number_, std::memory_order_release);
    return slot.time_s;
  }

 private:
  std::string name_;
  ImageSize size_;
  void* memory_ = MAP_FAILED;
  std::uint64_t number_ = 0;
};

}  // namespace

std::unique_ptr<FrameSink> internal::open_shared(const std::string& name, const SinkOptions& options) {
  return std::make_unique<SharedFrameSink>(name, options.size);
}

struct SharedFrameReader::Memory {
  std::string path;
  ino_t object = 0;  ///< tells a new one under the same name
  void* data = nullptr;
  ImageSize size;
};

SharedFrameReader::SharedFrameReader(const std::string& name) : memory_(std::make_unique<Memory>()) {
  memory_->path = path_of(name);
  const int file = shm_open(memory_->path.c_str(), O_RDONLY, 0);
  if (file < 0) throw shared_error(name, std::strerror(errno), "start what writes it first");
  struct stat about {};
  fstat(file, &about);
  memory_->object = about.st_ino;
  const std::size_t bytes = std::size_t(about.st_size);
  void* data = bytes < kHeader ? MAP_FAILED : mmap(nullptr, bytes, PROT_READ, MAP_SHARED, file, 0);
  close(file);
  const auto* header = static_cast<const Header*>(data);
  bool good = data != MAP_FAILED && std::memcmp(header->magic, kMagic, sizeof kMagic) == 0 &&
              header->channels == 3 && header->slots == kSharedSlots && header->width < 65536 &&
              header->height < 65536;
  if (good) {
    memory_->size = {int(header->width), int(header->height)};
    good = total_bytes(memory_->size) == bytes;
  }
  if (!good) {
    if (data != MAP_FAILED) munmap(data, bytes);
    throw shared_error(name, "it does not hold frames of procam",
                       "name what project-live --output shm:NAME wrote");
  }
  memory_->data = data;
}

SharedFrameReader::~SharedFrameReader() {
  munmap(memory_->data, total_bytes(memory_->size));
}

ImageSize SharedFrameReader::size() const {
  return memory_->size;
}

bool SharedFrameReader::is_orphan() const {
  const int file = shm_open(memory_->path.c_str(), O_RDONLY, 0);
  if (file < 0) return true;
  struct stat about {};
  const bool is_known = fstat(file, &about) == 0 && about.st_ino == memory_->object;
  close(file);
  return !is_known;
}

bool SharedFrameReader::read_newest(std::uint64_t after, SharedFrameReader::Frame& into) const {
  if (into.image.size() != memory_->size || into.image.channels() != 3)
    into.image = ImageU8(memory_->size, 3);
  // A writer that overtakes a copy makes it void; five times in a row only one that never rests.
  for (int attempt = 0; attempt < 5; ++attempt) {
    const std::uint64_t number = static_cast<Header*>(memory_->data)->newest.load(std::memory_order_acquire);
    if (number <= after) return false;
    Slot& slot = slot_of(memory_->data, memory_->size, number);
    if (slot.number.load(std::memory_order_acquire) != number) continue;
    std::memcpy(into.image.data(), pixels_of(slot), pixel_bytes(memory_->size));
    into.time_s = slot.time_s;
    std::atomic_thread_fence(std::memory_order_acquire);
    if (slot.number.load(std::memory_order_relaxed) != number) continue;
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
