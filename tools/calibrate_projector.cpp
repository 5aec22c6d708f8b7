/// calibrate-projector: captures of a printed board under patterns, or points of a room -> rig.json, with a
/// verdict.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "common/cli.hpp"
#include "common/known_before.hpp"
#include "common/lens_flags.hpp"
#include "common/rig_words.hpp"
#include "common/say_choices.hpp"
#include "procam/calibrate/calibrate.hpp"
#include "procam/calibrate/gates.hpp"
#include "procam/calibrate/mirror.hpp"
#include "procam/calibrate/points.hpp"
#include "procam/detect/detect_board.hpp"
#include "procam/io/board_file.hpp"
#include "procam/io/exchange/calibration_file.hpp"
#include "procam/io/files.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/session/observations_file.hpp"
#include "procam/io/session/point_pairs_file.hpp"
#include "procam/io/text.hpp"
#include "procam/report/calibration.hpp"
#include "procam/session/reader.hpp"

namespace procam::tools {
namespace {

namespace fs = std::filesystem;

struct Flags {
  fs::path captures, points, output, report, truth, check;
  fs::path observations, write_observations;
  std::vector<Device> cameras;  ///< of a table of observations
  io::SessionInfo stated;       ///< what session.json need not say
  session::ShownFlags shown;    ///< of a session of photographs
  double wall = 2;              ///< metres
  analyze::AcceptedError accepted;
  double metres_per_unit = 0;  ///< of an OpenCV file to check
  fs::path mirror_view;
  std::optional<Board> mirror_board;
  double mirror_depth = 0;  ///< metres
  bool holdout = false;
  bool keep_outliers = false;
  std::string board_shape = "auto";
  std::string camera_model = "auto", projector_model = "auto";
  std::vector<std::string> free;   ///< with --points: parameters to estimate that are fixed otherwise
  std::vector<std::string> fixed;  ///< parameters that stay zero
  DataSheet sheet;                 ///< of the projector
  fs::path known_camera;
};

const std::map<std::string, calibrate::BoardShape>& board_shapes() {
  static const std::map<std::string, calibrate::BoardShape> names{{"auto", calibrate::BoardShape::kAuto},
                                                                  {"flat", calibrate::BoardShape::kFlat},
                                                                  {"free", calibrate::BoardShape::kFree}};
  return names;
}

/// "camera 0.123 px, projector 0.098 px": a figure of every device.
std::string by_device(const calibrate::CalibrationResult& result, const std::vector<double>& px,
                      const char* pattern = "%s %.3f px") {
  std::string text;
  for (std::size_t d = 0; d < result.devices.size(); ++d)
    text += (d > 0 ? ", " : "") + format(pattern, result.devices[d].name.c_str(), px[d]);
  return text;
}

/// The board on the mirror in the picture as taken; the session's frames are to be turned.
calibrate::MirrorView read_mirror(const Flags& flags, session::SessionPlan& session) {
  if (!flags.mirror_board)
    throw Error(ErrorKind::kInput, flags.mirror_view.string(), "the board on the mirror is not stated",
                "give --mirror-board chessboard:6x5:20mm, the board that lies on the mirror's surface");
  if (session.cameras.size() > 1)
    throw Error(ErrorKind::kUnsupported, "--mirror-view", "the session has several cameras",
                "calibrate through a mirror with one camera");
  session.through_mirror = true;
  const ImageU8 grey = io::to_gray(io::load_image(flags.mirror_view).image);
  return {*flags.mirror_board, detect::detect_board(grey, *flags.mirror_board), flags.mirror_depth};
}

/// What follows every calibration of camera and projector: predicted errors and their check, the view to add
/// next, the files, and the words. The rig's provenance is set before.
ExitCode conclude(const Flags& flags, Console& console, calibrate::CalibrationResult& result,
                  const session::SessionContents& input, const Rig& truth) {
  Rig& rig = result.rig;
  const std::vector<analyze::LightErrors> predicted =
      analyze::check_predicted_errors(result, flags.wall, flags.accepted);

  console.progress("the view to add next", 99, 100);
  const auto worst = std::max_element(predicted.begin(), predicted.end(), [&](const auto& a, const auto& b) {
    return a.of(flags.accepted.located).rms_mm < b.of(flags.accepted.located).rms_mm;
  });
  std::optional<analyze::NextView> next;
  if (worst != predicted.end())
    next = analyze::advise_next_view(result, flags.wall, worst->externally.projector, flags.accepted.located);

  io::save_rig(flags.output, rig);
  if (!flags.report.empty()) {
    report::ReportInput extra;
    extra.title = input.title;
    extra.predicted = predicted;
    extra.accepted = flags.accepted;
    extra.next_view = next;
    if (!flags.truth.empty())
      for (const RigProjector& projector : rig.projectors)
        extra.truth.push_back(analyze::true_light_errors(rig, truth, flags.wall,
                                                         rig.projectors.size() > 1 ? projector.name : ""));
    io::write_file_atomically(flags.report, report::calibration_report(result, input.correspondences, extra));
  }

  say_result(console, rig, rig.quality, predicted, flags.accepted, next.has_value());
  say_remarks(console, result.diagnostics);
  std::string by_views;
  for (std::size_t d = 0; d < result.devices.size(); ++d) {
    std::set<int> views;
    for (const calibrate::Residual& r : result.residuals)
      if (r.used && r.device == int(d)) views.insert(r.view);
    by_views += (d > 0 ? ", " : "") + result.devices[d].name + " " + std::to_string(views.size());
    console.summary().set("/views_used_by/" + result.devices[d].name, int(views.size()));
  }
  console.say(format("views      %d of %d used (%s)", rig.quality.views_used, input.views, by_views.c_str()));
  console.say("RMS        " + by_device(result, result.rms_px) +
              format(", joint %.3f px", result.joint_rms_px));
  console.say("           outliers included: " + by_device(result, result.rms_all_px) +
              format(", joint %.3f px", result.joint_rms_all_px));
  console.summary().set("/views_used", rig.quality.views_used);
  console.summary().set("/views", input.views);
  for (std::size_t d = 0; d < result.devices.size(); ++d) {
    const std::string& device = result.devices[d].name;
    int found = 0, used = 0;
    for (const calibrate::Residual& r : result.residuals) {
      found += r.device == int(d);
      used += r.device == int(d) && r.used;
    }
    console.summary().set("/points_found/" + device, found);
    console.summary().set("/points_used/" + device, used);
    console.summary().set("/rms_px/" + device, result.rms_px[d]);
    console.summary().set("/rms_all_px/" + device, result.rms_all_px[d]);
    if (!flags.holdout) continue;
    console.summary().set("/holdout_px/" + device, result.holdout_px[d]);
    console.summary().set("/holdout_all_px/" + device, result.holdout_all_px[d]);
  }
  console.summary().set("/rms_px/joint", result.joint_rms_px);
  console.summary().set("/rms_all_px/joint", result.joint_rms_all_px);
  if (flags.holdout)
    console.say("held out   " + by_device(result, result.holdout_px) +
                "; each view predicted by a solve without it");
  if (flags.holdout) console.say("           outliers included: " + by_device(result, result.holdout_all_px));
  for (const RigCamera& camera : rig.cameras) say_lens(console, camera.name, camera.camera, rig.covariance);
  for (const RigProjector& projector : rig.projectors)
    say_lens(console, projector.name, projector.projector.inverse_camera, rig.covariance);
  for (const RigProjector& device : rig.projectors) {
    const Projector& projector = device.projector;
    console.say(
        format("optics     %sthrow ratio %.2f, lens shift %+.0f %% of the width, %+.0f %% of the height",
               said_of(rig, device).c_str(), projector.throw_ratio(), 100 * projector.lens_shift().x(),
               100 * projector.lens_shift().y()));
    console.summary().set(of_projector(rig, "", device, "/throw_ratio"), projector.throw_ratio());
    console.summary().set(of_projector(rig, "", device, "/lens_shift"),
                          std::vector<double>{projector.lens_shift().x(), projector.lens_shift().y()});
  }
  say_board_shape(console, result);
  say_size_to_measure(console, result);
  say_lens_models(console, result, flags.wall);
  say_views(console, result, next, flags.accepted.located);
  if (!flags.truth.empty()) say_truth(console, rig, truth, flags.wall);
  say_gates(console, rig.quality.gates);
  console.say("written    " + flags.output.string() +
              (flags.report.empty() ? "" : ", " + flags.report.string()));
  return exit_code(result.diagnostics);
}

session::SessionContents read_captures(const Flags& flags, std::optional<calibrate::MirrorView>& mirror,
                                       Console& console) {
  session::SessionPlan plan = session::open(flags.captures, {flags.stated, flags.shown});
  if (!flags.mirror_view.empty()) mirror = read_mirror(flags, plan);
  return session::read(plan, [&](const std::string& view, int done, int total) {
    console.progress("reading " + view, done, total);
  });
}

/// --observations, with the sizes that flags give.
session::SessionContents read_table(const Flags& flags) {
  std::vector<Device> devices = flags.cameras;
  if (flags.stated.projector_size)
    devices.push_back({"projector", DeviceKind::kProjector, *flags.stated.projector_size});
  for (const auto& [name, size] : flags.stated.projectors)
    devices.push_back({name, DeviceKind::kProjector, size});
  session::SessionContents input =
      session::read_observations(flags.observations, devices, flags.stated.board);
  if (input.correspondences.devices.back().kind != DeviceKind::kProjector)
    throw Error(ErrorKind::kInput, flags.observations.string(), "the projector's size is not given",
                "give --projector-size 1024x768; for a camera alone, use calibrate-camera");
  return input;
}

ExitCode calibrate_session(const Flags& flags, Console& console) {
  for (const fs::path& file : {flags.output, flags.report, flags.write_observations})
    if (!file.empty()) io::require_writable(file);
  Rig truth;
  if (!flags.truth.empty()) truth = io::load_rig(flags.truth);
  std::optional<calibrate::MirrorView> mirror;
  const session::SessionContents input =
      flags.observations.empty() ? read_captures(flags, mirror, console) : read_table(flags);
  const Correspondences& correspondences = input.correspondences;
  if (!flags.write_observations.empty()) io::save_observations(flags.write_observations, correspondences);
  std::vector<Device> projectors;
  for (const Device& device : correspondences.devices)
    if (device.kind == DeviceKind::kProjector) projectors.push_back(device);

  calibrate::Options options;
  options.holdout = flags.holdout;
  if (projectors.size() > 1 && (flags.sheet.throw_ratio || !flags.sheet.lens_shift.empty()))
    throw Error(ErrorKind::kUnsupported, "--throw-ratio, --lens-shift",
                "the session has several projectors, and they say nothing of which one",
                "leave them out: with a board before every projector they are not needed");
  options.projector.priors = priors_of(flags.sheet, projectors.front().size);
  if (flags.keep_outliers) options.outlier_sigmas = 0;
  options.board_shape = board_shapes().at(flags.board_shape);
  set_lens_model(flags.camera_model, flags.fixed, options.camera);
  set_lens_model(flags.projector_model, flags.fixed, options.projector);
  options.progress = [&](const std::string& step, double share) {
    console.progress(step, int(100 * share), 100);
  };
  calibrate::CalibrationResult result =
      flags.known_camera.empty()
          ? calibrate::calibrate_rig(correspondences, options)
          : calibrate::calibrate_projector(
                correspondences, read_known_camera(flags.known_camera, correspondences.devices), options);
  if (mirror) {
    calibrate::MirrorSolution seen = calibrate::through_mirror(result, *mirror);
    result = std::move(seen.result);
    const double distance = std::abs(seen.mirror_in_camera.offset);
    console.say(
        format("mirror     %.3f m before the camera, its board's RMS %.3f px", distance, seen.rms_px));
    console.summary().set("/mirror/distance_m", distance);
    console.summary().set("/mirror/rms_px", seen.rms_px);
  }
  Rig& rig = result.rig;
  rig.provenance = session::provenance(input, "calibrate-projector");
  for (const std::string& name : flags.fixed) rig.provenance.options["fix " + name] = "yes";
  for (const auto& [option, choice] :
       {std::pair("board-shape", flags.board_shape), std::pair("camera-model", flags.camera_model),
        std::pair("projector-model", flags.projector_model)})
    if (choice != "auto") rig.provenance.options[option] = choice;
  if (flags.keep_outliers) rig.provenance.options["keep-outliers"] = "yes";
  if (!flags.known_camera.empty())
    rig.provenance.inputs.push_back(
        {flags.known_camera.filename().string(), io::sha256_of_file(flags.known_camera)});
  if (mirror) {
    rig.provenance.options["mirror-board"] = io::format_board(*flags.mirror_board);
    rig.provenance.options["mirror-depth"] = format("%gmm", 1e3 * flags.mirror_depth);
    rig.provenance.inputs.push_back(
        {flags.mirror_view.filename().string(), io::sha256_of_file(flags.mirror_view)});
  }
  return conclude(flags, console, result, input, truth);
}

/// --points: a projector alone, in the room's frame.
ExitCode calibrate_points(const Flags& flags, Console& console) {
  for (const fs::path& file : {flags.output}) io::require_writable(file);
  if (!flags.stated.projector_size)
    throw Error(ErrorKind::kInput, flags.points.string(),
                "a list of points does not state the projector's size", "give --projector-size 1024x768");
  const ImageSize picture = *flags.stated.projector_size;
  Rig truth;
  if (!flags.truth.empty()) truth = io::load_rig(flags.truth);
  const std::vector<PointPair> pairs = io::load_point_pairs(flags.points);
  calibrate::PointsOptions options;
  options.lens.priors = priors_of(flags.sheet, picture);
  if (flags.keep_outliers) options.outlier_sigmas = 0;
  for (const std::string& name : flags.free)
    options.lens.held.erase(std::remove(options.lens.held.begin(), options.lens.held.end(), name),
                            options.lens.held.end());
  calibrate::PointsResult result =
      calibrate::calibrate_from_points({"projector", DeviceKind::kProjector, picture}, pairs, options);
  Rig& rig = result.rig;
  session::SessionContents source;
  source.inputs = {{flags.points.filename().string(), io::sha256_of_file(flags.points)}};
  source.options = {{"projector-size", io::format_size(picture)}};
  rig.provenance = session::provenance(source, "calibrate-projector");
  const std::vector<analyze::LightErrors> predicted = analyze::predicted_errors(rig, flags.wall);
  analyze::check_predicted_errors(rig, predicted, flags.accepted, rig.quality.gates, result.diagnostics);
  io::save_rig(flags.output, rig);

  say_result(console, rig, rig.quality, predicted, flags.accepted, false);
  say_remarks(console, result.diagnostics);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const calibrate::PairResidual& pair = result.pairs[i];
    console.say(format(
        "%-24s %7.2f %7.2f px%s",
        pairs[i].name.empty() ? format("pair %zu", i + 1).c_str() : pairs[i].name.substr(0, 24).c_str(),
        pair.residual.x(), pair.residual.y(),
        !pair.used          ? "  rejected"
        : pair.loo_residual ? format("  (%.2f when held out)", pair.loo_residual->norm()).c_str()
                            : ""));
  }
  console.say(format("RMS        %.2f px; one coordinate's sigma %.2f px; held out in turn %.2f px",
                     result.rms_px, result.sigma_px, result.loo_rms_px));
  console.summary().set("/rms_px", result.rms_px);
  console.summary().set("/sigma_px", result.sigma_px);
  console.summary().set("/left_out_px", result.loo_rms_px);
  console.summary().set("/pairs", int(pairs.size()));
  say_lens(console, "projector", rig.projector().projector.inverse_camera, rig.covariance);
  const Vec3 place = rig.projector().rig_from_projector.translation;
  const std::string names[] = {"rig_from_projector.tx", "rig_from_projector.ty", "rig_from_projector.tz"};
  console.say(format("place      %.3f, %.3f, %.3f m in the room", place.x(), place.y(), place.z()));
  console.summary().set("/place_m", std::vector<double>{place.x(), place.y(), place.z()});
  if (!flags.truth.empty()) say_truth(console, rig, truth, flags.wall);
  say_gates(console, rig.quality.gates);
  console.say("written    " + flags.output.string());
  return exit_code(result.diagnostics);
}

/// --check: the quality checks alone, on a rig file or on another program's calibration.
ExitCode check_file(const Flags& flags, Console& console) {
  io::CalibrationContext context;
  context.projector_size = flags.stated.projector_size;
  if (!flags.cameras.empty()) context.camera_size = flags.cameras.front().size;
  if (flags.metres_per_unit > 0) context.metres_per_unit = flags.metres_per_unit;
  const Rig rig = io::load_calibration(flags.check, context);
  RigQuality quality;
  quality.gates = calibrate::check_stored_rig(rig);
  const std::vector<analyze::LightErrors> predicted = analyze::predicted_errors(rig, flags.wall);
  Diagnostics diagnostics;
  for (const Gate& gate : quality.gates)
    if (!gate.passed) diagnostics.fail("gate_failed", gate.name + ": " + gate.detail);
  analyze::check_predicted_errors(rig, predicted, flags.accepted, quality.gates, diagnostics);
  say_result(console, rig, quality, predicted, flags.accepted, false);
  for (const RigCamera& camera : rig.cameras) say_lens(console, camera.name, camera.camera, rig.covariance);
  for (const RigProjector& projector : rig.projectors)
    say_lens(console, projector.name, projector.projector.inverse_camera, rig.covariance);
  say_gates(console, quality.gates);
  console.summary().add(diagnostics);
  return exit_code(diagnostics);
}

/// What the program can work on, and the other options that have a meaning then; with `allows` they are the
/// only ones, without it all but those in `refuses`.
struct InputKind {
  const char* name;
  bool needs_output;
  std::vector<std::string> allows, refuses;
};

const std::vector<InputKind>& input_kinds() {
  static const std::vector<InputKind> kinds{
      {"--captures", true, {}, {"--camera-size", "--unit"}},
      {"--decoded", true, {}, {"--camera-size", "--unit", "--pattern", "--step", "--shown", "--upright"}},
      {"--observations",
       true,
       {},
       {"--pattern", "--step", "--shown", "--upright", "--mirror-view", "--mirror-board", "--mirror-depth",
        "--unit"}},
      {"--points",
       true,
       {"--projector-size", "--throw-ratio", "--lens-shift", "--square-pixels", "--free", "--keep-outliers",
        "--wall", "--accept", "--truth", "--output"},
       {}},
      {"--check",
       false,
       {"--camera-size", "--projector-size", "--unit", "--wall", "--accept", "--surface-located"},
       {}},
  };
  return kinds;
}

/// An option that would be ignored is a usage error.
void require_one_input(const CLI::App& app, const Flags& flags) {
  const InputKind* given = nullptr;
  for (const InputKind& kind : input_kinds()) {
    if (app.get_option(kind.name)->count() == 0) continue;
    if (given != nullptr)
      throw CLI::ValidationError(kind.name, std::string("cannot be used together with ") + given->name);
    given = &kind;
  }
  if (given == nullptr)
    throw CLI::RequiredError(
        "--captures DIR, --decoded DIR, --observations FILE or --points FILE with -o rig.json, or --check "
        "FILE,");
  if (given->needs_output && flags.output.empty())
    throw CLI::RequiredError(std::string("-o rig.json with ") + given->name);
  const auto contains = [](const std::vector<std::string>& names, const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  const std::vector<std::string> always{given->name, "--json", "--help", "--version"};
  for (const CLI::Option* option : app.get_options()) {
    const std::string name = "--" + (option->get_lnames().empty() ? "" : option->get_lnames().front());
    const bool used = contains(always, name) || (given->allows.empty() ? !contains(given->refuses, name)
                                                                       : contains(given->allows, name));
    if (option->count() > 0 && !used)
      throw CLI::ValidationError(name, std::string("has no effect with ") + given->name);
  }
  const bool frees_k3 = std::find(flags.free.begin(), flags.free.end(), "k3") != flags.free.end();
  if (frees_k3 && !flags.points.empty())
    throw CLI::ValidationError("--free k3",
                               "has no effect with --points: a few points estimate no distortion");
}

void declare(CLI::App& app, Flags& flags) {
  app.add_option("--captures", flags.captures, "Folder with one sub-folder of numbered frames a board pose");
  app.add_option_function<std::string>(
      "--decoded",
      [&](const std::string& folder) {
        flags.captures = folder;
        flags.stated.pattern = session::kDecodedMaps;
      },
      "Instead of captures: a folder with one sub-folder a board pose of what another program has decoded: "
      "white.png, columns.npy and rows.npy (or .pfm, or map.npy with both), projector pixels with the "
      "centre of the top-left one at 0, 0 and NaN where undecoded (docs/patterns.md)");
  app.add_option(
      "--observations", flags.observations,
      "Instead of captures: a table of board points and pixels, .csv or .npy (docs/file-formats.md)");
  add_parsed(
      app, "--camera-size",
      [&](const std::string& text) { flags.cameras.push_back(io::parse_device(text, DeviceKind::kCamera)); },
      "Size of the camera's images, where a table of observations or a calibration to check does not give "
      "it; of several cameras one for each: left=1280x1024")
      ->trigger_on_parse()
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
  app.add_option("--write-observations", flags.write_observations,
                 "Also write the points and pixels that were found, as --observations reads them");
  app.add_option(
      "--pattern", flags.stated.pattern,
      "What was projected, if session.json does not say (default gray): " + session::pattern_help());
  add_parsed(
      app, "--projector-size",
      [&](const std::string& text) {
        const std::size_t equals = text.find('=');
        if (equals == std::string::npos)
          flags.stated.projector_size = io::parse_size(text);
        else
          flags.stated.projectors[text.substr(0, equals)] = io::parse_size(text.substr(equals + 1));
      },
      "Size of the projected picture, e.g. 1024x768; of several projectors one for each, with the name of "
      "its folder: left=1024x768")
      ->trigger_on_parse()
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
  add_parsed(
      app, "--board", [&](const std::string& text) { flags.stated.board = io::read_board(text); },
      "The printed board, e.g. chessboard:7x9:75mm (inner corners), or its board file (.json)");
  app.add_option("--step", flags.stated.step, "Stripe width of the finest pattern in projector pixels")
      ->check(CLI::Range(1, 1024));
  app.add_option(
      "--shown", flags.shown.shown,
      "The session holds one photograph a view that shows the printed and a projected chessboard: "
      "the frame that the projector showed in all views, or a shown.json that names what it showed "
      "in each (default: shown.json of the session)");
  app.add_flag("--upright", flags.shown.upright,
               "The projector's frame appears upright in the photographs; needed for projected chessboards "
               "with two odd or two even counts");
  app.add_option("--points", flags.points,
                 "Instead of captures: a list of the room's points, a line x,y,z (metres),u,v (pixels) "
                 "for each; at least six not on one wall, or four with a data sheet's values");
  add_parsed(
      app, "--throw-ratio",
      [&](const std::string& text) { flags.sheet.throw_ratio = io::parse_uncertain(text); },
      "Known of the projector: distance over picture width, e.g. 1.4 or 1.4+-0.02");
  add_parsed(
      app, "--lens-shift",
      [&](const std::string& text) {
        const std::size_t comma = text.find(',');
        if (comma == std::string::npos)
          throw Error(ErrorKind::kInput, "--lens-shift " + text, "it needs two numbers", "give e.g. 0,0.5");
        flags.sheet.lens_shift = {io::parse_uncertain(text.substr(0, comma)),
                                  io::parse_uncertain(text.substr(comma + 1))};
      },
      "Known of the projector: how far its axis lies from the picture's centre, in widths and heights, right "
      "and down, e.g. 0,0.5 or 0+-0.01,0.5+-0.02");
  app.add_flag("--square-pixels", flags.sheet.square_pixels, "Known of the projector: fx = fy");
  app.add_option("--known-camera", flags.known_camera,
                 "Rig file of the camera (from calibrate-camera), or another program's calibration of it "
                 "(docs/exchange.md): its lens is kept within the file's sigmas, or as it is where the file "
                 "has none");
  app.add_option("-o,--output", flags.output, "Rig file to write");
  app.add_option("--free", flags.free,
                 "With --points: also estimate skew. Boards estimate skew and k3 anyway")
      ->check(CLI::IsMember({"skew", "k3"}))
      ->delimiter(',');
  app.add_option("--fix", flags.fixed,
                 "Keep skew or k3 of camera and projector at zero, for a program that has none")
      ->check(CLI::IsMember({"skew", "k3"}))
      ->delimiter(',');
  app.add_option("--camera-model", flags.camera_model,
                 std::string("The camera's lens: ") + kLensModelHelp + " or fisheye")
      ->capture_default_str();
  app.add_option("--projector-model", flags.projector_model,
                 std::string("The projector's lens: ") + kLensModelHelp)
      ->capture_default_str();
  app.add_option("--report", flags.report, "Also write a self-contained HTML page");
  app.add_option("--board-shape", flags.board_shape,
                 "Is the board flat, as printed? auto: by the prediction of held-out views; flat; free: "
                 "every point may lie off its place by about 1 % of a square")
      ->check(CLI::IsMember(board_shapes()))
      ->capture_default_str();
  app.add_flag("--keep-outliers", flags.keep_outliers, "Leave no point and no view out, however far off");
  app.add_flag("--holdout", flags.holdout,
               "Leave each view out in turn and report how well the others predict it");
  add_parsed(
      app, "--wall",
      [&](const std::string& text) {
        flags.wall = io::parse_length(text);
        if (!(flags.wall > 0))
          throw Error(ErrorKind::kInput, "--wall " + text, "a distance must be positive", "give e.g. 2m");
      },
      "Distance of the wall for which errors are predicted (default 2m)");
  add_parsed(
      app, "--accept",
      [&](const std::string& text) {
        flags.accepted.rms_mm = 1e3 * io::parse_length(text);
        if (!(flags.accepted.rms_mm > 0))
          throw Error(ErrorKind::kInput, "--accept " + text, "an error must be positive", "give e.g. 5mm");
      },
      "Largest predicted error (RMS) on that wall that passes the quality check (default 5mm: markers and "
      "localisers place a surface to 5 to 10 mm)");
  app.add_option_function<std::string>(
         "--surface-located",
         [&](const std::string& text) {
           flags.accepted.located =
               text == "camera" ? analyze::SurfaceLocated::kByCamera : analyze::SurfaceLocated::kExternally;
         },
         "How you will locate surfaces: by the rig's camera (markers, boards), where errors that camera and "
         "projector share cancel, or externally (a map, a localiser, a tape measure). Decides which error is "
         "checked and which the next view reduces; both are reported")
      ->check(CLI::IsMember({"camera", "externally"}))
      ->default_str("externally");
  auto* mirror =
      app.add_option("--mirror-view", flags.mirror_view,
                     "The session was captured in a flat mirror: a picture of the board that lies on "
                     "the mirror, taken by the same camera at its place");
  add_parsed(
      app, "--mirror-board", [&](const std::string& text) { flags.mirror_board = io::read_board(text); },
      "The board on the mirror, e.g. chessboard:6x5:20mm, or its board file")
      ->needs(mirror);
  add_parsed(
      app, "--mirror-depth", [&](const std::string& text) { flags.mirror_depth = io::parse_length(text); },
      "How far the reflecting plane lies behind that board: paper, and two thirds of a silvered glass' "
      "thickness (default 0mm)")
      ->needs(mirror);
  app.add_option("--truth", flags.truth,
                 "A rig file known to be true (a simulation's): report the distance to it");
  app.add_option(
      "--check", flags.check,
      "Only check a calibration: a rig file, or one of OpenCV, ROS, Kalibr and others (docs/exchange.md)");
  add_parsed(
      app, "--unit", [&](const std::string& text) { flags.metres_per_unit = io::parse_length(text); },
      "Unit of the translation in another program's file (default 1mm)");
  app.callback([&app, &flags] { require_one_input(app, flags); });
}

}  // namespace
}  // namespace procam::tools

int main(int argc, char** argv) {
  using namespace procam::tools;
  Flags flags;
  return run_tool(
      argc, argv,
      {"calibrate-projector",
       "Calibrates a projector and a camera together from captures of a printed board lit by patterns, or a "
       "projector alone from points of a room.",
       "calibrate-projector --captures captures --pattern gray --projector-size 1024x768 "
       "--board chessboard:7x9:75mm -o rig.json --report report.html"},
      [&](CLI::App& app) { declare(app, flags); },
      [&](Console& console) {
        if (!flags.points.empty()) return calibrate_points(flags, console);
        return flags.check.empty() ? calibrate_session(flags, console) : check_file(flags, console);
      });
}
