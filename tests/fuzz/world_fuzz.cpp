// The bytes of a saved World, behind a header that fits them: what a forger would write. Whatever
// they are, they are read or refused with a line; a World that was read can be stepped.
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <string>

#include "engine/base/hash.hpp"
#include "engine/base/utf8.hpp"
#include "engine/runtime/save.hpp"
#include "engine/runtime/simulation.hpp"

using namespace pantin;
using namespace pantin::detail;

namespace {

constexpr std::size_t kPrefix = 20;  // magic, version, layout
constexpr std::size_t kHeader = kPrefix + 16;

/// The same payload with the header that save_world would have written before it.
std::string sealed(std::string bytes) {
  static const std::string empty = world_to_bytes(World{}).value();
  if (bytes.size() < kHeader) bytes.resize(kHeader);
  const std::uint64_t size = bytes.size() - kHeader;
  Hash hash;
  hash.add(std::string_view(bytes).substr(kHeader));
  const std::uint64_t checksum = hash.value();
  std::memcpy(bytes.data(), empty.data(), kPrefix);
  std::memcpy(bytes.data() + kPrefix, &size, sizeof size);
  std::memcpy(bytes.data() + kPrefix + 8, &checksum, sizeof checksum);
  return bytes;
}

void demand(bool holds) {
  if (!holds) std::abort();
}

/// No input is merely slow.
void bound_work(SolverSettings& s) {
  s.sweeps = std::min(s.sweeps, 50);
  if (s.step_tolerance < 1e-9) s.step_tolerance = 0;
}

void try_it(const std::string& bytes) {
  Result<World> world = world_from_bytes(bytes);
  if (!world) {
    demand(!world.errors().empty());
    for (const Error& e : world.errors()) demand(e.message == printable(e.message));
    return;
  }
  const std::size_t ties = world->links.size() + world->cables.size() + world->pins.size();
  if (world->bodies.size() > 20 || ties > 20) return;
  bound_work(world->default_settings);
  for (SolverSettings& s : world->settings.values()) bound_work(s);
  Simulation simulation(std::move(*world), {1.0 / 60, 1, 1, true});
  simulation.step();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  if (size % 16 == 0) try_it(bytes);
  try_it(sealed(bytes));
  return 0;
}
