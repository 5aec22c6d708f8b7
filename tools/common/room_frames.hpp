#pragma once
#include "procam/core/rig/room_frames.hpp"
