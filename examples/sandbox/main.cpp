/// An AR sandbox: a depth camera and a projector over a box of sand. Heights get colours, every 20 mm a contour line; hands
/// stay dark.
///
///   example_sandbox rig.json                             a Kinect or its kin, onto the projector's display
///   example_sandbox rig.json SOURCE OUTPUT SECONDS       e.g. watch:/run/depth frames:seen 10
///
/// The rig file has the projector and the depth camera: calibrate-projector writes it. The box should fill the middle of
/// the depth image; its edges are omitted.
#include <cstdio>
#include <cstdlib>

#include "procam/io/rig_file.hpp"
#include "procam/show/run.hpp"

namespace {

/// Tells what happens: "sees shape", a camera that is silent.
class Console : public procam::show::ShowListener {
 public:
  void on_start(const std::string& sentence) override { std::printf("%s\n", sentence.c_str()); }
  void on_event(const std::string& sentence) override { std::printf("%s\n", sentence.c_str()); }
};

}  // namespace

int main(int argc, char** argv) {
  using namespace procam;
  if (argc != 2 && argc != 5) {
    std::fprintf(stderr, "usage: %s rig.json [SOURCE OUTPUT SECONDS]\n", argv[0]);
    return 2;
  }
  try {
    show::ShowOptions options;
    options.surfaces = std::string("depth-shape:") + (argc > 2 ? argv[2] : "openni2:");
    options.contents["shape"] = "height:colours,range=-80mm..80mm,contours=20mm";
    options.depth.silhouettes = true;
    options.depth.delay_s = 0.04;  // of a Kinect; `project-live --delay-camera` measures the projector's
    options.delay_s = 0.03;
    options.control = "off";
    if (argc > 2) {
      options.output = argv[3];
      options.duration_s = std::atof(argv[4]);
    }
    Console console;
    const show::ShowReport report = show::run(io::load_rig(argv[1]), options, &console);
    std::printf("%llu frames\n", (unsigned long long)report.metrics.frames);
  } catch (const Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
