#include <algorithm>
#include <array>
#include <map>

#include "document/number.hpp"
#include "mesh/mesh_reader.hpp"
#include "procam/core/base/bytes.hpp"

namespace procam::io {
namespace {

enum class PlyCoding { kText, kLittleEndian, kBigEndian };

struct PlyType {
  std::size_t bytes = 0;
  bool is_float = false, is_signed = false;
};

struct PlyProperty {
  std::string name;
  PlyType type;
  std::optional<PlyType> count;  ///< of a list
};

struct PlyElement {
  std::string name;
  std::size_t count = 0;
  std::vector<PlyProperty> properties;
};

std::optional<PlyType> ply_type(std::string_view word) {
  if (word == "char" || word == "int8") return PlyType{1, false, true};
  if (word == "uchar" || word == "uint8") return PlyType{1, false, false};
  if (word == "short" || word == "int16") return PlyType{2, false, true};
  if (word == "ushort" || word == "uint16") return PlyType{2, false, false};
  if (word == "int" || word == "int32") return PlyType{4, false, true};
  if (word == "uint" || word == "uint32") return PlyType{4, false, false};
  if (word == "float" || word == "float32") return PlyType{4, true, true};
  if (word == "double" || word == "float64") return PlyType{8, true, true};
  return std::nullopt;
}

std::vector<std::string> words_of(std::string_view line) {
  std::vector<std::string> words;
  for (std::size_t at = line.find_first_not_of(" \t\r"); at != std::string_view::npos;
       at = line.find_first_not_of(" \t\r", at)) {
    const std::size_t end = std::min(line.find_first_of(" \t\r", at), line.size());
    words.emplace_back(line.substr(at, end - at));
    at = end;
  }
  return words;
}

class PlyReader {
 public:
  PlyReader(std::string_view bytes, const std::string& name) : bytes_(bytes), name_(name) {}

  Mesh read() {
    read_header();
    Mesh mesh;
    for (const PlyElement& element : elements_) {
      if (element.name == "vertex")
        read_vertices(element, mesh);
      else if (element.name == "face")
        read_faces(element, mesh);
      else
        skip(element);
    }
    if (!has_uv_ && corner_uv_.empty())
      refuse_mesh(
          name_,
          "its vertices have no texture coordinates (s, t) and its faces no texcoord, so content has no "
          "place on it",
          "unwrap the mesh in the program that made it and export it with texture coordinates");
    if (mesh.triangles.empty()) refuse_mesh(name_, "it has no face");
    if (!corner_uv_.empty() && corner_uv_.size() != 3 * mesh.triangles.size())
      refuse_mesh(name_, "some of its faces have a texcoord and others have none");
    return corner_uv_.empty() ? mesh : split_at_seams(mesh);
  }

 private:
  [[noreturn]] void refuse_header(const std::string& why) const {
    refuse_mesh(name_ + ":" + std::to_string(line_), why);
  }

  std::string_view next_line() {
    if (at_ >= bytes_.size()) refuse_mesh(name_, "it ends within its header");
    const std::size_t end = std::min(bytes_.find('\n', at_), bytes_.size());
    const std::string_view line = bytes_.substr(at_, end - at_);
    at_ = end + 1;
    ++line_;
    return line;
  }

  void read_header() {
    if (words_of(next_line()) != std::vector<std::string>{"ply"})
      refuse_header("it does not begin with 'ply'");
    bool has_format = false;
    for (;;) {
      const std::vector<std::string> words = words_of(next_line());
      if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
      if (words[0] == "end_header") break;
      if (words[0] == "format" && words.size() == 3) {
        const std::array<const char*, 3> codings{"ascii", "binary_little_endian", "binary_big_endian"};
        const auto found = std::find(codings.begin(), codings.end(), words[1]);
        if (found == codings.end()) refuse_header("there is no format '" + words[1] + "'");
        coding_ = PlyCoding(found - codings.begin());
        has_format = true;
      } else if (words[0] == "element" && words.size() == 3) {
        std::size_t count = 0;
        const std::string& text = words[2];
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), count);
        if (error != std::errc() || end != text.data() + text.size())
          refuse_header("'" + text.substr(0, 40) + "' is no number of elements");
        // An element takes a byte at least: a header cannot claim more than the file holds.
        if (count > bytes_.size())
          refuse_header("it claims " + text + " elements, and the file has " + std::to_string(bytes_.size()) +
                        " bytes");
        elements_.push_back({words[1], count, {}});
      } else if (words[0] == "property" && words.size() >= 3 && !elements_.empty()) {
        add_property(words);
      } else {
        refuse_header("'" + words[0].substr(0, 40) + "' is not understood here");
      }
    }
    if (!has_format) refuse_header("it has no format line");
    // Elements of no bytes could be claimed without end.
    for (const PlyElement& element : elements_)
      if (element.properties.empty())
        refuse_header("the element '" + element.name.substr(0, 40) + "' has no property");
  }

