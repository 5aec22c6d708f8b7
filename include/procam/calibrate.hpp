#pragma once
/// Every public header of procam::calibrate.
#include "procam/calibrate/bundle.hpp"
#include "procam/calibrate/calibrate.hpp"
#include "procam/calibrate/gates.hpp"
#include "procam/calibrate/lens_model.hpp"
#include "procam/calibrate/lens_prior.hpp"
#include "procam/calibrate/mirror.hpp"
#include "procam/calibrate/mount.hpp"
#include "procam/calibrate/next_view.hpp"
#include "procam/calibrate/options.hpp"
#include "procam/calibrate/points.hpp"
#include "procam/calibrate/result.hpp"
#include "procam/calibrate/update.hpp"
