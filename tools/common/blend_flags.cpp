#include "common/blend_flags.hpp"

#include <algorithm>
#include <cmath>

#include "common/cli.hpp"
#include "procam/core/base/color.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/surface_file.hpp"

namespace procam::tools {

NamedTexts named_texts(const std::string& flag, const std::vector<std::string>& items,
                       const std::vector<std::string>& known, const std::string& example) {
  NamedTexts texts;
  for (const std::string& item : items) {
    const std::size_t equals = item.find('=');
    const std::string name = item.substr(0, equals), what = flag + " " + item;
    if (equals == std::string::npos || equals == 0 || equals + 1 == item.size())
      throw Error(ErrorKind::kInput, what, "it does not read NAME=VALUE",
                  "write e.g. " + flag + " " + example);
    if (!known.empty() && std::find(known.begin(), known.end(), name) == known.end()) {
      std::string list;
      for (const std::string& one : known) list += (list.empty() ? "" : ", ") + one;
      throw Error(ErrorKind::kInput, what, "none is named '" + name + "'", "name one of: " + list);
    }
    if (!texts.emplace(name, item.substr(equals + 1)).second)
      throw Error(ErrorKind::kInput, what, "'" + name + "' is given twice", "give each name once");
  }
  return texts;
}

void declare_blend_levels(CLI::App& app, const BlendLevelFlags& flags) {
  app.add_option_function<std::vector<std::string>>(
      "--brightness", flags.brightness,
      "Light of a projector's white (lumens, or any common unit), with --compensate [1]");
  app.add_option_function<std::vector<std::string>>(
      "--black", flags.black,
      "Ratio of a projector's black to its white: 0.001 for a contrast of 1000:1 [0]");
  app.add_option_function<double>(
         "--compensate", flags.compensate,
         "Compensate brightness for distance and angle; bright parts keep at least this share (0.05 to "
         "1) of their light, e.g. 0.3")
      ->check(within(0.05, 1));
  app.add_flag_callback("--one-level", flags.one_level,
                        "With --compensate: the same brightness on all surfaces, as for the walls of a room");
}

void declare_blend(CLI::App& app, BlendFlags& flags) {
  app.add_option("--blend-with", flags.others,
                 "Solved surfaces of another projector of the rig, once for each: blend with it where both "
                 "project");
  declare_blend_levels(
      app,
      {[&](const auto& items) { flags.brightness = items; }, [&](const auto& items) { flags.black = items; },
       [&](double share) { flags.compensate = share; }, [&] { flags.one_level = true; }});
  app.add_option("--reflectance", flags.reflectance,
                 "With --compensate: reflectance of a surface, an image (sRGB) over the area of the content");
}

std::map<std::string, double> named_numbers(const std::string& flag, const std::vector<std::string>& items,
                                            double least, double most, const std::string& example) {
  std::map<std::string, double> numbers;
  for (const auto& [name, text] : named_texts(flag, items, {}, example)) {
    double value = 0;
    std::size_t end = 0;
    try {
      value = std::stod(text, &end);
    } catch (const std::exception&) {
      end = 0;
    }
    if (end != text.size() || !(value >= least && value <= most))
      throw Error(ErrorKind::kInput, flag + " " + name + "=" + text, "it is no number that can be",
                  format("give a number from %g to %g", least, most));
    numbers[name] = value;
  }
  return numbers;
}

namespace {

double number_of(const std::map<std::string, double>& numbers, const std::string& name, double usual) {
  const auto found = numbers.find(name);
  return found == numbers.end() ? usual : found->second;
}

ImageF light_of(const ImageU8& picture) {
  const ImageU8 grey = io::to_gray(picture);
  ImageF light(grey.size());
  for (int y = 0; y < grey.height(); ++y)
    for (int x = 0; x < grey.width(); ++x) light.at(x, y) = float(light_from_srgb(grey.at(x, y) / 255.0));
  return light;
}

}  // namespace

surface::BlendedSets blend_for(const BlendFlags& flags, const Rig& rig, const SolvedSurfaceSet& solved,
                               Diagnostics& diagnostics) {
  if (!flags.compensate && (!flags.brightness.empty() || flags.one_level || !flags.reflectance.empty()))
    throw Error(ErrorKind::kInput, "--brightness, --one-level, --reflectance",
                "they say nothing without --compensate", "add --compensate 0.3");
  surface::BlendedSets blending;
  std::vector<SolvedSurfaceSet>& sets = blending.sets;
  sets.push_back(solved);
  for (const std::string& file : flags.others) sets.push_back(io::load_solved_surfaces(file));
  std::vector<std::string> projectors, surfaces;
  for (const SolvedSurfaceSet& set : sets) {
    if (std::find(projectors.begin(), projectors.end(), set.projector) != projectors.end())
      throw Error(ErrorKind::kInput, "--blend-with",
                  "two of the files are solved for '" + set.projector + "'",
                  "give one a projector; solve-surfaces --projector names it");
    projectors.push_back(set.projector);
    for (const SolvedSurface& surface : set.surfaces) surfaces.push_back(surface.surface.name);
  }
  for (const auto& [flag, items] :
       {std::pair("--brightness", &flags.brightness), std::pair("--black", &flags.black)})
    named_texts(flag, *items, projectors, "left=0.001");
  const auto brightness = named_numbers("--brightness", flags.brightness, kMinBrightness, kMaxBrightness, ""),
             black = named_numbers("--black", flags.black, 0, kMaxBlack, "");
  const NamedTexts reflectance =
      named_texts("--reflectance", flags.reflectance, surfaces, "wall=wall_lit.png");
  std::vector<surface::BlendInput> lit;
  for (const SolvedSurfaceSet& set : sets) {
    blending.brightness.push_back(number_of(brightness, set.projector, 1));
    blending.black.push_back(number_of(black, set.projector, 0));
    lit.push_back(
        {rig.projector(set.projector).projector, &set, blending.brightness.back(), blending.black.back()});
  }
  surface::BlendOptions options;
  options.compensate = flags.compensate > 0;
  if (options.compensate) options.min_gain = flags.compensate;
  options.one_level = flags.one_level;
  std::map<std::string, ImageF> pictures;
  for (const auto& [name, file] : reflectance) {
    pictures[name] = light_of(io::load_image(file).image);
    options.reflectance[name] = pictures[name];
  }
  surface::Blend blend = surface::blend_maps(lit, options);
  diagnostics.append(blend.diagnostics);
  blending.maps = std::move(blend.maps);
  return blending;
}

}  // namespace procam::tools
