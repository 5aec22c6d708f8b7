#include <gtest/gtest.h>

#include "examples.hpp"
#include "procam/io/marker_map_file.hpp"
#include "scratch.hpp"

namespace procam::io {
namespace {

using test::Scratch;

std::string refusal(const std::string& text) {
  try {
    parse_marker(text);
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kInput) << text;
    return error.what();
  }
  return "taken";
}

TEST(MarkerMapFile, ReadsBackWhatWasWritten) {
  const Scratch scratch;
  for (const bool exact : {false, true}) {
    MarkerMap map = test::example_markers();
    if (exact) map.position_sigma = map.angle_sigma = 0;
    save_marker_map(scratch / "markers.json", map);
    const MarkerMap read = load_marker_map(scratch / "markers.json");
    EXPECT_EQ(read.dictionary, map.dictionary);
    EXPECT_EQ(read.position_sigma, map.position_sigma);
    EXPECT_EQ(read.angle_sigma, map.angle_sigma);
    ASSERT_EQ(read.markers.size(), 2u);
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_EQ(read.markers[i].id, map.markers[i].id);
      EXPECT_EQ(read.markers[i].size, map.markers[i].size);
      EXPECT_EQ(read.markers[i].world_from_marker.matrix(), map.markers[i].world_from_marker.matrix());
    }
  }
}

TEST(MarkerMapFile, RefusesWhatNoWallHolds) {
  const Scratch scratch;
  const std::string pose =
      R"("world_from_marker": {"translation": [0, 0, 0], "rotation_xyzw": [0, 0, 0, 1]})";
  const auto why = [&](const std::string& dictionary, const std::string& more, const std::string& markers) {
    scratch.write("m.json", R"({"format": "procam-markers", "version": 1, "dictionary": ")" + dictionary +
                                "\", " + more + "\"markers\": [" + markers + "]}");
    try {
      load_marker_map(scratch / "m.json");
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string("taken");
  };
  const std::string one = R"({"id": 3, "size": 0.16, )" + pose + "}";
  EXPECT_EQ(why("4x4_50", "", one), "taken");
  EXPECT_NE(why("4x4_50", "", "").find("at least one"), std::string::npos);
  EXPECT_NE(why("4x4_51", "", one).find("4x4_50"), std::string::npos);
  EXPECT_NE(why("4x4_50", "\"position_sigma\": -1, ", one).find("negative"), std::string::npos);
  EXPECT_NE(why("4x4_50", "", one + ", " + one).find("twice"), std::string::npos);
  EXPECT_NE(why("4x4_50", "", R"({"id": 50, "size": 0.16, )" + pose + "}").find("no marker 50"),
            std::string::npos);
  EXPECT_NE(why("4x4_50", "", R"({"id": 5, "size": 0, )" + pose + "}").find("positive"), std::string::npos);
}

TEST(ParseMarker, ReadsDictionaryIdAndSize) {
  const MarkerMap map = parse_marker("apriltag_36h11:3:160mm");
  EXPECT_EQ(map.dictionary, MarkerDictionary::kAprilTag36h11);
  ASSERT_EQ(map.markers.size(), 1u);
  EXPECT_EQ(map.markers[0].id, 3);
  EXPECT_EQ(map.markers[0].size, 0.16);
  EXPECT_EQ(map.markers[0].world_from_marker.matrix(), Mat4::Identity());
}

TEST(ParseMarker, SaysWhatIsWrong) {
  EXPECT_NE(refusal("apriltag_36h11:3").find("three parts"), std::string::npos);
  EXPECT_NE(refusal("april:3:160mm").find("apriltag_36h11"), std::string::npos);
  EXPECT_NE(refusal("4x4_50:x:160mm").find("no number"), std::string::npos);
  EXPECT_NE(refusal("4x4_50:50:160mm").find("0 to 49"), std::string::npos);
  EXPECT_NE(refusal("4x4_50:3:160").find("unit"), std::string::npos);
  EXPECT_NE(refusal("4x4_50:3:0mm").find("not positive"), std::string::npos);
}

}  // namespace
}  // namespace procam::io
