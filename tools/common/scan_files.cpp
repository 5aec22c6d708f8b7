#include "common/scan_files.hpp"

#include <filesystem>
#include <memory>

#include "procam/io/image/images.hpp"
#include "procam/io/image/pfm.hpp"
#include "procam/io/mesh/mesh_writer.hpp"
#include "procam/io/surface_file.hpp"

namespace procam::tools {
namespace {

namespace fs = std::filesystem;

/// FILE.EXT, of several scans FILE_SCAN.EXT.
std::string file_of(const std::string& path, const std::string& scan, std::size_t count) {
  if (count == 1) return path;
  const fs::path file(path);
  return (file.parent_path() / (file.stem().string() + "_" + scan + file.extension().string())).string();
}

void append(const PointCloud& more, PointCloud& all) {
  all.points.insert(all.points.end(), more.points.begin(), more.points.end());
  all.normals.insert(all.normals.end(), more.normals.begin(), more.normals.end());
  all.sigma.insert(all.sigma.end(), more.sigma.begin(), more.sigma.end());
}

}  // namespace

std::string scan_name(const std::string& camera, const std::string& projector, std::size_t count) {
  std::string name = "scan";
  if (count > 1)
    for (const std::string& device : {camera, projector}) name += device.empty() ? "" : "_" + device;
  return name;
}

void save_scan_meshes(const std::string& output, const std::vector<NamedMesh>& meshes,
                      const std::string& frame, std::vector<std::string>& files) {
  SurfaceSet set;
  for (const NamedMesh& named : meshes) {
    MeshSurface geometry;
    geometry.frame = frame;
    geometry.file = fs::path(output).stem().string() + "_" + named.name + ".ply";
    geometry.mesh = std::make_shared<const Mesh>(*named.mesh);
    const fs::path path = fs::path(output).parent_path() / geometry.file;
    io::save_mesh(path, *named.mesh);
    files.push_back(path.string());
    Surface definition;
    definition.name = named.name;
    definition.geometry = geometry;
    set.surfaces.push_back(definition);
  }
  io::save_surfaces(output, set);
  files.push_back(output);
}

void save_scan_files(const ScanFiles& wanted, const std::vector<report::ScannedSurface>& surfaces,
                     std::vector<std::string>& files) {
  if (!wanted.points.empty()) {
    PointCloud all;
    for (const report::ScannedSurface& surface : surfaces) append(scan::point_cloud(surface.scan), all);
    io::save_points(wanted.points, all);
    files.push_back(wanted.points);
  }
  for (const report::ScannedSurface& surface : surfaces) {
    if (!wanted.depth.empty()) {
      files.push_back(file_of(wanted.depth, surface.name, surfaces.size()));
      io::save_pfm(files.back(), surface.scan.depth);
    }
    if (!wanted.preview.empty()) {
      files.push_back(file_of(wanted.preview, surface.name, surfaces.size()));
      io::save_image(files.back(), report::scan_picture(surface.scan));
    }
  }
}

}  // namespace procam::tools
