#pragma once
/// Adds the internal forms of the descriptions of <pantin/joints.hpp> without any checks.
#include <string>

#include "engine/world/world.hpp"

namespace pantin::detail {

Entity add_link(World& world, Link link, std::string name = {});
Entity add_cable(World& world, Cable cable, std::string name = {});
Entity add_gear(World& world, const Gear& gear, std::string name = {});
Entity add_belt(World& world, const Belt& belt, std::string name = {});
Entity add_surface_contact(World& world, const SurfaceContact& contact, std::string name = {});

}  // namespace pantin::detail
