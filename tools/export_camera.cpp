/// export-camera: rig.json (+ pose.json) -> the projector as a camera of another program, as text.
#include <CLI/CLI.hpp>

#include "common/cli.hpp"
#include "procam/core/rig/room_frames.hpp"
#include "procam/io/exchange/camera_settings.hpp"
#include "procam/io/files.hpp"
#include "procam/io/pose_file.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/text.hpp"

namespace procam::tools {
namespace {

struct Flags {
  std::string rig, projector, pose, output;
  io::CameraProgram program = io::CameraProgram::kBlender;
  std::optional<io::WorldUp> up;
  io::ClipPlanes clip;
};

void declare(CLI::App& app, Flags& flags) {
  app.add_option("--rig", flags.rig, "rig.json of calibrate-projector")->required();
  add_parsed(
      app, "--for", [&](const std::string& text) { flags.program = io::parse_camera_program(text); },
      "The program that draws; opengl: glFrustum, projection and view matrix")
      ->required();
  app.add_option("--projector", flags.projector, "Name of the device, for a rig with several");
  app.add_option(
      "--pose", flags.pose,
      "pose.json between 'world' and 'projector', 'rig' or a camera of the rig; without it the rig "
      "is the world");
  add_parsed(
      app, "--world-up", [&](const std::string& text) { flags.up = io::parse_world_up(text); },
      "Upward axis of the world: z (x forward; as in ROS), y (as in OpenGL) or -y (an optical "
      "frame) [z; -y without --pose]");
  add_parsed(
      app, "--near", [&](const std::string& text) { flags.clip.near = io::parse_length(text); },
      "Near clip plane [10cm]");
  add_parsed(
      app, "--far", [&](const std::string& text) { flags.clip.far = io::parse_length(text); },
      "Far clip plane [100m]");
  app.add_option("-o,--output", flags.output, "Text file; without it the text is printed");
}

ExitCode describe(const Flags& flags, Console& console) {
  if (!(flags.clip.near > 0 && flags.clip.far > flags.clip.near))
    throw Error(ErrorKind::kInput, "--near and --far",
                "the far plane does not lie beyond a positive near one", "give e.g. --near 10cm --far 100m");
  const Rig rig = io::load_rig(flags.rig);
  const RigProjector& projector = rig.projector(flags.projector);
  Pose world_from_projector = projector.rig_from_projector;
  io::WorldUp up = io::WorldUp::kMinusY;
  if (!flags.pose.empty()) {
    const FrameTree room = room_frames(rig, projector, io::load_pose(flags.pose));
    world_from_projector = room.get("world", projector.name).pose;
    up = io::WorldUp::kZ;
  }
  const io::CameraSettings settings =
      io::camera_settings(flags.program, projector, world_from_projector, flags.up.value_or(up), flags.clip);

  if (flags.output.empty()) {
    console.say(settings.text.substr(0, settings.text.size() - 1));
  } else {
    io::write_file_atomically(flags.output, settings.text);
    console.say("wrote " + flags.output);
    console.summary().set("/files", std::vector<std::string>{flags.output});
  }
  console.report(settings.diagnostics);
  console.summary().set("/projector", projector.name);
  console.summary().set("/world", flags.pose.empty() ? "rig" : "world");
  for (const auto& [name, numbers] : settings.values) console.summary().set("/settings/" + name, numbers);
  console.summary().set("/render_size", io::format_size(settings.render_size));
  return exit_code(settings.diagnostics);
}

}  // namespace
}  // namespace procam::tools

int main(int argc, char** argv) {
  using namespace procam::tools;
  Flags flags;
  return run_tool(
      argc, argv,
      {"export-camera",
       "Prints the camera settings for another program, so that its image, sent to the projector, "
       "fits the room."},
      [&](CLI::App& app) { declare(app, flags); },
      [&](Console& console) { return describe(flags, console); });
}
