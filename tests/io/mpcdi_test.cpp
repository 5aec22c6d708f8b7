#include "procam/io/exchange/mpcdi.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "hand_made_zip.hpp"
#include "image/pfm_bytes.hpp"
#include "procam/io/files.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/image/pfm.hpp"
#include "scratch.hpp"
#include "support/lopsided.hpp"
#include "support/test_data.hpp"

namespace procam::io {
namespace {

using test::hand_made_zip;
using test::Scratch;
using test::ZipMember;

/// Unequal focal lengths, the whole picture above the optical axis, off to one side.
Projector beamer(double skew = 0, Distortion distortion = NoDistortion{}) {
  return {Camera{{96, 64}, {176.3, 171.1, 46.6, 71.3, skew}, distortion}};
}
Projector skewed_beamer() {
  return beamer(0.7, BrownConrady{{-0.2, 0.03, 0.0011, -0.0007, 0}});
}

/// u and v run differently, and one pixel shows nothing.
WarpMap lopsided_warp(ImageSize size) {
  WarpMap map{ImageF(size, 3, 0.0f)};
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      if (x == 3 && y == 1) continue;
      map.content.at(x, y, 0) = float((x + 0.3 * y) / (size.width + size.height));
      map.content.at(x, y, 1) = float(0.9 - 0.8 * y / size.height);
      map.content.at(x, y, 2) = 1;
    }
  return map;
}

void expect_same(const WarpMap& a, const WarpMap& b) {
  ASSERT_EQ(a.size(), b.size());
  for (int y = 0; y < a.content.height(); ++y)
    for (int x = 0; x < a.content.width(); ++x) {
      EXPECT_EQ(a.shows(x, y), b.shows(x, y));
      EXPECT_LT((a.at(x, y) - b.at(x, y)).norm(), 1e-7);  // 1 - (1 - v) in floats
    }
}

Mpcdi flat_mpcdi() {
  Mpcdi mpcdi;
  mpcdi.date = "2026-11-22 08:00:00";
  for (const char* id : {"beamer & <one>", "../two"}) {
    MpcdiRegion region;
    region.buffer = region.id = id;
    region.size = {id[0] == '.' ? 9 : 7, 5};
    region.warp = lopsided_warp(region.size);
    region.alpha = ImageF(region.size, 1, 1.0f);
    region.alpha->at(2, 3) = 51.0f / 255;
    region.alpha_gamma = 2.2;
    mpcdi.regions.push_back(region);
  }
  return mpcdi;
}

Mpcdi lamp_mpcdi(const Projector& projector, const Pose& world_from_projector) {
  Mpcdi mpcdi;
  mpcdi.profile = MpcdiProfile::kShaderLamps;
  MpcdiRegion region;
  region.buffer = region.id = "lamp";
  mpcdi.diagnostics = set_projector(region, projector, world_from_projector);
  region.positions = ImageF(region.size, 3, 1.5f);
  region.positions->at(4, 2, 1) = std::nanf("");
  mpcdi.regions.push_back(region);
  return mpcdi;
}

/// Archives need libzip; these tests have nothing to ask of a build without it.
bool archives_are_read() {
  const Scratch scratch;
  try {
    save_mpcdi(scratch / "x.mpcdi", flat_mpcdi());
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kUnsupported);
    EXPECT_TRUE(test::contains(error.what(), "install libzip-dev")) << error.what();
    return false;
  }
  return true;
}
#define PROCAM_REQUIRE_ARCHIVES() \
  if (!archives_are_read()) GTEST_SKIP() << "procam was built without libzip"

Mpcdi written_and_read(const Mpcdi& mpcdi) {
  const Scratch scratch;
  save_mpcdi(scratch / "x.mpcdi", mpcdi);
  return load_mpcdi(scratch / "x.mpcdi");
}

