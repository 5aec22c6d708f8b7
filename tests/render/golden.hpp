#pragma once
/// Pictures that were looked at once, kept beside the tests, and what is drawn today against them.
///
///   PROCAM_GOLDEN_UPDATE=1 test_render --gtest_filter='Golden*'     writes them anew (then look at each)
///
/// A pixel may be 2 of 255 off, one pixel in 1000 by more. Where a picture fails, kept, drawn and their
/// difference are written side by side, and the message names that file.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "procam/io/image/images.hpp"

namespace procam {

constexpr int kGoldenTolerance = 2;
constexpr int kGoldenOneIn = 1000;

/// Kept, drawn, and 16 times what they differ by, with a white gap between.
inline ImageU8 side_by_side(const ImageU8& kept, const ImageU8& drawn) {
  constexpr int kGap = 8;
  const int across = std::max(kept.width(), drawn.width()), down = std::max(kept.height(), drawn.height());
  ImageU8 page(3 * across + 2 * kGap, down, 3, 255);
  for (int y = 0; y < down; ++y)
    for (int x = 0; x < across; ++x)
      for (int c = 0; c < 3; ++c) {
        const auto at = [&](const ImageU8& image) {
          return x < image.width() && y < image.height() ? int(image.at(x, y, c)) : 255;
        };
        page.at(x, y, c) = std::uint8_t(at(kept));
        page.at(x + across + kGap, y, c) = std::uint8_t(at(drawn));
        page.at(x + 2 * (across + kGap), y, c) =
            std::uint8_t(std::min(255, 16 * std::abs(at(kept) - at(drawn))));
      }
  return page;
}

/// What is wrong with a picture, in words that name the picture of the difference; empty: nothing. `kept_in`
/// holds the pictures, `failed_in` gets that picture.
inline std::string golden_fault(const std::filesystem::path& kept_in, const std::filesystem::path& failed_in,
                                const std::string& name, const std::string& by, const ImageU8& drawn) {
  const std::filesystem::path file = kept_in / (name + ".png");
  const char* const update =
      "; if it is as it should be, write it with PROCAM_GOLDEN_UPDATE=1 and look at it";
  if (!std::filesystem::exists(file)) return file.string() + " is not there" + update;
  const ImageU8 kept = io::load_image(file).image;
  int off = 0, most = 0;
  if (kept.size() == drawn.size() && kept.channels() == 3)
    for (int y = 0; y < kept.height(); ++y)
      for (int x = 0; x < kept.width(); ++x) {
        int here = 0;
        for (int c = 0; c < 3; ++c) here = std::max(here, std::abs(kept.at(x, y, c) - drawn.at(x, y, c)));
        off += here > kGoldenTolerance;
        most = std::max(most, here);
      }
  else
    off = drawn.width() * drawn.height();
  if (off * kGoldenOneIn <= drawn.width() * drawn.height()) return "";
  std::filesystem::create_directories(failed_in);
  const std::filesystem::path page = failed_in / (name + "_" + by + ".png");
  io::save_image(page, side_by_side(kept, drawn));
  return name + " by " + by + ": " + std::to_string(off) + " pixels are off, by up to " +
         std::to_string(most) + "; kept, drawn and 16 times the difference: " + page.string() + update;
}

inline bool golden_update() {
  const char* asked = std::getenv("PROCAM_GOLDEN_UPDATE");
  return asked && *asked;
}

/// PROCAM_GOLDEN: where they are kept; PROCAM_GOLDEN_FAILED: where what failed is shown.
inline void expect_golden(const std::string& name, const std::string& by, const ImageU8& drawn) {
  EXPECT_EQ(golden_fault(PROCAM_GOLDEN, PROCAM_GOLDEN_FAILED, name, by, drawn), "");
}

}  // namespace procam
