#pragma once
/// Functions of one point, bound for arrays of points.
#include <cmath>
#include <vector>

#include "convert.hpp"

namespace procam::python {

using Seen = py::array_t<bool>;

/// One call of `map` for each row of an (n, From) array: (n, To) array, NaN where there is no answer, and where there is.
template <int To, typename From, typename Map>
py::tuple mapped(const std::vector<From>& points, const Map& map) {
  py::array_t<double> out({py::ssize_t(points.size()), py::ssize_t(To)});
  Seen seen(py::ssize_t(points.size()));
  double* to = out.mutable_data();
  bool* is_seen = seen.mutable_data();
  for (const From& point : points) {
    const auto found = map(point);
    *is_seen++ = bool(found);
    for (int i = 0; i < To; ++i) *to++ = found ? (*found)[i] : std::nan("");
  }
  return py::make_tuple(out, seen);
}

inline constexpr const char* kMappedDoc =
    "(n points): the answers, NaN in rows without one, and a bool array (n,) of the rows\n"
    "that have one.";

}  // namespace procam::python
