/// Rendered sessions with truth, through every stage: are the reported sigmas correct, and is the light in
/// its place?
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "peers.hpp"
#include "procam/analyze/light_error.hpp"
#include "procam/calibrate/calibrate.hpp"
#include "procam/detect/board_artwork.hpp"
#include "procam/pattern/gray_code.hpp"
#include "procam/pattern/projected_board.hpp"
#include "procam/session/reader.hpp"
#include "procam/simulate/session.hpp"

namespace procam::test {
namespace {

/// A session as procam reads it, and what its peers need beside that.
struct Seen {
  Correspondences data;
  simulate::SimulatedSession session;  ///< only the views in `data`
  std::vector<DecodedMap> decoded;     ///< Gray code, by view of `own_corners`: every bit decided
  Correspondences own_corners;         ///< the printed and projected corners as OpenCV finds them
};

/// Print and light of a pair of captures as OpenCV finds them: the light in what the pattern takes away.
/// Which of the light's corners is the first, it is told by procam's.
View opencv_view_of_pair(const session::BoardView& found, const std::vector<ViewU8>& captures,
                         const Chessboard& print, const Chessboard& light) {
  const ViewU8 &lit = captures[0], &with_pattern = captures[1];
  ImageU8 difference(lit.size());
  for (int y = 0; y < lit.height; ++y)
    for (int x = 0; x < lit.width; ++x)
      difference.at(x, y) = std::uint8_t(255 - std::abs(int(lit.at(x, y)) - int(with_pattern.at(x, y))));
  View view{found.name, {opencv_corners_by_sectors(lit, print), {}}};
  std::vector<Observation> corners = opencv_corners_by_sectors(difference, light);
  if (corners.size() != found.light_points.size()) return view;
  const auto distance = [&] {
    double sum = 0;
    for (std::size_t i = 0; i < corners.size(); ++i)
      sum += (corners[i].pixel - found.light_points[i].camera_pixel).norm();
    return sum;
  };
  const double as_found = distance();
  std::reverse(corners.begin(), corners.end());
  if (distance() > as_found) std::reverse(corners.begin(), corners.end());
  view.light_points = found.light_points;
  for (std::size_t i = 0; i < corners.size(); ++i) view.light_points[i].camera_pixel = corners[i].pixel;
  return view;
}

/// Through the reading that the tools use, without the files.
Seen look_at(const simulate::SimulatedSession& session, const std::string& pattern_text = "gray",
             bool for_peers = false,
             const std::function<void(std::size_t view, ImageU8& capture)>& spoil = {}) {
  const ImageSize projector_size = session.rig().projector().projector.size();
  const auto pattern = session::make_pattern(pattern_text, projector_size);
  const Board board = session.board().layout;
  Seen seen{{}, session, {}, {}};
  std::vector<session::BoardView> views;
  for (std::size_t v = 0; v < session.views.size(); ++v) {
    std::vector<ImageU8> images = simulate::capture_view(session, v, pattern->frames());
    if (spoil)
      for (ImageU8& image : images) spoil(v, image);
    const std::vector<ViewU8> captures(images.begin(), images.end());
    views.push_back(pattern->read(std::to_string(v), captures, board));
    if (!for_peers) continue;
    if (pattern_text != "gray") {
      const View own =
          opencv_view_of_pair(views.back(), captures, std::get<Chessboard>(session.board().layout),
                              pattern::chessboard_filling(projector_size));
      if (!own.observations[0].empty()) seen.own_corners.views.push_back(own);
      continue;
    }
    const std::vector<Observation> corners =
        opencv_corners(captures[captures.size() - 2], std::get<Chessboard>(session.board().layout));
    if (corners.empty()) continue;
    seen.own_corners.views.push_back({std::to_string(v), {corners, {}}});
    seen.decoded.push_back(
        pattern::decode(captures, {projector_size}, pattern::DecodeOptions{5, /*bit_sigmas=*/0}));
  }
  seen.data = session::join(
      board, session::session_devices(session.rig().camera().camera.size, projector_size), views);
  seen.own_corners.board = board;
  seen.own_corners.devices = seen.data.devices;
  seen.session.views.clear();
  for (const View& view : seen.data.views) seen.session.views.push_back(session.views[std::stoul(view.name)]);
  return seen;
}

/// The light's distance from its true place over the covered core, by procam and by its peers.
struct Compared {
  double ours = 0, opencv = 0, told = 0;  ///< squared millimetres, summed over sessions
};

void compare(const Seen& seen, const Rig& estimated, const calibrate::Options& options, Compared& sums) {
  const Rig& truth = seen.session.rig();
  const Eigen::AlignedBox2d core = covered_core(seen.data);
  const auto decoded = [&](std::size_t view, int x, int y) -> std::optional<Vec2> {
    const DecodedMap& map = seen.decoded[view];
    if (x < 0 || y < 0 || x >= map.columns.width() || y >= map.columns.height()) return std::nullopt;
    return map.projector_pixel(x, y);
  };
  const double ours = light_rms_mm(estimated, truth, core);
  const double opencv =
      light_rms_mm(seen.decoded.empty() ? opencv_rig_of_light_points(seen.own_corners)
                                        : opencv_rig_of_gray_code(seen.own_corners, decoded),
                   truth, core);
  const double told = light_rms_mm(told_bundle(seen.data, seen.session, options), truth, core);
  std::printf("  light from 1 to 3 m: procam %.3f mm rms, OpenCV %.3f, told bundle %.3f\n", ours, opencv,
              told);
  sums.ours += ours * ours, sums.opencv += opencv * opencv, sums.told += told * told;
}

/// Standard scores of all reported parameters.
std::vector<std::pair<std::string, double>> scores(const Rig& rig, const Rig& truth) {
  std::vector<std::pair<std::string, double>> result;
  const auto add = [&](const std::string& name, double error) {
    if (rig.covariance.index_of(name)) result.emplace_back(name, error / rig.covariance.sigma(name));
  };
  const auto add_lens = [&](const std::string& device, const Camera& estimated, const Camera& true_lens) {
    const VecX error = parameters_of(estimated) - parameters_of(true_lens);
    const std::vector<std::string> names = parameter_names(estimated);
    for (std::size_t i = 0; i < names.size(); ++i) add(device + "." + names[i], error[Eigen::Index(i)]);
  };
  add_lens("camera", rig.camera().camera, truth.camera().camera);
  add_lens("projector", rig.projector().projector.inverse_camera, truth.projector().projector.inverse_camera);
  const Vec6 xi =
      se3_log(rig.projector().rig_from_projector * truth.projector().rig_from_projector.inverse());
  for (int i = 0; i < 6; ++i) add(pose_increment_names("rig_from_projector")[std::size_t(i)], xi[i]);
  return result;
}

struct LevelCase {
  simulate::Level level;
  std::uint64_t seeds;      ///< 1 .. seeds
  bool with_peers = false;  ///< OpenCV searches for minutes for a board half in the dark
};

/// Parameters of sessions, by the size of their errors in reported sigmas.
struct Coverage {
  int total = 0, in_two = 0, in_three = 0;
  double squares = 0;   ///< of the scores
  std::string outside;  ///< three sigmas, with the scores

