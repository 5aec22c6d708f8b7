#pragma once
/// Text in columns: separated by commas, semicolons or tabs; '#' begins a comment; empty lines are skipped.
#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "document/trimmed.hpp"

namespace procam::io {

/// The cells between `separators`, without blanks at their ends. A cell in double quotes may hold separators (RFC 4180).
inline std::vector<std::string> cells_between(const std::string& line, std::string_view separators) {
  std::vector<std::string> cells(1);
  bool is_quoted = false;
  for (const char c : line)
    if (c == '"' && (is_quoted || trimmed(cells.back()).empty()))
      is_quoted = !is_quoted;
    else if (!is_quoted && separators.find(c) != std::string_view::npos)
      cells.emplace_back();
    else
      cells.back() += c;
  for (std::string& cell : cells) cell = trimmed(cell);
  return cells;
}

inline std::vector<std::string> cells_of(const std::string& line) {
  return cells_between(line, ",;\t");
}

/// The cells of a line whose commas are decimal ones, as spreadsheets write them in half of Europe (0,5;12,25): separated
/// by semicolons or tabs, each comma a point.
inline std::vector<std::string> cells_with_decimal_commas(const std::string& line) {
  std::vector<std::string> cells = cells_between(line, ";\t");
  for (std::string& cell : cells) std::replace(cell.begin(), cell.end(), ',', '.');
  return cells;
}

struct TableLine {
  int number = 0;  ///< in the file, from 1
  std::string text;
  std::vector<std::string> cells;
};

inline std::vector<TableLine> table_lines(const std::string& file) {
  const std::string text(without_byte_order_mark(file));
  std::vector<TableLine> lines;
  int number = 0;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::string line = text.substr(at, end - at);
    at = end + 1;
    ++number;
    const std::string content = trimmed(line.substr(0, line.find('#')));
    if (!content.empty()) lines.push_back({number, content, cells_of(content)});
  }
  return lines;
}

/// Does the line begin with these names?
template <typename Columns>
bool names_columns(const std::vector<std::string>& cells, const Columns& columns) {
  for (std::size_t i = 0; i < columns.size(); ++i)
    if (i >= cells.size() || cells[i] != columns[i]) return false;
  return true;
}

}  // namespace procam::io
