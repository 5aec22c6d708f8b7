/// What the card does: casting and drawing.
#include <epoxy/gl.h>

#include "kernels.hpp"
#include "state.hpp"

namespace procam::render_gl {

namespace {

Program linked(const char* vertices, const std::string& fragments) {
  const std::string version = epoxy_is_desktop_gl() ? "#version 330 core\n" : "#version 300 es\n";
  const std::string head = version +
                           "precision highp float;\nprecision highp int;\n"
                           "const int kFacetTexels = " +
                           std::to_string(kFacetTexels) +
                           ", kRecordTexels = " + std::to_string(kRecordTexels) +
                           ", kMaxGroups = " + std::to_string(kMaxGroups) + ";\n";
  Program program(glCreateProgram());
  std::array<Shader, 2> shaders{Shader(glCreateShader(GL_VERTEX_SHADER)),
                                Shader(glCreateShader(GL_FRAGMENT_SHADER))};
  const std::string texts[2] = {head + vertices, head + fragments};
  for (std::size_t i = 0; i < 2; ++i) {
    const char* const text = texts[i].c_str();
    glShaderSource(shaders[i].name(), 1, &text, nullptr);
    glCompileShader(shaders[i].name());
    GLint done = 0;
    glGetShaderiv(shaders[i].name(), GL_COMPILE_STATUS, &done);
    if (!done) {
      char words[2000] = "";
      glGetShaderInfoLog(shaders[i].name(), sizeof words, nullptr, words);
      refuse("OpenGL", std::string("the driver does not compile a program: ") + words);
    }
    glAttachShader(program.name(), shaders[i].name());
  }
  glLinkProgram(program.name());
  GLint done = 0;
  glGetProgramiv(program.name(), GL_LINK_STATUS, &done);
  if (!done) {
    char words[2000] = "";
    glGetProgramInfoLog(program.name(), sizeof words, nullptr, words);
    refuse("OpenGL", std::string("the driver does not link a program: ") + words);
  }
  return program;
}

void uniform(const Program& program, const char* name, int value) {
  glUniform1i(glGetUniformLocation(program.name(), name), value);
}

}  // namespace

GlRenderer::State::OnCard::OnCard() {
  const std::string common = kCommon;
  find_hits = linked(kFacetBoxes, common + kFindHits);
  find_plane_hits = linked(kWholeFrame, common + kFindPlaneHits);
  find_edges = linked(kWholeFrame, common + kFindEdges);
  choose_taps = linked(kWholeFrame, common + kChooseTaps);
  draw = linked(kWholeFrame, common + kDraw);
  copy = linked(kWholeFrame, kCopy);
  draw_edges = linked(kWholeFrame, "#define EDGES\n" + common + kDraw);
  GLuint name = 0;
  glGenFramebuffers(1, &name);
  framebuffer = Framebuffer(name);
  glGenVertexArrays(1, &name);
  nothing = VertexArray(name);
}

void GlRenderer::State::target(GLuint texture, int layer) const {
  glBindFramebuffer(GL_FRAMEBUFFER, on_card_->framebuffer.name());
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, GL_RENDERBUFFER, 0);
  if (layer < 0)
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture, 0);
  else
    glFramebufferTextureLayer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, texture, 0, layer);
}

void GlRenderer::State::use(const Program& program) const {
  const GLuint name = program.name();
  glUseProgram(name);
  const auto at = [&](const char* uniform) { return glGetUniformLocation(name, uniform); };
  const std::pair<const char*, int> units[] = {{"u_lists", kListsUnit},     {"u_numbers", kNumbersUnit},
                                               {"u_content", kContentUnit}, {"u_rays", kRaysUnit},
                                               {"u_hits", kHitsUnit},       {"u_edges", kEdgesUnit},
                                               {"u_taps", kTapsUnit},       {"u_values", kValuesUnit}};
  for (const auto& [uniform, unit] : units) glUniform1i(at(uniform), unit);
  const render::TileGrid grid = lens_.grid();
  glUniform1i(at("u_row_bits"), row_bits_);
  glUniform2i(at("u_frame"), grid.frame.width, grid.frame.height);
  glUniform2i(at("u_tiles"), grid.across(), grid.down());
  glUniform1i(at("u_first_tile"), GLint(first_tile_));
  glUniform1i(at("u_has_lens"), has_lens_);
  const Eigen::Matrix3f direction_from_pixel =
      projector_->inverse_camera.intrinsics.matrix().inverse().cast<float>();
  glUniformMatrix3fv(at("u_direction_from_pixel"), 1, GL_FALSE, direction_from_pixel.data());
  glUniform1i(at("u_right_steps"), !area() && !options_.linear_light ? 128 : 512);
  glBindVertexArray(on_card_->nothing.name());
  on_card_->lists.bind();
  on_card_->numbers.bind();
  on_card_->content.bind();
  on_card_->rays.bind();
  if (layers_cast_ > 0) on_card_->hits.bind();
}

