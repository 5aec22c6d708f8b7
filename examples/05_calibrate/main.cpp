// Captures of a printed board under patterns -> rig.json, with a verdict: what calibrate-projector does, in a program.
#include <iostream>

#include "procam/analyze/accept.hpp"
#include "procam/calibrate/calibrate.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/session/reader.hpp"

using namespace procam;

int main(int argc, char** argv) try {
  if (argc != 3) return std::cerr << "usage: 05_calibrate CAPTURES rig.json\n", 2;
  const auto session = session::read(session::open(argv[1]));  // session.json states pattern, board and sizes
  calibrate::Options options;
  options.camera.choose = options.projector.choose =
      true;  // the lens models that predict held-out views best
  auto result = calibrate::calibrate_rig(session.correspondences, options);
  for (const auto& errors : analyze::check_predicted_errors(result))
    std::cout << "predicted error " << analyze::in_words(errors.externally) << "\n";
  result.rig.provenance = session::provenance(session, "calibrate-projector");
  io::save_rig(argv[2], result.rig);
  return result.rig.quality.passed() ? 0 : 1;
} catch (const Error& error) {
  return std::cerr << error.what() << "\n", 2;
}
