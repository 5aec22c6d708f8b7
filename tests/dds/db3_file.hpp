#pragma once
/// A .db3 file as rosbag2 writes it.
#include <gtest/gtest.h>
#include <sqlite3.h>

#include <filesystem>
#include <string>

namespace procam::test {

class Db3File {
 public:
  explicit Db3File(const std::filesystem::path& path) {
    std::filesystem::remove(path);
    EXPECT_EQ(sqlite3_open(path.c_str(), &database_), SQLITE_OK);
    run("PRAGMA synchronous = OFF");
    run("CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, serialization_format TEXT NOT "
        "NULL, offered_qos_profiles TEXT NOT NULL)");
    run("CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, data BLOB NOT "
        "NULL)");
    run("CREATE INDEX timestamp_idx ON messages (timestamp ASC)");
  }
  Db3File(const Db3File&) = delete;
  Db3File& operator=(const Db3File&) = delete;
  ~Db3File() { sqlite3_close(database_); }

  void run(const std::string& text) {
    EXPECT_EQ(sqlite3_exec(database_, text.c_str(), nullptr, nullptr, nullptr), SQLITE_OK)
        << sqlite3_errmsg(database_);
  }
  Db3File& topic(int id, const std::string& name, const std::string& type,
                 const std::string& format = "cdr") {
    run("INSERT INTO topics VALUES(" + std::to_string(id) + ",'" + name + "','" + type + "','" + format +
        "','')");
    return *this;
  }
  Db3File& message(int topic, long long timestamp, const std::string& data) {
    sqlite3_stmt* insert = nullptr;
    sqlite3_prepare_v2(database_, "INSERT INTO messages(topic_id, timestamp, data) VALUES(?, ?, ?)", -1,
                       &insert, nullptr);
    sqlite3_bind_int(insert, 1, topic);
    sqlite3_bind_int64(insert, 2, timestamp);
    sqlite3_bind_blob(insert, 3, data.data(), int(data.size()), SQLITE_TRANSIENT);
    EXPECT_EQ(sqlite3_step(insert), SQLITE_DONE);
    sqlite3_finalize(insert);
    return *this;
  }

 private:
  sqlite3* database_ = nullptr;
};

}  // namespace procam::test
