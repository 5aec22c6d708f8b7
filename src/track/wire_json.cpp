#include "wire_json.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <nlohmann/json.hpp>

#include "procam/core/base/detail/plain_text.hpp"
#include "procam/core/base/limits.hpp"
#include "procam/track/detail/covariance_from_ros.hpp"
#include "procam/track/detail/json_depth.hpp"
#include "procam/track/detail/message_check.hpp"
#include "procam/track/wire.hpp"
#include "wire_parsers.hpp"

namespace procam::track {
namespace {

using nlohmann::json;

/// A message holds an object of numbers, texts and flat arrays. Read token by token: what is no message is
/// given up at its first wrong token, and nothing is built of it.
class MessageReader {
 public:
  using number_integer_t = json::number_integer_t;
  using number_unsigned_t = json::number_unsigned_t;
  using number_float_t = json::number_float_t;
  using string_t = json::string_t;
  using binary_t = json::binary_t;

  MessageReader(StampedPose& message, bool in_log) : message_(message), in_log_(in_log) {}

  const char* why = "it is not JSON";

  bool null() { return refuse("a value is null"); }
  bool boolean(bool) { return refuse("a value is true or false"); }
  bool number_integer(number_integer_t v) { return number(double(v)); }
  bool number_unsigned(number_unsigned_t v) { return number(double(v)); }
  bool number_float(number_float_t v, const string_t&) { return number(v); }
  bool binary(binary_t&) { return refuse("it is not JSON"); }

  bool string(string_t& text) {
    if (in_array_ || (field_ != kFrame && field_ != kChild)) return refuse("a text where a number belongs");
    if (text.size() > limits::kFrameNameBytes) return refuse("a frame's name is longer than 255 bytes");
    (field_ == kFrame ? message_.frame : message_.child) = text;
    return true;
  }
  bool start_object(std::size_t) {
    if (in_object_) return refuse("an object inside the message");
    in_object_ = true;
    return true;
  }
  bool end_object() { return true; }
  bool key(string_t& name) {
    for (int f = 0; f < kFields; ++f) {
      if (name != kNames[std::size_t(f)] || (f == kArrival && !in_log_)) continue;
      if (seen_ & (1u << f)) return refuse("a key appears twice");
      seen_ |= 1u << f;
      field_ = f;
      return true;
    }
    return refuse("a key that no message has");
  }
  bool start_array(std::size_t) {
    if (!in_object_ || in_array_ || kLengths[std::size_t(field_)] == 0)
      return refuse("an array where none belongs");
    in_array_ = true;
    count_ = 0;
    return true;
  }
  bool end_array() {
    in_array_ = false;
    if (count_ != kLengths[std::size_t(field_)]) return refuse("an array is too short");
    const double* v = values_.data();
    switch (field_) {
      case kPosition:
        message_.frame_from_child.translation = Eigen::Map<const Vec3>(v);
        break;
      case kQuaternion:
        message_.frame_from_child.rotation = Eigen::Quaterniond(v[3], v[0], v[1], v[2]);
        break;
      case kCovariance:
        message_.covariance = Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(v);
        break;
      case kTwist:
        message_.twist = Eigen::Map<const Vec6>(v);
        break;
      default:
        message_.angular_rate = Eigen::Map<const Vec3>(v);
    }
    return true;
  }
  bool parse_error(std::size_t, const std::string&, const json::exception&) { return false; }

  /// After the last token.
  bool is_complete() {
    for (const int f : {kFrame, kChild, kPosition, kQuaternion})
      if (!(seen_ & (1u << f))) return refuse("frame, child, position or quaternion is missing");
    if (in_log_ && !(seen_ & (1u << kArrival))) return refuse("arrival is missing");
    return true;
  }

 private:
  enum Field {
    kStamp,
    kSequence,
    kArrival,
    kFrame,
    kChild,
    kPosition,
    kQuaternion,
    kCovariance,
    kTwist,
    kAngularRate,
    kFields
  };
  static constexpr std::array<const char*, kFields> kNames = {
      "stamp",    "sequence",   "arrival",    "frame", "child",
      "position", "quaternion", "covariance", "twist", "angular_rate"};
  static constexpr std::array<std::size_t, kFields> kLengths = {0, 0, 0, 0, 0, 3, 4, 36, 6, 3};

