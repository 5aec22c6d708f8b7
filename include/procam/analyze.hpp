#pragma once
/// Every public header of procam::analyze.
#include "procam/analyze/accept.hpp"
#include "procam/analyze/advice.hpp"
#include "procam/analyze/error_sources.hpp"
#include "procam/analyze/landing_error.hpp"
#include "procam/analyze/light_error.hpp"
#include "procam/analyze/monte_carlo.hpp"
#include "procam/analyze/planner.hpp"
#include "procam/analyze/prediction.hpp"
#include "procam/analyze/verify.hpp"
