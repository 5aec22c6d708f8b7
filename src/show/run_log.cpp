#include "run_log.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cinttypes>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <utility>

#include "blend_log.hpp"
#include "picture_names.hpp"
#include "procam/core/base/clock.hpp"
#include "procam/core/base/detail/bounded_line.hpp"
#include "procam/core/base/detail/regular_file.hpp"
#include "procam/core/base/limits.hpp"
#include "procam/dds/detail/run_mcap.hpp"
#include "procam/io/surface_file.hpp"
#include "procam/track/clock.hpp"
#include "procam/track/detail/log_line.hpp"
#include "procam/track/wire.hpp"

namespace procam::show {
namespace {

constexpr const char* kHeader = "{\"format\":\"procam-run\",\"version\":1,\"conditions\":\"";
constexpr const char* kPart = "{\"part\":";
constexpr const char* kSighted = "{\"sighted\":";

std::uint64_t rotated(std::uint64_t x, int by) {
  return (x << by) | (x >> (64 - by));
}

Error log_error(const std::filesystem::path& path, long long line, const std::string& why) {
  return Error(ErrorKind::kInput, path.string() + ", line " + std::to_string(line), why,
               "give a log that project-live --record wrote");
}

/// Text of the form begin...end: what is between.
std::optional<std::string> between(const std::string& line, const char* begin, const char* end) {
  const std::size_t head = std::strlen(begin), tail = std::strlen(end);
  if (line.size() < head + tail || line.compare(0, head, begin) != 0 ||
      line.compare(line.size() - tail, tail, end) != 0)
    return std::nullopt;
  return line.substr(head, line.size() - head - tail);
}

std::optional<RecordedFrame> read_frame(const std::string& line) {
  RecordedFrame frame;
  int end = 0;
  if (std::sscanf(line.c_str(),
                  "{\"frame\":%lld,\"light\":%lg,\"content\":%lg,\"fingerprint\":\"%16" SCNx64 "\"}%n",
                  &frame.number, &frame.light_time, &frame.content_time, &frame.fingerprint, &end) != 4 ||
      std::size_t(end) != line.size() || !std::isfinite(frame.light_time) ||
      !std::isfinite(frame.content_time))
    return std::nullopt;
  return frame;
}

/// Bit for bit as it was: nothing is normalised.
std::optional<MovedProjector> read_projector(const std::string& line) {
  double v[7];
  int end = 0;
  if (std::sscanf(line.c_str(), "{\"projector\":[%lg,%lg,%lg,%lg,%lg,%lg,%lg]}%n", &v[0], &v[1], &v[2], &v[3],
                  &v[4], &v[5], &v[6], &end) != 7 ||
      std::size_t(end) != line.size())
    return std::nullopt;
  constexpr double kUnit = 1e-6;
  const Pose pose(Eigen::Quaterniond(v[0], v[1], v[2], v[3]), Vec3(v[4], v[5], v[6]));
  if (!pose.is_finite() || std::abs(pose.rotation.norm() - 1) > kUnit) return std::nullopt;
  return MovedProjector{pose};
}

/// As in a pose log.
std::string pose_line(const track::StampedPose& message) {
  char arrival[64];
  std::snprintf(arrival, sizeof arrival, "{\"arrival\":%.17g,", message.arrival);
  std::string line = arrival + track::to_json_line(message).substr(1);
  while (!line.empty() && line.back() == '\n') line.pop_back();
  return line;
}

constexpr std::size_t kBuffer = 65536;  // bytes

/// `run.log` is the newest part, `run.log.1` the one before.
std::filesystem::path part_path(const std::filesystem::path& log, int age) {
  return age == 0 ? log : std::filesystem::path(log.string() + "." + std::to_string(age));
}

/// The number of older parts that are there.
int older_parts(const std::filesystem::path& log) {
  std::error_code ignored;
  int count = 0;
  while (std::filesystem::exists(part_path(log, count + 1), ignored)) ++count;
  return count;
}

}  // namespace

std::uint64_t fingerprint(ViewU8 frame) {
  constexpr std::uint64_t kFirst = 0x9e3779b97f4a7c15, kSecond = 0xd6e8feb86659fd93;
  std::uint64_t lanes[4] = {kFirst, kSecond, ~kFirst, ~kSecond};
  const std::size_t bytes = std::size_t(frame.width) * std::size_t(frame.channels);
  for (int y = 0; y < frame.height; ++y) {
    const std::uint8_t* row = frame.row(y);
    std::size_t at = 0;
    for (; at + 32 <= bytes; at += 32)
      for (int lane = 0; lane < 4; ++lane) {
        std::uint64_t word;
        std::memcpy(&word, row + at + 8 * lane, 8);
        lanes[lane] = rotated((lanes[lane] ^ word) * kFirst, 29);
      }
    for (; at < bytes; ++at) lanes[at % 4] = rotated((lanes[at % 4] ^ row[at]) * kSecond, 31);
    lanes[0] += lanes[3];  // rows that change places are other frames
  }
  std::uint64_t sum = bytes;
  for (const std::uint64_t lane : lanes) sum = rotated((sum ^ lane) * kSecond, 27) + kFirst;
  return sum ^ (sum >> 32);
}

struct RunRecorder::State {
  std::filesystem::path path;
  std::string header;
  LogLimits limits;
  int file = -1;             ///< -1 once it failed
  std::string pending;       ///< whole lines that are not in the file yet
  std::uint64_t bytes = 0;   ///< of this part, with the pending ones
  std::uint64_t offset = 0;  ///< of the end of what was written whole
  int part = 1;
  double flushed = 0;
  std::string surfaces, picture, projector, blend;    ///< lines of the newest, which begin the next part
  std::optional<dds::internal::RunMcapEncoder> mcap;  ///< of a file that is named .mcap
  double unix_from_steady = 0, newest = 0;  ///< seconds; time of the newest line, by the steady clock

