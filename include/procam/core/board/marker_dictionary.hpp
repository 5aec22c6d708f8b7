#pragma once
/// The dictionaries of square markers by name: which codes a board's markers are taken from. The codes
/// themselves belong to detect, which prints and reads them.
#include <optional>
#include <string>

namespace procam {

/// ArUco's predefined dictionaries and the AprilTag families.
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
  const char* name;  ///< as people type it
  int bits;          ///< code bits a side; the marker is two modules wider, with its black border
  int count;         ///< ids run from 0 to count - 1
};

/// In the order of the enumeration.
inline constexpr MarkerDictionaryInfo kMarkerDictionaries[] = {
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
};

inline constexpr const MarkerDictionaryInfo& info_of(MarkerDictionary dictionary) {
  return kMarkerDictionaries[int(dictionary)];
}

/// nullopt for a name that is not in the table.
inline std::optional<MarkerDictionary> marker_dictionary_named(const std::string& name) {
  for (const MarkerDictionaryInfo& info : kMarkerDictionaries)
    if (name == info.name) return info.dictionary;
  return std::nullopt;
}

}  // namespace procam
