#include "procam/core/surface/detail/surface_body.hpp"
