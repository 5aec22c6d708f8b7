#include "procam/core/surface/detail/bezier_body.hpp"
#include "procam/core/surface/detail/content_layout_body.hpp"
#include "procam/core/surface/detail/surface_body.hpp"
