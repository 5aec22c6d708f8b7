#include "procam/io/rig_file.hpp"

#include <set>

#include "document/shared_fields.hpp"

namespace procam::io {

static void fields(Fields& f, Intrinsics& k) {
  f.field("fx", k.fx);
  f.field("fy", k.fy);
  f.field("cx", k.cx);
  f.field("cy", k.cy);
  f.field("skew", k.skew);
  for (const auto& [name, focal] : {std::pair("fx", k.fx), std::pair("fy", k.fy)})
    f.check(focal > 0, name, "the focal length is not positive", "give it in pixels");
}

template <std::size_t... Index>
static std::vector<std::string> model_names(std::index_sequence<Index...>) {
  return {std::variant_alternative_t<Index, Distortion>::kName...};
}

static void fields(Fields& f, Distortion& distortion) {
  const auto names = model_names(std::make_index_sequence<std::variant_size_v<Distortion>>());
  const std::size_t model = f.choice("model", names, distortion.index());
  if (f.reading()) distortion = distortion_named(names[model]);
  std::vector<double> coefficients = coefficients_of(distortion);
  const std::vector<std::string> coefficient = coefficient_names(distortion);
  for (std::size_t i = 0; i < coefficients.size(); ++i) f.field(coefficient[i].c_str(), coefficients[i]);
  distortion = with_coefficients(distortion, coefficients);
}

/// What cameras and projectors have in common; `pose_name` is rig_from_camera or rig_from_projector.
static void device_fields(Fields& f, std::string& name, Camera& camera, const char* pose_name,
                          Pose& rig_from_device) {
  f.field("name", name);
  f.check(!name.empty(), "name", "it is empty", "give every device a name");
  f.field("size", camera.size);
  f.field("intrinsics", camera.intrinsics);
  f.field("distortion", camera.distortion);
  f.field(pose_name, rig_from_device);
}

static void fields(Fields& f, RigCamera& camera) {
  device_fields(f, camera.name, camera.camera, "rig_from_camera", camera.rig_from_camera);
}

static void fields(Fields& f, RigProjector& projector) {
  device_fields(f, projector.name, projector.projector.inverse_camera, "rig_from_projector",
                projector.rig_from_projector);
}

static void fields(Fields& f, NamedCovariance& covariance) {
  f.field("names", covariance.names);
  f.field("matrix", covariance.matrix);
  const auto count = Eigen::Index(covariance.names.size());
  f.check(covariance.matrix.rows() == count && covariance.matrix.cols() == count, "matrix",
          "it is " + std::to_string(covariance.matrix.rows()) + "x" +
              std::to_string(covariance.matrix.cols()) + " for " + std::to_string(count) + " names",
          "give one row and one column a name");
  check_covariance(f, "matrix", covariance.matrix);
}

static void fields(Fields& f, Gate& gate) {
  f.field("name", gate.name);
  f.field("passed", gate.passed);
  f.field("detail", gate.detail);
}

static void fields(Fields& f, RigQuality& quality) {
  f.field("views_used", quality.views_used);
  f.map("rms_px", quality.rms_px);
  f.map("holdout_px", quality.holdout_px);
  const bool expected = f.reading() ? f.has("expected_holdout_px") : !quality.expected_holdout_px.empty();
  if (expected) f.map("expected_holdout_px", quality.expected_holdout_px);
  f.list("gates", "gate", quality.gates);
}

static void fields(Fields& f, InputFile& input) {
  f.field("path", input.path);
  f.field("sha256", input.sha256);
}

static void fields(Fields& f, Provenance& provenance) {
  f.field("tool", provenance.tool);
  f.field("version", provenance.version);
  f.field("created", provenance.created);
  f.map("options", provenance.options);
  f.list("inputs", "input", provenance.inputs);
}

/// Adds what the rig's covariance may name for one device.
static void add_parameter_names(const std::string& device, const Camera& camera,
                                std::set<std::string>& known) {
  for (const std::string& parameter : parameter_names(camera)) known.insert(device + "." + parameter);
  for (const std::string& increment : pose_increment_names("rig_from_" + device)) known.insert(increment);
}

static void fields(Fields& f, Rig& rig) {
  header(f, "procam-rig", 1);
  f.list("cameras", "camera", rig.cameras);
  f.list("projectors", "projector", rig.projectors);
  f.optional("covariance", rig.covariance);
  f.field("quality", rig.quality);
  f.field("provenance", rig.provenance);

  std::set<std::string> names, known;
  const auto add = [&](const char* list, const std::string& name, const Camera& camera) {
    f.check(names.insert(name).second, list, "two devices are named '" + name + "'",
            "give every device of the rig a name of its own");
    add_parameter_names(name, camera, known);
  };
  for (const RigCamera& camera : rig.cameras) add("cameras", camera.name, camera.camera);
  for (const RigProjector& projector : rig.projectors)
    add("projectors", projector.name, projector.projector.inverse_camera);
  std::set<std::string> seen;
  for (const std::string& name : rig.covariance.names) {
    f.check(known.count(name) == 1, "covariance", "the rig has no parameter '" + name + "'",
            suggest(name, {known.begin(), known.end()}));
    f.check(seen.insert(name).second, "covariance", "'" + name + "' is named twice", "name every row once");
  }
}

Rig load_rig(const std::filesystem::path& path) {
  return load_noun<Rig>(path, Syntax::kJson);
}

void save_rig(const std::filesystem::path& path, const Rig& rig) {
  save_noun(path, Syntax::kJson, rig);
}

}  // namespace procam::io
