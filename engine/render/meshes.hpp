#pragma once
/// The few meshes that all shapes are drawn with.
#include <array>
#include <cstdint>
#include <vector>

namespace pantin::detail {

/// A vertex of a solid that is a core grown by a skin: its position is `core * corner + skin *
/// normal`. One mesh so serves capsules of any length, and boxes with bevels of any width.
struct MeshVertex {
  float corner[3];  // -1, 0 or 1 an axis
  float normal[3];
};

/// Part of the common index buffer.
struct MeshRange {
  std::uint32_t first = 0, count = 0;  // indices
};

/// Capsules and spheres from fine to coarse, then boxes: near ones are fine, and drawn first.
enum Mesh : std::size_t { kRound64, kRound32, kRound16, kRound6, kBox, kMeshCount };

struct Meshes {
  std::vector<MeshVertex> vertices;
  std::vector<std::uint16_t> indices;  // triangles, counter-clockwise seen from outside
  std::array<MeshRange, kMeshCount> ranges;
};

Meshes make_meshes();

}  // namespace pantin::detail
