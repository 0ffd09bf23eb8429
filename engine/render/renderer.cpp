// The passes of one picture.
#include <algorithm>
#include <array>
#include <cstring>

#include "engine/render/gl_renderer.hpp"
#include "engine/render/marks.hpp"

namespace pantin {
namespace detail {

void GlRenderer::upload(const View& view, const Eye& eye) {
  gl_.BindBuffer(GL_UNIFORM_BUFFER, frame_block_);
  gl_.BufferData(GL_UNIFORM_BUFFER, sizeof frame_.block, &frame_.block, GL_STREAM_DRAW);

  std::size_t count = 0;
  for (const auto& list : list_.solids) count += list.size();
  for (const auto& group : list_.surfaces) count += group.instances.size();
  std::vector<Instance> all;
  all.reserve(count);
  for (const auto& list : list_.solids) all.insert(all.end(), list.begin(), list.end());
  for (const auto& group : list_.surfaces)
    all.insert(all.end(), group.instances.begin(), group.instances.end());
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
  shade_ground(list_.fillings, {frame_.shade_low, frame_.shade_high, view.ground_height}, shade_);
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

/// Hulls, meshes, height fields and substitutes for other shapes, whose instances begin at `first`.
void GlRenderer::draw_surfaces(std::size_t first) {
  for (const SurfaceSolids& group : list_.surfaces) {
    const StoredSurface& stored = surfaces_.stored(group.surface, group.smooth);
    gl_.BindVertexArray(stored.array);
    gl_.BindBuffer(GL_ARRAY_BUFFER, instances_);
    point_at_instances(first);
    gl_.DrawElementsInstanced(GL_TRIANGLES, stored.count, GL_UNSIGNED_INT, nullptr,
                              static_cast<GLsizei>(group.instances.size()));
    first += group.instances.size();
  }
}

/// Draws all solids and cables, into the shadow map or into the picture.
void GlRenderer::draw_world_meshes(MeshPass pass) {
  const bool depth_only = pass == MeshPass::shadow;
  if (pass == MeshPass::wires) gl_.PolygonMode(GL_FRONT_AND_BACK, GL_LINE);
  gl_.UseProgram(depth_only ? solid_depth_ : solid_);
  gl_.Enable(GL_CULL_FACE);
  gl_.BindVertexArray(solid_array_);
  gl_.BindBuffer(GL_ARRAY_BUFFER, instances_);
  std::size_t first = 0;
  for (std::size_t m = 0; m < kMeshCount; ++m) {
    const std::size_t count = list_.solids[m].size();
    if (count == 0) continue;
    point_at_instances(first);
    // A texel of the shadow map is larger than a pixel: fewer triangles suffice.
    const bool fine = m == kRound32 || m == kRound64;
    const bool coarse = pass != MeshPass::colour;  // the wires of fine ones would merge
    const MeshRange range = meshes_.ranges[coarse && fine ? std::size_t(kRound16) : m];
    gl_.DrawElementsInstanced(GL_TRIANGLES, static_cast<GLsizei>(range.count), GL_UNSIGNED_SHORT,
                              offset(range.first * sizeof(std::uint16_t)),
                              static_cast<GLsizei>(count));
    first += count;
  }
  draw_surfaces(first);
  gl_.PolygonMode(GL_FRONT_AND_BACK, GL_FILL);
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
  scissor({1, 1, kShadowSize - 1, kShadowSize - 1});  // the border stays lit, for everything
                                                      // outside the map
  gl_.Enable(GL_DEPTH_TEST);
  gl_.Enable(GL_DEPTH_CLAMP);  // objects in front of the map's box cast shadows too
  gl_.Enable(GL_POLYGON_OFFSET_FILL);
  gl_.PolygonOffset(1.5f, 4.f);
  gl_.FrontFace(GL_CCW);
  draw_world_meshes(MeshPass::shadow);
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
  draw_world_meshes(wireframe_ ? MeshPass::wires : MeshPass::colour);
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

/// Draws the sky, and the ground outside a region. Regions meet at whole pixels, so that no pixel
/// is shaded twice.
void GlRenderer::fill_backdrop(const PixelRect& n) {
  const int width = options_.width, height = options_.height, row = frame_.ground_row;
  fill(sky_, {0, 0, width, row});
  if (n.empty()) {
    fill(far_ground_, {0, row, width, height});
    return;
  }
  fill(far_ground_, {0, row, width, n.y0});
  fill(far_ground_, {0, n.y0, n.x0, n.y1});
  fill(far_ground_, {n.x1, n.y0, width, n.y1});
  fill(far_ground_, {0, n.y1, width, height});
}

BackdropKey backdrop_key(const Frame& frame, int width, int height) {
  const FrameBlock& b = frame.block;
  BackdropKey key{};
  std::memcpy(key.ray, b.ray, sizeof key.ray);
  std::memcpy(key.horizon, b.horizon, sizeof key.horizon);
  std::memcpy(key.zenith, b.zenith, sizeof key.zenith);
  std::memcpy(key.tiles, b.tiles, sizeof key.tiles);
  std::memcpy(key.origin, b.origin, sizeof key.origin);
  std::memcpy(key.to_clip, b.viewport, sizeof key.to_clip);
  key.ground = b.soil[3];
  key.width = width, key.height = height, key.row = frame.ground_row;
  return key;
}

/// If the camera has not moved, everything except the ground near bodies is copied from the last
/// picture: in software this takes a tenth of the time.
void GlRenderer::draw_backdrop() {
  const BackdropKey key = backdrop_key(frame_, options_.width, options_.height);
  const bool is_still = key == backdrop_key_;
  backdrop_key_ = key;
  has_backdrop_ = has_backdrop_ && is_still;
  gl_.Viewport(0, 0, options_.width, options_.height);
  gl_.BindVertexArray(empty_array_);
  if (is_still) {
    gl_.BindFramebuffer(GL_FRAMEBUFFER, backdrop_target_);
    if (!has_backdrop_) fill_backdrop({});
    has_backdrop_ = true;
    gl_.BindFramebuffer(GL_DRAW_FRAMEBUFFER, picture_target_);
    scissor({0, 0, options_.width, options_.height});
    gl_.BlitFramebuffer(0, 0, options_.width, options_.height, 0, 0, options_.width,
                        options_.height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
    gl_.BindFramebuffer(GL_FRAMEBUFFER, picture_target_);
  } else {
    gl_.BindFramebuffer(GL_FRAMEBUFFER, picture_target_);
    fill_backdrop(frame_.near_ground);
  }
  fill(near_ground_, frame_.near_ground);
}

void GlRenderer::merge() {
  gl_.Enable(GL_BLEND);
  gl_.BlendFuncSeparate(GL_ONE, GL_ONE_MINUS_SRC_ALPHA, GL_ZERO, GL_ONE);
  fill(merge_, frame_.solids);
  gl_.Disable(GL_BLEND);
}

void GlRenderer::draw_overlay(const PosedWorld& scene, const Overlay& overlay, const Eye& eye) {
  overlay_.clear();
  Pen pen(overlay_, eye);
  if (overlay.joints) add_marks(scene, pen);
  if (overlay.contacts && !overlay.joints) add_contact_marks(scene, pen);
  add_forces(scene.world, overlay.forces, pen);
  add_trails(scene, overlay.trails, pen);
  add_doubts(overlay.doubts, pen);
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

void GlRenderer::draw(const Shot& shot, Image& out) {
  const PosedWorld scene{shot.world, shot.poses, shot.colours};
  const Real aspect = static_cast<Real>(options_.width) / options_.height;
  const View view = framed_view(shot.world, shot.view, aspect);
  const Eye eye = make_eye(view.camera, options_.width, options_.height);
  gather(scene, view, eye, list_);
  frame_ = make_frame(view, eye, list_);
  wireframe_ = shot.wireframe;

  context_->make_current();
  surfaces_.forget_unused();
  upload(view, eye);
  if (!frame_.solids.empty()) {
    if (options_.shadows) draw_shadows();
    draw_solids();
  }
  draw_backdrop();
  if (!frame_.solids.empty()) merge();
  const Overlay nothing;
  draw_overlay(scene, shot.overlay ? *shot.overlay : nothing, eye);

  out.width = options_.width, out.height = options_.height;
  out.rgba.resize(std::size_t(4) * options_.width * options_.height);
  gl_.BindFramebuffer(GL_READ_FRAMEBUFFER, picture_target_);
  gl_.ReadPixels(0, 0, out.width, out.height, GL_RGBA, GL_UNSIGNED_BYTE, out.rgba.data());
  context_->release();
}

}  // namespace detail

using namespace detail;

Result<std::unique_ptr<Renderer>> Renderer::create(const RenderOptions& options) {
  GlReport report;
  auto context = open_context(options.path, {}, report);
  if (!context) return context.errors();
  auto renderer = std::make_unique<GlRenderer>(std::move(*context), std::move(report), options);
  if (auto done = renderer->start(); !done) return done.errors();
  return std::unique_ptr<Renderer>(std::move(renderer));
}

}  // namespace pantin
