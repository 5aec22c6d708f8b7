#pragma once
/// Every public header of procam::show.
#include "procam/show/control_page.hpp"
#include "procam/show/editor.hpp"
#include "procam/show/loop.hpp"
#include "procam/show/marker_source.hpp"
#include "procam/show/metrics.hpp"
#include "procam/show/overlay.hpp"
#include "procam/show/projection.hpp"
#include "procam/show/room_people.hpp"
#include "procam/show/room_watch.hpp"
#include "procam/show/run_log.hpp"
#include "procam/show/show_loader.hpp"
