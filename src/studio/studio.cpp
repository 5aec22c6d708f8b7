#include "procam/studio/studio.hpp"

#include "desk.hpp"

namespace procam::studio {

void run(const StudioOptions& options, StudioListener* listener) {
  static StudioListener none;
  Desk desk(options, listener != nullptr ? *listener : none);
  desk.run();
}

}  // namespace procam::studio
