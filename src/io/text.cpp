#include "procam/io/text.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>
#include <vector>

#include "document/number.hpp"
#include "document/size_check.hpp"
#include "procam/core/base/detail/edit_distance.hpp"
#include "procam/core/base/error.hpp"
#include "procam/core/base/limits.hpp"
#include "procam/core/base/words.hpp"

namespace procam::io {
namespace {

/// factor = numerator / denominator: dividing by 1000 gives the double nearest to the decimal that was typed;
/// multiplying by 0.001 does not.
struct Unit {
  std::string_view name;
  double numerator, denominator;
};

constexpr Unit kLengthUnits[] = {{"mm", 1, 1000}, {"cm", 1, 100}, {"m", 1, 1}, {"in", 254, 10000}};
constexpr Unit kPixelUnits[] = {{"px", 1, 1}};
constexpr Unit kDurationUnits[] = {{"ms", 1, 1000}, {"s", 1, 1}};
constexpr Unit kAngleUnits[] = {{"deg", kPi, 180}, {"rad", 1, 1}};

[[noreturn]] void fail(const char* noun, const std::string& text, const std::string& why,
                       const std::string& next) {
  throw Error(ErrorKind::kInput, std::string(noun) + " '" + text + "'", why, next);
}

template <std::size_t Count>
double parse_quantity(const char* noun, const std::string& text, const Unit (&units)[Count],
                      const char* next) {
  const std::size_t unit_begin = text.find_last_of("0123456789.") + 1;  // 0 when there is no number
  const std::string_view number(text.data(), unit_begin);
  const std::string_view name = std::string_view(text).substr(unit_begin);
  const std::optional<double> value = parse_number(number);
  if (!value) fail(noun, text, "it does not begin with a number", next);
  if (name.empty()) fail(noun, text, "the unit is missing", next);
  for (const Unit& unit : units)
    if (unit.name == name) return *value * unit.numerator / unit.denominator;
  fail(noun, text, "there is no unit '" + std::string(name) + "' here", next);
}

/// "7x9" -> 7, 9; nullopt unless both are whole numbers from 1 to `largest`.
std::optional<std::pair<int, int>> parse_pair(std::string_view text, int largest) {
  int values[2];
  const std::size_t cross = text.find('x');
  if (cross == std::string_view::npos) return std::nullopt;
  const std::string_view parts[2] = {text.substr(0, cross), text.substr(cross + 1)};
  for (int i = 0; i < 2; ++i) {
    const char* const end = parts[i].data() + parts[i].size();
    const auto [stop, error] = std::from_chars(parts[i].data(), end, values[i]);
    if (error != std::errc() || stop != end || values[i] < 1 || values[i] > largest) return std::nullopt;
  }
  return std::pair(values[0], values[1]);
}

const char* const kLengthNext = "write a number and mm, cm, m or in, e.g. 25mm";
/// A kind of board as it is typed, and what stands between the colons after the counts.
struct BoardKind {
  const char* name;
  const char* form;
};

const BoardKind kBoardKinds[] = {
    {"chessboard",
     "write chessboard:COLUMNSxROWS:SQUARE with the counts of inner corners, e.g. chessboard:7x9:75mm"},
    {"charuco",
     "write charuco:COLUMNSxROWS:SQUARE:MARKER:DICTIONARY with the counts of squares, e.g. "
     "charuco:5x7:40mm:30mm:5x5_100"},
    {"markers",
     "write markers:COLUMNSxROWS:MARKER:GAP:DICTIONARY with the counts of markers, e.g. "
     "markers:4x5:30mm:8mm:apriltag_36h11"},
    {"circles", "write circles:COLUMNSxROWS:SPACING:DIAMETER, e.g. circles:7x9:25mm:15mm"},
    {"asymmetric-circles",
     "write asymmetric-circles:COLUMNSxROWS:SPACING:DIAMETER with SPACING from row to row, e.g. "
     "asymmetric-circles:4x11:20mm:12mm"},
    {"aprilgrid",
     "write aprilgrid:COLUMNSxROWS:TAG:SPACING with the counts of tags and the spacing as a share of a tag, "
     "e.g. aprilgrid:6x6:88mm:0.3"},
};

/// The parts of a board's text, each taken once and complained about in its own words.
class BoardText {
 public:
  BoardText(const std::string& text, BoardUnit unit) : text_(text), unit_(unit) {
    for (std::size_t begin = 0; begin <= text.size();) {
      const std::size_t end = std::min(text.find(':', begin), text.size());
      parts_.push_back(text.substr(begin, end - begin));
      begin = end + 1;
    }
    for (const BoardKind& kind : kBoardKinds)
      if (parts_[0] == kind.name) form_ = kind.form;
    if (form_ != nullptr) return;
    std::vector<std::string> names;
    for (const BoardKind& kind : kBoardKinds) names.emplace_back(kind.name);
    fail("board", text_, "there is no board of kind '" + parts_[0] + "'",
         internal::did_you_mean(parts_[0], names) + "the kinds are " + comma_list(names) + "; " +
             kBoardKinds[0].form + ", or name a board file (.json, or a target of Kalibr, .yaml)");
  }

