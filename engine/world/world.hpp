#pragma once
/// The World: all components. It is a value; a copy is a snapshot.
#include <span>
#include <string>
#include <vector>

#include "engine/geometry/shape.hpp"
#include "engine/world/belt.hpp"
#include "engine/world/body.hpp"
#include "engine/world/collision.hpp"
#include "engine/world/entity.hpp"
#include "engine/world/joint_drive.hpp"
#include "engine/world/kinematic_path.hpp"
#include "engine/world/link.hpp"
#include "engine/world/look.hpp"
#include "engine/world/memory.hpp"
#include "engine/world/settings.hpp"
#include "engine/world/store.hpp"
#include "engine/world/surface_contact.hpp"
#include "engine/world/view.hpp"

namespace pantin {
namespace detail {

/// Components that connect bodies, or decide which solver steps them. If one is added or removed,
/// the solvers compile again.
template <class T, class... Others>
inline constexpr bool kIsAnyOf = (std::same_as<T, Others> || ...);
template <class T>
inline constexpr bool kIsStructural = kIsAnyOf<T, Body, Link, Cable, Gear, Belt, SurfaceContact,
                                               Pin, SolverSettings, JointDrive, Collision>;

/// Calls `each(store)` for all stores of a World that its `fields` list.
void for_each_store(auto& world, const auto& each) {
  world.fields(world, [&](const char*, auto&& field) {
    unwrap(field, [&](Role, auto& member) {
      if constexpr (requires { typename std::remove_cvref_t<decltype(member)>::Component; })
        each(member);
    });
  });
}
/// The same for the structural stores.
void for_each_structural_store(auto& world, const auto& each) {
  for_each_store(world, [&](auto& store) {
    if constexpr (kIsStructural<typename std::remove_cvref_t<decltype(store)>::Component>)
      each(store);
  });
}

}  // namespace detail

struct World {
  World();
  World(const World&);
  World(World&&) noexcept;
  World& operator=(const World&);
  World& operator=(World&&) noexcept;
  ~World();

  detail::Entities entities;
  Store<Body> bodies;
  Store<detail::Force> forces;
  Store<Pose>
      origins;  // of bodies placed by a frame of their own: that frame in the mass-centre frame
  Store<Shapes> shapes;
  Store<detail::Link> links;  // of the joints of <pantin/joints.hpp>, like cables and gears
  Store<detail::Cable> cables;
  Store<detail::Gear> gears;
  Store<detail::Belt> belts;
  Store<detail::SurfaceContact> surface_contacts;
  Store<Pin> pins;
  Store<KinematicPath> paths;
  Store<JointDrive> joint_drives;  // on links
  Store<Collision> collisions;     // on bodies
  Store<std::string> names;
  Store<SolverSettings> settings;  // on any body: applies to its whole island
  detail::UserStores user;

  Vec3 gravity{0, -9.81, 0};
  SolverSettings default_settings;
  std::vector<Material> materials{Material{}};
  std::vector<MaterialPair> material_pairs;  // each pair once, in either order

  std::uint64_t tick = 0;  // whole steps taken
  Real time = 0;           // s

  detail::Memories memory;  // of the solvers; see the rooms contact and solvers
  std::uint64_t edit_count = 1;

  /// The store of a user's component type, created on first use. It is copied, destroyed and (if
  /// the type has `fields`) hashed like the others.
  template <class T>
  Store<T>& store() {
    return user.of<T>();
  }

  /// All entities that have every one of these components, for loops like
  ///
  ///   for (auto [entity, body, wind] : world.view<Body, Wind>()) body.velocity += ...;
  ///
  /// in the order of the first component's store. The components are references, const if the World
  /// is. Nothing may be added to or removed from these stores within the loop.
  template <class... Components>
  detail::ComponentView<World, Components...> view() {
    return detail::ComponentView<World, Components...>(*this);
  }
  template <class... Components>
  detail::ComponentView<const World, Components...> view() const {
    return detail::ComponentView<const World, Components...>(*this);
  }

  /// Adds the object of a description: RigidBody, HingeJoint, CableJoint ... of
  /// <pantin/pantin.hpp>, or any type of yours with a function `add_to(World&, const T&)` in its
  /// namespace. Those of pantin return a Result<Entity>; on errors the World is unchanged.
  template <class T>
  [[nodiscard]] auto add(const T& description) {
    return add_to(*this, description);
  }

  Entity create() { return entities.create(); }
  /// Adds a body with an optional name.
  Entity add_body(const Body& body, std::string name = {});
  /// Adds a pin to a body; destroy() removes it.
  Entity add_pin(const Pin& pin, std::string name = {});

  /// Removes entities and every link, cable, gear, belt and pin that refers to them.
  void destroy(std::span<const Entity> doomed);
  void destroy(Entity e) { destroy(std::span<const Entity>(&e, 1)); }
  bool is_alive(Entity e) const { return entities.is_alive(e); }

  /// Call after changing masses, anchors, motions or settings: the solvers then recompile. Wakes
  /// all bodies that sleep; unchanged islands otherwise continue as before.
  void mark_dirty() { ++edit_count; }
  /// Changes whenever the structure does.
  std::uint64_t structure() const;

  /// Moves a body at once: the integrator restarts, and no pose in between is drawn. Returns false,
  /// and does nothing, if there is no such body.
  bool teleport(Entity body, const Pose& pose);

  /// Pushes a dynamic body with `force` (N, world axes) at `point` (world) during the next step.
  /// Called by a system within a step, it acts in the current substep; from before_contacts on, in
  /// the next. Returns false, and does nothing, if there is no such body.
  bool push(Entity body, Vec3 force, Vec3 point);

  /// The name of an entity, or "#<index>".
  std::string name_of(Entity e) const;
  /// The first entity of that name, or none.
  Entity find(std::string_view name) const;
  /// The pose of the frame a body was placed by (its own frame in a scene file).
  Pose origin_pose(Entity body) const;

  /// The components and global values. Used handles, names and appearance do not decide the next
  /// step. Of the shapes, those of colliders do, with their materials if pairs of materials have
  /// properties: see state_hash.
  static void fields(auto& self, auto&& field) {
    field("entities", passive(self.entities));
    field("bodies", self.bodies);
    field("forces", self.forces);
    field("origins", passive(self.origins));
    field("shapes", passive(self.shapes));
    field("links", self.links);
    field("cables", self.cables);
    field("gears", self.gears);
    field("belts", self.belts);
    field("surface_contacts", self.surface_contacts);
    field("pins", self.pins);
    field("paths", self.paths);
    field("joint_drives", self.joint_drives);
    field("collisions", self.collisions);
    field("names", passive(self.names));
    field("settings", self.settings);
    field("user", derived(self.user));
    field("gravity", self.gravity);
    field("default_settings", self.default_settings);
    field("materials", passive(self.materials));
    field("material_pairs", self.material_pairs);
    field("tick", self.tick);
    field("time", self.time);
    field("edit_count", passive(self.edit_count));
  }
};

/// A hash of everything that determines the next step.
std::uint64_t state_hash(const World& world);

}  // namespace pantin
