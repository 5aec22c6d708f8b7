#include "message_log.hpp"

#include <algorithm>
#include <fstream>

#include "mcap_records.hpp"
#include "procam/core/base/detail/regular_file.hpp"
#include "procam/core/base/error.hpp"
#include "procam/io/files.hpp"

namespace procam::dds::internal {
namespace {

namespace fs = std::filesystem;

enum class Format { kNone, kMcap, kSqlite, kZstd, kRos1 };

Format format_of(const fs::path& path) {
  std::error_code ignored;
  if (!fs::is_regular_file(path, ignored)) return Format::kNone;
  char bytes[16] = {};
  std::ifstream(path, std::ios::binary).read(bytes, sizeof bytes);
  const std::string_view begin(bytes, sizeof bytes);
  const auto is = [&](std::string_view magic) { return begin.substr(0, magic.size()) == magic; };
  if (is(kMcapMagic)) return Format::kMcap;
  if (is(std::string_view("SQLite format 3\0", 16))) return Format::kSqlite;
  if (is("\x28\xb5\x2f\xfd")) return Format::kZstd;
  if (is("#ROSBAG V")) return Format::kRos1;
  return Format::kNone;
}

bool has_name_of_log(const fs::path& path) {
  return path.extension() == ".mcap" || path.extension() == ".db3";
}

std::unique_ptr<MessageLog> open_file(const fs::path& path) {
  procam::internal::require_regular_file(path);
  switch (format_of(path)) {
    case Format::kMcap:
      return open_mcap(path);
    case Format::kSqlite:
      return open_db3(path);
    case Format::kZstd:
      throw Error(ErrorKind::kUnsupported, path.string(), "the file as a whole is compressed (zstd)",
                  "unpack it first: zstd -d " + path.string());
    case Format::kRos1:
      throw Error(ErrorKind::kUnsupported, path.string(), "it is a bag of ROS 1",
                  "convert it, e.g. with 'mcap convert', or export its poses (docs/live.md)");
    case Format::kNone:
      break;
  }
  std::error_code ignored;
  if (!fs::exists(path, ignored))
    throw Error(ErrorKind::kIo, path.string(), "there is no such file", "give a log that is there");
  throw Error(ErrorKind::kInput, path.string(),
              has_name_of_log(path)
                  ? "it does not begin as an MCAP or SQLite file: it is damaged, or another format"
                  : "it is no log of ROS 2",
              "give an .mcap or .db3 file, or the folder of a bag");
}

/// The files of a rosbag2 folder, one after another.
class JoinedLog : public MessageLog {
 public:
  explicit JoinedLog(const fs::path& folder) {
    for (const fs::path& file : files_in(folder)) {
      files_.push_back({open_file(file), {}, {}});
      File& added = files_.back();
      begin_ns_ = files_.size() == 1 ? added.log->begin_ns() : std::min(begin_ns_, added.log->begin_ns());
      for (const LogTopic& topic : added.log->topics()) added.topics.push_back(index_of(topic));
      if (!added.log->notice().empty()) notice_ = file.filename().string() + ": " + added.log->notice();
    }
  }

  void select(const std::vector<std::size_t>& topics) override {
    current_ = 0;
    for (File& file : files_) {
      file.selected.clear();
      for (std::size_t i = 0; i < file.topics.size(); ++i)
        if (std::find(topics.begin(), topics.end(), file.topics[i]) != topics.end())
          file.selected.push_back(i);
      file.log->select(file.selected);
    }
  }

  bool next(LoggedMessage& message) override {
    for (; current_ < files_.size(); ++current_)
      if (File& file = files_[current_]; file.log->next(message)) {
        message.topic = file.topics[message.topic];
        return true;
      }
    return false;
  }

 private:
  struct File {
    std::unique_ptr<MessageLog> log;
    std::vector<std::size_t> topics;  ///< of the file, as indices into topics_
    std::vector<std::size_t> selected;
  };

  /// metadata.yaml, which names them, is written when the recorder ends: a killed one leaves the files alone. Their names
  /// count up.
  static std::vector<fs::path> files_in(const fs::path& folder) {
    std::vector<fs::path> files;
    std::error_code failed;
    for (const auto& entry : fs::directory_iterator(folder, failed)) {
      const std::string name = entry.path().filename().string();
      const auto ends = [&](const std::string& end) {
        return name.size() > end.size() && name.compare(name.size() - end.size(), end.size(), end) == 0;
      };
      if (ends(".mcap") || ends(".db3") || ends(".mcap.zstd") || ends(".db3.zstd"))
        files.push_back(entry.path());
    }
    if (files.empty())
      throw Error(ErrorKind::kInput, folder.string(), "the folder holds no .mcap or .db3 file",
                  "give the folder that 'ros2 bag record' wrote");
    std::sort(files.begin(), files.end(), [](const fs::path& a, const fs::path& b) {
      return io::natural_less(a.filename().string(), b.filename().string());
    });
    return files;
  }

  std::size_t index_of(const LogTopic& topic) {
    const auto known = std::find_if(topics_.begin(), topics_.end(), [&](const LogTopic& one) {
      return one.name == topic.name && one.type == topic.type && one.encoding == topic.encoding;
    });
    if (known != topics_.end()) return std::size_t(known - topics_.begin());
    topics_.push_back(topic);
    return topics_.size() - 1;
  }

  std::vector<File> files_;
  std::size_t current_ = 0;
};

}  // namespace

bool is_message_log(const fs::path& path) {
  std::error_code ignored;
  return fs::is_directory(path, ignored) || format_of(path) != Format::kNone ||
         (has_name_of_log(path) && fs::exists(path, ignored));
}

std::unique_ptr<MessageLog> open_message_log(const fs::path& path) {
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) return std::make_unique<JoinedLog>(path);
  return open_file(path);
}

}  // namespace procam::dds::internal
