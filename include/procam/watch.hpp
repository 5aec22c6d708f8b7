#pragma once
/// Every public header of procam::watch.
#include "procam/watch/cell_shifts.hpp"
#include "procam/watch/correction.hpp"
#include "procam/watch/light_geometry.hpp"
#include "procam/watch/marks.hpp"
#include "procam/watch/movement.hpp"
#include "procam/watch/watch.hpp"
