#pragma once
/// Every public header of procam::scan.
#include "procam/scan/merge.hpp"
#include "procam/scan/scan.hpp"
#include "procam/scan/scan_error.hpp"
#include "procam/scan/scan_mesh.hpp"
#include "procam/scan/stations.hpp"
#include "procam/scan/viewer_error.hpp"
