#pragma once
/// Every public header of procam::dds.
#include "procam/dds/fleet.hpp"
#include "procam/dds/group.hpp"
#include "procam/dds/image_source.hpp"
#include "procam/dds/pose_source.hpp"
#include "procam/dds/projector_publisher.hpp"
#include "procam/dds/security.hpp"
