#include "engine/render/gather.hpp"

#include <algorithm>

#include "engine/geometry/surface.hpp"
#include "engine/render/belts.hpp"
#include "engine/render/curve_mesh.hpp"
#include "engine/render/palette.hpp"
#include "engine/render/springs.hpp"
#include "engine/render/supports.hpp"
#include "engine/render/surface_mesh.hpp"

namespace pantin::detail {
namespace {

constexpr std::size_t kCrowd = 500;  // bodies; above it coarse meshes are used
constexpr int kSlackSegments = 24;
constexpr std::size_t kManySprings = 100;       // above it their coils are coarse
constexpr int kFineTurn = 12, kCoarseTurn = 6;  // straight pieces a turn

void store(Vec3 from, float* to) {
  for (int k = 0; k < 3; ++k) to[k] = static_cast<float>(from[k]);
}

/// The tessellation of round shapes.
enum class MeshDetail { fine, coarse };

/// The coarsest mesh whose silhouette error is below half a pixel, or a few pixels at coarse
/// detail.
Mesh round_mesh(Real radius_pixels, MeshDetail detail) {
  const bool crowd = detail == MeshDetail::coarse;
  if (radius_pixels < (crowd ? 12 : 4)) return kRound6;
  if (radius_pixels < (crowd ? 1e9 : 20)) return kRound16;
  return radius_pixels < 70 ? kRound32 : kRound64;
}

/// Fills an instance except for its core and skin.
void fill(Instance& instance, const Pose& at, const Material& material, const Eye& eye) {
  instance.turn[0] = static_cast<float>(at.rotation.x);
  instance.turn[1] = static_cast<float>(at.rotation.y);
  instance.turn[2] = static_cast<float>(at.rotation.z);
  instance.turn[3] = static_cast<float>(at.rotation.w);
  store(at.position - eye.position, instance.position);
  store(material.colour, instance.colour);
  instance.roughness = static_cast<float>(material.roughness);
  instance.metallic = static_cast<float>(material.metallic);
}

/// The surface of a shape, or a substitute; stored, so that its copy on the GPU is kept too.
SurfaceSolids solids_of(const Shape& shape, DrawList& to) {
  if (has_surface(shape.kind)) return {shape.surface};
  const auto key = std::make_tuple(shape.kind, shape.size.x, shape.size.y, shape.size.z);
  const auto [entry, is_new] = to.stand_ins.try_emplace(key);
  StandIn& stand_in = entry->second;
  if (is_new) stand_in = {shape, tessellate(shape)};
  return {stand_in.surface, &stand_in.shape};
}

/// Collects the solids of a picture, for an eye.
struct SolidList {
  const Eye& eye;
  MeshDetail detail;
  DrawList& to;

