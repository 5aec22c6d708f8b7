#include "procam/session/light.hpp"

#include <algorithm>

#include "procam/io/files.hpp"
#include "procam/io/session/decoded_view.hpp"
#include "procam/pattern/decoded_pixels.hpp"

namespace procam::session {
namespace fs = std::filesystem;
namespace {

const PlannedView& view_named(const SessionPlan& plan, const std::string& name) {
  std::string known;
  for (const PlannedView& view : plan.views) {
    if (view.name == name || (name.empty() && plan.views.size() == 1)) return view;
    known += (known.empty() ? "" : ", ") + view.name;
  }
  throw Error(
      ErrorKind::kInput, plan.folder.string(),
      name.empty() ? "it has several views, and a scan is made of one" : "it has no view '" + name + "'",
      "name one by --view: " + known);
}

/// A board judges its points. Here every pixel is a result, and such captures give wrong ones.
void refuse_wrong_order(const Diagnostics& decoded, const std::string& view) {
  for (const char* const code : {"frames_exchanged", "waves_disagree"}) {
    const Diagnostic* const remark = decoded.find(code);
    if (remark == nullptr) continue;
    // "<why>: put the files back ..." or "<why>; capture this view again ...".
    const std::string& words = remark->message;
    const std::size_t why = std::min(words.find(": put"), words.find("; capture"));
    throw Error(ErrorKind::kInput, "view '" + view + "'", words.substr(0, why),
                why < words.size() ? words.substr(why + 2) : "capture this view again");
  }
}

CapturedLight read_stack_light(const SessionPlan& plan, const PlannedView& view, const io::Stack& stack) {
  const auto projector = std::find_if(
      plan.projectors.begin(), plan.projectors.end(),
      [&](const PlannedProjector& p) { return stack.projector.empty() || p.name == stack.projector; });
  CapturedLight seen;
  seen.view = view.name;
  seen.camera = stack.camera;
  seen.projector = stack.projector;
  const auto remember = [&](const std::vector<fs::path>& files) {
    for (const fs::path& file : files)
      seen.inputs.push_back(
          {file.lexically_relative(plan.folder).generic_string(), io::sha256_of_file(file)});
  };
  if (plan.decoded) {
    io::DecodedView decoded = io::load_decoded_view(stack.folder);
    remember(decoded.files);
    seen.light = pattern::light_map(decoded.pixels, decoded.white, projector->size);
    seen.light.diagnostics.append(decoded.diagnostics);
    seen.flat_lit = std::move(decoded.white);
    return seen;
  }
  const io::CaptureFolder captures = io::load_capture_folder(stack.folder, projector->pattern->frame_count(),
                                                             projector->pattern->channels());
  remember(captures.files);
  seen.exif = io::exif_focal(captures.files.front());
  std::optional<PatternLight> read =
      projector->pattern->read_light_map(std::vector<ViewU8>(captures.frames.begin(), captures.frames.end()));
  if (!read)
    throw Error(ErrorKind::kInput, "pattern '" + projector->pattern->text() + "'",
                "it lights points alone, and a scan needs the light of every pixel",
                "capture Gray code or phase shift (--pattern gray, phase or gray+phase)");
  seen.light = std::move(read->light);
  seen.flat_lit = std::move(read->flat_lit);
  seen.light.diagnostics.append(captures.diagnostics);
  refuse_wrong_order(seen.light.diagnostics, view.name);
  return seen;
}

}  // namespace

std::vector<CapturedLight> read_light(const SessionPlan& plan, const std::string& view) {
  if (plan.shown)
    throw Error(ErrorKind::kInput, plan.folder.string(),
                "it holds one photograph a view: no pixel's light can be read",
                "capture Gray code or phase shift");
  std::vector<CapturedLight> all;
  const PlannedView& planned = view_named(plan, view);
  for (const io::Stack& stack : planned.stacks) all.push_back(read_stack_light(plan, planned, stack));
  return all;
}

}  // namespace procam::session
