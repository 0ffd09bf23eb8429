#ifdef PANTIN_HAS_VIEW
#include "tools/pantin/view_window.hpp"

#include <cstdlib>

namespace pantin::program {

using namespace detail;

namespace {

bool is_set(const char* variable) {
  const char* value = std::getenv(variable);
  return value && *value;
}

Error sdl_error(const char* what) { return Error{std::string(what) + ": " + SDL_GetError()}; }

}  // namespace

Result<std::unique_ptr<Window>> Window::open(const std::string& title, int width, int height,
                                             Display display) {
  SDL_SetHint(SDL_HINT_NO_SIGNAL_HANDLERS, "1");  // the program has its own
  // Software rendering: not every display has OpenGL, and the pictures do not use the window's.
  SDL_SetHint(SDL_HINT_FRAMEBUFFER_ACCELERATION, "0");
  std::unique_ptr<Window> window(new Window);
  if (is_set("SDL_VIDEODRIVER") || is_set("DISPLAY") || is_set("WAYLAND_DISPLAY")) {
    if (auto done = window->start(title, width, height); !done) return done.errors();
    // If the display does not respond, SDL may fall back to an invisible driver.
    const bool is_unseen = window->driver_ == "offscreen" || window->driver_ == "dummy";
    if (is_unseen && display == Display::required && !is_set("SDL_VIDEODRIVER"))
      return Error{"no display: the one that DISPLAY or WAYLAND_DISPLAY names cannot be opened"};
    return window;
  }
  if (display == Display::required)
    return Error{
        "no display: DISPLAY and WAYLAND_DISPLAY are not set; with --script no display is needed"};
  std::string refused;
  for (const char* driver : {"offscreen", "dummy"}) {
    SDL_SetHint(SDL_HINT_VIDEODRIVER, driver);
    auto done = window->start(title, width, height);
    if (done) return window;
    refused += (refused.empty() ? "" : "; ") + std::string(driver) +
               " driver: " + done.errors().front().message;
    window.reset(new Window);
  }
  return Error{refused};
}

Result<Done> Window::start(const std::string& title, int width, int height) {
  if (SDL_Init(SDL_INIT_VIDEO) != 0) return sdl_error("SDL could not start");
  if (const char* driver = SDL_GetCurrentVideoDriver()) driver_ = driver;
  window_ = SDL_CreateWindow(title.c_str(), SDL_WINDOWPOS_CENTERED, SDL_WINDOWPOS_CENTERED, width,
                             height, SDL_WINDOW_RESIZABLE);
  if (!window_) return sdl_error("SDL made no window");
  renderer_ = SDL_CreateRenderer(window_, -1, SDL_RENDERER_SOFTWARE);
  if (!renderer_) return sdl_error("SDL cannot draw into its window");
  return make_texture(width, height);
}

Result<Done> Window::make_texture(int width, int height) {
  if (texture_ && width == texture_width_ && height == texture_height_) return Done{};
  if (texture_) SDL_DestroyTexture(texture_);
  texture_ = SDL_CreateTexture(renderer_, SDL_PIXELFORMAT_RGBA32, SDL_TEXTUREACCESS_STREAMING,
                               width, height);
  if (!texture_) return sdl_error("SDL made no texture");
  texture_width_ = width, texture_height_ = height;
  return Done{};
}

Window::~Window() {
  if (texture_) SDL_DestroyTexture(texture_);
  if (renderer_) SDL_DestroyRenderer(renderer_);
  if (window_) SDL_DestroyWindow(window_);
  SDL_Quit();
}

Result<Done> Window::show(const Image& image) {
  if (auto made = make_texture(image.width, image.height); !made) return made;
  if (SDL_UpdateTexture(texture_, nullptr, image.rgba.data(), image.width * 4) != 0 ||
      SDL_RenderClear(renderer_) != 0 || SDL_RenderCopy(renderer_, texture_, nullptr, nullptr) != 0)
    return sdl_error("SDL could not show a picture");
  SDL_RenderPresent(renderer_);
  return Done{};
}

}  // namespace pantin::program
#endif
