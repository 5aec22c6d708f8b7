#include "procam/io/session/point_pairs_file.hpp"

#include <array>
#include <optional>
#include <utility>

#include "document/number.hpp"
#include "document/table.hpp"
#include "procam/core/base/limits.hpp"
#include "procam/io/files.hpp"
#include "session/point_pairs_text.hpp"

namespace procam::io {
namespace {

constexpr std::array<const char*, 5> kPairColumns{"x", "y", "z", "u", "v"};

}  // namespace

std::vector<PointPair> parse_point_pairs(const std::string& text, const std::string& name) {
  std::vector<PointPair> pairs;
  for (auto [number, line, cells] : table_lines(text)) {
    if (pairs.empty() && names_columns(cells, kPairColumns)) continue;
    const std::string where = name + ", line " + std::to_string(number);
    const char* const expected =
        "write x, y, z in metres, then the pixel u, v, e.g. 1.35, 0.02, 2.417, 901, 140";
    const auto fits = [](std::size_t count) {
      return count == kPairColumns.size() || count == kPairColumns.size() + 1;
    };
    if (std::vector<std::string> decimal = cells_with_decimal_commas(line);
        !fits(cells.size()) && fits(decimal.size()))
      cells = std::move(decimal);
    if (!fits(cells.size()))
      throw Error(ErrorKind::kInput, where, "it has " + std::to_string(cells.size()) + " columns", expected);
    std::array<double, 5> numbers{};
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      const auto value = parse_number(cells[i]);
      if (!value)
        throw Error(
            ErrorKind::kInput, where,
            std::string("column ") + kPairColumns[i] + " is no number: '" + cells[i].substr(0, 40) + "'",
            expected);
      numbers[i] = *value;
    }
    PointPair pair;
    pair.point_in_world = Vec3(numbers[0], numbers[1], numbers[2]);
    pair.pixel = Vec2(numbers[3], numbers[4]);
    if (cells.size() > kPairColumns.size()) pair.name = cells.back();
    pairs.push_back(pair);
  }
  if (pairs.empty())
    throw Error(ErrorKind::kInput, name, "it lists no point", "write a line x, y, z, u, v for each point");
  return pairs;
}

std::vector<PointPair> load_point_pairs(const std::filesystem::path& path) {
  return parse_point_pairs(read_file(path, limits::kPointPairsBytes), path.string());
}

}  // namespace procam::io
