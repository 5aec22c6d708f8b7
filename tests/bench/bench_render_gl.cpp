/// A wall with a bump as a little over 100 000 triangles, and nine surfaces, 1920x1080, by the CPU renderer,
/// by the OpenGL renderer on whatever this machine has (its name is printed; llvmpipe is Mesa's on the CPU),
/// and the triangles by the plainest OpenGL there is: a textured mesh, one bilinear sample, no anti-aliasing,
/// no lens. All are read back into memory. The clock's time, and the CPU time of all threads, which other
/// work on the machine disturbs less.
///
///   bench_render_gl --benchmark_repetitions=5 --benchmark_enable_random_interleaving=true
#include <benchmark/benchmark.h>
#include <epoxy/egl.h>
#include <epoxy/gl.h>

#include <Eigen/LU>
#include <cstdio>
#include <random>

#include "procam/render/gl.hpp"
#include "render/gl/display_of_card.hpp"
#include "render/rooms.hpp"
#include "wall_of_triangles.hpp"

namespace {

using namespace procam;
using render::Filter;
using render::RenderOptions;

constexpr ImageSize kFrame{1920, 1080};

Projector projector() {
  return {Camera{kFrame, {2400, 2380, 950, 1000, 2}, NoDistortion{}}};
}

const ImageU8& picture() {
  static const ImageU8 image = [] {
    ImageU8 made(kFrame, 3);
    std::mt19937 random(1);
    for (int y = 0; y < kFrame.height; ++y)
      for (int x = 0; x < 3 * kFrame.width; ++x)
        made.row(y)[x] = std::uint8_t(120 + 60 * std::sin(0.01 * x) + int(random() % 50));
    return made;
  }();
  return image;
}

Sheet wall() {
  return tilted_sheet(projector(), 1.5, 0.84, 1.6, 60, Vec2(960, 540));
}

Scene triangles() {
  return wall_of_triangles(wall(), picture());
}

Scene nine() {
  Scene scene;
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 3; ++i) {
      Mat3 cell;
      cell << 1.0 / 3, 0, i / 3.0, 0, 1.0 / 3, j / 3.0, 0, 0, 1;
      PlacedPlane placed = wall().placement;
      placed.plane_from_content = placed.plane_from_content * cell;
      scene.items.push_back({placed, picture()});
    }
  return scene;
}

template <typename Renderer>
void draw(benchmark::State& state, const Scene& shown, Filter filter, bool moving) {
  RenderOptions options;
  options.filter = filter;
  options.linear_light = filter == Filter::kArea;
  Renderer renderer(options);
  Scene scene = shown;
  ImageU8 frame(kFrame, 3);
  const Projector p = projector();
  renderer.render(scene, p, frame);
  for (auto _ : state) {
    if (moving)
      for (SceneItem& item : scene.items)
        if (auto* const mesh = std::get_if<PlacedMesh>(&item.placement))
          mesh->projector_from_surface.translation.x() += 1e-7;
    renderer.render(scene, p, frame);
  }
}

