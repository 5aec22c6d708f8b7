#include "procam/io/point_pairs_file.hpp"

#include <algorithm>
#include <array>
#include <optional>

#include "number.hpp"
#include "procam/io/files.hpp"

namespace procam::io {
namespace {

constexpr std::array<const char*, 5> kColumns{"x", "y", "z", "u", "v"};

std::string trimmed(const std::string& text) {
  const auto first = text.find_first_not_of(" \t\r"), last = text.find_last_not_of(" \t\r");
  return first == std::string::npos ? "" : text.substr(first, last - first + 1);
}

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells(1);
  for (const char c : line)
    if (c == ',' || c == ';' || c == '\t')
      cells.emplace_back();
    else
      cells.back() += c;
  for (std::string& cell : cells) cell = trimmed(cell);
  return cells;
}

bool names_columns(const std::vector<std::string>& cells) {
  for (std::size_t i = 0; i < kColumns.size(); ++i)
    if (i >= cells.size() || cells[i] != kColumns[i]) return false;
  return true;
}

}  // namespace

std::vector<PointPair> parse_point_pairs(const std::string& text, const std::string& name) {
  std::vector<PointPair> pairs;
  int line_number = 0;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    std::string line = text.substr(at, end - at);
    at = end + 1;
    ++line_number;
    line = trimmed(line.substr(0, line.find('#')));
    if (line.empty()) continue;
    const std::vector<std::string> cells = cells_of(line);
    if (pairs.empty() && names_columns(cells)) continue;
    const std::string where = name + ", line " + std::to_string(line_number);
    const char* const expected =
        "write x, y, z in metres, then the pixel u, v, e.g. 1.35, 0.02, 2.417, 901, 140";
    if (cells.size() < kColumns.size() || cells.size() > kColumns.size() + 1)
      throw Error(ErrorKind::kInput, where, "it has " + std::to_string(cells.size()) + " columns", expected);
    std::array<double, 5> numbers{};
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      const auto number = parse_number(cells[i]);
      if (!number)
        throw Error(ErrorKind::kInput, where,
                    std::string("column ") + kColumns[i] + " is no number: '" + cells[i].substr(0, 40) + "'",
                    expected);
      numbers[i] = *number;
    }
    PointPair pair;
    pair.point_in_world = Vec3(numbers[0], numbers[1], numbers[2]);
    pair.pixel = Vec2(numbers[3], numbers[4]);
    if (cells.size() > kColumns.size()) pair.name = cells.back();
    pairs.push_back(pair);
  }
  if (pairs.empty())
    throw Error(ErrorKind::kInput, name, "it lists no point", "write a line x, y, z, u, v for each point");
  return pairs;
}

std::vector<PointPair> load_point_pairs(const std::filesystem::path& path) {
  constexpr std::size_t kLargest = std::size_t(16) << 20;
  return parse_point_pairs(read_file(path, kLargest), path.string());
}

}  // namespace procam::io
