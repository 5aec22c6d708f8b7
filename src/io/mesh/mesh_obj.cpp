#include <unordered_map>

#include "document/number.hpp"
#include "mesh/mesh_reader.hpp"

namespace procam::io {
namespace {

/// The next word of a line; empty at its end.
std::string_view next_word(std::string_view& line) {
  const std::size_t begin = line.find_first_not_of(" \t\r");
  if (begin == std::string_view::npos) {
    line = {};
    return {};
  }
  const std::size_t end = std::min(line.find_first_of(" \t\r", begin), line.size());
  const std::string_view word = line.substr(begin, end - begin);
  line.remove_prefix(end);
  return word;
}

class ObjReader {
 public:
  explicit ObjReader(const std::string& name) : name_(name) {}

  void read_line(std::string_view line) {
    ++line_;
    line = line.substr(0, line.find('#'));
    const std::string_view keyword = next_word(line);
    if (keyword == "v") {
      positions_.push_back(numbers<3>(line, "a position needs three numbers"));
    } else if (keyword == "vt") {
      uv_.push_back(numbers<2>(line, "a texture coordinate needs two numbers"));
    } else if (keyword == "f") {
      read_face(line);
    }  // normals, groups and materials do not matter here
  }

  Mesh take() {
    if (mesh_.triangles.empty()) refuse_mesh(name_, "it has no face");
    return std::move(mesh_);
  }

 private:
  std::string where() const { return name_ + ":" + std::to_string(line_); }

  template <int N>
  Eigen::Matrix<double, N, 1> numbers(std::string_view line, const char* needs) const {
    Eigen::Matrix<double, N, 1> result;
    for (int i = 0; i < N; ++i) {
      const std::string_view word = next_word(line);
      const auto number = parse_number(word);
      if (!number)
        refuse_mesh(where(),
                    std::string(needs) +
                        (word.empty() ? "" : ", and '" + std::string(word.substr(0, 40)) + "' is none"));
      result[i] = *number;
    }
    return result;
  }

  /// 1-based, negative from the end, as the format counts; 0-based here.
  std::size_t index(std::string_view text, std::size_t count, const char* what) const {
    long value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error == std::errc() && end == text.data() + text.size()) {
      if (value > 0 && std::size_t(value) <= count) return std::size_t(value) - 1;
      if (value < 0 && std::size_t(-(value + 1)) < count) return count - std::size_t(-(value + 1)) - 1;
    }
    refuse_mesh(where(),
                "there is no " + std::string(what) + " '" + std::string(text.substr(0, 40)) + "' before it");
  }

  void read_face(std::string_view line) {
    std::vector<int> corners;
    for (std::string_view word = next_word(line); !word.empty(); word = next_word(line)) {
      const std::size_t slash = word.find('/');
      const std::string_view rest = slash == std::string_view::npos ? "" : word.substr(slash + 1);
      const std::string_view texture = rest.substr(0, rest.find('/'));
      if (texture.empty())
        refuse_mesh(
            where(), "the face has no texture coordinates, so content has no place on it",
            "unwrap the mesh in the program that made it and export it with texture coordinates (vt)");
      const std::size_t position = index(word.substr(0, slash), positions_.size(), "position");
      corners.push_back(vertex(position, index(texture, uv_.size(), "texture coordinate")));
    }
    if (corners.size() < 3) refuse_mesh(where(), "a face needs three corners");
    add_fan(corners, where(), mesh_);
  }

  int vertex(std::size_t position, std::size_t uv) {
    const std::uint64_t pair = (std::uint64_t(position) << 32) | std::uint64_t(uv);
    const auto [found, is_new] = vertices_.emplace(pair, int(mesh_.vertices.size()));
    if (is_new) {
      mesh_.vertices.push_back(positions_[position]);
      mesh_.uv.emplace_back(uv_[uv].x(), 1 - uv_[uv].y());
    }
    return found->second;
  }

  std::string name_;
  int line_ = 0;
  Points3 positions_;
  Points2 uv_;
  std::unordered_map<std::uint64_t, int> vertices_;
  Mesh mesh_;
};

}  // namespace

Mesh parse_obj(std::string_view text, const std::string& name) {
  ObjReader reader(name);
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    reader.read_line(text.substr(at, end - at));
    at = end + 1;
  }
  return reader.take();
}

}  // namespace procam::io