  const std::string& kind() const { return parts_[0]; }
  [[noreturn]] void refuse(const std::string& why) const { fail("board", text_, why, form_); }

  void require_parts(std::size_t at_least, std::size_t at_most) const {
    if (parts_.size() >= at_least && parts_.size() <= at_most) return;
    refuse("it does not have " + std::to_string(at_least) + " parts between colons");
  }
  bool has(std::size_t part) const { return part < parts_.size(); }
  const std::string& part(std::size_t i) const { return parts_[i]; }

  std::pair<int, int> counts() const {
    const auto pair = parse_pair(parts_[1], 1000);
    if (!pair) refuse("its counts are not two positive whole numbers");
    return *pair;
  }
  double length(std::size_t part, const char* what) const {
    try {
      return unit_ == BoardUnit::kMetric
                 ? parse_length(parts_[part])
                 : parse_quantity("length", parts_[part], kPixelUnits, "write a number and px, e.g. 64px");
    } catch (const Error& error) {
      refuse("its " + std::string(what) + " is no length: " + error.why());
    }
  }
  double share(std::size_t part, const char* what) const {
    const auto number = parse_number(parts_[part]);
    if (!number) refuse("its " + std::string(what) + " is no number");
    return *number;
  }
  MarkerDictionary dictionary(std::size_t part) const {
    if (const auto found = marker_dictionary_named(parts_[part])) return *found;
    std::vector<std::string> names;
    for (const MarkerDictionaryInfo& info : kMarkerDictionaries) names.emplace_back(info.name);
    fail("board", text_, "there is no dictionary '" + parts_[part] + "'",
         internal::did_you_mean(parts_[part], names) + "the dictionaries are " + comma_list(names) + "; " +
             form_);
  }

 private:
  const std::string& text_;
  BoardUnit unit_;
  std::vector<std::string> parts_;
  const char* form_ = nullptr;
};

constexpr const char* kMarkerFirst = "marker-first";

std::string counts(int columns, int rows) {
  return std::to_string(columns) + "x" + std::to_string(rows);
}

/// A board as text, its lengths by a function of the unit.
struct BoardWriter {
  std::string (*length)(double);