  bool refuse(const char* reason) {
    why = reason;
    return false;
  }
  bool number(double v) {
    if (in_array_) {
      if (count_ == kLengths[std::size_t(field_)]) return refuse("an array is too long");
      values_[count_++] = v;
      return true;
    }
    switch (field_) {
      case kStamp:
        message_.stamp = v;
        return true;
      case kArrival:
        message_.arrival = v;
        return true;
      case kSequence:
        if (!(v >= 0 && v <= 4294967295.0 && v == std::floor(v))) return refuse("sequence is not a count");
        message_.sequence = std::uint32_t(v);
        return true;
      default:
        return refuse("a number where none belongs");
    }
  }

  StampedPose& message_;
  bool in_log_;
  bool in_object_ = false, in_array_ = false;
  unsigned seen_ = 0;
  int field_ = 0;
  std::size_t count_ = 0;
  std::array<double, 36> values_ = {};
};

/// All digits; with a point where JSON's integers would lose the sign of zero.
void append_number(std::string& text, double value) {
  char digits[40];
  std::snprintf(digits, sizeof digits, "%.17g", value);
  text += value == 0 && std::signbit(value) ? "-0.0" : digits;
}

void append(std::string& text, const char* key, const double* values, std::size_t count) {
  text += key;
  for (std::size_t i = 0; i < count; ++i) {
    text += i == 0 ? '[' : ',';
    append_number(text, values[i]);
  }
  text += ']';
}

}  // namespace

const char* internal::read_json_message(std::string_view line, bool in_log, StampedPose& message) {
  // The first byte separates most garbage from JSON.
  const std::size_t first = line.find_first_not_of(" \t\r");
  if (first == line.npos || line[first] != '{') return "it does not begin with {";
  MessageReader reader(message, in_log);
  if (!json::sax_parse(line.begin(), line.end(), &reader)) return reader.why;
  if (!reader.is_complete()) return reader.why;
  if (const char* why = why_malformed(message)) return why;
  internal::make_unit(message.frame_from_child.rotation);
  return nullptr;
}

std::string to_json_line(const StampedPose& message) {
  std::string text = "{";
  if (message.stamp) {
    text += "\"stamp\":";
    append_number(text, *message.stamp);
    text += ',';
  }
  if (message.sequence) text += "\"sequence\":" + std::to_string(*message.sequence) + ",";
  // dump() escapes; bytes that are no UTF-8 are replaced.
  const auto quoted = [](const std::string& name) {
    return json(name).dump(-1, ' ', false, json::error_handler_t::replace);
  };
  text += "\"frame\":" + quoted(message.frame) + ",\"child\":" + quoted(message.child);
  append(text, ",\"position\":", message.frame_from_child.translation.data(), 3);
  append(text, ",\"quaternion\":", message.frame_from_child.rotation.coeffs().data(), 4);
  if (message.covariance) {
    const Eigen::Matrix<double, 6, 6, Eigen::RowMajor> rows = *message.covariance;
    append(text, ",\"covariance\":", rows.data(), 36);
  }
  if (message.twist) append(text, ",\"twist\":", message.twist->data(), 6);
  if (message.angular_rate) append(text, ",\"angular_rate\":", message.angular_rate->data(), 3);
  return text + "}\n";
}

// --- rosbridge ---

bool internal::is_shallow(std::string_view text, int deepest) {
  int depth = 0;
  bool in_text = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_text) {
      if (c == '\\') ++i;
      if (c == '"') in_text = false;
    } else if (c == '"') {
      in_text = true;
    } else if ((c == '{' || c == '[') && ++depth > deepest) {
      return false;
    } else if (c == '}' || c == ']') {
      --depth;
    }
  }
  return true;
}

