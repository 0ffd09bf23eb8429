#pragma once
/// The paths of surface contacts on both bodies, recorded while a scene runs.
#include <map>
#include <utility>
#include <vector>

#include "engine/render/renderer.hpp"

namespace pantin::detail {

class ContactTrails {
 public:
  /// Records the present contact points; call it after each step.
  void record(const World& world);
  /// For Overlay::trails: for each contact point, the trail on a, then that on b.
  const std::vector<Overlay::Trail>& trails() const { return trails_; }

 private:
  /// `size` is that of the surface.
  void add(std::size_t trail, Vec3 point, Real size);

  // By index of the joint's entity and contact point: index of its pair of trails.
  std::map<std::pair<std::uint32_t, std::size_t>, std::size_t> places_;
  std::vector<Overlay::Trail> trails_;
  std::vector<char> apart_;  // the contact was open since the last point; by trail
};

}  // namespace pantin::detail
