#pragma once
/// Text in columns: separated by commas, semicolons or tabs; '#' begins a comment; empty lines are skipped.
#include <algorithm>
#include <string>
#include <vector>

#include "document/trimmed.hpp"

namespace procam::io {

inline std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells(1);
  for (const char c : line)
    if (c == ',' || c == ';' || c == '\t')
      cells.emplace_back();
    else
      cells.back() += c;
  for (std::string& cell : cells) cell = trimmed(cell);
  return cells;
}

struct TableLine {
  int number = 0;  ///< in the file, from 1
  std::vector<std::string> cells;
};

inline std::vector<TableLine> table_lines(const std::string& text) {
  std::vector<TableLine> lines;
  int number = 0;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::string line = text.substr(at, end - at);
    at = end + 1;
    ++number;
    const std::string content = trimmed(line.substr(0, line.find('#')));
    if (!content.empty()) lines.push_back({number, cells_of(content)});
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
