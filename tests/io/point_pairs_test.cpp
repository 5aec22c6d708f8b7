#include "procam/io/session/point_pairs_file.hpp"

#include <gtest/gtest.h>

#include <random>
#include "session/point_pairs_text.hpp"

namespace procam::io {
namespace {

const std::string kPairsText =
    "# the lab\n"
    "x, y, z, u, v, name\r\n"
    "0.5, -1.25e-1, 1.204, 312.5, 88.0, shelf left\r\n"
    "\n"
    "1.35;0.02;2.417;901;140  # no name\n"
    "-3\t0\t2\t-4.5\t1080\tbelow the picture";

TEST(PointPairs, AreReadWithEverySeparator) {
  const std::vector<PointPair> pairs = parse_point_pairs(kPairsText, "lab.csv");
  ASSERT_EQ(pairs.size(), 3u);
  EXPECT_EQ(pairs[0].point_in_world, Vec3(0.5, -0.125, 1.204));
  EXPECT_EQ(pairs[0].pixel, Vec2(312.5, 88));
  EXPECT_EQ(pairs[0].name, "shelf left");
  EXPECT_EQ(pairs[1].point_in_world, Vec3(1.35, 0.02, 2.417));
  EXPECT_EQ(pairs[1].name, "");
  EXPECT_EQ(pairs[2].pixel, Vec2(-4.5, 1080));
}

TEST(PointPairs, AreReadAsSpreadsheetsWriteThem) {
  const std::vector<PointPair> pairs = parse_point_pairs(
      "\xef\xbb\xbf"
      "x;y;z;u;v;name\r\n0,5;-0,125;1,204;312,5;88,0;\"shelf; left\"\r\n1,2;3;4;5;6;12\" tube\r\n",
      "lab.csv");
  ASSERT_EQ(pairs.size(), 2u);
  EXPECT_EQ(pairs[0].point_in_world, Vec3(0.5, -0.125, 1.204));
  EXPECT_EQ(pairs[0].pixel, Vec2(312.5, 88));
  EXPECT_EQ(pairs[0].name, "shelf; left");
  EXPECT_EQ(pairs[1].name, "12\" tube");
}

TEST(PointPairs, NameFileLineAndColumnOfAMistake) {
  const auto error_of = [](const std::string& text) {
    try {
      parse_point_pairs(text, "lab.csv");
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kInput);
      return std::string(error.what());
    }
    return std::string("no error");
  };
  EXPECT_NE(error_of("1,2,3,4,5\n1,2,3m,4,5\n").find("lab.csv, line 2: column z is no number: '3m'"),
            std::string::npos);
  EXPECT_NE(error_of("1,2,3,4\n").find("line 1: it has 4 columns"), std::string::npos);
  EXPECT_NE(error_of("1,2,3,4,nan\n").find("column v"), std::string::npos);
  EXPECT_NE(error_of("1,2,3,4,1e999\n").find("column v"), std::string::npos);
  EXPECT_NE(error_of("# nothing\n").find("lists no point"), std::string::npos);
  EXPECT_NE(error_of("1,2,3,4,5\nx,y,z,u,v\n").find("line 2"), std::string::npos);  // names come first
}

TEST(PointPairs, SurviveDamage) {
  std::mt19937 random(4);
  for (int trial = 0; trial < 3000; ++trial) {
    std::string text = kPairsText;
    for (int hit = 0; hit < 1 + trial % 6; ++hit) text[random() % text.size()] = char(random() % 256);
    if (trial % 3 == 0) text.resize(random() % text.size());
    try {
      for (const PointPair& pair : parse_point_pairs(text, "damaged"))
        EXPECT_TRUE(pair.point_in_world.allFinite() && pair.pixel.allFinite());
    } catch (const Error&) {
    }
  }
}

}  // namespace
}  // namespace procam::io
