#include "procam/io/exchange/warp_file.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <opencv2/imgcodecs.hpp>

#include "procam/io/files.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/image/pfm.hpp"
#include "scratch.hpp"

namespace procam::io {
namespace {

using test::Scratch;

/// u and v run differently, and two pixels show nothing.
WarpMap lopsided_map() {
  WarpMap map{ImageF(7, 5, 3, 0.0f)};
  for (int y = 0; y < 5; ++y)
    for (int x = 0; x < 7; ++x) {
      if ((x == 3 && y == 1) || (x == 6 && y == 4)) continue;
      map.content.at(x, y, 0) = float(0.03 + 0.13 * x + 0.01 * y);
      map.content.at(x, y, 1) = float(0.9 - 0.19 * y + 0.011 * x);
      map.content.at(x, y, 2) = 1;
    }
  return map;
}

void expect_near(const WarpMap& a, const WarpMap& b, double tolerance) {
  ASSERT_EQ(a.size(), b.size());
  for (int y = 0; y < 5; ++y)
    for (int x = 0; x < 7; ++x) {
      EXPECT_EQ(a.shows(x, y), b.shows(x, y));
      EXPECT_LE((a.at(x, y) - b.at(x, y)).cwiseAbs().maxCoeff(), tolerance) << x << " " << y;
    }
}

TEST(WarpFile, ReadsBackWhatItWrote) {
  const Scratch scratch;
  save_warp_map(scratch / "x.PFM", lopsided_map());
  expect_near(load_warp_map(scratch / "x.PFM"), lopsided_map(), 0);
  save_warp_map(scratch / "x.png", lopsided_map());
  expect_near(load_warp_map(scratch / "x.png"), lopsided_map(), 1.0 / 131070 + 1e-7);
}

TEST(WarpFile, StMapHasSInRedAndTUpwardsInGreen) {
  const Scratch scratch;
  save_warp_map(scratch / "x.png", lopsided_map());
  const cv::Mat pixels = cv::imread((scratch / "x.png").string(), cv::IMREAD_UNCHANGED);
  ASSERT_EQ(pixels.type(), CV_16UC3);
  const auto bgr = pixels.at<cv::Vec3w>(0, 2);  // row 0: the picture's top
  const Vec2 uv = lopsided_map().at(2, 0);
  EXPECT_EQ(bgr[2], std::lround(65535 * uv.x()));
  EXPECT_EQ(bgr[1], std::lround(65535 * (1 - uv.y())));
  EXPECT_EQ(bgr[0], 65535);
  EXPECT_EQ(pixels.at<cv::Vec3w>(1, 3), cv::Vec3w(0, 0, 0));
}

TEST(WarpFile, ExrIsReadByOpenExr) {
  ::setenv("OPENCV_IO_ENABLE_OPENEXR", "1", 1);
  const Scratch scratch;
  save_warp_map(scratch / "x.exr", lopsided_map());
  const cv::Mat pixels = cv::imread((scratch / "x.exr").string(), cv::IMREAD_UNCHANGED);
  ASSERT_EQ(pixels.type(), CV_32FC3);
  ASSERT_EQ(pixels.size(), cv::Size(7, 5));
  for (int y = 0; y < 5; ++y)
    for (int x = 0; x < 7; ++x) {
      const auto bgr = pixels.at<cv::Vec3f>(y, x);
      const bool shows = lopsided_map().shows(x, y);
      const Vec2 uv = lopsided_map().at(x, y);
      EXPECT_EQ(bgr[2], float(uv.x()));
      EXPECT_EQ(bgr[1], shows ? 1 - float(uv.y()) : 0);
      EXPECT_EQ(bgr[0], shows ? 1 : 0);
    }
}

TEST(WarpFile, RefusesMapsThatAreNone) {
  const Scratch scratch;
  const auto refuse = [&](int channel, float value, const char* why) {
    WarpMap map = lopsided_map();
    map.content.at(4, 2, channel) = value;
    save_pfm(scratch / "x.pfm", map.content);
    EXPECT_ERROR(load_warp_map(scratch / "x.pfm"), kInput, why);
  };
  refuse(0, std::nanf(""), "at pixel 4, 2");
  refuse(1, 1.01f, "at pixel 4, 2");
  refuse(1, -0.01f, "at pixel 4, 2");
  refuse(2, std::nanf(""), "at pixel 4, 2");
  refuse(2, 2, "at pixel 4, 2");
  save_pfm(scratch / "x.pfm", ImageF(4, 3));
  EXPECT_ERROR(load_warp_map(scratch / "x.pfm"), kInput, "one channel");
  save_image(scratch / "x.png", ImageU8(4, 3, 3));
  EXPECT_ERROR(load_warp_map(scratch / "x.png"), kUnsupported, "3 channels of 16 bits");
  EXPECT_ERROR(load_warp_map(scratch / "x.exr"), kUnsupported, "read from PFM");
  EXPECT_ERROR(save_warp_map(scratch / "x.jpg", lopsided_map()), kUnsupported, "PFM, PNG or EXR");
  EXPECT_THROW(save_warp_map(scratch / "x.pfm", WarpMap{}), std::invalid_argument);
}

WarpMesh lopsided_warp_mesh() {
  WarpMesh mesh;
  mesh.projector = {1024, 768};
  mesh.content = {{0, 0}, {0.5, 0}, {0, 1}, {0.5, 1}, {1, 1.0 / 3}};
  mesh.pixels = {{100.25, 90.125}, {420.1, -3.7}, {88.8, 700.01}, {470, 810.5}, {1023.5, 767.5}};
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {1, 3, 4}};
  return mesh;
}

TEST(WarpMeshFile, ReadsBackWhatItWrote) {
  const Scratch scratch;
  save_warp_mesh(scratch / "x.obj", lopsided_warp_mesh());
  const WarpMesh read = load_warp_mesh(scratch / "x.obj", {1024, 768});
  ASSERT_EQ(read.triangles.size(), 3u);
  for (std::size_t t = 0; t < 3; ++t)
    for (std::size_t c = 0; c < 3; ++c) {  // points are numbered as the faces come to them
      const auto before = std::size_t(lopsided_warp_mesh().triangles[t][c]),
                 after = std::size_t(read.triangles[t][c]);
      EXPECT_LT((read.pixels[after] - lopsided_warp_mesh().pixels[before]).norm(), 1e-9);
      EXPECT_LT((read.content[after] - lopsided_warp_mesh().content[before]).norm(), 1e-15);
    }
}

TEST(WarpMeshFile, CornersOfThePictureAreCornersOfTheSquare) {
  const Scratch scratch;
  WarpMesh mesh = lopsided_warp_mesh();
  mesh.pixels[0] = {-0.5, -0.5};  // the picture's top-left corner, not the centre of its first pixel
  save_warp_mesh(scratch / "x.obj", mesh);
  const std::string text = read_file(scratch / "x.obj");
  EXPECT_NE(text.find("\nv 0 1 0\n"), std::string::npos) << text;
  EXPECT_NE(text.find("\nv 1 0 0\n"), std::string::npos) << text;
  EXPECT_NE(text.find("\nvt 0 1\n"), std::string::npos) << text;  // (u, v) = (0, 0)
}

TEST(WarpMeshFile, ReadsPolygonsRelativeIndicesAndNormals) {
  const Scratch scratch;
  const auto path =
      scratch.write("x.obj",
                    "# other\r\no quad\r\nv 0 0 0 1.0\r\nv 1 0 0\r\nv 1 1 0\r\nv 0 1 0\r\nvt 0 0\r\n"
                    "vt 1 0 0\r\nvt 1 1\r\nvt 0 1\r\nvn 0 0 1\r\ns off\r\nf 1/1/1 2/2/1 -2/3/1 -1/-1/1");
  const WarpMesh mesh = load_warp_mesh(path, {10, 20});
  ASSERT_EQ(mesh.triangles.size(), 2u);
  EXPECT_EQ(mesh.pixels[2], Vec2(9.5, -0.5));
  EXPECT_EQ(mesh.content[2], Vec2(1, 0));
}

TEST(WarpMeshFile, RefusesWhatIsNoMeshWithItsLine) {
  const Scratch scratch;
  const std::string points = "v 0 0 0\nv 1 0 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\n";
  const auto refuse = [&](const std::string& text, const char* why) {
    EXPECT_ERROR(load_warp_mesh(scratch.write("x.obj", text), {10, 20}), kInput, why);
  };
  refuse("", "has no face");
  refuse(points, "has no face");
  refuse("v nan 0 0\n", "x.obj:1: a position needs three numbers");
  refuse("v 1\n", "three numbers");
  refuse(points + "f 1 2 3\n", "x.obj:7: the face has no texture coordinates");
  refuse(points + "f 1//1 2//1 3//1\n", "no texture coordinates");
  refuse(points + "f 1/1 2/2 4/3\n", "no position '4'");
  refuse(points + "f 1/1 2/2 3/0\n", "no texture coordinate '0'");
  refuse(points + "f 1/1 2/2 3/-4\n", "no texture coordinate '-4'");
  refuse(points + "f 1/1 2/2 3/1e300\n", "no texture coordinate");
  refuse(points + "f 1/1 2/2 3/1.5\n", "no texture coordinate '1.5'");
  refuse(points + "f 1/1 2/2\n", "needs three corners");
  EXPECT_ERROR(load_warp_mesh(scratch.write("x.ply", points), {10, 20}), kUnsupported, "OBJ");
  EXPECT_ERROR(save_warp_mesh(scratch / "x.ply", lopsided_warp_mesh()), kUnsupported, "OBJ");
}

}  // namespace
}  // namespace procam::io
