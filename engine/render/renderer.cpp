#include "engine/render/renderer.hpp"

#include <algorithm>
#include <array>

#include "engine/render/context.hpp"
#include "engine/render/font.hpp"
#include "engine/render/frame.hpp"
#include "engine/render/marks.hpp"
#include "engine/render/shaders.hpp"
#include "engine/render/surface_store.hpp"

namespace pantin {

using namespace detail;

namespace {

constexpr int kLetterRows = 40;  // an em is a fortieth of the picture's height

const void* offset(std::size_t bytes) { return reinterpret_cast<const void*>(bytes); }

template <class T>
GLsizeiptr bytes_of(std::span<const T> items) {
  return static_cast<GLsizeiptr>(items.size_bytes());
}

/// Solids are drawn with MSAA, but only where there are some; ground and sky filter themselves and
/// are drawn without. The two pictures are then merged by coverage.
class GlRenderer final : public Renderer {
 public:
  GlRenderer(std::unique_ptr<Context> context, GlReport report, const RenderOptions& options)
      : context_(std::move(context)),
        gl_(context_->gl),
        report_(std::move(report)),
        options_(options),
        surfaces_(gl_),
        font_(load_font(usual_fonts(), std::clamp(options.height / kLetterRows, 11, 64))),
        overlay_(font_) {
    report_.font = font_.source;
  }
  GlRenderer(const GlRenderer&) = delete;
  GlRenderer& operator=(const GlRenderer&) = delete;

  /// Makes everything that outlives a picture; the context is current before and not after.
  Result<Done> start();

  void draw(const World& world, std::span<const Pose> poses, const View& view,
            const Overlay& overlay, Image& out) override;
  const GlReport& report() const override { return report_; }

 private:
  Result<Done> make_programs();
  Result<Done> make_targets();
  Result<GLuint> program(const char* vertex, const char* fragment, const std::string& defines = {});
  void set_sampler(GLuint program, const char* name, int unit);
  GLuint texture(int unit, GLint form, int width, int height, GLenum format, GLenum type,
                 const void* texels, GLint filter);
  GLuint buffer(GLenum kind) {
    GLuint name = 0;
    gl_.GenBuffers(1, &name);
    gl_.BindBuffer(kind, name);
    return name;
  }
  void make_meshes_buffers();

  void upload(const View& view, const Eye& eye);
  void draw_shadows();
  void draw_solids();
  void draw_world_meshes(bool depth_only);
  void draw_surfaces(std::size_t first);
  void point_at_instances(std::size_t first);
  void draw_backdrop();
  void merge();
  void draw_overlay(const World& world, std::span<const Pose> poses, const Overlay& overlay,
                    const Eye& eye);
  void scissor(const PixelRect& rect) {
    gl_.Scissor(rect.x0, rect.y0, rect.width(), rect.height());
  }
  void fill(GLuint program, const PixelRect& rect);

  std::unique_ptr<Context> context_;
  const Gl& gl_;
  GlReport report_;
  RenderOptions options_;
  SurfaceStore surfaces_;
  Font font_;
  OverlayList overlay_;
  Meshes meshes_ = make_meshes();

  GLuint solid_ = 0, ribbon_ = 0, solid_depth_ = 0, ribbon_depth_ = 0;
  GLuint sky_ = 0, far_ground_ = 0, near_ground_ = 0, merge_ = 0, paint_ = 0;
  GLuint frame_block_ = 0, instances_ = 0, ribbon_buffer_ = 0, overlay_buffer_ = 0;
  GLuint empty_array_ = 0, solid_array_ = 0, ribbon_array_ = 0, overlay_array_ = 0;
  GLuint shade_map_ = 0;
  GLuint shadow_target_ = 0, solid_target_ = 0, resolved_target_ = 0, picture_target_ = 0;
  std::size_t overlay_room_ = 0;  // quads that the overlay's indices can name

