// Warp meshes <-> Wavefront OBJ.
#include "document/number.hpp"
#include "extension.hpp"
#include "mesh/mesh_reader.hpp"
#include "procam/io/exchange/warp_file.hpp"
#include "procam/io/files.hpp"

namespace procam::io {
namespace {

void require_obj(const std::filesystem::path& path) {
  if (lower_extension(path) != ".obj")
    throw Error(ErrorKind::kUnsupported, path.string(), "warp meshes are OBJ files",
                "give it a name that ends in .obj");
}

}  // namespace

void save_warp_mesh(const std::filesystem::path& path, const WarpMesh& mesh) {
  require_obj(path);
  require(mesh.projector.width > 0 && mesh.projector.height > 0 && mesh.content.size() == mesh.pixels.size(),
          "save_warp_mesh: no picture, or not one pixel a content point");
  std::string text = "# v: projector picture of " + std::to_string(mesh.projector.width) + " x " +
                     std::to_string(mesh.projector.height) +
                     " pixels as the square 0..1, y up; vt: content\n";
  for (const Vec2& pixel : mesh.pixels)
    text += "v " + format_number((pixel.x() + 0.5) / mesh.projector.width) + " " +
            format_number(1 - (pixel.y() + 0.5) / mesh.projector.height) + " 0\n";
  for (const Vec2& uv : mesh.content)
    text += "vt " + format_number(uv.x()) + " " + format_number(1 - uv.y()) + "\n";
  for (const std::array<int, 3>& triangle : mesh.triangles) {
    text += "f";
    for (const int corner : triangle) {
      const std::string number = std::to_string(corner + 1);
      text += " " + number + "/" + number;
    }
    text += "\n";
  }
  write_file_atomically(path, text);
}

WarpMesh load_warp_mesh(const std::filesystem::path& path, ImageSize projector) {
  require_obj(path);
  require(projector.width > 0 && projector.height > 0, "load_warp_mesh: the projector's picture is empty");
  const Mesh file = parse_obj(read_file(path), path.string());
  WarpMesh mesh;
  mesh.projector = projector;
  mesh.content = file.uv;
  mesh.triangles = file.triangles;
  for (const Vec3& vertex : file.vertices)
    mesh.pixels.emplace_back(vertex.x() * projector.width - 0.5, (1 - vertex.y()) * projector.height - 0.5);
  return mesh;
}

}  // namespace procam::io
