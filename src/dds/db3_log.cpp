/// Reads the SQLite files of rosbag2: tables topics(id, name, type, serialization_format, ...) and messages(id, topic_id,
/// timestamp, data). In message mode rosbag2 compresses each message (zstd).
#include <sqlite3.h>

#include <algorithm>
#include <map>

#include "compression.hpp"
#include "message_log.hpp"
#include "procam/core/base/error.hpp"
#include "procam/core/base/limits.hpp"

namespace procam::dds::internal {
namespace {

struct CloseDatabase {
  void operator()(sqlite3* database) const { sqlite3_close_v2(database); }
};
struct EndStatement {
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
};
using Statement = std::unique_ptr<sqlite3_stmt, EndStatement>;

class Db3Log : public MessageLog {
 public:
  explicit Db3Log(const std::filesystem::path& path) : path_(path) {
    sqlite3* opened = nullptr;
    const int failed = sqlite3_open_v2(path.c_str(), &opened, SQLITE_OPEN_READONLY, nullptr);
    database_.reset(opened);
    if (failed != SQLITE_OK) throw error();
    // The file may be anyone's: no functions of its schema run, no value is larger than a message.
    sqlite3_db_config(opened, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
    sqlite3_db_config(opened, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
    sqlite3_limit(opened, SQLITE_LIMIT_LENGTH, int(limits::kDdsSampleBytes));
    require_table("topics");
    require_table("messages");
    read_topics();
  }

  void select(const std::vector<std::size_t>& topics) override {
    std::string ids;
    for (const auto& [id, topic] : topic_of_id_)
      if (std::find(topics.begin(), topics.end(), topic) != topics.end())
        ids += (ids.empty() ? "" : ",") + std::to_string(id);
    messages_ = prepared("SELECT topic_id, timestamp, data FROM messages WHERE topic_id IN (" + ids +
                         ") ORDER BY timestamp, id");
  }

  bool next(LoggedMessage& message) override {
    if (!messages_) return false;
    const int result = sqlite3_step(messages_.get());
    if (result != SQLITE_ROW) {
      const bool is_damaged = result != SQLITE_DONE;
      const std::string why = sqlite3_errmsg(database_.get());
      messages_.reset();  // SQLite does not go on behind a damage
      if (is_damaged) throw Refusal{"log_damaged", "the log cannot be read further: " + why};
      return false;
    }
    const auto topic = topic_of_id_.find(sqlite3_column_int64(messages_.get(), 0));
    const void* data = sqlite3_column_blob(messages_.get(), 2);
    const int size = sqlite3_column_bytes(messages_.get(), 2);
    message.topic = topic->second;
    message.logged_ns = sqlite3_column_int64(messages_.get(), 1);
    message.bytes = {static_cast<const char*>(data), std::size_t(data == nullptr ? 0 : size)};
    if (message.bytes.substr(0, 4) == "\x28\xb5\x2f\xfd") unpack(message);  // CDR begins with a zero
    return true;
  }

 private:
  void unpack(LoggedMessage& message) {
    const std::size_t size = zstd_size(message.bytes);
    if (size > limits::kDdsSampleBytes)
      throw Refusal{"ros2_oversized", "a message of the log is larger than 64 MiB"};
    unpacked_ = unpacked_zstd(message.bytes, size);
    message.bytes = unpacked_;
  }

  Error error() const {
    return Error(ErrorKind::kInput, path_.string(),
                 database_ ? sqlite3_errmsg(database_.get()) : "SQLite has no memory",
                 "give a .db3 file of rosbag2 that is whole; 'ros2 bag reindex' repairs some");
  }

  Statement prepared(const std::string& text) const {
    sqlite3_stmt* statement = nullptr;
    if (sqlite3_prepare_v2(database_.get(), text.c_str(), -1, &statement, nullptr) != SQLITE_OK)
      throw error();
    return Statement(statement);
  }

  /// A view could compute without end.
  void require_table(const std::string& name) const {
    const Statement query = prepared("SELECT 1 FROM sqlite_master WHERE type = 'table' AND name = '" + name +
                                     "' AND sql NOT LIKE 'CREATE VIRTUAL%'");
    const int result = sqlite3_step(query.get());
    if (result == SQLITE_ROW) return;
    if (result != SQLITE_DONE) throw error();
    throw Error(ErrorKind::kInput, path_.string(),
                "it has no table '" + name + "', so it is no bag of rosbag2",
                "give a .db3 file that 'ros2 bag record' wrote");
  }

  void read_topics() {
    const Statement query = prepared("SELECT id, name, type, serialization_format FROM topics");
    const auto text = [&](int column) {
      const unsigned char* bytes = sqlite3_column_text(query.get(), column);
      return bytes == nullptr
                 ? std::string()
                 : std::string(reinterpret_cast<const char*>(bytes)).substr(0, limits::kFrameNameBytes);
    };
    int result = SQLITE_ROW;
    while (topics_.size() < limits::kLogTopics && (result = sqlite3_step(query.get())) == SQLITE_ROW) {
      topic_of_id_[sqlite3_column_int64(query.get(), 0)] = topics_.size();
      topics_.push_back({text(1), text(2), text(3)});
    }
    if (result != SQLITE_ROW && result != SQLITE_DONE) throw error();
    const Statement first = prepared("SELECT min(timestamp) FROM messages");
    if (sqlite3_step(first.get()) != SQLITE_ROW) throw error();
    begin_ns_ = sqlite3_column_int64(first.get(), 0);
  }

  const std::filesystem::path path_;
  std::unique_ptr<sqlite3, CloseDatabase> database_;
  std::map<sqlite3_int64, std::size_t> topic_of_id_;
  Statement messages_;  // before the database is closed
  std::string unpacked_;
};

}  // namespace

std::unique_ptr<MessageLog> open_db3(const std::filesystem::path& path) {
  return std::make_unique<Db3Log>(path);
}

}  // namespace procam::dds::internal