TEST(Mpcdi, FlatProfileReadsBackWhatItWrote) {
  PROCAM_REQUIRE_ARCHIVES();
  const Mpcdi written = flat_mpcdi(), read = written_and_read(written);
  EXPECT_EQ(read.profile, MpcdiProfile::k2d);
  EXPECT_EQ(read.date, "2026-11-22 08:00:00");
  ASSERT_EQ(read.regions.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    const MpcdiRegion &before = written.regions[i], &after = read.regions[i];
    EXPECT_EQ(after.id, before.id);
    EXPECT_EQ(after.buffer, before.buffer);
    EXPECT_EQ(after.size, before.size);
    EXPECT_EQ(after.width, 1);
    ASSERT_TRUE(after.warp && after.alpha);
    expect_same(*after.warp, *before.warp);
    EXPECT_FLOAT_EQ(after.alpha->at(2, 3), 0.2f);
    EXPECT_EQ(after.alpha->at(3, 3), 1);
    EXPECT_EQ(after.alpha_gamma, 2.2);
    EXPECT_FALSE(after.positions || after.distortion || after.frustum);
  }
}

TEST(Mpcdi, TheSameDataGiveTheSameBytes) {
  PROCAM_REQUIRE_ARCHIVES();
  const Scratch scratch;
  save_mpcdi(scratch / "a.mpcdi", flat_mpcdi());
  save_mpcdi(scratch / "b.mpcdi", flat_mpcdi());
  EXPECT_EQ(read_file(scratch / "a.mpcdi"), read_file(scratch / "b.mpcdi"));
}

TEST(Mpcdi, ShaderLampIsTheSameLightWhereTheLensHasShiftAlone) {
  PROCAM_REQUIRE_ARCHIVES();
  for (const Pose& pose : {test::lopsided_pose(), test::other_lopsided_pose()}) {
    const Mpcdi written = lamp_mpcdi(beamer(), pose);
    EXPECT_TRUE(written.diagnostics.items.empty());
    const Mpcdi read = written_and_read(written);
    const MpcdiRegion& region = read.regions.at(0);
    const Projector lamp = projector_of(region);
    const Pose world_from_lamp = world_from_projector(region);
    EXPECT_EQ(lamp.size(), beamer().size());
    std::mt19937_64 random(5);
    for (int i = 0; i < 200; ++i) {
      const Vec2 pixel(test::uniform(random, -0.5, 95.5), test::uniform(random, -0.5, 63.5));
      const Vec3 point_in_world = pose * Vec3(3 * beamer().emit(pixel)->direction);
      EXPECT_LT((*lamp.project(world_from_lamp.inverse() * point_in_world) - pixel).norm(), 1e-6);
    }
    for (int y = 0; y < 64; ++y)  // and then the distortion map is none
      for (int x = 0; x < 96; ++x)
        EXPECT_LT((region.distortion->at(x, y) - Vec2((x + 0.5) / 96, (y + 0.5) / 64)).norm(), 2e-7);
  }
}

TEST(Mpcdi, DistortionMapCarriesSkewAndLensAndTheFrustumSaysSo) {
  PROCAM_REQUIRE_ARCHIVES();
  const Mpcdi written = lamp_mpcdi(skewed_beamer(), test::lopsided_pose());
  const Diagnostic* const warning = written.diagnostics.find("frustum_is_not_lens");
  ASSERT_TRUE(warning);
  EXPECT_TRUE(test::contains(warning->message, "'lamp'"));
  const Mpcdi read = written_and_read(written);
  const MpcdiRegion& region = read.regions.at(0);
  const Projector frustum = projector_of(region);
  double largest_without = 0;
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 96; ++x) {
      ASSERT_TRUE(region.distortion->shows(x, y)) << "the frustum holds all of the light";
      const Vec2 uv = region.distortion->at(x, y);  // in the picture that is drawn with the frustum
      const Vec3 drawn = frustum.emit(Vec2(uv.x() * 96 - 0.5, uv.y() * 64 - 0.5))->direction;
      const Vec3 lit = skewed_beamer().emit(Vec2(x, y))->direction;
      const Vec2 pixel = *frustum.project(lit);
      EXPECT_LT((*frustum.project(drawn) - pixel).norm(), 2e-5);  // the rounding of a float
      largest_without = std::max(largest_without, (pixel - Vec2(x, y)).norm());
    }
  EXPECT_GT(largest_without, 0.5);
}

TEST(Mpcdi, PositionsComeBackInMetresAndNanStaysNan) {
  PROCAM_REQUIRE_ARCHIVES();
  Mpcdi written = lamp_mpcdi(beamer(), Pose());
  const Mpcdi lamp = written_and_read(written);
  EXPECT_EQ(lamp.regions[0].positions->at(5, 2, 1), 1.5f);
  for (int c = 0; c < 3; ++c) EXPECT_TRUE(std::isnan(lamp.regions[0].positions->at(4, 2, c)));
  written.profile = MpcdiProfile::kAdvanced3d;
  const Mpcdi advanced = written_and_read(written);
  EXPECT_EQ(advanced.profile, MpcdiProfile::kAdvanced3d);
  EXPECT_EQ(advanced.regions[0].positions->at(5, 2, 0), 1.5f);
}