  /// Adds a shape of a body at `pose`.
  void add(const Shape& shape, const Pose& pose, const Material& material);
  void add_surface(const Shape& shape, const Pose& pose, const Material& material);
  void add_instance(SurfaceSolids group, const Pose& at, const Material& material);
  void add_curve(const PosedWorld& scene, Entity body, const ContactSurface& on);
  void add_springs(const PosedWorld& scene);
  /// A spring, of as many straight pieces a turn.
  void add_coil(const Coil& coil, int around);
};

void SolidList::add_surface(const Shape& shape, const Pose& pose, const Material& material) {
  SurfaceSolids group = solids_of(shape, to);
  if (group.surface) add_instance(std::move(group), compose(pose, shape.local), material);
}

void SolidList::add_instance(SurfaceSolids group, const Pose& at, const Material& material) {
  const auto [entry, is_new] =
      to.surface_indices.try_emplace(group.surface.get(), to.surfaces.size());
  if (is_new) to.surfaces.push_back(std::move(group));
  Instance& instance = to.surfaces[entry->second].instances.emplace_back();
  fill(instance, at, material, eye);
  store(Vec3{1}, instance.core);
  instance.skin = 0;
}

/// A curve takes the material of its body's first shape.
void SolidList::add_curve(const PosedWorld& scene, Entity body, const ContactSurface& on) {
  const World& world = scene.world;
  const std::uint32_t slot = world.bodies.slot(body);
  if (slot == kNoSlot || !is_finite(scene.pose_of(slot))) return;
  DrawList::CurveSolid& kept = to.curve_solids[on.curve.get()];
  if (!kept.curve) kept = {on.curve, solid_of(*on.curve)};
  if (!kept.solid) return;
  const Shapes* shapes = world.shapes.find(body);
  const std::uint32_t material = shapes && !shapes->list.empty() ? shapes->list[0].material : 0;
  const Pose at = compose(scene.pose_of(slot), on.pose);
  add_instance({kept.solid}, at, drawn_material(scene, slot, material));
  for (int c = 0; c < 8; ++c) {
    const Vec3 low = kept.solid->low, high = kept.solid->high;
    const Vec3 corner{c & 1 ? high.x : low.x, c & 2 ? high.y : low.y, c & 4 ? high.z : low.z};
    to.solids_around.balls.push_back({to_world(at, corner), 0});
  }
  to.solids_around.end();
}

void SolidList::add_springs(const PosedWorld& scene) {
  std::vector<Coil> coils;
  for (const Link& link : scene.world.links.values())
    if (const auto coil = coil_of(scene, link)) coils.push_back(*coil);
  for (const Pin& pin : scene.world.pins.values())
    if (const auto coil = coil_of(scene, pin)) coils.push_back(*coil);
  for (const Coil& coil : coils)
    add_coil(coil, coils.size() > kManySprings ? kCoarseTurn : kFineTurn);
}

void SolidList::add_coil(const Coil& coil, int around) {
  Material steel;
  steel.colour = Vec3(0.5), steel.roughness = 0.4;
  const std::vector<Vec3> wire = wire_of(coil, around);
  for (std::size_t i = 1; i < wire.size(); ++i) {
    const Vec3 along = wire[i] - wire[i - 1];
    const Real length = glm::length(along);
    Shape piece;
    piece.kind = ShapeKind::capsule, piece.size = {coil.wire, length / 2, 0};
    add(piece, {0.5 * (wire[i] + wire[i - 1]), upright(along / length)}, steel);
  }
  for (const Vec3 end : {coil.a, coil.b}) {
    const Ball ball{end, coil.radius + coil.wire};
    to.solids_around.balls.push_back(ball), to.movers.push_back(ball);
  }
  to.solids_around.end();
}

void SolidList::add(const Shape& shape, const Pose& pose, const Material& material) {
  if (traits_of(shape.kind).shape_class == ShapeClass::half_space)
    return add(slab_of(shape), pose, material);
  const auto rounded = rounded_box(shape);
  if (!rounded) return add_surface(shape, pose, material);
  const Pose at = compose(pose, shape.local);
  DrawnBox box = drawn_box(*rounded);
  if (box.mesh != kBox) {
    const Real depth = std::max(eye.depth(at.position) - box.core.y, Real(1e-6));
    box.mesh = round_mesh(box.skin / (depth * eye.pixel()), detail);
  }
  Instance& instance = to.solids[box.mesh].emplace_back();
  fill(instance, at, material, eye);
  store(box.core, instance.core);
  instance.skin = static_cast<float>(box.skin);
}

/// A box of about three quarters of a shape's size; each side is a whole multiple of the shortest.
Shape box_within(const Shape& shape) {
  const Aabb bounds =
      shape.surface ? Aabb{shape.surface->low, shape.surface->high} : bounds_of(shape, Pose{});
  const Vec3 low = bounds.low, high = bounds.high;
  const Vec3 half = 0.375 * (high - low);
  const Real least = std::max(std::min({half.x, half.y, half.z}), 1e-6);
  Shape box;
  box.kind = ShapeKind::box;
  box.size = least * glm::max(glm::round(half / least), Vec3{1});
  box.local = {to_world(shape.local, 0.5 * (low + high)), shape.local.rotation};
  return box;
}

/// Balls that roughly fill a shape, for its contact shade; none for floors and walls.
void add_fillings(const Shape& shape, const Pose& pose, std::vector<Ball>& to) {
  if (is_ground(shape.kind)) return;
  const auto rounded = rounded_box(shape);
  if (!rounded) {
    if (is_complete(shape)) add_fillings(box_within(shape), pose, to);
    return;
  }
  const Pose at = compose(pose, shape.local);
  Vec3 reach = rounded->core;
  Real radius = rounded->radius;
  if (radius == 0) {
    radius = std::min({reach.x, reach.y, reach.z});
    reach -= radius;
  }
  // Barely overlapping balls: each occludes separately, and overlaps would count twice.
  const Real apart = 1.6 * radius;
  int gaps[3];
  for (int k = 0; k < 3; ++k) {
    if (reach[k] > 12 * radius) return;
    gaps[k] = static_cast<int>(std::ceil(2 * reach[k] / apart));
  }
  const auto along = [&](int axis, int i) {
    return gaps[axis] > 0 ? reach[axis] * (2.0 * i / gaps[axis] - 1) : 0.0;
  };
  for (int x = 0; x <= gaps[0]; ++x)
    for (int y = 0; y <= gaps[1]; ++y)
      for (int z = 0; z <= gaps[2]; ++z)
        to.push_back({to_world(at, {along(0, x), along(1, y), along(2, z)}), radius});
}

/// Whether a plane coincides with the drawn ground, which would cause z-fighting.
bool is_drawn_ground(const Shape& shape, const Pose& pose, const View& view) {
  const bool flat = traits_of(shape.kind).shape_class == ShapeClass::half_space;
  if (!flat || !view.ground) return false;
  const Pose at = compose(pose, shape.local);
  return (at.rotation * Vec3{0, 1, 0}).y > 1 - 1e-9 &&
         std::abs(at.position.y - view.ground_height) < 1e-3;
}

void sort_nearest_first(std::vector<Instance>& list, Vec3 forward) {
  const auto depth = [&](const Instance& i) {
    return forward.x * i.position[0] + forward.y * i.position[1] + forward.z * i.position[2];
  };
  std::stable_sort(list.begin(), list.end(),
                   [&](const Instance& a, const Instance& b) { return depth(a) < depth(b); });
}

void add_ribbon(std::span<const Vec3> points, const Eye& eye, DrawList& to) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3 along = points[std::min(i + 1, points.size() - 1)] - points[i > 0 ? i - 1 : 0];
    const auto first = static_cast<std::uint32_t>(to.ribbon.size());
    for (float side : {-1.f, 1.f}) {
      RibbonVertex& v = to.ribbon.emplace_back();
      store(points[i] - eye.position, v.position);
      store(along, v.tangent);
      v.side = side;
    }
    if (i + 1 == points.size()) break;
    for (std::uint32_t corner : {0u, 1u, 2u, 2u, 1u, 3u})
      to.ribbon_indices.push_back(first + corner);
  }
}

}  // namespace

