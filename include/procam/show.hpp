#pragma once
/// Every public header of procam::show.
#include "procam/show/frame_files.hpp"
#include "procam/show/metrics.hpp"
#include "procam/show/page_server.hpp"
#include "procam/show/projection.hpp"
#include "procam/show/run.hpp"
#include "procam/show/show_options.hpp"
