#include "session/observations_table.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "document/number.hpp"
#include "document/table.hpp"
#include "document/value.hpp"
#include "image/npy.hpp"
#include "procam/core/base/limits.hpp"
#include "procam/io/board_file.hpp"
#include "procam/io/text.hpp"

namespace procam::io::observations {
namespace {

constexpr const char* kNextTable =
    "give the columns view, device, point (or x, y, z), u, v and, where known, sigma; see "
    "docs/file-formats.md";

enum Column {
  kView,
  kDevice,
  kPoint,
  kX,
  kY,
  kZ,
  kU,
  kV,
  kSigma,
  kVarU,
  kCovUV,
  kVarV,
  kCamera,
  kCorrelated,
  kColumns
};
const std::array<const char*, kColumns> kNames{"view",   "device", "point",  "x",         "y",
                                               "z",      "u",      "v",      "sigma",     "var_u",
                                               "cov_uv", "var_v",  "camera", "correlated"};

std::string in_lower_case(std::string text) {
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = char(c + ('a' - 'A'));
  return text;
}

/// Position of every column in the file; -1 for those that are absent. A column without a name (the row numbers of a
/// data frame, a separator at the end of the line) is not used.
std::array<int, kColumns> find_columns(const std::vector<std::string>& names, const std::string& where) {
  std::array<int, kColumns> at{};
  at.fill(-1);
  if (std::count_if(names.begin(), names.end(),
                    [](const auto& name) { return parse_number(name).has_value(); }) > 1)
    fail_table(where, "it holds numbers, and a table begins with the names of its columns",
               "begin with a line like  view, device, point, u, v, sigma");
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i].empty()) continue;
    const auto known = std::find(kNames.begin(), kNames.end(), in_lower_case(names[i]));
    if (known == kNames.end())
      fail_table(where, "there is no column '" + names[i].substr(0, 40) + "'",
                 suggest(in_lower_case(names[i]), {kNames.begin(), kNames.end()}));
    int& place = at[std::size_t(known - kNames.begin())];
    if (place >= 0) fail_table(where, "the column '" + names[i] + "' stands there twice");
    place = int(i);
  }
  for (const Column column : {kView, kDevice, kU, kV})
    if (at[column] < 0) fail_table(where, std::string("the column '") + kNames[column] + "' is missing");
  const int positions = (at[kX] >= 0) + (at[kY] >= 0) + (at[kZ] >= 0);
  const int covariances = (at[kVarU] >= 0) + (at[kCovUV] >= 0) + (at[kVarV] >= 0);
  if ((at[kPoint] >= 0) == (positions > 0) || (positions != 0 && positions != 3))
    fail_table(where, "a point is named by the column 'point' or by the columns x, y and z");
  if ((covariances != 0 && covariances != 3) || (covariances > 0 && at[kSigma] >= 0))
    fail_table(where, "the uncertainty is the column 'sigma' or the columns var_u, cov_uv and var_v");
  return at;
}

/// What programs write for a value that they do not have.
bool is_absent(const std::string& cell) {
  const std::string text = in_lower_case(cell);
  return text.empty() || text == "nan" || text == "-nan" || text == "na" || text == "null" || text == "none";
}

/// Numbers of one row by column, wherever they come from, with their checks.
template <typename Number>
Row read_row(const std::array<int, kColumns>& at, const std::string& where, Number number) {
  Row row;
  row.where = where;
  row.pixel = Vec2(number(kU), number(kV));
  if (at[kPoint] >= 0) {
    const double point = number(kPoint);
    if (point != std::floor(point) || std::abs(point) > 1e9)
      fail_table(where, "column point is no whole number");
    row.point = int(point);
  } else {
    row.position = Vec3(number(kX), number(kY), number(kZ));
  }
  if (at[kSigma] >= 0) {
    const double sigma = number(kSigma);
    if (!(sigma > 1e-6 && sigma < 1e3))
      fail_table(where, "column sigma is not between 0.000001 and 1000 pixels");
    row.covariance = sigma * sigma * Mat2::Identity();
  }
  if (at[kCorrelated] >= 0) {
    const double correlated = number(kCorrelated);
    if (correlated != 0 && correlated != 1) fail_table(where, "column correlated is neither 0 nor 1");
    row.correlated = correlated == 1;
  }
  if (at[kVarU] >= 0) {
    const double uu = number(kVarU), uv = number(kCovUV), vv = number(kVarV);
    row.covariance << uu, uv, uv, vv;
    if (!(uu > 1e-12 && vv > 1e-12 && uu < 1e6 && vv < 1e6 && uu * vv - uv * uv > 1e-9 * uu * vv))
      fail_table(where, "var_u, cov_uv, var_v are no covariance of pixels: it is to be positive definite");
  }
  return row;
}

