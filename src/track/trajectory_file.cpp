#include "procam/track/trajectory_file.hpp"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <initializer_list>
#include <optional>

#include "procam/core/base/detail/bounded_line.hpp"
#include "procam/core/base/detail/regular_file.hpp"
#include "procam/core/base/error.hpp"
#include "procam/core/base/limits.hpp"
#include "procam/core/geometry/se3.hpp"
#include "procam/track/detail/covariance_from_ros.hpp"
#include "procam/track/detail/message_check.hpp"
#include "wire_json.hpp"

namespace procam::track {
namespace {

namespace fs = std::filesystem;
using Cells = std::vector<std::string>;

constexpr const char* kFormats =
    "give TUM ('t x y z qx qy qz qw' between blanks), EuRoC ('#timestamp, p_RS_R_x [m], ...'), KITTI (12 "
    "numbers) or a CSV of 'rostopic echo -p'";

struct Line {
  int number = 0;
  std::string text;  ///< without blanks at its ends
};

std::string trimmed(const std::string& text) {
  constexpr const char* kBlanks = " \t\r\n";
  const std::size_t begin = text.find_first_not_of(kBlanks);
  return begin == text.npos ? "" : text.substr(begin, text.find_last_not_of(kBlanks) - begin + 1);
}

std::vector<Line> lines_of(const fs::path& path) {
  procam::internal::require_regular_file(path);
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  std::vector<Line> lines;
  std::string text;
  std::size_t bytes = 0;
  using procam::internal::LineEnd;
  LineEnd end = LineEnd::kLineFeed;
  for (int number = 1; file.is_open() && end == LineEnd::kLineFeed; ++number) {
    end = procam::internal::read_bounded_line(file, text, limits::kLogLineBytes);
    bytes += text.size();
    const char* const why = end == LineEnd::kTooLong     ? "it is longer than 64 MiB"
                            : bytes > limits::kFileBytes ? "the file is longer than 1024 MiB"
                                                         : nullptr;
    if (why != nullptr)
      throw Error(ErrorKind::kInput, path.string() + ", line " + std::to_string(number), why,
                  "give a trajectory, or a part of one");
    if (number == 1 && text.rfind("\xef\xbb\xbf", 0) == 0) text.erase(0, 3);
    if (text = trimmed(text); !text.empty()) lines.push_back({number, text});
  }
  if (!file.is_open() || file.bad() || fs::is_directory(path))
    throw Error(ErrorKind::kIo, path.string(), errno != 0 ? std::strerror(errno) : "it cannot be read",
                "give a file that can be read");
  return lines;
}

Error error_at(const fs::path& path, const Line& line, const std::string& why, const std::string& next) {
  return {ErrorKind::kInput, path.string() + ", line " + std::to_string(line.number), why, next};
}

std::optional<double> number(const std::string& text) {
  double value = 0;
  const char* const end = text.data() + text.size();
  const char* const begin = text.data() + (text.size() > 1 && text[0] == '+' ? 1 : 0);
  const auto [stop, error] = std::from_chars(begin, end, value);
  if (error != std::errc() || stop != end || !std::isfinite(value)) return std::nullopt;
  return value;
}

Cells split(const std::string& text, bool by_commas) {
  Cells cells;
  const char* const separators = by_commas ? "," : " \t";
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t end = std::min(text.find_first_of(separators, at), text.size());
    const std::string cell = trimmed(text.substr(at, end - at));
    if (by_commas || !cell.empty()) cells.push_back(cell);
    at = end + 1;
  }
  if (by_commas && !cells.empty() && cells.back().empty()) cells.pop_back();  // a comma at the end
  return cells;
}

/// Nanoseconds or seconds: 1e14 s are three million years, 1e14 ns a day and a bit after a clock's zero.
double seconds(double time) {
  return std::abs(time) > 1e14 ? 1e-9 * time : time;
}

/// Adds a pose that is one, after the others.
void add(StampedPose pose, const fs::path& path, const Line& line, Trajectory& trajectory) {
  pose.arrival = *pose.stamp;
  if (const char* why = internal::why_malformed(pose))
    throw error_at(path, line, why,
                   "correct or remove the line; a " + trajectory.format + " file is expected");
  if (!trajectory.poses.empty() && *pose.stamp <= *trajectory.poses.back().stamp)
    throw error_at(path, line, "its time is not after that of the line before",
                   "sort the lines by time, one a time");
  pose.frame_from_child.rotation.normalize();
  if (pose.frame.empty()) pose.frame = "map";
  if (pose.child.empty()) pose.child = "base";
  trajectory.poses.push_back(std::move(pose));
}

/// Where a table's columns are; -1: there is none.
struct Columns {
  bool in_nanoseconds = false;  ///< all its times, however small: those of a simulation begin at 0
  int time = -1, seconds = -1, nanoseconds = -1;  ///< the message's own stamp: one number, or two
  int recorded = -1;                              ///< when the program received it, where it has no stamp
  int position[3] = {-1, -1, -1}, quaternion[4] = {-1, -1, -1, -1};  ///< x y z w
  int frame = -1, child = -1;
  int covariance = -1;  ///< the first of 36
};

bool ends_with(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

/// The column of one of these names. Several: the message holds several poses.
int column(const Cells& header, std::initializer_list<const char*> endings, const fs::path& path) {
  int found = -1;
  for (std::size_t i = 0; i < header.size(); ++i)
    for (const char* const ending : endings) {
      if (header[i] != ending && !ends_with(header[i], std::string(".") + ending)) continue;
      if (found >= 0)
        throw Error(
            ErrorKind::kInput, path.string() + ", line 1",
            "a line holds several poses ('" + header[std::size_t(found)] + "' and '" + header[i] + "')",
            "export a topic of one pose a message, e.g. /odom, or one transform of /tf");
      found = int(i);
    }
  return found;
}

Columns ros_columns(const Cells& header, const fs::path& path) {
  Columns at;
  at.recorded = 0;
  at.in_nanoseconds = header[0] == "%time";  // of rostopic echo -p
  at.time = column(header, {"header.stamp"}, path);
  at.seconds = column(header, {"header.stamp.secs", "header.stamp.sec"}, path);
  at.nanoseconds = column(header, {"header.stamp.nsecs", "header.stamp.nanosec"}, path);
  at.frame = column(header, {"header.frame_id"}, path);
  at.child = column(header, {"child_frame_id"}, path);
  const char* const axes[] = {"x", "y", "z", "w"};
  for (int i = 0; i < 4; ++i) {
    const std::string axis = axes[i];
    if (i < 3)
      at.position[i] = column(header, {("position." + axis).c_str(), ("translation." + axis).c_str()}, path);
    at.quaternion[i] = column(header, {("orientation." + axis).c_str(), ("rotation." + axis).c_str()}, path);
  }
  at.covariance = column(header, {"pose.covariance0", "pose.covariance_0"}, path);
  if (at.covariance >= 0 && at.covariance + 36 > int(header.size())) at.covariance = -1;
  return at;
}

/// "p_RS_R_x [m]" is p_RS_R_x: names begin with p_ and q_ and end in the axis.
Columns euroc_columns(const Cells& header) {
  Columns at;
  at.time = 0;
  const auto find = [&](char kind, char axis) {
    for (std::size_t i = 1; i < header.size(); ++i) {
      const std::string name = header[i].substr(0, header[i].find_first_of(" ["));
      if (name.size() > 3 && name[0] == kind && name[1] == '_' && name[name.size() - 2] == '_' &&
          name.back() == axis)
        return int(i);
    }
    return -1;
  };
  for (int i = 0; i < 4; ++i) {
    if (i < 3) at.position[i] = find('p', "xyz"[i]);
    at.quaternion[i] = find('q', "xyzw"[i]);
  }
  return at;
}

Trajectory read_table(const std::vector<Line>& lines, const fs::path& path, const std::string& format) {
  Trajectory trajectory{format, {}};
  std::string names = lines.front().text;
  const Cells header = split(names[0] == '#' ? names.substr(1) : names, true);
  const Columns at = format == "EuRoC" ? euroc_columns(header) : ros_columns(header, path);
  for (const int i : {0, 1, 2})
    if (at.position[i] < 0) throw error_at(path, lines.front(), "its columns hold no position", kFormats);
  for (const int i : {0, 1, 2, 3})
    if (at.quaternion[i] < 0)
      throw error_at(path, lines.front(), "its columns hold no orientation: a position alone is no pose",
                     "export poses (of a motion capture system the body's, not a single marker's)");
  for (std::size_t l = 1; l < lines.size(); ++l) {
    const Line& line = lines[l];
    if (line.text[0] == '#') continue;
    const Cells cells = split(line.text, true);
    if (cells.size() < header.size() && cells.size() < 8)
      throw error_at(path, line,
                     "it has " + std::to_string(cells.size()) + " columns where the header names " +
                         std::to_string(header.size()),
                     "correct or remove the line");
    const auto value = [&](int column_at) {
      const auto i = std::size_t(column_at);
      const auto found = i < cells.size() ? number(cells[i]) : std::nullopt;
      if (!found)
        throw error_at(path, line, "column '" + header[i] + "' is not a finite number",
                       "correct or remove the line");
      return *found;
    };
    const auto seconds_in = [&](int column_at) {
      return at.in_nanoseconds ? 1e-9 * value(column_at) : seconds(value(column_at));
    };
    StampedPose pose;
    double stamp = at.time >= 0 ? seconds_in(at.time) : 0;
    if (at.seconds >= 0) stamp = value(at.seconds) + (at.nanoseconds >= 0 ? 1e-9 * value(at.nanoseconds) : 0);
    if (stamp == 0 && at.recorded >= 0) stamp = seconds_in(at.recorded);
    pose.stamp = stamp;
    pose.frame_from_child.translation =
        Vec3(value(at.position[0]), value(at.position[1]), value(at.position[2]));
    pose.frame_from_child.rotation = Eigen::Quaterniond(value(at.quaternion[3]), value(at.quaternion[0]),
                                                        value(at.quaternion[1]), value(at.quaternion[2]));
    const auto text = [&](int column_at) {
      const auto i = std::size_t(column_at);
      if (column_at < 0 || i >= cells.size()) return std::string();
      return cells[i].rfind('/', 0) == 0 ? cells[i].substr(1) : cells[i];
    };
    pose.frame = text(at.frame);
    pose.child = text(at.child);
    if (at.covariance >= 0) {
      Mat6 ros;
      for (int i = 0; i < 36; ++i) ros(i / 6, i % 6) = value(at.covariance + i);
      pose.covariance = internal::covariance_from_ros(ros, pose.frame_from_child.translation);
    }
    add(std::move(pose), path, line, trajectory);
  }
  return trajectory;
}

/// Data lines: without comments.
std::vector<Line> rows_of(const std::vector<Line>& lines) {
  std::vector<Line> rows;
  for (const Line& line : lines)
    if (const std::string text = trimmed(line.text.substr(0, line.text.find('#'))); !text.empty())
      rows.push_back({line.number, text});
  return rows;
}

std::vector<double> numbers(const fs::path& path, const Line& row, std::size_t count) {
  std::vector<double> values;
  for (const std::string& cell : split(row.text, false)) {
    const auto value = number(cell);
    if (!value) throw error_at(path, row, "'" + cell.substr(0, 40) + "' is not a finite number", kFormats);
    values.push_back(*value);
  }
  if (values.size() != count)
    throw error_at(path, row,
                   "it has " + std::to_string(values.size()) + " numbers where " + std::to_string(count) +
                       " are expected",
                   "correct or remove the line");
  return values;
}

Trajectory read_tum(const std::vector<Line>& rows, const fs::path& path) {
  Trajectory trajectory{"TUM", {}};
  for (const Line& row : rows) {
    const std::vector<double> v = numbers(path, row, 8);
    StampedPose pose;
    pose.stamp = seconds(v[0]);
    pose.frame_from_child = Pose(Eigen::Quaterniond(v[7], v[4], v[5], v[6]), Vec3(v[1], v[2], v[3]));
    add(std::move(pose), path, row, trajectory);
  }
  return trajectory;
}

Trajectory read_kitti(const std::vector<Line>& rows, const fs::path& path, const fs::path& times) {
  Trajectory trajectory{"KITTI", {}};
  const std::vector<Line> stamps = rows_of(lines_of(times));
  if (stamps.size() != rows.size())
    throw Error(
        ErrorKind::kInput, times.string(),
        "it holds " + std::to_string(stamps.size()) + " times for " + std::to_string(rows.size()) + " poses",
        "give the times of this sequence, a line for each pose");
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::vector<double> v = numbers(path, rows[i], 12);
    Mat3 rotation;
    rotation << v[0], v[1], v[2], v[4], v[5], v[6], v[8], v[9], v[10];
    constexpr double kRounding = 1e-3;  // of seven printed digits, and of drift in a product of rotations
    if ((rotation.transpose() * rotation - Mat3::Identity()).cwiseAbs().maxCoeff() > kRounding ||
        rotation.determinant() < 0)
      throw error_at(path, rows[i], "its first three columns are no rotation",
                     "give the rows of [R|t] one after another");
    StampedPose pose;
    pose.stamp = numbers(times, stamps[i], 1).front();
    pose.frame_from_child = Pose(Eigen::Quaterniond(rotation), Vec3(v[3], v[7], v[11]));
    pose.frame_from_child.rotation.normalize();
    add(std::move(pose), path, rows[i], trajectory);
  }
  return trajectory;
}

}  // namespace

