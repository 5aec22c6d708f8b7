#pragma once
/// Tables for numpy.
#include <string>

#include "procam/core/base/export.hpp"

namespace procam::io {

/// A table with a header line (CSV, RFC 4180, UTF-8) as the bytes of a .npy file: an array of records whose fields are the
/// columns. A column of whole numbers is int64, one of numbers float64 (an empty cell: NaN), any other a text of as many
/// characters as its longest cell. Format: numpy.lib.format 1.0, or 3.0 where a column's name is not ASCII. Throws Error(kInput)
/// for a table without a header line, with a row of another length, or with a quote that does not end.
PROCAM_EXPORT std::string npy_of_csv(const std::string& csv);

}  // namespace procam::io
