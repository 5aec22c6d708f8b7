/// One more view, before it is captured: against the normal equations of a session that has it.
#include "procam/calibrate/next_view.hpp"

#include <gtest/gtest.h>

#include "procam/calibrate/calibrate.hpp"
#include "support/numeric_world.hpp"
#include "uncertainty.hpp"

namespace procam::calibrate {
namespace {

using test::NumericWorld;

/// The session with a view at that pose as its lenses would see it, without noise: bundle_covariance then
/// gives what is known with it in one step, whatever the views share.
NamedCovariance captured(const SolvedBundle& solved, const Pose& rig_from_board, double camera_sigma,
                         double projector_sigma) {
  SolvedBundle more = solved;
  View view{"next", {{}, {}}};
  for (std::size_t d = 0; d < 2; ++d)
    for (std::size_t i = 0; i < solved.state.points_in_board.size(); ++i) {
      const double sigma = d == 0 ? camera_sigma : projector_sigma;
      const auto pixel = solved.state.lenses[d].project(solved.state.device_from_rig[d] *
                                                        (rig_from_board * solved.state.points_in_board[i]));
      if (pixel && solved.state.lenses[d].size.contains(*pixel))
        view.observations[d].push_back({int(i), *pixel, sigma * sigma * Mat2::Identity()});
    }
  more.data.views.push_back(view);
  more.state.rig_from_board.push_back(rig_from_board);
  more.used.push_back(use_all(more.data).back());
  return bundle_covariance(more.data, more.used, more.state, more.options).devices;
}

class NextView : public ::testing::TestWithParam<BoardShape> {};

/// A free board is shared by all views: what is learnt of it must not count as learnt of the lenses, and the
/// lenses gain by what the new view tells of the board.
TEST_P(NextView, TellsWhatTheSessionKnowsOnceItIsCaptured) {
  NumericWorld world = NumericWorld::make(7, 4, 0.08, 0.05);
  if (GetParam() == BoardShape::kFree) world.bend_board();
  Options options;
  options.board_shape = GetParam();
  // Averaging over these terms is in what is known of the rig, not in the session's normal equations.
  options.camera.held = options.projector.held = {"skew", "k3"};
  const CalibrationResult result = calibrate_rig(world.correspondences(3), options);
  ASSERT_EQ(result.shape.free, GetParam() == BoardShape::kFree);
  ASSERT_FALSE(result.sigmas_from_views);
  const Pose there = NumericWorld::make(1, 77).camera_from_board.front();
  const auto told = covariance_with_view(result, {there}).front();
  ASSERT_TRUE(told.has_value());
  const NamedCovariance with = captured(result.solved, there, 0.08, 0.05);
  int compared = 0;
  for (const std::string& name : with.names) {
    if (!told->index_of(name)) continue;  // the place is the rig's in the one, the device's in the other
    ++compared;
    EXPECT_NEAR(told->sigma(name) / with.sigma(name), 1, 1e-5) << name;
    EXPECT_LT(told->sigma(name), 0.99999 * result.rig.covariance.sigma(name)) << name;
  }
  EXPECT_EQ(compared, 16);
}
INSTANTIATE_TEST_SUITE_P(Boards, NextView, ::testing::Values(BoardShape::kFlat, BoardShape::kFree),
                         [](const auto& board) {
                           return board.param == BoardShape::kFree ? "bent" : "flat";
                         });

}  // namespace
}  // namespace procam::calibrate
