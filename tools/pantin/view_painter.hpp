#pragma once
// Paints triangles over a picture, on the processor: the panel is small, and its picture so is the
// same on every machine and needs no second OpenGL.
#include <cstdint>
#include <span>

#include "engine/render/renderer.hpp"

namespace pantin::program {

using namespace detail;

/// Laid out like the vertices of the panel's library.
struct InkVertex {
  float x, y;          // pixels, from the top left corner
  float u, v;          // in the atlas, 0..1
  std::uint32_t rgba;  // red in the lowest byte
};

/// How much of a pixel a letter covers, 0..255, rows from the top.
struct InkAtlas {
  const std::uint8_t* coverage = nullptr;
  int width = 0, height = 0;
};

/// Triangles within a rectangle of the picture. Neighbours share no pixel.
struct InkBatch {
  std::span<const InkVertex> vertices;
  std::span<const std::uint16_t> indices;  // three a triangle
  float clip[4];                           // x0, y0, x1, y1
};

void paint(Image& picture, const InkBatch& batch, const InkAtlas& atlas);

}  // namespace pantin::program
