#pragma once
/// Files as whole things: read at once, written at once or not at all, named by their contents.
#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include "procam/core/base/export.hpp"
#include "procam/core/base/limits.hpp"

namespace procam::io {

/// Writes through a temporary name in the same directory, flushed to the disk and renamed: a reader sees the
/// old file or the new one, never half of it. A link is followed; a device (/dev/null) is written directly.
/// Throws Error(kIo) naming the file and the system's reason; nothing is left behind then.
PROCAM_EXPORT void write_file_atomically(const std::filesystem::path& path, std::string_view bytes);

/// Before long work: throws what write_file_atomically() would throw for this path, and leaves nothing
/// behind.
PROCAM_EXPORT void require_writable(const std::filesystem::path& path);

/// The whole file. Throws Error(kIo) when it cannot be read, Error(kInput) when it is larger than
/// `largest_size` bytes.
PROCAM_EXPORT std::string read_file(const std::filesystem::path& path,
                                    std::size_t largest_size = limits::kFileBytes);

/// SHA-256 (FIPS 180-4), lower-case hex.
PROCAM_EXPORT std::string sha256(std::string_view bytes);
PROCAM_EXPORT std::string sha256_of_file(const std::filesystem::path& path);

/// Order in which people number: digit runs compare as numbers, so frame_2 comes before frame_10.
PROCAM_EXPORT bool natural_less(std::string_view a, std::string_view b);

}  // namespace procam::io