/// The mesh drawn as a textbook does.
void draw_plainly(benchmark::State& state) {
  const EGLDisplay display = display_of_card();
  const EGLint any[] = {EGL_SURFACE_TYPE, 0, EGL_NONE};
  const EGLint version[] = {EGL_CONTEXT_MAJOR_VERSION_KHR, 3, EGL_CONTEXT_MINOR_VERSION_KHR, 3, EGL_NONE};
  EGLConfig config = nullptr;
  EGLint count = 0;
  if (!eglInitialize(display, nullptr, nullptr) || !eglBindAPI(EGL_OPENGL_API) ||
      !eglChooseConfig(display, any, &config, 1, &count))
    return state.SkipWithError("no EGL");
  const EGLContext context = eglCreateContext(display, config, EGL_NO_CONTEXT, version);
  eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context);

  const Scene scene = triangles();
  const PlacedMesh& placed = std::get<PlacedMesh>(scene.items[0].placement);
  std::vector<float> corners;
  for (std::size_t i = 0; i < placed.mesh->vertices.size(); ++i) {
    const Vec3 p = placed.projector_from_surface * placed.mesh->vertices[i];
    corners.insert(corners.end(), {float(p.x()), float(p.y()), float(p.z()), float(placed.mesh->uv[i].x()),
                                   float(placed.mesh->uv[i].y())});
  }
  GLuint names[2], vertices = 0, textures[2], depth = 0, framebuffer = 0;
  glGenVertexArrays(1, &vertices);
  glBindVertexArray(vertices);
  glGenBuffers(2, names);
  glBindBuffer(GL_ARRAY_BUFFER, names[0]);
  glBufferData(GL_ARRAY_BUFFER, GLsizeiptr(corners.size() * sizeof(float)), corners.data(), GL_STATIC_DRAW);
  const auto& indices = placed.mesh->triangles;
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, names[1]);
  glBufferData(GL_ELEMENT_ARRAY_BUFFER, GLsizeiptr(indices.size() * sizeof(indices[0])), indices.data(),
               GL_STATIC_DRAW);
  glEnableVertexAttribArray(0);
  glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, 20, nullptr);
  glEnableVertexAttribArray(1);
  glVertexAttribPointer(1, 2, GL_FLOAT, GL_FALSE, 20, reinterpret_cast<const void*>(12));
  glGenTextures(2, textures);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  for (const int i : {1, 0}) {
    glBindTexture(GL_TEXTURE_2D, textures[i]);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, kFrame.width, kFrame.height, 0, GL_RGB, GL_UNSIGNED_BYTE,
                 i == 0 ? picture().data() : nullptr);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  }
  glGenRenderbuffers(1, &depth);
  glBindRenderbuffer(GL_RENDERBUFFER, depth);
  glRenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH_COMPONENT24, kFrame.width, kFrame.height);
  glGenFramebuffers(1, &framebuffer);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, textures[1], 0);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, depth);
  glViewport(0, 0, kFrame.width, kFrame.height);
  glEnable(GL_DEPTH_TEST);
  const GLuint program = glCreateProgram();
  const char* const texts[2] = {
      "#version 330 core\nlayout(location = 0) in vec3 p; layout(location = 1) in vec2 c; uniform mat3 k;\n"
      "out vec2 uv; void main() { vec3 q = k * p; uv = c;\n"
      "gl_Position = vec4(2.0 * (q.xy + 0.5 * q.z) / vec2(1920, 1080) - q.z, 0.9 * q.z - 0.1, q.z); }",
      "#version 330 core\nin vec2 uv; uniform sampler2D s; out vec4 o; void main() { o = texture(s, uv); }"};
  const GLenum kinds[2] = {GL_VERTEX_SHADER, GL_FRAGMENT_SHADER};
  for (int i = 0; i < 2; ++i) {
    const GLuint shader = glCreateShader(kinds[i]);
    glShaderSource(shader, 1, &texts[i], nullptr);
    glCompileShader(shader);
    glAttachShader(program, shader);
  }
  glLinkProgram(program);
  glUseProgram(program);
  const Eigen::Matrix3f k = projector().inverse_camera.intrinsics.matrix().cast<float>();
  glUniformMatrix3fv(glGetUniformLocation(program, "k"), 1, GL_FALSE, k.data());
  std::vector<std::uint8_t> read(std::size_t(kFrame.width) * kFrame.height * 4);
  for (auto _ : state) {
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    glDrawElements(GL_TRIANGLES, GLsizei(3 * indices.size()), GL_UNSIGNED_INT, nullptr);
    glReadPixels(0, 0, kFrame.width, kFrame.height, GL_RGBA, GL_UNSIGNED_BYTE, read.data());
  }
  std::size_t lit = 0;
  for (std::size_t i = 0; i < read.size(); i += 4) lit += read[i] > 0;
  state.counters["lit share"] = double(lit) / (double(read.size()) / 4);
  if (glGetError() != GL_NO_ERROR) state.SkipWithError("OpenGL error");
  eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  eglDestroyContext(display, context);
}

}  // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  const Scene mesh = triangles(), surfaces = nine();
  const auto add = [](const std::string& name, auto work) {
    benchmark::RegisterBenchmark(name.c_str(), work)
        ->Unit(benchmark::kMillisecond)
        ->MeasureProcessCPUTime()
        ->UseRealTime()
        ->MinTime(0.2);
  };
  add("triangles, plainest OpenGL", draw_plainly);
  for (const Filter filter : {Filter::kBilinear, Filter::kArea})
    for (const bool moving : {false, true}) {
      const std::string of = std::string(filter == Filter::kArea ? ", area in light" : ", bilinear") +
                             (moving ? ", moving" : "");
      add("triangles, CPU" + of,
          [=](benchmark::State& state) { draw<render::CpuRenderer>(state, mesh, filter, moving); });
      add("triangles, OpenGL" + of,
          [=](benchmark::State& state) { draw<render_gl::GlRenderer>(state, mesh, filter, moving); });
      if (moving) continue;
      add("nine surfaces, CPU" + of,
          [=](benchmark::State& state) { draw<render::CpuRenderer>(state, surfaces, filter, false); });
      add("nine surfaces, OpenGL" + of,
          [=](benchmark::State& state) { draw<render_gl::GlRenderer>(state, surfaces, filter, false); });
    }
  std::printf("OpenGL: %s\n", render_gl::GlRenderer().device().c_str());
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