  void add_property(const std::vector<std::string>& words) {
    PlyProperty property;
    property.name = words.back();
    const bool list = words[1] == "list";
    if (words.size() != (list ? 5u : 3u)) refuse_header("the property is not understood");
    const auto type = ply_type(words[list ? 3 : 1]);
    if (!type) refuse_header("there is no type '" + words[list ? 3 : 1].substr(0, 40) + "'");
    property.type = *type;
    if (list) {
      property.count = ply_type(words[2]);
      if (!property.count || property.count->is_float) refuse_header("a list is counted by a whole number");
    }
    elements_.back().properties.push_back(property);
  }

  double value(const PlyType& type) {
    if (coding_ == PlyCoding::kText) {
      at_ = std::min(bytes_.find_first_not_of(" \t\r\n", at_), bytes_.size());
      const std::size_t end = std::min(bytes_.find_first_of(" \t\r\n", at_), bytes_.size());
      const std::string_view word = bytes_.substr(at_, end - at_);
      at_ = end;
      const auto number = parse_number(word);
      if (!number)
        refuse_mesh(where(), word.empty() ? "the file ends"
                                          : "'" + std::string(word.substr(0, 40)) + "' is no finite number");
      return *number;
    }
    const auto read = unsigned_at(bytes_, at_, type.bytes, coding_ == PlyCoding::kBigEndian);
    if (!read) refuse_mesh(where(), "the file ends");
    at_ += type.bytes;
    const std::uint64_t bits = read.value_or(0);
    if (type.is_float) {
      const double number = type.bytes == 4 ? double(real_of_bits(std::uint32_t(bits))) : real_of_bits(bits);
      if (!std::isfinite(number)) refuse_mesh(where(), "a number is not finite");
      return number;
    }
    const unsigned unused = unsigned(64 - 8 * type.bytes);
    return type.is_signed ? double(std::int64_t(bits << unused) >> unused) : double(bits);
  }

  void read_list(const PlyProperty& property, std::vector<double>& values) {
    const double count = value(*property.count);
    if (!(count >= 0) || count > double(bytes_.size() - at_))
      refuse_mesh(where(), "a list claims " + format_number(count) + " entries, more than the file holds");
    values.clear();
    for (std::size_t i = 0; i < std::size_t(count); ++i) values.push_back(value(property.type));
  }

  void skip(const PlyElement& element) {
    std::vector<double> list;
    element_ = element.name;
    for (index_ = 0; index_ < element.count; ++index_)
      for (const PlyProperty& property : element.properties) {
        if (property.count)
          read_list(property, list);
        else
          value(property.type);
      }
  }

  void read_vertices(const PlyElement& element, Mesh& mesh) {
    // Places of x, y, z, u, v among the properties.
    constexpr std::array<std::array<const char*, 4>, 5> kNames{
        {{"x"}, {"y"}, {"z"}, {"s", "u", "texture_u", "texture_s"}, {"t", "v", "texture_v", "texture_t"}}};
    std::array<std::size_t, 5> places{};
    for (std::size_t i = 0; i < 5; ++i) {
      places[i] = element.properties.size();
      for (std::size_t k = 0; k < element.properties.size(); ++k)
        for (const char* name : kNames[i])
          if (name && element.properties[k].name == name && !element.properties[k].count) places[i] = k;
      if (i < 3 && places[i] == element.properties.size())
        refuse_mesh(name_, std::string("its vertices have no ") + kNames[i][0]);
    }
    has_uv_ = places[3] < element.properties.size() && places[4] < element.properties.size();
    element_ = element.name;
    std::vector<double> list, row(element.properties.size());
    for (index_ = 0; index_ < element.count; ++index_) {
      for (std::size_t k = 0; k < element.properties.size(); ++k) {
        if (element.properties[k].count)
          read_list(element.properties[k], list);
        else
          row[k] = value(element.properties[k].type);
      }
      mesh.vertices.emplace_back(row[places[0]], row[places[1]], row[places[2]]);
      mesh.uv.push_back(has_uv_ ? Vec2(row[places[3]], 1 - row[places[4]]) : Vec2(0, 0));
    }
  }