  std::string operator()(const Chessboard& b) const {
    return "chessboard:" + counts(b.columns, b.rows) + ":" + length(b.square_size);
  }
  std::string operator()(const CharucoBoard& b) const {
    return "charuco:" + counts(b.columns, b.rows) + ":" + length(b.square_size) + ":" +
           length(b.marker_size) + ":" + info_of(b.dictionary).name +
           (b.marker_first ? std::string(":") + kMarkerFirst : "");
  }
  std::string operator()(const MarkerGrid& b) const {
    return "markers:" + counts(b.columns, b.rows) + ":" + length(b.marker_size) + ":" + length(b.gap) + ":" +
           info_of(b.dictionary).name;
  }
  std::string operator()(const CircleGrid& b) const {
    return (b.asymmetric ? "asymmetric-circles:" : "circles:") + counts(b.columns, b.rows) + ":" +
           length(b.spacing) + ":" + length(b.diameter);
  }
  std::string operator()(const AprilGrid& b) const {
    return "aprilgrid:" + counts(b.columns, b.rows) + ":" + length(b.tag_size) + ":" +
           format_number(b.spacing);
  }
};

std::string format_pixels(double pixels) {
  return format_number(pixels) + "px";
}

}  // namespace

ImageSize parse_size(const std::string& text) {
  const auto pair = parse_pair(text, limits::kSizeSide);
  if (!pair)
    fail("size", text, "it is not two positive whole numbers of pixels", "write WIDTHxHEIGHT, e.g. 1024x768");
  const ImageSize size{pair->first, pair->second};
  if (const auto why = flaw(size)) fail("size", text, *why, "write WIDTHxHEIGHT, e.g. 1024x768");
  return size;
}

std::string format_size(ImageSize size) {
  return std::to_string(size.width) + "x" + std::to_string(size.height);
}

Uncertain parse_uncertain(const std::string& text) {
  const char* const next = "write a number, or a number and its sigma, e.g. 1.4+-0.02";
  const std::size_t mark = text.find("+-");
  const std::optional<double> value = parse_number(text.substr(0, mark));
  const std::optional<double> sigma = mark == std::string::npos ? 0 : parse_number(text.substr(mark + 2));
  if (!value || !sigma) fail("value", text, "it is no number", next);
  if (mark != std::string::npos && !(*sigma > 0)) fail("value", text, "its sigma is not positive", next);
  return {*value, *sigma};
}

double parse_length(const std::string& text) {
  const double metres = parse_quantity("length", text, kLengthUnits, kLengthNext);
  if (!(std::abs(metres) <= limits::kLengthM)) fail("length", text, "it is beyond 1000 km", kLengthNext);
  return metres;
}

std::string format_length(double metres) {
  const std::string in_mm = format_number(metres * 1000);
  if (parse_number(in_mm).value_or(NAN) / 1000 == metres && in_mm.find('e') == std::string::npos)
    return in_mm + "mm";
  return format_number(metres) + "m";
}

double parse_angle(const std::string& text) {
  return parse_quantity("angle", text, kAngleUnits, "write a number and deg or rad, e.g. 30deg");
}

double parse_pixels(const std::string& text) {
  return parse_quantity("pixels", text, kPixelUnits, "write a number and px, e.g. 3px");
}

double parse_share(const std::string& text) {
  const bool percent = !text.empty() && text.back() == '%';
  const std::optional<double> value =
      parse_number(std::string_view(text).substr(0, text.size() - std::size_t(percent)));
  if (!value || !std::isfinite(*value)) fail("number", text, "it is not a number", "write e.g. 0.04 or 4%");
  return percent ? *value / 100 : *value;
}

double parse_duration(const std::string& text) {
  const char* const next = "write a number and ms or s, e.g. 50ms";
  const double seconds = parse_quantity("duration", text, kDurationUnits, next);
  if (seconds < 0) fail("duration", text, "it is negative", next);
  if (!(seconds <= limits::kDurationS)) fail("duration", text, "it is beyond 31 years", next);
  return seconds;
}

double parse_delay(const std::string& text) {
  const double seconds = parse_duration(text);
  if (seconds > limits::kDelayS)
    fail("delay", text, "no device is later than 10 s", "write a number and ms or s, e.g. 50ms");
  return seconds;
}

namespace {

/// Two quantities with a comma between; `per` follows each of their units.
LengthAndAngle parse_both(const std::string& text, const std::string& per, const char* noun,
                          const char* next) {
  LengthAndAngle both;
  bool has_length = false, has_angle = false;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    std::string part = text.substr(begin, end - begin);
    begin = end + 1;
    if (part.size() < per.size() || part.compare(part.size() - per.size(), per.size(), per) != 0)
      fail(noun, text, "'" + part + "' does not end with '" + per + "'", next);
    part.resize(part.size() - per.size());
    const bool is_angle = part.size() > 3 && (part.compare(part.size() - 3, 3, "deg") == 0 ||
                                              part.compare(part.size() - 3, 3, "rad") == 0);
    bool& has = is_angle ? has_angle : has_length;
    if (has) fail(noun, text, std::string("it has two ") + (is_angle ? "angles" : "lengths"), next);
    has = true;
    const double value = is_angle ? parse_angle(part) : parse_length(part);
    if (value < 0) fail(noun, text, "'" + part + "' is negative", next);
    (is_angle ? both.angle : both.length) = value;
  }
  return both;
}

}  // namespace

