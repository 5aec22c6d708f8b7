/// procam's CPU renderer against OpenCV's ways to draw the same frame of 1920x1080, in one run: time, and
/// PSNR against a 16 x 16 supersampled reference over every fifth pixel each way. Ends with a table of
/// ratios, the figure asked for beside each.
///
///   bench_render --benchmark_repetitions=9 --benchmark_enable_random_interleaving=true
///
/// which lets all take turns, so that a change of load meets each of them. On one thread CPU time is
/// compared, on two the clock's; the fastest repetition each.
#include <benchmark/benchmark.h>

#include <Eigen/LU>
#include <algorithm>
#include <cstdio>
#include <functional>
#include <map>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgproc.hpp>
#include <random>

#include "procam/render/cpu.hpp"
#include "render/rooms.hpp"
#include "wall_of_triangles.hpp"

namespace {

using namespace procam;
using render::CpuRenderer;
using render::Filter;
using render::RenderOptions;

constexpr ImageSize kFrame{1920, 1080};

Projector projector(bool lens) {
  Projector p{Camera{kFrame, {2400, 2380, 950, 1000, 2}, NoDistortion{}}};
  if (lens) p.inverse_camera.distortion = brown(-0.1);
  return p;
}

/// Clouds (1/f noise), text of several sizes, a zone plate up to half a cycle a texel, noise with hard edges.
const cv::Mat& picture(int channels) {
  static std::map<int, cv::Mat> made;
  cv::Mat& image = made[channels];
  if (!image.empty()) return image;
  const int w = kFrame.width, h = kFrame.height;
  cv::Mat clouds(h, w, CV_32FC3, cv::Scalar::all(0));
  cv::RNG random(11);
  for (int scale = 1; scale <= 256; scale *= 2) {
    cv::Mat noise(h / scale + 2, w / scale + 2, CV_32FC3), large;
    random.fill(noise, cv::RNG::NORMAL, 0, 3.0 * std::sqrt(double(scale)));
    cv::resize(noise, large, cv::Size(w, h), 0, 0, cv::INTER_CUBIC);
    clouds += large;
  }
  clouds.convertTo(image, CV_8UC3, 1, 120);
  for (int y = 60, line = 0; y < h - 20; y += 24 + line % 3 * 8, ++line)
    cv::putText(image, "Light follows the truth: the quick brown fox jumps over 0123456789",
                cv::Point(40 + line % 5 * 9, y), cv::FONT_HERSHEY_SIMPLEX, 0.45 + 0.2 * (line % 3),
                line % 2 ? cv::Scalar(250, 250, 240) : cv::Scalar(10, 20, 15), 1 + line % 2, cv::LINE_AA);
  const int size = 420;
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) {
      const double dx = x - 0.5 * size, dy = y - 0.5 * size;
      image.at<cv::Vec3b>(90 + y, w - 500 + x) =
          cv::Vec3b::all(std::uint8_t(127.5 + 127.5 * std::cos(kPi / size * (dx * dx + dy * dy))));
      const bool dark = (x / 35 + y / 50) % 2 == 0;
      image.at<cv::Vec3b>(570 + y, w - 500 + x) =
          cv::Vec3b::all(std::uint8_t(std::clamp((dark ? 40.0 : 200.0) + random.gaussian(15), 0.0, 255.0)));
    }
  if (channels == 4) {
    cv::cvtColor(image, image, cv::COLOR_RGB2RGBA);
    for (int y = 0; y < h; ++y)  // a soft vignette
      for (int x = 0; x < w; ++x)
        image.at<cv::Vec4b>(y, x)[3] =
            std::uint8_t(std::min(255.0, 40.0 + 4.0 * std::min({x, y, w - 1 - x, h - 1 - y})));
  }
  return image;
}

ViewU8 view_of(const cv::Mat& image) {
  return {image.data, image.cols, image.rows, image.channels(), std::ptrdiff_t(image.step)};
}