  DrawList list_;
  Frame frame_;
  std::vector<std::uint8_t> shade_;
  std::vector<std::uint32_t> overlay_indices_;
};

enum TextureUnit : int { kShadowUnit, kShadeUnit, kSolidsUnit, kAtlasUnit, kPictureUnit };

}  // namespace

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

GLuint GlRenderer::texture(int unit, GLint form, int width, int height, GLenum format, GLenum type,
                           const void* texels, GLint filter) {
  GLuint name = 0;
  gl_.GenTextures(1, &name);
  gl_.ActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
  gl_.BindTexture(GL_TEXTURE_2D, name);
  gl_.TexImage2D(GL_TEXTURE_2D, 0, form, width, height, 0, format, type, texels);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, filter);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, filter);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  return name;
}

Result<Done> GlRenderer::make_targets() {
  const int width = options_.width, height = options_.height;
  GLint most = 0, samples = 0;
  gl_.GetIntegerv(GL_MAX_RENDERBUFFER_SIZE, &most);
  if (width < 1 || height < 1 || width > most || height > most)
    return Error{"picture size: found " + std::to_string(width) + "x" + std::to_string(height) +
                 ", expected 1 to " + std::to_string(most) + " pixels a side"};
  gl_.GetIntegerv(GL_MAX_SAMPLES, &samples);
  samples = std::min<GLint>(samples, options_.samples);
  if (samples < 2) samples = 0;
  report_.samples = std::max(samples, 1);

  const auto target = [&](GLuint& name) {
    gl_.GenFramebuffers(1, &name);
    gl_.BindFramebuffer(GL_FRAMEBUFFER, name);
  };
  const auto whole = [&](const char* what) -> Result<Done> {
    if (gl_.CheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE) return Done{};
    return Error{std::string("the driver refuses the target of ") + what};
  };
  const auto renderbuffer = [&](GLenum form, GLenum point) {
    GLuint name = 0;
    gl_.GenRenderbuffers(1, &name);
    gl_.BindRenderbuffer(GL_RENDERBUFFER, name);
    gl_.RenderbufferStorageMultisample(GL_RENDERBUFFER, samples, form, width, height);
    gl_.FramebufferRenderbuffer(GL_FRAMEBUFFER, point, GL_RENDERBUFFER, name);
  };

  target(solid_target_);
  renderbuffer(GL_RGBA8, GL_COLOR_ATTACHMENT0);
  renderbuffer(GL_DEPTH_COMPONENT24, GL_DEPTH_ATTACHMENT);
  if (auto done = whole("solids"); !done) return done;

  target(resolved_target_);
  const GLuint resolved =
      texture(kSolidsUnit, GL_RGBA8, width, height, GL_RGBA, GL_UNSIGNED_BYTE, nullptr, GL_NEAREST);
  gl_.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, resolved, 0);
  if (auto done = whole("resolved solids"); !done) return done;

  target(picture_target_);
  const GLuint picture = texture(kPictureUnit, GL_RGBA8, width, height, GL_RGBA, GL_UNSIGNED_BYTE,
                                 nullptr, GL_NEAREST);
  gl_.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, picture, 0);
  if (auto done = whole("the picture"); !done) return done;

  if (!options_.shadows) return Done{};
  target(shadow_target_);
  const GLuint shadow = texture(kShadowUnit, GL_DEPTH_COMPONENT24, kShadowSize, kShadowSize,
                                GL_DEPTH_COMPONENT, GL_UNSIGNED_INT, nullptr, GL_LINEAR);
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
  attribute(0, 3, sizeof(RibbonVertex), offsetof(RibbonVertex, place));
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
  texture(kAtlasUnit, GL_R8, font_.atlas_width, font_.atlas_height, GL_RED, GL_UNSIGNED_BYTE,
          font_.atlas.data(), GL_LINEAR);
  shade_map_ = texture(kShadeUnit, GL_R8, kShadeSize, kShadeSize, GL_RED, GL_UNSIGNED_BYTE, nullptr,
                       GL_LINEAR);
  frame_block_ = buffer(GL_UNIFORM_BUFFER);
  gl_.BindBufferBase(GL_UNIFORM_BUFFER, 0, frame_block_);
  gl_.Enable(GL_SCISSOR_TEST);
  gl_.FrontFace(GL_CW);  // the picture's first row is the lowest one for OpenGL
  context_->release();
  return Done{};
}

