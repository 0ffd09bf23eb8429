#pragma once
/// Memory that the search for contacts keeps between steps.
#include <cstdint>
#include <vector>

#include "engine/geometry/box_tree.hpp"
#include "engine/geometry/touch.hpp"
#include "engine/world/collision.hpp"
#include "engine/world/entity.hpp"

namespace pantin::contact {

/// One shape of a body that may touch, placed in the world.
struct SolidPart {
  Pose pose;
  Box box;                  // as it stands
  Real extent = 0;          // m, half its diagonal
  std::uint32_t slot = 0;   // of the body
  std::uint32_t index = 0;  // among the body's shapes
  const Shape* shape = nullptr;
};

/// One body that may touch.
struct Solid {
  std::uint32_t slot = 0, first = 0, count = 0;  // its parts
  std::uint64_t island = UINT64_MAX;  // of all solvers; none: moved by nobody
  const Collision* collision = nullptr;
};

/// A point found for one body, before it becomes a contact.
struct FoundPoint {
  std::uint32_t slot_b = 0;
  std::uint64_t key = 0;
  const Collision* other = nullptr;
  TouchPoint at;
};

/// Nothing here is state: an empty one finds the same contacts.
struct Search {
  std::vector<SolidPart> parts;
  std::vector<Solid> solids;
  std::vector<std::uint32_t> still, endless, moving;  // parts; parts; solids
  std::vector<std::uint32_t> solid_at;                // by slot; UINT32_MAX: none
  std::vector<Box> boxes, still_boxes, moving_boxes;
  BoxTree still_tree, moving_tree;
  std::vector<std::uint64_t> jointed;  // pairs of slots, lower first, sorted
  std::uint64_t jointed_for = 0;       // see jointed_version
  std::vector<std::uint64_t> pairs;    // of solids that both move, lower slot first
  std::vector<FoundPoint> found;       // of one body
  std::vector<TouchPoint> points;      // of one pair
  NarrowRoom room;
};

}  // namespace pantin::contact
