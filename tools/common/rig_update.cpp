#include "common/rig_update.hpp"

#include "procam/calibrate/update.hpp"
#include "procam/io/files.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/report/calibration.hpp"

namespace procam::tools {

ExitCode update_rig(const ProjectorFlags& flags, const session::SessionContents& contents, Console& console) {
  const Rig before = io::load_rig(flags.update);
  calibrate::UpdateOptions options;
  options.changed = flags.changed;
  if (flags.keep_outliers) options.outlier_sigmas = 0;
  for (calibrate::RigChange& change : options.changed)
    if (change.device.empty()) change.device = before.projector().name;
  calibrate::UpdateResult result = console.reporting(contents.correspondences.diagnostics, [&] {
    return calibrate::update_rig(before, contents.correspondences, options);
  });
  Rig& rig = result.rig;
  rig.provenance = session::provenance(contents, "calibrate-projector");
  rig.provenance.inputs.push_back({flags.update.filename().string(), io::sha256_of_file(flags.update)});
  std::string changed;
  for (const calibrate::RigChange& change : options.changed)
    changed += (changed.empty() ? "" : ",") + change.device + ":" + calibrate::to_string(change.kind);
  rig.provenance.options["changed"] = changed.empty() ? "nothing" : changed;

  report::ReportInput summary =
      report::judge(rig, flags.wall, flags.accepted, rig.quality.gates, result.diagnostics);
  if (!flags.truth.empty()) report::add_truth(rig, io::load_rig(flags.truth), summary);
  io::save_rig(flags.output, rig);
  console.say(report::headline(rig, rig.quality, summary));
  console.report(result.diagnostics);
  console.say(report::lines(result, summary));
  console.say(written_line(flags));
  console.summary().merge(report::to_json(result, summary));
  return exit_code(result.diagnostics);
}

}  // namespace procam::tools
