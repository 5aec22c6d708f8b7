#include "exchange/mpcdi_xml.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <pugixml.hpp>
#include <set>

#include "document/document.hpp"
#include "document/number.hpp"
#include "document/trimmed.hpp"
#include "exchange/archive.hpp"
#include "procam/core/base/limits.hpp"

namespace procam::io {
namespace {

constexpr std::array<const char*, 4> kProfiles{"2d", "3d", "sl", "a3"};

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](char c) { return char(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c); });
  return text;
}

/// Elements and attributes by name in any case: the field spells them in many ways.
class MpcdiReader {
 public:
  explicit MpcdiReader(const std::string& file) : file_(file) {}

  MpcdiDocument read(const Node& root) {
    if (lower(text(root, "format")) != "mpcdi")
      fail(root, "its root element is '" + text(root, "format") + "', not MPCDI",
           "give an MPCDI file, .mpcdi or .mpcdi.xml");
    MpcdiDocument document;
    document.mpcdi.profile = profile(root);
    if (const Node* date = find(root, "date")) document.mpcdi.date = date->text;
    const Node* display = find(root, "display");
    if (display == nullptr) fail(root, "it has no display", kNextMpcdi);
    for (const Node& buffer : display->children)
      if (lower(buffer.name) == "buffer") add_buffer(buffer, document);
    if (document.mpcdi.regions.empty()) fail(*display, "it has no regions", kNextMpcdi);
    if (const Node* files = find(root, "files"))
      for (const Node& files_of : files->children)
        if (lower(files_of.name) == "fileset") add_files(files_of, text(files_of, "region"), document);
    return document;
  }

 private:
  static constexpr const char* kNextMpcdi = "export it again from the program that made it";
  const std::string& file_;
  std::set<std::string> ids_;

  [[noreturn]] void fail(const Node& node, const std::string& why, const char* next = kNextMpcdi) const {
    throw Error(ErrorKind::kInput, file_ + ":" + std::to_string(node.line), why, next);
  }
  static const Node* find(const Node& parent, const std::string& name) {
    for (const Node& child : parent.children)
      if (lower(child.name) == name) return &child;
    return nullptr;
  }
  std::string text(const Node& parent, const std::string& name) const {
    const Node* const child = find(parent, name);
    if (child == nullptr || trimmed(child->text).empty()) fail(parent, "it has no " + name);
    return trimmed(child->text);
  }
  double number(const Node& parent, const std::string& name) const {
    const std::string value = text(parent, name);
    const std::optional<double> parsed = parse_number(value);
    if (!parsed || std::abs(*parsed) > 1e9) fail(parent, "its " + name + " is '" + value.substr(0, 40) + "'");
    return *parsed;
  }
  Vec3 vector(const Node& parent, const std::string& name) const {
    return Vec3(number(parent, name + "x"), number(parent, name + "y"), number(parent, name + "z"));
  }

  MpcdiProfile profile(const Node& root) const {
    try {
      return parse_mpcdi_profile(text(root, "profile"));
    } catch (const Error& error) {
      fail(root, "its profile is " + error.subject());
    }
  }
  int side(const Node& region, const Node& buffer, const std::string& name) const {
    const double value = number(find(region, name) != nullptr ? region : buffer, name);
    if (!(value >= 1 && value <= limits::kFrameSide && value == std::floor(value)))
      fail(region, "its " + name + " is " + format_number(value) + ", and a picture has 1 to " +
                       std::to_string(limits::kFrameSide) + " pixels a side");
    return int(value);
  }
  void add_buffer(const Node& buffer, MpcdiDocument& document) {
    for (const Node& node : buffer.children) {
      if (lower(node.name) != "region") continue;
      if (document.mpcdi.regions.size() == limits::kRegions)
        fail(node, "it has more than " + std::to_string(limits::kRegions) + " regions");
      MpcdiRegion region;
      region.buffer = text(buffer, "id");
      region.id = text(node, "id");
      if (!ids_.insert(region.id).second) fail(node, "two regions have the id '" + region.id + "'");
      region.size = {side(node, buffer, "xresolution"), side(node, buffer, "yresolution")};
      set_part(node, region);
      if (const Node* frustum = find(node, "frustum")) region.frustum = read_frustum(*frustum);
      if (const Node* frame = find(node, "coordinateframe")) region.frame = read_frame(*frame);
      document.mpcdi.regions.push_back(std::move(region));
      document.files.emplace_back();
      for (const Node& child : node.children)  // where some programs write them
        if (lower(child.name) == "fileset") add_files(child, document.mpcdi.regions.back().id, document);
    }
  }
  void set_part(const Node& node, MpcdiRegion& region) const {
    region.x = number(node, "x");
    region.y = number(node, "y");
    region.width = number(node, "xsize");
    region.height = number(node, "ysize");
    constexpr double kSlack = 1e-4;  // files carry rounded numbers
    const auto inside = [](double from, double size) {
      return from >= -kSlack && size > 0 && from + size <= 1 + kSlack;
    };
    if (!inside(region.x, region.width) || !inside(region.y, region.height))
      fail(node, "region '" + region.id + "' does not lie within 0..1 of its buffer");
  }
  MpcdiFrustum read_frustum(const Node& node) const {
    MpcdiFrustum f{number(node, "yaw"),       number(node, "pitch"),      number(node, "roll"),
                   number(node, "leftangle"), number(node, "rightangle"), number(node, "downangle"),
                   number(node, "upangle")};
    const auto opens = [](double low, double high) { return low < high && low > -90 && high < 90; };
    if (!opens(f.left, f.right) || !opens(f.down, f.up))
      fail(node, "its frustum is empty or opens by 90 degrees and more to a side");
    return f;
  }
  MpcdiFrame read_frame(const Node& node) const {
    return {vector(node, "pos"), vector(node, "yaw"), vector(node, "pitch"), vector(node, "roll")};
  }

