#include "engine/render/meshes.hpp"

#include "engine/base/math.hpp"

namespace pantin::detail {
namespace {

std::uint16_t add_vertex(Meshes& to, Vec3 corner, Vec3 normal) {
  MeshVertex v{};
  for (int k = 0; k < 3; ++k) {
    v.corner[k] = static_cast<float>(corner[k]);
    v.normal[k] = static_cast<float>(normal[k]);
  }
  to.vertices.push_back(v);
  return static_cast<std::uint16_t>(to.vertices.size() - 1);
}

void add_triangle(Meshes& to, std::uint16_t a, std::uint16_t b, std::uint16_t c) {
  to.indices.insert(to.indices.end(), {a, b, c});
}

/// Two hemispheres of `rings` rings, and the cylinder between them.
void add_round(Meshes& to, int segments, int rings) {
  const auto ring_of = [&](int ring, Real end) {  // ring 0 is the rim
    const Real rise = kPi / 2 * ring / rings;
    std::vector<std::uint16_t> row;
    for (int s = 0; s < segments; ++s) {
      const Real around = 2 * kPi * s / segments;
      row.push_back(add_vertex(to, {0, end, 0},
                               {std::cos(rise) * std::cos(around), end * std::sin(rise),
                                std::cos(rise) * std::sin(around)}));
    }
    return row;
  };
  const auto bridge = [&](const std::vector<std::uint16_t>& low,
                          const std::vector<std::uint16_t>& high) {
    for (std::size_t s = 0; s < low.size(); ++s) {
      const std::size_t next = (s + 1) % low.size();
      add_triangle(to, low[s], high[s], low[next]);
      add_triangle(to, low[next], high[s], high[next]);
    }
  };
  std::vector<std::uint16_t> top = ring_of(0, 1), bottom = ring_of(0, -1);
  bridge(bottom, top);
  for (int ring = 1; ring < rings; ++ring) {
    auto higher = ring_of(ring, 1), lower = ring_of(ring, -1);
    bridge(top, higher), bridge(lower, bottom);
    top = std::move(higher), bottom = std::move(lower);
  }
  const std::uint16_t north = add_vertex(to, {0, 1, 0}, {0, 1, 0});
  const std::uint16_t south = add_vertex(to, {0, -1, 0}, {0, -1, 0});
  for (std::size_t s = 0; s < top.size(); ++s) {
    const std::size_t next = (s + 1) % top.size();
    add_triangle(to, top[s], north, top[next]);
    add_triangle(to, bottom[next], south, bottom[s]);
  }
}

/// Six faces, a bevel along each edge and a triangle at each corner. Normals vary across the
/// bevels.
void add_box(Meshes& to) {
  const auto axis = [](int k, Real sign) {
    Vec3 v{0};
    v[k] = sign;
    return v;
  };
  std::uint16_t at[8][3];  // by corner, and by the face that gives the normal
  for (int c = 0; c < 8; ++c) {
    const Vec3 corner{c & 1 ? 1 : -1, c & 2 ? 1 : -1, c & 4 ? 1 : -1};
    for (int k = 0; k < 3; ++k) at[c][k] = add_vertex(to, corner, axis(k, corner[k]));
  }
  enum class Winding { as_given, reversed };
  const auto quad = [&](std::array<std::uint16_t, 4> corners, Winding winding) {
    auto& [a, b, c, d] = corners;
    if (winding == Winding::reversed) std::swap(b, d);
    add_triangle(to, a, b, c), add_triangle(to, a, c, d);
  };
  for (int k = 0; k < 3; ++k) {
    const int i = 1 << ((k + 1) % 3), j = 1 << ((k + 2) % 3), up = 1 << k;
    const int u = (k + 1) % 3, v = (k + 2) % 3;
    quad({at[up][k], at[up | i][k], at[up | i | j][k], at[up | j][k]}, Winding::as_given);
    quad({at[0][k], at[i][k], at[i | j][k], at[j][k]}, Winding::reversed);
    for (int side = 0; side < 4; ++side) {  // the four edges along axis k
      const int low = (side & 1 ? i : 0) | (side & 2 ? j : 0), high = low | up;
      const Winding winding = side == 1 || side == 2 ? Winding::reversed : Winding::as_given;
      quad({at[low][v], at[high][v], at[high][u], at[low][u]}, winding);
    }
  }
  for (int c = 0; c < 8; ++c) {
    const bool flip = ((c & 1) + (c >> 1 & 1) + (c >> 2 & 1)) % 2 == 0;
    add_triangle(to, at[c][0], at[c][flip ? 2 : 1], at[c][flip ? 1 : 2]);
  }
}

}  // namespace

Meshes make_meshes() {
  Meshes meshes;
  const auto range = [&](Mesh which, auto&& add) {
    const auto first = static_cast<std::uint32_t>(meshes.indices.size());
    add();
    meshes.ranges[which] = {first, static_cast<std::uint32_t>(meshes.indices.size()) - first};
  };
  range(kRound6, [&] { add_round(meshes, 6, 2); });
  range(kRound16, [&] { add_round(meshes, 16, 3); });
  range(kRound32, [&] { add_round(meshes, 32, 6); });
  range(kRound64, [&] { add_round(meshes, 64, 12); });
  range(kBox, [&] { add_box(meshes); });
  return meshes;
}

}  // namespace pantin::detail
