#pragma once
/// A folder with the lamp's rig and its surfaces, as project-live gets them.
#include <gtest/gtest.h>

#include <string>

#include "lamp_rig.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/surface_file.hpp"
#include "tool_runner.hpp"

namespace procam::test {

class LampShow : public testing::Test {
 protected:
  LampShow() { io::save_rig(at("rig.json"), lamp_rig()); }

  std::string at(const std::string& name) const { return (folder_ / name).string(); }
  void save(const std::string& name, const SurfaceSet& set) const { io::save_surfaces(at(name), set); }
  std::string show(const std::string& surfaces = "surfaces.json") const {
    return "--rig " + at("rig.json") + " --surfaces " + at(surfaces) + " ";
  }

  ScratchFolder folder_;
};

}  // namespace procam::test
