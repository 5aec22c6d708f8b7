/// procam-convert: a calibration of any program that procam reads -> the formats of other programs, or rig.json.
#include <CLI/CLI.hpp>

#include "common/cli.hpp"
#include "procam/io/exchange/calibration_export.hpp"
#include "procam/io/exchange/calibration_file.hpp"
#include "procam/io/files.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/text.hpp"

namespace procam::tools {
namespace {

struct Flags {
  std::string input, device, output;
  std::optional<io::CalibrationFormat> format;  ///< nullopt: procam's own
  io::CalibrationContext context;
  std::string mount;
};

void declare(CLI::App& app, Flags& flags) {
  app.add_option("INPUT", flags.input,
                 "rig.json, or a calibration of OpenCV, ROS, Kalibr, mrcal, COLMAP, glTF, SDF, or K and D")
      ->required();
  add_parsed(
      app, "--format",
      [&](const std::string& text) {
        if (text != "procam") flags.format = io::parse_calibration_format(text);
      },
      "What to write; procam is rig.json")
      ->required();
  app.add_option("--device", flags.device,
                 "Camera or projector to write; needed for opencv, ros and mrcal if INPUT has several");
  app.add_option("--mount", flags.mount,
                 "mount.json of calibrate-mount, for urdf and sdf: the rig on its robot");
  add_parsed(
      app, "--camera-size",
      [&](const std::string& text) { flags.context.camera_size = io::parse_size(text); },
      "Image size of the camera, if INPUT does not state it, e.g. 1280x960");
  add_parsed(
      app, "--projector-size",
      [&](const std::string& text) { flags.context.projector_size = io::parse_size(text); },
      "Size of the projector's frame, if INPUT does not state it");
  add_parsed(
      app, "--unit",
      [&](const std::string& text) {
        flags.context.metres_per_unit = io::parse_length(text);
        if (!(flags.context.metres_per_unit > 0))
          throw Error(ErrorKind::kInput, "'" + text + "'", "it is no unit of length",
                      "give e.g. 1mm or 25mm");
      },
      "Unit of the translations, if INPUT does not state it [1mm]");
  app.add_option("-o,--output", flags.output, "File to write; without it the text is printed");
}

ExitCode convert(const Flags& flags, Console& console) {
  const Rig rig = io::load_calibration(flags.input, flags.context);
  if (!flags.format && flags.output.empty())
    throw Error(ErrorKind::kInput, "--format procam", "a rig is written to a file", "give -o rig.json");
  if (!flags.format && !(flags.device.empty() && flags.mount.empty()))
    throw Error(ErrorKind::kInput, flags.device.empty() ? "--mount" : "--device",
                "rig.json holds all devices and no mount", "leave it out");
  Diagnostics diagnostics;
  if (!flags.format) {
    io::save_rig(flags.output, rig);
  } else {
    const io::ForeignCalibration converted = io::export_calibration(
        *flags.format, rig, flags.device,
        flags.mount.empty() ? std::nullopt : std::optional(io::load_mount(flags.mount)));
    diagnostics = converted.diagnostics;
    if (flags.output.empty())
      console.say(converted.text.substr(0, converted.text.size() - 1));
    else
      io::write_file_atomically(flags.output, converted.text);
  }
  if (!flags.output.empty()) {
    console.say("wrote " + flags.output);
    console.summary().set("/files", std::vector<std::string>{flags.output});
  }
  console.report(diagnostics);
  return exit_code(diagnostics);
}

}  // namespace
}  // namespace procam::tools

int main(int argc, char** argv) {
  using namespace procam::tools;
  Flags flags;
  return run_tool(
      argc, argv, {"procam-convert", "Converts calibrations between procam and other programs."},
      [&](CLI::App& app) { declare(app, flags); }, [&](Console& console) { return convert(flags, console); });
}
