#pragma once
/// The compression function of SHA-256, and the ways in which this processor can compute it.
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace procam::io {

using Sha256State = std::array<std::uint32_t, 8>;

/// Applies `count` blocks of 64 bytes to the state.
using CompressBlocks = void (*)(Sha256State& state, const unsigned char* data, std::size_t count);

/// In plain C++, then the faster ones. All give the same bytes.
const std::vector<CompressBlocks>& ways_to_compress();

std::string sha256(std::string_view bytes, CompressBlocks compress_blocks);

}  // namespace procam::io
