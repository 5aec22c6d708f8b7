#include "procam/core/lens/distortion.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "procam/core/lens/camera.hpp"
#include "support/lopsided.hpp"

namespace procam {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

/// A strong but valid lens: its inverse must exist over the whole of this image.
template <typename Model>
struct Lens {
  const char* name;
  Model model;
  Intrinsics intrinsics;
  ImageSize size;
};

/// What each model supplies; a new alternative in the variant does not compile here without its own.
template <typename Model>
std::vector<Lens<Model>> lenses();

template <>
std::vector<Lens<NoDistortion>> lenses() {
  return {{"pinhole", {}, {812, 790, 530.2, 409.7, 1.9}, {1024, 768}}};
}

template <>
std::vector<Lens<BrownConrady>> lenses() {
  return {{"barrel", {{-0.3, 0, 0, 0, 0}}, {1110, 1075, 530.2, 409.7, 1.9}, {1024, 768}},
          {"pincushion", {{0.4, 0, 0, 0, 0}}, {812, 790, 480.2, 409.7, -1.9}, {1024, 768}},
          {"lens shift below the picture",
           {{-0.11, 0.02, 1e-3, -2e-3, 0}},
           {1880, 1871, 540, 860, 0.6},
           {1024, 768}},
          {"tangential", {{0, 0, 0.03, -0.02, 0}}, {812, 790, 530.2, 409.7, 1.9}, {1024, 768}},
          {"tangential barrel",
           {{-0.25, 0.06, -0.01, 0.012, -0.003}},
           {1050, 990, 370.2, 549.7, 1.9},
           {768, 1024}},
          {"moustache", {{-0.4, 0.5, 2e-3, -3e-3, -0.1}}, {1000, 980, 530.2, 409.7, 1.9}, {1024, 768}}};
}

template <>
std::vector<Lens<RationalDistortion>> lenses() {
  return {{"wide angle",
           {{5.2, 2.1, 4e-4, -3e-4, 0.06, 5.6, 3.9, 0.55}},
           {612, 603, 650.2, 349.7, 1.9},
           {1280, 720}},
          {"barrel", {{-0.3, 0, 4e-3, -3e-3, 0, 0, 0, 0}}, {1110, 1075, 530.2, 409.7, 1.9}, {1024, 768}},
          {"denominator alone",
           {{0, 0, 1e-3, 2e-3, 0, 0.4, 0.05, 0}},
           {1112, 1090, 530.2, 409.7, 1.9},
           {1024, 768}}};
}

template <>
std::vector<Lens<FisheyeDistortion>> lenses() {
  return {
      {"equidistant, 250 degrees across", {{0, 0, 0, 0}}, {298, 291, 530.2, 375.7, 1.9}, {1024, 768}},
      {"200 degrees across", {{-0.03, 0.004, -0.0012, 0.0001}}, {330, 321, 530.2, 375.7, 0.9}, {1024, 768}},
      {"stretched", {{0.11, 0.01, 0.003, 0.0002}}, {512, 503, 590.2, 409.7, -1.9}, {1024, 768}}};
}

template <typename Variant>
struct TypesOf;
template <typename... Models>
struct TypesOf<std::variant<Models...>> {
  using type = ::testing::Types<Models...>;
};

template <typename Model>
class DistortionLaws : public ::testing::Test {
 protected:
  static std::optional<Vec2> distort(const Model& model, const Vec3& point) {
    return Model::distort(model.coefficients.data(), point);
  }
  static std::optional<Vec3> undistort(const Model& model, const Vec2& distorted) {
    return Model::undistort(model.coefficients.data(), distorted);
  }
  /// Coefficients of a size that real lenses have, some with folds.
  static Model random_model(std::mt19937_64& random, double size) {
    Model model;
    for (double& c : model.coefficients) c = test::uniform(random, -size, size);
    return model;
  }
  static Vec3 direction(double off_axis, double around) {
    return Vec3(std::sin(off_axis) * std::cos(around), std::sin(off_axis) * std::sin(around),
                std::cos(off_axis));
  }
};
TYPED_TEST_SUITE(DistortionLaws, TypesOf<Distortion>::type);

TYPED_TEST(DistortionLaws, HasANameAndNamedCoefficients) {
  const Distortion model = distortion_named(TypeParam::kName);
  EXPECT_TRUE(std::holds_alternative<TypeParam>(model));
  EXPECT_STREQ(name_of(model), TypeParam::kName);
  EXPECT_EQ(coefficient_names(model).size(), std::size_t(TypeParam::kNumCoefficients));
  std::vector<double> values;
  for (int i = 0; i < TypeParam::kNumCoefficients; ++i) values.push_back(0.1 * (i + 1));
  EXPECT_EQ(coefficients_of(model), std::vector<double>(values.size(), 0.0));
  EXPECT_EQ(coefficients_of(with_coefficients(model, values)), values);
  values.push_back(1);
  EXPECT_THROW(with_coefficients(model, values), std::invalid_argument);
}

TYPED_TEST(DistortionLaws, DistortUndoesUndistortOverTheWholeImage) {
  for (const auto& lens : lenses<TypeParam>()) {
    const Camera camera{lens.size, lens.intrinsics, lens.model};
    const int steps = 41;
    for (int i = 0; i <= steps; ++i) {
      for (int j = 0; j <= steps; ++j) {
        const Vec2 pixel(lens.size.width * double(i) / steps - 0.5,
                         lens.size.height * double(j) / steps - 0.5);
        const auto bearing = camera.unproject(pixel);
        ASSERT_TRUE(bearing) << lens.name << " at " << pixel.transpose();
        EXPECT_NEAR(bearing->norm(), 1, 1e-14);
        const auto again = camera.project(*bearing);
        ASSERT_TRUE(again) << lens.name << " at " << pixel.transpose();
        EXPECT_LT((*again - pixel).norm(), 1e-9) << lens.name << " at " << pixel.transpose();
      }
    }
  }
}

TYPED_TEST(DistortionLaws, ThePrincipalPointLooksAlongTheAxis) {
  for (const auto& lens : lenses<TypeParam>()) {
    const auto axis = this->undistort(lens.model, Vec2(0, 0));
    ASSERT_TRUE(axis);
    EXPECT_LT((axis->normalized() - Vec3::UnitZ()).norm(), 1e-15);
    const auto image = this->distort(lens.model, Vec3(0, 0, 3.7));
    ASSERT_TRUE(image);
    EXPECT_EQ(image->norm(), 0);
  }
}

/// Derivatives in intrinsics, coefficients and point, against Richardson's extrapolation of central
/// differences.
TYPED_TEST(DistortionLaws, DualDerivativesMatchFiniteDifferences) {
  constexpr int kC = TypeParam::kNumCoefficients, kN = 5 + kC + 3;
  using D = Dual<kN>;
  std::mt19937_64 random(5);
  for (const auto& lens : lenses<TypeParam>()) {
    for (int trial = 0; trial < 12; ++trial) {
      const Vec2 pixel(test::uniform(random, 0, lens.size.width), test::uniform(random, 0, lens.size.height));
      const auto direction = this->undistort(lens.model, lens.intrinsics.normalized_from_pixel(pixel));
      ASSERT_TRUE(direction);
      Eigen::Matrix<double, kN, 1> parameters;
      const auto k = lens.intrinsics.to_array();
      for (int i = 0; i < 5; ++i) parameters[i] = k[i];
      for (int i = 0; i < kC; ++i) parameters[5 + i] = lens.model.coefficients[i];
      parameters.template tail<3>() = *direction * 1.7;

      const auto project_all = [&](const auto& p) {
        using T = std::decay_t<decltype(p[0])>;
        const T zero[1] = {T(0)};
        return project<TypeParam>(IntrinsicsT<T>::from_array(p.data()), kC > 0 ? p.data() + 5 : zero,
                                  Vec3T<T>(p[kN - 3], p[kN - 2], p[kN - 1]));
      };
      Eigen::Matrix<D, kN, 1> variables;
      for (int i = 0; i < kN; ++i) variables[i] = D(parameters[i], i);
      const auto dual = project_all(variables);
      ASSERT_TRUE(dual);
      for (int i = 0; i < kN; ++i) {
        const auto central = [&](double h) {
          auto low = parameters, high = parameters;
          low[i] -= h;
          high[i] += h;
          return Vec2((*project_all(high) - *project_all(low)) / (2 * h));
        };
        const double h = 2e-4 * std::max(1e-1, std::abs(parameters[i]));
        const Vec2 numeric = (4 * central(h / 2) - central(h)) / 3;
        const Vec2 exact((*dual).x().v[i], (*dual).y().v[i]);
        EXPECT_LT((exact - numeric).norm(), 1e-7 * std::max(1.0, exact.norm()))
            << lens.name << ", parameter " << i << " at " << pixel.transpose();
      }
    }
  }
}

TYPED_TEST(DistortionLaws, DerivativesHoldOnTheAxis) {
  using D = Dual<3>;
  for (const auto& lens : lenses<TypeParam>()) {
    D coefficients[TypeParam::kNumCoefficients + 1];
    for (int i = 0; i < TypeParam::kNumCoefficients; ++i) coefficients[i] = D(lens.model.coefficients[i]);
    const auto image =
        TypeParam::distort(static_cast<const D*>(coefficients), Vec3T<D>(D(0.0, 0), D(0.0, 1), D(2.5, 2)));
    ASSERT_TRUE(image);
    EXPECT_LT((image->x().v - Vec3(0.4, 0, 0)).norm(), 1e-15);
    EXPECT_LT((image->y().v - Vec3(0, 0.4, 0)).norm(), 1e-15);
  }
}

/// Outwards from the axis there is one end: beyond it nothing comes back as a ghost.
TYPED_TEST(DistortionLaws, WhatTheLensSeesHasNoHoles) {
  std::mt19937_64 random(17);
  for (int trial = 0; trial < 1000; ++trial) {
    auto model = this->random_model(random, trial % 2 ? 0.6 : 0.05);
    const double around = test::uniform(random, -3.14, 3.14);
    bool ended = false;
    for (double off_axis = 0; off_axis < 3.14; off_axis += 0.01) {
      const bool seen = this->distort(model, this->direction(off_axis, around)).has_value();
      EXPECT_FALSE(ended && seen) << "trial " << trial << ", " << off_axis << " rad off the axis";
      ended = ended || !seen;
    }
  }
}

/// Two directions on one pixel would be a ghost.
TYPED_TEST(DistortionLaws, UndistortUndoesDistortSoNoTwoDirectionsShareAPixel) {
  std::mt19937_64 random(23);
  int seen = 0;
  for (int trial = 0; trial < 4000; ++trial) {
    const auto model = this->random_model(random, trial % 2 ? 0.3 : 0.02);
    const double around = test::uniform(random, -3.14, 3.14);
    // To nine tenths of the way to the end of what the lens sees, at most 80 degrees for pinhole models.
    double end = 0.05;
    while (end < 3.1 && this->distort(model, this->direction(end, around))) end += 0.05;
    end -= 0.05;
    const double off_axis = std::min(test::uniform(random, 0, 0.9 * end), end > 1.55 ? 3.0 : 1.4);
    const Vec3 point = this->direction(off_axis, around);
    const auto image = this->distort(model, point);
    if (!image) continue;
    ++seen;
    const auto back = this->undistort(model, *image);
    ASSERT_TRUE(back) << "trial " << trial;
    EXPECT_LT((back->normalized() - point).norm(), 1e-8) << "trial " << trial << " at " << off_axis;
  }
  EXPECT_GT(seen, 3000);
}

/// Whatever the numbers: no NaN leaves, nothing hangs, and an inverse that answers is right.
TYPED_TEST(DistortionLaws, CrazyNumbersGiveARightAnswerOrNone) {
  std::mt19937_64 random(31);
  const auto crazy = [&]() {
    const int kind = std::uniform_int_distribution<int>(0, 40)(random);
    if (kind == 0) return kNan;
    if (kind == 1) return kInf;
    if (kind == 2) return -kInf;
    if (kind == 3) return 0.0;
    const double size =
        std::pow(10.0, kind < 8 ? test::uniform(random, -300, 300) : test::uniform(random, -6, 6));
    return kind % 2 ? size : -size;
  };
  int answers = 0;
  for (int trial = 0; trial < 20000; ++trial) {
    TypeParam model;
    for (double& c : model.coefficients) c = trial % 3 ? crazy() : test::uniform(random, -20, 20);
    const Vec3 point(crazy(), crazy(), crazy());
    const auto image = this->distort(model, point);
    EXPECT_TRUE(!image || image->allFinite()) << "trial " << trial;

    const Vec2 pixel = trial % 2 ? Vec2(crazy(), crazy()) : Vec2(test::random_vec3(random, 1.5).head<2>());
    const auto direction = this->undistort(model, pixel);
    if (!direction) continue;
    ++answers;
    ASSERT_TRUE(direction->allFinite()) << "trial " << trial;
    const auto again = this->distort(model, *direction);
    ASSERT_TRUE(again) << "trial " << trial;
    // Rounding near a pole of a rational lens: 2e-13 on x86-64, 6e-13 on arm64, where products and sums are fused.
    EXPECT_LE((*again - pixel).norm(), 1e-12 * (1 + pixel.norm())) << "trial " << trial;
  }
  EXPECT_GT(answers, 1000);
}

TYPED_TEST(DistortionLaws, NothingBehindOrBesideIsSeenByNanOrInfinity) {
  for (const auto& lens : lenses<TypeParam>()) {
    for (const double bad : {kNan, kInf, -kInf}) {
      EXPECT_FALSE(this->distort(lens.model, Vec3(bad, 0.2, 1)));
      EXPECT_FALSE(this->distort(lens.model, Vec3(0.1, bad, 1)));
      EXPECT_FALSE(this->distort(lens.model, Vec3(bad, bad, bad)));
      EXPECT_FALSE(this->undistort(lens.model, Vec2(bad, 0.2)));
      EXPECT_FALSE(this->undistort(lens.model, Vec2(0.1, bad)));
    }
    EXPECT_FALSE(this->distort(lens.model, Vec3(0.1, 0.2, kNan)));
    EXPECT_FALSE(this->distort(lens.model, Vec3(0, 0, 0)));
    EXPECT_FALSE(this->distort(lens.model, Vec3(0, 0, -1))) << "straight behind";
    EXPECT_FALSE(this->distort(lens.model, Vec3(1e200, 0, 1e-200)));
  }
}

TEST(BrownConrady, BarrelEndsAtItsFold) {
  const BrownConrady barrel{{-0.3, 0, 0, 0, 0}};
  const double* c = barrel.coefficients.data();
  const double fold = std::sqrt(1 / 0.9);  // 1 - 0.9 r^2 = 0
  EXPECT_TRUE(BrownConrady::distort(c, Vec3(0, fold - 1e-6, 1)));
  EXPECT_FALSE(BrownConrady::distort(c, Vec3(0, fold + 1e-6, 1)));
  // 1.8 (1 - 0.3 1.8^2) = 0.05: the formula alone would put this ghost next to the picture's centre.
  EXPECT_FALSE(BrownConrady::distort(c, Vec3(1.8, 0, 1)));
  const double largest = fold * (1 - 0.3 * fold * fold);
  EXPECT_TRUE(BrownConrady::undistort(c, Vec2(largest - 1e-6, 0)));
  EXPECT_FALSE(BrownConrady::undistort(c, Vec2(largest + 1e-6, 0)));
}

TEST(BrownConrady, StrongTangentialEndsAtTheFoldOfTheWholeMap) {
  // p2 = -0.2 on the x axis: x' = x - 0.6 x^2 turns round at x = 1 / 1.2, which the radial part never shows.
  const BrownConrady tilted{{0, 0, 0, -0.2, 0}};
  const double* c = tilted.coefficients.data();
  EXPECT_TRUE(BrownConrady::distort(c, Vec3(0.83, 0, 1)));
  EXPECT_FALSE(BrownConrady::distort(c, Vec3(0.84, 0, 1)));
  EXPECT_FALSE(BrownConrady::distort(c, Vec3(1.6, 0, 1)));  // the ghost of x = 0.07
}

/// A model of somebody else, by the recipe of CONTRIBUTING.md: the two functions that are required.
struct SampleLens {
  template <typename T>
  static std::optional<Vec2T<T>> distort(const T*, const Vec3T<T>&);
  static std::optional<Vec3> undistort(const double*, const Vec2&);
};
static_assert(!procam::internal::HasFormula<SampleLens>::value);
static_assert(!procam::internal::HasFormula<FisheyeDistortion>::value);
static_assert(procam::internal::HasFormula<NoDistortion>::value &&
              procam::internal::HasFormula<BrownConrady>::value &&
              procam::internal::HasFormula<RationalDistortion>::value);

TEST(RationalDistortion, EndsBeforeItsPole) {
  const RationalDistortion lens{{0, 0, 0, 0, 0, -0.5, 0, 0}};  // D = 1 - s / 2
  const double* c = lens.coefficients.data();
  EXPECT_TRUE(RationalDistortion::distort(c, Vec3(1.41, 0, 1)));
  EXPECT_FALSE(RationalDistortion::distort(c, Vec3(1.42, 0, 1)));
  EXPECT_FALSE(RationalDistortion::distort(c, Vec3(3, 0, 1)));
}

TEST(RationalDistortion, IsBrownConradyWithoutItsDenominator) {
  const RationalDistortion rational{{-0.2, 0.05, 0.003, -0.002, 0.01, 0, 0, 0}};
  const BrownConrady brown{{-0.2, 0.05, 0.003, -0.002, 0.01}};
  const Vec3 point(0.4, -0.3, 1.1);
  EXPECT_LT((*RationalDistortion::distort(rational.coefficients.data(), point) -
             *BrownConrady::distort(brown.coefficients.data(), point))
                .norm(),
            1e-15);
}

TEST(FisheyeDistortion, IsEquidistantAndSeesBehindItself) {
  const FisheyeDistortion lens;
  const double* c = lens.coefficients.data();
  for (const double theta : {1e-9, 0.4, 1.5707963267948966, 2.2, 3.1}) {
    const auto image = FisheyeDistortion::distort(c, Vec3(std::sin(theta), 0, std::cos(theta)));
    ASSERT_TRUE(image) << theta;
    EXPECT_NEAR(image->x(), theta, 1e-14) << theta;
  }
}

TEST(FisheyeDistortion, EndsAtItsFold) {
  const FisheyeDistortion lens{{-0.1, 0, 0, 0}};  // 1 - 0.3 theta^2 = 0
  const double* c = lens.coefficients.data();
  const double fold = std::sqrt(1 / 0.3);
  EXPECT_TRUE(FisheyeDistortion::distort(c, Vec3(std::sin(fold - 1e-6), 0, std::cos(fold - 1e-6))));
  EXPECT_FALSE(FisheyeDistortion::distort(c, Vec3(std::sin(fold + 1e-6), 0, std::cos(fold + 1e-6))));
}

TEST(Distortion, AnUnknownNameIsRefusedWithTheKnownOnes) {
  try {
    distortion_named("brown-conrady");
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kUnsupported);
    EXPECT_EQ(error.next(), "use one of: none, brown_conrady, rational, fisheye");
  }
}

}  // namespace
}  // namespace procam
