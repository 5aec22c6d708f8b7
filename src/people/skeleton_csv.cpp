// Recorded skeletons: CSV, and files of either form.
#include <charconv>
#include <cmath>
#include <fstream>
#include <iterator>

#include "procam/core/base/detail/regular_file.hpp"
#include "procam/core/base/error.hpp"
#include "procam/people/skeleton_reader.hpp"
#include "skeleton_csv.hpp"

namespace procam::people {
namespace {

/// Names of Kinect v1, as the logs of many programs have them.
std::optional<Joint> logged_joint(std::string_view name) {
  static constexpr std::pair<std::string_view, Joint> kKinect1[] = {{"shoulderCenter", Joint::kNeck},
                                                                    {"spine", Joint::kNavel},
                                                                    {"hipCenter", Joint::kPelvis},
                                                                    {"shoulderLeft", Joint::kLeftShoulder},
                                                                    {"shoulderRight", Joint::kRightShoulder},
                                                                    {"elbowLeft", Joint::kLeftElbow},
                                                                    {"elbowRight", Joint::kRightElbow},
                                                                    {"wristLeft", Joint::kLeftWrist},
                                                                    {"wristRight", Joint::kRightWrist},
                                                                    {"handLeft", Joint::kLeftHand},
                                                                    {"handRight", Joint::kRightHand},
                                                                    {"hipLeft", Joint::kLeftHip},
                                                                    {"hipRight", Joint::kRightHip},
                                                                    {"kneeLeft", Joint::kLeftKnee},
                                                                    {"kneeRight", Joint::kRightKnee},
                                                                    {"ankleLeft", Joint::kLeftAnkle},
                                                                    {"ankleRight", Joint::kRightAnkle},
                                                                    {"footLeft", Joint::kLeftFoot},
                                                                    {"footRight", Joint::kRightFoot}};
  for (const auto& [known, joint] : kKinect1)
    if (name == known) return joint;
  return joint_of(name);
}

std::string_view next_piece(std::string_view& rest, char end) {
  const std::size_t at = rest.find(end);
  std::string_view piece = rest.substr(0, at);
  rest = at == rest.npos ? std::string_view() : rest.substr(at + 1);
  while (!piece.empty() && (piece.back() == '\r' || piece.back() == ' ')) piece.remove_suffix(1);
  while (!piece.empty() && piece.front() == ' ') piece.remove_prefix(1);
  return piece;
}

/// nullopt for an empty cell and for NaN, which is how a tracker says "not seen"; false when it is neither.
bool read_cell(std::string_view cell, std::optional<double>& value) {
  value = std::nullopt;
  if (cell.empty()) return true;
  double number = 0;
  const auto [end, failure] = std::from_chars(cell.data(), cell.data() + cell.size(), number);
  if (failure == std::errc::result_out_of_range) return false;
  if (failure != std::errc() || end != cell.data() + cell.size()) return false;
  if (!std::isnan(number)) value = number;
  return true;
}

/// What a column holds.
struct Column {
  enum Kind { kNothing, kTime, kCoordinate, kFresh } kind = kNothing;
  Joint joint = Joint::kHead;
  int axis = 0;
};

Column column_of(std::string_view name) {
  if (name == "t_s") return {Column::kTime, Joint::kHead, 0};
  const auto ends = [&](std::string_view end) {
    return name.size() > end.size() && name.substr(name.size() - end.size()) == end;
  };
  static constexpr std::string_view kAxes[] = {"_x_m", "_y_m", "_z_m"};
  for (int axis = 0; axis < 3; ++axis)
    if (ends(kAxes[axis]))
      if (const auto joint = logged_joint(name.substr(0, name.size() - 4)))
        return {Column::kCoordinate, *joint, axis};
  if (ends("_ok"))
    if (const auto joint = logged_joint(name.substr(0, name.size() - 3))) return {Column::kFresh, *joint, 0};
  return {};
}

/// nullptr, or why the line holds no frame.
const char* read_line(std::string_view line, const std::vector<Column>& columns, SkeletonFrame& frame) {
  std::array<std::array<std::optional<double>, 3>, kJointCount> cells;
  std::array<bool, kJointCount> is_stale = {};
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (i > 0 && line.data() == nullptr) return "it has too few cells";
    std::optional<double> value;
    const bool is_read = read_cell(next_piece(line, ','), value);
    const Column& column = columns[i];
    if (column.kind == Column::kNothing) continue;
    if (!is_read) return "a cell is not a number";
    switch (column.kind) {
      case Column::kTime:
        frame.stamp = value;
        break;
      case Column::kCoordinate:
        cells[std::size_t(column.joint)][std::size_t(column.axis)] = value;
        break;
      default:
        is_stale[std::size_t(column.joint)] = !value || *value == 0;
    }
  }
  if (!line.empty()) return "it has too many cells";
  if (!frame.stamp) return "it has no time";
  Skeleton person;
  bool sees_somebody = false;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const auto& [x, y, z] = cells[j];
    if (is_stale[j] || !x || !y || !z) continue;
    person.joints[j] = SeenJoint<Vec3>{Vec3(*x, *y, *z), 1};
    sees_somebody = true;
  }
  if (sees_somebody) frame.people.push_back(person);
  return why_refused(frame);
}

}  // namespace

ParsedSkeletons parse_skeleton_csv(std::string_view text) {
  std::string_view header = next_piece(text, '\n');
  std::vector<Column> columns;
  bool has_time = false, has_joint = false;
  while (!header.empty()) {
    columns.push_back(column_of(next_piece(header, ',')));
    has_time |= columns.back().kind == Column::kTime;
    has_joint |= columns.back().kind == Column::kCoordinate;
  }
  if (!has_time || !has_joint)
    throw Error(ErrorKind::kInput, "skeleton log, line 1",
                has_time ? "no column is a joint's coordinate" : "there is no column t_s",
                "begin with a header such as t_s,left_hand_x_m,left_hand_y_m,left_hand_z_m,left_hand_ok");
  ParsedSkeletons result;
  while (!text.empty()) {
    const std::string_view line = next_piece(text, '\n');
    if (line.empty()) continue;
    SkeletonFrame frame;
    if (const char* why = read_line(line, columns, frame)) {
      ++result.malformed;
      result.why = why;
      continue;
    }
    frame.arrival = *frame.stamp;
    result.frames.push_back(std::move(frame));
  }
  return result;
}

std::vector<SkeletonFrame> read_skeleton_log(const std::filesystem::path& file) {
  procam::internal::require_regular_file(file);
  std::ifstream in(file, std::ios::binary);
  if (!in)
    throw Error(ErrorKind::kIo, file.string(), "it cannot be opened",
                "give the file of a recorded skeleton log");
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  ParsedSkeletons parsed =
      first != text.npos && text[first] == '{' ? parse_skeletons(text) : parse_skeleton_csv(text);
  if (parsed.frames.empty())
    throw Error(ErrorKind::kInput, file.string(),
                "it holds no frame" + (parsed.why.empty() ? std::string() : ": " + parsed.why),
                "give JSON lines or a CSV as docs/people.md describes them");
  for (SkeletonFrame& frame : parsed.frames) frame.arrival = frame.stamp.value_or(0);
  return std::move(parsed.frames);
}

}  // namespace procam::people
