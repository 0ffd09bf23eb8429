#include "tools/pantin/findings.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <pantin/measure.hpp>

#include "engine/base/utf8.hpp"

namespace pantin::program {

std::string words_of(const World& world, const Finding& f) {
  const FindingInfo& info = info_of(f.kind);
  return fmt::format("{} from {:.4g} s: {}, {:.3g} {} at worst, in {} steps", info.name, f.time,
                     printable(world.name_of(f.where)), f.amount, info.unit, f.steps);
}

Json findings_json(const World& world, std::span<const Finding> findings) {
  Json all = Json::array();
  for (const Finding& f : findings)
    all.push_back({{"kind", info_of(f.kind).name},
                   {"where", world.name_of(f.where)},
                   {"time_s", f.time},
                   {"amount", f.amount},
                   {"unit", info_of(f.kind).unit},
                   {"steps", f.steps}});
  return all;
}

void print_findings(const Simulation& sim) {
  for (int i = 0; i <= static_cast<int>(last_of(FindingKind{})); ++i) {
    const Finding* worst = nullptr;
    std::size_t places = 0;
    for (const Finding& f : sim.findings()) {
      if (f.kind != static_cast<FindingKind>(i)) continue;
      if (++places == 1 || f.amount > worst->amount) worst = &f;
    }
    if (!worst) continue;
    fmt::print("  found       {}{}\n", words_of(sim.world, *worst),
               places > 1 ? fmt::format("; and {} more, see --json", places - 1) : "");
  }
}

std::size_t unchecked_bodies(const Simulation& sim) {
  const World& world = sim.world;
  return static_cast<std::size_t>(
      std::count_if(world.bodies.owners().begin(), world.bodies.owners().end(), [&](Entity e) {
        return world.bodies[e].motion == Motion::dynamic && !sim.is_energy_checked(e);
      }));
}

Json sensors_json(const Scene& scene, const World& world) {
  Json j = Json::object();
  const auto written = [](Real x) { return std::isfinite(x) ? Json(x) : Json(); };
  for (Sensor sensor : scene.sensors) {
    const Vec3 value = read_sensor(world, sensor);
    if (components_of(sensor.kind) == 1)
      j[sensor.name] = written(value.x);
    else
      j[sensor.name] = {written(value.x), written(value.y), written(value.z)};
  }
  return j;
}

}  // namespace pantin::program
