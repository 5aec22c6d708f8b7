#pragma once
/// Words of the report page: text that is escaped, shapes of SVG.
#include <string>

#include "procam/core/base/types.hpp"
#include "procam/core/base/words.hpp"

namespace procam::report {

/// Text that may stand between tags and inside quoted attributes.
std::string escaped(const std::string& text);

/// A residual's length, to a thousandth; a fit without noise shows its order of magnitude.
std::string pixels(double value);
/// Decimals that show two digits of a standard deviation; `otherwise` when it says nothing.
int decimals_for(double sigma, int otherwise);
/// The largest of 1, 2, 5 times a power of ten that is not above a positive value.
double round_step(double value);

/// <name attributes>content</name>
std::string element(const std::string& name, const std::string& attributes, const std::string& content);

/// A coordinate of a picture: one decimal, without a trailing ".0".
std::string coordinate(double value);
/// "x y"
std::string position(const Vec2& point);

/// The d of an SVG path that is made of many small marks of one colour.
struct Marks {
  std::string d;

  void dot(const Vec2& at) { d += "M" + position(at) + "h0"; }  ///< round, by the line's cap
  void line(const Vec2& from, const Vec2& to) { d += "M" + position(from) + "L" + position(to); }
  void cross(const Vec2& at, double arm) {
    line(at - Vec2(arm, arm), at + Vec2(arm, arm));
    line(at - Vec2(arm, -arm), at + Vec2(arm, -arm));
  }
  /// The path, or nothing when there is no mark; `tip` is shown under a resting pointer.
  std::string path(const std::string& attributes, const std::string& tip = "") const;
};

/// <text> at a place, its words escaped.
std::string label(const Vec2& at, const std::string& attributes, const std::string& words);

/// A picture of the report: <figure> with its caption below.
std::string figure(const std::string& svg, const std::string& caption, const std::string& attributes = "");
/// <svg> that a screen reader can tell; `view_box` is "x y width height".
std::string svg(const std::string& view_box, const std::string& description, const std::string& content);
/// "x y width height" of a corner and a size.
std::string box(const Vec2& corner, const Vec2& size);
std::string rectangle(const std::string& attributes, const Vec2& corner, const Vec2& size);
std::string circle(const std::string& attributes, const Vec2& at, double radius);

}  // namespace procam::report
