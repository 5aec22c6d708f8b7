/// A camera before a real screen: grabs the X display's pixels, as the light of a projector, and writes what
/// a camera would see of the stage into a folder.
///
///   simulated_camera FOLDER SESSION FPS DELAY_MS FAULTS KEYSTONE SEED      (DISPLAY in the environment)
///
/// The board's pose is the number of complete views in SESSION: whoever captures them finds the next pose
/// there. FAULTS is the share of frames that are stale (what was seen some frames ago), and of those that are
/// torn. KEYSTONE above zero is a projector that narrows the picture's top by that share.
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <filesystem>
#include <random>
#include <thread>
#include <vector>

#include "procam/io/image/images.hpp"
#include "procam/simulate/capture.hpp"
#include "procam/simulate/world.hpp"
#include "small_stage.hpp"
#include "support/screen_pixels.hpp"

namespace {

using namespace procam;
namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

ImageU8 green(const ImageU8& screen) {
  ImageU8 picture(screen.size());
  for (int y = 0; y < picture.height(); ++y)
    for (int x = 0; x < picture.width(); ++x) picture.at(x, y) = screen.at(x, y, 1);
  return picture;
}

/// What the projector's panel shows of its input: resampled when it corrects keystone.
ImageU8 on_panel(const ImageU8& picture, double keystone) {
  if (keystone <= 0) return picture;
  ImageU8 panel(picture.size());
  const double middle = 0.5 * (picture.width() - 1);
  for (int y = 0; y < panel.height(); ++y) {
    const double narrowing = 1 - keystone * (1 - double(y) / panel.height());
    for (int x = 0; x < panel.width(); ++x) {
      const double u = middle + (x - middle) / narrowing;
      const int left = int(std::floor(u));
      if (left < 0 || left + 1 >= picture.width()) continue;
      const double share = u - left;
      panel.at(x, y) =
          std::uint8_t(std::lround((1 - share) * picture.at(left, y) + share * picture.at(left + 1, y)));
    }
  }
  return panel;
}

ImageU8 light_of(const ImageU8& panel) {
  ImageU8 light(panel.size());
  for (int y = 0; y < panel.height(); ++y)
    for (int x = 0; x < panel.width(); ++x)
      light.at(x, y) = std::uint8_t(std::lround(255 * std::pow(panel.at(x, y) / 255.0, 2.2)));
  return light;
}

/// One pose of the board, ready to be seen under any picture: a camera pixel's grey is that under black plus
/// its share of the projector pixel that it sees.
struct Placed {
  ImageU8 black, white;
  simulate::ProjectorMap map;

  explicit Placed(int number) {
    const simulate::World world = test::stage(number);
    simulate::CaptureOptions options;
    options.brightest_grey = 190;
    options.camera_blur_px = 0.5;
    const ImageSize size = test::kStageProjector;
    std::vector<ImageU8> flat = simulate::capture(world, {ImageU8(size), ImageU8(size, 1, 255)}, options);
    black = std::move(flat[0]), white = std::move(flat[1]);
    map = simulate::projector_map(world);
  }

  /// Projector pixels are tents, as in simulate::capture(); camera pixels look at their centres.
  ImageF under(const ImageU8& light) const {
    ImageF grey(black.size());
    for (int y = 0; y < grey.height(); ++y)
      for (int x = 0; x < grey.width(); ++x) {
        const float u = map.pixel.at(x, y, 0), v = map.pixel.at(x, y, 1);
        const int left = std::min(std::max(int(u), 0), light.width() - 2),
                  top = std::min(std::max(int(v), 0), light.height() - 2);
        const float a = u - float(left), b = v - float(top);
        const float share = ((1 - b) * ((1 - a) * light.at(left, top) + a * light.at(left + 1, top)) +
                             b * ((1 - a) * light.at(left, top + 1) + a * light.at(left + 1, top + 1))) /
                            255;
        grey.at(x, y) = black.at(x, y) + share * float(white.at(x, y) - black.at(x, y));
      }
    return grey;
  }
};

int complete_views(const fs::path& session) {
  int count = 0;
  std::error_code ignored;
  while (fs::exists(session / ("view_0" + std::to_string(count)), ignored)) ++count;
  return count;
}

struct Pending {
  Clock::time_point due;
  ImageU8 image;
};

}  // namespace

int main(int argc, char** argv) {
  if (argc != 8) return 2;
  const fs::path folder = argv[1], session = argv[2];
  const double fps = std::atof(argv[3]), delay_ms = std::atof(argv[4]), faults = std::atof(argv[5]);
  const double keystone = std::atof(argv[6]);
  std::mt19937 random(unsigned(std::atoi(argv[7])));
  const char* display = std::getenv("DISPLAY");
  const test::ScreenPixels screen(display != nullptr ? display : "");

  const auto interval = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(1 / fps));
  const auto delay =
      std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(delay_ms / 1000));
  // Drawn once: 120000 fresh ones a frame would be most of the work.
  std::normal_distribution<float> normal;
  std::vector<float> noise(1 << 18);
  for (float& one : noise) one = normal(random);
  std::uniform_real_distribution<double> uniform;
  std::vector<Placed> poses;
  for (int i = 0; i < test::kStagePoses; ++i) poses.emplace_back(i);
  std::deque<Pending> pending;
  std::deque<fs::path> written;
  std::deque<ImageF> ring;  // the driver's buffers: what is stale is several frames old
  long long number = 0;
  const pid_t parent = getppid();
  for (Clock::time_point next = Clock::now(); getppid() == parent;) {
    const Clock::time_point now = Clock::now();
    if (!pending.empty() && pending.front().due <= now) {
      written.push_back(folder / ("shot_" + std::to_string(number++) + ".png"));
      io::save_image(written.back(), pending.front().image);
      pending.pop_front();
      if (written.size() > 40) {
        fs::remove(written.front());
        written.pop_front();
      }
      continue;
    }
    if (next > now) {
      std::this_thread::sleep_until(pending.empty() ? next : std::min(next, pending.front().due));
      continue;
    }
    const Placed& pose = poses[std::size_t(std::min(complete_views(session), test::kStagePoses - 1))];
    const ImageF still = pose.under(light_of(on_panel(green(screen.read(test::kStageProjector)), keystone)));
    constexpr std::size_t kRing = 4;
    ring.push_back(still);
    if (ring.size() > kRing) ring.pop_front();
    const bool stale = uniform(random) < faults, torn = uniform(random) < faults;
    const int tear = torn ? int(uniform(random) * still.height()) : stale ? still.height() : 0;
    ImageU8 image(still.size());
    std::size_t next_noise = random() % (noise.size() / 2);
    for (int y = 0; y < image.height(); ++y)
      for (int x = 0; x < image.width(); ++x) {
        const float grey = (y < tear ? ring.front() : still).at(x, y);
        const float noisy = grey + std::sqrt(0.5f + 0.01f * grey) * noise[next_noise++];
        image.at(x, y) = std::uint8_t(std::min(255.f, std::max(0.f, noisy)) + 0.5f);
      }
    pending.push_back({now + delay, std::move(image)});
    next = std::max(next + interval, Clock::now() - interval);
  }
  return 0;
}
