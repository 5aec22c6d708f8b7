#pragma once
/// Tables of observations as they are in files: rows with names and numbers, and the correspondences that they are.
#include <string>
#include <vector>

#include "procam/io/session/observations_file.hpp"

namespace procam::io {
struct NpyArray;

namespace observations {

inline constexpr double kDefaultSigma = 0.1;  // pixels, as Observation::covariance begins

/// One row before its device and point are known.
struct Row {
  std::string where;  ///< "file, line 7"
  std::string view, device, camera;
  int point = 0;
  Vec3 position = Vec3::Zero();
  Vec2 pixel = Vec2::Zero();
  Mat2 covariance = kDefaultSigma * kDefaultSigma * Mat2::Identity();
  bool correlated = true;  ///< with the camera's corner; of a projector's pixel
};

struct Table {
  std::string name;
  bool by_position = false;  ///< x, y, z instead of point
  std::vector<Row> rows;
  ObservationsContext stated;  ///< by the file itself
};

[[noreturn]] void fail_table(const std::string& where, const std::string& why);
[[noreturn]] void fail_table(const std::string& where, const std::string& why, const std::string& next);

Table table_of_csv(const std::string& text, const std::string& name);
Table table_of_npy(const NpyArray& array, const std::string& name);

/// Throws Error where rows contradict each other, the board, or the devices' sizes.
Correspondences correspondences_of(const Table& table, const ObservationsContext& context);

/// Numbers of the pattern's points in files, -1, -2, ..., and in memory, 0, 1, ...: each is the other's.
inline int pattern_point(int number) {
  return -1 - number;
}

}  // namespace observations
}  // namespace procam::io
