#include "procam/io/mesh/mesh_writer.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <fstream>

#include "mesh/mesh_file.hpp"
#include "procam/io/files.hpp"

namespace procam::io {
namespace {

namespace fs = std::filesystem;

Mesh lopsided_mesh() {
  Mesh mesh;
  mesh.vertices = {Vec3(0.1, -0.25, 1.5), Vec3(0.9, -0.2, 1.75), Vec3(0.8, 0.4, 1.6), Vec3(0.05, 0.3, 1.55)};
  mesh.uv = {Vec2(0, 0), Vec2(0.9, 0.05), Vec2(1, 1), Vec2(0.1, 0.8)};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

fs::path mesh_folder() {
  const fs::path folder = fs::path(testing::TempDir()) / "procam_mesh_writer";
  fs::create_directories(folder);
  return folder;
}

TEST(MeshWriter, WhatIsWrittenIsReadAgain) {
  const Mesh mesh = lopsided_mesh();
  for (const std::string name : {"wall.ply", "wall.obj"}) {
    const fs::path path = mesh_folder() / name;
    save_mesh(path, mesh);
    const Mesh read = load_mesh(path);
    ASSERT_EQ(read.vertices.size(), mesh.vertices.size()) << name;
    ASSERT_EQ(read.triangles, mesh.triangles) << name;
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
      EXPECT_LT((read.vertices[i] - mesh.vertices[i]).norm(), 1e-6) << name;
      EXPECT_LT((read.uv[i] - mesh.uv[i]).norm(), 1e-6) << name;
    }
  }
}

TEST(MeshWriter, PointsHaveWhatThereIs) {
  PointCloud cloud;
  cloud.points = {Vec3(1, 2, 3), Vec3(-4, 5.5, 6)};
  save_points(mesh_folder() / "bare.ply", cloud);
  EXPECT_EQ(read_file(mesh_folder() / "bare.ply").find("nx"), std::string::npos);
  cloud.normals = {Vec3(0, 0, -1), Vec3(0, 1, 0)};
  cloud.sigma = {0.25, 0.5};
  save_points(mesh_folder() / "full.pcd", cloud);
  const std::string bytes = read_file(mesh_folder() / "full.pcd");
  EXPECT_NE(
      bytes.find("FIELDS x y z normal_x normal_y normal_z sigma\nSIZE 4 4 4 4 4 4 4\nTYPE F F F F F F F\n"),
      std::string::npos);
  EXPECT_NE(bytes.find("POINTS 2\nDATA binary\n"), std::string::npos);
  float last[7];
  ASSERT_GT(bytes.size(), sizeof last);
  std::memcpy(last, bytes.data() + bytes.size() - sizeof last, sizeof last);
  const float wanted[7] = {-4, 5.5f, 6, 0, 1, 0, 0.5f};
  EXPECT_EQ(std::memcmp(last, wanted, sizeof last), 0);
}

TEST(MeshWriter, RefusesWhatCannotBeWritten) {
  EXPECT_THROW(save_mesh(mesh_folder() / "wall.stl", lopsided_mesh()), Error);
  EXPECT_THROW(save_points(mesh_folder() / "wall.obj", {}), Error);
  EXPECT_THROW(save_mesh(mesh_folder() / "none" / "wall.ply", lopsided_mesh()), Error);
  Mesh broken = lopsided_mesh();
  broken.triangles[0][1] = 4;
  EXPECT_THROW(save_mesh(mesh_folder() / "broken.ply", broken), std::invalid_argument);
  EXPECT_FALSE(fs::exists(mesh_folder() / "broken.ply"));
  PointCloud cloud;
  cloud.points = {Vec3(1, 2, 3)};
  cloud.sigma = {0.1, 0.2};
  EXPECT_THROW(save_points(mesh_folder() / "points.ply", cloud), std::invalid_argument);
}

}  // namespace
}  // namespace procam::io
