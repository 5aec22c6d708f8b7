#include "render/golden.hpp"

#include "render/golden_scenes.hpp"

namespace procam {
namespace {

namespace fs = std::filesystem;

// By plain code and by vectors of each width, which must be the same to the bit.
TEST(Golden, EverySurfaceAndFilterByTheCpu) {
  for (const GoldenScene& golden : golden_scenes()) {
    const ImageU8 drawn = render::render(golden.scene, golden.projector, golden.options);
    if (golden_update()) io::save_image(fs::path(PROCAM_GOLDEN) / (golden.name + ".png"), drawn);
    expect_golden(golden.name, "cpu", drawn);
    for (const int bits : {0, 256}) {
      render::RenderOptions narrower = golden.options;
      narrower.vector_bits = bits;
      const ImageU8 other = render::render(golden.scene, golden.projector, narrower);
      EXPECT_TRUE(std::equal(drawn.data(), drawn.data() + 160 * 120 * 3, other.data()))
          << golden.name << ", " << bits << " bits";
    }
  }
}

// The suite itself: a wrong picture fails, and shows what is wrong where it says so.
TEST(Golden, ShowsWhatIsWrong) {
  const fs::path folder = fs::path(::testing::TempDir()) / "procam_golden";
  fs::remove_all(folder);
  fs::create_directories(folder / "kept");
  ImageU8 kept(160, 120, 3, 90), drawn = kept;
  io::save_image(folder / "kept" / "wall.png", kept);
  const auto fault = [&](const std::string& name) {
    return golden_fault(folder / "kept", folder / "failed", name, "cpu", drawn);
  };
  for (int i = 0; i < 160 * 120 * 3; ++i) drawn.data()[i] = 92;  // all a little
  for (int x = 0; x < 19; ++x) drawn.at(x, 7) = 200;             // one in 1000 by much
  EXPECT_EQ(fault("wall"), "");
  EXPECT_FALSE(fs::exists(folder / "failed"));
  drawn.at(30, 9, 2) = 200;
  const std::string message = fault("wall");
  const fs::path page = folder / "failed" / "wall_cpu.png";
  EXPECT_NE(message.find(page.string()), std::string::npos) << message;
  EXPECT_NE(message.find("20 pixels"), std::string::npos) << message;
  const ImageU8 shown = io::load_image(page).image;
  ASSERT_EQ(shown.size(), ImageSize({3 * 160 + 16, 120}));
  EXPECT_EQ(shown.at(30, 9, 2), 90);
  EXPECT_EQ(shown.at(168 + 30, 9, 2), 200);
  EXPECT_EQ(shown.at(336 + 30, 9, 2), 255);
  EXPECT_EQ(shown.at(336 + 80, 90, 0), 32);
  EXPECT_NE(fault("other").find("PROCAM_GOLDEN_UPDATE"), std::string::npos);
  drawn = ImageU8(80, 60, 3);
  EXPECT_NE(fault("wall"), "") << "of another size";
  fs::remove_all(folder);
}

}  // namespace
}  // namespace procam
