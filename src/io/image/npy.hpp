#pragma once
/// NumPy's .npy files (format 1.0 to 3.0): arrays of numbers, little-endian, in C order.
///
/// Read: integers of 1, 2, 4 and 8 bytes, floats of 4 and 8 bytes, bool; one to three dimensions, or a list
/// of records with named fields of these types. Everything becomes double; a 64-bit integer beyond 2^53 is
/// refused. Written: float64 in C order, or records of float64. Format: numpy.lib.format in NumPy's manual.
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace procam::io {

/// An array, or a table with named columns: `shape` is then {rows, columns}.
struct NpyArray {
  std::vector<std::size_t> shape;
  std::vector<double> values;        ///< C order: the last index runs fastest
  std::vector<std::string> columns;  ///< names of a table's columns; empty for a plain array
};

/// Throws Error(kIo) for a file that cannot be read, Error(kInput) for one that is no .npy file or is cut
/// short, Error(kUnsupported) for Fortran order, big-endian numbers, texts and objects.
NpyArray load_npy(const std::filesystem::path& path);
/// The same from the file's bytes; `name` stands in messages.
NpyArray parse_npy(std::string_view bytes, const std::string& name);

/// What stands before the numbers: `type` and `shape` as Python writes them. Version 1.0, or 3.0 where a name is not ASCII or the
/// header is long.
std::string npy_head(const std::string& type, const std::string& shape);

/// The bytes of a .npy file. Throws std::invalid_argument when the shape does not fit the values.
std::string format_npy(const NpyArray& array);

}  // namespace procam::io
