#include <algorithm>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <limits>
#include <vector>

#include "image/npy.hpp"
#include "procam/core/base/error.hpp"
#include "procam/io/csv_table.hpp"

namespace procam::io {
namespace {

using Row = std::vector<std::string>;

[[noreturn]] void refuse_table(const std::string& why, const std::string& next) {
  throw Error(ErrorKind::kInput, "table", why, next);
}

/// Rows of RFC 4180: cells in quotes may hold separators, line ends and doubled quotes.
std::vector<Row> rows_of(const std::string& csv) {
  std::vector<Row> rows;
  Row row(1);
  bool quoted = false, any = false;
  for (std::size_t i = 0; i < csv.size(); ++i) {
    const char c = csv[i];
    if (quoted) {
      if (c != '"')
        row.back() += c;
      else if (i + 1 < csv.size() && csv[i + 1] == '"')
        row.back() += csv[++i];
      else
        quoted = false;
      continue;
    }
    if (c == '\r' && i + 1 < csv.size() && csv[i + 1] == '\n') continue;
    if (c == '\n') {
      if (any) rows.push_back(std::move(row));
      row = Row(1);
      any = false;
      continue;
    }
    any = true;
    if (c == '"' && row.back().empty())
      quoted = true;
    else if (c == ',')
      row.emplace_back();
    else
      row.back() += c;
  }
  if (quoted) refuse_table("a quote does not end", "close it, and double quotes within a cell");
  if (any) rows.push_back(std::move(row));
  return rows;
}

template <typename Number>
bool is_number(const std::string& text, Number& number) {
  const char *begin = text.data(), *end = begin + text.size();
  const auto [stop, failure] = std::from_chars(begin, end, number);
  return failure == std::errc() && stop == end;
}

/// The code points of UTF-8; a byte that begins none counts as U+FFFD.
std::u32string code_points(const std::string& text) {
  std::u32string out;
  for (std::size_t i = 0; i < text.size();) {
    const auto lead = static_cast<unsigned char>(text[i++]);
    const int more = lead < 0x80         ? 0
                     : lead >> 5 == 0x6  ? 1
                     : lead >> 4 == 0xe  ? 2
                     : lead >> 3 == 0x1e ? 3
                                         : -1;
    char32_t code = more < 0 ? 0xfffd : more == 0 ? lead : lead & (0x3fu >> more);
    for (int k = 0; k < more; ++k) {
      if (i >= text.size() || (static_cast<unsigned char>(text[i]) & 0xc0) != 0x80) {
        code = 0xfffd;
        break;
      }
      code = code << 6 | (static_cast<unsigned char>(text[i++]) & 0x3f);
    }
    out += code;
  }
  return out;
}

struct Column {
  enum class Kind { kWhole, kReal, kText } kind = Kind::kWhole;
  std::size_t characters = 1;  ///< of a text

  void add(const std::string& cell) {
    std::int64_t whole = 0;
    double real = 0;
    if (kind == Kind::kWhole && !is_number(cell, whole)) kind = Kind::kReal;
    if (kind == Kind::kReal && !cell.empty() && !is_number(cell, real)) kind = Kind::kText;
    characters = std::max(characters, code_points(cell).size());
  }
  std::string type() const {
    return kind == Kind::kWhole ? "<i8" : kind == Kind::kReal ? "<f8" : "<U" + std::to_string(characters);
  }
  void write(const std::string& cell, std::string& bytes) const {
    const auto append = [&](const auto& value) {
      bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
    };
    std::int64_t whole = 0;
    double real = std::numeric_limits<double>::quiet_NaN();
    if (kind == Kind::kText) {
      std::u32string text = code_points(cell);
      text.resize(characters);
      for (const char32_t c : text) append(c);
    } else if (kind == Kind::kReal) {
      if (!is_number(cell, real)) real = std::numeric_limits<double>::quiet_NaN();
      append(real);
    } else {
      is_number(cell, whole);
      append(whole);
    }
  }
};

/// As a string of Python.
std::string python_string(const std::string& text) {
  std::string out = "'";
  for (const char c : text) {
    if (c == '\n') {
      out += "\\n";
      continue;
    }
    if (c == '\'' || c == '\\') out += '\\';
    out += c;
  }
  return out + "'";
}

}  // namespace

std::string npy_of_csv(const std::string& csv) {
  const std::vector<Row> rows = rows_of(csv);
  if (rows.empty()) refuse_table("it has no header line", "write the names of the columns first");
  const Row& names = rows.front();
  std::vector<Column> columns(names.size());
  for (std::size_t r = 1; r < rows.size(); ++r) {
    if (rows[r].size() != names.size())
      refuse_table("row " + std::to_string(r) + " has " + std::to_string(rows[r].size()) +
                       " cells, the header " + std::to_string(names.size()),
                   "give every row a cell for each column");
    for (std::size_t c = 0; c < columns.size(); ++c) columns[c].add(rows[r][c]);
  }
  std::string description;
  for (std::size_t c = 0; c < columns.size(); ++c)
    description += (c > 0 ? ", (" : "(") + python_string(names[c]) + ", '" + columns[c].type() + "')";
  std::string bytes = npy_head("[" + description + "]", std::to_string(rows.size() - 1) + ",");
  for (std::size_t r = 1; r < rows.size(); ++r)
    for (std::size_t c = 0; c < columns.size(); ++c) columns[c].write(rows[r][c], bytes);
  return bytes;
}

}  // namespace procam::io
