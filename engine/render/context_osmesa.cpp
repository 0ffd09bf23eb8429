#include <dlfcn.h>

#include <array>
#include <cstdint>
#include <type_traits>

#include "engine/render/context.hpp"

namespace pantin::detail {
namespace {

// Declarations of OSMesa, without its header: that one includes the GL header of the compatibility
// profile, which conflicts with glcorearb.h.
using OsMesaContext = void*;
constexpr int kOsMesaFormat = 0x22, kOsMesaProfile = 0x33, kOsMesaCoreProfile = 0x34;
constexpr int kOsMesaMajor = 0x36, kOsMesaMinor = 0x37;

struct OsMesa {
  OsMesaContext (*create_context)(const int* attributes, OsMesaContext shared) = nullptr;
  void (*destroy_context)(OsMesaContext) = nullptr;
  unsigned char (*make_current)(OsMesaContext, void* buffer, GLenum type, GLsizei width,
                                GLsizei height) = nullptr;
  GlAddress (*get_proc_address)(const char* name) = nullptr;
};

class OsMesaOffscreen final : public Context {
 public:
  explicit OsMesaOffscreen(const OsMesa& osmesa) : osmesa_(osmesa) {}
  ~OsMesaOffscreen() override {
    if (!context_) return;
    release();
    osmesa_.destroy_context(context_);
  }
  OsMesaOffscreen(const OsMesaOffscreen&) = delete;
  OsMesaOffscreen& operator=(const OsMesaOffscreen&) = delete;

  bool make_current() override {
    // OSMesa requires a colour buffer of its own; nothing is drawn to it.
    return osmesa_.make_current(context_, unused_.data(), GL_UNSIGNED_BYTE, kSide, kSide) != 0;
  }
  void release() override { osmesa_.make_current(nullptr, nullptr, GL_UNSIGNED_BYTE, 0, 0); }

  std::string open() {
    const int attributes[] = {kOsMesaFormat,
                              GL_RGBA,
                              kOsMesaProfile,
                              kOsMesaCoreProfile,
                              kOsMesaMajor,
                              3,
                              kOsMesaMinor,
                              3,
                              0};
    context_ = osmesa_.create_context(attributes, nullptr);
    if (!context_) return "OSMesaCreateContextAttribs refused OpenGL 3.3 core";
    if (!make_current()) return "OSMesaMakeCurrent failed";
    if (const char* missing = load(gl, osmesa_.get_proc_address))
      return "the driver lacks " + std::string(missing);
    return {};
  }

 private:
  static constexpr int kSide = 16;
  OsMesa osmesa_;
  OsMesaContext context_ = nullptr;
  std::array<std::uint8_t, kSide * kSide * 4> unused_{};
};

}  // namespace

Result<std::unique_ptr<Context>> open_osmesa(const char* library) {
  void* handle = dlopen(library, RTLD_NOW | RTLD_LOCAL);
  if (!handle) return Error{dlerror()};
  OsMesa osmesa;
  const char* missing = nullptr;
  const auto symbol = [&](auto& pointer, const char* name) {
    pointer = reinterpret_cast<std::remove_reference_t<decltype(pointer)>>(dlsym(handle, name));
    if (!pointer && !missing) missing = name;
  };
  symbol(osmesa.create_context, "OSMesaCreateContextAttribs");
  symbol(osmesa.destroy_context, "OSMesaDestroyContext");
  symbol(osmesa.make_current, "OSMesaMakeCurrent");
  symbol(osmesa.get_proc_address, "OSMesaGetProcAddress");
  if (missing) return Error{std::string(library) + " lacks " + missing};
  auto context = std::make_unique<OsMesaOffscreen>(osmesa);
  if (std::string why = context->open(); !why.empty()) return Error{why};
  return std::unique_ptr<Context>(std::move(context));
}

}  // namespace pantin::detail
