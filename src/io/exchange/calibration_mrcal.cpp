#include <algorithm>

#include "document/number.hpp"
#include "document/size_check.hpp"
#include "document/value.hpp"
#include "exchange/calibration_readers.hpp"
#include "procam/core/base/limits.hpp"
#include "procam/core/geometry/se3.hpp"

namespace procam::io {
namespace {

constexpr const char* kNextMrcal = "give the file as mrcal writes it, or convert it with mrcal-to-kalibr";

bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\n';
}

/// A Python literal as JSON, line by line: comments, quotes, tuples, trailing commas, numbers such as "0." and "+1".
class PythonLiteral {
 public:
  explicit PythonLiteral(std::string_view bytes) : bytes_(bytes) {}

  std::string json() {
    while (at_ < bytes_.size()) step();
    return std::move(json_);
  }

 private:
  char here() const { return bytes_[at_]; }
  char next() const { return at_ + 1 < bytes_.size() ? bytes_[at_ + 1] : '\0'; }

  void step() {
    const char c = here();
    const bool is_prefix_of_bytes = (c == 'b' || c == 'B') && (next() == '\'' || next() == '"');
    const bool is_trailing_comma = c == ',' && closes(at_ + 1);
    if (c == '#') {
      at_ = std::min(bytes_.find('\n', at_), bytes_.size());
    } else if (is_prefix_of_bytes || is_trailing_comma) {
      ++at_;
    } else if (c == '\'' || c == '"') {
      copy_text();
    } else if (is_word(c)) {
      copy_word();
    } else {
      json_ += c == '(' ? '[' : c == ')' ? ']' : c;
      ++at_;
    }
  }

  static bool is_word(char c) {
    return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '.' ||
           c == '+' || c == '-' || c == '_';
  }

  /// Is the next letter that counts a closing bracket?
  bool closes(std::size_t at) const {
    while (at < bytes_.size() && (is_blank(bytes_[at]) || bytes_[at] == '#')) {
      if (bytes_[at] == '#')
        at = std::min(bytes_.find('\n', at), bytes_.size());
      else
        ++at;
    }
    return at < bytes_.size() && (bytes_[at] == ']' || bytes_[at] == ')' || bytes_[at] == '}');
  }

  void copy_text() {
    const char quote = here();
    json_ += '"';
    for (++at_; at_ < bytes_.size() && here() != quote; ++at_) {
      const bool is_escaped_quote = here() == '\\' && (next() == '\'' || next() == '"');
      if (is_escaped_quote) ++at_;
      if (here() == '"' || (here() == '\\' && !is_escaped_quote)) json_ += '\\';
      json_ += here();
    }
    if (at_ < bytes_.size()) {
      json_ += '"';
      ++at_;
    }
  }

  void copy_word() {
    const std::size_t begin = at_;
    while (at_ < bytes_.size() && is_word(here())) ++at_;
    const std::string_view word = bytes_.substr(begin, at_ - begin);
    const std::optional<double> number = parse_number(word.front() == '+' ? word.substr(1) : word);
    if (number)
      json_ += format_number(*number);
    else if (word == "None")
      json_ += "null";
    else if (word == "True" || word == "False")
      json_ += word == "True" ? "true" : "false";
    else
      json_ += word;
  }

  std::string_view bytes_;
  std::size_t at_ = 0;
  std::string json_;
};

std::optional<Value> member_called(const std::vector<Value>& members, const std::string& name) {
  for (const Value& member : members)
    if (member.node->name == name) return member;
  return std::nullopt;
}

Value require_member_called(const Value& root, const std::vector<Value>& members, const std::string& name) {
  const std::optional<Value> found = member_called(members, name);
  if (!found) root.fail("the field '" + name + "' is missing", kNextMrcal);
  return *found;
}

std::vector<double> numbers_counted(const Value& value, std::size_t count) {
  std::vector<double> numbers = value.numbers();
  if (numbers.size() != count)
    value.fail("it has " + std::to_string(numbers.size()) + " numbers, not " + std::to_string(count),
               kNextMrcal);
  return numbers;
}

/// The lens model's distortion with all coefficients 0; nullopt for one that procam has not.
std::optional<Distortion> lens_called(const std::string& name) {
  if (name == "LENSMODEL_PINHOLE") return NoDistortion{};
  if (name == "LENSMODEL_OPENCV4" || name == "LENSMODEL_OPENCV5") return BrownConrady{};
  if (name == "LENSMODEL_OPENCV8") return RationalDistortion{};
  return std::nullopt;
}

}  // namespace

bool is_mrcal(std::string_view bytes) {
  // The command line in a comment may name it first.
  const auto has = [&](const char* text) { return bytes.find(text) != std::string_view::npos; };
  const bool has_old_name = has("'lens_model'") && has("'LENSMODEL_");
  return has("'lensmodel'") || has("\"lensmodel\"") || has_old_name;
}

Rig read_mrcal(std::string_view bytes, const std::string& file) {
  const Node document = parse_json(PythonLiteral(bytes).json(), file);
  const Value root{&document, &file, ""};
  const std::vector<Value> members = root.members();
  const auto old = member_called(members, "lens_model");  // before mrcal 1.0
  const Value model = old ? *old : require_member_called(root, members, "lensmodel");
  const std::string name = model.text();
  const std::optional<Distortion> lens = lens_called(name);
  if (!lens)
    model.fail("procam has no lens model '" + name.substr(0, 60) + "'",
               "fit LENSMODEL_OPENCV8 to it with mrcal-convert-lensmodel", ErrorKind::kUnsupported);

  RigCamera camera;
  const Value sides = require_member_called(root, members, "imagersize");
  const std::vector<double> size = numbers_counted(sides, 2);
  for (const double side : size)
    if (side != std::floor(side) || side < 1 || side > limits::kSizeSide)
      sides.fail("it is not a width and a height in whole pixels", kNextMrcal);
  camera.camera.size = {int(size[0]), int(size[1])};
  if (const auto why = flaw(camera.camera.size)) sides.fail(*why, kNextMrcal);

  const std::size_t count = name == "LENSMODEL_OPENCV4" ? 4 : coefficients_of(*lens).size();
  const Value intrinsics = require_member_called(root, members, "intrinsics");
  std::vector<double> k = numbers_counted(intrinsics, 4 + count);
  if (!(k[0] > 0 && k[1] > 0)) intrinsics.fail("its focal lengths are not positive", kNextMrcal);
  camera.camera.intrinsics = {k[0], k[1], k[2], k[3], 0};
  k.resize(4 + coefficients_of(*lens).size(), 0.0);
  camera.camera.distortion = with_coefficients(*lens, {k.begin() + 4, k.end()});

  // Newer files call it by its meaning.
  std::optional<Value> pose = member_called(members, "rt_cam_ref");
  if (!pose) pose = require_member_called(root, members, "extrinsics");
  const std::vector<double> rt = numbers_counted(*pose, 6);
  const Vec3 r(rt[0], rt[1], rt[2]), t(rt[3], rt[4], rt[5]);
  if (!(r.norm() < 1e3) || !(t.norm() < limits::kLengthM))
    pose->fail("no camera stands so far away, or is turned so far", kNextMrcal);
  camera.rig_from_camera = Pose(so3_exp(r), t).inverse();

  Rig rig;
  rig.provenance.tool = "mrcal";
  rig.cameras.push_back(camera);
  return rig;
}

}  // namespace procam::io
