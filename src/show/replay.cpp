/// A recorded run shown again, frame by frame, and compared with what it showed.
#include <map>
#include <memory>
#include <string>

#include "procam/device/content_source.hpp"
#include "procam/device/frame_sink.hpp"
#include "procam/render/cpu.hpp"
#include "procam/show/run.hpp"
#include "run_listener.hpp"
#include "run_log.hpp"
#include "run_options.hpp"

namespace procam::show {
namespace {

/// A recorded run that is read back, record by record.
struct Replay {
  Projection& projection;
  const BlendPlan& blend;
  device::FrameSink& sink;
  const ShowOptions& options;
  const std::string& conditions;
  ShowListener& listener;
  ImageU8 frame;
  std::map<std::string, std::shared_ptr<device::ContentSource>> opened = {};
  ReplayReport report = {};
  std::string content_fault = {};  ///< that was reported last

  void operator()(const RunConditions& recorded) {
    if (recorded.text != conditions)
      listener.on_event("recorded under other conditions; frames may differ\n  then: " + recorded.text +
                        "\n  now:  " + conditions);
  }
  void operator()(const MissingParts& parts) {
    listener.on_event("parts " + std::to_string(parts.first) + " to " + std::to_string(parts.last) +
                      " of the log are missing: poses are filtered anew from here, and frames may differ");
  }
  void operator()(const SurfaceSet& set) {
    const std::filesystem::path beside = content_folder(options.surfaces) / "surfaces.json";
    device::ContentOptions exact;
    exact.pace = device::Pace::kExact;
    Show show;
    for (const Surface& surface : set.surfaces) {
      std::shared_ptr<device::ContentSource>& content = opened[surface.content];
      if (!content && !surface.content.empty())
        content = device::open_content(device::content_beside(beside, surface.content), exact);
      show.contents.push_back(content);
    }
    show.surfaces = set;
    projection.set_show(std::move(show));
  }
  void operator()(TestPattern picture) { projection.set_picture(picture); }
  void operator()(const MovedProjector& moved) { projection.move_projector(moved.rig_from_projector); }
  void operator()(const BlendScene& scene) { projection.set_blend(make_blend(blend, scene).blend); }
  void operator()(const track::StampedPose& message) { projection.add(message); }
  void operator()(const SightedSurface& sighted) { projection.add_sighting(sighted.message); }
  void operator()(const RecordedFrame& recorded) {
    const DrawnFrame drawn = projection.draw(recorded.light_time, recorded.content_time, frame);
    if (!drawn.content_fault.empty() && drawn.content_fault != content_fault)
      listener.on_event(content_fault = drawn.content_fault);
    sink.show_next(frame);
    report.equal += fingerprint(frame) == recorded.fingerprint ? 1 : 0;
    ++report.frames;
    ShowReport so_far;
    so_far.metrics.frames = report.frames;
    listener.on_frame(so_far);
  }
};

}  // namespace

ReplayReport replay(const Rig& rig, const ShowOptions& options, const std::filesystem::path& log,
                    ShowListener* listener) {
  ProjectionOptions drawing = projection_options(options, rig);
  const std::string conditions = conditions_text(options, drawing, rig);
  const BlendPlan blend = blend_basis(options, rig, drawing);
  Projection projection(rig, std::move(drawing));
  render::require_drawable(projection.frame_size());
  device::SinkOptions sink_options;
  sink_options.size = projection.frame_size();
  sink_options.fps = options.fps > 0 ? options.fps : kUsualRate;
  const auto sink = device::open_sink(options.output.empty() ? "none" : options.output, sink_options);
  Replay replay{projection,
                blend,
                *sink,
                options,
                conditions,
                listener_or_none(listener),
                ImageU8(projection.frame_size(), 3)};
  RunReader reader(log, options.surfaces);
  while (const std::optional<RunRecord> record = reader.next()) std::visit(replay, *record);
  sink->finish();
  if (replay.report.frames == 0)
    throw Error(ErrorKind::kInput, log.string(), "it holds no frame, so nothing was compared",
                "give the log of a run that showed frames");
  return replay.report;
}

}  // namespace procam::show
