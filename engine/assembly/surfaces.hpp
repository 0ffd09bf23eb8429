#pragma once
/// Bilateral surface joints whose bodies are far apart.
#include "engine/assembly/problem.hpp"

namespace pantin::detail::assembly {

/// Searches the nearest pair of points that face one another, at any distance, of bilateral surface
/// joints that track none. Returns whether all track one.
bool find_pairs_anywhere(const World& world, Part& part);

/// Puts one body of bilateral surface joints against the other at the contact that the joint was
/// described with, the normals opposed: of all, or where no pair faces another. Returns the number
/// of bodies that were moved.
enum class Bring : std::uint8_t { lost, all };
int bring_into_contact(const World& world, Part& part, Bring which);

}  // namespace pantin::detail::assembly