void GlRenderer::upload(const View& view, const Eye& eye) {
  gl_.BindBuffer(GL_UNIFORM_BUFFER, frame_block_);
  gl_.BufferData(GL_UNIFORM_BUFFER, sizeof frame_.block, &frame_.block, GL_STREAM_DRAW);

  std::size_t count = 0;
  for (const auto& list : list_.solids) count += list.size();
  for (const auto& group : list_.surfaces) count += group.instances.size();
  std::vector<Instance> all;
  all.reserve(count);
  for (const auto& list : list_.solids) all.insert(all.end(), list.begin(), list.end());
  for (const auto& [surface, list] : list_.surfaces)
    all.insert(all.end(), list.begin(), list.end());
  gl_.BindBuffer(GL_ARRAY_BUFFER, instances_);
  gl_.BufferData(GL_ARRAY_BUFFER, bytes_of(std::span<const Instance>(all)), all.data(),
                 GL_STREAM_DRAW);

  gl_.BindBuffer(GL_ARRAY_BUFFER, ribbon_buffer_);
  gl_.BufferData(GL_ARRAY_BUFFER, bytes_of(std::span<const RibbonVertex>(list_.ribbon)),
                 list_.ribbon.data(), GL_STREAM_DRAW);
  gl_.BindVertexArray(ribbon_array_);
  gl_.BufferData(GL_ELEMENT_ARRAY_BUFFER,
                 bytes_of(std::span<const std::uint32_t>(list_.ribbon_indices)),
                 list_.ribbon_indices.data(), GL_STREAM_DRAW);

  if (frame_.ground_row >= eye.height || !(frame_.shade_low.x < frame_.shade_high.x)) return;
  shade_ground(list_.fillings, frame_.shade_low, frame_.shade_high, view.ground_height, shade_);
  gl_.ActiveTexture(GL_TEXTURE0 + kShadeUnit);
  gl_.TexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, kShadeSize, kShadeSize, GL_RED, GL_UNSIGNED_BYTE,
                    shade_.data());
}

/// Sets the attributes of instances for the vertex array that is bound.
void GlRenderer::point_at_instances(std::size_t first) {
  for (GLuint part = 0; part < 4; ++part)
    gl_.VertexAttribPointer(2 + part, 4, GL_FLOAT, GL_FALSE, sizeof(Instance),
                            offset(first * sizeof(Instance) + 16 * part));
}

/// Hulls, meshes and height fields, whose instances begin at `first`.
void GlRenderer::draw_surfaces(std::size_t first) {
  for (const auto& [surface, list] : list_.surfaces) {
    const StoredSurface& stored = surfaces_.stored(surface);
    gl_.BindVertexArray(stored.array);
    gl_.BindBuffer(GL_ARRAY_BUFFER, instances_);
    point_at_instances(first);
    gl_.DrawElementsInstanced(GL_TRIANGLES, stored.count, GL_UNSIGNED_INT, nullptr,
                              static_cast<GLsizei>(list.size()));
    first += list.size();
  }
}

