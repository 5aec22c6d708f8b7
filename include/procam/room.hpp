#pragma once
/// Every public header of procam::room.
#include "procam/room/calibrate_room.hpp"
#include "procam/room/deviations.hpp"
#include "procam/room/points.hpp"
