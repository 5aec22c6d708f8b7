#pragma once
/// Private to calibrate: a device's first lens and place, from views whose boards stand in the rig already.
#include <string>
#include <vector>

#include "initial.hpp"

namespace procam::calibrate {

/// One view's points of a device in the rig's frame, in the order given and turned by 180 degrees.
struct Lit {
  std::size_t view;
  Points3 as_given, turned;
  Points2 pixels;
};

struct Agreement {
  Resection resection;
  std::vector<std::size_t> views;  ///< that it holds for; indices into the lit views
};

/// Resects a device from all its views. With `settle`, each view is taken in the one of its two orders that
/// fits fits: the two views whose planes differ most are tried in all four combinations, the others join
/// one by one. `turned` marks the views that were turned. Errors as resect()'s.
Agreement resect_device(const std::vector<Lit>& lit, bool settle, const std::string& name,
                        std::vector<bool>& turned);

}  // namespace procam::calibrate