  ~State() {
    try {
      if (file >= 0) end_part();
    } catch (const Error&) {  // nobody is left who could free the disk
    }
    close();
  }

  void line(const std::string& text_of_line) {
    if (mcap) {
      mcap->add_line(text_of_line, unix_ns(newest));
    } else {
      pending += text_of_line;
      pending += '\n';
    }
    bytes += text_of_line.size() + 1;
    if (pending.size() + (mcap ? mcap->waiting() / 16 : 0) > kBuffer || file < 0) flush();
  }
  std::int64_t unix_ns(double steady) const { return std::int64_t(1e9 * (steady + unix_from_steady)); }
  void end_part() {
    if (mcap) pending += mcap->end();
    flush();
  }
  /// What was written in part when it fails is cut off: the log ends with a whole line.
  void flush() {
    if (mcap) pending += mcap->chunk();
    int reason = file < 0 ? EBADF : 0;
    for (std::size_t done = 0; done < pending.size() && reason == 0;) {
      const ssize_t wrote = ::write(file, pending.data() + done, pending.size() - done);
      if (wrote > 0)
        done += std::size_t(wrote);
      else if (wrote == 0 || errno != EINTR)
        reason = wrote == 0 ? ENOSPC : errno;
    }
    if (reason == 0) {
      offset += pending.size();
      return pending.clear();
    }
    pending.clear();
    if (file >= 0) (void)!::ftruncate(file, off_t(offset));
    close();
    throw Error(ErrorKind::kIo, path.string(), std::strerror(reason),
                "free some of the disk, then start the show again to record");
  }
  void close() {
    if (file >= 0) ::close(file);
    file = -1;
  }
  void open() {
    file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    if (file < 0)
      throw Error(ErrorKind::kIo, path.string(), std::strerror(errno), "give a file that can be written");
    bytes = offset = 0;
    if (mcap) pending += mcap->begin();
    line(header);
    flush();
  }
  void begin_next_part() {
    end_part();
    close();
    std::error_code failed;
    for (int age = std::min(older_parts(path), limits.parts - 2); age >= 0 && !failed; --age)
      std::filesystem::rename(part_path(path, age), part_path(path, age + 1), failed);
    if (failed)
      throw Error(ErrorKind::kIo, path.string(), "its parts cannot be renamed: " + failed.message(),
                  "give a log in a folder that can be written");
    open();
    line(kPart + std::to_string(++part) + "}");
    for (const std::string* text : {&surfaces, &picture, &projector, &blend})
      if (!text->empty()) line(*text);
  }
};

RunRecorder::RunRecorder(const std::filesystem::path& path, const std::string& conditions,
                         const LogLimits& limits)
    : state_(std::make_unique<State>()) {
  require(limits.parts >= 2 && limits.part_bytes > 0, "RunRecorder: a log has at least two parts");
  state_->path = path;
  state_->limits = limits;
  state_->unix_from_steady = -track::local_from_unix();
  state_->newest = steady_now();
  if (path.extension() == ".mcap") state_->mcap.emplace();
  std::string words = conditions;
  // What would end the string or the line stands for nothing here.
  for (char& letter : words)
    if (letter == '"' || letter == '\\' || static_cast<unsigned char>(letter) < 0x20) letter = '_';
  state_->header = kHeader + words + "\"}";
  state_->open();
  std::error_code ignored;
  for (int age = older_parts(path); age > 0; --age) std::filesystem::remove(part_path(path, age), ignored);
}
RunRecorder::~RunRecorder() = default;

void RunRecorder::record(const SurfaceSet& surfaces) {
  std::string text = io::surfaces_to_text(surfaces);
  for (char& letter : text)
    if (letter == '\n') letter = ' ';
  state_->surfaces = "{\"surfaces\":" + text + "}";
  state_->line(state_->surfaces);
}

void RunRecorder::record(TestPattern picture) {
  state_->picture = std::string("{\"picture\":\"") + kPictureNames[int(picture)] + "\"}";
  state_->line(state_->picture);
}

void RunRecorder::record(const MovedProjector& moved) {
  const auto& q = moved.rig_from_projector.rotation;
  const Vec3& t = moved.rig_from_projector.translation;
  char line[256];
  std::snprintf(line, sizeof line, "{\"projector\":[%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g]}", q.w(),
                q.x(), q.y(), q.z(), t.x(), t.y(), t.z());
  state_->projector = line;
  state_->line(state_->projector);
}

void RunRecorder::record(const SightedSurface& sighted) {
  state_->newest = sighted.message.arrival;
  state_->line(kSighted + pose_line(sighted.message) + "}");
}

void RunRecorder::record(const BlendScene& blend) {
  state_->blend = blend_line(blend);
  state_->line(state_->blend);
}

void RunRecorder::record(const track::StampedPose& message) {
  const std::string line = pose_line(message);
  state_->newest = message.arrival;
  if (state_->mcap) state_->mcap->add_pose(message, state_->unix_ns(message.arrival));
  state_->line(line);
}

void RunRecorder::record(const RecordedFrame& frame) {
  char line[160];
  std::snprintf(line, sizeof line,
                "{\"frame\":%lld,\"light\":%.17g,\"content\":%.17g,\"fingerprint\":\"%016" PRIx64 "\"}",
                frame.number, frame.light_time, frame.content_time, frame.fingerprint);
  state_->newest = frame.light_time;
  state_->line(line);
  if (state_->bytes >= state_->limits.part_bytes) state_->begin_next_part();
  if (frame.light_time - state_->flushed < 1 && frame.light_time > state_->flushed) return;
  state_->flushed = frame.light_time;
  state_->flush();
}

struct RunReader::State {
  std::filesystem::path log, surfaces;
  int age = 0;                 ///< of the part that is read
  int part = 0;                ///< its number; 0: none was read yet
  std::filesystem::path path;  ///< of this part
  std::ifstream file;
  std::optional<dds::internal::RunMcapLines> mcap;  ///< instead of the file
  long long number = 0;                             ///< of the line, from 1
  /// A part repeats the surfaces and the picture that the one before ended with.
  bool skips_surfaces = false, skips_picture = false;

