#include "image/npy.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>

#include "procam/core/base/bytes.hpp"
#include "procam/core/base/error.hpp"
#include "procam/core/base/limits.hpp"
#include "procam/io/files.hpp"

namespace procam::io {
namespace {

constexpr std::string_view kMagic("\x93NUMPY", 6);
constexpr double kMaxExact = 9007199254740992.0;  // 2^53: above it integers are no doubles
constexpr const char* kNextNpy = "write it with numpy.save() from a float64 array in C order";

[[noreturn]] void fail_npy(const std::string& file, const std::string& why,
                           ErrorKind kind = ErrorKind::kInput) {
  throw Error(kind, file, why, kNextNpy);
}

/// One number's type: '<f8' and the like.
struct NumberType {
  char kind = 'f';
  std::size_t bytes = 8;
};

NumberType number_type(const std::string& text, const std::string& file) {
  const auto unsupported = [&](const std::string& why) {
    fail_npy(file, "its numbers have the type '" + text.substr(0, 16) + "': " + why, ErrorKind::kUnsupported);
  };
  if (text.size() < 3) unsupported("that is none of bool, integer and float");
  const char order = text[0];
  NumberType type{text[1], 0};
  const auto [end, error] = std::from_chars(text.data() + 2, text.data() + text.size(), type.bytes);
  if (error != std::errc() || end != text.data() + text.size()) unsupported("its size is no number");
  if (order == '>' && type.bytes > 1) unsupported("big-endian");
  if (order != '<' && order != '|' && order != '=' && order != '>') unsupported("the byte order is unknown");
  const bool known = (type.kind == 'f' && (type.bytes == 4 || type.bytes == 8)) ||
                     ((type.kind == 'i' || type.kind == 'u') &&
                      (type.bytes == 1 || type.bytes == 2 || type.bytes == 4 || type.bytes == 8)) ||
                     (type.kind == 'b' && type.bytes == 1);
  if (!known) unsupported("bool, integers of 1 to 8 bytes and floats of 4 and 8 bytes are read");
  return type;
}

template <typename T>
double number_as(const char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  return double(value);
}

double number_at(const char* bytes, NumberType type) {
  if (type.kind == 'f') return type.bytes == 4 ? number_as<float>(bytes) : number_as<double>(bytes);
  const bool is_signed = type.kind == 'i';
  switch (type.bytes) {
    case 1:
      return is_signed ? number_as<std::int8_t>(bytes) : number_as<std::uint8_t>(bytes);
    case 2:
      return is_signed ? number_as<std::int16_t>(bytes) : number_as<std::uint16_t>(bytes);
    case 4:
      return is_signed ? number_as<std::int32_t>(bytes) : number_as<std::uint32_t>(bytes);
    default:
      return is_signed ? number_as<std::int64_t>(bytes) : number_as<std::uint64_t>(bytes);
  }
}

struct Field {
  std::string name;  ///< empty for a plain array
  NumberType type;
};

/// What the header says: {'descr': '<f8', 'fortran_order': False, 'shape': (3, 2), }, a Python literal.
class Header {
 public:
  Header(std::string_view text, const std::string& file) : text_(text), file_(file) {
    expect('{');
    while (!accept('}')) {
      const std::string key = quoted();
      expect(':');
      if (key == "descr")
        read_types();
      else if (key == "fortran_order")
        fortran_order_ = word() == "True";
      else if (key == "shape")
        read_shape();
      else
        fail_npy(file_, "its header has an unknown field '" + key.substr(0, 32) + "'");
      if (!accept(',')) {
        expect('}');
        break;
      }
    }
    if (fields.empty() || !has_shape_) fail_npy(file_, "its header states no type or no shape");
    if (fortran_order_ && shape.size() > 1)
      fail_npy(file_, "it is stored in Fortran order; procam reads C order", ErrorKind::kUnsupported);
  }

  std::vector<Field> fields;
  std::vector<std::size_t> shape;

 private:
  std::string_view text_;
  const std::string& file_;
  std::size_t at_ = 0;
  bool has_shape_ = false, fortran_order_ = false;

  void skip_blanks() {
    while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_])) != 0) ++at_;
  }
  bool accept(char wanted) {
    skip_blanks();
    if (at_ >= text_.size() || text_[at_] != wanted) return false;
    ++at_;
    return true;
  }
  void expect(char wanted) {
    if (!accept(wanted))
      fail_npy(file_, std::string("its header is damaged: '") + wanted + "' is expected at byte " +
                          std::to_string(at_) + " of it");
  }
  std::string quoted() {
    skip_blanks();
    const char quote = at_ < text_.size() ? text_[at_] : '\0';
    if (quote != '\'' && quote != '"') fail_npy(file_, "its header is damaged: a text in quotes is expected");
    const std::size_t end = text_.find(quote, at_ + 1);
    if (end == std::string_view::npos) fail_npy(file_, "its header is damaged: a text does not end");
    std::string out(text_.substr(at_ + 1, end - at_ - 1));
    at_ = end + 1;
    return out;
  }
  std::string word() {
    skip_blanks();
    const std::size_t begin = at_;
    while (at_ < text_.size() && std::isalnum(static_cast<unsigned char>(text_[at_])) != 0) ++at_;
    return std::string(text_.substr(begin, at_ - begin));
  }
  void read_types() {
    fields.clear();
    if (!accept('[')) {
      fields.push_back({"", number_type(quoted(), file_)});
      return;
    }
    while (!accept(']')) {
      expect('(');
      Field field;
      field.name = quoted();
      expect(',');
      field.type = number_type(quoted(), file_);
      accept(',');
      if (!accept(')'))
        fail_npy(file_, "its field '" + field.name.substr(0, 32) + "' holds arrays", ErrorKind::kUnsupported);
      if (field.name.empty() || fields.size() >= 64) fail_npy(file_, "its header has fields without a name");
      for (const Field& other : fields)
        if (other.name == field.name) fail_npy(file_, "two of its fields are called '" + field.name + "'");
      fields.push_back(field);
      if (!accept(',')) {
        expect(']');
        break;
      }
    }
  }
  void read_shape() {
    shape.clear();
    has_shape_ = true;
    expect('(');
    while (!accept(')')) {
      const std::string digits = word();
      std::size_t side = 0;
      const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), side);
      if (digits.empty() || error != std::errc() || end != digits.data() + digits.size())
        fail_npy(file_, "its shape is no list of whole numbers");
      shape.push_back(side);
      if (shape.size() > 3) fail_npy(file_, "it has more than three dimensions", ErrorKind::kUnsupported);
      if (!accept(',')) {
        expect(')');
        break;
      }
    }
  }
};

}  // namespace

