/// Patterns of other programs, frame by frame: what was shown is read back.
#include "procam/pattern/frame_sequence.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "procam/pattern/stripe_edges.hpp"
#include "support/expect_error.hpp"
#include "support/gray_code_world.hpp"

namespace procam::pattern {
namespace {

using test::GrayCodeWorld;
using Kind = SequenceFrame::Kind;

const ImageSize kSize{107, 93};
constexpr double kDegree = 3.14159265358979323846 / 180;

void add_wave(FrameSequence& sequence, StripeAxis axis, double period,
              const std::vector<double>& phases_deg) {
  for (const double phase : phases_deg)
    sequence.frames.push_back({Kind::kPhase, axis, 0, false, period, phase * kDegree});
}

std::vector<double> equal_steps(int count, double first = 0) {
  std::vector<double> phases;
  for (int k = 0; k < count; ++k) phases.push_back(first + 360.0 * k / count);
  return phases;
}

void add_bits(FrameSequence& sequence, StripeAxis axis, int bits, bool inverse) {
  for (int bit = 0; bit < bits; ++bit) sequence.frames.push_back({Kind::kGray, axis, bit, inverse});
}

struct PhaseCase {
  const char* name;
  FrameSequence (*make)();
  double max_rms;  ///< of the decoded positions under noise, blur and a tone curve; twice what is measured
};

const PhaseCase kPhaseCases[] = {
    // No wave spans the frame. Rows first.
    {"FourStepsOfThreeLikeWaves",
     [] {
       FrameSequence all;
       for (const StripeAxis axis : {StripeAxis::kRow, StripeAxis::kColumn})
         for (const double period : {12.0, 13.1, 14.9}) add_wave(all, axis, period, equal_steps(4));
       return all;
     },
     0.055},
    // By a sine: phases from 90 degrees. Three steps feel all of a tone curve.
    {"ThreeStepsFromCoarseToFine",
     [] {
       FrameSequence all;
       for (const StripeAxis axis : {StripeAxis::kColumn, StripeAxis::kRow})
         for (const double period : {107.0, 40.0, 14.0}) add_wave(all, axis, period, equal_steps(3, 90));
       return all;
     },
     0.27},
    {"UnequalPhases",
     [] {
       FrameSequence all;
       for (const StripeAxis axis : {StripeAxis::kColumn, StripeAxis::kRow})
         for (const double period : {120.0, 18.0}) add_wave(all, axis, period, {0, 55, 130, 190, 235, 310});
       return all;
     },
     0.1},
    // Stripes as wide as the wave, no inverse, white or black: the threshold is the waves' mean.
    {"GrayCodeOfWholeWaves",
     [] {
       FrameSequence all;
       all.step = 14;
       for (const StripeAxis axis : {StripeAxis::kColumn, StripeAxis::kRow}) {
         add_bits(all, axis, 3, false);
         add_wave(all, axis, 14, equal_steps(5));
         all.frames.push_back({});
       }
       return all;
     },
     0.08},
};

class PhaseSequences : public testing::TestWithParam<PhaseCase> {};
INSTANTIATE_TEST_SUITE_P(Kinds, PhaseSequences, testing::ValuesIn(kPhaseCases),
                         [](const auto& tested) { return tested.param.name; });

/// A camera with a tone curve, blur of projector and camera, and noise of two grey levels.
TEST_P(PhaseSequences, AreReadBack) {
  const FrameSequence sequence = GetParam().make();
  GrayCodeWorld world;
  world.gamma = 1.5;
  world.projector_blur = 0.9, world.camera_blur = 0.8;
  world.noise_at_black = 4;
  world.white_level = 190;
  const std::vector<ImageU8> captures = test::capture_all(world, frames(sequence, kSize));
  const LightMap map = decode(test::views_of(captures), sequence, kSize);
  double sum = 0;
  int decoded = 0, lit = 0, wrong_wave = 0;
  for (int y = 3; y < world.camera.height - 3; ++y)
    for (int x = 3; x < world.camera.width - 3; ++x) {
      const Vec2 truth = world.projector_pixel(Vec2(x, y));
      // Waves as long as the frame do not tell its ends apart.
      if (truth.minCoeff() < 4 || truth.x() > kSize.width - 5 || truth.y() > kSize.height - 5) continue;
      ++lit;
      const auto pixel = map.projector_pixel(x, y);
      if (!pixel) continue;
      ++decoded;
      const Vec2 error = *pixel - truth;
      if (error.cwiseAbs().maxCoeff() > 5)
        ++wrong_wave;
      else
        sum += error.squaredNorm();
    }
  const double rms = std::sqrt(sum / (2.0 * (decoded - wrong_wave)));
  EXPECT_LT(rms, GetParam().max_rms);
  EXPECT_LE(wrong_wave, decoded / 500);
  // Stripes of a whole wave lose a tenth at either end, of both axes.
  EXPECT_GT(decoded, (sequence.step > 1 ? 0.55 : 0.9) * lit);
}

/// The order of the scanning program of Brown University: white and black first, as many bits for rows as for
/// columns, codes centred in their range; and one from the finest bit, rows first, inverses after all
/// patterns.
TEST(GraySequences, OfAnyOrderAreReadLikeProcamsOwn) {
  FrameSequence centred;
  centred.offset = {10, 17};  // (2^7 - 107) / 2, (2^7 - 93) / 2
  centred.frames = {{Kind::kWhite}, {Kind::kBlack}};
  for (const StripeAxis axis : {StripeAxis::kColumn, StripeAxis::kRow})
    for (int bit = 7; bit-- > 0;)
      for (const bool inverse : {false, true}) centred.frames.push_back({Kind::kGray, axis, bit, inverse});
  FrameSequence backwards;
  for (const StripeAxis axis : {StripeAxis::kRow, StripeAxis::kColumn})
    for (const bool inverse : {false, true}) add_bits(backwards, axis, 7, inverse);
  backwards.frames.push_back({Kind::kIgnored});

  GrayCodeWorld world;
  world.square = 20;
  const GrayCode own{kSize, 1};
  const auto own_captures = test::capture_all(world, frames(own));
  const DecodedMap expected = decode(test::views_of(own_captures), own);
  for (const FrameSequence& sequence : {centred, backwards}) {
    require_decodable(sequence, kSize);
    const auto captures = test::capture_all(world, frames(sequence, kSize));
    const GrayCaptures ordered = gray_captures(test::views_of(captures), sequence, kSize);
    EXPECT_TRUE(ordered.has_all_inverses);
    const DecodedMap map = decode(ordered.captures, ordered.gray_code);
    int differing = 0, decoded = 0;
    for (int y = 0; y < world.camera.height; ++y)
      for (int x = 0; x < world.camera.width; ++x) {
        if (!map.decoded(x, y) || !expected.decoded(x, y)) continue;
        ++decoded;
        // Other bits have their edges at other stripes.
        differing += std::abs(map.columns.at(x, y) - sequence.offset[0] - expected.columns.at(x, y)) > 1 ||
                     std::abs(map.rows.at(x, y) - sequence.offset[1] - expected.rows.at(x, y)) > 1;
      }
    EXPECT_GT(decoded, 15000);
    EXPECT_LE(differing, decoded / 200);
  }
}

/// Stripe edges, by the truth, with the frames of one order and fewer of them each time.
TEST(GraySequences, AbsentFramesAreReplaced) {
  GrayCodeWorld world;
  world.noise_at_black = 2;
  const auto edges_rms = [&](bool inverses, bool ends) {
    FrameSequence sequence;
    for (const StripeAxis axis : {StripeAxis::kColumn, StripeAxis::kRow}) {
      add_bits(sequence, axis, 7, false);
      if (inverses) add_bits(sequence, axis, 7, true);
    }
    if (ends) sequence.frames.insert(sequence.frames.end(), {{Kind::kWhite}, {Kind::kBlack}});
    const auto captures = test::capture_all(world, frames(sequence, kSize));
    const GrayCaptures ordered = gray_captures(test::views_of(captures), sequence, kSize);
    EXPECT_EQ(ordered.has_all_inverses, inverses);
    EXPECT_EQ(ordered.original.back(), ends ? int(captures.size()) - 1 : -1);
    const DecodedMap map = decode(ordered.captures, ordered.gray_code);
    double sum = 0;
    int count = 0;
    for (const StripeEdge& edge : stripe_edges(ordered.captures, map, ordered.gray_code)) {
      const Vec2 truth = world.projector_pixel(edge.camera_pixel);
      if (truth.minCoeff() < 2 || truth.x() > kSize.width - 3 || truth.y() > kSize.height - 3) continue;
      const double error = edge.projector_coordinate - truth[edge.axis == StripeAxis::kColumn ? 0 : 1];
      sum += error * error, ++count;
    }
    EXPECT_GT(count, 15000);
    return std::sqrt(sum / count);
  };
  const double all = edges_rms(true, true), no_ends = edges_rms(true, false),
               no_inverses = edges_rms(false, true);
  std::printf("edges: %.4f px; without white and black %.4f; without inverses %.4f\n", all, no_ends,
              no_inverses);
  EXPECT_LT(all, 0.04);  // 0.018, 0.017 and 0.021 px
  EXPECT_LT(no_ends, 1.3 * all);
  // White and black take the place of the second measurement: sqrt(3) of the noise.
  EXPECT_LT(no_inverses, 2.2 * all);
}

/// A description that is not that of the frames. A sine for a cosine gave a rig that was 289 mm off at 2 m and passed all checks.
TEST(PhaseSequence, ThatIsDescribedWronglyIsFound) {
  const auto described = [](double coarse, double fine, int steps, double first_deg, bool backwards) {
    FrameSequence all;
    for (const StripeAxis axis : {StripeAxis::kColumn, StripeAxis::kRow})
      for (const double period : {coarse, fine}) {
        std::vector<double> phases = equal_steps(steps, first_deg);
        if (backwards) std::reverse(phases.begin() + 1, phases.end());
        add_wave(all, axis, period, phases);
      }
    return all;
  };
  GrayCodeWorld world;
  world.gamma = 1.5;
  world.projector_blur = 0.9, world.camera_blur = 0.8;
  world.noise_at_black = 4;
  world.white_level = 190;
  const FrameSequence shown = described(120, 18, 4, 0, false);
  const std::vector<ImageU8> captures = test::capture_all(world, frames(shown, kSize));
  const auto remark = [&](const FrameSequence& as_described) {
    const Diagnostics found = decode(test::views_of(captures), as_described, kSize).diagnostics;
    const Diagnostic* disagree = found.find("waves_disagree");
    return disagree == nullptr ? std::string() : disagree->message;
  };
  EXPECT_EQ(remark(shown), "");
  const std::string sine = remark(described(120, 18, 4, 90, false));
  EXPECT_NE(sine.find("The columns' wave of 18 pixels does not fit the longer wave, by 0.4"),
            std::string::npos)
      << sine;
  EXPECT_NE(remark(described(120, 14, 4, 0, false)).find("another one at each pixel"), std::string::npos);
  EXPECT_NE(remark(described(145, 18, 4, 0, false)).find("wave of 18 pixels does not fit"),
            std::string::npos);
  EXPECT_NE(remark(described(120, 18, 4, 0, true)).find("wave of 18 pixels does not fit"), std::string::npos);
}

/// Two captures of phase steps in each other's place, with blur, noise and a tone curve. Of four steps two exchanges look
/// alike, and those of the first with the third and the second with the fourth mirror the wave: the waves disagree then.
TEST(PhaseSequence, ExchangedCapturesAreNamed) {
  GrayCodeWorld world;
  world.gamma = 1.8;
  world.projector_blur = 0.9, world.camera_blur = 0.8;
  world.noise_at_black = 2;
  world.white_level = 190;
  FrameSequence shown;
  for (const StripeAxis axis : {StripeAxis::kColumn, StripeAxis::kRow}) {
    add_wave(shown, axis, 18, equal_steps(8));
    add_wave(shown, axis, 120, equal_steps(4));
  }
  const std::vector<ImageU8> images = test::capture_all(world, frames(shown, kSize));
  const std::vector<ViewU8> captures = test::views_of(images);
  EXPECT_EQ(decode(captures, shown, kSize).diagnostics.find("frames_exchanged"), nullptr);
  int named = 0, alone = 0, mirrored = 0;
  for (int a = 0; a < 12; ++a)
    for (int b = a + 1; b < int(captures.size()); ++b) {
      if (b > 12 && b % 5 != 0) continue;
      std::vector<ViewU8> exchanged = captures;
      std::swap(exchanged[std::size_t(a)], exchanged[std::size_t(b)]);
      const Diagnostics found = decode(exchanged, shown, kSize).diagnostics;
      const Diagnostic* remark = found.find("frames_exchanged");
      const bool mirrors = a + 2 == b && a >= 8 && b < 12;
      EXPECT_EQ(remark == nullptr, mirrors) << a << " and " << b;
      if (remark == nullptr) {
        EXPECT_NE(found.find("waves_disagree"), nullptr) << a << " and " << b;
        ++mirrored;
        continue;
      }
      const std::string pair = "frame " + std::to_string(a) + " and frame " + std::to_string(b);
      EXPECT_NE(remark->message.find(pair), std::string::npos) << pair << ": " << remark->message;
      ++named;
      alone += remark->message.find(", or frame ") == std::string::npos;
    }
  EXPECT_EQ(mirrored, 2);
  EXPECT_EQ(named, 66 - 2 + 12 * 3);
  EXPECT_GE(alone, named - 8);
}

TEST(FrameSequences, ThatCannotBeDecodedAreRefused) {
  const auto expect = [](const FrameSequence& sequence, const std::string& words) {
    EXPECT_ERROR(require_decodable(sequence, kSize), kInput, words);
  };
  FrameSequence gray;
  add_bits(gray, StripeAxis::kColumn, 7, false);
  add_bits(gray, StripeAxis::kRow, 7, false);
  expect(gray, "neither inverse frames nor a white one");
  gray.frames.push_back({Kind::kWhite});
  require_decodable(gray, kSize);
  FrameSequence changed = gray;
  changed.frames[3] = {Kind::kIgnored};
  expect(changed, "bit 3 of the columns is missing");
  changed = gray;
  changed.frames[3].bit = 2;
  expect(changed, "frames 2 and 3 are both columns bit 2");
  FrameSequence waves;
  add_wave(waves, StripeAxis::kColumn, 120, equal_steps(4));
  expect(waves, "no waves of rows");
  add_wave(waves, StripeAxis::kRow, 40, equal_steps(4));
  expect(waves, "same phases again after 40 pixels");
  add_wave(waves, StripeAxis::kRow, 30, equal_steps(4));
  require_decodable(waves, kSize);  // 120 pixels together
  add_wave(waves, StripeAxis::kColumn, 9, {0, 180, 0});
  expect(waves, "3 phases of the columns' wave of 9 pixels do not determine it");
  waves.frames.resize(waves.frames.size() - 3);
  add_bits(waves, StripeAxis::kColumn, 7, false);
  expect(waves, "Gray code is of columns alone");
  EXPECT_ERROR(gray_captures({}, gray, kSize), kInput, "0 frames where the pattern has 15");
}

}  // namespace
}  // namespace procam::pattern
