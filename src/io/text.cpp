#include "procam/io/text.hpp"

#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>
#include <vector>

#include "number.hpp"
#include "procam/core/error.hpp"

namespace procam::io {
namespace {

/// factor = numerator / denominator: dividing by 1000 gives the double nearest to the decimal that was typed;
/// multiplying by 0.001 does not.
struct Unit {
  std::string_view name;
  double numerator, denominator;
};

constexpr double kPi = 3.141592653589793238462643383279502884;
constexpr Unit kLengthUnits[] = {{"mm", 1, 1000}, {"cm", 1, 100}, {"m", 1, 1}, {"in", 254, 10000}};
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
const char* const kBoardNext =
    "write chessboard:COLUMNSxROWS:SQUARE with the counts of inner corners, e.g. chessboard:7x9:75mm";

}  // namespace

ImageSize parse_size(const std::string& text) {
  const auto pair = parse_pair(text, 1 << 20);
  if (!pair)
    fail("size", text, "it is not two positive whole numbers of pixels", "write WIDTHxHEIGHT, e.g. 1024x768");
  return {pair->first, pair->second};
}

std::string format_size(ImageSize size) {
  return std::to_string(size.width) + "x" + std::to_string(size.height);
}

double parse_length(const std::string& text) {
  return parse_quantity("length", text, kLengthUnits, kLengthNext);
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

Board parse_board(const std::string& text) {
  const std::size_t first = text.find(':'), second = text.find(':', first + 1);
  if (first == std::string::npos || second == std::string::npos || first == second)
    fail("board", text, "it does not have three parts", kBoardNext);
  const std::string kind = text.substr(0, first);
  if (kind != "chessboard") fail("board", text, "there is no board of kind '" + kind + "'", kBoardNext);
  const auto counts = parse_pair(std::string_view(text).substr(first + 1, second - first - 1), 1000);
  if (!counts || counts->first < 2 || counts->second < 2)
    fail("board", text, "its counts are not two whole numbers of at least 2 inner corners", kBoardNext);
  double square_size = 0;
  try {
    square_size = parse_length(text.substr(second + 1));
  } catch (const Error& error) {
    fail("board", text, "its square size is no length: " + error.why(), kBoardNext);
  }
  if (!(square_size > 0)) fail("board", text, "its squares have no positive size", kBoardNext);
  return Chessboard{counts->first, counts->second, square_size};
}

std::string format_board(const Board& board) {
  const auto& chessboard = std::get<Chessboard>(board);
  return "chessboard:" + std::to_string(chessboard.columns) + "x" + std::to_string(chessboard.rows) + ":" +
         format_length(chessboard.square_size);
}

}  // namespace procam::io
