#pragma once
/// The ways that contacts of surfaces went over both bodies, kept while a scene runs.
#include <map>
#include <utility>
#include <vector>

#include "engine/render/renderer.hpp"

namespace pantin::detail {

class ContactTrails {
 public:
  /// Notes where the surfaces touch now; after each step.
  void record(const World& world);
  /// For Overlay::trails: of each joint that on a, then that on b.
  const std::vector<Overlay::Trail>& trails() const { return trails_; }

 private:
  void add(Overlay::Trail& trail, Vec3 point, Real near);

  std::map<std::uint32_t, std::size_t> places_;  // by index of the joint's entity, of its first
  std::vector<Overlay::Trail> trails_;
};

}  // namespace pantin::detail
