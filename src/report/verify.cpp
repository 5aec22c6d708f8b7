#include <algorithm>
#include <cmath>

#include "html.hpp"
#include "procam/core/base/closed_form.hpp"
#include "procam/report/verify.hpp"

namespace procam::report {

using analyze::VerifiedMark;
using analyze::VerifyResult;
namespace {

constexpr double kSheetWidth = 900, kSheetRim = 30, kHead = 34, kSheetFoot = 96;
constexpr double kChiSquare95 = 5.991464547107979;  ///< two degrees of freedom

/// Surface metres to picture units; x right, y down as the content is read.
struct SurfaceFrame {
  Vec2 low, high;
  double units_per_metre;
  Vec2 at(const Vec2& p) const { return Vec2(kSheetRim, kHead + kSheetRim) + units_per_metre * (p - low); }
  double height() const { return kHead + 2 * kSheetRim + units_per_metre * (high.y() - low.y()); }
};

SurfaceFrame frame_round(const VerifyResult& result, const Points2& content) {
  SurfaceFrame frame{Vec2::Constant(1e300), Vec2::Constant(-1e300), 1};
  const auto include = [&](const Vec2& p) {
    frame.low = frame.low.cwiseMin(p);
    frame.high = frame.high.cwiseMax(p);
  };
  for (const Vec2& corner : content) include(corner);
  for (const VerifiedMark& mark : result.marks)
    if (!mark.intended.isZero(0)) include(mark.intended);
  const Vec2 rim = 0.06 * (frame.high - frame.low).cwiseMax(1e-3);
  frame.low -= rim, frame.high += rim;
  frame.units_per_metre = (kSheetWidth - 2 * kSheetRim) / (frame.high.x() - frame.low.x());
  return frame;
}

/// Such that the larger errors fill two thirds of the gaps between marks.
double magnification_of(const VerifyResult& result, const SurfaceFrame& frame) {
  const double gap = std::sqrt((frame.high - frame.low).prod() / double(result.marks.size()));
  double sigma = 0;
  for (const VerifiedMark& mark : result.marks)
    if (mark.rejection.empty()) sigma = std::max(sigma, std::sqrt(kChiSquare95 * mark.covariance.trace()));
  const double largest = std::max({result.worst, 0.5 * sigma, 1e-7});
  return std::max(1.0, round_step(0.67 * gap / largest));
}

std::string arrow(const Vec2& from, const Vec2& to, const std::string& attributes) {
  const Vec2 along = to - from;
  const double length = along.norm();
  Marks marks;
  marks.line(from, to);
  if (length > 1) {
    const Vec2 back = -along / length * std::min(6.0, 0.4 * length), side(-back.y(), back.x());
    marks.line(to, to + back + 0.5 * side);
    marks.line(to, to + back - 0.5 * side);
  }
  return marks.path(attributes);
}

std::string region(const Vec2& at, const Mat2& covariance, double scale) {
  const SymmetricEigen2 eigen = symmetric_eigen(covariance);
  const auto half = [&](int i) {
    return fixed(scale * std::sqrt(kChiSquare95 * std::max(eigen.values[i], 0.0)), 2);
  };
  const double turn = std::atan2(eigen.vectors(1, 0), eigen.vectors(0, 0)) * 180 / std::acos(-1.0);
  return element("ellipse",
                 "rx=\"" + half(0) + "\" ry=\"" + half(1) + "\" transform=\"translate(" + position(at) +
                     ") rotate(" + fixed(turn, 1) + ")\" fill=\"#8a8f98\" fill-opacity=\"0.25\"",
                 "");
}

constexpr const char* kBefore = "fill=\"none\" stroke=\"#c62f2f\" stroke-width=\"1.3\"";
constexpr const char* kAfter = "fill=\"none\" stroke=\"#1b7f3b\" stroke-width=\"1.3\"";
constexpr const char* kRejected = "fill=\"none\" stroke=\"#b58900\" stroke-width=\"1.3\"";

bool is_corrected(const VerifyResult& result) {
  return result.rig || result.rig_from_surface;
}

std::string content_outline(const Points2& content, const SurfaceFrame& frame) {
  std::string outline = "M";
  for (std::size_t i = 0; i < content.size(); ++i)
    outline += (i > 0 ? "L" : "") + position(frame.at(content[i]));
  return element("path", "d=\"" + outline + "Z\" fill=\"#f4f6f9\" stroke=\"#9aa3ad\"", "");
}

/// Every mark's error as an arrow, `scale` units a metre, with the region of what would be no surprise.
std::string mark_errors(const VerifyResult& result, const SurfaceFrame& frame, double scale) {
  std::string drawing, arrows;
  Marks rejected;
  for (const VerifiedMark& mark : result.marks) {
    if (mark.intended.isZero(0)) continue;  // its light misses the surface
    const Vec2 at = frame.at(mark.intended);
    if (!mark.rejection.empty()) {
      rejected.cross(at, 4);
      continue;
    }
    drawing += region(at, mark.covariance, scale);
    arrows += arrow(at, at + scale * mark.error, kBefore);
    if (is_corrected(result)) arrows += arrow(at, at + scale * mark.error_after, kAfter);
  }
  return drawing + arrows + rejected.path(kRejected);
}

std::string largest_error(const VerifyResult& result, const SurfaceFrame& frame) {
  const auto largest = std::max_element(
      result.marks.begin(), result.marks.end(), [](const VerifiedMark& a, const VerifiedMark& b) {
        return (a.rejection.empty() ? a.error.norm() : -1) < (b.rejection.empty() ? b.error.norm() : -1);
      });
  if (!largest->rejection.empty()) return "";
  return label(frame.at(largest->intended) + Vec2(6, 14),
               "font-family=\"sans-serif\" font-size=\"12\" fill=\"#c62f2f\"",
               significant(1e3 * largest->error.norm(), 2) + " mm");
}

/// What the lines and colours mean, from `foot` downwards.
std::string legend(const VerifyResult& result, double foot, double magnification, double scale) {
  const std::string words = "font-family=\"sans-serif\" font-size=\"14\" fill=\"#222\"";
  const double ruler = round_step(120 / scale);  // metres of error
  Marks bar;
  bar.line(Vec2(kSheetRim, foot), Vec2(kSheetRim + scale * ruler, foot));
  std::string drawing = bar.path("stroke=\"#222\" stroke-width=\"3\" fill=\"none\"");
  drawing += label(Vec2(kSheetRim + scale * ruler + 10, foot + 5), words,
                   shortest(1e3 * ruler) + " mm of error, drawn " + shortest(magnification) +
                       " times larger than the surface");
  drawing += arrow(Vec2(kSheetRim, foot + 22), Vec2(kSheetRim + 40, foot + 22), kBefore);
  drawing += label(Vec2(kSheetRim + 50, foot + 27), words,
                   "from the intended to the measured point: " + significant(1e3 * result.rms, 2) +
                       " mm RMS, " + significant(1e3 * result.worst, 2) + " mm max");
  if (is_corrected(result)) {
    drawing += arrow(Vec2(kSheetRim, foot + 44), Vec2(kSheetRim + 40, foot + 44), kAfter);
    drawing += label(Vec2(kSheetRim + 50, foot + 49), words,
                     "after the correction: " + significant(1e3 * result.rms_after, 2) + " mm RMS, " +
                         significant(1e3 * result.worst_after, 2) + " mm max");
  }
  const bool has_crosses = std::any_of(
      result.marks.begin(), result.marks.end(),
      [](const VerifiedMark& mark) { return !mark.intended.isZero(0) && !mark.rejection.empty(); });
  return drawing + label(Vec2(kSheetRim, foot + 71), words,
                         "grey: 95 % of errors when nothing has moved" +
                             std::string(has_crosses ? "; crosses: marks that are rejected" : ""));
}

}  // namespace

std::string verify_picture(const VerifyResult& result, const Points2& content) {
  require(!result.marks.empty(), "verify_picture: there are no marks");
  const SurfaceFrame frame = frame_round(result, content);
  const double magnification = magnification_of(result, frame), scale = magnification * frame.units_per_metre;
  const Vec2 size(kSheetWidth, frame.height() + kSheetFoot);
  std::string drawing = rectangle("fill=\"#fff\"", Vec2::Zero(), size);
  if (content.size() >= 3) drawing += content_outline(content, frame);
  drawing += mark_errors(result, frame, scale) + largest_error(result, frame);
  drawing += label(Vec2(kSheetRim, kHead),
                   "font-family=\"sans-serif\" font-size=\"22\" font-weight=\"bold\" fill=\"" +
                       std::string(result.alarm ? "#c62f2f" : "#1b7f3b") + "\"",
                   (result.alarm ? "ALARM: " : "No alarm: ") + significant(1e3 * result.rms, 2) +
                       " mm RMS on " + result.surface);
  drawing += legend(result, frame.height() + 8, magnification, scale);
  std::string picture = svg(box(Vec2::Zero(), size), "Errors of the light on " + result.surface, drawing);
  picture.insert(picture.find("<svg") + 4, " xmlns=\"http://www.w3.org/2000/svg\"");
  return picture + "\n";
}

}  // namespace procam::report