Sheet sheet_at(double degrees, const Projector& p) {
  return degrees < 50 ? tilted_sheet(p, 1.35, 0.76, 1.6, degrees, Vec2(960, 540))
                      : tilted_sheet(p, 1.5, 0.84, 1.6, degrees, Vec2(960, 540));
}

/// n x n pieces of the wall at 47 degrees that cover as much of the frame whatever n, each with the picture.
Scene mosaic(int n, const Projector& p, ViewU8 content) {
  const Sheet sheet = sheet_at(47, p);
  Scene scene;
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      Mat3 cell;
      cell << 1.0 / n, 0, double(i) / n, 0, 1.0 / n, double(j) / n, 0, 0, 1;
      PlacedPlane placed = sheet.placement;
      placed.plane_from_content = placed.plane_from_content * cell;
      scene.items.push_back({placed, content});
    }
  return scene;
}

Scene one_surface(double degrees, const Projector& p, ViewU8 content) {
  Scene scene;
  scene.items.push_back({sheet_at(degrees, p).placement, content});
  return scene;
}

/// From texels of the content to pixels of a frame `scale` times as large, for a pinhole.
cv::Matx33d pixel_from_texel(const SceneItem& item, const Projector& p, int scale = 1) {
  const PlacedPlane& plane = std::get<PlacedPlane>(item.placement);
  Mat3 direction_from_plane = plane.projector_from_surface.rotation_matrix();
  direction_from_plane.col(2) = plane.projector_from_surface.translation;
  Mat3 content_from_texel, scaled;
  const double w = item.content.width, h = item.content.height, shift = 0.5 * (scale - 1);
  content_from_texel << 1 / w, 0, 0.5 / w, 0, 1 / h, 0.5 / h, 0, 0, 1;
  scaled << scale, 0, shift, 0, scale, shift, 0, 0, 1;
  const Mat3 m = scaled * p.inverse_camera.intrinsics.matrix() * direction_from_plane *
                 plane.plane_from_content * content_from_texel;
  return cv::Matx33d(m(0, 0), m(0, 1), m(0, 2), m(1, 0), m(1, 1), m(1, 2), m(2, 0), m(2, 1), m(2, 2));
}

// One frame drawn in one of the ways; draws into `frame`.
using Draw = std::function<void(cv::Mat& frame)>;

Draw procam_draws(const Scene& scene, const Projector& p, Filter filter, bool linear_light, int threads) {
  RenderOptions options;
  options.filter = filter;
  options.linear_light = linear_light;
  options.threads = threads;
  const auto renderer = std::make_shared<CpuRenderer>(options);
  return [=](cv::Mat& frame) {
    frame.create(kFrame.height, kFrame.width, CV_8UC3);
    renderer->render(scene, p, {frame.data, frame.cols, frame.rows, 3});
  };
}

/// The same, and before each frame `change` makes it another.
Draw changing(Scene scene, const Projector& p, Filter filter, bool linear_light,
              const std::function<void(SceneItem&)>& change) {
  const auto shown = std::make_shared<Scene>(std::move(scene));
  RenderOptions options;
  options.filter = filter;
  options.linear_light = linear_light;
  options.threads = 1;
  const auto renderer = std::make_shared<CpuRenderer>(options);
  return [=](cv::Mat& frame) {
    for (SceneItem& item : shown->items) change(item);
    frame.create(kFrame.height, kFrame.width, CV_8UC3);
    renderer->render(*shown, p, {frame.data, frame.cols, frame.rows, 3});
  };
}

Draw warp_draws(const cv::Mat& content, const cv::Matx33d& matrix) {
  return [=](cv::Mat& frame) {
    cv::warpPerspective(content, frame, matrix, cv::Size(kFrame.width, kFrame.height), cv::INTER_LINEAR);
  };
}

