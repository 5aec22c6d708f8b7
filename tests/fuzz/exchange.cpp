// What other programs write: calibrations, MPCDI, meshes, arrays and images.
#include <cmath>
#include <cstring>

#include "exchange/mpcdi_xml.hpp"
#include "fuzz_target.hpp"
#include "image/exif_bytes.hpp"
#include "image/image_check.hpp"
#include "image/npy.hpp"
#include "image/pfm_bytes.hpp"
#include "io/examples.hpp"
#include "mesh/mesh_file.hpp"
#include "procam/io/exchange/calibration_file.hpp"
#include "procam/io/exchange/mpcdi.hpp"
#include "procam/io/exchange/warp_file.hpp"
#include "procam/io/image/depth_file.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/rig_file.hpp"
#include "targets.hpp"

namespace procam::fuzz {
namespace {

void check_mesh_file(const std::string& name, std::string_view bytes) {
  const Mesh mesh = io::load_mesh(store(name, bytes));
  const auto fault = fault_of(mesh);
  check(!fault, "a mesh was accepted: " + fault.value_or(""));
  check(mesh.triangles.size() <= bytes.size(), "there are more triangles than bytes");
}

/// The bytes with every chunk's checksum made right: a changed byte then reaches what is behind the check.
std::string with_png_checksums(std::string_view bytes) {
  std::string png(bytes);
  const auto big_endian = [&](std::size_t at) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i) value = value << 8 | std::uint8_t(png[at + i]);
    return std::size_t(value);
  };
  for (std::size_t at = 8; at + 12 <= png.size();) {
    const std::size_t length = big_endian(at);
    if (length > png.size() - at - 12) break;
    const std::uint32_t sum = io::crc32(std::string_view(png).substr(at + 4, length + 4));
    for (std::size_t i = 0; i < 4; ++i) png[at + 8 + length + i] = char(sum >> (24 - 8 * i) & 0xff);
    at += length + 12;
  }
  return png;
}

}  // namespace

void calibration(std::string_view bytes) {
  io::CalibrationContext context;
  context.camera_size = ImageSize{1280, 960};
  context.projector_size = ImageSize{1024, 768};
  const Rig rig = io::load_calibration(store("calibration.yml", bytes), context);
  check(!rig.cameras.empty() || !rig.projectors.empty(), "a rig without devices");
  const std::filesystem::path file = folder() / "calibrated.json";
  must("writing the rig", [&] { io::save_rig(file, rig); });
  must("reading the rig", [&] { return io::load_rig(file); });
}

/// An archive, or its XML alone.
void mpcdi(std::string_view bytes) {
  const bool is_archive = bytes.substr(0, 2) == "PK";
  const io::Mpcdi read =
      io::load_mpcdi(store(is_archive ? "x.mpcdi" : "x.mpcdi.xml", bytes), std::size_t(1) << 24);
  for (const io::MpcdiRegion& region : read.regions) {
    check(region.size.width > 0 && region.size.height > 0, "a region without a size");
    try {
      check(io::projector_of(region).size() == region.size, "a projector of another size");
      check(io::world_from_projector(region).translation.allFinite(), "a pose that is not finite");
    } catch (const Error&) {
      continue;
    }
  }
  if (is_archive) return;
  const io::MpcdiDocument document = io::parse_mpcdi_xml(bytes, "x.mpcdi.xml");
  check(document.files.size() == document.mpcdi.regions.size(), "regions and their files differ in number");
}

void mesh_obj(std::string_view bytes) {
  check_mesh_file("mesh.obj", bytes);
  io::load_warp_mesh(folder() / "mesh.obj", {1024, 768});
}

void mesh_ply(std::string_view bytes) {
  check_mesh_file("mesh.ply", bytes);
}

void pfm(std::string_view bytes) {
  const ImageF image = io::decode_pfm(bytes, "x.pfm");
  check(std::size_t(image.width()) * std::size_t(image.height()) <= bytes.size(), "more pixels than bytes");
  const std::string written = io::encode_pfm(image.view());
  const ImageF again = must("reading what was written", [&] { return io::decode_pfm(written, "y.pfm"); });
  check_same(written, io::encode_pfm(again.view()), "a map");
  const WarpMap map = io::load_warp_map(store("map.pfm", bytes));
  for (int y = 0; y < map.content.height(); ++y)
    for (int x = 0; x < map.content.width(); ++x)
      check(std::isfinite(map.content.at(x, y, 0)) && std::isfinite(map.content.at(x, y, 1)),
            "a warp map was accepted with coordinates that are not finite");
}

void npy(std::string_view bytes) {
  const io::NpyArray array = io::parse_npy(bytes, "x.npy");
  std::size_t count = 1;
  for (const std::size_t side : array.shape) count *= side;
  check(count == array.values.size(), "shape and values differ");
  check(array.values.size() <= bytes.size(), "there are more values than bytes");
  if (array.shape.empty()) return;
  const std::string written = io::format_npy(array);
  const io::NpyArray again =
      must("reading what was written", [&] { return io::parse_npy(written, "y.npy"); });
  check_same(written, io::format_npy(again), "an array");
}

/// Pictures and depth images. What OpenCV decodes is bounded here, since the decoders are not instrumented.
void image(std::string_view bytes) {
  constexpr long long kDecoded = 1 << 16;  // pixels
  const std::string checked =
      bytes.substr(0, 4) == "\x89PNG" ? with_png_checksums(bytes) : std::string(bytes);
  const io::ImageCheck header = io::check_image(checked);
  if (const auto focal = io::exif_focal_in(checked))
    check(focal->focal_px > 0 && focal->focal_px < 1e12, "a focal length that is none");
  if (!header.damage.empty()) return;
  if (header.width < 1 || header.width > kDecoded || header.height < 1 ||
      header.width * header.height > kDecoded)
    return;
  const std::filesystem::path file = store("image.png", checked);
  try {
    const io::LoadedImage loaded = io::load_image(file);
    check(loaded.image.width() == header.width && loaded.image.height() == header.height,
          "a picture of another size than its header's");
  } catch (const Error&) {
    io::load_depth_pixels(file);
  }
}

}  // namespace procam::fuzz
