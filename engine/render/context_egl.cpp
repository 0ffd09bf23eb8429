#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <dlfcn.h>

#include <array>
#include <cstdio>
#include <type_traits>

#include "engine/base/check.hpp"
#include "engine/render/context.hpp"

namespace pantin::detail {
namespace {

struct Egl {
  decltype(&eglGetProcAddress) get_proc_address = nullptr;
  decltype(&eglGetError) get_error = nullptr;
  decltype(&eglQueryString) query_string = nullptr;
  decltype(&eglInitialize) initialize = nullptr;
  decltype(&eglBindAPI) bind_api = nullptr;
  decltype(&eglChooseConfig) choose_config = nullptr;
  decltype(&eglCreateContext) create_context = nullptr;
  decltype(&eglDestroyContext) destroy_context = nullptr;
  decltype(&eglMakeCurrent) make_current = nullptr;
  PFNEGLGETPLATFORMDISPLAYEXTPROC get_platform_display = nullptr;
};

/// An extension list is words separated by spaces.
bool has_word(const char* list, std::string_view word) {
  if (!list) return false;
  const std::string padded_list = " " + std::string(list) + " ";
  return padded_list.find(" " + std::string(word) + " ") != std::string::npos;
}

std::string failure(const Egl& egl, const char* call) {
  std::array<char, 64> code;
  std::snprintf(code.data(), code.size(), "%s failed (EGL error 0x%04x)", call,
                static_cast<unsigned>(egl.get_error()));
  return code.data();
}

/// Empty, or why the library cannot be used. The library stays loaded, since Mesa does not survive
/// unloading.
std::string load_egl(Egl& egl, const char* library) {
  void* handle = dlopen(library, RTLD_NOW | RTLD_LOCAL);
  if (!handle) return dlerror();
  const char* missing = nullptr;
  const auto symbol = [&](auto& pointer, const char* name) {
    pointer = reinterpret_cast<std::remove_reference_t<decltype(pointer)>>(dlsym(handle, name));
    if (!pointer && !missing) missing = name;
  };
  symbol(egl.get_proc_address, "eglGetProcAddress");
  symbol(egl.get_error, "eglGetError");
  symbol(egl.query_string, "eglQueryString");
  symbol(egl.initialize, "eglInitialize");
  symbol(egl.bind_api, "eglBindAPI");
  symbol(egl.choose_config, "eglChooseConfig");
  symbol(egl.create_context, "eglCreateContext");
  symbol(egl.destroy_context, "eglDestroyContext");
  symbol(egl.make_current, "eglMakeCurrent");
  if (missing) return std::string(library) + " lacks " + missing;
  egl.get_platform_display = reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(
      egl.get_proc_address("eglGetPlatformDisplayEXT"));
  if (!egl.get_platform_display) return std::string(library) + " lacks eglGetPlatformDisplayEXT";
  return {};
}

class EglContext final : public Context {
 public:
  explicit EglContext(const Egl& egl) : egl_(egl) {}
  ~EglContext() override {
    if (context_ == EGL_NO_CONTEXT) return;
    release();
    egl_.destroy_context(display_, context_);
    // Do not terminate the display: all contexts of the process share it.
  }
  EglContext(const EglContext&) = delete;
  EglContext& operator=(const EglContext&) = delete;

  bool make_current() override {
    return egl_.bind_api(EGL_OPENGL_API) &&
           egl_.make_current(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_);
  }
  void release() override {
    egl_.make_current(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  }

  /// Empty if the context was created and is current.
  std::string open(EGLDisplay display) {
    display_ = display;
    if (display_ == EGL_NO_DISPLAY) return failure(egl_, "eglGetPlatformDisplayEXT");
    EGLint major = 0, minor = 0;
    if (!egl_.initialize(display_, &major, &minor)) return failure(egl_, "eglInitialize");
    if (!egl_.bind_api(EGL_OPENGL_API)) return failure(egl_, "eglBindAPI");
    const char* extensions = egl_.query_string(display_, EGL_EXTENSIONS);
    if (!has_word(extensions, "EGL_KHR_surfaceless_context"))
      return "EGL_KHR_surfaceless_context is not offered";
    EGLConfig config = nullptr;
    if (!has_word(extensions, "EGL_KHR_no_config_context")) {
      const EGLint wanted[] = {EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_SURFACE_TYPE, 0, EGL_NONE};
      EGLint count = 0;
      if (!egl_.choose_config(display_, wanted, &config, 1, &count) || count == 0)
        return failure(egl_, "eglChooseConfig");
    }
    const EGLint version[] = {EGL_CONTEXT_MAJOR_VERSION,
                              3,
                              EGL_CONTEXT_MINOR_VERSION,
                              3,
                              EGL_CONTEXT_OPENGL_PROFILE_MASK,
                              EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                              EGL_NONE};
    context_ = egl_.create_context(display_, config, EGL_NO_CONTEXT, version);
    if (context_ == EGL_NO_CONTEXT) return failure(egl_, "eglCreateContext for OpenGL 3.3 core");
    if (!make_current()) return failure(egl_, "eglMakeCurrent");
    if (const char* missing = load(gl, egl_.get_proc_address))
      return "the driver lacks " + std::string(missing);
    return {};
  }

 private:
  Egl egl_;
  EGLDisplay display_ = EGL_NO_DISPLAY;
  EGLContext context_ = EGL_NO_CONTEXT;
};

Result<std::unique_ptr<Context>> open_display(const Egl& egl, EGLDisplay display) {
  auto context = std::make_unique<EglContext>(egl);
  if (std::string why = context->open(display); !why.empty()) return Error{why};
  return std::unique_ptr<Context>(std::move(context));
}

/// The first device that provides a context: a GPU if there is one.
Result<std::unique_ptr<Context>> open_device(const Egl& egl) {
  const auto query_devices =
      reinterpret_cast<PFNEGLQUERYDEVICESEXTPROC>(egl.get_proc_address("eglQueryDevicesEXT"));
  if (!query_devices) return Error{"eglQueryDevicesEXT is not offered"};
  std::array<EGLDeviceEXT, 16> devices;
  EGLint count = 0;
  if (!query_devices(static_cast<EGLint>(devices.size()), devices.data(), &count))
    return Error{failure(egl, "eglQueryDevicesEXT")};
  std::string why = "no EGL device found";
  for (EGLint i = 0; i < count; ++i) {
    auto opened =
        open_display(egl, egl.get_platform_display(EGL_PLATFORM_DEVICE_EXT,
                                                   devices[static_cast<std::size_t>(i)], nullptr));
    if (opened) return opened;
    why = "device " + std::to_string(i) + ": " + opened.errors().front().message;
  }
  return Error{why};
}

}  // namespace

Result<std::unique_ptr<Context>> open_egl(GlPath path, const char* library) {
  Egl egl;
  if (std::string why = load_egl(egl, library); !why.empty()) return Error{why};
  PANTIN_ASSERT(egl.query_string && egl.get_platform_display && egl.get_proc_address);
  const char* const platform =
      path == GlPath::device ? "EGL_EXT_platform_device" : "EGL_MESA_platform_surfaceless";
  if (!has_word(egl.query_string(EGL_NO_DISPLAY, EGL_EXTENSIONS), platform))
    return Error{std::string(platform) + " is not offered"};
  if (path == GlPath::device) return open_device(egl);
  return open_display(
      egl, egl.get_platform_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr));
}

}  // namespace pantin::detail
