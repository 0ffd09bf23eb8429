#pragma once
/// Which near bodies collide: the answers of a user's filter, and passages through one-way
/// surfaces. Kept while a pair stays near.
#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/base/fields.hpp"
#include "engine/contact/contact.hpp"

namespace pantin {
struct World;
}

namespace pantin::detail::contact {

struct NearPair {
  Entity a, b;           // a has the lower index
  bool asked = false;    // the filter was called
  bool refused = false;  // by the filter
  bool passes = false;   // through a one-way surface, until the bodies are apart
  bool seen = false;     // in this step

  bool collides() const { return !refused && !passes; }

  static void fields(auto& self, auto&& field) {
    field("a", self.a);
    field("b", self.b);
    field("asked", self.asked);
    field("refused", self.refused);
    field("passes", self.passes);
    field("seen", derived(self.seen));
  }
};

/// Near pairs of a World, or of a plane of it. Empty, at no cost, if there is neither a filter nor
/// a one-way surface.
struct NearPairs {
  std::vector<NearPair> list;  // sorted by the indices of the entities

  static void fields(auto& self, auto&& field) { field("list", self.list); }

  /// Begins a step: no pair has been seen in it.
  void begin();
  /// The entry of a near pair; a new one is passed to the filter.
  NearPair& at(const ContactPair& pair, const ContactFilter* filter);
  /// Removes the pairs that were not seen, except those for which `stays(pair)` is true.
  template <class Stays>
  void end(const Stays& stays) {
    std::erase_if(list, [&](const NearPair& p) { return !p.seen && !stays(p); });
  }
};

/// Whether the World needs near pairs.
bool has_near_pairs(const World& world, const ContactFilter* filter);

/// Bodies that ignore each other for a time (pairs of slots) pass a one-way surface, wherever they
/// are when that time ends.
void add_ignored(const World& world, std::span<const std::uint64_t> ignored, NearPairs& near);

/// Direction of a body's solid side, world axes; zero: solid on all sides.
Vec3 one_way(const World& world, Entity body);

/// How a body approaches a one-way surface.
struct Approach {
  Real facing = 0;         // cosine between the outward normal there and the solid side
  Real low = 0, high = 0;  // m: extent of the body along the solid side
  Real top = 0;            // m: top of the surface along the solid side
};
/// Whether the surface lets it pass. A body from the side counts as standing on the surface if it
/// is no lower than the top: it moves from one platform to the next.
bool is_let_pass(const Approach& from);

}  // namespace pantin::detail::contact
