#pragma once
#ifdef __linux__
#include <sys/resource.h>
#endif

namespace procam::show {

/// Where cores are few, work in the background takes longer rather than frames of the show. Of this thread and those that it
/// starts; a refusal costs frames and no more.
inline void let_the_show_go_first() {
#ifdef __linux__
  constexpr int kNicer = 5;  // a third of the share that a thread of the show has
  setpriority(PRIO_PROCESS, 0, kNicer);
#endif
}

}  // namespace procam::show
