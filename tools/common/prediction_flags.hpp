#pragma once
/// Options of predict-error: rig and surfaces, uncertainties, draws and output files.
#include <CLI/CLI.hpp>
#include <optional>

#include "procam/analyze/monte_carlo.hpp"
#include "procam/core/geometry/frame_tree.hpp"
#include "procam/io/text.hpp"

namespace procam::tools {

struct PredictionFlags {
  std::string rig, surfaces, pose, projector, report, figures, data, save_draws;
  std::vector<std::string> draws_files;
  std::optional<io::LengthAndAngle> pose_sigma;
  io::LengthAndAngle map_sigma, speed, speed_sigma;
  Vec3 forward = Vec3::UnitZ(), up = -Vec3::UnitY();
  double delay = 0, delay_sigma = 0;
  bool predict = false, whole_pixels = false;
  analyze::MonteCarloOptions draws{0};
};

void declare(CLI::App& app, PredictionFlags& flags);

/// `frames`: with the pose of the rig in the world, where one is given.
analyze::ErrorSources sources_of(const PredictionFlags& flags, const Rig& rig,
                                 const std::optional<FrameTree>& frames);

}  // namespace procam::tools
