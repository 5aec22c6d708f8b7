#pragma once
/// Every public header of procam::device.
#include "procam/device/content_source.hpp"
#include "procam/device/depth_source.hpp"
#include "procam/device/frame_sink.hpp"
#include "procam/device/frame_source.hpp"
#include "procam/device/shared_frame.hpp"
#include "procam/device/video_file.hpp"
