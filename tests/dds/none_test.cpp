#include <gtest/gtest.h>

#include "log_files.hpp"
#include "procam/dds/fleet.hpp"
#include "procam/dds/group.hpp"
#include "procam/dds/image_source.hpp"
#include "procam/dds/pose_source.hpp"
#include "procam/dds/security.hpp"
#include "support/expect_error.hpp"
#include "support/udp.hpp"

namespace procam::dds {
namespace {

TEST(NoDds, NamesThePackages) {
  EXPECT_FALSE(is_available());
  EXPECT_ERROR(open_pose_source("ros2:map,base_link"), kUnsupported,
               "install cyclonedds-dev and cyclonedds-tools");
}

TEST(NoDds, ImagesNameThePackages) {
  EXPECT_ERROR(ImageSource("/image"), kUnsupported, "install cyclonedds-dev and cyclonedds-tools");
  EXPECT_ERROR(DepthImageSource("/depth"), kUnsupported, "install cyclonedds-dev and cyclonedds-tools");
  EXPECT_ERROR(ImageSource("/a,/b"), kInput, "one topic");
}

TEST(NoDds, SecurityNamesThePackages) {
  EXPECT_ERROR(use_security("enclave"), kUnsupported, "install cyclonedds-dev and cyclonedds-tools");
  EXPECT_NO_THROW(use_security({}));
}

TEST(NoDds, AGroupNamesThePackages) {
  EXPECT_ERROR(Group({"stage"}), kUnsupported, "install cyclonedds-dev and cyclonedds-tools");
  EXPECT_ERROR(Group({"a/b"}), kInput, "group 'a/b'");
}

TEST(NoDds, AFleetNamesThePackages) {
  EXPECT_ERROR(RobotFleet({"hall", "spot"}), kUnsupported, "install cyclonedds-dev and cyclonedds-tools");
  EXPECT_ERROR(RobotFleet({"hall", "a/b"}), kInput, "robot 'a/b'");
}

TEST(NoDds, LogsOfRos2NameThePackages) {
  const std::filesystem::path log = test::log_folder() / "run.mcap";
  test::write_file(log, test::McapFile().closed());
  EXPECT_ERROR(open_pose_source("log:" + log.string()), kUnsupported,
               "install cyclonedds-dev and cyclonedds-tools");
  EXPECT_ERROR(ImageSource("log:" + log.string()), kUnsupported,
               "install cyclonedds-dev and cyclonedds-tools");
}

TEST(NoDds, OpensAllOtherSources) {
  EXPECT_NE(open_pose_source("udp:127.0.0.1:" + test::free_udp_port()), nullptr);
}

}  // namespace
}  // namespace procam::dds
