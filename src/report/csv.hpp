#pragma once
/// Cells and lines of a table as CSV (RFC 4180); '.' is the decimal point in every locale.
#include <cmath>
#include <string>
#include <vector>

#include "procam/core/base/words.hpp"

namespace procam::report {

/// Quoted where the text has a separator, a quote or a line's end.
inline std::string csv_quoted(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? "\"\"" : std::string(1, c);
  return out + "\"";
}

/// Nothing for a value that is not finite.
inline std::string csv_number(double value) {
  return std::isfinite(value) ? shortest(value, 12) : "";
}

inline void add_csv_row(std::string& table, const std::vector<std::string>& cells) {
  for (std::size_t i = 0; i < cells.size(); ++i) table += (i > 0 ? "," : "") + cells[i];
  table += "\n";
}

}  // namespace procam::report
