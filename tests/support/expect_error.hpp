#pragma once
/// What procam::Error says, in tests.
#include <gtest/gtest.h>

#include <string>

#include "procam/core/base/error.hpp"

namespace procam::test {

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
