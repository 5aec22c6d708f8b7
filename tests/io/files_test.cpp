#include "procam/io/files.hpp"
#include "sha256.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>

#include "scratch.hpp"

namespace procam::io {
namespace {

namespace fs = std::filesystem;
using test::Scratch;

std::size_t entries(const fs::path& folder) {
  return std::size_t(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

TEST(Files, ReadsBackWhatWasWritten) {
  const Scratch scratch;
  const std::string bytes("a\0b\r\n\xff", 6);
  write_file_atomically(scratch / "x.bin", "older and longer than what follows");
  write_file_atomically(scratch / "x.bin", bytes);
  EXPECT_EQ(read_file(scratch / "x.bin"), bytes);
  EXPECT_EQ(entries(scratch.path()), 1u) << "a temporary file was left behind";
}

TEST(Files, RefusesAnUnwritableOutputAndLeavesNothing) {
  const Scratch scratch;
  EXPECT_ERROR(write_file_atomically(scratch / "no/such/folder/rig.json", "x"), kIo,
               "No such file or directory");
  // Below a regular file: unwritable for root, too.
  scratch.write("file", "kept");
  EXPECT_ERROR(write_file_atomically(scratch / "file/rig.json", "x"), kIo, "Not a directory");
  fs::create_directory(scratch / "folder");
  EXPECT_ERROR(write_file_atomically(scratch / "folder", "x"), kIo, "Is a directory");
  EXPECT_ERROR(require_writable(scratch / "file/rig.json"), kIo, "Not a directory");
  EXPECT_ERROR(require_writable(scratch / "folder"), kIo, "Is a directory");
  require_writable(scratch / "file");
  EXPECT_EQ(read_file(scratch / "file"), "kept");
  EXPECT_EQ(entries(scratch.path()), 2u);
}

TEST(Files, WritesThroughALinkAndIntoADevice) {
  const Scratch scratch;
  scratch.write("real", "old");
  fs::create_symlink(scratch / "real", scratch / "link");
  write_file_atomically(scratch / "link", "new");
  EXPECT_TRUE(fs::is_symlink(scratch / "link"));
  EXPECT_EQ(read_file(scratch / "real"), "new");
  write_file_atomically("/dev/null", "gone");
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

TEST(Files, RefusesToReadWhatIsAbsentAFolderOrTooLarge) {
  const Scratch scratch;
  EXPECT_ERROR(read_file(scratch / "absent"), kIo, "No such file");
  EXPECT_ERROR(read_file(scratch.path()), kIo, "Is a directory");
  scratch.write("long", std::string(1001, 'x'));
  EXPECT_ERROR(read_file(scratch / "long", 1000), kInput, "larger than the 1000 bytes");
}

// NIST FIPS 180-4 example vectors, and lengths round the block's padding boundary against sha256sum.
TEST(Sha256, MatchesTheVectorsOfTheStandard) {
  EXPECT_EQ(sha256(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(sha256(std::string(1000000, 'a')),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
  const Scratch scratch;
  EXPECT_EQ(sha256_of_file(scratch.write("abc", "abc")), sha256("abc"));
}

// Where the processor has instructions for it, both ways are tried on it.
TEST(Sha256, IsTheSameByEveryWayToComputeIt) {
  for (const std::size_t length : {0, 1, 55, 56, 63, 64, 65, 127, 128, 1000, 4096}) {
    std::string bytes(length, ' ');
    for (std::size_t i = 0; i < length; ++i) bytes[i] = char(i * i * 37 + i / 3);
    for (const CompressBlocks way : ways_to_compress())
      EXPECT_EQ(sha256(bytes, way), sha256(bytes, ways_to_compress().front())) << length;
  }
  EXPECT_EQ(sha256(std::string(1000000, 'a'), ways_to_compress().front()),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(NaturalOrder, CountsAsPeopleDo) {
  std::vector<std::string> names{"frame_10",
                                 "frame_2",
                                 "frame_02",
                                 "frame_1",
                                 "b2",
                                 "a10b3",
                                 "a10b20",
                                 "frame",
                                 "x99999999999999999999999",
                                 "x100000000000000000000000"};
  const std::vector<std::string> expected{"a10b3",
                                          "a10b20",
                                          "b2",
                                          "frame",
                                          "frame_1",
                                          "frame_02",
                                          "frame_2",
                                          "frame_10",
                                          "x99999999999999999999999",
                                          "x100000000000000000000000"};
  std::sort(names.begin(), names.end(), natural_less);
  EXPECT_EQ(names, expected);
  for (const std::string& a : names)
    for (const std::string& b : names)
      EXPECT_EQ(natural_less(a, b) || natural_less(b, a), a != b) << a << " " << b;
}

}  // namespace
}  // namespace procam::io
