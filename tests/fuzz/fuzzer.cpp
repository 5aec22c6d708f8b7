// libFuzzer's entry: `procam_fuzz --target=rig tests/fuzz/corpus/rig`; `--list` names the targets.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <random>

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

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

/// JSON is changed as a document every second time, else as bytes.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned seed) {
  if (procam::fuzz::chosen->is_json && seed % 2 == 0) {
    std::minstd_rand random(seed);
    std::string draws(8 + seed / 2 % 32, '\0');
    for (char& byte : draws) byte = char(random() >> 8);
    const std::string changed =
        procam::fuzz::changed_document({reinterpret_cast<const char*>(data), size}, draws);
    if (!changed.empty() && changed.size() <= max_size) {
      std::memcpy(data, changed.data(), changed.size());
      return changed.size();
    }
  }
  return LLVMFuzzerMutate(data, size, max_size);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  procam::fuzz::run(*procam::fuzz::chosen, {reinterpret_cast<const char*>(data), size});
  return 0;
}
