#pragma once
// A run as a model with animated nodes.
#include <cstdint>
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/world/world.hpp"

namespace pantin::program {

using namespace detail;

/// Collects a run and writes it as a binary glTF 2.0 file: a node for each body at its own frame,
/// with its shapes as a mesh, nodes of tubes along cables, and one animation of all that move.
/// Springs, belts and supports are left out. Bodies and cables that are added after the start are
/// left out; what is destroyed stays where it was. Metres, +Y up; times are from the start.
/// [Khronos 2021]
class GltfFilm {
 public:
  /// Begins with the present objects and poses.
  void start(const World& world, std::string title);
  /// Keeps the poses unless the last ones are less than 1/60 s old. Returns false, and keeps
  /// nothing, once the file would be too large.
  bool add(const World& world);
  /// Writes the file beside its place and renames it.
  Result<Done> write(const std::string& path) const;

 private:
  /// Something that is drawn, and its pose at each kept time.
  struct Node {
    Entity object;
    std::string name;
    // 3, 4 and 3 numbers a time; scales of tubes only.
    std::vector<float> translations = {}, rotations = {}, scales = {};
    std::size_t segment = 0;  // of a cable's tubes
    bool is_cable = false;
  };
  void keep(const World& world);
  static void keep_body(const World& world, Node& node);
  void keep_cable(const World& world, std::size_t first);

  World start_;
  std::string title_;
  std::vector<Node> nodes_;
  std::vector<float> times_;  // s, from the start
  double last_ = 0;           // s, of the World, when poses were kept last
};

}  // namespace pantin::program
