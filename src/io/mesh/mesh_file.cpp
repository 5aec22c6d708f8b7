#include "mesh/mesh_file.hpp"

#include "mesh/mesh_reader.hpp"
#include "procam/io/files.hpp"

namespace procam::io {

Mesh load_mesh(const std::filesystem::path& path) {
  const std::string extension = path.extension().string();
  if (extension != ".obj" && extension != ".ply")
    throw Error(ErrorKind::kUnsupported, path.string(),
                "'" + extension + "' is no mesh format that is known here",
                "export the mesh as .obj or .ply");
  const std::string bytes = read_file(path);
  Mesh mesh = extension == ".obj" ? parse_obj(bytes, path.string()) : parse_ply(bytes, path.string());
  if (const auto fault = fault_of(mesh)) refuse_mesh(path.string(), *fault);
  return mesh;
}

}  // namespace procam::io