  void read_faces(const PlyElement& element, Mesh& mesh) {
    element_ = element.name;
    bool has_texcoord = false;
    for (const PlyProperty& property : element.properties) has_texcoord |= is_texcoord(property);
    std::vector<double> list, texcoord;
    std::vector<int> corners;
    for (index_ = 0; index_ < element.count; ++index_) {
      corners.clear();
      texcoord.clear();
      for (const PlyProperty& property : element.properties) {
        if (!property.count) {
          value(property.type);
          continue;
        }
        read_list(property, list);
        if (is_texcoord(property)) texcoord = list;
        if (property.name != "vertex_indices" && property.name != "vertex_index") continue;
        if (list.size() < 3) refuse_mesh(where(), "a face needs three corners");
        for (const double corner : list) {
          if (!(corner >= 0) || !(corner < double(mesh.vertices.size())))
            refuse_mesh(where(), "there is no vertex " + format_number(corner) + " before it");
          corners.push_back(int(corner));
        }
      }
      if (corners.empty()) continue;
      add_fan(corners, where(), mesh);
      if (!has_texcoord) continue;
      if (texcoord.size() != 2 * corners.size())
        refuse_mesh(where(),
                    "it has " + std::to_string(texcoord.size()) + " texture coordinates for " +
                        std::to_string(corners.size()) + " corners",
                    "export the mesh again with an s and a t for every corner of every face");
      const auto uv = [&](std::size_t corner) {
        return Vec2(texcoord[2 * corner], 1 - texcoord[2 * corner + 1]);
      };
      for (std::size_t i = 2; i < corners.size(); ++i)  // as add_fan() makes the triangles
        corner_uv_.insert(corner_uv_.end(), {uv(0), uv(i - 1), uv(i)});
    }
  }

  static bool is_texcoord(const PlyProperty& property) {
    return property.count && property.name == "texcoord";
  }

  /// A mesh whose faces bring their own texture coordinates (MeshLab's "texcoord"): a vertex for every place
  /// that has others in another face.
  Mesh split_at_seams(const Mesh& mesh) const {
    Mesh out;
    std::map<std::array<double, 3>, int> known;  // vertex, u, v
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      std::array<int, 3> triangle{};
      for (std::size_t k = 0; k < 3; ++k) {
        const int vertex = mesh.triangles[t][k];
        const Vec2& uv = corner_uv_[3 * t + k];
        const auto [at, is_new] =
            known.try_emplace({double(vertex), uv.x(), uv.y()}, int(out.vertices.size()));
        if (is_new) {
          out.vertices.push_back(mesh.vertices[std::size_t(vertex)]);
          out.uv.push_back(uv);
        }
        triangle[k] = at->second;
      }
      out.triangles.push_back({triangle[0], triangle[1], triangle[2]});
    }
    return out;
  }

  std::string where() const { return name_ + ", " + element_ + " " + std::to_string(index_); }

  std::string_view bytes_;
  std::string name_;
  std::size_t at_ = 0;
  int line_ = 0;
  PlyCoding coding_ = PlyCoding::kText;
  std::vector<PlyElement> elements_;
  std::string element_;
  std::size_t index_ = 0;
  bool has_uv_ = false;          ///< of the vertices
  std::vector<Vec2> corner_uv_;  ///< of the faces: three a triangle, or none
};

}  // namespace

Mesh parse_ply(std::string_view bytes, const std::string& name) {
  return PlyReader(bytes, name).read();
}

}  // namespace procam::io