/// With fixed-point maps made beforehand.
Draw remap_draws(const cv::Mat& content, const cv::Matx33d& matrix) {
  const cv::Matx33d inverse = matrix.inv();
  cv::Mat exact(kFrame.height, kFrame.width, CV_32FC2), whole, part;
  for (int y = 0; y < exact.rows; ++y)
    for (int x = 0; x < exact.cols; ++x) {
      const cv::Vec3d q = inverse * cv::Vec3d(x, y, 1);
      exact.at<cv::Vec2f>(y, x) = cv::Vec2f(float(q[0] / q[2]), float(q[1] / q[2]));
    }
  cv::convertMaps(exact, cv::noArray(), whole, part, CV_16SC2);
  return [=](cv::Mat& frame) { cv::remap(content, frame, whole, part, cv::INTER_LINEAR); };
}

Draw reduced_draws(const cv::Mat& content, const cv::Matx33d& twice) {
  const auto large = std::make_shared<cv::Mat>();
  return [=](cv::Mat& frame) {
    cv::warpPerspective(content, *large, twice, cv::Size(2 * kFrame.width, 2 * kFrame.height),
                        cv::INTER_LINEAR);
    cv::resize(*large, frame, cv::Size(kFrame.width, kFrame.height), 0, 0, cv::INTER_AREA);
  };
}

/// A warp, the mask of its outline and a masked copy for each.
Draw masked_warps_draw(const Scene& scene, const Projector& p, const cv::Mat& content) {
  struct Step {
    cv::Matx33d matrix;
    std::vector<cv::Point> outline;
  };
  std::vector<Step> steps;
  for (const SceneItem& item : scene.items) {
    Step step{pixel_from_texel(item, p), {}};
    const double w = content.cols - 0.5, h = content.rows - 0.5;
    for (const cv::Vec3d& corner :
         {cv::Vec3d(-0.5, -0.5, 1), cv::Vec3d(w, -0.5, 1), cv::Vec3d(w, h, 1), cv::Vec3d(-0.5, h, 1)}) {
      const cv::Vec3d q = step.matrix * corner;
      step.outline.emplace_back(cvRound(q[0] / q[2]), cvRound(q[1] / q[2]));
    }
    steps.push_back(step);
  }
  const auto warped = std::make_shared<cv::Mat>(), mask = std::make_shared<cv::Mat>();
  return [=](cv::Mat& frame) {
    frame.create(kFrame.height, kFrame.width, CV_8UC3);
    frame.setTo(0);
    mask->create(frame.size(), CV_8U);
    for (const Step& step : steps) {
      cv::warpPerspective(content, *warped, step.matrix, frame.size(), cv::INTER_LINEAR);
      mask->setTo(0);
      cv::fillConvexPoly(*mask, step.outline, 255);
      warped->copyTo(frame, *mask);
    }
  };
}

/// Keeps the fastest repetition of each.
class BestOf : public benchmark::ConsoleReporter {
 public:
  std::map<std::string, double> milliseconds;

  void ReportRuns(const std::vector<Run>& runs) override {
    for (const Run& run : runs) {
      if (run.run_type != Run::RT_Iteration || run.error_occurred) continue;
      std::string name = run.run_name.function_name;
      const bool two = name.find("/2 threads") != std::string::npos;
      double& best = milliseconds.emplace(name, 1e30).first->second;
      best = std::min(best, two ? run.GetAdjustedRealTime() : run.GetAdjustedCPUTime());
    }
    ConsoleReporter::ReportRuns(runs);
  }
};

/// PSNR of a frame over pixels that the content fills: all of them, and those that hold over two texels.
struct Quality {
  double all_db = 0, minified_db = 0;
};