  void open() {
    path = part_path(log, age);
    procam::internal::require_regular_file(path);
    number = 0;
    mcap.reset();
    if (dds::internal::is_run_mcap(path)) return void(mcap.emplace(path));
    errno = 0;
    file = std::ifstream(path, std::ios::binary);
    if (!file)
      throw Error(ErrorKind::kIo, path.string(), std::strerror(errno),
                  "give a log that project-live --record wrote");
  }

  /// The next whole line of this part; false at its end.
  bool read(std::string& line) {
    using procam::internal::LineEnd;
    if (mcap) {
      std::optional<std::string> next = mcap->next();
      if (!next && ++number == 1 && part == 0) throw log_error(path, 1, "the log is empty");
      if (!next) return false;
      ++number;
      line = std::move(*next);
      return true;
    }
    const LineEnd end = procam::internal::read_bounded_line(file, line, limits::kLogLineBytes);
    ++number;
    if (end == LineEnd::kTooLong) throw log_error(path, number, "it is longer than 64 MiB");
    if (end == LineEnd::kCut && number == 1 && part == 0)
      throw log_error(path, 1, line.empty() ? "the log is empty" : "the log ends in its first line");
    return end == LineEnd::kLineFeed;
  }

  /// nullopt: the program ended when this part began.
  std::optional<RunConditions> read_header() {
    std::string line;
    if (!read(line)) return std::nullopt;
    const std::optional<std::string> conditions = between(line, kHeader, "\"}");
    if (!conditions) throw log_error(path, 1, "it does not begin as a run does");
    return RunConditions{*conditions};
  }

