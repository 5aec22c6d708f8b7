/// procam against its peers, on simulated sessions in numbers: whose light lands nearest to the truth?
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "numeric_session.hpp"
#include "peers.hpp"
#include "procam/calibrate/calibrate.hpp"

namespace procam::test {
namespace {

struct PeerCase {
  simulate::Level level;
  bool gray_code;
  DetectorNoise noise;         ///< of procam's detectors
  DetectorNoise opencv_noise;  ///< of OpenCV's, on the same pictures
  double share_of_opencv;      ///< procam's error over OpenCV's: at most
  std::uint64_t seeds;
};

std::string name_of(const PeerCase& which) {
  return std::string(simulate::to_string(which.level)) + (which.gray_code ? "_gray" : "_chessboard");
}

class Peers : public ::testing::TestWithParam<PeerCase> {};

/// RMS over the seeds of each way's error. OpenCV gets corners as good as its own finders', or, as a second
/// figure, procam's, which leaves the way of solving alone; and pixels decoded without an error. One seed may
/// fall either way; over twenty the limits are half as much again as was measured (docs/calibration.md),
/// where the standard error of a ratio is some 20 %. The ratio to the told bundle adjustment compares two
/// solves of the same measurements, whose difference is small against their common error.
TEST_P(Peers, LeaveTheLightFartherFromTheTruth) {
  const PeerCase& which = GetParam();
  const auto pattern =
      session::make_pattern(which.gray_code ? "gray" : "chessboard", simulate::projector_size(which.level));
  calibrate::Options options;
  double ours2 = 0, opencv2 = 0, opencv_given_ours2 = 0, told2 = 0;
  int larger = 0;
  for (std::uint64_t seed = 1; seed <= which.seeds; ++seed) {
    const simulate::SimulatedSession session = simulate::make_session(
        which.level, seed, pattern->on_blank_paper(), {}, simulate::plain_conditions());
    const auto seen_with = [&](const DetectorNoise& noise) {
      return which.gray_code ? numeric_gray_code(session, noise, 100 + seed)
                             : numeric_chessboards(session, noise, 100 + seed);
    };
    const Correspondences data = seen_with(which.noise);
    const auto decoded = [&](std::size_t view, int x, int y) -> std::optional<Vec2> {
      const auto pixel = simulate::projector_pixel_seen_at(session.views[view], Vec2(x, y));
      if (!pixel) return std::nullopt;
      return Vec2(std::round(pixel->x()), std::round(pixel->y()));
    };
    const Eigen::AlignedBox2d core = covered_core(data);
    const double ours = light_rms_mm(calibrate::calibrate_rig(data, options).rig, session.rig(), core);
    const double told = light_rms_mm(told_bundle(data, session, options), session.rig(), core);
    const auto opencv_with = [&](const Correspondences& corners) {
      return light_rms_mm(
          which.gray_code ? opencv_rig_of_gray_code(corners, decoded) : opencv_rig_of_light_points(corners),
          session.rig(), core);
    };
    const double opencv = opencv_with(seen_with(which.opencv_noise)), given_ours = opencv_with(data);
    std::printf("%s seed %llu: procam %.3f mm, OpenCV %.3f (procam's corners: %.3f), told bundle %.3f\n",
                name_of(which).c_str(), static_cast<unsigned long long>(seed), ours, opencv, given_ours,
                told);
    ours2 += ours * ours, opencv2 += opencv * opencv, told2 += told * told;
    opencv_given_ours2 += given_ours * given_ours;
    larger += ours > opencv;
  }
  const auto rms = [&](double sum) { return std::sqrt(sum / double(which.seeds)); };
  std::printf(
      "%s, %llu seeds: procam %.3f mm rms, OpenCV %.3f (%.1f times; with procam's corners %.3f, %.1f times), "
      "told "
      "bundle %.3f (procam %.2f times); farther than OpenCV's in %d\n",
      name_of(which).c_str(), static_cast<unsigned long long>(which.seeds), rms(ours2), rms(opencv2),
      rms(opencv2) / rms(ours2), rms(opencv_given_ours2), rms(opencv_given_ours2) / rms(ours2), rms(told2),
      rms(ours2) / rms(told2), larger);
  EXPECT_LE(rms(ours2), which.share_of_opencv * rms(opencv2));
  // Priors and the averaging over skew and k3 are in one of the two solves alone: where one seed's bundle is
  // near the truth by chance, procam's may be several times as far off.
  if (which.seeds > 1) EXPECT_LE(rms(ours2), 1.3 * rms(told2));
}

// As measured on the rendered pictures. OpenCV's: cornerSubPix (11 x 11) for Gray code;
// findChessboardCornersSB where two boards are in the picture, since findChessboardCorners misses most prints
// there. At level hard both miss all: there OpenCV gets procam's printed corners.
constexpr DetectorNoise kEasyGray{0.003, 0.003}, kPaperGray{0.011, 0.005}, kHardGray{0.025, 0.010},
    kEasyBoards{0.006, 0.005}, kPaperBoards{0.023, 0.017}, kHardBoards{0.10, 0.033};
constexpr DetectorNoise kOpencvEasyGray{0.026, 0}, kOpencvPaperGray{0.025, 0}, kOpencvHardGray{0.047, 0},
    kOpencvEasyBoards{0.18, 0.039}, kOpencvPaperBoards{0.105, 0.055}, kOpencvHardBoards{0.10, 0.079};

std::vector<PeerCase> cases(std::uint64_t seeds) {
  using simulate::Level;
  std::vector<PeerCase> all{{Level::kEasy, true, kEasyGray, kOpencvEasyGray, 0.27, seeds},
                            {Level::kPaper, true, kPaperGray, kOpencvPaperGray, 0.72, seeds},
                            {Level::kHard, true, kHardGray, kOpencvHardGray, 0.33, seeds},
                            {Level::kEasy, false, kEasyBoards, kOpencvEasyBoards, 0.58, seeds},
                            {Level::kPaper, false, kPaperBoards, kOpencvPaperBoards, 0.5, seeds},
                            {Level::kHard, false, kHardBoards, kOpencvHardBoards, 0.23, seeds}};
  if (seeds == 1)
    for (PeerCase& one : all) one.share_of_opencv = 1.2;
  return all;
}
const auto kName = [](const auto& which) { return name_of(which.param); };
INSTANTIATE_TEST_SUITE_P(OneSeed, Peers, ::testing::ValuesIn(cases(1)), kName);
INSTANTIATE_TEST_SUITE_P(TwentySeeds, Peers, ::testing::ValuesIn(cases(20)), kName);

}  // namespace
}  // namespace procam::test
