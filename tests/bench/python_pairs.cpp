// The C++ half of tests/bench/python_overhead.py:   python_pairs render|renderer|decode|calibrate ROUNDS [CAPTURES]
//
// Prints the seconds of each round of the work that the script does in Python, on the same data.
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <string>

#include "procam/calibrate/calibrate.hpp"
#include "procam/core/base/clock.hpp"
#include "procam/pattern/gray_code.hpp"
#include "procam/render/cpu.hpp"
#include "procam/session/reader.hpp"

using namespace procam;

namespace {

template <typename Work>
void time_rounds(int rounds, const Work& work) {
  work();
  for (int i = 0; i < rounds; ++i) {
    const double begin = steady_now();
    work();
    std::printf("%.9f\n", steady_now() - begin);
  }
}

/// The same pixels as in the script.
ImageU8 picture() {
  ImageU8 image(1280, 720, 3);
  for (int y = 0; y < 720; ++y)
    for (int x = 0; x < 1280; ++x)
      for (int c = 0; c < 3; ++c) image.at(x, y, c) = std::uint8_t(x * 7 + y * 13 + c * 50);
  return image;
}

void render_rounds(int rounds, bool frame_after_frame) {
  const ImageU8 content = picture();
  Projector projector;
  projector.inverse_camera.size = {1920, 1080};
  projector.inverse_camera.intrinsics = {2000, 2010, 950, 1000, 0};
  PlacedPlane plane;
  plane.plane_from_content << 1.6, 0, -0.8, 0, 0.9, -0.9, 0, 0, 1;
  plane.projector_from_surface = se3_exp(Vec6((Vec6() << 0.1, 0.2, 0, 0, 0, 2).finished()));
  Scene scene;
  scene.items.push_back({plane, content.view()});
  ImageU8 frame(1920, 1080, 3);
  render::RenderOptions options;
  options.threads = 1;
  render::CpuRenderer renderer(options);
  time_rounds(rounds, [&] {
    if (frame_after_frame) {
      renderer.render(scene, projector, frame.view());
    } else {
      render::render(scene, projector, frame.view(), options);
    }
  });
}

void decode_rounds(int rounds) {
  const pattern::GrayCode code{{1024, 768}, 1};
  const std::vector<ImageU8> frames = pattern::frames(code);
  const std::vector<ViewU8> captures(frames.begin(), frames.end());
  time_rounds(rounds, [&] { pattern::decode(captures, code); });
}

void calibrate_rounds(int rounds, const std::string& captures) {
  const session::SessionContents contents = session::read(session::open(captures));
  time_rounds(rounds, [&] { calibrate::calibrate_rig(contents.correspondences); });
}

}  // namespace

int main(int argc, char** argv) try {
  const std::string what = argc > 2 ? argv[1] : "";
  const int rounds = argc > 2 ? std::atoi(argv[2]) : 0;
  if (what == "render" || what == "renderer") {
    render_rounds(rounds, what == "renderer");
  } else if (what == "decode") {
    decode_rounds(rounds);
  } else if (what == "calibrate" && argc > 3) {
    calibrate_rounds(rounds, argv[3]);
  } else {
    std::cerr << "usage: python_pairs render|renderer|decode|calibrate ROUNDS [CAPTURES]\n";
    return 2;
  }
  return 0;
} catch (const Error& error) {
  std::cerr << error.what() << "\n";
  return 3;
}