void GlRenderer::State::cast(bool new_lens) {
  const render::TileGrid grid = lens_.grid();
  const int width = grid.frame.width, height = grid.frame.height;
  OnCard& card = *on_card_;
  if (layers_cast_ > 0) {
    const bool lost = card.hits.resize(width + 2, height + 2, layers_cast_);
    find_hits(new_lens || lost);
  }
  if (layers_cast_ == 0) return;
  card.edges.resize(width, height);
  card.stencil.resize(width, height);
  target(card.edges.name(), -1);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, GL_RENDERBUFFER,
                            card.stencil.name());
  glViewport(0, 0, width, height);
  const GLint none[4] = {0, 0, 0, 0};
  glClearBufferiv(GL_COLOR, 0, none);
  glClearBufferiv(GL_STENCIL, 0, none);
  glEnable(GL_STENCIL_TEST);
  glStencilFunc(GL_ALWAYS, 1, 0xff);
  glStencilOp(GL_KEEP, GL_KEEP, GL_REPLACE);
  use(card.find_edges);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glDisable(GL_STENCIL_TEST);
  if (!area()) return;
  card.taps.resize(grid.across() * kBlocksAcross, grid.down() * kBlocksDown, tap_layers_);
  use(card.choose_taps);
  glViewport(0, 0, card.taps.width(), card.taps.height());
  for (std::size_t i = 0; i < items_.size(); ++i) {
    if (!cast_at_[i]) continue;
    uniform(card.choose_taps, "u_item", int(i));
    for (int n = 0; n < (items_[i].mask.view.empty() ? 1 : 2); ++n) {
      target(card.taps.name(), items_[i].records()[std::size_t(n)]->layer);
      uniform(card.choose_taps, "u_record", 2 * int(i) + n);
      glDrawArrays(GL_TRIANGLES, 0, 3);
    }
  }
}

void GlRenderer::State::find_hits(bool all) {
  OnCard& card = *on_card_;
  const int width = card.hits.width(), height = card.hits.height();
  card.depth.resize(width, height);
  glViewport(0, 0, width, height);
  for (std::size_t i = 0; i < items_.size(); ++i) {
    // Another item's change may have given it another layer or other numbers for its facets.
    const Item& item = items_[i];
    const std::pair<int, std::size_t> cast_for{cast_at_[i] ? item.layer : -1, item.first_facet};
    if (cast_for_.size() <= i) cast_for_.resize(i + 1, {-1, 0});
    const bool same = !all && !item.new_map && cast_for_[i] == cast_for;
    cast_for_[i] = cast_for;
    if (same || !cast_at_[i]) continue;
    target(card.hits.name(), item.layer);
    if (!layers_[i].is_mesh()) {
      use(card.find_plane_hits);
      uniform(card.find_plane_hits, "u_facet", int(item.first_facet));
      glDrawArrays(GL_TRIANGLES, 0, 3);
      continue;
    }
    use(card.find_hits);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_LESS);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, card.depth.name());
    const GLint none[4] = {-1, 0, 0, 0};
    const GLfloat far = 1;
    glClearBufferiv(GL_COLOR, 0, none);
    glClearBufferfv(GL_DEPTH, 0, &far);
    uniform(card.find_hits, "u_first_box", GLint(first_box_[i]));
    glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, GLsizei(layers_[i].room->boxes().count));
    glDisable(GL_DEPTH_TEST);
  }
}

void GlRenderer::State::draw(const Scene& scene) const {
  OnCard& card = *on_card_;
  const ImageSize frame = lens_.grid().frame;
  card.drawn.resize(frame.width, frame.height);
  target(card.drawn.name(), -1);
  glViewport(0, 0, frame.width, frame.height);
  if (layers_cast_ > 0) {
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, GL_RENDERBUFFER,
                              card.stencil.name());
    glEnable(GL_STENCIL_TEST);
    glStencilOp(GL_KEEP, GL_KEEP, GL_KEEP);
  }
  for (const bool edges : {false, true}) {
    if (edges && layers_cast_ == 0) continue;
    glStencilFunc(GL_EQUAL, edges, 0xff);
    const Program& program = edges ? card.draw_edges : card.draw;
    use(program);
    card.values.bind();
    if (layers_cast_ > 0) card.edges.bind();
    if (layers_cast_ > 0 && area()) card.taps.bind();
    const std::uint8_t* const b = scene.background;
    glUniform3i(glGetUniformLocation(program.name(), "u_background"), curve_.light(b[0]), curve_.light(b[1]),
                curve_.light(b[2]));
    uniform(program, "u_area", area());
    glDrawArrays(GL_TRIANGLES, 0, 3);
  }
  glDisable(GL_STENCIL_TEST);
}

void GlRenderer::State::copy(GLuint framebuffer, int rows) const {
  const ImageSize frame = lens_.grid().frame;
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, framebuffer);
  glViewport(0, rows - frame.height, frame.width, frame.height);
  glUseProgram(on_card_->copy.name());
  on_card_->drawn.bind();
  uniform(on_card_->copy, "u_drawn", kTapsUnit);
  uniform(on_card_->copy, "u_rows", rows);
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

void GlRenderer::State::read(ImageView<std::uint8_t> frame) {
  read_.resize(std::size_t(frame.width) * std::size_t(frame.height) * 4);
  glReadPixels(0, 0, frame.width, frame.height, GL_RGBA, GL_UNSIGNED_BYTE, read_.data());
  check("drawing");
  const auto to_rgb = render::best_kernels().values_to_rgb;
  for (int y = 0; y < frame.height; ++y)
    to_rgb(read_.data() + std::size_t(y) * std::size_t(frame.width) * 4, frame.width, frame.row(y));
}

}  // namespace procam::render_gl
