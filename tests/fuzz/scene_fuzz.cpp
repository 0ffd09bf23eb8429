// Text -> recipe -> World -> structure -> a step where that is small. Whatever the text, it is read
// or refused with a line that a terminal may show.
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "engine/base/utf8.hpp"
#include "engine/runtime/simulation.hpp"
#include "engine/scene/scene.hpp"
#include "engine/solvers/solver.hpp"

using namespace pantin;
using namespace pantin::detail;

namespace {

/// Counts that one input cannot exceed, so that no input is merely slow.
SceneLimits small_limits() {
  SceneLimits limits;
  limits.bytes = 1u << 16;
  limits.bodies = limits.links = limits.copies = 2000;
  limits.parts = 4000, limits.values = 20'000, limits.name_bytes = 1u << 20;
  return limits;
}

void demand(bool holds) {
  if (!holds) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  Result<Scene> scene = parse_scene(text, "fuzz.json", small_limits());
  // Whatever is JSON is JSON5 too.
  const Result<Scene> loose = parse_scene(text, "fuzz.json5", small_limits());
  demand(bool(loose) || !bool(scene));
  if (!scene) {
    demand(!scene.errors().empty());
    for (const Error& e : scene.errors()) demand(e.message == printable(e.message));
    return 0;
  }
  for (const std::string& line : scene->warnings) demand(line == printable(line));
  World& world = scene->world;
  if (world.bodies.size() > 200 || world.links.size() > 200) return 0;
  compile_if_changed(world);
  if (world.bodies.size() > 20 || world.links.size() + world.cables.size() + world.pins.size() > 20)
    return 0;
  Simulation sim = Simulation::copy_of(world, {scene->step, 1, 1, true});
  sim.step();
  return 0;
}
