#include "engine/world/ties.hpp"

#include <utility>

namespace pantin::detail {
namespace {

template <class T>
Entity add_named(World& world, Store<T>& store, T tie, std::string name) {
  const Entity e = world.create();
  store.add(e, std::move(tie));
  if (!name.empty()) world.names.add(e, std::move(name));
  return e;
}

}  // namespace

Entity add_link(World& world, Link link, std::string name) {
  return add_named(world, world.links, std::move(link), std::move(name));
}

Entity add_cable(World& world, Cable cable, std::string name) {
  return add_named(world, world.cables, std::move(cable), std::move(name));
}

Entity add_gear(World& world, const Gear& gear, std::string name) {
  return add_named(world, world.gears, gear, std::move(name));
}

Entity add_belt(World& world, const Belt& belt, std::string name) {
  return add_named(world, world.belts, belt, std::move(name));
}

Entity add_surface_contact(World& world, const SurfaceContact& contact, std::string name) {
  return add_named(world, world.surface_contacts, contact, std::move(name));
}

}  // namespace pantin::detail