/// All solids and cables, into the shadow map or into the picture.
void GlRenderer::draw_world_meshes(bool depth_only) {
  gl_.UseProgram(depth_only ? solid_depth_ : solid_);
  gl_.Enable(GL_CULL_FACE);
  gl_.BindVertexArray(solid_array_);
  gl_.BindBuffer(GL_ARRAY_BUFFER, instances_);
  std::size_t first = 0;
  for (std::size_t m = 0; m < kMeshCount; ++m) {
    const std::size_t count = list_.solids[m].size();
    if (count == 0) continue;
    point_at_instances(first);
    // A texel of the shadow map is coarser than a pixel: fewer triangles do.
    const bool fine = m == kRound32 || m == kRound64;
    const MeshRange range = meshes_.ranges[depth_only && fine ? std::size_t(kRound16) : m];
    gl_.DrawElementsInstanced(GL_TRIANGLES, static_cast<GLsizei>(range.count), GL_UNSIGNED_SHORT,
                              offset(range.first * sizeof(std::uint16_t)),
                              static_cast<GLsizei>(count));
    first += count;
  }
  draw_surfaces(first);
  if (list_.ribbon_indices.empty()) return;
  gl_.UseProgram(depth_only ? ribbon_depth_ : ribbon_);
  gl_.Disable(GL_CULL_FACE);
  gl_.BindVertexArray(ribbon_array_);
  gl_.DrawElements(GL_TRIANGLES, static_cast<GLsizei>(list_.ribbon_indices.size()), GL_UNSIGNED_INT,
                   nullptr);
}

void GlRenderer::draw_shadows() {
  gl_.BindFramebuffer(GL_FRAMEBUFFER, shadow_target_);
  gl_.Viewport(0, 0, kShadowSize, kShadowSize);
  scissor({0, 0, kShadowSize, kShadowSize});
  gl_.Clear(GL_DEPTH_BUFFER_BIT);
  scissor({1, 1, kShadowSize - 1, kShadowSize - 1});  // the border stays lit: all beyond shows it
  gl_.Enable(GL_DEPTH_TEST);
  gl_.Enable(GL_DEPTH_CLAMP);  // what stands before the map's box casts shadows into it
  gl_.Enable(GL_POLYGON_OFFSET_FILL);
  gl_.PolygonOffset(1.5f, 4.f);
  gl_.FrontFace(GL_CCW);
  draw_world_meshes(true);
  gl_.FrontFace(GL_CW);
  gl_.Disable(GL_POLYGON_OFFSET_FILL);
  gl_.Disable(GL_DEPTH_CLAMP);
}

void GlRenderer::draw_solids() {
  gl_.BindFramebuffer(GL_FRAMEBUFFER, solid_target_);
  gl_.Viewport(0, 0, options_.width, options_.height);
  scissor(frame_.solids);
  gl_.ClearColor(0, 0, 0, 0);
  gl_.Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  gl_.Enable(GL_DEPTH_TEST);
  if (frame_.clips_ground) gl_.Enable(GL_CLIP_DISTANCE0);
  draw_world_meshes(false);
  gl_.Disable(GL_CLIP_DISTANCE0);
  gl_.Disable(GL_CULL_FACE);
  gl_.Disable(GL_DEPTH_TEST);
  const PixelRect& r = frame_.solids;
  gl_.BindFramebuffer(GL_READ_FRAMEBUFFER, solid_target_);
  gl_.BindFramebuffer(GL_DRAW_FRAMEBUFFER, resolved_target_);
  gl_.BlitFramebuffer(r.x0, r.y0, r.x1, r.y1, r.x0, r.y0, r.x1, r.y1, GL_COLOR_BUFFER_BIT,
                      GL_NEAREST);
}

void GlRenderer::fill(GLuint program, const PixelRect& rect) {
  if (rect.empty()) return;
  scissor(rect);
  gl_.UseProgram(program);
  gl_.DrawArrays(GL_TRIANGLES, 0, 3);
}

/// Sky and ground lie side by side in whole pixels, so that no pixel is shaded twice.
void GlRenderer::draw_backdrop() {
  gl_.BindFramebuffer(GL_FRAMEBUFFER, picture_target_);
  gl_.Viewport(0, 0, options_.width, options_.height);
  gl_.BindVertexArray(empty_array_);
  const int width = options_.width, height = options_.height, row = frame_.ground_row;
  const PixelRect n = frame_.near_ground;
  fill(sky_, {0, 0, width, row});
  if (n.empty()) {
    fill(far_ground_, {0, row, width, height});
    return;
  }
  fill(near_ground_, n);
  fill(far_ground_, {0, row, width, n.y0});
  fill(far_ground_, {0, n.y0, n.x0, n.y1});
  fill(far_ground_, {n.x1, n.y0, width, n.y1});
  fill(far_ground_, {0, n.y1, width, height});
}

