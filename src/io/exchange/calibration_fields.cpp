#include "exchange/calibration_fields.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <iterator>

#include "document/size_check.hpp"
#include "document/trimmed.hpp"
#include "procam/core/base/limits.hpp"

namespace procam::io::calibration {

std::optional<Value> find(const Value& object, const Names& names) {
  const Node& node = *object.node;
  if (node.kind != Node::Kind::kObject && node.kind != Node::Kind::kElement) return std::nullopt;
  for (const char* const name : names)
    for (const Node& child : node.children)
      if (child.name == name)
        return Value{&child, object.file, object.path.empty() ? child.name : object.path + "." + child.name};
  return std::nullopt;
}

namespace {

std::string plain_spelling(const std::string& name) {
  std::string plain;
  for (const char c : name)
    if (c != '_' && c != '-' && c != ' ') plain += char(std::tolower(static_cast<unsigned char>(c)));
  return plain;
}

}  // namespace

std::optional<Value> find_spelled(const Value& object, const Names& names) {
  if (!is_group(object)) return std::nullopt;
  for (const char* const name : names)
    for (const Node& child : object.node->children)
      if (plain_spelling(child.name) == name)
        return Value{&child, object.file, object.path.empty() ? child.name : object.path + "." + child.name};
  return std::nullopt;
}

Value require_member(const Value& object, const Names& names, const char* next) {
  const auto found = find(object, names);
  if (!found) object.fail(std::string("the field '") + names.front() + "' is missing", next);
  return *found;
}

double require_number(const Value& object, const Names& names) {
  return require_member(object, names).number();
}

bool is_group(const Value& value) {
  return value.node->kind == Node::Kind::kObject || value.node->kind == Node::Kind::kElement;
}

bool is_set(const std::optional<Value>& flag) {
  if (!flag) return false;
  if (flag->node->kind == Node::Kind::kBool) return flag->boolean();
  const std::string word = flag->node->kind == Node::Kind::kText ? plain_spelling(flag->text()) : "";
  if (word == "true" || word == "false") return word == "true";
  return flag->number() != 0;
}

Numbers numbers_of(const Value& value) {
  Numbers out;
  if (const auto data = find(value, {"data"}); data && is_group(value)) {
    const auto side = [&](const Names& names) {
      const auto found = find(value, names);
      if (!found) value.fail("its number of " + std::string(names.front()) + " is missing", kNextCalibration);
      const double number = found->number();
      if (number != std::floor(number) || number < 1 || number > double(limits::kMatrixNumbers))
        found->fail("it is no number of rows or columns", kNextCalibration);
      return std::size_t(number);
    };
    out.rows = side({"rows"});
    out.columns = side({"cols", "columns"});
    out.values = data->numbers();
    if (out.values.size() != out.rows * out.columns)
      data->fail("it has " + std::to_string(out.values.size()) + " numbers where its rows and columns make " +
                     std::to_string(out.rows * out.columns),
                 kNextCalibration);
    return out;
  }
  const bool of_rows = value.node->kind == Node::Kind::kList && !value.node->children.empty() &&
                       value.node->children.front().kind == Node::Kind::kList;
  if (!of_rows) {
    out.values = value.numbers();
    return out;
  }
  for (const Value& row : value.items("row")) {
    const std::vector<double> numbers = row.numbers();
    if (out.rows > 0 && numbers.size() != out.columns)
      row.fail("its rows have different lengths", kNextCalibration);
    out.columns = numbers.size();
    ++out.rows;
    out.values.insert(out.values.end(), numbers.begin(), numbers.end());
    if (out.values.size() > limits::kMatrixNumbers)
      value.fail("it is too large for a calibration's matrix", kNextCalibration);
  }
  return out;
}

MatX matrix_of(const Value& value, std::size_t rows, std::size_t columns) {
  const Numbers found = numbers_of(value);
  const std::string wanted = std::to_string(rows) + "x" + std::to_string(columns);
  if (found.values.size() != rows * columns || (found.rows > 0 && found.rows != rows))
    value.fail(
        "it is not " + wanted + " numbers" +
            (found.rows > 0 ? " but " + std::to_string(found.rows) + "x" + std::to_string(found.columns)
                            : " but " + std::to_string(found.values.size())),
        kNextCalibration);
  MatX out{Eigen::Index(rows), Eigen::Index(columns)};
  for (std::size_t i = 0; i < found.values.size(); ++i)
    out(Eigen::Index(i / columns), Eigen::Index(i % columns)) = found.values[i];
  return out;
}

Intrinsics intrinsics_of(const Value& value) {
  const Numbers found = numbers_of(value);
  Intrinsics k;
  if (found.values.size() == 4 && found.rows <= 1) {  // fx fy cx cy
    k = {found.values[0], found.values[1], found.values[2], found.values[3], 0};
  } else {
    const Mat3 matrix = matrix_of(value, 3, 3);
    if (matrix(1, 0) != 0 || matrix(2, 0) != 0 || matrix(2, 1) != 0 || matrix(2, 2) != 1)
      value.fail("it is not [fx skew cx; 0 fy cy; 0 0 1]", kNextCalibration);
    k = Intrinsics::from_matrix(matrix);
  }
  check_focal_lengths(value, k);
  return k;
}

void check_focal_lengths(const Value& where, const Intrinsics& intrinsics) {
  if (!(intrinsics.fx > 0 && intrinsics.fy > 0))
    where.fail("its focal lengths are not positive", kNextCalibration);
}

namespace {

/// A whole number of pixels.
int side_of(const Value& value, double number) {
  if (number != std::floor(number) || number < 1 || number > limits::kSizeSide)
    value.fail("it is not a whole number of pixels from 1 to " + std::to_string(limits::kSizeSide),
               kNextCalibration);
  return int(number);
}

}  // namespace

ImageSize size_in(const Value& value, double width, double height) {
  const ImageSize size{side_of(value, width), side_of(value, height)};
  if (const auto why = flaw(size)) value.fail(*why, kNextCalibration);
  return size;
}

std::optional<ImageSize> size_of(const Value& camera) {
  const auto width = find_spelled(camera, {"imagewidth", "width", "framewidth", "framew"});
  const auto height = find_spelled(camera, {"imageheight", "height", "frameheight", "frameh"});
  if (width && height) return size_in(*width, width->number(), height->number());
  if (const auto size = find_spelled(camera, {"imagesize", "cameraresolution", "size", "resolution"})) {
    if (is_group(*size) && !find(*size, {"data"})) return size_of(*size);
    const std::vector<double> sides = numbers_of(*size).values;
    if (sides.size() != 2) size->fail("it is not a width and a height", kNextCalibration);
    return size_in(*size, sides[0], sides[1]);
  }
  if (const auto shape = find(camera, {"img_shape"})) {  // as numpy counts: rows, columns (, channels)
    const std::vector<double> sides = numbers_of(*shape).values;
    if (sides.size() != 2 && sides.size() != 3)
      shape->fail("it is not the rows and columns of an image", kNextCalibration);
    return size_in(*shape, sides[1], sides[0]);
  }
  return std::nullopt;
}

ImageSize required_size(const std::optional<ImageSize>& in_file, const std::optional<ImageSize>& given,
                        const Value& where, const char* device) {
  if (in_file) return *in_file;
  if (given) return *given;
  where.fail(std::string("it does not state the size of the ") + device + "'s image",
             std::string("give --") + device + "-size, e.g. 1280x1024");
}

namespace {

/// Names of lens models, of all programs.
struct LensName {
  const char* name;
  bool fisheye;
  std::size_t max_coefficients;
};
constexpr LensName kLensNames[] = {
    {"plumb_bob", false, 5},
    {"radtan", false, 5},
    {"radial-tangential", false, 5},
    {"opencv", false, 8},
    {"rational_polynomial", false, 8},
    {"equidistant", true, 4},
    {"equi", true, 4},
    {"kannala_brandt", true, 4},
    {"fisheye", true, 4},
    {"pinhole", false, 8},
    {"none", false, 0},
};

}  // namespace

namespace {

/// k1 k2 p1 p2 k3 [k4 k5 k6], or the k1 k2 k3 k4 of a fisheye lens, by name.
std::vector<double> named_coefficients(const Value& group, bool fisheye, bool states_model) {
  const auto term = [&](const char* name) {
    const auto found = find(group, {name});
    return found ? found->number() : 0.0;
  };
  if (fisheye) {
    if (term("p1") != 0 || term("p2") != 0 || !find(group, {"k4"}))
      group.fail("an equidistant lens has the coefficients k1, k2, k3 and k4", kNextCalibration);
    return {term("k1"), term("k2"), term("k3"), term("k4")};
  }
  if (term("k4") != 0 && !find(group, {"p1"}) && !states_model)
    group.fail("it does not say which lens its k1 to k4 are of",
               "add distortion_model: equidistant (a fisheye), or rational_polynomial");
  std::vector<double> found{term("k1"), term("k2"), term("p1"), term("p2"), term("k3")};
  if (term("k4") != 0 || term("k5") != 0 || term("k6") != 0)
    found.insert(found.end(), {term("k4"), term("k5"), term("k6")});
  return found;
}

}  // namespace

Distortion distortion_of(const Value& camera, const std::optional<Value>& coefficients,
                         const std::optional<Value>& model, bool fisheye) {
  std::size_t most = 8;
  const bool states_model = model && !trimmed(model->text()).empty();
  if (states_model) {
    const std::string name = trimmed(model->text());
    const auto known = std::find_if(std::begin(kLensNames), std::end(kLensNames),
                                    [&](const LensName& lens) { return name == lens.name; });
    if (known == std::end(kLensNames)) {
      std::vector<std::string> names;
      for (const LensName& lens : kLensNames) names.emplace_back(lens.name);
      model->fail("procam has no lens model '" + name.substr(0, 40) + "'", suggest(name, names),
                  ErrorKind::kUnsupported);
    }
    fisheye = known->fisheye;
    most = known->max_coefficients;
  }
  std::vector<double> found;
  if (coefficients && is_group(*coefficients) && !find(*coefficients, {"data"}))
    found = named_coefficients(*coefficients, fisheye, states_model);
  else if (coefficients && coefficients->node->kind != Node::Kind::kNull)
    found = numbers_of(*coefficients).values;
  if (states_model && !coefficients && !fisheye && trimmed(model->text()) != "pinhole" && most > 0)
    camera.fail("it names the lens model '" + trimmed(model->text()) + "', and its coefficients are missing",
                "add distortion_coefficients, or the model none");
  const auto is_zero = [](double c) { return c == 0; };
  if (fisheye) {
    if (found.size() != 4)
      (coefficients ? *coefficients
       : model      ? *model
                    : camera)
          .fail("an equidistant lens has 4 coefficients, not " + std::to_string(found.size()),
                kNextCalibration);
    return with_coefficients(FisheyeDistortion{}, found);
  }
  if (found.size() > most) {
    if (!std::all_of(found.begin() + long(most), found.end(), is_zero))
      coefficients->fail("it has " + std::to_string(found.size()) + " coefficients; the lens model ends at " +
                             std::to_string(most),
                         found.size() <= 8 ? "name the model whose they are: rational_polynomial has 8"
                                           : "calibrate again without the thin prism and tilted models",
                         ErrorKind::kUnsupported);
    found.resize(most);
  }
  if (std::all_of(found.begin(), found.end(), is_zero)) return NoDistortion{};
  if (found.size() < 4 && found.size() != 2)
    coefficients->fail(
        "it has " + std::to_string(found.size()) + " coefficients where k1 k2 p1 p2 are the least",
        kNextCalibration);
  found.resize(8, 0.0);
  if (std::all_of(found.begin() + 5, found.end(), is_zero))
    return with_coefficients(BrownConrady{}, {found.begin(), found.begin() + 5});
  return with_coefficients(RationalDistortion{}, found);
}

void refuse_unread_distortion(const Value& camera) {
  for (const Node& child : camera.node->children) {
    const std::string name = plain_spelling(child.name);
    const Value member{&child, camera.file,
                       camera.path.empty() ? child.name : camera.path + "." + child.name};
    const bool holds_numbers = child.kind == Node::Kind::kList || is_group(member);
    const bool says_distortion = name.find("distort") != name.npos && name.find("undistort") == name.npos;
    if (holds_numbers && (says_distortion || (name.rfind("dist", 0) == 0 && name.rfind("distance", 0) != 0)))
      member.fail("procam does not know this name, and the lens's distortion seems to be under it",
                  "call it distortion_coefficients, or remove it if it is something else");
  }
}

bool is_rotation(const Mat3& matrix) {
  constexpr double kRounding = 5e-5;
  return (matrix * matrix.transpose() - Mat3::Identity()).norm() < kRounding && matrix.determinant() > 0;
}

Pose rigid_transform_of(const Value& matrix, const char* next) {
  const Mat4 transform = matrix_of(matrix, 4, 4);
  const Mat3 r = transform.topLeftCorner<3, 3>();
  if (!is_rotation(r) || transform.row(3) != Eigen::RowVector4d(0, 0, 0, 1))
    matrix.fail("it is not a rigid transform", next);
  return Pose(r, Vec3(transform.topRightCorner<3, 1>()));
}

}  // namespace procam::io::calibration
