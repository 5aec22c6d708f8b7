#pragma once
/// Every public header of procam::track.
#include "procam/track/align_maps.hpp"
#include "procam/track/byte_source.hpp"
#include "procam/track/clock.hpp"
#include "procam/track/locate.hpp"
#include "procam/track/pose_log.hpp"
#include "procam/track/pose_sender.hpp"
#include "procam/track/pose_source.hpp"
#include "procam/track/pose_track.hpp"
#include "procam/track/sight_surface.hpp"
#include "procam/track/stamped_pose.hpp"
#include "procam/track/trajectory_file.hpp"
#include "procam/track/wire.hpp"
