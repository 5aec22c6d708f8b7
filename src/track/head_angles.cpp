#include "procam/track/head_angles.hpp"

#include <array>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>

#include "log_header.hpp"
#include "procam/core/base/detail/bounded_line.hpp"
#include "procam/core/base/detail/regular_file.hpp"
#include "procam/core/base/error.hpp"
#include "procam/core/base/limits.hpp"
#include "procam/track/detail/parsed_source.hpp"
#include "procam/track/detail/recorded.hpp"
#include "sources.hpp"

namespace procam::track {
namespace {

using nlohmann::json;

constexpr const char* kAngleLogBegins = "{\"format\":\"procam-angle-log\",\"version\":1}";
constexpr double kMaxTurns = 100;

/// Token by token: what is no message is given up at its first wrong token.
class AnglesReader {
 public:
  using number_integer_t = json::number_integer_t;
  using number_unsigned_t = json::number_unsigned_t;
  using number_float_t = json::number_float_t;
  using string_t = json::string_t;
  using binary_t = json::binary_t;

  enum Field { kStamp, kArrival, kSequence, kPan, kTilt, kFields };
  std::array<std::optional<double>, kFields> values;
  const char* why = "it is not JSON";

  bool null() { return refuse("a value is no number"); }
  bool boolean(bool) { return refuse("a value is no number"); }
  bool number_integer(number_integer_t v) { return number(double(v)); }
  bool number_unsigned(number_unsigned_t v) { return number(double(v)); }
  bool number_float(number_float_t v, const string_t&) { return number(v); }
  bool binary(binary_t&) { return refuse("it is not JSON"); }
  bool string(string_t&) { return refuse("a value is no number"); }
  bool start_object(std::size_t) {
    if (in_object_) return refuse("an object inside the message");
    in_object_ = true;
    return true;
  }
  bool end_object() { return true; }
  bool start_array(std::size_t) { return refuse("an array where none belongs"); }
  bool end_array() { return true; }
  bool key(string_t& name) {
    static constexpr std::array<const char*, kFields> kNames = {"stamp", "arrival", "sequence", "pan_deg",
                                                                "tilt_deg"};
    for (std::size_t f = 0; f < kFields; ++f)
      if (name == kNames[f]) {
        field_ = f;
        return values[f] ? refuse("a key appears twice") : true;
      }
    return refuse("a key that no message of angles has");
  }
  bool parse_error(std::size_t, const std::string&, const json::exception&) { return false; }

 private:
  std::size_t field_ = kFields;
  bool in_object_ = false;

  bool refuse(const char* reason) {
    why = reason;
    return false;
  }
  bool number(double value) {
    if (field_ >= kFields) return refuse("it is not an object");
    if (!std::isfinite(value)) return refuse("a number is not finite");
    values[field_] = value;
    return true;
  }
};

/// nullptr, or what is wrong.
const char* read_angles(std::string_view line, StampedAngles& angles) {
  if (line.size() > limits::kMessageBytes) return "it is longer than 8192 bytes";
  AnglesReader reader;
  if (!json::sax_parse(line.begin(), line.end(), &reader)) return reader.why;
  const auto& values = reader.values;
  if (!values[AnglesReader::kPan] || !values[AnglesReader::kTilt]) return "pan_deg or tilt_deg is missing";
  for (const auto& angle : {values[AnglesReader::kPan], values[AnglesReader::kTilt]})
    if (!(std::abs(*angle) <= 360 * kMaxTurns)) return "an angle is more than 100 turns";
  angles.pan = *values[AnglesReader::kPan] * kDegree;
  angles.tilt = *values[AnglesReader::kTilt] * kDegree;
  angles.stamp = values[AnglesReader::kStamp];
  angles.arrival = values[AnglesReader::kArrival].value_or(angles.stamp.value_or(0));
  angles.sequence.reset();
  if (const auto& sequence = values[AnglesReader::kSequence]) {
    if (!(*sequence >= 0 && *sequence <= 4294967295.0 && *sequence == std::floor(*sequence)))
      return "sequence is not a count";
    angles.sequence = std::uint32_t(*sequence);
  }
  return nullptr;
}

void take_line(std::string_view line, ParsedAngles& parsed) {
  if (line.find_first_not_of(" \t\r") == line.npos) return;
  StampedAngles angles;
  if (const char* why = read_angles(line, angles)) {
    ++parsed.malformed;
    parsed.why = why;
    return;
  }
  angles.arrival = 0;
  parsed.angles.push_back(angles);
}

/// A stream, cut anywhere.
class AngleStream {
 public:
  ParsedAngles parse(std::string_view bytes) {
    ParsedAngles parsed;
    rest_ += bytes;
    std::size_t begin = 0;
    for (std::size_t end = rest_.find('\n'); end != rest_.npos; end = rest_.find('\n', begin)) {
      take_line(std::string_view(rest_).substr(begin, end - begin), parsed);
      begin = end + 1;
    }
    rest_.erase(0, begin);
    if (rest_.size() > limits::kMessageBytes) {
      rest_.clear();
      ++parsed.malformed;
      parsed.why = "it is longer than 8192 bytes";
    }
    return parsed;
  }

