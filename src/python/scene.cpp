#include "scene.hpp"

namespace procam::python {

namespace {

ViewU8 picture(const py::object& array, const char* name) {
  return array.is_none() ? ViewU8() : Loader<ViewU8>::from(array, {"SceneItem", name});
}

}  // namespace

Scene scene_of(const HeldScene& held) {
  Scene scene;
  std::copy(held.background.begin(), held.background.end(), scene.background);
  // Another thread may change the list during the call.
  const py::tuple items(held.items);
  for (py::handle one : items) {
    if (!py::isinstance<HeldItem>(one)) refuse_type({"Scene", "items"}, "procam.SceneItem", one);
    const auto& item = one.cast<const HeldItem&>();
    scene.items.push_back({item.placement, picture(item.content, "content"), item.content_revision,
                           picture(item.mask, "mask"), item.mask_revision});
  }
  return scene;
}

HeldScene held_scene(const Scene& scene, const HeldScene& from) {
  HeldScene held;
  held.background = from.background;
  std::size_t next = 0;
  for (const SceneItem& item : scene.items) {
    for (; next < from.items.size(); ++next) {
      const auto& source = from.items[next].cast<const HeldItem&>();
      if (picture(source.content, "content").data != item.content.data) continue;
      held.items.append(
          HeldItem{item.placement, source.content, item.content_revision, source.mask, item.mask_revision});
      ++next;
      break;
    }
  }
  return held;
}

}  // namespace procam::python