namespace {

/// nullptr where the path ends early.
const json* field(const json* from, std::initializer_list<const char*> path) {
  for (const char* name : path) {
    if (from == nullptr || !from->is_object()) return nullptr;
    const auto found = from->find(name);
    if (found == from->end()) return nullptr;
    from = &*found;
  }
  return from;
}

double number_at(const json* object, const char* name) {
  const json* value = field(object, {name});
  return value != nullptr && value->is_number() ? value->get<double>()
                                                : std::numeric_limits<double>::quiet_NaN();
}
Vec3 vector_at(const json* object) {
  return {number_at(object, "x"), number_at(object, "y"), number_at(object, "z")};
}
Pose pose_at(const json* position, const json* orientation) {
  Pose pose;
  pose.translation = vector_at(position);
  pose.rotation.coeffs() << vector_at(orientation), number_at(orientation, "w");
  return pose;
}

/// ROS 1 says secs and nsecs, ROS 2 sec and nanosec. All zero, or no stamp: not stamped. NaN: it is no time.
std::optional<double> stamp_at(const json* header) {
  const json* stamp = field(header, {"stamp"});
  if (stamp == nullptr) return std::nullopt;
  const bool ros2 = field(stamp, {"sec"}) != nullptr;
  const double time =
      number_at(stamp, ros2 ? "sec" : "secs") + 1e-9 * number_at(stamp, ros2 ? "nanosec" : "nsecs");
  if (time == 0) return std::nullopt;
  return time;
}

std::string text_at(const json* object, const char* name) {
  const json* value = field(object, {name});
  if (value == nullptr || !value->is_string()) return {};
  std::string text = value->get<std::string>();
  if (!text.empty() && text.front() == '/') text.erase(0, 1);
  return text;
}

bool take_covariance(const json* rows, StampedPose& message) {
  if (rows == nullptr) return true;
  if (!rows->is_array() || rows->size() != 36) return false;
  Mat6 ros;
  for (Eigen::Index i = 0; i < 36; ++i) {
    const json& value = (*rows)[std::size_t(i)];
    if (!value.is_number()) return false;
    ros(i / 6, i % 6) = value.get<double>();
  }
  message.covariance = internal::covariance_from_ros(ros, message.frame_from_child.translation);
  return true;
}

void keep(StampedPose& message, Parsed& parsed) {
  const char* why = internal::why_malformed(message);
  if (why == nullptr && (message.frame.empty() || message.child.empty())) why = "a frame has no name";
  if (why != nullptr) {
    ++parsed.malformed;
    parsed.why = why;
    return;
  }
  internal::make_unit(message.frame_from_child.rotation);
  parsed.poses.push_back(std::move(message));
}

Parsed refused(const char* why) {
  Parsed parsed;
  parsed.malformed = 1;
  parsed.why = why;
  return parsed;
}

}  // namespace

std::optional<Mat6> internal::covariance_from_ros(const Mat6& ros, const Vec3& translation) {
  if (ros.isZero(0) || ros(0, 0) == -1) return std::nullopt;
  Mat6 left_from_ros = Mat6::Zero();
  left_from_ros.topRightCorner<3, 3>().setIdentity();
  left_from_ros.bottomLeftCorner<3, 3>().setIdentity();
  left_from_ros.bottomRightCorner<3, 3>() = hat(translation);
  return left_from_ros * ros * left_from_ros.transpose();
}

Parsed parse_rosbridge(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  if (first == text.npos || text[first] != '{') return refused("it does not begin with {");
  if (!internal::is_shallow(text, limits::kRosbridgeDepth)) return refused("it is nested too deeply");
  const json root = json::parse(text.begin(), text.end(), nullptr, false);
  if (root.is_discarded()) return refused("it is not JSON");
  const std::string op = text_at(&root, "op");
  Parsed parsed;
  if (op == "status") {
    if (text_at(&root, "level") == "error")
      parsed.why = "rosbridge says: " + procam::internal::to_plain_text(text_at(&root, "msg").substr(0, 200));
    return parsed;
  }
  if (op != "publish") return refused("it is no published message");
  const json* msg = field(&root, {"msg"});
  if (const json* transforms = field(msg, {"transforms"})) {
    if (!transforms->is_array() || transforms->size() > limits::kTransforms)
      return refused("transforms are no list");
    for (const json& t : *transforms) {
      StampedPose message;
      message.stamp = stamp_at(field(&t, {"header"}));
      message.frame = text_at(field(&t, {"header"}), "frame_id");
      message.child = text_at(&t, "child_frame_id");
      message.frame_from_child =
          pose_at(field(&t, {"transform", "translation"}), field(&t, {"transform", "rotation"}));
      keep(message, parsed);
    }
    return parsed;
  }
  StampedPose message;
  message.stamp = stamp_at(field(msg, {"header"}));
  message.frame = text_at(field(msg, {"header"}), "frame_id");
  message.child = text_at(msg, "child_frame_id");
  if (message.child.empty()) message.child = "base_link";
  const json* pose = field(msg, {"pose", "pose"});
  const bool bare = pose == nullptr;
  if (bare) pose = field(msg, {"pose"});
  message.frame_from_child = pose_at(field(pose, {"position"}), field(pose, {"orientation"}));
  if (!message.frame_from_child.is_finite()) return refused("it holds no pose of finite numbers");
  if (!bare && !take_covariance(field(msg, {"pose", "covariance"}), message))
    return refused("the covariance is not 36 numbers");
  if (const json* twist = field(msg, {"twist", "twist"})) {
    message.twist = Vec6();
    *message.twist << vector_at(field(twist, {"angular"})), vector_at(field(twist, {"linear"}));
  }
  keep(message, parsed);
  return parsed;
}

}  // namespace procam::track
