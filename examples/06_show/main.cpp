/// Runs a show: a calibrated rig, and everything else from a show file.   example_06_show rig.json show.json
#include <cstdio>

#include "procam/io/rig_file.hpp"
#include "procam/show/run.hpp"

int main(int argc, char** argv) {
  using namespace procam;
  if (argc != 3) {
    std::fprintf(stderr, "usage: %s rig.json show.json\n", argv[0]);
    return 2;
  }
  try {
    const show::ShowReport report = show::run(io::load_rig(argv[1]), show::load_options(argv[2]));
    std::printf("%llu frames\n", (unsigned long long)report.metrics.frames);
  } catch (const Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
