#pragma once
/// Every public header of procam::render.
#include "procam/render/cpu.hpp"
#include "procam/render/gl.hpp"
#include "procam/render/renderer.hpp"
#include "procam/render/viewer.hpp"
#include "procam/render/viewpoint.hpp"