/// "# camera: left 1280x1024".
void read_statement(const std::string& comment, const std::string& where, ObservationsContext& stated) {
  const std::size_t colon = comment.find(':');
  if (colon == std::string::npos) return;
  const std::string keyword = trimmed(comment.substr(0, colon)), value = trimmed(comment.substr(colon + 1));
  if (keyword != "board" && keyword != "camera" && keyword != "projector") return;
  try {
    if (keyword == "board") {
      stated.board = parse_board(value);
      return;
    }
    const std::size_t blank = value.find_last_of(" \t");
    if (blank == std::string::npos)
      fail_table(where, "it does not give a name and a size", "write e.g. # camera: left 1280x1024");
    stated.devices.push_back({trimmed(value.substr(0, blank)),
                              keyword == "camera" ? DeviceKind::kCamera : DeviceKind::kProjector,
                              parse_size(value.substr(blank + 1))});
  } catch (const Error& error) {
    throw Error(error.kind(), where, error.subject() + ": " + error.why(), error.next());
  }
}

}  // namespace

void fail_table(const std::string& where, const std::string& why) {
  fail_table(where, why, kNextTable);
}

void fail_table(const std::string& where, const std::string& why, const std::string& next) {
  throw Error(ErrorKind::kInput, where, why, next);
}

Table table_of_csv(const std::string& file, const std::string& name) {
  const std::string text(without_byte_order_mark(file));
  if (text.find('\0') != std::string::npos)
    fail_table(name, "it is not UTF-8 text",
               "save the table as CSV in UTF-8; a spreadsheet's own file and UTF-16 are not read");
  Table table{name, false, {}, {}};
  std::array<int, kColumns> at{};
  std::size_t columns = 0;
  int line = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::string content = trimmed(text.substr(begin, end - begin));
    begin = end + 1;
    ++line;
    const std::size_t hash = content.find('#');
    const std::string where = name + ", line " + std::to_string(line);
    if (hash == 0) {
      read_statement(content.substr(1), where, table.stated);
      continue;
    }
    const std::string values = trimmed(content.substr(0, hash));
    if (values.empty()) continue;
    std::vector<std::string> cells = cells_of(values);
    if (columns == 0) {
      columns = cells.size();
      at = find_columns(cells, where);
      table.by_position = at[kX] >= 0;
      continue;
    }
    if (std::vector<std::string> decimal = cells_with_decimal_commas(values);
        cells.size() != columns && decimal.size() == columns)
      cells = std::move(decimal);
    if (cells.size() != columns)
      fail_table(where, "it has " + std::to_string(cells.size()) + " columns where the first line names " +
                            std::to_string(columns));
    if (table.rows.size() >= limits::kTableRows)
      fail_table(name, "it has more than " + std::to_string(limits::kTableRows) + " rows",
                 "give one session a file");
    const auto number = [&](Column column) {
      const std::string& cell = cells[std::size_t(at[column])];
      const auto value = parse_number(cell);
      if (!value)
        fail_table(where,
                   std::string("column ") + kNames[column] + " is no number: '" + cell.substr(0, 40) + "'",
                   is_absent(cell) ? "leave out the rows of points that were not found" : kNextTable);
      return *value;
    };
    Row row = read_row(at, where, number);
    row.view = cells[std::size_t(at[kView])];
    row.device = cells[std::size_t(at[kDevice])];
    if (at[kCamera] >= 0) row.camera = cells[std::size_t(at[kCamera])];
    for (const Column column : {kView, kDevice})
      if (cells[std::size_t(at[column])].empty())
        fail_table(where, std::string("column ") + kNames[column] + " is empty");
    table.rows.push_back(std::move(row));
  }
  return table;
}

Table table_of_npy(const NpyArray& array, const std::string& name) {
  if (array.shape.size() != 2)
    fail_table(name, "it is no table: it has " + std::to_string(array.shape.size()) + " dimensions");
  const std::size_t columns = array.shape[1], rows = array.shape[0];
  std::vector<std::string> names = array.columns;
  if (names.empty()) {
    if (columns < 5 || columns > 8)
      fail_table(name, "an array of " + std::to_string(columns) + " columns has no meaning here",
                 "give view, device, point, u, v [, sigma] or view, device, x, y, z, u, v [, sigma]");
    names = {"view", "device"};
    if (columns <= 6)
      names.emplace_back("point");
    else
      names.insert(names.end(), {"x", "y", "z"});
    names.insert(names.end(), {"u", "v"});
    if (columns % 2 == 0) names.emplace_back("sigma");
  }
  if (rows > limits::kTableRows)
    fail_table(name, "it has more than " + std::to_string(limits::kTableRows) + " rows");
  const std::array<int, kColumns> at = find_columns(names, name);
  Table table{name, at[kX] >= 0, {}, {}};
  for (std::size_t r = 0; r < rows; ++r) {
    const std::string where = name + ", row " + std::to_string(r);
    const auto number = [&](Column column) {
      const double value = array.values[r * columns + std::size_t(at[column])];
      if (!std::isfinite(value))
        fail_table(where, std::string("column ") + kNames[column] + " is not finite");
      return value;
    };
    const auto index = [&](Column column) -> std::string {
      const double value = number(column);
      if (value != std::floor(value) || value < 0 || value > 1e6)
        fail_table(where, std::string("column ") + kNames[column] + " is no whole number from 0");
      return std::to_string(int(value));
    };
    Row row = read_row(at, where, number);
    row.view = index(kView);
    row.device = index(kDevice);
    if (at[kCamera] >= 0) row.camera = index(kCamera);
    table.rows.push_back(std::move(row));
  }
  return table;
}

}  // namespace procam::io::observations
