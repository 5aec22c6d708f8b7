#include "sheet_experiment.hpp"

#include "procam/detect/marker_edges.hpp"
#include "procam/simulate/marker_view.hpp"
#include "procam/track/locate.hpp"

namespace procam::section_v {
namespace {

/// Where the true projector's light falls on the true sheet when `steering` lights its corners there.
std::vector<Landing> landings(const Sheet& sheet, const Projector& steering, const Pose& steering_from_sheet,
                              const Projector& truth, const Pose& truth_from_sheet) {
  std::vector<Landing> landed;
  const std::array<Vec2, 4> corners = sheet_corners(sheet);
  for (int i = 0; i < 4; ++i) {
    const Vec2 corner = corners[std::size_t(i)];
    const auto pixel = steering.project(steering_from_sheet * Vec3(corner.x(), corner.y(), 0));
    if (!pixel || !truth.size().contains(*pixel)) continue;
    const auto hit = truth.intersect(*pixel, Plane::of_xy(truth_from_sheet));
    if (!hit) continue;
    const Vec3 on_sheet = truth_from_sheet.inverse() * *hit;
    landed.push_back({i, corner, on_sheet.head<2>(), std::nullopt});
  }
  return landed;
}

Pose projector_from_camera(const Rig& rig) {
  return rig.projectors.front().rig_from_projector.inverse() * rig.cameras.front().rig_from_camera;
}

}  // namespace

SheetExperiment run_sheet_experiment(std::vector<SheetPlacement> placements, const std::vector<Sheet>& sheets,
                                     const Rig& truth, const Rig& rig, double noise_grey, std::uint64_t seed,
                                     const std::function<void(int)>& step) {
  const RigCamera &true_camera = truth.cameras.front(), &camera = rig.cameras.front();
  const RigProjector& projector = rig.projectors.front();
  const Projector& true_projector = truth.projectors.front().projector;
  const Pose true_projector_from_camera = projector_from_camera(truth);
  MarkerMap map;
  map.dictionary = MarkerDictionary::kAprilTag36h11;
  const MarkerCells codes = detect::marker_cells(map.dictionary);

  SheetExperiment experiment;
  for (std::size_t i = 0; i < placements.size(); ++i) {
    step(int(i));
    SheetPlacement& placement = placements[i];
    const Sheet& sheet = sheets[std::size_t(placement.sheet)];
    const Pose true_camera_from_sheet = true_projector_from_camera.inverse() * placement.projector_from_sheet;
    map.markers = {{3, kMarkerSize,
                    Pose(Eigen::Quaterniond::Identity(), Vec3(0, 0.5 * sheet.size.y() + kMarkerBelow, 0))}};
    simulate::MarkerViewOptions view;
    view.noise = {noise_grey * noise_grey, 0};
    view.seed = seed + i;
    const ImageU8 image =
        simulate::marker_view(true_camera.camera, true_camera_from_sheet, map.markers, codes, view);
    const auto located = [&](const Camera& lens) -> std::optional<track::LocateResult> {
      try {
        return track::locate(detect::detect_marker_edges(image, codes, {lens}), lens, map);
      } catch (const Error&) {
        return std::nullopt;
      }
    };
    const auto seen = located(camera.camera), seen_by_truth = located(true_camera.camera);
    if (!seen || !seen_by_truth) {
      ++experiment.unseen;
      continue;
    }
    const auto add = [&](std::vector<SheetPlacement>& list, const Projector& steering,
                         const Pose& steering_from_sheet) {
      list.push_back(placement);
      list.back().landings =
          landings(sheet, steering, steering_from_sheet, true_projector, placement.projector_from_sheet);
    };
    add(experiment.placements, projector.projector, projector_from_camera(rig) * seen->camera_from_world);
    add(experiment.with_true_pose, projector.projector, projector_from_camera(rig) * true_camera_from_sheet);
    add(experiment.with_true_calibration, true_projector,
        true_projector_from_camera * seen_by_truth->camera_from_world);

    if (rig.covariance.empty()) continue;
    analyze::ErrorSources sources;
    sources.calibration = rig.covariance;
    analyze::set_measured_pose(sources, camera, seen->covariance, seen->jacobian_lens);
    const analyze::LightPath path{projector, camera.rig_from_camera * seen->camera_from_world, true, true};
    for (Landing& landing : experiment.placements.back().landings)
      landing.predicted = analyze::landing_error(path, sources, landing.physical);
  }
  return experiment;
}

}  // namespace procam::section_v
