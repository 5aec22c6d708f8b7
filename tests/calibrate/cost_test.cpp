/// The cost function's derivatives, against finite differences on the manifold and against Ceres' Jets.
#include <ceres/jet.h>
#include <gtest/gtest.h>

#include "procam/calibrate/costs/flexed.hpp"
#include "procam/calibrate/costs/image_change.hpp"
#include "procam/calibrate/costs/light_point.hpp"
#include "procam/calibrate/costs/point_prior.hpp"
#include "procam/calibrate/costs/reprojection.hpp"
#include "procam/calibrate/costs/shared_corner.hpp"

namespace procam::calibrate {
namespace {

/// Lopsided everywhere: fx != fy, skew, off-centre, rotations about no axis.
template <typename Model>
struct Fixture {
  static constexpr int kLens = ReprojectionCost<Model>::kLensSize;
  std::array<double, kLens> lens{};
  std::array<double, 7> device{}, board{};
  Vec3 point{0.13, -0.07, 0};
  Vec2 pixel{611.5, 402.25};
  Mat2 sqrt_information;

  Fixture() {
    const double intrinsics[] = {1210.0, 1187.0, 655.0, 811.0, 2.5};
    const double coefficients[] = {-0.11, 0.05, 0.0013, -0.0021, 0.012, 0.02, -0.01, 0.004};
    std::copy(intrinsics, intrinsics + 5, lens.begin());
    std::copy(coefficients, coefficients + Model::kNumCoefficients, lens.begin() + 5);
    pose_to_block(Pose(so3_exp<double>(Vec3(0.11, -0.23, 0.05)), Vec3(0.2, -0.4, 0.1)), device.data());
    pose_to_block(Pose(so3_exp<double>(Vec3(-0.31, 0.17, 0.42)), Vec3(-0.1, 0.15, 1.3)), board.data());
    sqrt_information << 8.0, 0.0, -1.5, 11.0;
  }
};

template <typename Model>
class Cost : public ::testing::Test {};
using Models = ::testing::Types<NoDistortion, BrownConrady, RationalDistortion, FisheyeDistortion>;
TYPED_TEST_SUITE(Cost, Models);

TYPED_TEST(Cost, DerivativesAreThoseOfFiniteDifferences) {
  Fixture<TypeParam> f;
  const ReprojectionCost<TypeParam> cost(f.pixel, f.sqrt_information);
  Vec2 residual;
  Eigen::Matrix<double, 2, Fixture<TypeParam>::kLens, Eigen::RowMajor> by_lens;
  Eigen::Matrix<double, 2, 7, Eigen::RowMajor> by_device, by_board;
  Eigen::Matrix<double, 2, 3, Eigen::RowMajor> by_point;
  double* jacobians[] = {by_lens.data(), by_device.data(), by_board.data(), by_point.data()};
  const double* blocks[] = {f.lens.data(), f.device.data(), f.board.data(), f.point.data()};
  ASSERT_TRUE(cost.Evaluate(blocks, residual.data(), jacobians));

  const auto value_at = [&](const double* lens, const double* device, const double* board,
                            const Vec3& point) {
    const double* moved[] = {lens, device, board, point.data()};
    Vec2 r;
    EXPECT_TRUE(cost.Evaluate(moved, r.data(), nullptr));
    return r;
  };
  const auto value = [&](const double* lens, const double* device, const double* board) {
    return value_at(lens, device, board, f.point);
  };
  for (int i = 0; i < 3; ++i) {
    const Vec3 h = 1e-6 * Vec3::Unit(i);
    const Vec2 expected = (value_at(f.lens.data(), f.device.data(), f.board.data(), f.point + h) -
                           value_at(f.lens.data(), f.device.data(), f.board.data(), f.point - h)) /
                          2e-6;
    EXPECT_LT((by_point.col(i) - expected).norm(), 1e-6 * (1 + expected.norm())) << "point " << i;
  }
  for (int i = 0; i < Fixture<TypeParam>::kLens; ++i) {
    const double h = 1e-6 * std::max(1.0, std::abs(f.lens[std::size_t(i)]));
    auto plus = f.lens, minus = f.lens;
    plus[std::size_t(i)] += h, minus[std::size_t(i)] -= h;
    const Vec2 expected = (value(plus.data(), f.device.data(), f.board.data()) -
                           value(minus.data(), f.device.data(), f.board.data())) /
                          (2 * h);
    EXPECT_LT((by_lens.col(i) - expected).norm(), 1e-6 * (1 + expected.norm())) << "lens parameter " << i;
  }
  const Se3Manifold manifold;
  for (int i = 0; i < 6; ++i) {
    const double h = 1e-6;
    Vec6 step = Vec6::Zero();
    std::array<double, 7> plus, minus;
    for (const bool of_device : {true, false}) {
      const auto& block = of_device ? f.device : f.board;
      step[i] = h;
      manifold.Plus(block.data(), step.data(), plus.data());
      step[i] = -h;
      manifold.Plus(block.data(), step.data(), minus.data());
      const Vec2 expected = of_device ? Vec2((value(f.lens.data(), plus.data(), f.board.data()) -
                                              value(f.lens.data(), minus.data(), f.board.data())) /
                                             (2 * h))
                                      : Vec2((value(f.lens.data(), f.device.data(), plus.data()) -
                                              value(f.lens.data(), f.device.data(), minus.data())) /
                                             (2 * h));
      const Vec2 actual = of_device ? by_device.col(i) : by_board.col(i);
      EXPECT_LT((actual - expected).norm(), 1e-6 * (1 + expected.norm()))
          << (of_device ? "device" : "board") << " increment " << i;
    }
  }
  EXPECT_EQ(by_device.col(6).norm() + by_board.col(6).norm(), 0);
}

/// project<T> serves Ceres' Jets as it serves procam's own dual numbers.
TYPED_TEST(Cost, ProjectGivesJetsTheSameDerivatives) {
  constexpr int kLens = Fixture<TypeParam>::kLens;
  using Jet = ceres::Jet<double, 3 + kLens>;
  using D = Dual<3 + kLens>;
  const Fixture<TypeParam> f;
  const Vec3 point(0.21, -0.34, 1.1);
  Jet jet_lens[kLens];
  D dual_lens[kLens];
  for (int i = 0; i < kLens; ++i)
    jet_lens[i] = Jet(f.lens[std::size_t(i)], 3 + i), dual_lens[i] = D(f.lens[std::size_t(i)], 3 + i);
  const Vec3T<Jet> jet_point(Jet(point.x(), 0), Jet(point.y(), 1), Jet(point.z(), 2));
  const Vec3T<D> dual_point(D(point.x(), 0), D(point.y(), 1), D(point.z(), 2));
  const auto jet = project<TypeParam>(IntrinsicsT<Jet>::from_array(jet_lens),
                                      static_cast<const Jet*>(jet_lens + 5), jet_point);
  const auto dual = project<TypeParam>(IntrinsicsT<D>::from_array(dual_lens),
                                       static_cast<const D*>(dual_lens + 5), dual_point);
  ASSERT_TRUE(jet && dual);
  for (int axis = 0; axis < 2; ++axis) {
    EXPECT_NEAR((*jet)[axis].a, (*dual)[axis].a, 1e-9);
    EXPECT_LT(((*jet)[axis].v - (*dual)[axis].v).norm(), 1e-9 * (1 + (*dual)[axis].v.norm()));
  }
}

TEST(ReprojectionCost, FailsForAPointBehindTheLensInsteadOfScoringZero) {
  Fixture<BrownConrady> f;
  pose_to_block(Pose(Mat3::Identity(), Vec3(0, 0, -3)), f.board.data());
  const ReprojectionCost<BrownConrady> cost(f.pixel, f.sqrt_information);
  const double* blocks[] = {f.lens.data(), f.device.data(), f.board.data(), f.point.data()};
  Vec2 residual;
  EXPECT_FALSE(cost.Evaluate(blocks, residual.data(), nullptr));
}

/// A camera with a wide lens looks at the sheet and a long one lights it, from another place.
struct LitSheet {
  Fixture<FisheyeDistortion> seen;
  Fixture<BrownConrady> lit;
  LightPointCost cost{FisheyeDistortion{}, BrownConrady{},        Vec2(655.0 + 80, 811.0 - 120),
                      Vec2(711.5, 702.25), seen.sqrt_information, Vec2(0.14, 0.09)};
  std::array<std::vector<double>, 6> blocks;  ///< the sheet's curvature last: it is bent

