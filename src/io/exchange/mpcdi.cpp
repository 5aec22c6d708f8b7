// MPCDI files as wholes: the archive's members <-> the maps of the regions.
#include "procam/io/exchange/mpcdi.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>

#include "document/document.hpp"
#include "exchange/archive.hpp"
#include "exchange/mpcdi_xml.hpp"
#include "extension.hpp"
#include "image/image_check.hpp"
#include "image/image_decode.hpp"
#include "image/pfm_bytes.hpp"
#include "procam/core/base/limits.hpp"
#include "procam/io/files.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/image/pfm.hpp"

namespace procam::io {
namespace {

const char* const kNextMap = "export it again from the program that made it";

std::string size_words(ImageSize size) {
  return std::to_string(size.width) + " x " + std::to_string(size.height);
}

ImageF read_float_map(const Archive& archive, const std::string& file, const std::string& member,
                      const MpcdiRegion& region) {
  const std::string what = file + ": " + member;
  ImageF map = decode_pfm(archive.read(member), what);
  if (map.size() != region.size || map.channels() != 3)
    throw Error(ErrorKind::kInput, what,
                "it has " + size_words(map.size()) + " pixels of " + std::to_string(map.channels()) +
                    " channels, and region '" + region.id + "' " + size_words(region.size) + " of 3",
                kNextMap);
  return map;
}

/// MPCDI's v runs upwards, and NaN shows nothing. A map that shows nothing at all, or places outside 0..1, is
/// refused: a warp of another kind would look like that.
WarpMap warp_from_file(ImageF map, const std::string& what) {
  long long shown = 0;
  for (int y = 0; y < map.height(); ++y)
    for (int x = 0; x < map.width(); ++x) {
      float& u = map.at(x, y, 0);
      float& v = map.at(x, y, 1);
      constexpr float kSlack = 1e-4f;  // the rounding of other programs
      const bool shows = std::isfinite(u) && std::isfinite(v);
      if (shows && !(u >= -kSlack && u <= 1 + kSlack && v >= -kSlack && v <= 1 + kSlack))
        throw Error(ErrorKind::kInput, what,
                    "at pixel " + std::to_string(x) + ", " + std::to_string(y) +
                        " it leads outside the content, 0..1",
                    kNextMap);
      u = shows ? std::clamp(u, 0.0f, 1.0f) : 0;
      v = shows ? 1 - std::clamp(v, 0.0f, 1.0f) : 0;
      map.at(x, y, 2) = shows ? 1 : 0;
      shown += shows;
    }
  if (shown == 0) throw Error(ErrorKind::kInput, what, "none of its numbers is finite", kNextMap);
  return {std::move(map)};
}

ImageF warp_for_file(const WarpMap& warp) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  ImageF map(warp.size(), 3, nan);
  for (int y = 0; y < map.height(); ++y)
    for (int x = 0; x < map.width(); ++x) {
      if (!warp.shows(x, y)) continue;
      map.at(x, y, 0) = warp.content.at(x, y, 0);
      map.at(x, y, 1) = 1 - warp.content.at(x, y, 1);
      map.at(x, y, 2) = 0;
    }
  return map;
}

ImageF positions_from_file(ImageF map, double metres_per_unit, const std::string& what) {
  long long shown = 0;
  for (int y = 0; y < map.height(); ++y)
    for (int x = 0; x < map.width(); ++x) {
      bool finite = true;
      for (int c = 0; c < 3; ++c) finite = finite && std::isfinite(map.at(x, y, c));
      for (int c = 0; c < 3; ++c) {
        float& metres = map.at(x, y, c);
        metres = finite ? float(metres * metres_per_unit) : std::numeric_limits<float>::quiet_NaN();
        if (std::abs(metres) > limits::kLengthM)
          throw Error(ErrorKind::kInput, what,
                      "at pixel " + std::to_string(x) + ", " + std::to_string(y) +
                          " it lies a thousand kilometres away",
                      kNextMap);
      }
      shown += finite;
    }
  if (shown == 0) throw Error(ErrorKind::kInput, what, "none of its numbers is finite", kNextMap);
  return map;
}

ImageF read_alpha(const Archive& archive, const std::string& file, const std::string& member,
                  const MpcdiRegion& region) {
  const std::string what = file + ": " + member, bytes = archive.read(member);
  const ImageCheck check = check_image(bytes);
  if (check.format != ImageFormat::kUnknown && check.damage.empty() &&
      (check.width != region.size.width || check.height != region.size.height))
    throw Error(ErrorKind::kInput, what,
                "it has " + std::to_string(check.width) + " x " + std::to_string(check.height) +
                    " pixels, and region '" + region.id + "' " + size_words(region.size),
                kNextMap);
  const cv::Mat pixels = decode_image(bytes, what);
  if (pixels.depth() != CV_8U && pixels.depth() != CV_16U)
    throw Error(ErrorKind::kUnsupported, what, "its pixels are " + cv::typeToString(pixels.type()), kNextMap);
  ImageF alpha(region.size);
  for (int y = 0; y < pixels.rows; ++y)
    for (int x = 0; x < pixels.cols; ++x) {
      const int at = x * pixels.channels();  // all channels of a grey picture are the same
      alpha.at(x, y) = pixels.depth() == CV_8U ? float(pixels.ptr<std::uint8_t>(y)[at] / 255.0)
                                               : float(pixels.ptr<std::uint16_t>(y)[at] / 65535.0);
    }
  return alpha;
}

std::string encode_alpha(const ImageF& alpha) {
  ImageU8 pixels(alpha.size());
  for (int y = 0; y < alpha.height(); ++y)
    for (int x = 0; x < alpha.width(); ++x)
      pixels.at(x, y) = std::uint8_t(std::lround(255 * std::clamp(alpha.at(x, y), 0.0f, 1.0f)));
  return encode_png(pixels);
}

/// The XML's member: as the standard says, as seen in the field, or the only one there is.
std::string xml_member(const Archive& archive, const std::string& file) {
  std::string only;
  int count = 0;
  for (const std::string& name : archive.names()) {
    if (lower_extension(name) != ".xml") continue;
    std::string plain = name;
    std::transform(plain.begin(), plain.end(), plain.begin(),
                   [](unsigned char c) { return char(std::tolower(c)); });
    if (plain == "mpcdi.xml" || plain == "mpacs.xml") return name;
    only = name;
    ++count;
  }
  if (count != 1)
    throw Error(ErrorKind::kInput, file, "the archive has no mpcdi.xml", "give an .mpcdi archive");
  return only;
}

void read_maps(const Archive& archive, const std::string& file, MpcdiProfile profile, const MpcdiFiles& files,
               MpcdiRegion& region) {
  if (!files.warp.empty()) {
    ImageF map = read_float_map(archive, file, files.warp, region);
    const std::string what = file + ": " + files.warp;
    if (profile == MpcdiProfile::kShaderLamps || profile == MpcdiProfile::kAdvanced3d)
      region.positions = positions_from_file(std::move(map), files.metres_per_unit, what);
    else
      region.warp = warp_from_file(std::move(map), what);
  }
  if (!files.distortion.empty())
    region.distortion = warp_from_file(read_float_map(archive, file, files.distortion, region),
                                       file + ": " + files.distortion);
  if (!files.alpha.empty()) region.alpha = read_alpha(archive, file, files.alpha, region);
}

void note_missing_maps(MpcdiDocument& document) {
  for (const MpcdiRegion& region : document.mpcdi.regions)
    if (!region.warp && !region.positions)
      document.mpcdi.diagnostics.note("no_warp", "region '" + region.id +
                                                     "' has no warp: it only gives the pose of its projector "
                                                     "stands and how wide it opens");
}

void require_complete(MpcdiProfile profile, const MpcdiRegion& region) {
  const std::string what = "save_mpcdi: region '" + region.id + "' ";
  const auto fits = [&](const auto& map) { return !map || map->size() == region.size; };
  require(!region.id.empty() && !region.buffer.empty() && region.size.width > 0 && region.size.height > 0,
          what + "has no id, buffer or size");
  require(fits(region.warp) && fits(region.positions) && fits(region.distortion) && fits(region.alpha),
          what + "has a map of another size");
  require(!region.positions || region.positions->channels() == 3, what + "has positions without 3 channels");
  require(!region.alpha || region.alpha->channels() == 1, what + "has an alpha map without 1 channel");
  if (profile == MpcdiProfile::k2d)
    require(region.warp && !region.positions, what + "needs a warp, profile 2d");
  if (profile == MpcdiProfile::kAdvanced3d)
    require(region.positions && !region.warp, what + "needs positions, profile a3");
  if (profile == MpcdiProfile::kShaderLamps)
    require(region.positions && !region.warp && region.frustum && region.frame && region.distortion,
            what + "needs positions, frustum, frame and distortion, profile sl");
}

}  // namespace

