#include "procam/io/files.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <optional>
#include <random>

#include "procam/core/base/detail/regular_file.hpp"
#include "procam/core/base/error.hpp"

namespace procam::io {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail_to(const std::string& verb, const fs::path& path, int error, const std::string& next) {
  throw Error(ErrorKind::kIo, path.string(), "cannot " + verb + ": " + std::strerror(error), next);
}

const char* const kWriteNext = "name an output in an existing folder that you may write to";
const char* const kReadNext = "check the name and whether you may read it";

/// Closes on every way out.
class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (number_ >= 0) ::close(number_);
  }
  int get() const { return number_; }
  bool close() {
    const int number = number_;
    number_ = -1;
    return ::close(number) == 0;
  }

 private:
  int number_;
};

/// 0, or the system's error number.
int write_all(int descriptor, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor, bytes.data(), bytes.size());
    if (written < 0 && errno != EINTR) return errno;
    if (written > 0) bytes.remove_prefix(std::size_t(written));
  }
  return 0;
}

void write_directly(const fs::path& path, std::string_view bytes) {
  const Descriptor file(::open(path.c_str(), O_WRONLY | O_CLOEXEC));
  if (file.get() < 0) fail_to("write", path, errno, kWriteNext);
  if (const int error = write_all(file.get(), bytes)) fail_to("write", path, error, kWriteNext);
}

/// Makes the rename itself survive a power cut; not every file system can, so failure is no error.
void flush_folder(const fs::path& folder) {
  const Descriptor descriptor(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (descriptor.get() >= 0) (void)::fsync(descriptor.get());
}

/// Where a write goes: the file behind a link.
struct Destination {
  fs::path target, folder;
};

Destination destination_of(const fs::path& path) {
  std::error_code ignored;
  if (fs::is_directory(fs::status(path, ignored)))
    fail_to("write", path, EISDIR, "name a file, not a folder");
  Destination destination;
  destination.target = fs::is_symlink(fs::symlink_status(path, ignored)) ? fs::weakly_canonical(path) : path;
  destination.folder =
      destination.target.has_parent_path() ? destination.target.parent_path() : fs::path(".");
  return destination;
}

/// A new file under a temporary name beside the destination; `path` is how errors call that.
class Temporary {
 public:
  Temporary(const Destination& destination, const fs::path& path) {
    // Random names: one that a killed process left behind must not stand in the way of a later one.
    std::random_device random;
    // A name has at most 255 bytes.
    const std::string begin = "." + destination.target.filename().string().substr(0, 200) + ".tmp-";
    struct stat old {};
    const bool replaces = ::stat(destination.target.c_str(), &old) == 0 && S_ISREG(old.st_mode);
    int file = -1;
    for (int attempt = 0; file < 0 && attempt < 100; ++attempt) {
      name_ = destination.folder / (begin + std::to_string(random()) + std::to_string(random()));
      file = ::open(name_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, replaces ? 0600 : 0666);
      if (file < 0 && errno != EEXIST) break;
    }
    if (file < 0) fail_to("write", path, errno, kWriteNext);
    file_.emplace(file);
    if (replaces) take_mode(old);
  }
  Temporary(const Temporary&) = delete;
  Temporary& operator=(const Temporary&) = delete;
  ~Temporary() {
    if (!name_.empty()) ::unlink(name_.c_str());
  }

  /// 0, or the system's error number.
  int write(std::string_view bytes) {
    if (const int error = write_all(file_->get(), bytes)) return error;
    if (::fsync(file_->get()) != 0) return errno;
    return file_->close() ? 0 : errno;
  }
  int rename_to(const fs::path& target) {
    if (::rename(name_.c_str(), target.c_str()) != 0) return errno;
    name_.clear();
    return 0;
  }

 private:
  /// A file that is replaced keeps its group and mode; where the system refuses the group, it gets no rights.
  void take_mode(const struct stat& old) {
    struct stat mine {};
    (void)::fstat(file_->get(), &mine);
    mode_t mode = old.st_mode & 0777;
    if (mine.st_gid != old.st_gid && ::fchown(file_->get(), uid_t(-1), old.st_gid) != 0) mode &= ~070u;
    (void)::fchmod(file_->get(), mode);  // not every file system has modes
  }

  fs::path name_;
  std::optional<Descriptor> file_;
};

bool is_device(const fs::path& path) {
  std::error_code ignored;
  const fs::file_status status = fs::status(path, ignored);
  return fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status);
}

}  // namespace

void write_file_atomically(const fs::path& path, std::string_view bytes) {
  // Renaming onto a device or a pipe would replace it by a file.
  if (is_device(path)) return write_directly(path, bytes);
  const Destination destination = destination_of(path);
  Temporary file(destination, path);
  int error = file.write(bytes);
  if (error == 0) error = file.rename_to(destination.target);
  if (error != 0) fail_to("write", path, error, kWriteNext);
  flush_folder(destination.folder);
}

void require_writable(const fs::path& path) {
  if (is_device(path)) return;
  const Temporary file(destination_of(path), path);
}

std::string read_file(const fs::path& path, std::size_t largest_size) {
  // Without waiting: opening a named pipe would wait for its writer.
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  const int error = errno;
  struct stat about {};
  // A socket cannot be opened at all.
  if (file.get() < 0 && error != ENXIO) fail_to("read", path, error, kReadNext);
  if (file.get() < 0 || (::fstat(file.get(), &about) == 0 && !S_ISREG(about.st_mode)))
    throw procam::internal::not_a_regular_file(path);
  std::string bytes;
  constexpr std::size_t kBlock = std::size_t(1) << 16;
  for (;;) {
    const std::size_t used = bytes.size();
    bytes.resize(used + kBlock);
    const ssize_t count = ::read(file.get(), bytes.data() + used, kBlock);
    if (count < 0 && errno != EINTR) fail_to("read", path, errno, kReadNext);
    bytes.resize(used + std::size_t(count > 0 ? count : 0));
    if (bytes.size() > largest_size)
      throw Error(
          ErrorKind::kInput, path.string(),
          "it is larger than the " + std::to_string(largest_size) + " bytes that such a file may have",
          "check that this is the file you mean");
    if (count == 0) return bytes;
  }
}

bool natural_less(std::string_view a, std::string_view b) {
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  std::size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    if (!is_digit(a[i]) || !is_digit(b[j])) {
      if (a[i] != b[j]) return static_cast<unsigned char>(a[i]) < static_cast<unsigned char>(b[j]);
      ++i, ++j;
      continue;
    }
    while (i < a.size() && a[i] == '0') ++i;
    while (j < b.size() && b[j] == '0') ++j;
    std::size_t i_end = i, j_end = j;
    while (i_end < a.size() && is_digit(a[i_end])) ++i_end;
    while (j_end < b.size() && is_digit(b[j_end])) ++j_end;
    // Without leading zeros the longer number is the larger; of any length, so no conversion can overflow.
    if (i_end - i != j_end - j) return i_end - i < j_end - j;
    const int order = a.substr(i, i_end - i).compare(b.substr(j, j_end - j));
    if (order != 0) return order < 0;
    i = i_end, j = j_end;
  }
  if (i < a.size() || j < b.size()) return i == a.size();
  return a < b;  // equal but for leading zeros: a strict order all the same
}

}  // namespace procam::io
