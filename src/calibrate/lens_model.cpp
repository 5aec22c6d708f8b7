#include "procam/calibrate/lens_model.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include "lens_models.hpp"

namespace procam::calibrate {
namespace {

constexpr double kWideAngle = 35 * kDegree;

bool among(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> parts{""};
  for (const char c : text)
    if (c == ',')
      parts.emplace_back();
    else
      parts.back() += c;
  return parts;
}

/// The largest angle off the axis of the image's corners; of a corner that a lens model does not reach, the
/// pinhole's.
double widest_angle(const Camera& lens) {
  const auto angle = [&](const Vec2& pixel) {
    const auto bearing = lens.unproject(pixel);
    return bearing ? std::acos(std::clamp(bearing->z(), -1.0, 1.0))
                   : std::atan(lens.intrinsics.normalized_from_pixel(pixel).norm());
  };
  double widest = 0;
  for (const double x : {-0.5, lens.size.width - 0.5})
    for (const double y : {-0.5, lens.size.height - 0.5}) widest = std::max(widest, angle(Vec2(x, y)));
  return widest;
}

/// theta (1 + k1 theta^2 + ...) = the lens's own distorted radius, along a ray between the axes.
FisheyeDistortion fisheye_like(const Camera& lens) {
  const double widest = std::min(widest_angle(lens), 1.4);
  constexpr int kSamples = 24;
  MatX powers(kSamples, 4);
  VecX excess(kSamples);
  int rows = 0;
  for (int i = 1; i <= kSamples; ++i) {
    const double theta = widest * i / kSamples, s = std::sin(theta) * std::sqrt(0.5);
    const auto pixel = lens.project(Vec3(s, s, std::cos(theta)));
    if (!pixel) continue;
    const double radius = lens.intrinsics.normalized_from_pixel(*pixel).norm(), t = theta * theta;
    powers.row(rows) << theta * t, theta * t * t, theta * t * t * t, theta * t * t * t * t;
    excess[rows++] = radius - theta;
  }
  FisheyeDistortion fisheye;
  if (rows < 4) return fisheye;
  const VecX k = powers.topRows(rows).colPivHouseholderQr().solve(excess.head(rows));
  for (int i = 0; i < 4; ++i) fisheye.coefficients[std::size_t(i)] = k[i];
  return fisheye;
}

}  // namespace

LensModel lens_model_named(const std::string& name) {
  const std::size_t colon = name.find(':');
  std::string distortion = name.substr(0, colon);
  std::replace(distortion.begin(), distortion.end(), '-', '_');
  LensModel model{name, distortion_named(distortion), {}};
  const std::vector<std::string> known = coefficient_names(model.distortion);
  std::vector<std::string> estimated = known;
  if (colon != std::string::npos)
    estimated = split(name.substr(colon + 1));
  else if (std::holds_alternative<BrownConrady>(model.distortion))
    estimated = {"k1", "k2", "p1", "p2"};
  for (const std::string& coefficient : estimated)
    if (!among(known, coefficient))
      throw Error(ErrorKind::kInput, "lens model '" + name + "'",
                  "it has no coefficient '" + coefficient + "'",
                  "name some of those it has, e.g. brown-conrady:k1,k2");
  for (const std::string& coefficient : known)
    if (!among(estimated, coefficient)) model.held.push_back(coefficient);
  return model;
}

std::vector<LensModel> candidate_lens_models(const Camera& lens, DeviceKind kind) {
  std::vector<LensModel> ladder;
  for (const char* name :
       {"none", "brown-conrady:k1,k2", kWithoutTangential, "brown-conrady", kUsualLensModel, "rational"})
    ladder.push_back(lens_model_named(name));
  if (kind == DeviceKind::kCamera && widest_angle(lens) > kWideAngle)
    ladder.push_back(lens_model_named("fisheye"));
  return ladder;
}

Camera in_model(const Camera& lens, const LensModel& model) {
  Camera out{lens.size, lens.intrinsics, model.distortion};
  const bool was_fisheye = std::holds_alternative<FisheyeDistortion>(lens.distortion);
  const bool is_fisheye = std::holds_alternative<FisheyeDistortion>(model.distortion);
  if (is_fisheye && !was_fisheye) {
    out.distortion = fisheye_like(lens);
  } else if (is_fisheye == was_fisheye) {
    const std::vector<std::string> from = coefficient_names(lens.distortion),
                                   to = coefficient_names(model.distortion);
    const std::vector<double> values = coefficients_of(lens.distortion);
    std::vector<double> kept(to.size(), 0.0);
    for (std::size_t i = 0; i < to.size(); ++i)
      for (std::size_t j = 0; j < from.size(); ++j)
        if (to[i] == from[j] && !among(model.held, to[i])) kept[i] = values[j];
    out.distortion = with_coefficients(model.distortion, kept);
  }
  return out;
}

double folded_share(const Camera& lens, double reach) {
  int lost = 0;
  for (int j = 0; j <= 16; ++j)
    for (int i = 0; i <= 16; ++i) {
      const Vec2 pixel(-0.5 + lens.size.width * i / 16.0, -0.5 + lens.size.height * j / 16.0);
      lost +=
          (pixel - Vec2(lens.intrinsics.cx, lens.intrinsics.cy)).norm() <= reach && !lens.unproject(pixel);
    }
  return lost / 289.0;
}

double reach_of(const Correspondences& data, const UsedMask& used, std::size_t device, const Camera& lens) {
  double farthest = 0;
  for (std::size_t v = 0; v < data.views.size(); ++v)
    for (const Measurement& m : measurements_of(data, int(v), int(device)))
      if (used[v][device][std::size_t(m.index)])
        farthest = std::max(farthest, (m.pixel() - Vec2(lens.intrinsics.cx, lens.intrinsics.cy)).norm());
  return 1.1 * farthest;
}

}  // namespace procam::calibrate