// As the readers in the field do it: SGCT's mpcdi.cpp turns by -yaw, pitch, -roll about y, x, z of OpenGL's
// axes, and PyMPCDI's MpacsWarpSL.py gives the four tangents to glFrustum.
TEST(Mpcdi, FrustumIsWhatOtherReadersMakeOfIt) {
  MpcdiRegion region;
  region.size = {1400, 1050};
  region.frustum = MpcdiFrustum{-54.649, 30.0864, -35.2582, -26.5795, 21.3, -20.5434, 24.1};
  region.frame = MpcdiFrame{};
  region.frame->position = Vec3(0.3, -0.2, 0.9);
  const Eigen::Matrix3d world_from_eye = (Eigen::AngleAxisd(54.649 * kDegree, Vec3::UnitY()) *
                                          Eigen::AngleAxisd(30.0864 * kDegree, Vec3::UnitX()) *
                                          Eigen::AngleAxisd(35.2582 * kDegree, Vec3::UnitZ()))
                                             .toRotationMatrix();
  const double l = std::tan(-26.5795 * kDegree), r = std::tan(21.3 * kDegree);
  const double b = std::tan(-20.5434 * kDegree), t = std::tan(24.1 * kDegree);
  const Pose projector_from_world = world_from_projector(region).inverse();
  std::mt19937_64 random(3);
  for (int i = 0; i < 50; ++i) {
    const Vec3 in_eye(test::uniform(random, -0.3, 0.3), test::uniform(random, -0.3, 0.3), -1);
    const double x = (-in_eye.x() / in_eye.z() - l) / (r - l), y = (-in_eye.y() / in_eye.z() - b) / (t - b);
    const Vec2 pixel(x * 1400 - 0.5, (1 - y) * 1050 - 0.5);
    const Vec3 point_in_world = world_from_eye * Vec3(2.5 * in_eye) + region.frame->position;
    EXPECT_LT((*projector_of(region).project(projector_from_world * point_in_world) - pixel).norm(), 1e-9);
  }
}

TEST(Mpcdi, AnglesSurviveStraightUpAndDown) {
  for (const double pitch : {90.0, -90.0, 89.999999}) {
    const Pose pose(
        Mat3((Eigen::AngleAxisd(0.7, Vec3::UnitY()) * Eigen::AngleAxisd(pitch * kDegree, Vec3::UnitX()))
                 .toRotationMatrix()),
        Vec3(1, 2, 3));
    MpcdiRegion region;
    set_projector(region, beamer(), pose);
    const Pose back = world_from_projector(region);
    EXPECT_LT((back.matrix() - pose.matrix()).norm(), 1e-9) << pitch;
  }
}

// The room of a file from the field: six projectors around the origin, each looking at its middle axis.
TEST(Mpcdi, CubeMappingSampleLoads) {
  PROCAM_REQUIRE_TEST_DATA("mpcdi/Cube-mapping.mpcdi.xml");
  const Mpcdi cube = load_mpcdi(test::test_data() / "mpcdi/Cube-mapping.mpcdi.xml");
  EXPECT_EQ(cube.profile, MpcdiProfile::k3d);
  ASSERT_EQ(cube.regions.size(), 6u);
  EXPECT_EQ(cube.diagnostics.items.size(), 6u);  // they have no warps
  EXPECT_EQ(cube.regions[1].id, "Front");
  for (const MpcdiRegion& region : cube.regions) {
    EXPECT_EQ(region.size, (ImageSize{1920, 1080}));
    const Projector projector = projector_of(region);
    EXPECT_NEAR(projector.throw_ratio(), 1 / (2 * 0.4), 1e-6);  // tan 21.801409 deg = 0.4
    EXPECT_NEAR(projector.lens_shift().norm(), 0, 1e-12);
    const Pose pose = world_from_projector(region);
    const bool vertical = region.id == "Top" || region.id == "Bottom";
    const Vec3 target(0, vertical ? 0 : 0.5, 0);
    const Vec3 seen = pose.inverse() * target;
    EXPECT_NEAR(seen.z(), 3, 1e-6) << region.id;
    EXPECT_LT(seen.head<2>().norm(), 1e-6) << region.id;
    if (!vertical)
      EXPECT_LT((pose.rotate(-Vec3::UnitY()) - Vec3::UnitY()).norm(), 1e-9) << region.id << " is upright";
  }
}

