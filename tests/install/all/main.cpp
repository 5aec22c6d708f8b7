// Everything is linked by one name.
#include "procam/session/patterns.hpp"
#include "procam/show/show_options.hpp"

int main() {
  return procam::show::is_depth_source("depth:watch:frames") && !procam::show::is_depth_source("wall.json") &&
                 !procam::session::pattern_help().empty()
             ? 0
             : 1;
}
