#include "common/rig_words.hpp"

#include <algorithm>
#include <cmath>

#include "procam/core/se3.hpp"

namespace procam::tools {

std::string of_projector(const Rig& rig, const std::string& group, const RigProjector& projector,
                         const std::string& figure) {
  return group + (rig.projectors.size() > 1 ? "/" + projector.name : "") + figure;
}

std::string said_of(const Rig& rig, const RigProjector& projector) {
  return rig.projectors.size() > 1 ? "of " + projector.name + " " : "";
}

namespace {

/// Decimals that show two digits of a sigma, one of a number that has none.
int decimals(double sigma) {
  return sigma > 0 ? std::clamp(1 - int(std::floor(std::log10(sigma))), 0, 4) : 1;
}

}  // namespace

void say_lens(Console& console, const std::string& device, const Camera& lens,
              const NamedCovariance& covariance) {
  std::string line = format("%-10s", device.c_str());
  const VecX values = parameters_of(lens);
  const std::vector<std::string> names = parameter_names(lens);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const double value = values[Eigen::Index(i)], sigma = covariance.sigma(device + "." + names[i]);
    console.summary().set("/" + device + "/" + names[i], value);
    console.summary().set("/" + device + "/sigma/" + names[i], sigma);
    const int digits = decimals(sigma);
    if (i < 4) line += format("  %s %.*f +- %.*f", names[i].c_str(), digits, value, digits, sigma);
  }
  console.say(line + " px");
}

void say_gates(Console& console, const std::vector<Gate>& gates) {
  int failed = 0;
  for (const Gate& gate : gates) {
    if (gate.passed) continue;
    ++failed;
    console.say("gate FAILED  " + gate.name + ": " + gate.detail);
  }
  console.say(failed == 0
                  ? format("gates      all %zu passed", gates.size())
                  : format("gates      %d of %zu failed: do not trust this rig", failed, gates.size()));
  console.summary().set("/gates/failed", failed);
  console.summary().set("/gates/total", int(gates.size()));
}

void say_predicted_light(Console& console, const Rig& rig,
                         const std::vector<analyze::LightError>& predicted) {
  for (std::size_t i = 0; i < predicted.size(); ++i) {
    const RigProjector& device = rig.projectors[i];
    console.say(format(
        "wall       at %g m the light %sis predicted to land within %.3f mm rms (worst corner %.3f mm)",
        predicted[i].distance, said_of(rig, device).c_str(), predicted[i].rms_mm, predicted[i].worst_mm));
    console.summary().set("/wall/distance_m", predicted[i].distance);
    console.summary().set(of_projector(rig, "/wall", device, "/rms_mm"), predicted[i].rms_mm);
    console.summary().set(of_projector(rig, "/wall", device, "/worst_mm"), predicted[i].worst_mm);
  }
}

void say_truth(Console& console, const Rig& rig, const Rig& truth, double wall) {
  int inside = 0, total = 0;
  const auto count = [&](double difference, const std::string& name) {
    if (!rig.covariance.index_of(name)) return;
    ++total;
    inside += std::abs(difference) <= 3 * rig.covariance.sigma(name);
  };
  const auto count_device = [&](const std::string& device, const Camera& estimated, const Camera& true_lens,
                                const Pose& pose, const Pose& true_pose) {
    const VecX difference = parameters_of(estimated) - parameters_of(true_lens);
    const std::vector<std::string> names = parameter_names(estimated);
    for (std::size_t i = 0; i < names.size(); ++i)
      count(difference[Eigen::Index(i)], device + "." + names[i]);
    const Vec6 xi = se3_log(true_pose * pose.inverse());
    const auto pose_names = pose_increment_names("rig_from_" + device);
    for (int i = 0; i < 6; ++i) count(xi[i], pose_names[std::size_t(i)]);
  };
  for (const RigCamera& camera : rig.cameras) {
    const RigCamera& known = truth.camera(rig.cameras.size() > 1 ? camera.name : "");
    count_device(camera.name, camera.camera, known.camera, camera.rig_from_camera, known.rig_from_camera);
  }
  for (const RigProjector& projector : rig.projectors) {
    const RigProjector& known = truth.projector(rig.projectors.size() > 1 ? projector.name : "");
    count_device(projector.name, projector.projector.inverse_camera, known.projector.inverse_camera,
                 projector.rig_from_projector, known.rig_from_projector);
  }
  for (const RigProjector& projector : rig.projectors) {
    const std::string name = rig.projectors.size() > 1 ? projector.name : "";
    const analyze::LightError error = analyze::true_light_error(rig, truth, wall, name);
    console.say(
        format("truth      light %son a wall at %g m is off by %.3f mm on average (rms %.3f, worst %.3f)",
               said_of(rig, projector).c_str(), wall, error.mean_mm, error.rms_mm, error.worst_mm));
    console.summary().set(of_projector(rig, "/truth", projector, "/mean_mm"), error.mean_mm);
    console.summary().set(of_projector(rig, "/truth", projector, "/rms_mm"), error.rms_mm);
    console.summary().set(of_projector(rig, "/truth", projector, "/worst_mm"), error.worst_mm);
  }
  console.say(format("truth      %d of %d parameters inside 3 sigma", inside, total));
  console.summary().set("/truth/parameters_inside_3_sigma", inside);
  console.summary().set("/truth/parameters", total);
}

}  // namespace procam::tools
