#include "procam/session/simulated.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "procam/core/base/error.hpp"

namespace procam::session {
namespace {

/// What writing such a session says; nothing may be left behind.
std::optional<Error> refusal(const std::string& setting, const std::string& room = "") {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "procam_refused_session";
  std::filesystem::remove_all(folder);
  SimulationOptions options;
  options.settings = {setting};
  options.room = room;
  options.views = 1;
  std::optional<Error> error;
  try {
    write_simulated_session(folder, options);
  } catch (const Error& thrown) {
    error = thrown;
  }
  EXPECT_FALSE(std::filesystem::exists(folder)) << setting;
  std::filesystem::remove_all(folder);
  return error;
}

TEST(SimulatedSession, RefusesLensDeviationsThatAreNone) {
  for (const char* value : {"-1px", "11px", "nan", "", "abc", "1e99px"})
    for (const char* key : {"lens-deviation=", "camera-lens-deviation=", "projector-lens-deviation="}) {
      const std::optional<Error> error = refusal(std::string(key) + value);
      ASSERT_TRUE(error) << key << value;
      EXPECT_EQ(error->kind(), ErrorKind::kInput) << key << value;
    }
}

TEST(SimulatedSession, RefusesFlexThatIsNone) {
  for (const char* value : {"-1mm", "1m", "nan", "", "abc"})
    EXPECT_TRUE(refusal(std::string("flex=") + value)) << value;
}

TEST(SimulatedSession, RefusesImageChangesThatAreNone) {
  for (const char* setting : {"refocus=-1%", "refocus=6%", "refocus=nan", "refocus=", "stabiliser=-1px",
                              "stabiliser=101px", "stabiliser=2mm"})
    EXPECT_TRUE(refusal(setting)) << setting;
}

/// Silently omitted, it would look as if it had no effect.
TEST(SimulatedSession, RefusesInARoomWhatOnlyBoardsHave) {
  for (const char* setting :
       {"lens-deviation=0.05px", "bend=6mm", "flex=1mm", "refocus=0.3%", "stabiliser=2px"}) {
    const std::optional<Error> error = refusal(setting, "wall");
    ASSERT_TRUE(error) << setting;
    EXPECT_EQ(error->kind(), ErrorKind::kUnsupported) << setting;
  }
}

}  // namespace
}  // namespace procam::session
