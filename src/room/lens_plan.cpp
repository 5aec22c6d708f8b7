#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "procam/core/base/words.hpp"
#include "start.hpp"

namespace procam::room {
namespace {

constexpr double kSquareShare = 0.005, kSkewShare = 0.005, kTangential = 0.005, kCornerShare = 0.15,
                 kHighOrderShare = 0.05;

/// What a lens without a stated deviation may be off by, as a data sheet's: shares of the focal length, of the image's
/// width and of the corner's distance from the axis.
constexpr double kSheetFocal = 0.1, kSheetCentre = 0.03, kSheetCorner = 0.1;

/// Of the image's farthest corner on the normalised plane, the square of its distance from the axis.
double corner_square(const Camera& lens) {
  double corner = 0;
  for (const double x : {-0.5, lens.size.width - 0.5})
    for (const double y : {-0.5, lens.size.height - 0.5})
      corner = std::max(corner, lens.intrinsics.normalized_from_pixel(Vec2(x, y)).norm());
  return std::pow(std::clamp(corner, 0.2, 2.0), 2);
}

/// Weak knowledge of any lens, as calibration from boards has it (src/calibrate/lens_prior.cpp), and square pixels.
void add_any_lens(const Camera& lens, int index, std::vector<LensKnowledge>& known) {
  const Intrinsics& k = lens.intrinsics;
  known.push_back({index, {{0, 1.0}, {1, -1.0}}, 0, kSquareShare * k.fx});
  known.push_back({index, {{4, 1.0}}, 0, kSkewShare * k.fx});
  const double squares = corner_square(lens);
  known.push_back({index, {{5, 1.0}}, 0, kCornerShare / squares});
  known.push_back({index, {{6, 1.0}}, 0, kCornerShare / (squares * squares)});
  known.push_back({index, {{7, 1.0}}, 0, kTangential});
  known.push_back({index, {{8, 1.0}}, 0, kTangential});
  known.push_back({index, {{9, 1.0}}, 0, kHighOrderShare / (squares * squares * squares)});
}

void add_guess(const LensGuess& guess, int index, std::vector<LensKnowledge>& known) {
  known.push_back({index, {{0, 1.0}}, guess.focal, guess.focal_sigma * guess.focal});
  known.push_back({index, {{2, 1.0}}, guess.centre.x(), guess.centre_sigma.x()});
  known.push_back({index, {{3, 1.0}}, guess.centre.y(), guess.centre_sigma.y()});
}

/// The covariance of a lens that was calibrated before, as independent combinations of its parameters.
void add_covariance(const CameraLens& camera, int index, LensPlan& plan) {
  const std::vector<std::string> all = parameter_names(camera.lens);
  const VecX values = parameters_of(camera.lens);
  std::vector<std::string> names;
  std::vector<int> rows;
  for (std::size_t i = 0; i < all.size(); ++i)
    if (camera.covariance.sigma(all[i]) > 0) names.push_back(all[i]), rows.push_back(int(i));
  if (names.empty()) return;
  const MatX covariance = camera.covariance.block(names);
  const VecX sigma = covariance.diagonal().cwiseSqrt();
  const Eigen::LLT<MatX> factor(
      MatX(sigma.cwiseInverse().asDiagonal() * covariance * sigma.cwiseInverse().asDiagonal()));
  if (!sigma.allFinite() || factor.info() != Eigen::Success)
    throw Error(ErrorKind::kInput, "the known camera's lens", "its covariance is not positive definite",
                "calibrate the camera again, or give its lens without a covariance");
  const MatX whitened = factor.matrixL().solve(MatX(sigma.cwiseInverse().asDiagonal()));
  for (Eigen::Index row = 0; row < whitened.rows(); ++row) {
    LensKnowledge known{index, {}, 0, 1};
    for (Eigen::Index i = 0; i <= row; ++i) {
      known.terms.emplace_back(rows[std::size_t(i)], whitened(row, i));
      known.value += whitened(row, i) * values[rows[std::size_t(i)]];
    }
    plan.known.push_back(std::move(known));
    plan.free[std::size_t(index)][std::size_t(rows[std::size_t(row)])] = 1;
  }
}

/// A known lens whose focal length, principal point and distortion in the corner are uncertain by shares: of the focal
/// length, of the same, and of the corner's distance from the axis. The shape of the pixels and the skew are exact.
void add_share(LensPlan& plan, int camera, double focal, double centre, double corner_share) {
  const auto index = std::size_t(camera);
  const Camera& lens = plan.lenses[index];
  const Intrinsics& k = lens.intrinsics;
  const VecX values = parameters_of(lens);
  const double squares = corner_square(lens);
  std::vector<char>& free = plan.free[index];
  free.assign(std::size_t(values.size()), 0);
  std::fill(free.begin(), free.begin() + 4, 1);
  constexpr double kSquareOfKnown = 1e-3;
  plan.known.push_back({camera, {{0, 1.0}, {1, -k.fx / k.fy}}, 0, kSquareOfKnown * k.fx});
  plan.known.push_back({camera, {{0, 1.0}}, k.fx, focal * k.fx});
  plan.known.push_back({camera, {{2, 1.0}}, k.cx, centre * k.fx});
  plan.known.push_back({camera, {{3, 1.0}}, k.cy, centre * k.fx});
  const auto uncertain = [&](int parameter, double sigma) {
    if (parameter >= int(values.size())) return;
    free[std::size_t(parameter)] = 1;
    plan.known.push_back({camera, {{parameter, 1.0}}, values[parameter], sigma});
  };
  uncertain(5, corner_share / squares);
  uncertain(6, corner_share / (squares * squares));
  if (!std::holds_alternative<BrownConrady>(lens.distortion)) return;
  uncertain(7, std::min(kTangential, corner_share));
  uncertain(8, std::min(kTangential, corner_share));
  uncertain(9, std::min(kHighOrderShare, corner_share) / (squares * squares * squares));
}

LensGuess projector_guess(const Device& projector, const LensSheet& sheet) {
  LensGuess guess;
  guess.size = projector.size;
  const double width = projector.size.width, height = projector.size.height;
  guess.focal = 1.5 * width;
  guess.focal_sigma = 0.7;
  guess.centre = Vec2(0.5 * (width - 1), 0.5 * (height - 1));
  guess.centre_sigma = Vec2(0.2 * width, 0.4 * height);
  if (sheet.throw_ratio) {
    guess.focal = sheet.throw_ratio->value * width;
    guess.focal_sigma = sheet.throw_ratio->sigma / sheet.throw_ratio->value;
  }
  if (sheet.shift_x) {
    guess.centre.x() += sheet.shift_x->value * width;
    guess.centre_sigma.x() = sheet.shift_x->sigma * width;
  }
  if (sheet.shift_y) {
    guess.centre.y() += sheet.shift_y->value * height;
    guess.centre_sigma.y() = sheet.shift_y->sigma * height;
  }
  return guess;
}

LensGuess camera_guess(const Device& camera, const CameraSheet* sheet) {
  LensGuess guess;
  guess.size = camera.size;
  const double width = camera.size.width, height = camera.size.height;
  guess.focal = 1.1 * width;
  guess.focal_sigma = 0.5;
  guess.centre = Vec2(0.5 * (width - 1), 0.5 * (height - 1));
  guess.centre_sigma = Vec2(0.02 * width, 0.02 * width);
  if (sheet != nullptr) {
    guess.focal = sheet->focal_px.value;
    guess.focal_sigma = sheet->focal_px.sigma / sheet->focal_px.value;
  }
  return guess;
}

}  // namespace

LensPlan plan_lenses(const RoomPoints& points, const RoomOptions& options) {
  LensPlan plan;
  const auto add_unknown = [&](const LensGuess& guess) {
    const int index = int(plan.lenses.size());
    plan.lenses.push_back(
        {guess.size, {guess.focal, guess.focal, guess.centre.x(), guess.centre.y(), 0}, BrownConrady{}});
    plan.guess.emplace_back(guess);
    plan.free.emplace_back(10, 1);
    plan.unstated.push_back(0);
    add_guess(guess, index, plan.known);
    add_any_lens(plan.lenses.back(), index, plan.known);
  };
  for (const Device& camera : points.cameras) {
    const auto known = options.cameras.find(camera.name);
    if (known == options.cameras.end()) {
      plan.cameras_known = false;
      const auto sheet = options.camera_sheets.find(camera.name);
      add_unknown(camera_guess(camera, sheet == options.camera_sheets.end() ? nullptr : &sheet->second));
      continue;
    }
    const Camera& lens = known->second.lens;
    if (lens.size != camera.size)
      throw Error(
          ErrorKind::kInput, "known camera '" + camera.name + "'",
          "its lens is for images of " + counts(lens.size) + ", the captures are " + counts(camera.size),
          "give the lens of this camera at this resolution");
    const bool has_covariance = !known->second.covariance.names.empty(),
               has_sigma = bool(known->second.sigma);
    const bool varies = !has_covariance && known->second.sigma.value_or(0) > 0;
    plan.lenses.push_back(varies || (!has_covariance && !has_sigma) ? with_distortion(lens) : lens);
    plan.guess.emplace_back();
    plan.free.emplace_back(std::size_t(parameters_of(plan.lenses.back()).size()), 0);
    plan.unstated.push_back(!has_covariance && !has_sigma);
    const int index = int(plan.lenses.size()) - 1;
    if (has_covariance) add_covariance(known->second, index, plan);
    if (varies) {
      const double sigma = *known->second.sigma;
      add_share(plan, index, sigma, sigma, sigma);
    }
  }
  for (const Device& projector : points.projectors) {
    const auto sheet = options.projectors.find(projector.name);
    add_unknown(projector_guess(projector, sheet == options.projectors.end() ? LensSheet{} : sheet->second));
  }
  return plan;
}

Camera with_distortion(const Camera& lens) {
  if (!std::holds_alternative<NoDistortion>(lens.distortion)) return lens;
  return {lens.size, lens.intrinsics, BrownConrady{}};
}

LensPlan widened(const LensPlan& plan, const std::vector<char>& chosen) {
  LensPlan out = plan;
  for (std::size_t index = 0; index < chosen.size(); ++index) {
    if (!chosen[index] || plan.guess[index]) continue;
    const int camera = int(index);
    out.known.erase(std::remove_if(out.known.begin(), out.known.end(),
                                   [&](const LensKnowledge& known) { return known.lens == camera; }),
                    out.known.end());
    out.lenses[index] = with_distortion(plan.lenses[index]);
    const double width = plan.lenses[index].size.width;
    add_share(out, camera, kSheetFocal, kSheetCentre * width / plan.lenses[index].intrinsics.fx,
              kSheetCorner);
  }
  return out;
}

std::vector<LensKnowledge> knowledge_at(const LensPlan& plan, const RoomState& state) {
  std::vector<LensKnowledge> known;
  for (const LensKnowledge& item : plan.known)
    if (!plan.guess[std::size_t(item.lens)]) known.push_back(item);
  for (std::size_t l = 0; l < plan.guess.size(); ++l)
    if (plan.guess[l]) {
      add_guess(*plan.guess[l], int(l), known);
      add_any_lens(state.lenses[l], int(l), known);
    }
  return known;
}

}  // namespace procam::room
