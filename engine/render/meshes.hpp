#pragma once
/// The meshes from which all shapes are drawn.
#include <array>
#include <cstdint>
#include <vector>

namespace pantin::detail {

/// A vertex of a solid made of a core and a skin: its position is `core * corner + skin * normal`.
/// One mesh thus serves capsules of any length, and boxes with bevels of any width.
struct MeshVertex {
  float corner[3];  // -1, 0 or 1 per axis
  float normal[3];
};

/// A range of the common index buffer.
struct MeshRange {
  std::uint32_t first = 0, count = 0;  // indices
};

/// Capsules and spheres from fine to coarse, then boxes. Near ones are fine, and are drawn first.
enum Mesh : std::size_t { kRound64, kRound32, kRound16, kRound6, kBox, kMeshCount };

struct Meshes {
  std::vector<MeshVertex> vertices;
  std::vector<std::uint16_t> indices;  // triangles, counter-clockwise seen from outside
  std::array<MeshRange, kMeshCount> ranges;
};

Meshes make_meshes();

}  // namespace pantin::detail