Mpcdi load_mpcdi(const std::filesystem::path& path, std::size_t largest_unpacked) {
  const std::string file = path.string();
  std::string bytes = read_file(path, largest_unpacked);
  if (bytes.compare(0, 2, "PK") != 0) {
    if (bytes.size() > limits::kDocumentBytes)
      throw Error(ErrorKind::kInput, file, "it is neither an archive nor a short XML file", kNextMap);
    MpcdiDocument document = parse_mpcdi_xml(bytes, file);
    for (const MpcdiFiles& files : document.files)
      for (const std::string& name : {files.warp, files.distortion, files.alpha})
        if (!name.empty())
          throw Error(ErrorKind::kInput, file,
                      "it names the file '" + name + "', and an XML file has none inside",
                      "give the .mpcdi archive with its maps");
    note_missing_maps(document);
    return std::move(document.mpcdi);
  }

  const Archive archive(std::move(bytes), file, largest_unpacked);
  const std::string xml_name = xml_member(archive, file);
  const std::string xml = archive.read(xml_name);
  if (xml.size() > limits::kDocumentBytes)
    throw Error(ErrorKind::kInput, file + ": " + xml_name, "it is too large for an MPCDI description",
                kNextMap);
  MpcdiDocument document = parse_mpcdi_xml(xml, file + ": " + xml_name);
  // Bounded before a map is unpacked: regions may share a member, and each would have its own copy.
  double pixels = 0;
  for (std::size_t i = 0; i < document.files.size(); ++i) {
    const MpcdiFiles& files = document.files[i];
    const ImageSize size = document.mpcdi.regions[i].size;
    const int maps = 3 * !files.warp.empty() + 3 * !files.distortion.empty() + !files.alpha.empty();
    pixels += double(maps) * size.width * size.height;
  }
  if (pixels * sizeof(float) > double(largest_unpacked))
    throw Error(ErrorKind::kInput, file + ": " + xml_name,
                "its regions' maps would take more than the " + std::to_string(largest_unpacked) +
                    " bytes that they may have",
                "split it into files of fewer projectors");
  for (std::size_t i = 0; i < document.files.size(); ++i)
    read_maps(archive, file, document.mpcdi.profile, document.files[i], document.mpcdi.regions[i]);
  note_missing_maps(document);
  return std::move(document.mpcdi);
}

