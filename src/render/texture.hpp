#pragma once
/// Content ready to be sampled. Its memory is kept from one picture to the next of the same size.
#include <vector>

#include "kernels.hpp"
#include "light.hpp"
#include "procam/core/base/export.hpp"
#include "procam/core/base/image.hpp"
#include "workers.hpp"

namespace procam::render {

template <typename Pixel>
struct Texels {
  int width = 0, height = 0;
  std::vector<Pixel> data;

  void resize(int w, int h) {
    width = w;
    height = h;
    data.resize(std::size_t(w + 1) * std::size_t(h + 1) * 4);
  }
  Pixel* row(int y) { return data.data() + std::ptrdiff_t(y) * (width + 1) * 4; }
  const Pixel* row(int y) const { return data.data() + std::ptrdiff_t(y) * (width + 1) * 4; }
  TexelsView<Pixel> view() const { return {data.data(), width, height, width + 1}; }
};

/// Level l has half as many texels a side as level l - 1 (rounded up), each the exact mean of its area; the
/// last has one.
PROCAM_EXPORT int levels_of(ImageSize size);

/// Light in a pyramid of area means.
class PROCAM_EXPORT LightTexture {
 public:
  using Pixel = Light;

  /// 1 (grey), 3 (RGB) or 4 (RGBA, straight alpha) channels; the finest `levels` of the pyramid.
  void prepare(ViewU8 image, const LightCurve& curve, int levels, Workers& workers);

  int levels() const { return levels_made_; }
  TexelsView<Light> level(int l) const { return levels_[std::size_t(l)].view(); }
  bool opaque() const { return opaque_; }

 private:
  std::vector<Texels<Light>> levels_;
  int levels_made_ = 0;
  bool opaque_ = true;
};

/// Values as they stand, in one level.
class ValueTexture {
 public:
  using Pixel = Value;

  void prepare(ViewU8 image, const Kernels& kernels, Workers& workers);

  TexelsView<Value> level(int) const { return texels_.view(); }
  bool opaque() const { return opaque_; }

 private:
  Texels<Value> texels_;
  bool opaque_ = true;
};

}  // namespace procam::render
