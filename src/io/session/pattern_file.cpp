#include "procam/io/session/pattern_file.hpp"

#include "document/fields.hpp"

namespace procam::io {
namespace {

constexpr double kRadiansPerDegree = 3.14159265358979323846 / 180;

void axis_field(Fields& f, StripeAxis& axis) {
  axis = StripeAxis(f.choice("axis", {"columns", "rows"}, std::size_t(axis)));
}

/// Written only where it differs from its default.
template <typename T>
void defaulted(Fields& f, const char* name, T& value, const T& usual) {
  if (f.reading() ? f.has(name) : value != usual) f.field(name, value);
}

}  // namespace

static void fields(Fields& f, SequenceFrame& frame) {
  using Kind = SequenceFrame::Kind;
  frame.kind = Kind(f.choice("kind", {"gray", "phase", "white", "black", "ignore"}, std::size_t(frame.kind)));
  if (frame.kind == Kind::kGray) {
    axis_field(f, frame.axis);
    f.field("bit", frame.bit);
    f.check(frame.bit >= 0 && frame.bit <= 15, "bit", "it is not a number from 0 to 15",
            "give the significance of the bit, 0 for the finest stripes");
    defaulted(f, "inverse", frame.inverse, false);
  }
  if (frame.kind == Kind::kPhase) {
    axis_field(f, frame.axis);
    f.field("period", frame.period);
    f.check(frame.period >= 2, "period", "it is below 2", "give the length of the wave in projector pixels");
    double phase_deg = frame.phase / kRadiansPerDegree;
    f.field("phase_deg", phase_deg);
    if (f.reading()) frame.phase = phase_deg * kRadiansPerDegree;
  }
}

static void fields(Fields& f, FrameSequence& sequence) {
  header(f, "procam-pattern", 1);
  defaulted(f, "step", sequence.step, 1);
  f.check(sequence.step >= 1 && sequence.step <= 1024, "step", "it is not a number from 1 to 1024",
          "give the width of the finest stripes in projector pixels");
  Vec2 offset(sequence.offset[0], sequence.offset[1]);
  if (f.reading() ? f.has("offset") : !offset.isZero()) f.field("offset", offset);
  const bool whole =
      offset == offset.array().round().matrix() && offset.minCoeff() >= 0 && offset.maxCoeff() <= 16384;
  f.check(whole, "offset", "it is not two whole numbers from 0 to 16384",
          "give what the Gray code adds to the number of a stripe, for columns and rows");
  // check() does not throw where a field is missing, and a number beyond an int has no value as one.
  if (whole) sequence.offset = {int(offset.x()), int(offset.y())};
  f.list("frames", "frame", sequence.frames);
  f.check(!sequence.frames.empty(), "frames", "there is none",
          "describe each frame, in the order of capture");
}

FrameSequence load_pattern(const std::filesystem::path& path) {
  return load_noun<FrameSequence>(path, Syntax::kJson);
}

void save_pattern(const std::filesystem::path& path, const FrameSequence& sequence) {
  save_noun(path, Syntax::kJson, sequence);
}

}  // namespace procam::io
