#pragma once
/// Every public header of procam::surface.
#include "procam/surface/blend.hpp"
#include "procam/surface/lay_out.hpp"
#include "procam/surface/solve.hpp"
#include "procam/surface/warp.hpp"
