#pragma once
/// Surfaces found in a depth image for people: as JSON, as lines, as a picture.
#include <string>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/base/image.hpp"
#include "procam/depth/sensor_check.hpp"
#include "procam/depth/surfaces.hpp"

namespace procam::report {

/// "surfaces", "planes" (every plane, also one without a surface) and "sensor"; metres.
PROCAM_EXPORT std::string to_json(const depth::Planes& planes, const depth::RoomSurfaces& room,
                                  const depth::SensorKind& sensor, const depth::SensorCheck& check);

/// A table of the surfaces, then of the planes without one.
PROCAM_EXPORT std::vector<std::string> lines(const depth::Planes& planes, const depth::RoomSurfaces& room);

/// The depth image shaded by its slopes, every surface in its colour with outline, free rectangle, name and
/// size, corners of the room, and a legend at the right. RGB.
PROCAM_EXPORT ImageU8 room_picture(const depth::Planes& planes, const depth::RoomSurfaces& room,
                                   const depth::DepthImage& image, const depth::RayTable& rays);

}  // namespace procam::report
