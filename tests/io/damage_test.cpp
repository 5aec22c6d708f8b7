// Damaged files: cut at every byte, bytes changed at random. Nothing but procam::Error may come out.
#include <gtest/gtest.h>

#include <random>

#include "examples.hpp"
#include "procam/io/board_file.hpp"
#include "procam/io/files.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/surface_file.hpp"
#include "scratch.hpp"
#include "support/sanitizer.hpp"

namespace procam::io {
namespace {

using test::Scratch;

struct Case {
  const char* file;
  void (*save)(const std::filesystem::path&);
  void (*load)(const std::filesystem::path&);
};

const Case kCases[] = {
    {"rig.json", [](const auto& path) { save_rig(path, test::example_rig()); },
     [](const auto& path) { (void)load_rig(path); }},
    {"surfaces.json", [](const auto& path) { save_surfaces(path, test::example_surfaces()); },
     [](const auto& path) { (void)load_surfaces(path); }},
    {"surfaces.xml", [](const auto& path) { save_surfaces(path, test::example_surfaces()); },
     [](const auto& path) { (void)load_surfaces(path); }},
    {"solved.xml", [](const auto& path) { save_solved_surfaces(path, test::example_solved_surfaces()); },
     [](const auto& path) { (void)load_solved_surfaces(path); }},
    {"board.json", [](const auto& path) { save_board(path, test::example_boards()[2]); },
     [](const auto& path) { (void)load_board(path); }},
};

class Damage : public testing::TestWithParam<Case> {};
INSTANTIATE_TEST_SUITE_P(Files, Damage, testing::ValuesIn(kCases), [](const auto& tested) {
  std::string name = tested.param.file;
  name[name.find('.')] = '_';
  return name;
});

TEST_P(Damage, EveryTruncationIsRefusedWithTheFilesName) {
  const Scratch scratch;
  const std::filesystem::path path = scratch / GetParam().file;
  GetParam().save(path);
  const std::string whole = read_file(path);
  // All but the last line feed: without it the document is still whole.
  for (std::size_t length = 0; length + 1 < whole.size(); ++length) {
    scratch.write(GetParam().file, whole.substr(0, length));
    const Error error = test::error_of([&] { GetParam().load(path); });
    ASSERT_EQ(error.kind(), ErrorKind::kInput) << length << ": " << error.what();
    ASSERT_TRUE(test::contains(error.subject(), path.string() + ":")) << error.what();
  }
}

TEST_P(Damage, ChangedBytesAreReadOrRefused) {
  const Scratch scratch;
  scratch.write("roof.obj", test::kRoof);  // a surface names it
  save_image(scratch / "leaves.png", ImageU8(5, 3, 3, 200));
  const std::filesystem::path path = scratch / GetParam().file;
  GetParam().save(path);
  const std::string whole = read_file(path);
  std::mt19937 random(11);
  const std::string digits_and_marks = "0123456789eE+-.,:;[]{}<>/=\"' \n&N";
#ifdef PROCAM_ADDRESS_SANITIZER
  // Of solved surfaces all curved ones are tessellated, a hundred times slower than without the sanitizer.
  const int trials = std::string(GetParam().file) == "solved.xml" ? 200 : 1000;
#else
  const int trials = 1000;
#endif
  for (int trial = 0; trial < trials; ++trial) {
    std::string damaged = whole;
    for (unsigned i = 0; i <= random() % 3; ++i) {
      const std::size_t at = random() % damaged.size();
      // Half of the changes are bytes that mean something to a parser.
      damaged[at] = trial % 2 == 0 ? char(random()) : digits_and_marks[random() % digits_and_marks.size()];
    }
    scratch.write(GetParam().file, damaged);
    try {
      GetParam().load(path);
    } catch (const Error& error) {
      ASSERT_TRUE(test::contains(error.subject(), path.string())) << error.what();
    } catch (const std::exception& other) {
      FAIL() << "trial " << trial << ": " << other.what();
    }
  }
}

}  // namespace
}  // namespace procam::io
