// Creates the persistent objects of the renderer: programs, targets, buffers.
#include <array>

#include "engine/render/gl_renderer.hpp"
#include "engine/render/shaders.hpp"

namespace pantin::detail {

Result<GLuint> GlRenderer::program(const char* vertex, const char* fragment,
                                   const std::string& defines) {
  auto made = make_program(gl_, defines, vertex, fragment);
  if (!made) return made;
  const GLuint block = gl_.GetUniformBlockIndex(*made, "Frame");
  if (block != GL_INVALID_INDEX) gl_.UniformBlockBinding(*made, block, 0);
  set_sampler(*made, "shadow_map", kShadowUnit);
  set_sampler(*made, "contact_shade", kShadeUnit);
  set_sampler(*made, "solids", kSolidsUnit);
  set_sampler(*made, "atlas", kAtlasUnit);
  return made;
}

void GlRenderer::set_sampler(GLuint program, const char* name, int unit) {
  const GLint at = gl_.GetUniformLocation(program, name);
  if (at < 0) return;
  gl_.UseProgram(program);
  gl_.Uniform1i(at, unit);
}

Result<Done> GlRenderer::make_programs() {
  const std::string shadows = options_.shadows ? "#define SHADOWS\n" : "";
  const std::string ribbon =
      "#define RIBBON\n#define STRING_RADIUS " + std::to_string(kStringRadius) + "\n";
  const std::string line = "#define LINE 0.014\n";
  struct Wanted {
    GLuint* to;
    const char *vertex, *fragment;
    std::string defines;
  };
  const Wanted all[] = {
      {&solid_, kSolidVertex, kSurfaceFragment, shadows},
      {&ribbon_, kRibbonVertex, kSurfaceFragment, ribbon},
      {&solid_depth_, kSolidVertex, kDepthFragment, "#define DEPTH\n"},
      {&ribbon_depth_, kRibbonVertex, kDepthFragment, "#define DEPTH\n" + ribbon},
      {&sky_, kScreenVertex, kSkyFragment, ""},
      {&far_ground_, kScreenVertex, kGroundFragment, line},
      {&near_ground_, kScreenVertex, kGroundFragment, "#define NEAR\n" + line + shadows},
      {&merge_, kScreenVertex, kMergeFragment, ""},
      {&paint_, kOverlayVertex, kOverlayFragment, ""},
  };
  for (const Wanted& wanted : all) {
    auto made = program(wanted.vertex, wanted.fragment, wanted.defines);
    if (!made) return made.errors();
    *wanted.to = *made;
  }
  return Done{};
}

GLuint GlRenderer::make_texture(int unit, const TextureForm& form) {
  GLuint name = 0;
  gl_.GenTextures(1, &name);
  gl_.ActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
  gl_.BindTexture(GL_TEXTURE_2D, name);
  gl_.TexImage2D(GL_TEXTURE_2D, 0, form.stored, form.width, form.height, 0, form.format, form.type,
                 form.texels);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, form.filter);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, form.filter);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  return name;
}

/// Allocates targets for pictures up to this size; changes texture bindings.
Result<Done> GlRenderer::allocate(int width, int height) {
  GLint most = 0, samples = 0;
  gl_.GetIntegerv(GL_MAX_RENDERBUFFER_SIZE, &most);
  if (width < 1 || height < 1 || width > most || height > most)
    return Error{"picture size: found " + std::to_string(width) + "x" + std::to_string(height) +
                 ", expected 1 to " + std::to_string(most) + " pixels a side"};
  gl_.GetIntegerv(GL_MAX_SAMPLES, &samples);
  samples = std::min<GLint>(samples, options_.samples);
  if (samples < 2) samples = 0;
  report_.samples = std::max(samples, 1);
  const auto renderbuffer = [&](GLuint name, GLenum form) {
    gl_.BindRenderbuffer(GL_RENDERBUFFER, name);
    gl_.RenderbufferStorageMultisample(GL_RENDERBUFFER, samples, form, width, height);
  };
  renderbuffer(solid_colours_, GL_RGBA8);
  renderbuffer(solid_depths_, GL_DEPTH_COMPONENT24);
  const auto texture = [&](int unit, GLuint name) {
    gl_.ActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
    gl_.BindTexture(GL_TEXTURE_2D, name);
    gl_.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, width, height, 0, GL_RGBA, GL_UNSIGNED_BYTE,
                   nullptr);
  };
  texture(kSolidsUnit, resolved_);
  texture(kPictureUnit, picture_);
  texture(kBackdropUnit, backdrop_);
  has_backdrop_ = false;
  room_width_ = width, room_height_ = height;
  return Done{};
}

Result<Done> GlRenderer::resize(int width, int height) {
  const bool fits = width <= room_width_ && height <= room_height_ && width > 0 && height > 0;
  if (!fits) {
    context_->make_current();
    auto done = allocate(width, height);
    context_->release();
    if (!done) return done;
  }
  options_.width = width, options_.height = height;
  return Done{};
}

