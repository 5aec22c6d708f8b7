#include "procam/io/mesh/mesh_writer.hpp"

#include <cstdint>
#include <cstring>

#include "procam/core/base/error.hpp"
#include "procam/core/base/words.hpp"
#include "procam/io/files.hpp"

namespace procam::io {
namespace {

/// Little-endian bytes, as all machines that procam runs on have them.
template <typename T>
void append(std::string& bytes, T value) {
  char raw[sizeof value];
  std::memcpy(raw, &value, sizeof value);
  bytes.append(raw, sizeof value);
}

void append(std::string& bytes, const Vec3& v) {
  for (int i = 0; i < 3; ++i) append(bytes, float(v[i]));
}

[[noreturn]] void refuse_extension(const std::filesystem::path& path, const std::string& known) {
  throw Error(ErrorKind::kUnsupported, path.string(),
              "'" + path.extension().string() + "' is not written here", "give a name that ends in " + known);
}

std::string mesh_ply(const Mesh& mesh) {
  std::string bytes =
      "ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(mesh.vertices.size()) +
      "\nproperty float x\nproperty float y\nproperty float z\nproperty float s\nproperty float t\n"
      "element face " +
      std::to_string(mesh.triangles.size()) + "\nproperty list uchar int vertex_indices\nend_header\n";
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    append(bytes, mesh.vertices[i]);
    append(bytes, float(mesh.uv[i].x()));
    append(bytes, float(1 - mesh.uv[i].y()));
  }
  for (const auto& triangle : mesh.triangles) {
    append(bytes, std::uint8_t(3));
    for (const int corner : triangle) append(bytes, std::int32_t(corner));
  }
  return bytes;
}

std::string mesh_obj(const Mesh& mesh) {
  std::string text;
  for (const Vec3& v : mesh.vertices) text += format("v %.7g %.7g %.7g\n", v.x(), v.y(), v.z());
  for (const Vec2& uv : mesh.uv) text += format("vt %.7g %.7g\n", uv.x(), 1 - uv.y());
  for (const auto& t : mesh.triangles)
    text += format("f %d/%d %d/%d %d/%d\n", t[0] + 1, t[0] + 1, t[1] + 1, t[1] + 1, t[2] + 1, t[2] + 1);
  return text;
}

void append_points(std::string& bytes, const PointCloud& cloud) {
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    append(bytes, cloud.points[i]);
    if (!cloud.normals.empty()) append(bytes, cloud.normals[i]);
    if (!cloud.sigma.empty()) append(bytes, float(cloud.sigma[i]));
  }
}

std::string cloud_ply(const PointCloud& cloud) {
  std::string bytes = "ply\nformat binary_little_endian 1.0\nelement vertex " +
                      std::to_string(cloud.points.size()) +
                      "\nproperty float x\nproperty float y\nproperty float z\n";
  if (!cloud.normals.empty()) bytes += "property float nx\nproperty float ny\nproperty float nz\n";
  if (!cloud.sigma.empty()) bytes += "property float sigma\n";
  bytes += "end_header\n";
  append_points(bytes, cloud);
  return bytes;
}

std::string cloud_pcd(const PointCloud& cloud) {
  std::string fields = "x y z", ones = "1 1 1";
  if (!cloud.normals.empty()) fields += " normal_x normal_y normal_z", ones += " 1 1 1";
  if (!cloud.sigma.empty()) fields += " sigma", ones += " 1";
  const auto repeated = [&](char symbol) {
    std::string line;
    for (const char c : ones) line += c == '1' ? symbol : c;
    return line;
  };
  const std::string count = std::to_string(cloud.points.size());
  std::string bytes = "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS " + fields +
                      "\nSIZE " + repeated('4') + "\nTYPE " + repeated('F') + "\nCOUNT " + ones + "\nWIDTH " +
                      count + "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + count + "\nDATA binary\n";
  append_points(bytes, cloud);
  return bytes;
}

}  // namespace

void save_mesh(const std::filesystem::path& path, const Mesh& mesh) {
  const std::string extension = path.extension().string();
  if (extension != ".ply" && extension != ".obj") refuse_extension(path, ".ply or .obj");
  if (const auto fault = fault_of(mesh)) throw std::invalid_argument("save_mesh: " + *fault);
  write_file_atomically(path, extension == ".ply" ? mesh_ply(mesh) : mesh_obj(mesh));
}

void save_points(const std::filesystem::path& path, const PointCloud& cloud) {
  const std::string extension = path.extension().string();
  if (extension != ".ply" && extension != ".pcd") refuse_extension(path, ".ply or .pcd");
  require((cloud.normals.empty() || cloud.normals.size() == cloud.points.size()) &&
              (cloud.sigma.empty() || cloud.sigma.size() == cloud.points.size()),
          "save_points: lists of different lengths");
  write_file_atomically(path, extension == ".ply" ? cloud_ply(cloud) : cloud_pcd(cloud));
}

}  // namespace procam::io
