#pragma once
/// How alike two names are, for suggestions.
#include <algorithm>
#include <string>
#include <vector>

namespace procam::internal {

/// Edits (insert, delete, replace, swap of neighbours) from a to b: the optimal string alignment distance.
inline int edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::vector<int>> d(a.size() + 1, std::vector<int>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i)
    for (std::size_t j = 0; j <= b.size(); ++j) {
      if (i == 0 || j == 0) {
        d[i][j] = int(i + j);
        continue;
      }
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + int(a[i - 1] != b[j - 1])});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
    }
  return d[a.size()][b.size()];
}

/// The known name with the fewest edits from `name`, at most 1 + a third of its length; empty when there is none.
inline std::string nearest_name(const std::string& name, const std::vector<std::string>& known) {
  std::string nearest;
  int fewest_edits = 0;
  // A hostile name may be megabytes long, and the table of edits is its length squared.
  if (name.size() > 64) return nearest;
  for (const std::string& candidate : known) {
    const int edits = edit_distance(name, candidate);
    if (edits <= 1 + int(candidate.size()) / 3 && (nearest.empty() || edits < fewest_edits)) {
      nearest = candidate;
      fewest_edits = edits;
    }
  }
  return nearest;
}

/// "did you mean 'gray'? " for the nearest of the known names; empty when none is near.
inline std::string did_you_mean(const std::string& name, const std::vector<std::string>& known) {
  const std::string nearest = nearest_name(name, known);
  return nearest.empty() ? "" : "did you mean '" + nearest + "'? ";
}

}  // namespace procam::internal