  /// After {"part":N}: what is missing before it, if anything.
  std::optional<MissingParts> begin_part(const std::string& line) {
    const std::optional<std::string> text = between(line, kPart, "}");
    int found = 0, end = 0;
    if (!text || std::sscanf(text->c_str(), "%9d%n", &found, &end) != 1 || std::size_t(end) != text->size() ||
        found <= part || number != 2)
      throw log_error(path, number, "it is no part of this run");
    const int expected = part + 1;
    skips_surfaces = skips_picture = found == expected && part > 0;
    part = found;
    if (found == expected) return std::nullopt;
    return MissingParts{expected, found - 1};
  }

  RunRecord parse(const std::string& line) const {
    if (line.rfind("{\"arrival\":", 0) == 0) {
      std::optional<track::StampedPose> pose = track::internal::pose_of_log_line(line);
      if (!pose) throw log_error(path, number, "it holds no pose");
      return std::move(*pose);
    }
    if (const auto text = between(line, kSighted, "}")) {
      std::optional<track::StampedPose> pose = track::internal::pose_of_log_line(*text);
      if (!pose) throw log_error(path, number, "it holds no pose of a surface");
      return SightedSurface{std::move(*pose)};
    }
    if (line.rfind("{\"frame\":", 0) == 0) {
      const std::optional<RecordedFrame> frame = read_frame(line);
      if (!frame) throw log_error(path, number, "it holds no frame");
      return *frame;
    }
    if (line.rfind("{\"projector\":", 0) == 0) {
      const std::optional<MovedProjector> moved = read_projector(line);
      if (!moved) throw log_error(path, number, "it holds no pose of the projector");
      return *moved;
    }
    try {
      if (const auto text = between(line, "{\"surfaces\":", "}"))
        return io::surfaces_from_text(*text, surfaces);
      if (line.rfind(kBlendLine, 0) == 0) {
        std::optional<BlendScene> blend = read_blend_line(line, surfaces);
        if (!blend) throw log_error(path, number, "it holds no blend");
        return std::move(*blend);
      }
    } catch (const Error& error) {
      throw log_error(path, number, error.what());
    }
    if (const auto picture = between(line, "{\"picture\":\"", "\"}")) {
      int i = 0;
      while (i < 3 && *picture != kPictureNames[i]) ++i;
      if (i == 3) throw log_error(path, number, "'" + *picture + "' is no picture");
      return TestPattern(i);
    }
    throw log_error(path, number, "it is no line of a run");
  }
};

RunReader::RunReader(const std::filesystem::path& path, const std::filesystem::path& surfaces)
    : state_(std::make_unique<State>()) {
  state_->log = path;
  state_->surfaces = surfaces;
  state_->age = older_parts(path);
  state_->open();
}
RunReader::~RunReader() = default;

std::optional<RunRecord> RunReader::next() {
  State& s = *state_;
  std::string line;
  while (true) {
    if (s.number == 0) {
      const std::optional<RunConditions> conditions = s.read_header();
      if (!conditions) return std::nullopt;
      if (s.part == 0) return *conditions;
      continue;
    }
    if (!s.read(line)) {
      std::error_code ignored;
      if (s.age == 0 || !std::filesystem::exists(part_path(s.log, s.age - 1), ignored)) return std::nullopt;
      --s.age;
      s.open();
      continue;
    }
    if (line.rfind(kPart, 0) == 0) {
      if (const auto missing = s.begin_part(line)) return *missing;
      continue;
    }
    s.part = std::max(s.part, 1);
    const auto repeated = [&line](bool& skips, const char* begin) {
      return line.rfind(begin, 0) == 0 && std::exchange(skips, false);
    };
    if (repeated(s.skips_surfaces, "{\"surfaces\":") || repeated(s.skips_picture, "{\"picture\":")) continue;
    // The surfaces and the picture come right after the number of the part.
    s.skips_surfaces = s.skips_picture = false;
    return s.parse(line);
  }
}

}  // namespace procam::show
