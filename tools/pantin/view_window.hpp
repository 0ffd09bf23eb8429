#pragma once
// A window that shows pictures made elsewhere.
#include <SDL.h>

#include <memory>

#include "engine/base/result.hpp"
#include "engine/render/renderer.hpp"

namespace pantin::program {

using namespace detail;

/// Owns SDL, its window and the texture that pictures go through. One at a time.
class Window {
 public:
  /// Whether there must be a display; without one nobody sees the window.
  enum class Display { required, optional };
  /// Opens a window of the picture's size in pixels.
  static Result<std::unique_ptr<Window>> open(const std::string& title, int width, int height,
                                              Display display);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  /// Shows a picture, scaled if it has not the window's size.
  Result<Done> show(const Image& image);
  /// In pixels, as the user has drawn it.
  void size(int& width, int& height) const { SDL_GetWindowSize(window_, &width, &height); }
  void resize(int width, int height) { SDL_SetWindowSize(window_, width, height); }
  std::uint32_t id() const { return SDL_GetWindowID(window_); }
  /// The way to the screen that SDL has taken: x11, wayland, offscreen, dummy.
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
