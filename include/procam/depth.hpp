#pragma once
/// Every public header of procam::depth.
#include "procam/depth/areas.hpp"
#include "procam/depth/depth_image.hpp"
#include "procam/depth/height_field.hpp"
#include "procam/depth/height_picture.hpp"
#include "procam/depth/main_planes.hpp"
#include "procam/depth/plane_map.hpp"
#include "procam/depth/planes.hpp"
#include "procam/depth/ray_table.hpp"
#include "procam/depth/room_depth.hpp"
#include "procam/depth/sensor_check.hpp"
#include "procam/depth/surfaces.hpp"