std::optional<RoundedBox> rounded_box(const Shape& shape) {
  const auto rounded = traits_of(shape.kind).rounded;
  return rounded ? rounded(shape) : std::nullopt;
}

DrawnBox drawn_box(const RoundedBox& box) {
  if (box.radius == 0) {
    const Real bevel = 0.08 * std::min({box.core.x, box.core.y, box.core.z});
    return {box.core - bevel, bevel, kBox};
  }
  const bool is_round = box.core.x == 0 && box.core.z == 0;
  return {box.core, box.radius, is_round ? kRound32 : kBox};
}

void gather(const PosedWorld& scene, const View& view, const Eye& eye, DrawList& to) {
  for (auto& list : to.solids) list.clear();
  to.surfaces.clear(), to.surface_indices.clear();
  to.ribbon.clear(), to.ribbon_indices.clear(), to.solids_around.clear(), to.movers.clear();
  to.fillings.clear(), to.grounds.clear();

  const Material plain;
  const World& world = scene.world;
  SolidList solids{eye, world.bodies.size() > kCrowd ? MeshDetail::coarse : MeshDetail::fine, to};
  for (std::size_t i = 0; i < world.shapes.size(); ++i) {
    const std::uint32_t slot = world.bodies.slot(world.shapes.owners()[i]);
    if (slot == kNoSlot) continue;
    const Pose& pose = scene.pose_of(slot);
    if (!is_finite(pose)) continue;
    const bool moves = world.bodies.values()[slot].motion != Motion::fixed;
    for (const Shape& shape : world.shapes.values()[i].list) {
      if (is_drawn_ground(shape, pose, view)) continue;
      solids.add(shape, pose, drawn_material(scene, slot, shape.material));
      const bool ground = is_ground(shape.kind);
      Hulls& hulls = ground ? to.grounds : to.solids_around;
      add_balls(shape, pose, hulls.balls), hulls.end();
      if (ground) continue;
      add_fillings(shape, pose, to.fillings);
      if (moves) add_balls(shape, pose, to.movers);
    }
  }

  std::vector<BeltPiece> pieces;
  for (const Belt& belt : world.belts.values()) {
    pieces.clear();
    add_belt(scene, belt, pieces);
    const bool known = belt.material < world.materials.size();
    const Material own = known ? world.materials[belt.material] : plain;
    Material mark = own;
    mark.colour = glm::mix(own.colour, Vec3(1), 0.55);
    for (const BeltPiece& piece : pieces) {
      solids.add(piece.box, piece.pose, piece.is_mark ? mark : own);
      add_balls(piece.box, piece.pose, to.solids_around.balls), to.solids_around.end();
      add_balls(piece.box, piece.pose, to.movers);
    }
  }
  std::vector<std::pair<Entity, const nurbs::Wire*>> drawn;
  for (const SurfaceContact& c : world.surface_contacts.values())
    for (const auto& [body, on] : {std::pair{c.a, &c.on_a}, {c.b, &c.on_b}}) {
      const std::pair one{body, on->curve.get()};
      if (!on->curve || std::find(drawn.begin(), drawn.end(), one) != drawn.end()) continue;
      drawn.push_back(one), solids.add_curve(scene, body, *on);
    }

  solids.add_springs(scene);
  Material frame;
  frame.colour = Vec3(0.16), frame.roughness = 0.8;
  std::vector<SupportPart> supports;
  add_supports(scene, supports);
  for (const SupportPart& part : supports) {
    solids.add(part.shape, part.pose, frame);
    add_balls(part.shape, part.pose, to.solids_around.balls), to.solids_around.end();
  }

  // Front to back, so that hidden fragments are rejected early.
  for (auto& list : to.solids) sort_nearest_first(list, eye.forward);
  for (auto& group : to.surfaces) sort_nearest_first(group.instances, eye.forward);

  std::vector<Vec3> curve;
  for (const Cable& cable : world.cables.values()) {
    curve.clear();
    add_cable(scene, cable, kSlackSegments, curve);
    if (curve.empty()) continue;
    add_ribbon(curve, eye, to);
    for (std::size_t i = 0; i < curve.size(); ++i) {
      const Ball one{curve[i], kStringRadius};
      to.movers.push_back(one);
      if (i == 0) continue;
      to.solids_around.balls.push_back({curve[i - 1], kStringRadius});
      to.solids_around.balls.push_back(one), to.solids_around.end();
    }
  }
}

}  // namespace pantin::detail