Vec3 parse_direction(const std::string& text) {
  Vec3 direction;
  const char* at = text.c_str();
  bool read = true;
  for (int k = 0; k < 3; ++k) {
    char* end = nullptr;
    direction[k] = std::strtod(at, &end);
    read = read && end != at && *end == (k < 2 ? ',' : 0);
    if (!read) break;
    at = end + 1;
  }
  if (!read || !direction.allFinite() || !(direction.norm() > 1e-6))
    throw Error(ErrorKind::kInput, "direction '" + text + "'",
                "it is not three numbers x,y,z other than 0,0,0", "give e.g. 0,0,1");
  return direction.normalized();
}

Vec3 parse_position(const std::string& text) {
  Vec3 position;
  std::size_t from = 0;
  for (int k = 0; k < 3; ++k) {
    const std::size_t comma = text.find(',', from);
    if ((comma == std::string::npos) != (k == 2))
      throw Error(ErrorKind::kInput, "'" + text + "'", "it is not X,Y,Z",
                  "give three lengths with their units: 0.4m,-120mm,2m");
    position[k] = parse_length(text.substr(from, comma - from));
    from = comma + 1;
  }
  return position;
}

LengthAndAngle parse_length_and_angle(const std::string& text) {
  return parse_both(text, "", "sigmas", "write a length and an angle, e.g. 10mm,0.5deg, or one of them");
}

LengthAndAngle parse_speed(const std::string& text) {
  return parse_both(text, "/s", "speed", "write e.g. 0.5m/s,30deg/s, or one of them");
}

Board parse_board(const std::string& text, BoardUnit unit) {
  const BoardText spec(text, unit);
  const auto read = [&]() -> Board {
    if (spec.kind() == "chessboard") {
      spec.require_parts(3, 3);
      const auto [columns, rows] = spec.counts();
      return Chessboard{columns, rows, spec.length(2, "square size")};
    }
    if (spec.kind() == "charuco") {
      spec.require_parts(5, 6);
      const auto [columns, rows] = spec.counts();
      if (spec.has(5) && spec.part(5) != kMarkerFirst)
        spec.refuse("its last part is not '" + std::string(kMarkerFirst) + "' but '" + spec.part(5) + "'");
      return CharucoBoard{
          columns,    rows, spec.length(2, "square size"), spec.length(3, "marker size"), spec.dictionary(4),
          spec.has(5)};
    }
    if (spec.kind() == "markers") {
      spec.require_parts(5, 5);
      const auto [columns, rows] = spec.counts();
      return MarkerGrid{columns, rows, spec.length(2, "marker size"), spec.length(3, "gap"),
                        spec.dictionary(4)};
    }
    spec.require_parts(4, 4);
    const auto [columns, rows] = spec.counts();
    if (spec.kind() == "aprilgrid")
      return AprilGrid{columns, rows, spec.length(2, "tag size"), spec.share(3, "spacing")};
    return CircleGrid{columns, rows, spec.length(2, "spacing"), spec.length(3, "diameter"),
                      spec.kind() == "asymmetric-circles"};
  };
  const Board board = read();
  if (const std::string why = flaw(board); !why.empty()) spec.refuse(why);
  return board;
}

std::string format_board(const Board& board, BoardUnit unit) {
  return std::visit(BoardWriter{unit == BoardUnit::kMetric ? format_length : format_pixels}, board);
}

Device parse_device(const std::string& text, DeviceKind kind) {
  const std::size_t equals = text.find('=');
  const std::string name = equals == std::string::npos
                               ? (kind == DeviceKind::kCamera ? "camera" : "projector")
                               : text.substr(0, equals);
  if (name.empty())
    throw Error(ErrorKind::kInput, "'" + text + "'", "the device's name is empty",
                "give e.g. left=1280x1024");
  return {name, kind, parse_size(equals == std::string::npos ? text : text.substr(equals + 1))};
}

}  // namespace procam::io
