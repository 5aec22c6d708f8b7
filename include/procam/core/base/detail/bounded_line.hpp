#pragma once
/// std::getline() with a bound: a line without an end must not fill the memory.
#include <istream>
#include <string>

namespace procam::internal {

enum class LineEnd {
  kLineFeed,
  kCut,     ///< the file ended first; with an empty line there was nothing left
  kTooLong  ///< the line has more bytes than allowed; the rest of it was not read
};

/// Reads up to the line feed, which is taken and not kept. Sets badbit when the file cannot be read.
inline LineEnd read_bounded_line(std::istream& file, std::string& line, std::size_t max_bytes) {
  using Letters = std::streambuf::traits_type;
  line.clear();
  std::streambuf& bytes = *file.rdbuf();
  try {
    for (int letter = bytes.sbumpc(); letter != Letters::eof(); letter = bytes.sbumpc()) {
      if (letter == '\n') return LineEnd::kLineFeed;
      if (line.size() == max_bytes) return LineEnd::kTooLong;
      line.push_back(Letters::to_char_type(letter));
    }
  } catch (const std::ios_base::failure&) {  // as libstdc++ reports what the system does not read
    file.setstate(std::ios_base::badbit);
  }
  return LineEnd::kCut;
}

}  // namespace procam::internal
