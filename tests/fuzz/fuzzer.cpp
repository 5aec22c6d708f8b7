// libFuzzer's entry: `procam_fuzz --target=rig tests/fuzz/corpus/rig`; `--list` names the targets.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "fuzz_target.hpp"

namespace procam::fuzz {
namespace {

const Target* chosen = nullptr;

}  // namespace
}  // namespace procam::fuzz

/// libFuzzer passes over flags that begin with two dashes.
extern "C" int LLVMFuzzerInitialize(int* count, char*** arguments) {
  using namespace procam::fuzz;
  constexpr const char* kFlag = "--target=";
  for (int i = 1; i < *count; ++i) {
    if (std::strncmp((*arguments)[i], kFlag, std::strlen(kFlag)) == 0)
      chosen = find_target((*arguments)[i] + std::strlen(kFlag));
    if (std::strcmp((*arguments)[i], "--list") == 0) {
      for (const Target& target : targets()) std::printf("%s\n", target.name);
      std::exit(0);
    }
  }
  if (chosen == nullptr) {
    std::fprintf(stderr, "procam_fuzz: there is no such target; give --target=NAME, see --list\n");
    std::exit(2);
  }
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  procam::fuzz::run(*procam::fuzz::chosen, {reinterpret_cast<const char*>(data), size});
  return 0;
}
