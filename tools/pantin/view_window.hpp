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
  /// Opens a window of the picture's size in pixels. Without a display it opens one that nobody
  /// sees if `unseen` allows that.
  static Result<std::unique_ptr<Window>> open(const std::string& title, int width, int height,
                                              bool unseen);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  /// Shows a picture of the window's size, scaled if the user has changed that.
  Result<Done> show(const Image& image);
  std::uint32_t id() const { return SDL_GetWindowID(window_); }
  /// The way to the screen that SDL has taken: x11, wayland, offscreen, dummy.
  const std::string& driver() const { return driver_; }

 private:
  Window() = default;
  Result<Done> start(const std::string& title, int width, int height);
  SDL_Window* window_ = nullptr;
  SDL_Renderer* renderer_ = nullptr;
  SDL_Texture* texture_ = nullptr;
  std::string driver_;
};

}  // namespace pantin::program