class Reference {
 public:
  Reference(const Scene& scene, const Projector& p, const cv::Mat& content, bool linear_light) {
    const cv::Matx33d matrix = pixel_from_texel(scene.items[0], p).inv();
    const auto texel = [&](double x, double y) {
      const cv::Vec3d q = matrix * cv::Vec3d(x, y, 1);
      return Vec2(q[0] / q[2], q[1] / q[2]);
    };
    const auto inside = [&](const Vec2& t) {
      return t.x() >= 0 && t.y() >= 0 && t.x() < content.cols - 1 && t.y() < content.rows - 1;
    };
    double light[256];
    for (int v = 0; v < 256; ++v) light[v] = linear_light ? light_of(v) : v / 255.0;
    for (int y = 2; y < kFrame.height; y += 5)
      for (int x = 2; x < kFrame.width; x += 5) {
        const Vec2 corners[4] = {texel(x - 0.5, y - 0.5), texel(x + 0.5, y - 0.5), texel(x + 0.5, y + 0.5),
                                 texel(x - 0.5, y + 0.5)};
        if (!std::all_of(corners, corners + 4, inside)) continue;
        Pixel pixel{x, y, false, {0, 0, 0}};
        const Vec2 a = corners[2] - corners[0], b = corners[3] - corners[1];
        pixel.minified = std::abs(a.x() * b.y() - a.y() * b.x()) > 2 * 2;  // twice the area
        for (int j = 0; j < 16; ++j)
          for (int i = 0; i < 16; ++i) {
            const Vec2 t = texel(x + (i + 0.5) / 16 - 0.5, y + (j + 0.5) / 16 - 0.5);
            const int x0 = int(t.x()), y0 = int(t.y());
            const double u = t.x() - x0, v = t.y() - y0;
            const std::uint8_t *upper = content.ptr(y0) + 3 * x0, *lower = content.ptr(y0 + 1) + 3 * x0;
            for (int c = 0; c < 3; ++c)
              pixel.value[c] += ((1 - v) * ((1 - u) * light[upper[c]] + u * light[upper[c + 3]]) +
                                 v * ((1 - u) * light[lower[c]] + u * light[lower[c + 3]])) /
                                256;
          }
        for (double& value : pixel.value) {
          if (linear_light)
            value = value <= 0.0031308 ? 12.92 * value : 1.055 * std::pow(value, 1 / 2.4) - 0.055;
          value *= 255;
        }
        pixels_.push_back(pixel);
      }
  }

  Quality quality(const cv::Mat& frame) const {
    double error = 0, minified_error = 0;
    std::size_t minified = 0;
    for (const Pixel& pixel : pixels_) {
      const cv::Vec3b drawn = frame.at<cv::Vec3b>(pixel.y, pixel.x);
      double sum = 0;
      for (int c = 0; c < 3; ++c) sum += std::pow(drawn[c] - pixel.value[c], 2) / 3;
      error += sum;
      minified_error += pixel.minified ? sum : 0;
      minified += pixel.minified;
    }
    const auto db = [](double total, std::size_t count) {
      return 10 * std::log10(65025.0 * double(count) / total);
    };
    return {db(error, pixels_.size()), db(minified_error, minified)};
  }

  void say(double degrees) const {
    const auto minified =
        std::count_if(pixels_.begin(), pixels_.end(), [](const Pixel& p) { return p.minified; });
    std::printf("  %.0f degrees: filled pixels %.0f %% of the frame, of them %.0f %% hold over two texels\n",
                degrees, 100.0 * double(pixels_.size()) * 25 / (kFrame.width * kFrame.height),
                100.0 * double(minified) / double(pixels_.size()));
  }

