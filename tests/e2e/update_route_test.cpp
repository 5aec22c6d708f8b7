/// A rig refreshed by one rendered view after its projector was bumped, as a user does it.
#include <gtest/gtest.h>

#include "e2e/small_session.hpp"
#include "e2e/tool_runner.hpp"
#include "procam/io/rig_file.hpp"

namespace procam::test {
namespace {

/// The rig of the shared session, and the same rig's later views.
struct Bumped {
  ScratchFolder folder;
  ToolRun calibrated =
      run_tool("calibrate-projector", "--captures " + kSession.string() + " -o " + path("rig.json"));

  std::string path(const char* name) const { return (folder / name).string(); }
  void capture(const std::string& change) {
    const ToolRun run =
        run_tool("simulate-captures", "--seed 7 --views 1 " + change + " --force -o " + path("after"));
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }
  ToolRun update(const std::string& flags) const {
    return run_tool("calibrate-projector", "--captures " + path("after") + " --update " + path("rig.json") +
                                               " " + flags + " --truth " + path("after/truth.json") +
                                               " --json -o " + path("fresh.json"));
  }
};

TEST(UpdateRoute, OneViewAfterABump) {
  Bumped rig;
  ASSERT_EQ(rig.calibrated.exit_code, 0) << rig.calibrated.err;
  rig.capture("--bump 0.3deg");

  // A change that was not stated is named, and no file appears.
  const ToolRun unstated = rig.update("");
  EXPECT_EQ(unstated.exit_code, 4) << unstated.err;
  EXPECT_NE(unstated.err.find("state --changed projector:pose"), std::string::npos) << unstated.err;
  EXPECT_FALSE(std::filesystem::exists(rig.path("fresh.json")));

  const ToolRun run = rig.update("--changed pose");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const nlohmann::json said = run.json();
  const nlohmann::json& change = said.at("changes").at(0);
  EXPECT_EQ(change.at("device"), "projector");
  EXPECT_NEAR(change.at("rotation_deg").get<double>(), 0.3,
              4 * change.at("rotation_sigma_deg").get<double>());
  EXPECT_LT(change.at("rotation_sigma_deg").get<double>(), 0.06);
  EXPECT_GE(said.at("truth").at("parameters_inside_3_sigma"),
            said.at("truth").at("parameters").get<int>() - 1);
  EXPECT_LT(said.at("truth").at("rms_mm").get<double>(), 3 * said.at("wall").at("rms_mm").get<double>());
  const Rig fresh = io::load_rig(rig.path("fresh.json"));
  EXPECT_EQ(fresh.provenance.options.at("changed"), "projector:pose");
  EXPECT_EQ(fresh.covariance.names, io::load_rig(rig.path("rig.json")).covariance.names);

  // A refreshed rig is a rig: it can be refreshed again.
  std::filesystem::rename(rig.path("fresh.json"), rig.path("rig.json"));
  EXPECT_EQ(rig.update("").exit_code, 0);
}

TEST(UpdateRoute, FlagsThatAreNotUnderstood) {
  Bumped rig;
  ASSERT_EQ(rig.calibrated.exit_code, 0) << rig.calibrated.err;
  rig.capture("--zoom 1.04");
  EXPECT_EQ(rig.update("--changed zoom").exit_code, 0);
  EXPECT_EQ(rig.update("--changed colour").exit_code, 2);
  EXPECT_EQ(rig.update("--changed beamer:zoom").exit_code, 3);
  EXPECT_EQ(rig.update("--changed zoom --holdout 2").exit_code, 2);
  EXPECT_EQ(run_tool("calibrate-projector",
                     "--captures " + rig.path("after") + " --changed zoom -o " + rig.path("x.json"))
                .exit_code,
            2);
}

}  // namespace
}  // namespace procam::test