  static std::string path_of(const Node& node) {
    const Node* const path = find(node, "path");
    return trimmed(path != nullptr ? path->text : node.text);
  }
  std::string member(const Node& files, const std::string& name) const {
    const Node* const node = find(files, name);
    if (node == nullptr) return "";
    const std::string path = path_of(*node);
    if (leads_outside(path)) fail(*node, "the file '" + path.substr(0, 80) + "' does not lie in the archive");
    return path;
  }
  void add_files(const Node& node, const std::string& id, MpcdiDocument& document) const {
    const auto& regions = document.mpcdi.regions;
    const auto region = std::find_if(regions.begin(), regions.end(),
                                     [&](const MpcdiRegion& candidate) { return candidate.id == id; });
    if (region == regions.end()) fail(node, "it has files for '" + id + "', and no region of that id");
    MpcdiFiles& files = document.files[std::size_t(region - regions.begin())];
    files.warp = member(node, "geometrywarpfile");
    files.distortion = member(node, "distortionmap");
    files.alpha = member(node, "alphamap");
    if (const Node* alpha = find(node, "alphamap"))
      if (find(*alpha, "gammaembedded") != nullptr) {
        const double gamma = number(*alpha, "gammaembedded");
        if (!(gamma > 0 && gamma <= 10)) fail(*alpha, "its gamma is " + format_number(gamma));
        document.mpcdi.regions[std::size_t(region - regions.begin())].alpha_gamma = gamma;
      }
    if (const Node* warp = find(node, "geometrywarpfile"))
      if (find(*warp, "geometricunit") != nullptr) files.metres_per_unit = metres_per(*warp);
  }
  double metres_per(const Node& warp) const {
    const std::string unit = lower(text(warp, "geometricunit"));
    constexpr std::array<std::pair<const char*, double>, 9> kUnits{{{"mm", 1e-3},
                                                                    {"cm", 1e-2},
                                                                    {"dm", 1e-1},
                                                                    {"m", 1},
                                                                    {"in", 0.0254},
                                                                    {"ft", 0.3048},
                                                                    {"yd", 0.9144},
                                                                    {"2d", 1},
                                                                    {"unknown", 1}}};
    for (const auto& [name, metres] : kUnits)
      if (unit == name) return metres;
    fail(warp, "its unit is '" + unit.substr(0, 20) + "'");
  }
};

void add_text(pugi::xml_node parent, const char* name, const std::string& text) {
  parent.append_child(name).text().set(text.c_str());
}
void add_number(pugi::xml_node parent, const std::string& name, double value) {
  add_text(parent, name.c_str(), format_number(value == 0 ? 0.0 : value));  // not "-0.0"
}
void add_vector(pugi::xml_node parent, const std::string& name, const Vec3& v) {
  add_number(parent, name + "x", v.x());
  add_number(parent, name + "y", v.y());
  add_number(parent, name + "z", v.z());
}

