#pragma once
/// Where the real captures lie: PROCAM_TEST_DATA, else ../shared/data beside the project. Tests skip where
/// absent.
#include <cstdlib>
#include <filesystem>

namespace procam::test {

inline std::filesystem::path test_data() {
  const char* from_environment = std::getenv("PROCAM_TEST_DATA");
  return from_environment != nullptr ? from_environment : PROCAM_DEFAULT_TEST_DATA;
}

}  // namespace procam::test

#define PROCAM_REQUIRE_TEST_DATA(relative)                                                \
  if (!std::filesystem::exists(procam::test::test_data() / (relative)))                   \
  GTEST_SKIP() << "no test data at " << (procam::test::test_data() / (relative)).string() \
               << "; set PROCAM_TEST_DATA"
