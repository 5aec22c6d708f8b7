#include "procam/core/lens/detail/camera_body.hpp"
#include "procam/core/lens/detail/distortion_body.hpp"
#include "procam/core/lens/distortion/detail/brown_conrady_body.hpp"
#include "procam/core/lens/distortion/detail/rational_body.hpp"
