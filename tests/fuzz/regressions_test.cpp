// Every fuzz target over the inputs that are kept: the seeds, and what once was a finding.
#include <gtest/gtest.h>

#include <algorithm>

#include "fuzz_target.hpp"

namespace procam::fuzz {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> inputs(const std::string& kind, const char* target) {
  const fs::path place = fs::path(PROCAM_FUZZ_INPUTS) / kind / target;
  std::vector<fs::path> files;
  if (fs::is_directory(place))
    for (const auto& entry : fs::directory_iterator(place)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

class FuzzTarget : public testing::TestWithParam<Target> {};

TEST_P(FuzzTarget, HoldsOnEveryKeptInput) {
  const Target target = GetParam();
  EXPECT_NO_THROW(run(target, "")) << "the empty input";
  EXPECT_FALSE(inputs("corpus", target.name).empty()) << "give " << target.name << " an input to begin with";
  for (const char* kind : {"corpus", "regressions"})
    for (const fs::path& file : inputs(kind, target.name))
      EXPECT_NO_THROW(run(target, io::read_file(file))) << file.string();
}

INSTANTIATE_TEST_SUITE_P(All, FuzzTarget, testing::ValuesIn(targets()),
                         [](const auto& info) { return std::string(info.param.name); });

TEST(FuzzInputs, BelongToATarget) {
  for (const char* kind : {"corpus", "regressions"}) {
    const fs::path place = fs::path(PROCAM_FUZZ_INPUTS) / kind;
    if (!fs::is_directory(place)) continue;
    for (const auto& entry : fs::directory_iterator(place))
      EXPECT_NE(find_target(entry.path().filename().string()), nullptr) << entry.path().string();
  }
}

}  // namespace
}  // namespace procam::fuzz
