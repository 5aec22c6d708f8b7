#include "simulated_clock.hpp"

#include <gtest/gtest.h>

#include "names.hpp"
#include "support/expect_error.hpp"

namespace procam::dds::internal {
namespace {

using Change = SimulatedClock::Change;
constexpr double kRounding = 1e-9;

TEST(SimulatedClock, StampsAreOfTheMomentAtWhichTheClockShowedThem) {
  SimulatedClock clock;
  EXPECT_FALSE(clock.local(5, 100));
  // Three times as fast as the time of here.
  for (int i = 0; i <= 20; ++i) EXPECT_EQ(clock.take(50 + 0.3 * i, 200 + 0.1 * i), Change::kAdvanced);
  EXPECT_NEAR(clock.rate(), 3, kRounding);
  EXPECT_NEAR(*clock.local(50.75, 300), 200.25, kRounding);
  EXPECT_NEAR(*clock.local(56.15, 300), 202.05, kRounding) << "after the newest: at its rate";
  EXPECT_NEAR(*clock.local(56.15, 202.01), 202.01, kRounding) << "not after it has arrived";
  EXPECT_NEAR(*clock.local(49.7, 300), 199.9, kRounding);
}

TEST(SimulatedClock, APauseEndsWhereItWas) {
  SimulatedClock clock;
  clock.take(10, 100);
  clock.take(10.1, 100.1);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(clock.take(10.1, 101 + i), Change::kStands);
  EXPECT_EQ(clock.rate(), 0);
  EXPECT_EQ(*clock.local(10.1, 200), 105) << "it is still then";
  EXPECT_NEAR(*clock.local(10.05, 200), 100.05, kRounding);
  clock.take(10.3, 105.2);
  EXPECT_NEAR(*clock.local(10.2, 200), 105.1, kRounding) << "the pause is none of its time";
  EXPECT_NEAR(clock.rate(), 1, kRounding);
}

TEST(SimulatedClock, AJumpBeginsAnew) {
  SimulatedClock clock;
  clock.take(100, 10);
  clock.take(100.1, 10.1);
  EXPECT_EQ(clock.take(3, 10.2), Change::kJumped);
  EXPECT_EQ(*clock.local(3, 50), 10.2);
  EXPECT_EQ(clock.take(30, 10.3), Change::kJumped);
  EXPECT_EQ(clock.take(30.05, 10.4), Change::kAdvanced);
  EXPECT_NEAR(clock.rate(), 0.5, 1e-6);
}

TEST(SimulatedClock, IsNamedAsInRos) {
  EXPECT_EQ(parse_ros2_source("map,base_link").clock, "");
  EXPECT_EQ(parse_ros2_source("map,base_link,use_sim_time:=true").clock, "/clock");
  EXPECT_EQ(parse_ros2_source("/odom,use_sim_time:=true,/clock:=/sim/clock").clock, "/sim/clock");
  EXPECT_EQ(parse_ros2_source("use_sim_time:=false").clock, "");
  EXPECT_ERROR(parse_ros2_source("use_sim_time:=1"), kInput, "true or false");
  EXPECT_ERROR(parse_ros2_topic("/image,use_sim_time:=true", "camera"), kInput,
               "for poses of the graph alone");
}

}  // namespace
}  // namespace procam::dds::internal
