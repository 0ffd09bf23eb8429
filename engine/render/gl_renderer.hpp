#pragma once
/// The OpenGL renderer: set up in gl_setup.cpp, drawing in renderer.cpp.
#include <algorithm>

#include "engine/render/context.hpp"
#include "engine/render/font.hpp"
#include "engine/render/frame.hpp"
#include "engine/render/overlay.hpp"
#include "engine/render/renderer.hpp"
#include "engine/render/surface_store.hpp"

namespace pantin::detail {

inline constexpr int kLetterRows = 40;  // an em is a fortieth of the picture's height

inline const void* offset(std::size_t bytes) { return reinterpret_cast<const void*>(bytes); }

template <class T>
GLsizeiptr bytes_of(std::span<const T> items) {
  return static_cast<GLsizeiptr>(items.size_bytes());
}

/// Everything that determines sky and far ground: equal keys give equal backgrounds.
struct BackdropKey {
  float ray[3][4], horizon[4], zenith[4], tiles[2][4], origin[4], to_clip[2], ground;
  int width, height, row;
  bool operator==(const BackdropKey&) const = default;
};

/// Solids are drawn with MSAA, but only in their region. Ground and sky are filtered analytically
/// and drawn without it. Both are then blended by coverage.
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

  /// Creates all objects that persist between pictures; the context is current before, and not
  /// after.
  Result<Done> start();

  void draw(const Shot& shot, Image& out) override;
  Result<Done> resize(int width, int height) override;
  const GlReport& report() const override { return report_; }

 private:
  Result<Done> make_programs();
  Result<Done> make_targets();
  Result<Done> allocate(int width, int height);
  Result<GLuint> program(const char* vertex, const char* fragment, const std::string& defines = {});
  void set_sampler(GLuint program, const char* name, int unit);
  /// The parameters of TexImage2D for a texture, and its filter.
  struct TextureForm {
    GLint stored;  // format on the GPU
    int width, height;
    GLenum format, type;  // of `texels`
    const void* texels = nullptr;
    GLint filter;
  };
  GLuint make_texture(int unit, const TextureForm& form);
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
  enum class MeshPass { shadow, colour, wires };
  void draw_world_meshes(MeshPass pass);
  void draw_surfaces(std::size_t first);
  void point_at_instances(std::size_t first);
  void draw_backdrop();
  void fill_backdrop(const PixelRect& spared);
  void merge();
  void draw_overlay(const PosedWorld& scene, const Overlay& overlay, const Eye& eye);
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
  GLuint backdrop_target_ = 0;
  // Render targets.
  GLuint solid_colours_ = 0, solid_depths_ = 0, resolved_ = 0, picture_ = 0, backdrop_ = 0;
  int room_width_ = 0, room_height_ = 0;  // size of the targets, pixels
  bool wireframe_ = false;
  std::size_t overlay_room_ = 0;  // quads that the overlay's index buffer can address

  // While the camera is static, sky and far ground are copied from the last picture.
  BackdropKey backdrop_key_{};
  bool has_backdrop_ = false;  // backdrop_ matches the key

  DrawList list_;
  Frame frame_;
  std::vector<std::uint8_t> shade_;
  std::vector<std::uint32_t> overlay_indices_;
};

enum TextureUnit : int {
  kShadowUnit,
  kShadeUnit,
  kSolidsUnit,
  kAtlasUnit,
  kPictureUnit,
  kBackdropUnit
};

}  // namespace pantin::detail
