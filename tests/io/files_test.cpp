#include "procam/io/files.hpp"
#include "sha256.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>

#include "mesh/mesh_file.hpp"
#include "procam/io/image/images.hpp"
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

// Opening a pipe would wait for its writer, without end.
TEST(Files, RefusesPipesSocketsAndDevices) {
  const Scratch scratch;
  ASSERT_EQ(::mkfifo((scratch / "pipe.png").c_str(), 0600), 0);
  ASSERT_EQ(::mkfifo((scratch / "pipe.obj").c_str(), 0600), 0);
  const int listener = ::socket(AF_UNIX, SOCK_STREAM, 0);
  sockaddr_un address = {};
  address.sun_family = AF_UNIX;
  std::strncpy(address.sun_path, (scratch / "socket").c_str(), sizeof address.sun_path - 1);
  ASSERT_EQ(::bind(listener, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  EXPECT_ERROR(read_file(scratch / "pipe.png"), kIo, "a named pipe, not a regular file");
  EXPECT_ERROR(read_file(scratch / "socket"), kIo, "a socket, not a regular file");
  EXPECT_ERROR(read_file("/dev/zero"), kIo, "a device, not a regular file");
  EXPECT_ERROR(load_image(scratch / "pipe.png"), kIo, "a named pipe");
  EXPECT_ERROR(load_mesh(scratch / "pipe.obj"), kIo, "a named pipe");
  EXPECT_EQ(image_size(scratch / "pipe.png"), std::nullopt);
  ::close(listener);
}

// A process that was killed left its temporary files, and a later one has its number.
TEST(Files, TemporaryFilesOfAKilledProcessDoNotMatter) {
  const Scratch scratch;
  for (int i = 0; i < 300; ++i)
    scratch.write(".rig.json.tmp-" + std::to_string(::getpid()) + "-" + std::to_string(i), "half");
  write_file_atomically(scratch / "rig.json", "whole");
  EXPECT_EQ(read_file(scratch / "rig.json"), "whole");
  const std::string longest(255, 'x');  // bytes that a name can have
  write_file_atomically(scratch / longest, "whole");
  EXPECT_EQ(read_file(scratch / longest), "whole");
  EXPECT_EQ(entries(scratch.path()), 302u);
}

TEST(Files, AFileKeepsItsMode) {
  const Scratch scratch;
  const auto mode = [&](const std::string& name) {
    struct stat about {};
    EXPECT_EQ(::stat((scratch / name).c_str(), &about), 0);
    return about.st_mode & 07777;
  };
  scratch.write("secret", "old");
  fs::create_symlink(scratch / "secret", scratch / "link");
  for (const mode_t wanted : {0600, 0640, 0666}) {
    ASSERT_EQ(::chmod((scratch / "secret").c_str(), wanted), 0);
    write_file_atomically(scratch / "link", "new");
    EXPECT_EQ(mode("secret"), wanted);
  }
  const mode_t before = ::umask(027);
  write_file_atomically(scratch / "fresh", "new");
  ::umask(before);
  EXPECT_EQ(mode("fresh"), mode_t(0640));
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
