#pragma once
/// The families of square markers that procam knows, by short name: ArUco's and AprilTag's.
///
/// A marker is a black square with a grid of `cells` x `cells` black and white cells inside a black border
/// one cell wide; its size is the side of the black square, border included, without the white rim. Which
/// cells are white is a matter of the detector (detect/marker.hpp); here are the names, for command lines and
/// files.
#include <array>
#include <string>

#include "procam/core/error.hpp"

namespace procam {

enum class MarkerDictionary {
  k4x4_50,
  k4x4_100,
  k4x4_250,
  k4x4_1000,
  k5x5_50,
  k5x5_100,
  k5x5_250,
  k5x5_1000,
  k6x6_50,
  k6x6_100,
  k6x6_250,
  k6x6_1000,
  k7x7_50,
  k7x7_100,
  k7x7_250,
  k7x7_1000,
  kArucoOriginal,
  kAprilTag16h5,
  kAprilTag25h9,
  kAprilTag36h10,
  kAprilTag36h11
};

struct MarkerDictionaryInfo {
  MarkerDictionary dictionary;
  const char* name;
  int cells;  ///< per side, without the black border
  int count;  ///< ids are 0 .. count - 1
};

/// All of them, in the order of the enumerators.
inline constexpr std::array<MarkerDictionaryInfo, 21> kMarkerDictionaries{{
    {MarkerDictionary::k4x4_50, "4x4_50", 4, 50},
    {MarkerDictionary::k4x4_100, "4x4_100", 4, 100},
    {MarkerDictionary::k4x4_250, "4x4_250", 4, 250},
    {MarkerDictionary::k4x4_1000, "4x4_1000", 4, 1000},
    {MarkerDictionary::k5x5_50, "5x5_50", 5, 50},
    {MarkerDictionary::k5x5_100, "5x5_100", 5, 100},
    {MarkerDictionary::k5x5_250, "5x5_250", 5, 250},
    {MarkerDictionary::k5x5_1000, "5x5_1000", 5, 1000},
    {MarkerDictionary::k6x6_50, "6x6_50", 6, 50},
    {MarkerDictionary::k6x6_100, "6x6_100", 6, 100},
    {MarkerDictionary::k6x6_250, "6x6_250", 6, 250},
    {MarkerDictionary::k6x6_1000, "6x6_1000", 6, 1000},
    {MarkerDictionary::k7x7_50, "7x7_50", 7, 50},
    {MarkerDictionary::k7x7_100, "7x7_100", 7, 100},
    {MarkerDictionary::k7x7_250, "7x7_250", 7, 250},
    {MarkerDictionary::k7x7_1000, "7x7_1000", 7, 1000},
    {MarkerDictionary::kArucoOriginal, "aruco_original", 5, 1024},
    {MarkerDictionary::kAprilTag16h5, "apriltag_16h5", 4, 30},
    {MarkerDictionary::kAprilTag25h9, "apriltag_25h9", 5, 35},
    {MarkerDictionary::kAprilTag36h10, "apriltag_36h10", 6, 2320},
    {MarkerDictionary::kAprilTag36h11, "apriltag_36h11", 6, 587},
}};

inline const MarkerDictionaryInfo& info(MarkerDictionary dictionary) {
  return kMarkerDictionaries[std::size_t(dictionary)];
}

inline const char* to_string(MarkerDictionary dictionary) {
  return info(dictionary).name;
}

/// Throws Error(kUnsupported) with the names there are.
inline MarkerDictionary marker_dictionary_named(const std::string& name) {
  std::string known;
  for (const MarkerDictionaryInfo& row : kMarkerDictionaries) {
    if (name == row.name) return row.dictionary;
    known += (known.empty() ? "" : ", ") + std::string(row.name);
  }
  throw Error(ErrorKind::kUnsupported, "marker dictionary '" + name + "'", "there is no such dictionary",
              "use one of: " + known);
}

}  // namespace procam
