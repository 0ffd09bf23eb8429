#include "engine/render/strip.hpp"

#include <algorithm>

namespace pantin {

using namespace detail;

Strip::Strip(int columns, int rows, int width, int height)
    : columns_(columns), rows_(rows), width_(width), height_(height) {
  image_.width = columns * width, image_.height = rows * height;
  image_.rgba.assign(
      4 * static_cast<std::size_t>(image_.width) * static_cast<std::size_t>(image_.height), 255);
}

void Strip::add(const Image& picture) {
  if (filled_ == cells() || picture.width != width_ || picture.height != height_) return;
  const auto columns = static_cast<std::size_t>(columns_);
  const std::size_t line = 4 * static_cast<std::size_t>(width_), pitch = columns * line;
  const std::size_t left = filled_ % columns * line;
  const std::size_t top = filled_ / columns * static_cast<std::size_t>(height_);
  for (std::size_t y = 0; y < static_cast<std::size_t>(height_); ++y)
    std::copy_n(picture.rgba.data() + y * line, line,
                image_.rgba.data() + (top + y) * pitch + left);
  ++filled_;
}

std::size_t Strip::frame_of(std::size_t cell, std::size_t frames) const {
  if (cells() < 2 || frames < 2) return 0;
  return cell * (frames - 1) / (cells() - 1);
}

}  // namespace pantin