std::string xml_of(const std::string& region, const std::string& files = "",
                   const std::string& profile = "2d") {
  return "<?xml version=\"1.0\"?>\n<MPCDI profile=\"" + profile +
         "\" version=\"2.0\"><display><buffer id=\"b\">" + region + "</buffer></display>" + files +
         "</MPCDI>";
}
const char* const kRegion =
    "<region id=\"r\" Xresolution=\"2\" Yresolution=\"2\" x=\"0\" y=\"0\" xsize=\"1\" ysize=\"1\"/>";
const char* const kFiles =
    "<files><fileset region=\"r\"><geometryWarpFile><path>w.pfm</path></geometryWarpFile></fileset></files>";

/// 2 x 2 pixels, their numbers from the top row.
std::string warp_pfm(std::vector<float> numbers) {
  ImageF map(2, 2, 3);
  std::copy(numbers.begin(), numbers.end(), map.data());
  return encode_pfm(map);
}
const std::vector<float> kWarp{0.1f, 0.9f, 0, 0.6f, 0.9f, 0, 0.1f, 0.2f, 0, std::nanf(""), std::nanf(""), 0};

TEST(Mpcdi, ContentRunsUpwardsFromTheBottomLeftCorner) {
  PROCAM_REQUIRE_ARCHIVES();
  const Scratch scratch;
  const auto path = scratch.write(
      "x.mpcdi", hand_made_zip({{"mpcdi.xml", xml_of(kRegion, kFiles)}, {"w.pfm", warp_pfm(kWarp)}}));
  const WarpMap warp = *load_mpcdi(path).regions[0].warp;
  EXPECT_LT((warp.at(0, 0) - Vec2(0.1, 0.1)).norm(), 1e-7);  // the top row shows the content's top
  EXPECT_LT((warp.at(0, 1) - Vec2(0.1, 0.8)).norm(), 1e-7);
  EXPECT_FALSE(warp.shows(1, 1));
}

TEST(Mpcdi, TakesTheSpellingsOfTheField) {
  PROCAM_REQUIRE_ARCHIVES();
  const Scratch scratch;
  const std::string region =
      "<Region ID='r' xResolution='2' yresolution='2' X='0.0' y='0.0' xSize='1.0' YSIZE='1.00001'><fileSet>"
      "<GeometryWarpFile><Path> maps/W.pfm </Path><GeometricUnit>CM</GeometricUnit></GeometryWarpFile>"
      "</fileSet></Region>";
  const auto path = scratch.write(
      "x.mpcdi", hand_made_zip({{"MPCDI.XML", xml_of(region, "", "A3")}, {"maps/w.PFM", warp_pfm(kWarp)}}));
  const Mpcdi read = load_mpcdi(path);
  EXPECT_EQ(read.profile, MpcdiProfile::kAdvanced3d);
  EXPECT_FLOAT_EQ(read.regions[0].positions->at(1, 0, 0), 0.006f);
  const std::string no_size = "<region id='r' x='0' y='0' xsize='1' ysize='1'/>";
  const std::string in_buffer =
      "<?xml version='1.0'?><mpcdi profile='sl'><display><buffer id='b' Xresolution='640' "
      "Yresolution='480'>" +
      no_size + "</buffer></display></mpcdi>";
  EXPECT_EQ(load_mpcdi(scratch.write("y.mpcdi.xml", in_buffer)).regions[0].size, (ImageSize{640, 480}));
}