void save_mpcdi(const std::filesystem::path& path, const Mpcdi& mpcdi) {
  if (lower_extension(path) != ".mpcdi")
    throw Error(ErrorKind::kUnsupported, path.string(), "it is not named as an MPCDI archive",
                "give it a name that ends in .mpcdi");
  if (mpcdi.profile == MpcdiProfile::k3d)
    throw Error(ErrorKind::kUnsupported, path.string(), "profile 3d is read, not written",
                "use 2d, sl or a3");
  require(!mpcdi.regions.empty(), "save_mpcdi: no regions");
  std::vector<MpcdiFiles> files_of_regions;
  std::vector<std::pair<std::string, std::string>> members{{"mpcdi.xml", ""}};
  for (std::size_t i = 0; i < mpcdi.regions.size(); ++i) {
    const MpcdiRegion& region = mpcdi.regions[i];
    require_complete(mpcdi.profile, region);
    const std::string number = std::to_string(i + 1);  // ids may not be fit for a file's name
    MpcdiFiles files;
    files.warp = "geometry_warp_" + number + ".pfm";
    members.emplace_back(files.warp, region.positions ? encode_pfm(*region.positions)
                                                      : encode_pfm(warp_for_file(*region.warp)));
    if (region.distortion) {
      files.distortion = "distortion_" + number + ".pfm";
      members.emplace_back(files.distortion, encode_pfm(warp_for_file(*region.distortion)));
    }
    if (region.alpha) {
      files.alpha = "alpha_" + number + ".png";
      members.emplace_back(files.alpha, encode_alpha(*region.alpha));
    }
    files_of_regions.push_back(std::move(files));
  }
  members.front().second = to_mpcdi_xml(mpcdi, files_of_regions);
  write_file_atomically(path, make_archive(members));
}

}  // namespace procam::io