Trajectory read_trajectory(const std::string& file) {
  fs::path path = file, times;
  std::error_code ignored;
  if (const std::size_t plus = file.rfind('+'); plus != file.npos && !fs::exists(path, ignored)) {
    path = file.substr(0, plus);
    times = file.substr(plus + 1);
  }
  const std::vector<Line> lines = lines_of(path), rows = rows_of(lines);
  Trajectory trajectory;
  if (lines.empty()) throw Error(ErrorKind::kInput, path.string(), "it is empty", kFormats);
  const std::string& first = lines.front().text;
  if (first.rfind("%time,", 0) == 0 || first.rfind("Time,", 0) == 0) {
    trajectory = read_table(lines, path, "rosbag");
  } else if (first[0] == '#' && first.find(',') != first.npos && first.find("timestamp") != first.npos) {
    trajectory = read_table(lines, path, "EuRoC");
  } else if (!rows.empty()) {
    if (rows.front().text.find(',') != std::string::npos)
      throw error_at(path, rows.front(),
                     "its numbers stand between commas without a header, so that the order of the "
                     "quaternion is unknown (EuRoC: w x y z, TUM: x y z w)",
                     kFormats);
    const std::size_t count = split(rows.front().text, false).size();
    if (count == 12 && times.empty())
      throw Error(ErrorKind::kInput, path.string(), "KITTI poses have no times",
                  "give the sequence's times as well: " + path.string() + "+times.txt");
    if (count == 12)
      trajectory = read_kitti(rows, path, times);
    else if (count == 8)
      trajectory = read_tum(rows, path);
    else
      throw error_at(path, rows.front(), "it has " + std::to_string(count) + " numbers", kFormats);
  }
  if (!times.empty() && trajectory.format != "KITTI")
    throw Error(ErrorKind::kInput, times.string(), "times of a second file are for KITTI poses only",
                path.string() + " has its own: give it alone");
  if (trajectory.poses.empty())
    throw Error(ErrorKind::kNotEnoughData, path.string(), "it holds no pose", kFormats);
  return trajectory;
}

Trajectory read_waypoints(const std::string& file) {
  Trajectory trajectory{"waypoint", {}};
  for (const Line& line : lines_of(file)) {
    std::string text = line.text.substr(0, line.text.find('#'));
    std::replace(text.begin(), text.end(), ',', ' ');
    const Cells cells = split(text, false);
    if (cells.empty()) continue;
    std::vector<double> values;
    for (const std::string& cell : cells)
      if (const auto value = number(cell); value && std::abs(*value) < 1e12) values.push_back(*value);
    if (cells.size() != 4 || values.size() != 4)
      throw error_at(file, line, "it is not 'time x y yaw_deg'", "correct or remove the line");
    StampedPose pose;
    pose.stamp = values[0];
    pose.frame_from_child = Pose(so3_exp(Vec3(0, 0, values[3] * M_PI / 180)), Vec3(values[1], values[2], 0));
    add(std::move(pose), file, line, trajectory);
  }
  if (trajectory.poses.empty())
    throw Error(ErrorKind::kNotEnoughData, file, "it holds no waypoint", "give lines of 'time x y yaw_deg'");
  return trajectory;
}

}  // namespace procam::track
