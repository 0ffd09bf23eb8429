#pragma once
/// Which bodies that are near each other collide: what a user's filter answered, and who passes a
/// one-way surface. Kept while a pair stays near.
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
  bool asked = false;    // the filter was
  bool refused = false;  // by it
  bool passes = false;   // one the one-way surface of the other, until they are apart
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

/// Those of a World, or of a plane of it. Empty, and of no cost, where there is neither a filter
/// nor a one-way surface.
struct NearPairs {
  std::vector<NearPair> list;  // sorted by the indices of the entities

  static void fields(auto& self, auto&& field) { field("list", self.list); }

  /// A step begins: none has been seen in it.
  void begin();
  /// The entry of a pair that is near; the filter is asked about a new one.
  NearPair& at(const ContactPair& pair, const ContactFilter* filter);
  /// Forgets those that were not seen, except what `stays`.
  template <class Stays>
  void end(const Stays& stays) {
    std::erase_if(list, [&](const NearPair& p) { return !p.seen && !stays(p); });
  }
};

/// Whether anybody asks for them.
bool has_near_pairs(const World& world, const ContactFilter* filter);

/// Bodies that ignore each other for a time (pairs of slots) pass a one-way surface, wherever they
/// are when that time is over.
void add_ignored(const World& world, std::span<const std::uint64_t> ignored, NearPairs& near);

/// Where a body is solid, world axes; zero: on all sides.
Vec3 one_way(const World& world, Entity body);

/// How a body lies to a one-way surface where they come near.
struct Approach {
  Real facing = 0;         // cosine between the outward normal there and the solid side
  Real low = 0, high = 0;  // m: from where to where the body is, along the solid side
  Real top = 0;            // m: to where the surface is
};
/// Whether the surface lets it pass. What comes from the side stands on it already if it is no
/// lower than the top: it goes from one platform to the next.
bool is_let_pass(const Approach& from);

}  // namespace pantin::detail::contact
