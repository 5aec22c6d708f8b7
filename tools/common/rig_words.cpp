#include "common/rig_words.hpp"

#include <algorithm>
#include <cmath>

#include "common/note_groups.hpp"
#include "procam/core/geometry/se3.hpp"

namespace procam::tools {

std::string of_projector(const Rig& rig, const std::string& group, const RigProjector& projector,
                         const std::string& figure) {
  return group + (rig.projectors.size() > 1 ? "/" + projector.name : "") + figure;
}

std::string said_of(const Rig& rig, const RigProjector& projector) {
  return rig.projectors.size() > 1 ? projector.name + ": " : "";
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

void say_remarks(Console& console, const Diagnostics& diagnostics) {
  Diagnostics rest;
  for (const Diagnostic& item : diagnostics.items)
    if (item.code != "gate_failed") rest.items.push_back(item);
  for (const std::string& line : lines_for_people(rest)) console.log(line);
  console.summary().add(diagnostics);
}

void say_gates(Console& console, const std::vector<Gate>& gates) {
  int failed = 0;
  for (const Gate& gate : gates) {
    if (gate.passed) continue;
    ++failed;
    console.say("check FAILED " + gate.name + ": " + gate.detail);
  }
  console.say(failed == 0 ? format("checks     all %zu quality checks passed", gates.size())
                          : format("checks     %d of %zu quality checks failed", failed, gates.size()));
  console.summary().set("/gates/failed", failed);
  console.summary().set("/gates/total", int(gates.size()));
}

void say_result(Console& console, const Rig& rig, const RigQuality& quality,
                const std::vector<analyze::LightErrors>& predicted, const analyze::AcceptedError& accepted,
                bool next_view) {
  const bool imprecise = analyze::only_predicted_error_failed(quality);
  const char* const verdict = quality.passed() ? "passed" : imprecise ? "usable, but" : "do not use";
  console.summary().set("/result", quality.passed() ? "passed" : imprecise ? "imprecise" : "failed");
  if (predicted.empty()) {
    console.say(format("result     %s; the rig states no uncertainty, so no error is predicted", verdict));
    return;
  }
  for (std::size_t i = 0; i < predicted.size(); ++i) {
    const RigProjector& device = rig.projectors[i];
    const analyze::LightErrors& errors = predicted[i];
    const analyze::LightError& selected = errors.of(accepted.located);
    std::string line = i == 0 ? format("result     %s%s ", verdict, imprecise ? "" : ":") : "           ";
    line += said_of(rig, device) + "predicted error " + analyze::in_words(selected) +
            format(" (accepted: %g mm)", accepted.rms_mm);
    if (i + 1 == predicted.size() && imprecise) line += next_view ? ": add the view below" : ": add views";
    console.say(line);
    const analyze::LightError* other = &errors.externally;
    if (selected.located == analyze::SurfaceLocated::kExternally)
      other = errors.by_camera ? &*errors.by_camera : nullptr;
    if (other != nullptr) console.say("           " + analyze::in_words(*other));
    if (!errors.by_camera && !rig.cameras.empty())
      console.say("           no camera of the rig sees the frame there, so none can locate the surface");
    Summary& summary = console.summary();
    const auto field = [&](const char* name) { return of_projector(rig, "/wall", device, name); };
    summary.set("/wall/distance_m", selected.distance);
    summary.set("/wall/accepted_mm", accepted.rms_mm);
    summary.set("/wall/surface_located", analyze::to_string(accepted.located));
    summary.set(field("/rms_mm"), errors.externally.rms_mm);
    summary.set(field("/worst_mm"), errors.externally.worst_mm);
    if (!errors.by_camera) continue;
    summary.set(field("/by_camera/rms_mm"), errors.by_camera->rms_mm);
    summary.set(field("/by_camera/worst_mm"), errors.by_camera->worst_mm);
    summary.set(field("/by_camera/camera"), errors.by_camera->camera);
    summary.set(field("/by_camera/share"), errors.by_camera->share);
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
    const analyze::LightErrors errors = analyze::true_light_errors(rig, truth, wall, name);
    const auto say = [&](const analyze::LightError& error, const std::string& group) {
      console.say(format("truth      %serror %s (mean %s, max %s mm)", said_of(rig, projector).c_str(),
                         analyze::in_words(error).c_str(), two_digits(error.mean_mm).c_str(),
                         two_digits(error.worst_mm).c_str()));
      console.summary().set(of_projector(rig, "/truth", projector, group + "/mean_mm"), error.mean_mm);
      console.summary().set(of_projector(rig, "/truth", projector, group + "/rms_mm"), error.rms_mm);
      console.summary().set(of_projector(rig, "/truth", projector, group + "/worst_mm"), error.worst_mm);
    };
    say(errors.externally, "");
    if (errors.by_camera) say(*errors.by_camera, "/by_camera");
  }
  console.say(format("truth      %d of %d parameters inside 3 sigma", inside, total));
  console.summary().set("/truth/parameters_inside_3_sigma", inside);
  console.summary().set("/truth/parameters", total);
}

}  // namespace procam::tools
