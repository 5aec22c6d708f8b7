#pragma once
/// The folder of four simulated views that tests/e2e/CMakeLists.txt makes once for all tests of bad input.
#include <filesystem>

namespace procam::test {

inline const std::filesystem::path kSession = PROCAM_E2E_SESSION;

}  // namespace procam::test
