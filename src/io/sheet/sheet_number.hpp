#pragma once
/// Lengths in drawings: plain decimals of a fixed fineness, the same on every machine.
#include <charconv>
#include <string>

namespace procam::io {

/// At most `digits` after the point, no exponent, no zeros at the end.
inline std::string plain_decimal(double value, int digits) {
  char text[64];
  const auto [end, error] = std::to_chars(text, text + sizeof text, value, std::chars_format::fixed, digits);
  std::string number(text, error == std::errc() ? end : text);
  if (number.find('.') != std::string::npos) {
    number.erase(number.find_last_not_of('0') + 1);
    if (number.back() == '.') number.pop_back();
  }
  return number == "-0" ? "0" : number;
}

/// Metres in millimetres, to a tenth of a micrometre: far below any printer.
inline std::string millimetres(double metres) {
  return plain_decimal(1000 * metres, 4);
}

}  // namespace procam::io
