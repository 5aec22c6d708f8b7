#pragma once
/// A fuzz target takes any bytes. procam::Error is an answer; every other exception, a failed check() and
/// whatever a sanitizer reports are findings. libFuzzer runs the targets (fuzzer.cpp), and the ordinary tests
/// run them over the kept inputs (regressions_test.cpp). See docs/fuzzing.md.
#include <filesystem>
#include <ostream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "procam/core/base/error.hpp"
#include "procam/io/files.hpp"

namespace procam::fuzz {

struct Target {
  const char* name;
  void (*run)(std::string_view bytes);
  /// Its inputs are JSON documents: the search changes their values as well as their bytes.
  bool is_json = false;
};
inline void PrintTo(const Target& target, std::ostream* out) {
  *out << target.name;
}

const std::vector<Target>& targets();

/// nullptr if there is none of this name.
const Target* find_target(std::string_view name);

/// Passes procam::Error over.
void run(const Target& target, std::string_view bytes);

inline void check(bool holds, const std::string& what) {
  if (!holds) throw std::logic_error(what);
}

/// The JSON document with some of its values changed, removed, doubled and exchanged as the draws say, in one
/// line if it was one; empty where the bytes are no document.
std::string changed_document(std::string_view bytes, std::string_view draws);

/// The texts around the first byte that differs become part of the finding.
void check_same(const std::string& once, const std::string& twice, const std::string& what);

/// A folder of this process, in memory where the system has such a place; removed at the end.
const std::filesystem::path& folder();

/// Writes the bytes to a file of folder(), without the care of io::write_file_atomically().
std::filesystem::path store(const std::string& name, std::string_view bytes);

/// What must not fail: procam::Error becomes a finding.
template <typename Function>
auto must(const char* what, const Function& function) {
  try {
    return function();
  } catch (const Error& error) {
    throw std::logic_error(std::string(what) + ": " + error.what());
  }
}

/// What load() accepts, save() writes, load() reads again, and save() then writes as the same bytes.
template <typename Load, typename Save>
void check_file(const std::string& name, std::string_view bytes, const Load& load, const Save& save) {
  const std::filesystem::path file = store(name, bytes);
  const auto first = load(file);
  must("writing what was read", [&] { save(file, first); });
  const std::string once = io::read_file(file);
  const auto second = must("reading what was written", [&] { return load(file); });
  must("writing again", [&] { save(file, second); });
  check_same(once, io::read_file(file), name);
}

}  // namespace procam::fuzz