 private:
  std::string rest_;
};

class AngleSource {
 public:
  virtual ~AngleSource() = default;
  virtual void poll(std::vector<StampedAngles>& arrived) = 0;
  virtual void wait(double seconds) = 0;
  virtual SourceStatus status() const = 0;
};
template <typename Parser>
using ParsedAngleSource = internal::ParsedSource<AngleSource, StampedAngles, Parser, &ParsedAngles::angles>;

class HeadSource final : public PoseSource {
 public:
  HeadSource(std::unique_ptr<AngleSource> angles, const PlacedHead& head)
      : angles_(std::move(angles)), head_(head) {}
  void poll(std::vector<StampedPose>& arrived) override {
    angles_->poll(polled_);
    arrived.resize(polled_.size());
    for (std::size_t i = 0; i < polled_.size(); ++i) arrived[i] = pose_of(polled_[i], head_);
  }
  void wait(double seconds) override { angles_->wait(seconds); }
  SourceStatus status() const override { return angles_->status(); }

 private:
  std::unique_ptr<AngleSource> angles_;
  PlacedHead head_;
  std::vector<StampedAngles> polled_;
};

class MovedSource final : public PoseSource {
 public:
  MovedSource(std::unique_ptr<PoseSource> source, const Pose& world_from_frame)
      : source_(std::move(source)), world_from_frame_(world_from_frame) {}
  void poll(std::vector<StampedPose>& arrived) override {
    source_->poll(arrived);
    const Mat6 to_world = adjoint(world_from_frame_);
    for (StampedPose& message : arrived) {
      message.frame_from_child = world_from_frame_ * message.frame_from_child;
      if (message.covariance) message.covariance = to_world * *message.covariance * to_world.transpose();
    }
  }
  void wait(double seconds) override { source_->wait(seconds); }
  SourceStatus status() const override { return source_->status(); }
  std::map<std::string, std::uint64_t> rejected() const override { return source_->rejected(); }
  std::string description() const override { return source_->description(); }

