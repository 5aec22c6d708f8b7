#pragma once
/// People before the projector, as project-live's command line tells of them.
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/cli.hpp"
#include "procam/core/rig/rig.hpp"
#include "procam/show/projection.hpp"

namespace procam::tools {

struct PeopleFlags {
  std::string source, sensor;
  std::vector<std::string> to;  ///< SURFACE=udp:HOST:PORT
  double delay = 0;
};
void declare(CLI::App& app, PeopleFlags& flags);

/// Skeletons from a socket: heads kept dark, contents told. Used by one thread.
class ShowPeople {
 public:
  /// Throws Error for a source, a sensor's place or a destination that makes no sense.
  ShowPeople(const PeopleFlags& flags, const Rig& rig, const RigProjector& projector,
             std::function<void(const std::string&)> say);
  ~ShowPeople();

  /// Takes what has arrived and tells the contents.
  void take(const show::Projection& projection);
  /// The same, and blackens heads: ProjectionOptions::over.
  void over(const show::Projection& projection, double light_time, ImageView<std::uint8_t> frame);
  void tell(Console& console) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace procam::tools