void write_region(pugi::xml_node buffer, const MpcdiRegion& region) {
  pugi::xml_node node = buffer.append_child("region");
  node.append_attribute("id") = region.id.c_str();
  node.append_attribute("Xresolution") = region.size.width;
  node.append_attribute("Yresolution") = region.size.height;
  node.append_attribute("x") = format_number(region.x).c_str();
  node.append_attribute("y") = format_number(region.y).c_str();
  node.append_attribute("xsize") = format_number(region.width).c_str();
  node.append_attribute("ysize") = format_number(region.height).c_str();
  if (region.frustum) {
    pugi::xml_node frustum = node.append_child("frustum");
    add_number(frustum, "yaw", region.frustum->yaw);
    add_number(frustum, "pitch", region.frustum->pitch);
    add_number(frustum, "roll", region.frustum->roll);
    add_number(frustum, "rightAngle", region.frustum->right);
    add_number(frustum, "leftAngle", region.frustum->left);
    add_number(frustum, "upAngle", region.frustum->up);
    add_number(frustum, "downAngle", region.frustum->down);
  }
  if (region.frame) {
    pugi::xml_node frame = node.append_child("coordinateFrame");
    add_vector(frame, "pos", region.frame->position);
    add_vector(frame, "yaw", region.frame->yaw);
    add_vector(frame, "pitch", region.frame->pitch);
    add_vector(frame, "roll", region.frame->roll);
  }
}

void write_files(pugi::xml_node parent, const MpcdiRegion& region, const MpcdiFiles& files) {
  pugi::xml_node node = parent.append_child("fileset");
  node.append_attribute("region") = region.id.c_str();
  pugi::xml_node warp = node.append_child("geometryWarpFile");
  add_text(warp, "path", files.warp);
  add_text(warp, "geometricUnit", region.positions ? "m" : "2D");
  add_text(warp, "interpolation", "linear");
  if (region.positions) add_text(warp, "originOf3DData", "floorCenter");
  if (!files.alpha.empty()) {
    pugi::xml_node alpha = node.append_child("alphaMap");
    add_text(alpha, "path", files.alpha);
    add_text(alpha, "componentDepth", "1");
    add_text(alpha, "bitDepth", "8");
    add_number(alpha, "gammaEmbedded", region.alpha_gamma);
  }
  if (!files.distortion.empty()) add_text(node.append_child("distortionMap"), "path", files.distortion);
}

struct XmlText : pugi::xml_writer {
  std::string out;
  void write(const void* data, std::size_t size) override {
    out.append(static_cast<const char*>(data), size);
  }
};

}  // namespace

MpcdiProfile parse_mpcdi_profile(const std::string& text) {
  for (std::size_t i = 0; i < kProfiles.size(); ++i)
    if (lower(text) == kProfiles[i]) return MpcdiProfile(i);
  throw Error(ErrorKind::kInput, "'" + text.substr(0, 40) + "'", "it is no MPCDI profile",
              "give 2d, 3d, sl or a3");
}

MpcdiDocument parse_mpcdi_xml(std::string_view bytes, const std::string& file) {
  return MpcdiReader(file).read(parse_xml(bytes, file));
}

std::string to_mpcdi_xml(const Mpcdi& mpcdi, const std::vector<MpcdiFiles>& files_of_regions) {
  pugi::xml_document xml;
  pugi::xml_node declaration = xml.append_child(pugi::node_declaration);
  declaration.append_attribute("version") = "1.0";
  declaration.append_attribute("encoding") = "utf-8";
  pugi::xml_node root = xml.append_child("MPCDI");
  root.append_attribute("profile") = kProfiles[std::size_t(mpcdi.profile)];
  root.append_attribute("geometry") = "1";
  root.append_attribute("color") = "1";
  root.append_attribute("date") = mpcdi.date.c_str();
  root.append_attribute("version") = "2.0";
  pugi::xml_node display = root.append_child("display");
  for (const MpcdiRegion& region : mpcdi.regions) {
    pugi::xml_node buffer = display.find_child_by_attribute("buffer", "id", region.buffer.c_str());
    if (!buffer) {
      buffer = display.append_child("buffer");
      buffer.append_attribute("id") = region.buffer.c_str();
      buffer.append_attribute("Xresolution") = region.size.width;
      buffer.append_attribute("Yresolution") = region.size.height;
    }
    write_region(buffer, region);
  }
  pugi::xml_node files = root.append_child("files");
  for (std::size_t i = 0; i < files_of_regions.size(); ++i)
    write_files(files, mpcdi.regions[i], files_of_regions[i]);
  XmlText text;
  xml.save(text, "  ", pugi::format_default, pugi::encoding_utf8);
  return text.out;
}

}  // namespace procam::io