TEST(Mpcdi, RefusesDescriptionsThatAreNoneWithTheirLine) {
  const Scratch scratch;
  const auto refuse = [&](const std::string& xml, const char* why) {
    EXPECT_ERROR(load_mpcdi(scratch.write("x.mpcdi.xml", xml)), kInput, why);
  };
  const auto region = [](const std::string& attributes) {
    return xml_of("<region id=\"r\" " + attributes + "/>");
  };
  const std::string size = "Xresolution=\"2\" Yresolution=\"2\" ";
  refuse("", "not valid XML");
  refuse("<MPCDI profile=\"2d\">", "x.mpcdi.xml:1: it is not valid XML");
  refuse("<html/>", "not MPCDI");
  refuse(xml_of(kRegion, "", "4d"), "its profile is '4d'");
  refuse("<MPCDI profile=\"2d\"/>", "no display");
  refuse(xml_of(""), "no regions");
  refuse(xml_of(std::string(kRegion) + kRegion), "two regions have the id 'r'");
  refuse(region(size + "x=\"0\" y=\"0\" xsize=\"1\""), "x.mpcdi.xml:2: it has no ysize");
  refuse(region(size + "x=\"0\" y=\"0.5\" xsize=\"1\" ysize=\"0.6\""), "within 0..1");
  refuse(region(size + "x=\"-0.1\" y=\"0\" xsize=\"1\" ysize=\"1\""), "within 0..1");
  refuse(region(size + "x=\"0\" y=\"0\" xsize=\"0\" ysize=\"1\""), "within 0..1");
  refuse(region(size + "x=\"nan\" y=\"0\" xsize=\"1\" ysize=\"1\""), "its x is 'nan'");
  for (const char* side : {"0", "-5", "1.5", "16385", "1e9"})
    refuse(region("Xresolution=\"" + std::string(side) +
                  "\" Yresolution=\"2\" x=\"0\" y=\"0\" xsize=\"1\" ysize=\"1\""),
           "1 to 16384 pixels");
  refuse(xml_of(kRegion, kFiles), "an XML file has none inside");
  refuse(xml_of(kRegion, "<files><fileset region=\"q\"/></files>"), "no region of that id");
  const auto frustum = [](const std::string& left, const std::string& right) {
    return xml_of(
        "<region id=\"r\" Xresolution=\"2\" Yresolution=\"2\" x=\"0\" y=\"0\" xsize=\"1\" "
        "ysize=\"1\"><frustum>"
        "<yaw>0</yaw><pitch>0</pitch><roll>0</roll><rightAngle>" +
        right + "</rightAngle><leftAngle>" + left +
        "</leftAngle><upAngle>5</upAngle><downAngle>-5</downAngle></frustum></region>");
  };
  refuse(frustum("10", "-10"), "frustum is empty");
  refuse(frustum("-90", "10"), "frustum is empty or opens by 90");
  refuse(frustum("-10", "inf"), "its rightangle is 'inf'");
}

TEST(Mpcdi, RefusesFramesThatAreNotRightHandedAxes) {
  MpcdiRegion region;
  EXPECT_ERROR(projector_of(region), kInput, "no frustum");
  EXPECT_ERROR(world_from_projector(region), kInput, "no frustum");
  region.frustum = MpcdiFrustum{0, 0, 0, -10, 10, -10, 10};
  region.frame = MpcdiFrame{};
  region.frame->roll = Vec3::UnitZ();  // y up, z forward: Unity's
  EXPECT_ERROR(world_from_projector(region), kUnsupported, "left-handed");
  region.frame->roll = Vec3(0, 0.1, -1);
  EXPECT_ERROR(world_from_projector(region), kInput, "square to each other");
}

TEST(Mpcdi, RefusesMapsThatAreNone) {
  PROCAM_REQUIRE_ARCHIVES();
  const Scratch scratch;
  const auto refuse = [&](const std::string& map, const char* why, const std::string& profile = "2d") {
    const auto path = scratch.write(
        "x.mpcdi", hand_made_zip({{"mpcdi.xml", xml_of(kRegion, kFiles, profile)}, {"w.pfm", map}}));
    EXPECT_ERROR(load_mpcdi(path), kInput, why);
  };
  refuse(encode_pfm(ImageF(3, 2, 3)), "3 x 2 pixels");
  refuse(encode_pfm(ImageF(2, 2, 1)), "1 channels");
  refuse(warp_pfm(kWarp).substr(0, 50), "w.pfm: its header claims");
  refuse("PF\n40000 40000\n-1\n", "its header claims");
  const float nan = std::nanf("");
  refuse(warp_pfm(std::vector<float>(12, nan)), "none of its numbers is finite");
  refuse(warp_pfm(std::vector<float>(12, nan)), "none of its numbers is finite", "a3");
  std::vector<float> outside = kWarp;
  outside[4] = 1.1f;
  refuse(warp_pfm(outside), "at pixel 1, 0 it leads outside the content");
  outside[4] = 1e30f;
  refuse(warp_pfm(outside), "at pixel 1, 0 it lies a thousand kilometres away", "sl");
}

