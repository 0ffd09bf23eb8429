#pragma once
/// A filmstrip: pictures of one size side by side, row after row.
#include <cstddef>

#include "engine/render/renderer.hpp"

namespace pantin {

class Strip {
 public:
  /// Room for `columns` x `rows` pictures of `width` x `height` pixels, white at first.
  Strip(int columns, int rows, int width, int height);

  std::size_t cells() const { return static_cast<std::size_t>(columns_ * rows_); }
  std::size_t filled() const { return filled_; }
  /// Puts the next picture in its cell; one too many, or one of another size, is left out.
  void add(const Image& picture);
  const Image& image() const { return image_; }

  /// The frame that cell `cell` shows when `frames` frames are spread over all cells, the first and
  /// the last included.
  std::size_t frame_of(std::size_t cell, std::size_t frames) const;

 private:
  int columns_, rows_, width_, height_;
  std::size_t filled_ = 0;
  Image image_;
};

}  // namespace pantin
