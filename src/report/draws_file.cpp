#include "procam/report/draws_file.hpp"

#include <cmath>
#include <stdexcept>

#include "fields.hpp"
#include "procam/io/files.hpp"

namespace procam::report {
namespace {

using Spreads = std::vector<std::optional<analyze::LandingSpread>>;

constexpr const char* kDrawAgain = "draw all parts with the same inputs, and give each once";

/// The head of a part, and its surfaces' draws.
struct Part {
  std::string file;
  std::uint64_t seed = 0;
  int draws = 0, shard = 0, shards = 0;
  std::vector<Spreads> surfaces;
};

Json numbers_of(const analyze::LandingSpread& s) {
  return Json::array({s.draws, s.missed, s.mean.x(), s.mean.y(), s.covariance(0, 0), s.covariance(0, 1),
                      s.covariance(1, 1), s.worst});
}

analyze::LandingSpread spread_of(const Json& numbers) {
  analyze::LandingSpread s;
  s.draws = numbers.at(0).get<int>();
  s.missed = numbers.at(1).get<int>();
  s.mean = Vec2(numbers.at(2).get<double>(), numbers.at(3).get<double>());
  s.covariance << numbers.at(4).get<double>(), numbers.at(5).get<double>(), numbers.at(5).get<double>(),
      numbers.at(6).get<double>();
  s.worst = numbers.at(7).get<double>();
  if (s.draws < 0 || s.missed < 0 || s.missed > s.draws) throw std::invalid_argument("counts");
  return s;
}

[[noreturn]] void refuse(const std::string& file, const std::string& why) {
  throw Error(ErrorKind::kInput, file, why, kDrawAgain);
}

/// The draws of one surface; of other inputs than the prediction's they are refused.
Spreads surface_of(const Json& json, const analyze::SurfacePrediction& prediction, const std::string& file) {
  if (json.at("name").get<std::string>() != prediction.surface ||
      json.at("points").size() != prediction.grid.size() ||
      !(std::abs(json.at("rms_mm").get<double>() - prediction.rms_mm) <= 1e-9 * prediction.rms_mm))
    refuse(file, "its surface '" + json.at("name").get<std::string>() +
                     "' was predicted from another rig, pose, surface or uncertainty");
  Spreads spreads;
  for (const Json& point : json.at("points"))
    spreads.push_back(point.is_null() ? std::nullopt : std::optional(spread_of(point)));
  return spreads;
}

Part load_part(const std::filesystem::path& path, const std::vector<analyze::SurfacePrediction>& surfaces) {
  Part part;
  part.file = path.string();
  const std::string text = io::read_file(path);
  try {
    const Json json = Json::parse(text);
    if (json.at("format") != "procam-draws" || json.at("version") != 1)
      refuse(part.file, "it is not a file of predict-error --save-draws");
    part.seed = json.at("seed").get<std::uint64_t>();
    part.draws = json.at("draws").get<int>();
    part.shard = json.at("shard").get<int>();
    part.shards = json.at("shards").get<int>();
    if (json.at("surfaces").size() != surfaces.size()) refuse(part.file, "it has another number of surfaces");
    for (std::size_t i = 0; i < surfaces.size(); ++i)
      part.surfaces.push_back(surface_of(json.at("surfaces")[i], surfaces[i], part.file));
  } catch (const Error&) {
    throw;
  } catch (const std::exception& damaged) {  // of the JSON library, or of a number out of its range
    refuse(part.file,
           std::string("it is damaged or not a file of predict-error --save-draws: ") + damaged.what());
  }
  return part;
}

/// Parts of one run, each once.
void check_parts(const std::vector<Part>& parts) {
  const Part& first = parts.front();
  if (first.shards != int(parts.size()))
    refuse(first.file, "it is one of " + std::to_string(first.shards) + " parts, and " +
                           std::to_string(parts.size()) + (parts.size() == 1 ? " is given" : " are given"));
  std::vector<std::string> given(parts.size());
  for (const Part& part : parts) {
    if (part.seed != first.seed || part.draws != first.draws || part.shards != first.shards)
      refuse(part.file, "its seed, number of draws or number of parts is not that of " + first.file);
    if (part.shard < 1 || part.shard > part.shards)
      refuse(part.file, "its part is not one of 1 to " + std::to_string(part.shards));
    std::string& same = given[std::size_t(part.shard - 1)];
    if (!same.empty()) refuse(part.file, "it is the same part as " + same);
    same = part.file;
  }
}

}  // namespace

std::string draws_to_json(const std::vector<analyze::SurfacePrediction>& surfaces,
                          const analyze::MonteCarloOptions& options) {
  Json json = {{"format", "procam-draws"},   {"version", 1},
               {"seed", options.seed},       {"draws", options.draws},
               {"shard", options.shard + 1}, {"shards", options.shards}};
  json["surfaces"] = Json::array();
  for (const analyze::SurfacePrediction& surface : surfaces) {
    Json points = Json::array();
    for (const auto& spread : surface.drawn) points.push_back(spread ? numbers_of(*spread) : Json());
    json["surfaces"].push_back({{"name", surface.surface}, {"rms_mm", surface.rms_mm}, {"points", points}});
  }
  return json.dump() + "\n";
}

void merge_draws(const std::vector<std::filesystem::path>& files,
                 std::vector<analyze::SurfacePrediction>& surfaces) {
  require(!files.empty(), "merge_draws: no file");
  std::vector<Part> parts;
  for (const std::filesystem::path& file : files) parts.push_back(load_part(file, surfaces));
  check_parts(parts);
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    std::vector<Spreads> of_surface;
    for (const Part& part : parts) of_surface.push_back(part.surfaces[i]);
    analyze::merge_draws(of_surface, surfaces[i]);
  }
}

}  // namespace procam::report
