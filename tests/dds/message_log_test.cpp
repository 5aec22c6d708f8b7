// Containers of logs: what comes out of files as other programs write them, and of damaged ones.
#include "message_log.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <tuple>

#ifdef PROCAM_HAVE_SQLITE3
#include "db3_file.hpp"
#endif
#include "log_files.hpp"
#include "support/expect_error.hpp"

namespace procam::dds::internal {
namespace {

using test::log_folder;
using test::McapFile;
using test::write_file;

/// Topic, time, bytes.
using Row = std::tuple<std::string, std::int64_t, std::string>;
struct Contents {
  std::vector<Row> rows;
  std::map<std::string, int> refused;
};

Contents contents_of(MessageLog& log, const std::vector<std::string>& names = {}) {
  std::vector<std::size_t> topics;
  for (std::size_t i = 0; i < log.topics().size(); ++i)
    if (names.empty() || std::find(names.begin(), names.end(), log.topics()[i].name) != names.end())
      topics.push_back(i);
  log.select(topics);
  Contents contents;
  for (LoggedMessage message;;) {
    try {
      if (!log.next(message)) return contents;
      contents.rows.emplace_back(log.topics()[message.topic].name, message.logged_ns,
                                 std::string(message.bytes));
    } catch (const Refusal& refusal) {
      ++contents.refused[refusal.cause];
    }
  }
}

std::filesystem::path stored(const std::string& name, const std::string& bytes) {
  const std::filesystem::path path = log_folder() / name;
  write_file(path, bytes);
  return path;
}

McapFile two_topics() {
  McapFile file;
  file.channel(1, "/odom", "nav_msgs/msg/Odometry").channel(7, "/image", "sensor_msgs/msg/Image");
  return file;
}
const std::vector<Row> kRows = {
    {"/odom", 1000, "one"}, {"/image", 1500, std::string(5000, 'p')}, {"/odom", 2000, "two"}};

std::string file_of(const std::string& compression, bool with_summary = true) {
  McapFile file = two_topics();
  file.message(1, 1000, "one").message(7, 1500, std::string(5000, 'p'));
  if (compression != "none") file.chunk(compression);
  file.message(1, 2000, "two");
  if (compression != "none") file.chunk(compression);
  return file.closed(with_summary);
}

TEST(Mcap, GivesTheSameMessagesHoweverTheyArePacked) {
  std::vector<std::string> packings = {"none", ""};
#ifdef PROCAM_HAVE_ZSTD
  packings.push_back("zstd");
#endif
#ifdef PROCAM_HAVE_LZ4
  packings.push_back("lz4");
#endif
  for (const std::string& packing : packings)
    for (const bool with_summary : {true, false}) {
      const auto log = open_message_log(stored("a.mcap", file_of(packing, with_summary)));
      EXPECT_EQ(log->begin_ns(), 1000);
      EXPECT_EQ(log->notice(), "");
      ASSERT_EQ(log->topics().size(), 2u);
      EXPECT_EQ(log->topics()[1].type, "sensor_msgs/msg/Image");
      EXPECT_EQ(log->topics()[1].encoding, "cdr");
      const Contents all = contents_of(*log);
      EXPECT_EQ(all.rows, kRows) << packing << with_summary;
      EXPECT_TRUE(all.refused.empty());
      // And again, one topic alone.
      EXPECT_EQ(contents_of(*log, {"/odom"}).rows, (std::vector<Row>{kRows[0], kRows[2]}));
    }
}

TEST(Mcap, WithoutItsEndIsReadAsFarAsItGoes) {
  McapFile file = two_topics();
  file.message(1, 1000, "one").chunk("").message(7, 1500, std::string(5000, 'p')).message(1, 2000, "two");
  const std::string bytes = file.unclosed();
  std::size_t most = 0;
  for (std::size_t length = test::kMcapMagic.size(); length <= bytes.size(); length += 7) {
    const auto log = open_message_log(stored("cut.mcap", bytes.substr(0, length)));
    EXPECT_NE(log->notice().find("it is read as far as it goes"), std::string::npos);
    const Contents contents = contents_of(*log);
    EXPECT_TRUE(contents.refused.empty());
    ASSERT_LE(contents.rows.size(), 3u);
    EXPECT_GE(contents.rows.size(), most);
    most = std::max(most, contents.rows.size());
    EXPECT_TRUE(std::equal(contents.rows.begin(), contents.rows.end(), kRows.begin()));
  }
  EXPECT_EQ(contents_of(*open_message_log(stored("all.mcap", bytes))).rows, kRows);
}

TEST(Mcap, ADamagedChunkIsCountedAndTheNextIsRead) {
  std::string bytes = file_of("");
  bytes[bytes.find("one")] = 'O';
  const auto log = open_message_log(stored("a.mcap", bytes));
  Contents contents = contents_of(*log);
  EXPECT_EQ(contents.rows, (std::vector<Row>{kRows[2]}));
  EXPECT_EQ(contents.refused["log_damaged"], 1);
}

/// With an index of what chunks hold, those without the topic are not even unpacked.
TEST(Mcap, ChunksWithoutTheTopicAreSkippedByTheSummary) {
  McapFile file = two_topics();
  file.message(7, 1000, "pixels").chunk("").message(1, 2000, "two").chunk("");
  std::string bytes = file.closed();
  bytes[bytes.find("pixels")] = 'P';  // its checksum is wrong then
  const auto log = open_message_log(stored("a.mcap", bytes));
  EXPECT_TRUE(contents_of(*log, {"/odom"}).refused.empty());
  EXPECT_EQ(contents_of(*log, {"/image"}).refused["log_damaged"], 1);
}

TEST(Mcap, LengthsThatLieAreRefused) {
  const auto refusals = [&](const std::string& bytes) {
    return contents_of(*open_message_log(stored("a.mcap", bytes))).refused;
  };
  McapFile huge = two_topics();
  huge.message(1, 1000, "one").chunk("zstd", std::uint64_t(1) << 40);
  EXPECT_EQ(refusals(huge.closed())["ros2_oversized"], 1);
#ifdef PROCAM_HAVE_ZSTD
  McapFile longer = two_topics();
  longer.message(1, 1000, "one").chunk("zstd", 100000);
  EXPECT_EQ(refusals(longer.closed())["log_damaged"], 1);
#endif
  McapFile unknown = two_topics();
  unknown.message(1, 1000, "one").chunk("brotli");
  EXPECT_EQ(refusals(unknown.closed())["log_damaged"], 1);
  // A record that is longer than the file, in a file that has an end.
  std::string bytes = file_of("none");
  bytes[bytes.find("one") - 22 - 2] = 0x7f;
  EXPECT_LE(contents_of(*open_message_log(stored("b.mcap", bytes))).rows.size(), 1u);
}

TEST(MessageLog, TellsWhyAFileIsNone) {
  EXPECT_ERROR(open_message_log(log_folder() / "missing.mcap"), kIo, "there is no such file");
  EXPECT_ERROR(open_message_log(stored("a.txt", "1 2 3")), kInput, "it is no log of ROS 2");
  EXPECT_ERROR(open_message_log(stored("a.db3.zstd", "\x28\xb5\x2f\xfdxxxx")), kUnsupported, "zstd -d");
  EXPECT_ERROR(open_message_log(stored("a.bag", "#ROSBAG V2.0\n")), kUnsupported, "a bag of ROS 1");
  const std::filesystem::path empty = log_folder() / "empty";
  std::filesystem::create_directories(empty);
  EXPECT_ERROR(open_message_log(empty), kInput, "no .mcap or .db3 file");
}

/// Parts of a bag, read in the order of their numbers: 10 comes after 2.
TEST(MessageLog, AFolderIsItsFilesOneAfterAnother) {
  const std::filesystem::path folder = log_folder() / "bag";
  std::filesystem::create_directories(folder);
  const auto part = [&](int number, int id, const std::string& topic, std::uint64_t time) {
    McapFile file;
    file.channel(id, topic, "nav_msgs/msg/Odometry").message(id, time, topic);
    write_file(folder / ("bag_" + std::to_string(number) + ".mcap"), file.closed());
  };
  part(10, 1, "/b", 3000);
  part(2, 4, "/b", 2000);
  part(1, 1, "/a", 1000);
  write_file(folder / "metadata.yaml", "rosbag2_bagfile_information:");
  const auto log = open_message_log(folder);
  EXPECT_EQ(log->begin_ns(), 1000);
  EXPECT_EQ(log->topics().size(), 2u);
  EXPECT_EQ(contents_of(*log).rows,
            (std::vector<Row>{{"/a", 1000, "/a"}, {"/b", 2000, "/b"}, {"/b", 3000, "/b"}}));
  EXPECT_EQ(contents_of(*log, {"/b"}).rows.size(), 2u);
}

#ifdef PROCAM_HAVE_SQLITE3
TEST(Db3, GivesTheMessagesByTime) {
  const std::filesystem::path path = log_folder() / "a.db3";
  {
    test::Db3File file(path);
    file.topic(3, "/odom", "nav_msgs/msg/Odometry").topic(5, "/image", "sensor_msgs/msg/Image");
    file.message(3, 2000, "two").message(5, 1500, std::string(5000, 'p')).message(3, 1000, "one");
    file.message(99, 1700, "of no topic");
  }
  const auto log = open_message_log(path);
  EXPECT_EQ(log->begin_ns(), 1000);
  EXPECT_EQ(contents_of(*log).rows, kRows);
  EXPECT_EQ(contents_of(*log, {"/odom"}).rows, (std::vector<Row>{kRows[0], kRows[2]}));
}

#ifdef PROCAM_HAVE_ZSTD
TEST(Db3, MessagesThatAreCompressedOneByOneAreUnpacked) {
  const std::filesystem::path path = log_folder() / "a.db3";
  const std::string plain = std::string("\0\1\0\0", 4) + std::string(300, 'x');
  std::string packed(1000, ' ');
  packed.resize(ZSTD_compress(packed.data(), packed.size(), plain.data(), plain.size(), 3));
  {
    test::Db3File file(path);
    file.topic(3, "/odom", "nav_msgs/msg/Odometry")
        .message(3, 1000, packed)
        .message(3, 2000, packed.substr(0, 9));
  }
  Contents contents = contents_of(*open_message_log(path));
  EXPECT_EQ(contents.rows, (std::vector<Row>{{"/odom", 1000, plain}}));
  EXPECT_EQ(contents.refused["log_damaged"], 1);
}
#endif

TEST(Db3, DatabasesThatAreNoBagAreRefused) {
  const std::filesystem::path path = log_folder() / "a.db3";
  {
    test::Db3File file(path);
    file.run("DROP TABLE messages");
  }
  EXPECT_ERROR(open_message_log(path), kInput, "it has no table 'messages'");
  {
    test::Db3File file(path);
    file.run("DROP TABLE messages");
    file.run(
        "CREATE VIEW messages AS WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i FROM n) SELECT i AS id, i AS topic_id, i "
        "AS timestamp, i AS data FROM n");
  }
  EXPECT_ERROR(open_message_log(path), kInput, "it has no table 'messages'");
  write_file(path, std::string("SQLite format 3\0", 16) + std::string(200, 'x'));
  EXPECT_ERROR(open_message_log(path), kInput, "not a database");
}

TEST(Db3, ADamagedOneIsReadAsFarAsItGoes) {
  const std::filesystem::path path = log_folder() / "a.db3";
  {
    test::Db3File file(path);
    file.topic(3, "/odom", "nav_msgs/msg/Odometry");
    for (int i = 0; i < 100; ++i) file.message(3, 1000 + i, std::string(3000, char('a' + i % 26)));
  }
  std::filesystem::resize_file(path, std::filesystem::file_size(path) / 2);
  const auto log = [&]() -> std::unique_ptr<MessageLog> {
    try {
      return open_message_log(path);
    } catch (const Error&) {  // SQLite may refuse it at once
      return nullptr;
    }
  }();
  if (!log) return;
  Contents contents = contents_of(*log);
  EXPECT_LT(contents.rows.size(), 100u);
  EXPECT_EQ(contents.refused["log_damaged"], 1);
}
#endif

}  // namespace
}  // namespace procam::dds::internal