 private:
  struct Pixel {
    int x, y;
    bool minified;
    double value[3];
  };
  std::vector<Pixel> pixels_;
};

}  // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;

  const auto add = [](const std::string& name, int threads, const Draw& draw) {
    const std::string full = name + "/" + std::to_string(threads) + (threads == 1 ? " thread" : " threads");
    auto* const one = benchmark::RegisterBenchmark(full.c_str(), [=](benchmark::State& state) {
      cv::setNumThreads(threads);
      cv::Mat frame;
      for (auto _ : state) draw(frame);
    });
    one->Unit(benchmark::kMillisecond)->MinTime(0.05);
    if (threads > 1) one->UseRealTime();
  };

  const Projector pinhole = projector(false), lens = projector(true);
  const cv::Mat &rgb = picture(3), &rgba = picture(4);
  for (const int threads : {1, 2})
    for (const int degrees : {47, 60})
      for (const int channels : {3, 4}) {
        const cv::Mat& content = channels == 3 ? rgb : rgba;
        const Scene scene = one_surface(degrees, pinhole, view_of(content));
        const std::string of = std::to_string(degrees) + (channels == 3 ? " RGB" : " RGBA");
        add("procam bilinear " + of, threads,
            procam_draws(scene, pinhole, Filter::kBilinear, false, threads));
        add("warp " + of, threads, warp_draws(content, pixel_from_texel(scene.items[0], pinhole)));
        add("remap " + of, threads, remap_draws(content, pixel_from_texel(scene.items[0], pinhole)));
        if (channels == 4) continue;
        add("procam area " + of, threads, procam_draws(scene, pinhole, Filter::kArea, false, threads));
        add("procam area in light " + of, threads,
            procam_draws(scene, pinhole, Filter::kArea, true, threads));
        if (threads == 1)
          add("2x2 reduced " + of, threads,
              reduced_draws(content, pixel_from_texel(scene.items[0], pinhole, 2)));
      }
  // An oval outline with a hole, at half the resolution.
  cv::Mat mask(kFrame.height / 2, kFrame.width / 2, CV_8U, cv::Scalar(0));
  const cv::Point middle(mask.cols / 2, mask.rows / 2);
  cv::ellipse(mask, middle, {mask.cols / 2 - 8, mask.rows / 2 - 8}, 0, 0, 360, cv::Scalar(255), cv::FILLED);
  cv::circle(mask, middle, mask.rows / 8, cv::Scalar(0), cv::FILLED);
  cv::Mat small[9];
  for (const int n : {1, 3, 8}) {
    cv::resize(rgb, small[n], cv::Size(kFrame.width / n, kFrame.height / n), 0, 0, cv::INTER_AREA);
    const Scene scene = mosaic(n, pinhole, view_of(small[n]));
    const std::string of = std::to_string(n * n) + " surfaces";
    add("procam bilinear " + of, 1, procam_draws(scene, pinhole, Filter::kBilinear, false, 1));
    add("procam area in light " + of, 1, procam_draws(scene, pinhole, Filter::kArea, true, 1));
    add("masked warps " + of, 1, masked_warps_draw(scene, pinhole, small[n]));
  }
  for (const Filter filter : {Filter::kBilinear, Filter::kArea}) {
    const std::string of = filter == Filter::kArea ? "procam area in light " : "procam bilinear ";
    const bool light = filter == Filter::kArea;
    const Scene scene = one_surface(60, lens, view_of(rgb)),
                straight = one_surface(60, pinhole, view_of(rgb));
    add(of + "60 RGB with lens", 1, procam_draws(scene, lens, filter, light, 1));
    Scene masked = straight;
    masked.items[0].mask = view_of(mask);
    add(of + "60 RGB masked", 1, procam_draws(masked, pinhole, filter, light, 1));
    add(of + "60 RGB moving", 1, changing(straight, pinhole, filter, light, [](SceneItem& item) {
          std::get<PlacedPlane>(item.placement).projector_from_surface.translation.x() += 1e-7;
        }));
    add(of + "60 RGB with lens, moving", 1, changing(scene, lens, filter, light, [](SceneItem& item) {
          std::get<PlacedPlane>(item.placement).projector_from_surface.translation.x() += 1e-7;
        }));
    const Scene triangles = wall_of_triangles(sheet_at(60, pinhole), view_of(rgb));
    add(of + "100k triangles", 1, procam_draws(triangles, pinhole, filter, light, 1));
    add(of + "100k triangles moving", 1, changing(triangles, pinhole, filter, light, [](SceneItem& item) {
          std::get<PlacedMesh>(item.placement).projector_from_surface.translation.x() += 1e-7;
        }));
    add(of + "60 RGB video", 1,
        changing(straight, pinhole, filter, light, [](SceneItem& item) { ++item.content_revision; }));
  }

  BestOf best;
  benchmark::RunSpecifiedBenchmarks(&best);

  std::printf("\nOpenCV %s; milliseconds a frame, fastest repetition\n", CV_VERSION);
  const auto row = [&](const std::string& ours, const std::string& theirs, const char* asked) {
    const auto a = best.milliseconds.find(ours), b = best.milliseconds.find(theirs);
    if (a == best.milliseconds.end() || b == best.milliseconds.end()) return;
    std::printf("  %-48s %7.2f   %-42s %7.2f   ratio %5.2f   %s\n", ours.c_str(), a->second, theirs.c_str(),
                b->second, b->second / a->second, asked);
  };
  for (const std::string threads : {"/1 thread", "/2 threads"})
    for (const std::string of : {"47 RGB", "47 RGBA", "60 RGB", "60 RGBA"}) {
      row("procam bilinear " + of + threads, "warp " + of + threads, "asked: 4 or more");
      row("procam bilinear " + of + threads, "remap " + of + threads, "asked: 2 or more");
      row("procam area " + of + threads, "warp " + of + threads, "asked: 0.67 or more (1.5 times the time)");
      row("procam area in light " + of + threads, "warp " + of + threads, "asked: 0.67 or more");
      row("procam area " + of + threads, "2x2 reduced " + of + threads, "asked: 3 or more");
      row("procam area in light " + of + threads, "2x2 reduced " + of + threads, "asked: 3 or more");
    }
  for (const std::string of : {"1 surfaces", "9 surfaces", "64 surfaces"}) {
    row("procam bilinear " + of + "/1 thread", "masked warps " + of + "/1 thread",
        of[0] == '9' ? "asked: 4 or more, and under 14.3 ms" : "");
    row("procam area in light " + of + "/1 thread", "masked warps " + of + "/1 thread", "");
  }
  for (const std::string of : {"procam bilinear ", "procam area in light "}) {
    row(of + "60 RGB with lens/1 thread", of + "60 RGB/1 thread", "asked: 0.77 or more (1.3 times the time)");
    row(of + "60 RGB masked/1 thread", of + "60 RGB/1 thread", "two samples, and blended: 0.4 or more");
    row(of + "60 RGB with lens, moving/1 thread", of + "60 RGB moving/1 thread", "asked: 0.77 or more");
    row(of + "60 RGB moving/1 thread", "warp 60 RGB/1 thread", "every frame a new map");
    row(of + "60 RGB video/1 thread", "warp 60 RGB/1 thread", "every frame a new picture");
    row(of + "100k triangles/1 thread", of + "60 RGB/1 thread", "the same wall with a bump");
    row(of + "100k triangles moving/1 thread", of + "60 RGB moving/1 thread", "");
  }

  std::printf("\nPSNR, dB: all filled pixels, those that hold over two texels\n");
  for (const int degrees : {47, 60}) {
    const Scene scene = one_surface(degrees, pinhole, view_of(rgb));
    const cv::Matx33d matrix = pixel_from_texel(scene.items[0], pinhole);
    const Reference values(scene, pinhole, rgb, false), light(scene, pinhole, rgb, true);
    values.say(degrees);
    const auto say = [&](const char* name, const Reference& reference, const Draw& draw, const char* asked) {
      cv::Mat frame;
      draw(frame);
      const Quality quality = reference.quality(frame);
      std::printf("    %-34s %6.2f %6.2f   %s\n", name, quality.all_db, quality.minified_db, asked);
    };
    say("warpPerspective", values, warp_draws(rgb, matrix), "");
    say("remap", values, remap_draws(rgb, matrix), "");
    say("2x2 reduced", values, reduced_draws(rgb, pixel_from_texel(scene.items[0], pinhole, 2)), "");
    say("procam bilinear", values, procam_draws(scene, pinhole, Filter::kBilinear, false, 1),
        "asked: no lower than warpPerspective");
    say("procam area", values, procam_draws(scene, pinhole, Filter::kArea, false, 1),
        "asked: 40 or more, 6 above bilinear where minified");
    say("procam bilinear in light", light, procam_draws(scene, pinhole, Filter::kBilinear, true, 1),
        "(reference in light)");
    say("procam area in light", light, procam_draws(scene, pinhole, Filter::kArea, true, 1),
        "(reference in light)");
  }
  return 0;
}
