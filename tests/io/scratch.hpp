#pragma once
/// A folder of its own for each test, gone when the test ends.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "procam/core/error.hpp"

namespace procam::test {

class Scratch {
 public:
  Scratch() {
    std::string name = (std::filesystem::temp_directory_path() / "procam-io-XXXXXX").string();
    path_ = ::mkdtemp(name.data());
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  ~Scratch() { std::filesystem::remove_all(path_); }

  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
  const std::filesystem::path& path() const { return path_; }

  /// Writes a file, folders included.
  std::filesystem::path write(const std::string& name, const std::string& bytes) const {
    const std::filesystem::path file = path_ / name;
    std::filesystem::create_directories(file.parent_path());
    // A file that is emptied and filled again is flushed to the disk by ext4; a new one is not.
    std::filesystem::remove(file);
    std::ofstream(file, std::ios::binary) << bytes;
    return file;
  }

 private:
  std::filesystem::path path_;
};

/// The procam::Error that the call throws; fails the test when there is none.
template <typename Call>
Error error_of(Call call) {
  try {
    call();
  } catch (const Error& error) {
    return error;
  }
  ADD_FAILURE() << "no procam::Error was thrown";
  return Error(ErrorKind::kIo, "", "", "");
}

inline bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace procam::test

/// The call throws procam::Error of that kind, and its message has that part.
#define EXPECT_ERROR(call, expected_kind, part)                                \
  do {                                                                         \
    const procam::Error error = procam::test::error_of([&] { (void)(call); }); \
    EXPECT_EQ(error.kind(), procam::ErrorKind::expected_kind) << error.what(); \
    EXPECT_TRUE(procam::test::contains(error.what(), part)) << error.what();   \
  } while (false)
