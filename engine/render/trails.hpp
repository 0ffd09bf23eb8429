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
  /// For Overlay::trails: of each place that on a, then that on b.
  const std::vector<Overlay::Trail>& trails() const { return trails_; }

 private:
  /// Of a surface of this size.
  void add(std::size_t trail, Vec3 point, Real size);

  // By index of the joint's entity and place: where its pair of trails begins.
  std::map<std::pair<std::uint32_t, std::size_t>, std::size_t> places_;
  std::vector<Overlay::Trail> trails_;
  std::vector<char> apart_;  // since the last point; by trail
};

}  // namespace pantin::detail
