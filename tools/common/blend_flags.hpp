#pragma once
/// The flags of the tools that blend several projectors.
#include <CLI/CLI.hpp>
#include <functional>

#include "procam/core/rig/rig.hpp"
#include "procam/surface/blend.hpp"

namespace procam::tools {

/// "wall=cover": a name and what it is given.
using NamedTexts = std::map<std::string, std::string>;

/// Reads NAME=VALUE texts; `known` are the names there are (none: any name), `example` goes into what is said of others.
/// Throws Error(kInput).
NamedTexts named_texts(const std::string& flag, const std::vector<std::string>& items,
                       const std::vector<std::string>& known, const std::string& example);

/// The same with numbers from `least` to `most`; any names.
std::map<std::string, double> named_numbers(const std::string& flag, const std::vector<std::string>& items,
                                            double least, double most, const std::string& example);

inline constexpr double kMinBrightness = 1e-6, kMaxBrightness = 1e9, kMaxBlack = 0.5;

struct BlendFlags {
  std::vector<std::string> others;             ///< solved surfaces of the other projectors
  std::vector<std::string> brightness, black;  ///< PROJECTOR=NUMBER
  std::vector<std::string> reflectance;        ///< SURFACE=PICTURE
  double compensate = 0;                       ///< least gain; 0: not compensated
  bool one_level = false;

  bool given() const {
    return !others.empty() || compensate > 0 || !brightness.empty() || !black.empty() ||
           !reflectance.empty() || one_level;
  }
};

void declare_blend(CLI::App& app, BlendFlags& flags);

/// The options that the tools that blend have in common: brightness, black and their compensation.
struct BlendLevelFlags {
  std::function<void(const std::vector<std::string>&)> brightness, black;  ///< PROJECTOR=NUMBER
  std::function<void(double)> compensate;
  std::function<void()> one_level;
};
void declare_blend_levels(CLI::App& app, const BlendLevelFlags& flags);

/// What every projector must do, that of `solved` first; its weights are 1 where no other is given.
surface::BlendedSets blend_for(const BlendFlags& flags, const Rig& rig, const SolvedSurfaceSet& solved,
                               Diagnostics& diagnostics);

}  // namespace procam::tools
