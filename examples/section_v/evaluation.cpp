#include "evaluation.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "procam/core/base/cholesky.hpp"
#include "procam/core/base/closed_form.hpp"
#include "procam/core/base/words.hpp"
#include "procam/core/geometry/se3.hpp"

namespace procam::section_v {

using analyze::LandingError;
using analyze::LightPath;

namespace {

/// The projector alone, as a rig: its own frame is the rig's. All its light is turned by `turn` about it.
LightPath light_path(const Projector& projector, const Pose& projector_from_sheet,
                     const Vec3& turn = Vec3::Zero()) {
  RigProjector alone;
  alone.name = "projector";
  alone.projector = projector;
  LightPath path;
  path.projector = alone;
  path.rig_from_surface = Pose(so3_exp(Vec3(-turn)), Vec3::Zero()) * projector_from_sheet;
  return path;
}

/// Where a corner's light lands, by rotations of all light (radians) and by the pixel: central differences.
struct LandingDerivatives {
  Mat23 by_turn;
  Mat2 by_pixel;
};

std::optional<LandingDerivatives> landing_derivatives(const Projector& projector,
                                                      const Pose& projector_from_sheet,
                                                      const Vec2& on_sheet) {
  constexpr double kTurnStep = 1e-5, kPixelStep = 1e-2;
  const auto pixel = projector.project(projector_from_sheet * Vec3(on_sheet.x(), on_sheet.y(), 0));
  if (!pixel) return std::nullopt;
  LandingDerivatives derivatives;
  const auto column = [&](const Vec3& turn, const Vec2& offset, double step, auto&& out) {
    const auto after =
        analyze::landing_place(light_path(projector, projector_from_sheet, turn), *pixel + offset);
    const auto before =
        analyze::landing_place(light_path(projector, projector_from_sheet, -turn), *pixel - offset);
    if (after && before) out = (*after - *before) / (2 * step);
    return after && before;
  };
  for (int i = 0; i < 3; ++i)
    if (!column(kTurnStep * Vec3::Unit(i), Vec2::Zero(), kTurnStep, derivatives.by_turn.col(i)))
      return std::nullopt;
  for (int i = 0; i < 2; ++i)
    if (!column(Vec3::Zero(), kPixelStep * Vec2::Unit(i), kPixelStep, derivatives.by_pixel.col(i)))
      return std::nullopt;
  return derivatives;
}

double median_of(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

double deviation_of(const std::vector<double>& values) {
  if (values.size() < 2) return 0;
  double mean = 0, squares = 0;
  for (double value : values) mean += value / double(values.size());
  for (double value : values) squares += (value - mean) * (value - mean);
  return std::sqrt(squares / double(values.size() - 1));
}

CornerRow row_of(const std::vector<const Landing*>& landings) {
  CornerRow row;
  row.count = int(landings.size());
  if (landings.empty()) return row;
  for (int axis = 0; axis < 2; ++axis) {
    std::vector<double> physical, projected;
    for (const Landing* landing : landings) {
      physical.push_back(landing->physical[axis]);
      projected.push_back(landing->projected[axis]);
    }
    row.physical[axis] = median_of(physical);
    row.median[axis] = median_of(projected);
    row.standard_deviation[axis] = deviation_of(projected);
  }
  row.error = (row.median - row.physical).norm();
  return row;
}

/// One landing with the placement that it belongs to.
struct Seen {
  const SheetPlacement* placement;
  const Landing* landing;

  Vec2 offset() const { return landing->projected - landing->physical; }
};

std::optional<LightTurn> turn_of(const std::vector<Seen>& all, const Projector& projector) {
  Mat3 normal = Mat3::Zero();
  Vec3 right = Vec3::Zero();
  double squares = 0;
  std::vector<Mat23> rows;
  for (const Seen& seen : all) {
    const auto moved =
        landing_derivatives(projector, seen.placement->projector_from_sheet, seen.landing->physical);
    if (!moved) return std::nullopt;
    rows.push_back(moved->by_turn);
    normal += rows.back().transpose() * rows.back();
    right += rows.back().transpose() * seen.offset();
    squares += seen.offset().squaredNorm();
  }
  const Cholesky<3> factors(normal);
  if (all.size() < 3 || factors.pivots().minCoeff() <= 1e-9 * normal.trace()) return std::nullopt;
  LightTurn turn{factors.solve(right), 0, 0};
  double rest = 0;
  for (std::size_t i = 0; i < all.size(); ++i)
    rest += (all[i].offset() - rows[i] * turn.rotation).squaredNorm();
  turn.explained = squares > 0 ? 1 - rest / squares : 0;
  turn.rest_mm = 1e3 * std::sqrt(rest / double(all.size()));
  return turn;
}

void predict_from(const std::vector<Seen>& all, SheetEvaluation& result) {
  std::vector<const LandingError*> predicted;
  int inside = 0;
  for (const Seen& seen : all) {
    if (!seen.landing->predicted) continue;
    const LandingError& error = *seen.landing->predicted;
    predicted.push_back(&error);
    const Vec2 rest = seen.offset() - error.total.bias;
    const Cholesky<2> factors(error.total.covariance);
    // Chi-square of two degrees of freedom: 95 %.
    inside += factors.pivots().minCoeff() > 0 && rest.dot(factors.solve(rest)) <= 5.991464547107979;
  }
  if (predicted.empty()) return;
  double squares = 0;
  for (const LandingError* error : predicted) squares += error->total.rms() * error->total.rms();
  result.predicted_rms_mm = 1e3 * std::sqrt(squares / double(predicted.size()));
  result.inside_95 = double(inside) / double(predicted.size());
  result.causes = analyze::rank_causes(predicted);
  double pose = 0;
  for (const LandingError* error : predicted)
    for (const LandingError::SourceError& source : error->sources)
      if (source.name == "rig pose") pose += source.rms() * source.rms();
  result.pose_rms_mm = 1e3 * std::sqrt(pose / double(predicted.size()));
}

SheetEvaluation evaluate_sheet(const Sheet& sheet, const std::vector<Seen>& all, const Projector& projector) {
  SheetEvaluation result;
  result.sheet = sheet;
  result.landings = int(all.size());
  std::vector<const SheetPlacement*> placements;
  std::array<std::vector<const Landing*>, 4> of_corner;
  std::vector<double> distances;
  double per_pixel = 0;
  for (const Seen& seen : all) {
    if (placements.empty() || placements.back() != seen.placement) placements.push_back(seen.placement);
    of_corner[std::size_t(seen.landing->corner)].push_back(seen.landing);
    const double mm = 1e3 * seen.offset().norm();
    distances.push_back(mm);
    result.mean_mm += mm / double(all.size());
    result.rms_mm += mm * mm / double(all.size());
    result.worst_mm = std::max(result.worst_mm, mm);
    const auto moved =
        landing_derivatives(projector, seen.placement->projector_from_sheet, seen.landing->physical);
    // A pixel's error has all directions alike.
    if (moved) per_pixel += 0.5 * moved->by_pixel.squaredNorm() / double(all.size());
  }
  result.placements = int(placements.size());
  result.rms_mm = std::sqrt(result.rms_mm);
  result.median_mm = median_of(distances);
  result.mm_per_pixel = 1e3 * std::sqrt(per_pixel);
  for (std::size_t i = 0; i < 4; ++i) result.corners[i] = row_of(of_corner[i]);
  result.turn = turn_of(all, projector);
  predict_from(all, result);
  return result;
}

double mean_distance(const std::vector<SheetPlacement>& placements, int sheet) {
  double sum = 0;
  int count = 0;
  for (const SheetPlacement& placement : placements) {
    if (placement.sheet != sheet) continue;
    for (const Landing& landing : placement.landings) {
      sum += (landing.projected - landing.physical).norm();
      ++count;
    }
  }
  return count > 0 ? sum / count : 0;
}

}  // namespace

std::array<Vec2, 4> sheet_corners(const Sheet& sheet) {
  const Vec2 half = 0.5 * sheet.size;
  return {Vec2(-half.x(), -half.y()), Vec2(half.x(), -half.y()), half, Vec2(-half.x(), half.y())};
}

Pose place_sheet(const Projector& projector, const Sheet& sheet, const Vec2& pixel, double distance,
                 bool to_right, double roll) {
  require(sheet.incidence_deg >= 0 && sheet.incidence_deg < 90 && distance > 0 && std::isfinite(distance) &&
              std::isfinite(roll),
          "place_sheet: an incidence of 0 to 90 degrees and a positive distance");
  const auto ray = projector.emit(pixel);
  require(ray.has_value(), "place_sheet: the lens does not know that pixel");
  const Mat3 across = rotation_between(Vec3::UnitZ(), ray->direction).toRotationMatrix();
  const double turn = (to_right ? -1 : 1) * sheet.incidence_deg * kDegree;
  const Mat3 rotation =
      across * so3_exp(Vec3(0, turn, 0)).toRotationMatrix() * so3_exp(Vec3(0, 0, roll)).toRotationMatrix();
  return Pose(Eigen::Quaterniond(rotation), distance * ray->direction);
}

std::vector<Sheet> original_sheets() {
  return {{"47 degrees", Vec2(0.202, 0.211), 47}, {"60 degrees", Vec2(0.1485, 0.211), 60}};
}

Sheet sheet_at(double incidence_deg) {
  for (const Sheet& sheet : original_sheets())
    if (sheet.incidence_deg == incidence_deg) return sheet;
  return {shortest(incidence_deg) + " degrees", original_sheets().front().size, incidence_deg};
}

std::vector<SheetPlacement> draw_placements(const Projector& projector, const SheetLayout& layout,
                                            std::uint64_t seed) {
  require(layout.placements > 0 && !layout.distances.empty(),
          "draw_placements: a placement and a distance, or more");
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const ImageSize size = projector.size();
  std::vector<SheetPlacement> placements;
  for (int sheet = 0; sheet < int(layout.sheets.size()); ++sheet)
    for (int i = 0; i < layout.placements; ++i) {
      const double u = size.width * (0.5 + uniform(random) / 6),
                   v = size.height * (0.5 + uniform(random) / 6);
      SheetPlacement placement{sheet, layout.distances[std::size_t(i) % layout.distances.size()], Pose(), {}};
      placement.projector_from_sheet =
          place_sheet(projector, layout.sheets[std::size_t(sheet)], Vec2(u, v), placement.distance,
                      i % 2 == 1, 5 * kDegree * uniform(random));
      placements.push_back(placement);
    }
  return placements;
}

Evaluation evaluate(const std::vector<Sheet>& sheets, const std::vector<SheetPlacement>& placements,
                    const Projector& projector) {
  Evaluation evaluation{{}, sheets, placements, {}};
  for (int sheet = 0; sheet < int(sheets.size()); ++sheet) {
    std::vector<Seen> all;
    for (const SheetPlacement& placement : evaluation.placements) {
      require(placement.sheet >= 0 && placement.sheet < int(sheets.size()),
              "evaluate: a placement of no sheet");
      if (placement.sheet != sheet) continue;
      for (const Landing& landing : placement.landings) {
        require(landing.corner >= 0 && landing.corner < 4 && landing.physical.allFinite() &&
                    landing.projected.allFinite(),
                "evaluate: a landing that is not finite or of no corner");
        all.push_back({&placement, &landing});
      }
    }
    if (!all.empty())
      evaluation.results.push_back(evaluate_sheet(sheets[std::size_t(sheet)], all, projector));
  }
  if (evaluation.results.empty())
    throw Error(ErrorKind::kNotEnoughData, "evaluation", "no corner landed on any sheet",
                "place the sheets where the projector's frame reaches them");
  return evaluation;
}

void draw_crude_landings(std::vector<SheetPlacement>& placements, const std::vector<Sheet>& sheets,
                         const Projector& projector, const CrudeCalibration& crude, std::uint64_t seed) {
  require(crude.pixel_rms >= 0 && crude.turn.size() == sheets.size(),
          "draw_crude_landings: a pixel error that is not negative, and a turn for each sheet");
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> direction(0, 2 * kPi);
  Points3 turned;
  for (double turn : crude.turn) {
    const double angle = direction(random);
    turned.push_back(turn * Vec3(std::cos(angle), std::sin(angle), 0));
  }
  for (SheetPlacement& placement : placements) {
    const auto sheet = std::size_t(placement.sheet);
    const LightPath path = light_path(projector, placement.projector_from_sheet, turned[sheet]);
    const std::array<Vec2, 4> corners = sheet_corners(sheets[sheet]);
    placement.landings.clear();
    for (int i = 0; i < 4; ++i) {
      const Vec2 corner = corners[std::size_t(i)];
      const Vec2 offset = crude.pixel_rms / std::sqrt(2.0) * Vec2{normal(random), normal(random)};
      const auto pixel = projector.project(placement.projector_from_sheet * Vec3(corner.x(), corner.y(), 0));
      const auto landed = pixel ? analyze::landing_place(path, *pixel + offset) : std::nullopt;
      if (landed) placement.landings.push_back({i, corner, *landed, std::nullopt});
    }
  }
}

double turn_explaining(const std::vector<SheetPlacement>& placements, const std::vector<Sheet>& sheets,
                       int sheet, const Projector& projector, double pixel_rms, double mean_mm,
                       std::uint64_t seed) {
  require(sheet >= 0 && sheet < int(sheets.size()), "turn_explaining: no such sheet");
  std::vector<SheetPlacement> drawn = placements;
  const auto mean_at = [&](double turn) {
    draw_crude_landings(drawn, sheets, projector, {pixel_rms, std::vector<double>(sheets.size(), turn)},
                        seed);
    return 1e3 * mean_distance(drawn, sheet);
  };
  double low = 0, high = 5 * kDegree;
  if (mean_at(low) >= mean_mm) return 0;
  for (int i = 0; i < 30; ++i) (mean_at(0.5 * (low + high)) < mean_mm ? low : high) = 0.5 * (low + high);
  return 0.5 * (low + high);
}

}  // namespace procam::section_v
