// procam: errors, diagnostics, sizes, clocks and limits, as procam/core/base has them.
#include "procam/core.hpp"

#include "bind.hpp"
#include "components.hpp"

namespace procam::python {

namespace {

void bind_errors(py::module_& m) {
  Enum<ErrorKind>(m, "ErrorKind", "The kinds of procam.Error: what a person must act on.")
      .value("kInput", ErrorKind::kInput)
      .value("kNotEnoughData", ErrorKind::kNotEnoughData)
      .value("kDegenerate", ErrorKind::kDegenerate)
      .value("kNotConverged", ErrorKind::kNotConverged)
      .value("kUnsupported", ErrorKind::kUnsupported)
      .value("kIo", ErrorKind::kIo)
      .value("kDevice", ErrorKind::kDevice);

  Enum<Severity>(m, "Severity", "How much a remark matters: note, warning, failure of a quality check.")
      .value("kNote", Severity::kNote, "a decision that the person may want to know")
      .value("kWarning", Severity::kWarning, "the result stands, but something deserves a look")
      .value("kFailure", Severity::kFailure,
             "a quality check failed: the result is written, marked, and the tool exits with 5");

  Record<Diagnostic> diagnostic(
      m, "Diagnostic", "One remark about a result: a stable code for programs, a sentence for people.");
  diagnostic.fields_init()
      .field("severity", &Diagnostic::severity, "")
      .field("code", &Diagnostic::code, "snake_case, e.g. \"board_flipped\"")
      .field("message", &Diagnostic::message, "what, why, what to do next");

  Record<Diagnostics> diagnostics(m, "Diagnostics",
                                  "Remarks that come with a result: notes, warnings and failed checks.");
  diagnostics.fields_init()
      .field("items", &Diagnostics::items, "")
      .method("note", &Diagnostics::note, "Adds a note: a code for programs, a sentence for people.",
              py::arg("code"), py::arg("message"))
      .method("warn", &Diagnostics::warn, "Adds a warning: a code for programs, a sentence for people.",
              py::arg("code"), py::arg("message"))
      .method("fail", &Diagnostics::fail,
              "Adds the failure of a quality check: a code for programs, a sentence for people.",
              py::arg("code"), py::arg("message"))
      .method("append", &Diagnostics::append, "Adds the remarks of another one at the end.", py::arg("other"))
      .method("failed", &Diagnostics::failed, "Is there a failure among the remarks?")
      .method("find", &Diagnostics::find, "The first remark with this code, or None.", py::arg("code"));

  function(m, Gil::kHeld, "to_string", &procam::to_string, "The kind in words, e.g. \"input\".",
           py::arg("kind"));
}

void bind_clocks(py::module_& m) {
  function(m, Gil::kHeld, "steady_now", &procam::steady_now,
           "Seconds of the clock of time.monotonic(): never set back, the same in all processes of a\n"
           "machine, without relation to the date.");
  function(m, Gil::kHeld, "utc_now", &procam::utc_now,
           "The time that files state, in UTC, ISO 8601 with whole seconds:\n"
           "\"2026-01-02T03:04:05Z\". SOURCE_DATE_EPOCH (seconds since 1970), where it is set,\n"
           "takes the place of the present: then equal input gives equal files\n"
           "(https://reproducible-builds.org/specs/source-date-epoch).");
}

void bind_color(py::module_& m) {
  function(
      m, Gil::kHeld, "light_from_srgb", [](double value) { return light_from_srgb(value); },
      "Light, 0..1, of an sRGB value, 0..1.", py::arg("value"));
  function(
      m, Gil::kHeld, "srgb_from_light", [](double light) { return srgb_from_light(light); },
      "sRGB value, 0..1, of light, 0..1.", py::arg("light"));
}

void bind_limits(py::module_& m) {
  m.attr("kDocumentDepth") = limits::kDocumentDepth;
  m.attr("kSizeSide") = limits::kSizeSide;
  m.attr("kFrameSide") = limits::kFrameSide;
  m.attr("kSenders") = limits::kSenders;
  m.attr("kTakeoverSilenceS") = limits::kTakeoverSilenceS;
  m.attr("kSenderSilenceS") = limits::kSenderSilenceS;
  m.attr("kOscDepth") = limits::kOscDepth;
  m.attr("kRosbridgeDepth") = limits::kRosbridgeDepth;
  m.attr("kSkeletonDepth") = limits::kSkeletonDepth;
  m.attr("kPageHeadS") = limits::kPageHeadS;
  m.attr("kPageRequestS") = limits::kPageRequestS;
  m.attr("kThreads") = limits::kThreads;
  m.attr("kDurationS") = limits::kDurationS;
  m.attr("kDelayS") = limits::kDelayS;
  m.attr("kLengthM") = limits::kLengthM;
}

}  // namespace

void bind_core_base(py::module_& m) {
  Record<ImageSize> image_size(m, "ImageSize", "Width and height in pixels.");
  image_size.fields_init()
      .field("width", &ImageSize::width, "")
      .field("height", &ImageSize::height, "")
      .method("contains", &ImageSize::contains,
              "Is the pixel position inside the picture's area, [-0.5, W-0.5) x [-0.5, H-0.5)?",
              py::arg("pixel"));

  m.attr("kPi") = procam::kPi;
  m.attr("kDegree") = procam::kDegree;
  bind_errors(m);
  bind_clocks(m);
  bind_color(m);
  bind_limits(m);
}

}  // namespace procam::python