 private:
  std::unique_ptr<PoseSource> source_;
  Pose world_from_frame_;
};

Error angle_log_error(const std::filesystem::path& path, const char* next) {
  return {ErrorKind::kIo, path.string(), errno != 0 ? std::strerror(errno) : "input or output failed", next};
}

std::unique_ptr<PoseSource> open_angle_log(const std::string& rest, const PlacedHead& head) {
  const internal::FileAndSpeed log = internal::parse_file_and_speed(rest);
  std::vector<StampedPose> poses;
  for (const StampedAngles& angles : read_angle_log(log.file)) poses.push_back(pose_of(angles, head));
  return std::make_unique<internal::Recorded<StampedPose, PoseSource>>(std::move(poses), log.speed);
}

}  // namespace

ParsedAngles parse_angles(std::string_view lines) {
  ParsedAngles parsed;
  while (!lines.empty()) {
    const std::size_t end = std::min(lines.find('\n'), lines.size());
    take_line(lines.substr(0, end), parsed);
    lines.remove_prefix(std::min(end + 1, lines.size()));
  }
  return parsed;
}

std::string angles_to_json_line(const StampedAngles& angles) {
  std::string text = "{";
  char part[64];
  if (angles.stamp) {
    std::snprintf(part, sizeof part, "\"stamp\":%.17g,", *angles.stamp);
    text += part;
  }
  if (angles.sequence) text += "\"sequence\":" + std::to_string(*angles.sequence) + ",";
  std::snprintf(part, sizeof part, "\"pan_deg\":%.10g,\"tilt_deg\":%.10g}\n", angles.pan / kDegree,
                angles.tilt / kDegree);
  return text + part;
}

std::vector<StampedAngles> read_angle_log(const std::filesystem::path& path) {
  procam::internal::require_regular_file(path);
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (!file.is_open()) throw angle_log_error(path, "give a log that can be read");
  std::vector<StampedAngles> log;
  std::string line;
  for (int number = 1;; ++number) {
    const procam::internal::LineEnd end =
        procam::internal::read_bounded_line(file, line, limits::kMessageBytes);
    if (file.bad()) throw angle_log_error(path, "give a log that can be read");
    if (!line.empty() && line.back() == '\r') line.pop_back();
    const std::string fault = number == 1 ? internal::log_header_fault(line, "procam-angle-log") : "";
    if (!fault.empty())
      throw Error(ErrorKind::kInput, path.string() + ", line 1", "it is no log of angles: " + fault,
                  std::string("write the first line as ") + kAngleLogBegins);
    if (number > 1 && line.find_first_not_of(" \t") != line.npos) {
      StampedAngles angles;
      const char* why = read_angles(line, angles);
      if (why != nullptr && end == procam::internal::LineEnd::kCut) break;
      if (why != nullptr)
        throw Error(ErrorKind::kInput, path.string() + ", line " + std::to_string(number), why,
                    "lines read {\"stamp\": 1.25, \"pan_deg\": 12.5, \"tilt_deg\": -3.0}");
      log.push_back(angles);
    }
    if (end != procam::internal::LineEnd::kLineFeed) break;
  }
  return log;
}

void write_angle_log(const std::filesystem::path& path, const std::vector<StampedAngles>& angles) {
  errno = 0;
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file << kAngleLogBegins << '\n';
  char arrival[48];
  for (const StampedAngles& message : angles) {
    std::snprintf(arrival, sizeof arrival, "{\"arrival\":%.17g,", message.arrival);
    file << arrival << angles_to_json_line(message).substr(1);
  }
  file.flush();
  if (!file) throw angle_log_error(path, "give a place that can be written and has room");
}

StampedPose pose_of(const StampedAngles& angles, const PlacedHead& head) {
  StampedPose message;
  message.stamp = angles.stamp;
  message.arrival = angles.arrival;
  message.sequence = angles.sequence;
  message.frame = head.frame;
  message.child = head.child;
  message.frame_from_child =
      (head.world_from_head * head_from_tilt(head.axes, angles.pan, angles.tilt)).normalized();
  return message;
}

std::unique_ptr<PoseSource> open_head_source(const std::string& text, const PlacedHead& head,
                                             const SourceOptions& options) {
  const std::string kind = text.substr(0, text.find(':'));
  if (kind == "log") return open_angle_log(text.substr(4), head);
  std::unique_ptr<AngleSource> angles;
  if (kind == "udp")
    angles = std::make_unique<ParsedAngleSource<internal::Stateless<parse_angles>>>(text, options);
  else if (kind == "tcp" || kind == "tcp-listen")
    angles = std::make_unique<ParsedAngleSource<AngleStream>>(text, options);
  else
    throw Error(ErrorKind::kInput, "source of angles '" + text + "'", "no kind of source is called so",
                "use udp:[ADDRESS:]PORT, tcp:HOST:PORT, tcp-listen:[ADDRESS:]PORT or log:FILE[@SPEED]");
  return std::make_unique<HeadSource>(std::move(angles), head);
}

std::unique_ptr<PoseSource> moved_source(std::unique_ptr<PoseSource> source, const Pose& world_from_frame) {
  require(source != nullptr && world_from_frame.is_finite(), "moved_source: there is no source or no pose");
  return std::make_unique<MovedSource>(std::move(source), world_from_frame);
}

}  // namespace procam::track