  LitSheet() {
    std::array<double, 7> camera;
    pose_to_block(Pose(so3_exp<double>(Vec3(-0.05, 0.09, 0.02)), Vec3(0.03, -0.02, 0.05)), camera.data());
    blocks = {std::vector<double>(seen.lens.begin(), seen.lens.end()),
              std::vector<double>(camera.begin(), camera.end()),
              std::vector<double>(lit.lens.begin(), lit.lens.end()),
              std::vector<double>(lit.device.begin(), lit.device.end()),
              std::vector<double>(lit.board.begin(), lit.board.end()),
              {0.21, -0.13, 0.08}};
  }
  bool evaluate(Vec2& residual, double** jacobians = nullptr) const {
    const double* pointers[] = {blocks[0].data(), blocks[1].data(), blocks[2].data(),
                                blocks[3].data(), blocks[4].data(), blocks[5].data()};
    return cost.Evaluate(pointers, residual.data(), jacobians);
  }
};

TEST(LightPointCost, DerivativesAreThoseOfFiniteDifferences) {
  LitSheet sheet;
  using Block = Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor>;
  std::array<Block, 6> derivative;
  double* jacobians[6];
  for (std::size_t b = 0; b < 6; ++b) {
    derivative[b].resize(2, Eigen::Index(sheet.blocks[b].size()));
    jacobians[b] = derivative[b].data();
  }
  Vec2 residual;
  ASSERT_TRUE(sheet.evaluate(residual, jacobians));
  const Se3Manifold manifold;
  for (std::size_t b = 0; b < 6; ++b) {
    const bool is_pose = b == 1 || b == 3 || b == 4;
    for (int i = 0; i < (is_pose ? 6 : int(sheet.blocks[b].size())); ++i) {
      const std::vector<double> here = sheet.blocks[b];
      const double h = 1e-6 * (is_pose ? 1 : std::max(1.0, std::abs(here[std::size_t(i)])));
      const auto value = [&](double step) {
        if (is_pose) {
          const Vec6 delta = step * Vec6::Unit(i);
          manifold.Plus(here.data(), delta.data(), sheet.blocks[b].data());
        } else {
          sheet.blocks[b] = here;
          sheet.blocks[b][std::size_t(i)] += step;
        }
        Vec2 r;
        EXPECT_TRUE(sheet.evaluate(r));
        sheet.blocks[b] = here;
        return r;
      };
      const Vec2 expected = (value(h) - value(-h)) / (2 * h);
      EXPECT_LT((derivative[b].col(i) - expected).norm(), 1e-5 * (1 + expected.norm()))
          << "block " << b << " parameter " << i;
    }
  }
}

TEST(SharedCornerCost, DerivativesAreThoseOfFiniteDifferences) {
  LitSheet sheet;
  Mat2 carry;
  carry << 3.0, -0.4, 0.7, 5.0;
  const SharedCornerCost cost(
      std::make_unique<ReprojectionCost<FisheyeDistortion>>(Vec2(640, 700), carry),
      std::make_unique<ReprojectionCost<BrownConrady>>(Vec2(711.5, 702.25), sheet.lit.sqrt_information));
  std::vector<std::vector<double>> blocks(sheet.blocks.begin(), sheet.blocks.end());
  blocks.back() = {0.13, -0.07, 0.004};
  using Block = Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor>;
  std::vector<Block> derivative(6);
  double* jacobians[6];
  for (std::size_t b = 0; b < 6; ++b) {
    derivative[b].resize(2, Eigen::Index(blocks[b].size()));
    jacobians[b] = derivative[b].data();
  }
  const auto evaluate = [&](double** out) {
    const double* pointers[] = {blocks[0].data(), blocks[1].data(), blocks[2].data(),
                                blocks[3].data(), blocks[4].data(), blocks[5].data()};
    Vec2 residual;
    EXPECT_TRUE(cost.Evaluate(pointers, residual.data(), out));
    return residual;
  };
  EXPECT_EQ(evaluate(jacobians), evaluate(nullptr));
  const Se3Manifold manifold;
  for (std::size_t b = 0; b < 6; ++b) {
    const bool is_pose = b == 1 || b == 3 || b == 4;
    for (int i = 0; i < (is_pose ? 6 : int(blocks[b].size())); ++i) {
      const std::vector<double> here = blocks[b];
      const double h = 1e-6 * (is_pose ? 1 : std::max(1.0, std::abs(here[std::size_t(i)])));
      const auto value = [&](double step) {
        if (is_pose) {
          const Vec6 delta = step * Vec6::Unit(i);
          manifold.Plus(here.data(), delta.data(), blocks[b].data());
        } else {
          blocks[b] = here;
          blocks[b][std::size_t(i)] += step;
        }
        const Vec2 r = evaluate(nullptr);
        blocks[b] = here;
        return r;
      };
      const Vec2 expected = (value(h) - value(-h)) / (2 * h);
      EXPECT_LT((derivative[b].col(i) - expected).norm(), 1e-5 * (1 + expected.norm()))
          << "block " << b << " parameter " << i;
    }
  }
}

/// The derivatives of a cost by some of its blocks, against differences. Returns the residual.
Vec2 compare_with_differences(const ceres::CostFunction& cost, std::vector<std::vector<double>> blocks,
                              const std::vector<std::size_t>& of) {
  using Block = Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor>;
  std::vector<Block> derivative;
  std::vector<double*> jacobians;
  for (const auto& block : blocks) derivative.emplace_back(2, Eigen::Index(block.size()));
  for (Block& block : derivative) jacobians.push_back(block.data());
  const auto evaluate = [&](double** out) {
    std::vector<const double*> pointers;
    for (const auto& block : blocks) pointers.push_back(block.data());
    Vec2 residual;
    EXPECT_TRUE(cost.Evaluate(pointers.data(), residual.data(), out));
    return residual;
  };
  EXPECT_LT((evaluate(jacobians.data()) - evaluate(nullptr)).norm(), 1e-9);
  for (const std::size_t b : of)
    for (std::size_t i = 0; i < blocks[b].size(); ++i) {
      const double here = blocks[b][i], h = 1e-6 * std::max(1.0, std::abs(here));
      blocks[b][i] = here + h;
      const Vec2 above = evaluate(nullptr);
      blocks[b][i] = here - h;
      const Vec2 expected = (above - evaluate(nullptr)) / (2 * h);
      blocks[b][i] = here;
      EXPECT_LT((derivative[b].col(Eigen::Index(i)) - expected).norm(), 1e-5 * (1 + expected.norm()))
          << "block " << b << " parameter " << i;
    }
  return evaluate(nullptr);
}

/// A cost of a point on a flat sheet, and one of the sheet's curvature: each with the flex as a block more.
TEST(FlexedCost, DerivativesAreThoseOfFiniteDifferences) {
  const LitSheet sheet;
  const Vec2 centre(0.14, 0.09);
  const Vec3 flex(-0.31, 0.22, 0.17), point(0.33, -0.17, 0.004);
  const std::vector<double> as_block(flex.data(), flex.data() + 3);

  const auto of_point = [&] {
    return std::make_unique<ReprojectionCost<BrownConrady>>(Vec2(711.5, 702.25), sheet.lit.sqrt_information);
  };
  const Vec2 flexed = compare_with_differences(
      FlexedCost(of_point(), FlexedCost::Last::kPoint, centre),
      {sheet.blocks[2], sheet.blocks[3], sheet.blocks[4], {point.x(), point.y(), point.z()}, as_block},
      {3, 4});
  const double dx = 0.33 - 0.14, dy = -0.17 - 0.09;
  const Vec3 lifted(0.33, -0.17, 0.004 + 0.5 * (-0.31 * dx * dx + 2 * 0.22 * dx * dy + 0.17 * dy * dy));
  const double* flat[] = {sheet.blocks[2].data(), sheet.blocks[3].data(), sheet.blocks[4].data(),
                          lifted.data()};
  Vec2 expected;
  ASSERT_TRUE(of_point()->Evaluate(flat, expected.data(), nullptr));
  EXPECT_LT((flexed - expected).norm(), 1e-9);

  auto light = std::make_unique<LightPointCost>(FisheyeDistortion{}, BrownConrady{}, Vec2(735, 691),
                                                Vec2(711.5, 702.25), sheet.seen.sqrt_information, centre);
  std::vector<std::vector<double>> blocks(sheet.blocks.begin(), sheet.blocks.end());
  blocks.push_back(as_block);
  compare_with_differences(FlexedCost(std::move(light), FlexedCost::Last::kCurvature, centre), blocks,
                           {5, 6});
}

/// And that of a camera whose focus and image have changed: as another cost with that lens, and by finite differences.
TEST(ImageChangeCost, HasTheLensOfTheView) {
  const LitSheet sheet;
  const std::vector<double> change{0.013, -2.25, 1.5};
  const auto of_point = [&] {
    return std::make_unique<ReprojectionCost<BrownConrady>>(Vec2(711.5, 702.25), sheet.lit.sqrt_information);
  };
  const std::vector<std::vector<double>> of_print{
      sheet.blocks[2], sheet.blocks[3], sheet.blocks[4], {0.33, -0.17, 0.004}, change};
  const Vec2 residual = compare_with_differences(ImageChangeCost(of_point()), of_print, {0, 4});
  Camera lens{{1920, 1080}, {}, BrownConrady{}};
  lens = changed(with_parameters(lens, Eigen::Map<const VecX>(sheet.blocks[2].data(), 10)),
                 Vec3(0.013, -2.25, 1.5));
  EXPECT_NEAR(lens.intrinsics.skew, 1.013 * sheet.blocks[2][4], 1e-12);
  const VecX of_view = parameters_of(lens);
  const double* blocks[] = {of_view.data(), of_print[1].data(), of_print[2].data(), of_print[3].data()};
  Vec2 expected;
  ASSERT_TRUE(of_point()->Evaluate(blocks, expected.data(), nullptr));
  EXPECT_LT((residual - expected).norm(), 1e-9);

  auto light =
      std::make_unique<LightPointCost>(FisheyeDistortion{}, BrownConrady{}, Vec2(735, 691),
                                       Vec2(711.5, 702.25), sheet.seen.sqrt_information, Vec2(0.14, 0.09));
  std::vector<std::vector<double>> of_light(sheet.blocks.begin(), sheet.blocks.end());
  of_light.push_back(change);
  compare_with_differences(ImageChangeCost(std::move(light)), of_light, {0, 6});
}

/// Cylinders about axes of any direction whose curvature has RMS s have whitened squares of mean 3.
TEST(FlexPrior, IsThatOfCylindersOfAnyDirection) {
  const double s = 0.013;
  const FlexPrior prior(s);
  Mat3 second = Mat3::Zero();
  constexpr int kAxes = 360;
  for (int i = 0; i < kAxes; ++i) {
    const double c = std::cos(kPi * i / kAxes), d = std::sin(kPi * i / kAxes);
    const Vec3 flex = s * Vec3(c * c, c * d, d * d);
    const double* blocks[] = {flex.data()};
    Vec3 residual;
    ASSERT_TRUE(prior.Evaluate(blocks, residual.data(), nullptr));
    second += residual * residual.transpose() / kAxes;
  }
  EXPECT_LT((second - Mat3::Identity()).norm(), 1e-9);
}

TEST(PointPrior, DerivativesAreThoseOfFiniteDifferences) {
  const PointPrior cost(Vec3(0.31, -0.12, 0), 0.0004, BentSheet{Vec3::Zero(), Vec2(0.14, 0.09)});
  Vec3 point(0.3102, -0.1199, 0.003), curvature(0.21, -0.13, 0.08);
  const auto evaluate = [&](double** jacobians) {
    const double* blocks[] = {point.data(), curvature.data()};
    Vec3 residual;
    EXPECT_TRUE(cost.Evaluate(blocks, residual.data(), jacobians));
    return residual;
  };
  Eigen::Matrix<double, 3, 3, Eigen::RowMajor> derivative[2];
  double* jacobians[] = {derivative[0].data(), derivative[1].data()};
  evaluate(jacobians);
  for (Vec3* block : {&point, &curvature})
    for (int i = 0; i < 3; ++i) {
      const double here = (*block)[i];
      (*block)[i] = here + 1e-4;
      const Vec3 above = evaluate(nullptr);
      (*block)[i] = here - 1e-4;
      const Vec3 expected = (above - evaluate(nullptr)) / 2e-4;
      (*block)[i] = here;
      EXPECT_LT((derivative[block == &curvature].col(i) - expected).norm(), 1e-7 * (1 + expected.norm()));
    }
  // A point on the bent sheet is where it was printed.
  point = Vec3(0.31, -0.12, 0.5 * (0.21 * 0.17 * 0.17 + 2 * 0.13 * 0.17 * 0.21 + 0.08 * 0.21 * 0.21));
  EXPECT_LT(evaluate(nullptr).norm(), 1e-9);
}

TEST(LightPointCost, FailsWhereTheCameraSeesNoSheet) {
  LitSheet sheet;
  pose_to_block(Pose(Mat3::Identity(), Vec3(0, 0, -3)), sheet.blocks[4].data());
  Vec2 residual;
  EXPECT_FALSE(sheet.evaluate(residual));
}

TEST(Se3Manifold, MinusUndoesPlus) {
  const Fixture<NoDistortion> f;
  const Se3Manifold manifold;
  Vec6 delta;
  delta << 0.1, -0.2, 0.05, 0.3, -0.1, 0.2;
  std::array<double, 7> moved;
  Vec6 back;
  manifold.Plus(f.device.data(), delta.data(), moved.data());
  manifold.Minus(moved.data(), f.device.data(), back.data());
  EXPECT_LT((back - delta).norm(), 1e-12);
}

}  // namespace
}  // namespace procam::calibrate