Result<Done> GlRenderer::make_targets() {
  const auto target = [&](GLuint& name) {
    gl_.GenFramebuffers(1, &name);
    gl_.BindFramebuffer(GL_FRAMEBUFFER, name);
  };
  const auto whole = [&](const char* what) -> Result<Done> {
    if (gl_.CheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE) return Done{};
    return Error{std::string("the driver refuses the target of ") + what};
  };
  const TextureForm colours{.stored = GL_RGBA8,
                            .width = 1,
                            .height = 1,
                            .format = GL_RGBA,
                            .type = GL_UNSIGNED_BYTE,
                            .filter = GL_NEAREST};
  gl_.GenRenderbuffers(1, &solid_colours_);
  gl_.GenRenderbuffers(1, &solid_depths_);
  resolved_ = make_texture(kSolidsUnit, colours);
  picture_ = make_texture(kPictureUnit, colours);
  backdrop_ = make_texture(kBackdropUnit, colours);
  if (auto done = allocate(options_.width, options_.height); !done) return done;

  target(solid_target_);
  gl_.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER,
                              solid_colours_);
  gl_.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, solid_depths_);
  if (auto done = whole("solids"); !done) return done;

  target(resolved_target_);
  gl_.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, resolved_, 0);
  if (auto done = whole("resolved solids"); !done) return done;

  target(picture_target_);
  gl_.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, picture_, 0);
  if (auto done = whole("the picture"); !done) return done;

  target(backdrop_target_);
  gl_.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, backdrop_, 0);
  if (auto done = whole("sky and ground"); !done) return done;

  if (!options_.shadows) return Done{};
  target(shadow_target_);
  const GLuint shadow = make_texture(kShadowUnit, {.stored = GL_DEPTH_COMPONENT24,
                                                   .width = kShadowSize,
                                                   .height = kShadowSize,
                                                   .format = GL_DEPTH_COMPONENT,
                                                   .type = GL_UNSIGNED_INT,
                                                   .filter = GL_LINEAR});
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
  gl_.FramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, shadow, 0);
  gl_.DrawBuffer(GL_NONE);
  gl_.ReadBuffer(GL_NONE);
  return whole("shadows");
}

void GlRenderer::make_meshes_buffers() {
  const auto attribute = [&](GLuint index, GLint count, std::size_t stride, std::size_t at) {
    gl_.EnableVertexAttribArray(index);
    gl_.VertexAttribPointer(index, count, GL_FLOAT, GL_FALSE, static_cast<GLsizei>(stride),
                            offset(at));
  };
  gl_.GenVertexArrays(1, &empty_array_);
  gl_.GenVertexArrays(1, &solid_array_);
  gl_.BindVertexArray(solid_array_);
  buffer(GL_ARRAY_BUFFER);
  gl_.BufferData(GL_ARRAY_BUFFER, bytes_of(std::span<const MeshVertex>(meshes_.vertices)),
                 meshes_.vertices.data(), GL_STATIC_DRAW);
  attribute(0, 3, sizeof(MeshVertex), offsetof(MeshVertex, corner));
  attribute(1, 3, sizeof(MeshVertex), offsetof(MeshVertex, normal));
  buffer(GL_ELEMENT_ARRAY_BUFFER);
  gl_.BufferData(GL_ELEMENT_ARRAY_BUFFER, bytes_of(std::span<const std::uint16_t>(meshes_.indices)),
                 meshes_.indices.data(), GL_STATIC_DRAW);
  for (GLuint index = 2; index < 6; ++index) {
    gl_.EnableVertexAttribArray(index);
    gl_.VertexAttribDivisor(index, 1);
  }
  instances_ = buffer(GL_ARRAY_BUFFER);

  gl_.GenVertexArrays(1, &ribbon_array_);
  gl_.BindVertexArray(ribbon_array_);
  ribbon_buffer_ = buffer(GL_ARRAY_BUFFER);
  attribute(0, 3, sizeof(RibbonVertex), offsetof(RibbonVertex, position));
  attribute(1, 3, sizeof(RibbonVertex), offsetof(RibbonVertex, tangent));
  attribute(2, 1, sizeof(RibbonVertex), offsetof(RibbonVertex, side));
  buffer(GL_ELEMENT_ARRAY_BUFFER);

  gl_.GenVertexArrays(1, &overlay_array_);
  gl_.BindVertexArray(overlay_array_);
  overlay_buffer_ = buffer(GL_ARRAY_BUFFER);
  attribute(0, 2, sizeof(OverlayVertex), offsetof(OverlayVertex, pixel));
  attribute(1, 2, sizeof(OverlayVertex), offsetof(OverlayVertex, local));
  attribute(2, 4, sizeof(OverlayVertex), offsetof(OverlayVertex, form));
  attribute(3, 4, sizeof(OverlayVertex), offsetof(OverlayVertex, colour));
  buffer(GL_ELEMENT_ARRAY_BUFFER);
}

Result<Done> GlRenderer::start() {
  if (auto done = make_targets(); !done) return done;
  if (auto done = make_programs(); !done) return done;
  make_meshes_buffers();
  gl_.PixelStorei(GL_UNPACK_ALIGNMENT, 1);
  gl_.PixelStorei(GL_PACK_ALIGNMENT, 1);
  make_texture(kAtlasUnit, {.stored = GL_R8,
                            .width = font_.atlas_width,
                            .height = font_.atlas_height,
                            .format = GL_RED,
                            .type = GL_UNSIGNED_BYTE,
                            .texels = font_.atlas.data(),
                            .filter = GL_LINEAR});
  shade_map_ = make_texture(kShadeUnit, {.stored = GL_R8,
                                         .width = kShadeSize,
                                         .height = kShadeSize,
                                         .format = GL_RED,
                                         .type = GL_UNSIGNED_BYTE,
                                         .filter = GL_LINEAR});
  frame_block_ = buffer(GL_UNIFORM_BUFFER);
  gl_.BindBufferBase(GL_UNIFORM_BUFFER, 0, frame_block_);
  gl_.Enable(GL_SCISSOR_TEST);
  gl_.FrontFace(GL_CW);  // the picture's first row is the lowest one in OpenGL
  context_->release();
  return Done{};
}

}  // namespace pantin::detail
