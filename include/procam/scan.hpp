#pragma once
/// Every public header of procam::scan.
#include "procam/scan/scan.hpp"
#include "procam/scan/scan_error.hpp"
#include "procam/scan/scan_mesh.hpp"
