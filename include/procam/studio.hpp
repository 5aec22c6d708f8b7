#pragma once
/// Every public header of procam::studio.
#include "procam/studio/studio.hpp"
