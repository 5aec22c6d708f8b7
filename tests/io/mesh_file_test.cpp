/// Meshes as programs write them, and as nobody should.
#include "mesh/mesh_file.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "scratch.hpp"
#include "support/test_data.hpp"

namespace procam::io {
namespace {

using test::Scratch;

const char* const kRoofObj =
    "# a roof\r\n"
    "mtllib roof.mtl\r\n"
    "v 0 0 0.2\r\n"
    "v 0.7 0.03 0 1.0\r\n"
    "v 0.8 1 0.05\n"
    "v\t0.1 9e-1 0.2  # the last\n"
    "vt 0 1\nvt 0.4 1 0\nvt 0.4 0\nvt 0 0\n"
    "vn 0 0 -1\n"
    "s off\n"
    "f 1/1/1 2/2/1 3/3/1 4/4/1\n"
    "f -4/-4 -3/1 -2/-2\n";

TEST(MeshFile, ReadsObjAsProgramsWriteIt) {
  const Scratch scratch;
  const Mesh mesh = load_mesh(scratch.write("roof.obj", kRoofObj));
  ASSERT_EQ(mesh.triangles.size(), 3u);
  ASSERT_EQ(mesh.vertices.size(), 5u) << "four corners, and one of them with another texture coordinate";
  EXPECT_EQ(mesh.vertices[1], Vec3(0.7, 0.03, 0));
  EXPECT_EQ(mesh.uv[0], Vec2(0, 0)) << "t counts from the bottom";
  EXPECT_EQ(mesh.uv[2], Vec2(0.4, 1));
  EXPECT_EQ(mesh.triangles[1], (std::array<int, 3>{0, 2, 3})) << "a fan";
  EXPECT_EQ(mesh.vertices[4], mesh.vertices[1]);
  EXPECT_EQ(mesh.uv[4], mesh.uv[0]);
}

std::string bytes_of(const void* value, std::size_t size, bool swapped) {
  std::string bytes(static_cast<const char*>(value), size);
  return swapped ? std::string(bytes.rbegin(), bytes.rend()) : bytes;
}

/// The quad of the roof, vertices with a colour in between and faces with a number before the list.
std::string ply(const std::string& coding) {
  std::string text =
      "ply\nformat " + coding +
      " 1.0\ncomment of a roof\nelement vertex 4\nproperty float x\nproperty double y\n"
      "property float z\nproperty uchar red\nproperty float s\nproperty float t\n"
      "element face 1\nproperty short group\nproperty list uchar int vertex_indices\nend_header\n";
  const double rows[4][6] = {{0, 0, 0.25, 200, 0, 1},
                             {0.75, 0.03, 0, 7, 0.5, 1},
                             {0.5, 1, 0.125, 0, 0.5, 0},
                             {0.125, 0.9, 0.25, 1, 0, 0}};
  const bool swapped = coding == "binary_big_endian";
  for (const auto& row : rows)
    for (int i = 0; i < 6; ++i) {
      if (coding == "ascii") {
        text += std::to_string(row[i]) + (i == 5 ? "\n" : " ");
      } else if (i == 1) {
        text += bytes_of(&row[i], 8, swapped);
      } else if (i == 3) {
        text += char(static_cast<unsigned char>(row[i]));
      } else {
        const float value = float(row[i]);
        text += bytes_of(&value, 4, swapped);
      }
    }
  if (coding == "ascii") return text + "-3 4 0 1 2 3\n";
  const std::int16_t group = -3;
  text += bytes_of(&group, 2, swapped) + char(4);
  for (const std::int32_t corner : {0, 1, 2, 3}) text += bytes_of(&corner, 4, swapped);
  return text;
}

TEST(MeshFile, ReadsPlyInAllThreeCodings) {
  const Scratch scratch;
  for (const char* coding : {"ascii", "binary_little_endian", "binary_big_endian"}) {
    const Mesh mesh = load_mesh(scratch.write("roof.ply", ply(coding)));
    ASSERT_EQ(mesh.vertices.size(), 4u) << coding;
    ASSERT_EQ(mesh.triangles.size(), 2u) << coding;
    EXPECT_EQ(mesh.vertices[1], Vec3(0.75, 0.03, 0)) << coding;
    EXPECT_EQ(mesh.uv[2], Vec2(0.5, 1)) << coding;
    EXPECT_EQ(mesh.triangles[1], (std::array<int, 3>{0, 2, 3})) << coding;
  }
}

TEST(MeshFile, RefusesWithPlaceAndReason) {
  const Scratch scratch;
  const auto obj = [&](const std::string& text) { return load_mesh(scratch.write("m.obj", text)); };
  EXPECT_ERROR(obj(""), kInput, "m.obj: it has no face");
  EXPECT_ERROR(obj("v 1 2\n"), kInput, "m.obj:1: a position needs three numbers");
  EXPECT_ERROR(obj("v 1 2 nan\n"), kInput, "m.obj:1: a position needs three numbers, and 'nan' is none");
  EXPECT_ERROR(obj("v 1 2 1e999\n"), kInput, "m.obj:1");
  const std::string corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n";
  EXPECT_ERROR(obj(corners + "f 1 2 3\n"), kInput, "m.obj:7: the face has no texture coordinates");
  EXPECT_ERROR(obj(corners + "f 1//1 2//1 3//1\n"), kInput, "no texture coordinates");
  EXPECT_ERROR(obj(corners + "f 1/1 2/2 4/3\n"), kInput, "m.obj:7: there is no position '4' before it");
  EXPECT_ERROR(obj(corners + "f 1/1 2/2 0/3\n"), kInput, "there is no position '0'");
  EXPECT_ERROR(obj(corners + "f 1/1 2/2 -4/3\n"), kInput, "there is no position '-4'");
  EXPECT_ERROR(obj(corners + "f 1/1 2/2 99999999999999999999/3\n"), kInput, "there is no position");
  EXPECT_ERROR(obj(corners + "f 1/1 2/2 -9223372036854775808/3\n"), kInput, "there is no position");
  EXPECT_ERROR(obj(corners + "f 1/1 2/2\n"), kInput, "a face needs three corners");
  EXPECT_ERROR(obj(corners + "f 1/1 2/2 2/3\n"), kInput, "triangle 0 has no area");
  const auto ply_text = [&](const std::string& text) { return load_mesh(scratch.write("m.ply", text)); };
  EXPECT_ERROR(ply_text("plx\n"), kInput, "m.ply:1: it does not begin with 'ply'");
  EXPECT_ERROR(ply_text("ply\nformat ascii 1.0\n"), kInput, "it ends within its header");
  EXPECT_ERROR(ply_text("ply\nformat ascii 1.0\nelement vertex 10000000000\n"), kInput,
               "it claims 10000000000 elements, and the file has");
  EXPECT_ERROR(ply_text("ply\nformat ascii 1.0\nelement vertex -1\n"), kInput,
               "'-1' is no number of elements");
  EXPECT_ERROR(ply_text("ply\nformat ascii 1.0\nelement vertex 1\nproperty quad x\n"), kInput,
               "no type 'quad'");
  EXPECT_ERROR(
      ply_text(
          "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
          "end_header\n0 0 0\n"),
      kInput, "no texture coordinates");
  const std::string whole = ply("binary_little_endian");
  EXPECT_ERROR(ply_text(whole.substr(0, whole.size() - 3)), kInput, "m.ply, face 0: the file ends");
  std::string endless = whole;
  endless[whole.size() - 17] = char(0xfa);  // a face of 250 corners
  EXPECT_ERROR(ply_text(endless), kInput, "a list claims 250 entries, more than the file holds");
  std::string nan = whole;
  const float not_a_number = std::numeric_limits<float>::quiet_NaN();
  std::memcpy(nan.data() + nan.find("end_header\n") + 11, &not_a_number, 4);
  EXPECT_ERROR(ply_text(nan), kInput, "m.ply, vertex 0: a number is not finite");
  EXPECT_ERROR(
      ply_text("ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nelement cell 9\nend_header\n0\n"),
      kInput, "the element 'cell' has no property");
  const std::string faces =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 1\nproperty list uchar int vertex_index\n"
      "element face 1\nproperty list uchar int vertex_index\nproperty list uchar float texcoord\nend_header\n"
      "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n3 0 1 2 6 0 0 1 0 0 1\n";
  EXPECT_ERROR(ply_text(faces), kInput, "some of its faces have a texcoord and others have none");
  EXPECT_ERROR(load_mesh(scratch.write("m.stl", "solid")), kUnsupported, "'.stl' is no mesh format");
  EXPECT_ERROR(load_mesh(scratch / "none.obj"), kIo, "none.obj");
}

TEST(MeshFile, SurvivesDamage) {
  const Scratch scratch;
  std::mt19937 random(11);
  int loaded = 0;
  for (const std::string& whole : {std::string(kRoofObj), ply("ascii"), ply("binary_little_endian")})
    for (int trial = 0; trial < 300; ++trial) {
      std::string damaged = whole;
      for (int change = 0; change < 1 + trial % 5; ++change)
        damaged[random() % damaged.size()] = char(random());
      if (trial % 7 == 0) damaged.resize(random() % damaged.size());
      try {
        const Mesh mesh = load_mesh(scratch.write(whole == kRoofObj ? "d.obj" : "d.ply", damaged));
        EXPECT_EQ(fault_of(mesh), std::nullopt);
        ++loaded;
      } catch (const Error&) {
      }
    }
  EXPECT_GT(loaded, 20) << "a changed digit leaves a mesh";
}

TEST(MeshFile, SaysOfTheCornellBoxThatItHasNoTextureCoordinates) {
  PROCAM_REQUIRE_TEST_DATA("mesh/cornell_box.obj");
  EXPECT_ERROR(load_mesh(test::test_data() / "mesh/cornell_box.obj"), kInput,
               "the face has no texture coordinates, so content has no place on it");
}

/// MeshLab's "wedge" coordinates: a list of s, t for every corner of every face, here as its ASCII export.
TEST(MeshFile, ReadsTextureCoordinatesOfPlyFaces) {
  const Scratch scratch;
  const std::string head =
      "ply\nformat ascii 1.0\ncomment VCGLIB generated\nelement vertex 4\nproperty float x\n"
      "property float y\nproperty float z\nelement face 2\nproperty list uchar int vertex_indices\n"
      "property list uchar float texcoord\nproperty int texnumber\nend_header\n"
      "0 0 0\n2 0 0\n2 1 0\n0 1 0.5\n";
  const Mesh mesh = load_mesh(
      scratch.write("m.ply", head + "3 0 1 2 6 0 0 0.5 0 0.5 1 0\n3 0 2 3 6 0 0 0.75 1 0.25 0.875 0\n"));
  ASSERT_EQ(mesh.triangles.size(), 2u);
  // Vertex 0 has one place in both faces, vertex 2 two: a seam.
  EXPECT_EQ(mesh.vertices.size(), 5u);
  const auto corner = [&](int triangle, int k) {
    return std::size_t(mesh.triangles[std::size_t(triangle)][std::size_t(k)]);
  };
  EXPECT_EQ(corner(0, 0), corner(1, 0));
  EXPECT_EQ(mesh.vertices[corner(0, 2)], mesh.vertices[corner(1, 1)]);
  EXPECT_EQ(mesh.uv[corner(0, 2)], Vec2(0.5, 0));
  EXPECT_EQ(mesh.uv[corner(1, 1)], Vec2(0.75, 0));
  EXPECT_EQ(mesh.vertices[corner(1, 2)], Vec3(0, 1, 0.5));
  EXPECT_EQ(mesh.uv[corner(1, 2)], Vec2(0.25, 0.125));
  EXPECT_ERROR(load_mesh(scratch.write("m.ply", head + "3 0 1 2 4 0 0 0.5 0 0\n3 0 2 3 0 0\n")), kInput,
               "face 0: it has 4 texture coordinates for 3 corners");
}

}  // namespace
}  // namespace procam::io
