/// align-maps: surfaces and markers of two maps -> alignment.json, map_a_from_map_b with its covariance.
#include <CLI/CLI.hpp>
#include <filesystem>

#include "common/cli.hpp"
#include "common/pose_lines.hpp"
#include "procam/io/files.hpp"
#include "procam/io/marker_map_file.hpp"
#include "procam/io/pose_file.hpp"
#include "procam/io/surface_file.hpp"
#include "procam/io/text.hpp"
#include "procam/track/align_maps.hpp"

namespace procam::tools {
namespace {

struct Flags {
  std::vector<std::string> into, map;
  std::string output, moved;
  track::PlacedSigma surface_sigma{0.005, 0.3 * kDegree}, marker_sigma{0.002, 0.3 * kDegree};
  track::AlignMapsOptions options;
};

void add_sigma(CLI::App& app, const std::string& flag, track::PlacedSigma& sigma, const std::string& help) {
  add_parsed(
      app, flag,
      [&sigma](const std::string& text) {
        const io::LengthAndAngle stated = io::parse_length_and_angle(text);
        if (!(stated.length > 0 && stated.angle > 0))
          throw Error(ErrorKind::kInput, "'" + text + "'", "both sigmas must be positive",
                      "give e.g. 5mm,0.3deg");
        sigma = {stated.length, stated.angle};
      },
      help);
}

void declare(CLI::App& app, Flags& flags) {
  app.add_option("--into", flags.into, "Map A: surfaces (.json, .xml), markers.json, or both")->required();
  app.add_option("--map", flags.map, "Map B, likewise")->required();
  app.add_flag("--by-geometry", flags.options.planes_by_geometry,
               "Match surfaces by where they are, because their names differ; markers are matched by id");
  add_sigma(
      app, "--surface-sigma", flags.surface_sigma,
      "How well both maps know a surface: standard deviations of its distance and of its tilt (5mm,0.3deg)");
  add_sigma(app, "--marker-sigma", flags.marker_sigma,
            "The same of a marker, where its file states none (2mm,0.3deg)");
  app.add_option("-o,--output", flags.output,
                 "Pose file to write: frame of map B in map A, with its covariance")
      ->required();
  app.add_option("--write-moved", flags.moved, "Also write the surfaces of map B, in the frame of map A");
}

struct Map {
  std::vector<track::MapElement> elements;
  SurfaceSet surfaces;
};

Map load(const std::vector<std::string>& files, const Flags& flags) {
  Map map;
  const auto add = [&](const std::vector<track::MapElement>& more) {
    map.elements.insert(map.elements.end(), more.begin(), more.end());
  };
  for (const std::string& file : files) {
    const bool markers = std::filesystem::path(file).extension() == ".json" &&
                         io::read_file(file).find("\"procam-markers\"") != std::string::npos;
    if (markers) {
      add(track::elements_of(io::load_marker_map(file), flags.marker_sigma));
      continue;
    }
    const SurfaceSet surfaces = io::load_surfaces(file);
    add(track::elements_of(surfaces, flags.surface_sigma));
    map.surfaces.surfaces.insert(map.surfaces.surfaces.end(), surfaces.surfaces.begin(),
                                 surfaces.surfaces.end());
  }
  if (map.elements.empty())
    throw Error(ErrorKind::kNotEnoughData, files.front(),
                "it has no marker and no planar surface in the world",
                "align by surfaces of kind \"planar\" in frame \"world\", or by markers");
  return map;
}

void say_pairs(Console& console, const track::AlignMapsResult& joined) {
  for (std::size_t i = 0; i < joined.pairs.size(); ++i) {
    const track::AlignedPair& pair = joined.pairs[i];
    const std::string name =
        pair.name_in_a == pair.name_in_b ? pair.name_in_a : pair.name_in_a + " = " + pair.name_in_b;
    console.say(format("%-28s %8.1f mm %7.2f deg  chi2 %6.1f%s", name.c_str(), pair.distance * 1e3,
                       pair.angle / kDegree, pair.chi2, pair.used ? "" : "  REJECTED"));
    const std::string at = "/pairs/" + std::to_string(i);
    console.summary().set(at + "/in_a", pair.name_in_a);
    console.summary().set(at + "/in_b", pair.name_in_b);
    console.summary().set(at + "/used", pair.used);
    console.summary().set(at + "/distance_mm", pair.distance * 1e3);
    console.summary().set(at + "/angle_deg", pair.angle / kDegree);
    console.summary().set(at + "/chi2", pair.chi2);
  }
  if (!joined.only_in_a.empty()) console.say("only in map A: " + comma_list(joined.only_in_a));
  if (!joined.only_in_b.empty()) console.say("only in map B: " + comma_list(joined.only_in_b));
}

ExitCode align(const Flags& flags, Console& console) {
  for (const std::string& file : {flags.output, flags.moved})
    if (!file.empty()) io::require_writable(file);
  const Map a = load(flags.into, flags), b = load(flags.map, flags);
  const track::AlignMapsResult joined = track::align_maps(a.elements, b.elements, flags.options);
  const FrameTree::Link link{"map_a", "map_b", joined.map_a_from_map_b};
  io::save_pose(flags.output, link);
  if (!flags.moved.empty())
    io::save_surfaces(flags.moved, track::moved(b.surfaces, joined.map_a_from_map_b.pose));
  say_pairs(console, joined);
  say_link(console, link, "/pose");
  console.summary().set("/chi2", joined.chi2);
  console.summary().set("/degrees_of_freedom", joined.degrees_of_freedom);
  console.report(joined.diagnostics);
  console.say("wrote " + flags.output + (flags.moved.empty() ? "" : ", " + flags.moved));
  return exit_code(joined.diagnostics);
}

}  // namespace
}  // namespace procam::tools

int main(int argc, char** argv) {
  using namespace procam::tools;
  Flags flags;
  return run_tool(
      argc, argv,
      {"align-maps",
       "Joins two maps of one place by the surfaces and markers that both hold, with covariance."},
      [&](CLI::App& app) { declare(app, flags); }, [&](Console& console) { return align(flags, console); });
}
