#pragma once
/// Every public header of procam::report.
#include "procam/report/calibration.hpp"
#include "procam/report/draws_file.hpp"
#include "procam/report/files.hpp"
#include "procam/report/mount.hpp"
#include "procam/report/plan.hpp"
#include "procam/report/prediction.hpp"
#include "procam/report/room.hpp"
#include "procam/report/room_calibration.hpp"
#include "procam/report/scan.hpp"
#include "procam/report/stations.hpp"
#include "procam/report/verify.hpp"
