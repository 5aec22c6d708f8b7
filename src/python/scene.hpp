#pragma once
/// A scene whose pictures are numpy arrays: procam.Scene and procam.SceneItem. The arrays live as long as the items.
#include "bind.hpp"
#include "procam/core/surface/scene.hpp"

namespace procam::python {

struct HeldItem {
  Placement placement;
  py::object content = py::none();  ///< uint8 array, (h, w) or (h, w, c), each row without gaps
  std::uint64_t content_revision = 0;
  py::object mask = py::none();
  std::uint64_t mask_revision = 0;
};

struct HeldScene {
  py::list items;  ///< of HeldItem
  std::array<std::uint8_t, 3> background{};
};

/// As procam::render takes it. Its arrays are kept until the current call returns.
Scene scene_of(const HeldScene& held);

/// The arrays of `from` on the items of a scene that was made of its items, in their order.
HeldScene held_scene(const Scene& scene, const HeldScene& from);

}  // namespace procam::python