  void add(const Rig& rig, const Rig& truth) {
    for (const auto& [name, score] : scores(rig, truth)) {
      ++total;
      squares += score * score;
      in_two += std::abs(score) <= 2;
      in_three += std::abs(score) <= 3;
      if (std::abs(score) > 3) outside += " " + name + " " + std::to_string(score);
    }
  }
};

class SimulatedSessions : public ::testing::TestWithParam<LevelCase> {};

/// Under the level's own conditions: gamma, glare, indirect light, defocus, skew and k3; level hard with its
/// dark, overexposed, moved and stale views. Some 26 parameters a seed. Were the sigmas exact, 95.4 % would
/// lie inside two of them and 99.7 % inside three. Sigmas may not be too large either: over five seeds
/// of paper and hard the mean squared score is at least 0.5 and the predicted light within a factor of two of the true
/// one (RMS), however the surface is located. Exact sigmas have a score of 1 with a standard error of 0.22
/// (parameters of one rig count as 8 independent ones), and leave the limits in 2 % of draws.
TEST_P(SimulatedSessions, TruthLiesInsideTheReportedSigmas) {
  Coverage all;
  Vec2 predicted_squares = Vec2::Zero(), actual_squares = Vec2::Zero();  // located externally, by the camera
  Compared sums;
  const simulate::Level level = GetParam().level;
  for (std::uint64_t seed = 1; seed <= GetParam().seeds; ++seed) {
    const simulate::SimulatedSession session = simulate::make_session(level, seed);
    const Seen seen = look_at(session, "gray", GetParam().with_peers);
    const calibrate::CalibrationResult result = calibrate::calibrate_rig(seen.data);
    EXPECT_TRUE(result.rig.quality.passed()) << "seed " << seed;
    EXPECT_EQ(result.rig.quality.views_used, int(session.views.size())) << "seed " << seed;
    const analyze::LightErrors both_predicted = analyze::predicted_light_errors(result.rig, 2.0);
    const analyze::LightErrors both = analyze::true_light_errors(result.rig, session.rig(), 2.0);
    const analyze::LightError &predicted = both_predicted.externally, &actual = both.externally;
    const double by_camera = both.of(analyze::SurfaceLocated::kByCamera).rms_mm;
    const double predicted_by_camera = both_predicted.of(analyze::SurfaceLocated::kByCamera).rms_mm;
    predicted_squares += Vec2(predicted.rms_mm, predicted_by_camera).cwiseAbs2();
    actual_squares += Vec2(actual.rms_mm, by_camera).cwiseAbs2();
    Coverage one;
    one.add(result.rig, session.rig());
    all.add(result.rig, session.rig());
    std::printf(
        "%s seed %llu: rms camera %.3f projector %.3f px; light at 2 m off by %.3f mm rms (located by the camera %.3f); "
        "predicted %.3f rms (%.3f); inside 2 sigma %d, 3 sigma %d of %d;%s\n",
        simulate::to_string(level), static_cast<unsigned long long>(seed), result.rms_px[0], result.rms_px[1],
        actual.rms_mm, by_camera, predicted.rms_mm, predicted_by_camera, one.in_two, one.in_three, one.total,
        one.outside.c_str());
    std::fflush(stdout);
    EXPECT_LT(actual.rms_mm, 4 * predicted.rms_mm)
        << "seed " << seed;  // four times the rms of 2-D Gaussians: never
    if (GetParam().with_peers) compare(seen, result.rig, {}, sums);
  }
  // Parameters of one rig are correlated: of one session 80 %.
  EXPECT_GE(all.in_two, (GetParam().seeds > 1 ? 0.9 : 0.8) * all.total) << all.in_two << " of " << all.total;
  EXPECT_GE(all.in_three, 0.95 * all.total) << all.in_three << " of " << all.total << all.outside;
  if (GetParam().seeds > 1 && level != simulate::Level::kEasy) {
    EXPECT_GE(all.squares, 0.5 * all.total);
    for (const double ratio : Vec2(predicted_squares.cwiseQuotient(actual_squares).cwiseSqrt())) {
      EXPECT_GT(ratio, 0.5);
      EXPECT_LT(ratio, 2);
    }
  }
  if (GetParam().with_peers) EXPECT_LE(sums.ours, sums.opencv);
}

/// The other ways to pair projector and board, a session each.
struct PatternCase {
  simulate::Level level;
  const char* pattern;
  std::optional<Board> board = std::nullopt;  ///< instead of the level's
  bool plain = false;                         ///< not under the level's own conditions
};

class PatternSessions : public ::testing::TestWithParam<PatternCase> {};

/// Some 24 parameters a session: one outside three exact sigmas has a chance of 6 %, two, as parameters of
/// one rig are correlated, well under 3 %; that many are let pass.
TEST_P(PatternSessions, TruthLiesInsideThreeReportedSigmas) {
  const PatternCase& which = GetParam();
  const auto pattern = session::make_pattern(which.pattern, simulate::projector_size(which.level));
  std::optional<simulate::BoardPrint> print;
  if (which.board) print = simulate::BoardPrint{*which.board, detect::board_artwork(*which.board)};
  const simulate::SimulatedSession session = simulate::make_session(
      which.level, 2, pattern->on_blank_paper(), print,
      which.plain ? simulate::plain_conditions() : simulate::level_conditions(which.level));
  const calibrate::CalibrationResult result = calibrate::calibrate_rig(look_at(session, which.pattern).data);
  EXPECT_TRUE(result.rig.quality.passed());
  const analyze::LightError predicted = analyze::predicted_light_error(result.rig, 2.0);
  const analyze::LightError actual = analyze::true_light_error(result.rig, session.rig(), 2.0);
  int total = 0, outside = 0;
  std::string names;
  for (const auto& [name, score] : scores(result.rig, session.rig())) {
    ++total;
    if (std::abs(score) <= 3) continue;
    ++outside;
    names += " " + name + " " + std::to_string(score);
  }
  std::printf(
      "%s %s: %d views; rms camera %.3f projector %.3f px; light at 2 m off by %.3f mm rms, predicted %.3f; "
      "outside 3 sigma:%s\n",
      simulate::to_string(which.level), which.pattern, result.rig.quality.views_used, result.rms_px[0],
      result.rms_px[1], actual.rms_mm, predicted.rms_mm, names.empty() ? " none" : names.c_str());
  EXPECT_LE(outside, 2) << names;
  EXPECT_GE(total, 20);
  EXPECT_LT(result.rms_px[0], 0.3);
  EXPECT_LT(result.rms_px[1], 0.3);
  EXPECT_LT(actual.rms_mm, 4 * predicted.rms_mm);
}

/// A printed and a projected board in 18 views, the light of a projector whose axis lies far from its
/// picture's middle. `seed` moves everything else.
simulate::SimulatedSession paper_like_set(std::uint64_t seed) {
  const auto pattern = session::make_pattern("chessboard", simulate::projector_size(simulate::Level::kPaper));
  simulate::SimulatedSession session = simulate::make_session(
      simulate::Level::kPaper, seed, pattern->on_blank_paper(), {}, simulate::plain_conditions());
  for (simulate::World& view : session.views) {
    Intrinsics& k = view.rig.projectors.front().projector.inverse_camera.intrinsics;
    k.cx = 671;
    k.cy = 696;
  }
  return session;
}

class PaperLikeSet : public ::testing::TestWithParam<std::uint64_t> {};

/// 26 parameters a seed inside three sigmas: exact sigmas leave one outside in fewer than 6 % of seeds (the
/// parameters are correlated). OpenCV's light is at least twice as far off, over all seeds.
TEST_P(PaperLikeSet, IsSolvedWithEveryParameterInsideItsSigmas) {
  Compared sums;
  for (std::uint64_t seed = 1; seed <= GetParam(); ++seed) {
    const Seen seen = look_at(paper_like_set(seed), "chessboard", true);
    ASSERT_EQ(seen.session.views.size(), 18u);
    const calibrate::Options options;
    const calibrate::CalibrationResult result = calibrate::calibrate_rig(seen.data, options);
    std::printf("paper-like seed %llu: rms camera %.3f projector %.3f px\n",
                static_cast<unsigned long long>(seed), result.rms_px[0], result.rms_px[1]);
    EXPECT_TRUE(result.rig.quality.passed());
    EXPECT_LE(result.rms_all_px[0], 0.3);
    EXPECT_LE(result.rms_all_px[1], 0.3);
    const auto all = scores(result.rig, seen.session.rig());
    EXPECT_EQ(all.size(), 26u);
    for (const auto& [name, score] : all) EXPECT_LE(std::abs(score), 3) << "seed " << seed << " " << name;
    compare(seen, result.rig, options, sums);
  }
  EXPECT_LE(std::sqrt(sums.ours), 0.5 * std::sqrt(sums.opencv));
}

INSTANTIATE_TEST_SUITE_P(OneSeed, PaperLikeSet, ::testing::Values(1));
INSTANTIATE_TEST_SUITE_P(FiveSeeds, PaperLikeSet, ::testing::Values(5));

INSTANTIATE_TEST_SUITE_P(Patterns, PatternSessions,
                         ::testing::Values(PatternCase{simulate::Level::kEasy, "phase"}),
                         [](const auto& which) {
                           std::string name = simulate::to_string(which.param.level) + std::string("_");
                           for (const char* c = which.param.pattern; *c != 0; ++c)
                             name += *c == '+' ? '_' : *c;
                           return name;
                         });

const Board kCharucoSheet = CharucoBoard{6, 5, 0.06, 0.045, MarkerDictionary::k4x4_50};
INSTANTIATE_TEST_SUITE_P(
    ManyBoards, PatternSessions,
    ::testing::Values(PatternCase{simulate::Level::kEasy, "gray+phase"},
                      PatternCase{simulate::Level::kHard, "chessboard"},
                      PatternCase{simulate::Level::kEasy, "gray", kCharucoSheet},
                      PatternCase{simulate::Level::kPaper, "phase", kCharucoSheet},
                      PatternCase{simulate::Level::kEasy, "gray",
                                  MarkerGrid{5, 4, 0.045, 0.018, MarkerDictionary::k4x4_50}},
                      PatternCase{simulate::Level::kEasy, "gray", CircleGrid{5, 9, 0.026, 0.022, true}},
                      PatternCase{simulate::Level::kPaper, "charuco", kCharucoSheet},
                      PatternCase{simulate::Level::kHard, "markers", kCharucoSheet},
                      PatternCase{simulate::Level::kHard, "circles", kCharucoSheet, true},
                      PatternCase{simulate::Level::kPaper, "chessboard:colour", std::nullopt, true}));

/// Four of 18 captures are saved upside down. A pose of the board explains the camera's corners nearly as well there, and the
/// light of the projector does not fit. Two of these views agree with the camera to twice the others' RMS, and their camera
/// corners stay: 7.7 mm are predicted. Before any lost them, the light was 19.7 mm off, and 5.2 mm were predicted.
TEST(RotatedCaptures, AreNamedAndTheErrorIsNotHidden) {
  const auto pattern = session::make_pattern("chessboard", simulate::projector_size(simulate::Level::kPaper));
  simulate::SimulatedSession session =
      simulate::make_session(simulate::Level::kPaper, 302, pattern->on_blank_paper());
  session.capture.samples_per_axis = 1;  // for speed
  const auto is_rotated = [](std::size_t view) { return view % 4 == 2; };
  const Seen seen = look_at(session, "chessboard", false, [&](std::size_t view, ImageU8& capture) {
    if (is_rotated(view)) std::reverse(capture.data(), capture.data() + capture.width() * capture.height());
  });
  calibrate::Options options;
  options.camera.choose = options.projector.choose = true;
  const calibrate::CalibrationResult result = calibrate::calibrate_rig(seen.data, options);
  int rejected = 0;
  for (const calibrate::ViewResult& view : result.views) {
    const bool is_named = view.note.find("rotated") != std::string::npos;
    EXPECT_EQ(is_named, is_rotated(std::stoul(view.name))) << view.name << " " << view.note;
    if (is_rotated(std::stoul(view.name)))
      rejected += !view.used;
    else
      EXPECT_TRUE(view.used) << view.name;
  }
  EXPECT_GE(rejected, 2);
  const analyze::LightError predicted = analyze::predicted_light_error(result.rig, 2.0);
  const analyze::LightError actual = analyze::true_light_error(result.rig, session.rig(), 2.0);
  EXPECT_LT(actual.rms_mm, 2 * predicted.rms_mm);
}

/// Someone puts the sheet back upside down: the same board, its first corner at the other end.
TEST(BoardTurnedByHalf, InOneViewChangesNothing) {
  simulate::SimulatedSession session = simulate::make_session(simulate::Level::kEasy, 9);
  session.views.resize(4);
  const Points3 corners = points_in_board(session.board().layout);
  const Vec3 middle = 0.5 * (corners.front() + corners.back());
  const Pose half_turn(so3_exp<double>(Vec3(0, 0, 3.14159265358979)), Vec3::Zero());
  session.views[1].rig_from_board = session.views[1].rig_from_board * Pose(Mat3::Identity(), middle) *
                                    half_turn * Pose(Mat3::Identity(), -middle);
  const calibrate::CalibrationResult result = calibrate::calibrate_rig(look_at(session).data);
  EXPECT_EQ(result.rig.quality.views_used, 4);
  EXPECT_TRUE(result.rig.quality.passed());
  for (const auto& [name, score] : scores(result.rig, session.rig())) EXPECT_LE(std::abs(score), 4) << name;
}

const auto kLevelName = [](const auto& which) { return std::string(simulate::to_string(which.param.level)); };
INSTANTIATE_TEST_SUITE_P(OneSeed, SimulatedSessions,
                         ::testing::Values(LevelCase{simulate::Level::kEasy, 1},
                                           LevelCase{simulate::Level::kPaper, 1},
                                           LevelCase{simulate::Level::kHard, 1}),
                         kLevelName);
INSTANTIATE_TEST_SUITE_P(FiveSeeds, SimulatedSessions,
                         ::testing::Values(LevelCase{simulate::Level::kEasy, 5, true},
                                           LevelCase{simulate::Level::kPaper, 5},
                                           LevelCase{simulate::Level::kHard, 5}),
                         kLevelName);

}  // namespace
}  // namespace procam::test
