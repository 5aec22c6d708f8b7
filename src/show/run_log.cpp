#include "procam/show/run_log.hpp"

#include <cerrno>
#include <cinttypes>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>

#include "procam/io/surface_file.hpp"
#include "procam/track/wire.hpp"

namespace procam::show {
namespace {

constexpr const char* kHeader = "{\"format\":\"procam-run\",\"version\":1,\"conditions\":\"";
constexpr const char* kPictures[] = {"content", "grid", "mask"};
/// A surface file may hold many surfaces; nothing else is long.
constexpr std::size_t kLongestLine = std::size_t(1) << 26;

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

std::optional<track::StampedPose> read_pose(const std::string& line) {
  constexpr const char* kBegin = "{\"arrival\":";
  const char* number = line.c_str() + std::strlen(kBegin);
  char* end = nullptr;
  const double arrival = std::strtod(number, &end);
  if (end == number || *end != ',' || !std::isfinite(arrival)) return std::nullopt;
  track::Parsed parsed = track::parse_poses("{" + std::string(end + 1));
  if (parsed.poses.size() != 1 || parsed.malformed != 0) return std::nullopt;
  parsed.poses[0].arrival = arrival;
  return std::move(parsed.poses[0]);
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
  std::ofstream file;
  double flushed = 0;

  void line(const std::string& text_of_line) { file << text_of_line << '\n'; }
  void flush() {
    file.flush();
    if (!file)
      throw Error(ErrorKind::kIo, path.string(), "it cannot be written further", "free some of the disk");
  }
};

RunRecorder::RunRecorder(const std::filesystem::path& path, const std::string& conditions)
    : state_(std::make_unique<State>()) {
  state_->path = path;
  state_->file.open(path, std::ios::binary);
  if (!state_->file)
    throw Error(ErrorKind::kIo, path.string(), std::strerror(errno), "give a file that can be written");
  std::string words = conditions;
  // What would end the string or the line stands for nothing here.
  for (char& letter : words)
    if (letter == '"' || letter == '\\' || static_cast<unsigned char>(letter) < 0x20) letter = '_';
  state_->line(kHeader + words + "\"}");
  state_->flush();
}
RunRecorder::~RunRecorder() = default;

void RunRecorder::record(const SurfaceSet& surfaces) {
  std::string text = io::surfaces_to_text(surfaces);
  for (char& letter : text)
    if (letter == '\n') letter = ' ';
  state_->line("{\"surfaces\":" + text + "}");
}

void RunRecorder::record(TestPattern picture) {
  state_->line(std::string("{\"picture\":\"") + kPictures[int(picture)] + "\"}");
}

void RunRecorder::record(const track::StampedPose& message) {
  char arrival[64];
  std::snprintf(arrival, sizeof arrival, "{\"arrival\":%.17g,", message.arrival);
  std::string line = arrival + track::to_json_line(message).substr(1);
  while (!line.empty() && line.back() == '\n') line.pop_back();
  state_->line(line);
}

void RunRecorder::record(const RecordedFrame& frame) {
  char line[160];
  std::snprintf(line, sizeof line,
                "{\"frame\":%lld,\"light\":%.17g,\"content\":%.17g,\"fingerprint\":\"%016" PRIx64 "\"}",
                frame.number, frame.light_time, frame.content_time, frame.fingerprint);
  state_->line(line);
  if (frame.light_time - state_->flushed < 1 && frame.light_time > state_->flushed) return;
  state_->flushed = frame.light_time;
  state_->flush();
}

struct RunReader::State {
  std::filesystem::path path, surfaces;
  std::ifstream file;
  long long number = 0;  ///< of the line, from 1

  RunRecord parse(const std::string& line) const {
    if (line.size() > kLongestLine) throw log_error(path, number, "it is longer than 64 MiB");
    if (number == 1) {
      const std::optional<std::string> conditions = between(line, kHeader, "\"}");
      if (!conditions) throw log_error(path, 1, "it does not begin as a run does");
      return RunConditions{*conditions};
    }
    if (line.rfind("{\"arrival\":", 0) == 0) {
      std::optional<track::StampedPose> pose = read_pose(line);
      if (!pose) throw log_error(path, number, "it holds no pose");
      return std::move(*pose);
    }
    if (line.rfind("{\"frame\":", 0) == 0) {
      const std::optional<RecordedFrame> frame = read_frame(line);
      if (!frame) throw log_error(path, number, "it holds no frame");
      return *frame;
    }
    if (const auto text = between(line, "{\"surfaces\":", "}")) {
      try {
        return io::surfaces_from_text(*text, surfaces);
      } catch (const Error& error) {
        throw log_error(path, number, error.what());
      }
    }
    if (const auto picture = between(line, "{\"picture\":\"", "\"}")) {
      int i = 0;
      while (i < 3 && *picture != kPictures[i]) ++i;
      if (i == 3) throw log_error(path, number, "'" + *picture + "' is no picture");
      return TestPattern(i);
    }
    throw log_error(path, number, "it is no line of a run");
  }
};

RunReader::RunReader(const std::filesystem::path& path, const std::filesystem::path& surfaces)
    : state_(std::make_unique<State>()) {
  state_->path = path;
  state_->surfaces = surfaces;
  state_->file.open(path, std::ios::binary);
  if (!state_->file)
    throw Error(ErrorKind::kIo, path.string(), std::strerror(errno),
                "give a log that project-live --record wrote");
}
RunReader::~RunReader() = default;

std::optional<RunRecord> RunReader::next() {
  std::string line;
  if (!std::getline(state_->file, line) || state_->file.eof()) return std::nullopt;
  ++state_->number;
  return state_->parse(line);
}

}  // namespace procam::show
