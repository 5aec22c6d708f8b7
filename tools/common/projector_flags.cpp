#include "common/projector_flags.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>

#include "common/help.hpp"
#include "common/lens_flags.hpp"
#include "procam/io/board_file.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/text.hpp"

namespace procam::tools {
namespace {

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

/// A rig that is refreshed keeps its lens models and its board; the page is of a whole calibration.
constexpr const char* kNotOfUpdate[] = {
    "--known-camera", "--mirror-view", "--compare",    "--report",        "--figures",
    "--data",         "--board-shape", "--holdout",    "--fix",           "--free",
    "--camera-model", "--throw-ratio", "--lens-shift", "--square-pixels", "--projector-model"};

/// An option that would be ignored is a usage error.
void require_one_input(const CLI::App& app, const ProjectorFlags& flags) {
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
  if (!flags.update.empty())
    for (const char* name : kNotOfUpdate)
      if (app.get_option(name)->count() > 0) throw CLI::ValidationError(name, "has no effect with --update");
  const bool frees_k3 = std::find(flags.free.begin(), flags.free.end(), "k3") != flags.free.end();
  if (frees_k3 && !flags.points.empty())
    throw CLI::ValidationError("--free k3",
                               "has no effect with --points: a few points estimate no distortion");
}

/// "pose" or "lamp:zoom".
calibrate::RigChange parse_change(const std::string& text) {
  using Kind = calibrate::RigChange::Kind;
  const std::size_t colon = text.rfind(':');
  calibrate::RigChange change;
  if (colon != std::string::npos) change.device = text.substr(0, colon);
  const std::string kind = colon == std::string::npos ? text : text.substr(colon + 1);
  for (const Kind known : {Kind::kPose, Kind::kZoom, Kind::kFocus})
    if (kind == calibrate::to_string(known)) return change.kind = known, change;
  throw Error(ErrorKind::kInput, "--changed " + text, "'" + kind + "' is none of pose, zoom and focus",
              "give e.g. pose, or of several devices camera:focus,projector:pose");
}

void declare_update(CLI::App& app, ProjectorFlags& flags) {
  auto* update =
      app.add_option("--update", flags.update,
                     "Refresh this rig by one or two new views instead of a calibration from nothing; "
                     "see --changed");
  add_parsed(
      app, "--changed",
      [&](const std::string& text) {
        for (std::size_t begin = 0, end = 0; end != std::string::npos; begin = end + 1) {
          end = text.find(',', begin);
          flags.changed.push_back(parse_change(text.substr(begin, end - begin)));
        }
      },
      "What may have changed since then: pose (bumped), zoom, focus, of the projector or of a named device: "
      "camera:focus,projector:pose (default: nothing, and the views must agree with the rig)")
      ->needs(update);
}

/// What was captured, and of what.
void declare_input(CLI::App& app, ProjectorFlags& flags) {
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
      "--pattern", flags.stated.pattern,
      "What was projected, if session.json does not state it (default gray): " + session::pattern_help());
  add_parsed(
      app, "--projector-size",
      [&](const std::string& text) {
        const std::size_t equals = text.find('=');
        if (equals == std::string::npos)
          flags.stated.projector_size = io::parse_size(text);
        else
          flags.stated.projectors[text.substr(0, equals)] = io::parse_size(text.substr(equals + 1));
      },
      "Size of the projected image, e.g. 1024x768; of several projectors one for each, with the name of "
      "its folder: left=1024x768")
      ->trigger_on_parse()
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
  add_parsed(
      app, "--board", [&](const std::string& text) { flags.stated.board = io::read_board(text); },
      "The printed board, e.g. charuco:5x7:34mm:25mm:5x5_100 or chessboard:9x6:24mm (inner corners), or its board file (.json)");
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
}

/// What is known of the devices beforehand.
void declare_data_sheet(CLI::App& app, ProjectorFlags& flags) {
  add_parsed(
      app, "--throw-ratio",
      [&](const std::string& text) { flags.sheet.throw_ratio = io::parse_uncertain(text); },
      "Known of the projector: distance over image width, e.g. 1.4 or 1.4+-0.02");
  add_parsed(
      app, "--lens-shift",
      [&](const std::string& text) {
        const std::size_t comma = text.find(',');
        if (comma == std::string::npos)
          throw Error(ErrorKind::kInput, "--lens-shift " + text, "it needs two numbers", "give e.g. 0,0.5");
        flags.sheet.lens_shift = {io::parse_uncertain(text.substr(0, comma)),
                                  io::parse_uncertain(text.substr(comma + 1))};
      },
      "Known of the projector: how far its axis is from the centre of the image, in widths and heights, right "
      "and down, e.g. 0,0.5 or 0+-0.01,0.5+-0.02");
  app.add_flag("--square-pixels", flags.sheet.square_pixels, "Known of the projector: fx = fy");
  app.add_option("--known-camera", flags.known_camera,
                 "Rig file of the camera (from calibrate-camera), or another program's calibration of it "
                 "(docs/exchange.md): its lens is kept within the file's sigmas, or as it is where the file "
                 "has none");
}

void declare_models(CLI::App& app, ProjectorFlags& flags) {
  app.add_option("--free", flags.free,
                 "With --points: also estimate skew. Boards estimate skew and k3 anyway")
      ->check(CLI::IsMember({"skew", "k3"}))
      ->delimiter(',');
  app.add_option("--camera-model", flags.camera_model,
                 std::string("The camera's lens: ") + kLensModelHelp + " or fisheye")
      ->capture_default_str();
  app.add_option("--projector-model", flags.projector_model,
                 std::string("The projector's lens: ") + kLensModelHelp)
      ->capture_default_str();
}

/// Which errors are predicted, and how large they may be.
void declare_limits(CLI::App& app, ProjectorFlags& flags) {
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
}

void declare_mirror(CLI::App& app, ProjectorFlags& flags) {
  auto* mirror =
      app.add_option("--mirror-view", flags.mirror_view,
                     "The session was captured in a flat mirror: an image of the board that lies on "
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
}

void declare_check(CLI::App& app, ProjectorFlags& flags) {
  app.add_option("--truth", flags.truth,
                 "A rig file known to be true (a simulation's): report the distance to it");
  app.add_option("--compare", flags.compare,
                 "An earlier rig file of the same devices: the report draws what differs");
  app.add_option(
      "--check", flags.check,
      "Only check a calibration: a rig file, or one of OpenCV, ROS, Kalibr and others (docs/exchange.md)");
  add_parsed(
      app, "--unit", [&](const std::string& text) { flags.metres_per_unit = io::parse_length(text); },
      "Unit of the translation in another program's file (default 1mm)");
}

}  // namespace

void declare_projector(CLI::App& app, ProjectorFlags& flags) {
  declare_group(app, "Input", [&] { declare_input(app, flags); });
  declare_group(app, "Calibration", [&] {
    declare_calibration(app, flags);
    declare_models(app, flags);
  });
  for (const char* name : {"--observations", "--camera-size"}) app.get_option(name)->group("Input");
  declare_group(app, "Known values", [&] { declare_data_sheet(app, flags); });
  declare_group(app, "Accepted error", [&] { declare_limits(app, flags); });
  declare_group(app, "Refresh of a rig", [&] { declare_update(app, flags); });
  declare_group(app, "Through a mirror", [&] { declare_mirror(app, flags); });
  declare_group(app, "Checks", [&] { declare_check(app, flags); });
  app.callback([&app, &flags] {
    require_one_input(app, flags);
    if (!flags.compare.empty() && flags.report.empty() && flags.figures.empty())
      throw CLI::RequiredError("--report or --figures with --compare");
  });
}

std::optional<Rig> load_if_given(const std::filesystem::path& rig_file) {
  if (rig_file.empty()) return std::nullopt;
  return io::load_rig(rig_file);
}

session::SessionContents read_observations(const ProjectorFlags& flags) {
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

}  // namespace procam::tools