TEST(Mpcdi, RefusesAlphaMapsOfAnotherSizeOrNone) {
  PROCAM_REQUIRE_ARCHIVES();
  const Scratch scratch;
  const std::string files =
      "<files><fileset region=\"r\"><alphaMap><path>a.png</path><gammaEmbedded>@</gammaEmbedded></alphaMap>"
      "</fileset></files>";
  const auto write = [&](const std::string& gamma, const std::string& alpha) {
    std::string filled = files;
    filled.replace(filled.find('@'), 1, gamma);
    return scratch.write("x.mpcdi",
                         hand_made_zip({{"mpcdi.xml", xml_of(kRegion, filled)}, {"a.png", alpha}}));
  };
  EXPECT_NO_THROW(load_mpcdi(write("2.2", encode_png(ImageU8(2, 2)))));
  EXPECT_ERROR(load_mpcdi(write("2.2", encode_png(ImageU8(3, 2)))), kInput, "3 x 2 pixels");
  EXPECT_ERROR(load_mpcdi(write("2.2", encode_png(ImageU8(2, 2)).substr(0, 40))), kInput, "cut short");
  EXPECT_ERROR(load_mpcdi(write("2.2", "GIF89a")), kUnsupported, "a.png: it is not a PNG");
  EXPECT_ERROR(load_mpcdi(write("0", encode_png(ImageU8(2, 2)))), kInput, "its gamma is 0");
}

TEST(MpcdiArchive, RefusesMembersThatLeadOutside) {
  PROCAM_REQUIRE_ARCHIVES();
  const Scratch scratch;
  const ZipMember xml{"mpcdi.xml", xml_of(kRegion, kFiles)}, warp{"w.pfm", warp_pfm(kWarp)};
  EXPECT_NO_THROW(load_mpcdi(scratch.write("x.mpcdi", hand_made_zip({xml, warp, {"a..b/..c", "fine"}}))));
  for (const char* name : {"../evil", "a/../../evil", "/etc/evil", "..", "c:evil", "a\\..\\evil"}) {
    EXPECT_ERROR(load_mpcdi(scratch.write("x.mpcdi", hand_made_zip({xml, warp, {name, "x"}}))), kInput,
                 "leads out of the archive");
    std::string files = kFiles;
    files.replace(files.find("w.pfm"), 5, name);
    EXPECT_ERROR(
        load_mpcdi(scratch.write("x.mpcdi", hand_made_zip({{"mpcdi.xml", xml_of(kRegion, files)}, warp}))),
        kInput, "does not lie in the archive");
  }
}

TEST(MpcdiArchive, RefusesBombsBeforeAndWhileUnpacking) {
  PROCAM_REQUIRE_ARCHIVES();
  const Scratch scratch;
  const ZipMember xml{"mpcdi.xml", xml_of(kRegion, kFiles)};
  // Four gigabytes, and several of half a gigabyte, by what they declare.
  const ZipMember giant{"w.pfm", "x", 0xfffffff0u, 0, 8}, large{"a", "x", 0x20000000u, 0, 8};
  ZipMember second = large, third = large;
  second.name = "b";
  third.name = "c";
  EXPECT_ERROR(load_mpcdi(scratch.write("x.mpcdi", hand_made_zip({xml, giant}))), kInput,
               "unpacks to more than");
  EXPECT_ERROR(load_mpcdi(scratch.write("x.mpcdi", hand_made_zip({xml, large, second, third}))), kInput,
               "unpacks to more than");
  // A hundred thousand zeros, deflated to 114 bytes, that declare themselves as ten.
  std::string deflated("\xed\xc1\x31\x01\0\0\0\xc2\xa0\xf5\x4f\x6d\x0d\x0f\xa0", 16);
  deflated.append(95, '\0');
  deflated += "\x80\x57\x03";
  const ZipMember valid{"w.pfm", deflated, 100000, 0xd411957d, 8},
      lying{"w.pfm", deflated, 10, 0xd411957d, 8};
  EXPECT_ERROR(load_mpcdi(scratch.write("x.mpcdi", hand_made_zip({xml, valid}))), kInput, "it is not a PFM");
  EXPECT_ERROR(load_mpcdi(scratch.write("x.mpcdi", hand_made_zip({xml, lying}))), kInput,
               "unpacks to more than the 10 bytes it declares");
  const auto whole = scratch.write("x.mpcdi", hand_made_zip({xml, {"w.pfm", warp_pfm(kWarp)}}));
  EXPECT_NO_THROW(load_mpcdi(whole, 2000));
  EXPECT_ERROR(load_mpcdi(whole, 300), kInput, "larger than the 300 bytes");
  // One small member that a thousand regions would each unpack for themselves.
  std::string regions, files;
  for (int i = 0; i < 1000; ++i) {
    const std::string id = std::to_string(i);
    regions += "<region id=\"" + id +
               "\" Xresolution=\"400\" Yresolution=\"400\" x=\"0\" y=\"0\" xsize=\"1\" ysize=\"1\"/>";
    files +=
        "<fileset region=\"" + id + "\"><geometryWarpFile><path>w.pfm</path></geometryWarpFile></fileset>";
  }
  const ZipMember shared{"mpcdi.xml", xml_of(regions, "<files>" + files + "</files>")};
  EXPECT_ERROR(load_mpcdi(scratch.write("x.mpcdi",
                                        hand_made_zip({shared, {"w.pfm", encode_pfm(ImageF(400, 400, 3))}}))),
               kInput, "maps would take more");
}

