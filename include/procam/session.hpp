#pragma once
/// Every public header of procam::session.
#include "procam/session/capture.hpp"
#include "procam/session/change.hpp"
#include "procam/session/checks.hpp"
#include "procam/session/coverage.hpp"
#include "procam/session/delay.hpp"
#include "procam/session/files.hpp"
#include "procam/session/join.hpp"
#include "procam/session/patterns.hpp"
#include "procam/session/projected_board.hpp"
#include "procam/session/reader.hpp"
#include "procam/session/recorder.hpp"
#include "procam/session/shown_views.hpp"
