#pragma once
// A software rasteriser of triangles: the panel is small, so its picture can be equal on every
// machine, without a second OpenGL context.
#include <cstdint>
#include <span>

#include "engine/render/renderer.hpp"

namespace pantin::program {

using namespace detail;

/// Layout of the vertices of Dear ImGui.
struct InkVertex {
  float x, y;          // pixels, from the top left corner
  float u, v;          // in the atlas, 0..1
  std::uint32_t rgba;  // red in the lowest byte
};

/// Coverage of letters, 0..255, rows from the top.
struct InkAtlas {
  const std::uint8_t* coverage = nullptr;
  int width = 0, height = 0;
};

/// Triangles within a rectangle of the picture. Adjacent triangles share no pixel.
struct InkBatch {
  std::span<const InkVertex> vertices;
  std::span<const std::uint16_t> indices;  // three per triangle
  float clip[4];                           // x0, y0, x1, y1
};

void paint(Image& picture, const InkBatch& batch, const InkAtlas& atlas);

}  // namespace pantin::program
