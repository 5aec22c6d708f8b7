#pragma once
#include <cstddef>
#include <string>
#include <string_view>

namespace procam::dds::internal {

/// zstd, or lz4 in its frame format, unpacked to `size` bytes. Throws Refusal (log_damaged) for bytes that do not unpack to
/// this size, Error(kUnsupported) in a build without the library.
std::string unpacked_zstd(std::string_view bytes, std::size_t size);
std::string unpacked_lz4(std::string_view bytes, std::size_t size);

/// How many bytes a zstd frame says it unpacks to; 0: it does not say.
std::size_t zstd_size(std::string_view bytes);

/// Throws Error(kUnsupported) in a build without the library.
std::string packed_zstd(std::string_view bytes);
bool has_zstd();

}  // namespace procam::dds::internal
