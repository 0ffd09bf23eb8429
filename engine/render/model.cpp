#include "engine/render/model.hpp"

#include <algorithm>

#include "engine/geometry/surface.hpp"
#include "engine/render/curve_mesh.hpp"
#include "engine/render/gather.hpp"
#include "engine/render/palette.hpp"
#include "engine/render/surface_mesh.hpp"

namespace pantin::detail {
namespace {

std::array<float, 3> floats(Vec3 v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

Vec3 vec(const float (&v)[3]) { return {v[0], v[1], v[2]}; }

/// Adds vertices and triangles; `corner` gives the position of a mesh's vertex.
template <class Corner>
void add_mesh(ModelPart& to, std::span<const MeshVertex> vertices, const Pose& at, Corner corner) {
  for (const MeshVertex& v : vertices) {
    to.positions.push_back(floats(to_world(at, corner(v))));
    to.normals.push_back(floats(at.rotation * vec(v.normal)));
  }
}

/// A shape of ready triangles.
void add_surface(ModelPart& to, const Surface& surface, const Shape* smooth, const Pose& at) {
  const SurfaceMesh mesh = make_surface_mesh(surface, smooth);
  const auto first = static_cast<std::uint32_t>(to.positions.size());
  add_mesh(to, mesh.vertices, at, [](const MeshVertex& v) { return vec(v.corner); });
  for (const std::uint32_t i : mesh.indices) to.indices.push_back(first + i);
}

void add_box(ModelPart& to, const DrawnBox& box, const Pose& at) {
  static const Meshes meshes = make_meshes();
  const auto first = static_cast<std::uint32_t>(to.positions.size());
  const MeshRange range = meshes.ranges[box.mesh];
  const std::span indices(meshes.indices.data() + range.first, range.count);
  const auto [low, high] = std::minmax_element(indices.begin(), indices.end());
  const std::span own(meshes.vertices.data() + *low, static_cast<std::size_t>(*high - *low) + 1);
  add_mesh(to, own, at, [&](const MeshVertex& v) {
    return vec(v.corner) * box.core + box.skin * vec(v.normal);
  });
  for (const std::uint16_t i : indices) to.indices.push_back(first + i - *low);
}

void add_shape(ModelPart& to, const Shape& shape, const Pose& frame) {
  if (traits_of(shape.kind).shape_class == ShapeClass::half_space)
    return add_shape(to, slab_of(shape), frame);
  const Pose at = compose(frame, shape.local);
  if (const auto rounded = rounded_box(shape)) return add_box(to, drawn_box(*rounded), at);
  if (has_surface(shape.kind)) {
    if (shape.surface) add_surface(to, *shape.surface, nullptr, at);
  } else if (const auto stand_in = tessellate(shape)) {
    add_surface(to, *stand_in, &shape, at);
  }
}

}  // namespace

std::vector<ModelPart> model_of(const World& world, Entity body) {
  std::vector<ModelPart> parts;
  const std::uint32_t slot = world.bodies.slot(body);
  if (slot == kNoSlot) return parts;
  const Pose* origin = world.origins.find(body);
  const Pose frame = origin ? inverse(*origin) : Pose{};
  const auto part_of = [&](std::uint32_t material) -> ModelPart& {
    const Material drawn = drawn_material({world}, slot, material);
    for (ModelPart& part : parts)
      if (part.material.colour == drawn.colour && part.material.roughness == drawn.roughness &&
          part.material.metallic == drawn.metallic)
        return part;
    return parts.emplace_back(ModelPart{drawn, {}, {}, {}});
  };
  const Shapes* shapes = world.shapes.find(body);
  if (shapes)
    for (const Shape& shape : shapes->list) add_shape(part_of(shape.material), shape, frame);
  std::vector<const nurbs::Wire*> drawn;
  const std::uint32_t material = shapes && !shapes->list.empty() ? shapes->list[0].material : 0;
  for (const SurfaceContact& c : world.surface_contacts.values())
    for (const auto& [owner, on] : {std::pair{c.a, &c.on_a}, {c.b, &c.on_b}}) {
      if (owner != body || !on->curve || std::ranges::count(drawn, on->curve.get())) continue;
      drawn.push_back(on->curve.get());
      if (const auto solid = solid_of(*on->curve))
        add_surface(part_of(material), *solid, nullptr, compose(frame, on->pose));
    }
  std::erase_if(parts, [](const ModelPart& part) { return part.indices.empty(); });
  return parts;
}

ModelPart tube(Real radius) {
  constexpr std::uint32_t kAround = 8;
  ModelPart part;
  for (std::uint32_t i = 0; i < kAround; ++i) {
    const Real angle = 2 * kPi * i / kAround;
    const Vec3 out(std::cos(angle), 0, std::sin(angle));
    for (const Real height : {0.0, 1.0}) {
      part.positions.push_back(floats(radius * out + Vec3(0, height, 0)));
      part.normals.push_back(floats(out));
    }
    const std::uint32_t low = 2 * i, next = 2 * ((i + 1) % kAround);
    for (const std::uint32_t corner : {low, low + 1, next, next, low + 1, next + 1})
      part.indices.push_back(corner);
  }
  return part;
}

}  // namespace pantin::detail
