#pragma once
// A window that shows finished pictures.
#include <SDL.h>

#include <memory>

#include "engine/base/result.hpp"
#include "engine/render/renderer.hpp"

namespace pantin::program {

using namespace detail;

/// Owns SDL, its window and the texture of the picture. One at a time.
class Window {
 public:
  /// Whether a display is required; without one the window is invisible.
  enum class Display { required, optional };
  /// Opens a window of the picture's size in pixels.
  static Result<std::unique_ptr<Window>> open(const std::string& title, int width, int height,
                                              Display display);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  /// Shows a picture, scaled to the window's size.
  Result<Done> show(const Image& image);
  /// In pixels, as resized by the user.
  void size(int& width, int& height) const { SDL_GetWindowSize(window_, &width, &height); }
  void set_title(const std::string& title) { SDL_SetWindowTitle(window_, title.c_str()); }
  void resize(int width, int height) { SDL_SetWindowSize(window_, width, height); }
  std::uint32_t id() const { return SDL_GetWindowID(window_); }
  /// SDL's video driver: x11, wayland, offscreen, dummy.
  const std::string& driver() const { return driver_; }

 private:
  Window() = default;
  Result<Done> start(const std::string& title, int width, int height);
  Result<Done> make_texture(int width, int height);
  SDL_Window* window_ = nullptr;
  SDL_Renderer* renderer_ = nullptr;
  SDL_Texture* texture_ = nullptr;
  int texture_width_ = 0, texture_height_ = 0;
  std::string driver_;
};

}  // namespace pantin::program