void GlRenderer::merge() {
  gl_.Enable(GL_BLEND);
  gl_.BlendFuncSeparate(GL_ONE, GL_ONE_MINUS_SRC_ALPHA, GL_ZERO, GL_ONE);
  fill(merge_, frame_.solids);
  gl_.Disable(GL_BLEND);
}

void GlRenderer::draw_overlay(const World& world, std::span<const Pose> poses,
                              const Overlay& overlay, const Eye& eye) {
  overlay_.clear();
  if (overlay.joints) {
    Pen pen(overlay_, eye);
    add_marks({world, poses}, pen);
  }
  overlay_.add_labels(overlay, eye);
  const auto vertices = overlay_.vertices();
  if (vertices.empty()) return;
  gl_.BindVertexArray(overlay_array_);
  gl_.BindBuffer(GL_ARRAY_BUFFER, overlay_buffer_);
  gl_.BufferData(GL_ARRAY_BUFFER, bytes_of(vertices), vertices.data(), GL_STREAM_DRAW);
  const std::size_t quads = vertices.size() / 4;
  if (quads > overlay_room_) {
    overlay_room_ = quads;
    overlay_indices_.clear();
    for (std::uint32_t q = 0; q < quads; ++q)
      for (std::uint32_t corner : {0u, 1u, 2u, 0u, 2u, 3u})
        overlay_indices_.push_back(4 * q + corner);
    gl_.BufferData(GL_ELEMENT_ARRAY_BUFFER,
                   bytes_of(std::span<const std::uint32_t>(overlay_indices_)),
                   overlay_indices_.data(), GL_STATIC_DRAW);
  }
  scissor({0, 0, options_.width, options_.height});
  gl_.Enable(GL_BLEND);
  gl_.BlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ZERO, GL_ONE);
  gl_.UseProgram(paint_);
  gl_.DrawElements(GL_TRIANGLES, static_cast<GLsizei>(6 * quads), GL_UNSIGNED_INT, nullptr);
  gl_.Disable(GL_BLEND);
}

void GlRenderer::draw(const World& world, std::span<const Pose> poses, const View& view,
                      const Overlay& overlay, Image& out) {
  const Real aspect = static_cast<Real>(options_.width) / options_.height;
  const Camera camera = view.camera.automatic ? framing_camera(world, view, aspect) : view.camera;
  const Eye eye = make_eye(camera, options_.width, options_.height);
  gather(world, poses, view, eye, list_);
  frame_ = make_frame(view, eye, list_);

  context_->make_current();
  surfaces_.forget_unused();
  upload(view, eye);
  if (!frame_.solids.empty()) {
    if (options_.shadows) draw_shadows();
    draw_solids();
  }
  draw_backdrop();
  if (!frame_.solids.empty()) merge();
  draw_overlay(world, poses, overlay, eye);

  out.width = options_.width, out.height = options_.height;
  out.rgba.resize(std::size_t(4) * options_.width * options_.height);
  gl_.BindFramebuffer(GL_READ_FRAMEBUFFER, picture_target_);
  gl_.ReadPixels(0, 0, out.width, out.height, GL_RGBA, GL_UNSIGNED_BYTE, out.rgba.data());
  context_->release();
}

Result<std::unique_ptr<Renderer>> Renderer::create(const RenderOptions& options) {
  GlReport report;
  auto context = open_context(options.path, {}, report);
  if (!context) return context.errors();
  auto renderer = std::make_unique<GlRenderer>(std::move(*context), std::move(report), options);
  if (auto done = renderer->start(); !done) return done.errors();
  return std::unique_ptr<Renderer>(std::move(renderer));
}

}  // namespace pantin
