#pragma once
/// Opening a named pipe waits for its writer, and some devices never end: readers take regular files only.
#include <filesystem>

#include "procam/core/base/error.hpp"

namespace procam::internal {

inline Error not_a_regular_file(const std::filesystem::path& path) {
  std::error_code ignored;
  const char* what = "a device";
  switch (std::filesystem::status(path, ignored).type()) {
    case std::filesystem::file_type::directory:
      what = "a folder (Is a directory)";
      break;
    case std::filesystem::file_type::fifo:
      what = "a named pipe";
      break;
    case std::filesystem::file_type::socket:
      what = "a socket";
      break;
    default:
      break;
  }
  return Error(ErrorKind::kIo, path.string(), std::string("it is ") + what + ", not a regular file",
               "name a regular file; write what a pipe gives into a file first");
}

/// Throws Error(kIo) for what is there and no regular file; for readers that open by name.
inline void require_regular_file(const std::filesystem::path& path) {
  std::error_code ignored;
  const std::filesystem::file_status status = std::filesystem::status(path, ignored);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status))
    throw not_a_regular_file(path);
}

}  // namespace procam::internal
