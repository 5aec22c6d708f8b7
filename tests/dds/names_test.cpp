#include "names.hpp"

#include <gtest/gtest.h>

#include <cstdlib>

#include "procam/dds/pose_source.hpp"
#include "support/expect_error.hpp"
#include "support/udp.hpp"

namespace procam::dds::internal {
namespace {

TEST(GraphNames, RelativeNamesGetTheNamespaceAndRemapsCompareFullNames) {
  GraphNames names;
  names.node_namespace = "/robot1";
  names.remaps = {{"/tf", "tf"}, {"odom", "/wheels/odom"}};
  EXPECT_EQ(names.resolve("/tf"), "/robot1/tf");
  EXPECT_EQ(names.resolve("odom"), "/wheels/odom");
  EXPECT_EQ(names.resolve("/robot1/odom"), "/wheels/odom");
  EXPECT_EQ(names.resolve("/odom"), "/odom");
  EXPECT_EQ(names.resolve("/tf_static"), "/tf_static");
  EXPECT_EQ(dds_topic("/robot1/tf"), "rt/robot1/tf");
}

TEST(Ros2Source, ReadsFramesTopicsRemapsAndNamespace) {
  const Ros2Source usual = parse_ros2_source("");
  EXPECT_EQ(usual.frame + " " + usual.child + " " + usual.tf, "map base_link /tf");
  const Ros2Source nav = parse_ros2_source("world,base,__ns:=/robot1,/tf:=tf,/tf_static:=tf_static");
  EXPECT_EQ(nav.frame + " " + nav.child, "world base");
  EXPECT_EQ(nav.tf + " " + nav.tf_static, "/robot1/tf /robot1/tf_static");
  EXPECT_EQ(parse_ros2_source("/odom").topic, "/odom");
  EXPECT_EQ(parse_ros2_source("/odom,/odom:=/wheels/odom").topic, "/wheels/odom");
  EXPECT_EQ(parse_ros2_source("/map,/base").frame, "map");  // as old nodes wrote frames
}

TEST(Ros2Source, RefusesWhatIsNone) {
  for (const char* text : {"map", "a,b,c", "map,", ",base", "map,map", "/odom/", "/od om", "/1st", "//odom",
                           "/a//b", "/odom,/odom:=", "/odom,:=/b", "__ns:=a b,map,base", "/"})
    EXPECT_ERROR(parse_ros2_source(text), kInput, "ros2:");
}

/// A mistyped remap would leave the source at the name from before, unseen.
TEST(Ros2Source, RefusesARemapOfANameThatIsNotRead) {
  EXPECT_ERROR(parse_ros2_source("map,base,/ft:=/robot1/tf"), kInput, "remap one of: /tf, /tf_static");
  EXPECT_ERROR(parse_ros2_source("/odom,/odm:=/wheels/odom"), kInput, "remap one of: /odom");
  EXPECT_ERROR(parse_ros2_source("map,base,/clock:=/sim/clock"), kInput, "changes no name that is read");
  EXPECT_EQ(parse_ros2_source("map,base,/clock:=/sim/clock,use_sim_time:=true").clock, "/sim/clock");
  EXPECT_EQ(parse_ros2_topic("/eye/image,/eye/camera_info:=/lens", "camera").info, "/lens");
  EXPECT_ERROR(parse_ros2_topic("/eye/image,/camera_info:=/lens", "camera"), kInput,
               "remap one of: /eye/image, /eye/camera_info");
}

TEST(Ros2Source, OtherTextsAreOpenedAsBefore) {
  EXPECT_NE(open_pose_source("udp:127.0.0.1:" + test::free_udp_port()), nullptr);
  EXPECT_ERROR(open_pose_source("laser:1"), kInput, "ros2:[FRAME,CHILD | /TOPIC]");
  EXPECT_ERROR(track::open_pose_source("ros2:map,base"), kUnsupported, "dds::open_pose_source()");
}

TEST(Domain, IsThatOfTheEnvironment) {
  const char* before = std::getenv("ROS_DOMAIN_ID");
  const std::string kept = before != nullptr ? before : "";
  ::setenv("ROS_DOMAIN_ID", "", 1);
  EXPECT_EQ(domain_of_environment(), 0);
  ::setenv("ROS_DOMAIN_ID", "42", 1);
  EXPECT_EQ(domain_of_environment(), 42);
  for (const char* text : {"233", "-1", "1x", " 1", "99999999999999999999"}) {
    ::setenv("ROS_DOMAIN_ID", text, 1);
    EXPECT_ERROR(domain_of_environment(), kInput, "0 to 232");
  }
  before != nullptr ? ::setenv("ROS_DOMAIN_ID", kept.c_str(), 1) : ::unsetenv("ROS_DOMAIN_ID");
}

}  // namespace
}  // namespace procam::dds::internal