NpyArray parse_npy(std::string_view bytes, const std::string& name) {
  if (bytes.substr(0, kMagic.size()) != kMagic || bytes.size() < 10) fail_npy(name, "it is no .npy file");
  const int version = static_cast<unsigned char>(bytes[6]);
  if (version < 1 || version > 3)
    fail_npy(name, "its format version is " + std::to_string(version) + "; 1 to 3 are read",
             ErrorKind::kUnsupported);
  const std::size_t length_bytes = version == 1 ? 2 : 4, begin = 8 + length_bytes;
  if (bytes.size() < begin) fail_npy(name, "it is cut short");
  const std::size_t length = unsigned_at(bytes, 8, length_bytes, false).value_or(0);
  if (length > limits::kArrayHeaderBytes)
    fail_npy(name, "its header claims " + std::to_string(length) + " bytes");
  if (bytes.size() - begin < length) fail_npy(name, "it is cut short in its header");
  const Header header(bytes.substr(begin, length), name);

  NpyArray array;
  array.shape = header.shape;
  std::size_t count = 1, record = 0;
  for (const std::size_t side : header.shape) {
    if (side > limits::kArrayValues || (side > 0 && count > limits::kArrayValues / side))
      fail_npy(name, "it claims more than " + std::to_string(limits::kArrayValues) + " values");
    count *= side;
  }
  for (const Field& field : header.fields) record += field.type.bytes;
  if (count * header.fields.size() > limits::kArrayValues)
    fail_npy(name, "it claims more than " + std::to_string(limits::kArrayValues) + " values");
  const std::string_view data = bytes.substr(begin + length);
  if (data.size() != count * record)
    fail_npy(name, "it holds " + std::to_string(data.size()) + " bytes of numbers where its header states " +
                       std::to_string(count * record));
  if (!header.fields.front().name.empty()) {
    if (header.shape.size() != 1)
      fail_npy(name, "its records are no list (one dimension)", ErrorKind::kUnsupported);
    for (const Field& field : header.fields) array.columns.push_back(field.name);
    array.shape = {count, header.fields.size()};
  }
  array.values.reserve(count * header.fields.size());
  const char* at = data.data();
  for (std::size_t i = 0; i < count; ++i)
    for (const Field& field : header.fields) {
      const double value = number_at(at, field.type);
      if (field.type.kind != 'f' && std::abs(value) > kMaxExact)
        fail_npy(name, "value " + std::to_string(i) + " is an integer beyond 2^53");
      array.values.push_back(value);
      at += field.type.bytes;
    }
  return array;
}

NpyArray load_npy(const std::filesystem::path& path) {
  return parse_npy(read_file(path), path.string());
}

std::string npy_head(const std::string& type, const std::string& shape) {
  std::string header = "{'descr': " + type + ", 'fortran_order': False, 'shape': (" + shape + "), }";
  const bool is_ascii = std::all_of(header.begin(), header.end(), [](char c) { return (c & 0x80) == 0; });
  const bool is_short = header.size() < 65000 && is_ascii;
  const std::size_t before = kMagic.size() + 2 + (is_short ? 2 : 4);
  // NumPy pads with blanks so that the numbers begin at a multiple of 64 bytes.
  header.append(63 - (before + header.size()) % 64, ' ');
  header += '\n';
  std::string bytes(kMagic);
  bytes += {is_short ? '\x01' : '\x03', '\x00'};
  for (int byte = 0; byte < (is_short ? 2 : 4); ++byte) bytes += char(header.size() >> (8 * byte) & 0xff);
  return bytes + header;
}

std::string format_npy(const NpyArray& array) {
  static_assert(std::numeric_limits<double>::is_iec559);
  std::size_t count = 1;
  for (const std::size_t side : array.shape) count *= side;
  require(!array.shape.empty() && count == array.values.size(), "format_npy: shape and values differ");
  require(array.columns.empty() || (array.shape.size() == 2 && array.columns.size() == array.shape[1]),
          "format_npy: one name a column");
  std::string type = "'<f8'", shape;
  if (array.columns.empty()) {
    for (const std::size_t side : array.shape) shape += std::to_string(side) + ", ";
  } else {
    type.clear();
    for (const std::string& column : array.columns)
      type += (type.empty() ? "[('" : ", ('") + column + "', '<f8')";
    type += "]";
    shape = std::to_string(array.shape[0]) + ",";
  }
  std::string bytes = npy_head(type, shape);
  const std::size_t begin = bytes.size();
  bytes.resize(begin + sizeof(double) * count);
  if (count > 0) std::memcpy(&bytes[begin], array.values.data(), sizeof(double) * count);
  return bytes;
}

}  // namespace procam::io
