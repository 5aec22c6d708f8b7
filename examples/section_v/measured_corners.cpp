#include "measured_corners.hpp"

#include <array>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

#include "document/number.hpp"
#include "document/table.hpp"
#include "procam/core/base/error.hpp"
#include "procam/io/files.hpp"

namespace procam::section_v {
namespace {

using namespace io;

constexpr std::array<const char*, 9> kCornerColumns{"sheet",         "placement",   "distance_m",
                                                    "incidence_deg", "corner",      "physical_x",
                                                    "physical_y",    "projected_x", "projected_y"};

}  // namespace

std::vector<MeasuredCorner> parse_measured_corners(const std::string& text, const std::string& name,
                                                   double unit) {
  require(unit > 0 && std::isfinite(unit), "parse_measured_corners: a positive unit");
  std::vector<MeasuredCorner> corners;
  std::set<std::tuple<std::string, int, int>> seen;
  std::map<std::string, double> incidence_of;
  for (const TableLine& line : table_lines(text)) {
    const std::vector<std::string>& cells = line.cells;
    if (corners.empty() && names_columns(cells, kCornerColumns)) continue;
    const std::string where = name + ", line " + std::to_string(line.number);
    const char* const expected =
        "write sheet, placement, distance_m, incidence_deg, corner (1 to 4), then the corner's own x, y and "
        "where its light landed, e.g. A4, 1, 1.2, 47, 1, 0, 0, 0.3, -0.8";
    if (cells.size() != kCornerColumns.size())
      throw Error(ErrorKind::kInput, where, "it has " + std::to_string(cells.size()) + " columns, not 9",
                  expected);
    std::array<double, 9> numbers{};
    for (std::size_t i = 1; i < numbers.size(); ++i) {
      const auto value = parse_number(cells[i]);
      if (!value)
        throw Error(
            ErrorKind::kInput, where,
            std::string("column ") + kCornerColumns[i] + " is no number: '" + cells[i].substr(0, 40) + "'",
            expected);
      numbers[i] = *value;
    }
    const auto refuse = [&](std::size_t column, const std::string& why) {
      throw Error(
          ErrorKind::kInput, where,
          std::string("column ") + kCornerColumns[column] + " is " + cells[column].substr(0, 40) + ": " + why,
          expected);
    };
    if (cells[0].empty()) refuse(0, "a sheet needs a name");
    if (numbers[1] != std::floor(numbers[1]) || std::abs(numbers[1]) > 1e6)
      refuse(1, "a whole number is meant");
    if (!(numbers[2] > 0 && numbers[2] <= 1000)) refuse(2, "metres above 0 are meant");
    if (!(numbers[3] >= 0 && numbers[3] < 90)) refuse(3, "degrees from 0 to below 90 are meant");
    if (numbers[4] != std::floor(numbers[4]) || numbers[4] < 1 || numbers[4] > 4)
      refuse(4, "1 to 4 is meant");
    for (std::size_t i = 5; i < 9; ++i)
      if (std::abs(numbers[i] * unit) > 100) refuse(i, "that is beyond 100 m; look at the units");
    MeasuredCorner corner;
    corner.sheet = cells[0];
    corner.placement = int(numbers[1]);
    corner.distance = numbers[2];
    corner.incidence_deg = numbers[3];
    corner.corner = int(numbers[4]) - 1;
    corner.physical = unit * Vec2(numbers[5], numbers[6]);
    corner.projected = unit * Vec2(numbers[7], numbers[8]);
    if (!seen.insert({corner.sheet, corner.placement, corner.corner}).second)
      throw Error(ErrorKind::kInput, where, "that corner of that placement is in the file already",
                  "give repeated measurements placement numbers of their own");
    if (incidence_of.emplace(corner.sheet, corner.incidence_deg).first->second != corner.incidence_deg)
      refuse(3, "an earlier line gives sheet '" + corner.sheet + "' another angle; name it otherwise");
    corners.push_back(corner);
  }
  if (corners.empty())
    throw Error(ErrorKind::kInput, name, "it lists no corner",
                "write a line for each corner that was measured");
  return corners;
}

std::vector<MeasuredCorner> load_measured_corners(const std::filesystem::path& path, double unit) {
  constexpr std::size_t kLargest = std::size_t(16) << 20;
  return parse_measured_corners(read_file(path, kLargest), path.string(), unit);
}

std::string format_measured_corners(const std::vector<MeasuredCorner>& corners, double unit) {
  std::string text;
  for (std::size_t i = 0; i < kCornerColumns.size(); ++i)
    text += (i > 0 ? ", " : "") + std::string(kCornerColumns[i]);
  text += "\n";
  for (const MeasuredCorner& c : corners) {
    text += c.sheet + ", " + std::to_string(c.placement);
    for (double value : {c.distance, c.incidence_deg}) text += ", " + format_number(value);
    text += ", " + std::to_string(c.corner + 1);
    for (double value : {c.physical.x(), c.physical.y(), c.projected.x(), c.projected.y()})
      text += ", " + format_number(value / unit);
    text += "\n";
  }
  return text;
}

}  // namespace procam::section_v
