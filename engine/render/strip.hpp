#pragma once
/// A filmstrip: pictures of equal size side by side, row after row.
#include <cstddef>

#include "engine/render/renderer.hpp"

namespace pantin {

class Strip {
 public:
  /// Reserves `columns` x `rows` pictures of `width` x `height` pixels, initially white.
  Strip(int columns, int rows, int width, int height);

  std::size_t cells() const { return static_cast<std::size_t>(columns_ * rows_); }
  std::size_t filled() const { return filled_; }
  /// Copies the next picture into its cell; surplus pictures, or ones of another size, are ignored.
  void add(const Image& picture);
  const Image& image() const { return image_; }

  /// The frame of cell `cell` if `frames` frames are spread evenly over all cells, including the
  /// first and the last frame.
  std::size_t frame_of(std::size_t cell, std::size_t frames) const;

 private:
  int columns_, rows_, width_, height_;
  std::size_t filled_ = 0;
  Image image_;
};

}  // namespace pantin