TEST(MpcdiArchive, RefusesMissingFilesAndDamage) {
  PROCAM_REQUIRE_ARCHIVES();
  const Scratch scratch;
  const ZipMember xml{"mpcdi.xml", xml_of(kRegion, kFiles)}, warp{"w.pfm", warp_pfm(kWarp)};
  EXPECT_ERROR(load_mpcdi(scratch.write("x.mpcdi", hand_made_zip({xml}))), kInput,
               "w.pfm: the archive has no such member");
  EXPECT_ERROR(load_mpcdi(scratch.write("x.mpcdi", hand_made_zip({warp}))), kInput, "no mpcdi.xml");
  EXPECT_ERROR(load_mpcdi(scratch.write("x.mpcdi", hand_made_zip({{"a.xml", ""}, {"b.xml", ""}}))), kInput,
               "no mpcdi.xml");
  EXPECT_NO_THROW(load_mpcdi(scratch.write("x.mpcdi", hand_made_zip({{"a.xml", xml.bytes}, warp}))));
  ZipMember damaged = warp;
  damaged.checksum = 1;
  EXPECT_ERROR(load_mpcdi(scratch.write("x.mpcdi", hand_made_zip({xml, damaged}))), kInput,
               "w.pfm: it cannot be unpacked");
  const std::string whole = hand_made_zip({xml, warp});
  for (std::size_t length = 2; length < whole.size(); length += 7) {
    const auto path = scratch.write("x.mpcdi", whole.substr(0, length));
    EXPECT_ERROR(load_mpcdi(path), kInput, "not a whole zip archive");
  }
  EXPECT_ERROR(load_mpcdi(scratch / "absent.mpcdi"), kIo, "No such file");
}

TEST(Mpcdi, WritesOnlyWhatIsComplete) {
  const Scratch scratch;
  Mpcdi mpcdi = flat_mpcdi();
  EXPECT_ERROR(save_mpcdi(scratch / "x.zip", mpcdi), kUnsupported, "ends in .mpcdi");
  mpcdi.profile = MpcdiProfile::k3d;
  EXPECT_ERROR(save_mpcdi(scratch / "x.mpcdi", mpcdi), kUnsupported, "profile 3d");
  for (const MpcdiProfile profile : {MpcdiProfile::kShaderLamps, MpcdiProfile::kAdvanced3d}) {
    mpcdi.profile = profile;
    EXPECT_THROW(save_mpcdi(scratch / "x.mpcdi", mpcdi), std::invalid_argument);
  }
  mpcdi.profile = MpcdiProfile::k2d;
  mpcdi.regions[0].alpha = ImageF(3, 3);
  EXPECT_THROW(save_mpcdi(scratch / "x.mpcdi", mpcdi), std::invalid_argument);
  EXPECT_THROW(save_mpcdi(scratch / "x.mpcdi", Mpcdi{}), std::invalid_argument);
}

}  // namespace
}  // namespace procam::io
