#include "engine/runtime/monitor.hpp"

#include <algorithm>

#include "engine/joints/kinds.hpp"
#include "engine/world/cable_route.hpp"
#include "engine/world/partition.hpp"

namespace pantin::detail {
namespace {

/// Of a mechanism's size: by so much its joints may be open.
constexpr Real kOpen = 1e-3;

}  // namespace

void Monitor::note(FindingKind kind, Entity where, Real amount) {
  const auto same = [&](const Finding& f) { return f.kind == kind && f.where == where; };
  const auto found = std::find_if(findings_.begin(), findings_.end(), same);
  if (found != findings_.end()) {
    found->amount = std::max(found->amount, amount), ++found->steps;
  } else if (findings_.size() < kMost) {
    findings_.push_back({kind, where, time_, amount, 1});
  }
}

/// How far the anchors of a mechanism lie apart, as it was built; of bodies it is added up.
void Monitor::find_sizes(const World& world) {
  findings_.reserve(kMost);
  sizes_.assign(world.bodies.size(), 0);
  const Partition& partition = partition_of(world);
  std::vector<Vec3> low(partition.islands.size(), Vec3(1e300)), high(low.size(), Vec3(-1e300));
  const auto island_of = [&](Entity e) {
    const std::uint32_t slot = world.bodies.slot(e);
    return slot < partition.island.size() ? partition.island[slot] : Owner::kNone;
  };
  const auto add = [&](std::uint32_t island, Entity e, Vec3 anchor) {
    const Body* b = world.bodies.find(e);
    if (!b || island == Owner::kNone) return;
    const Vec3 at = to_world(b->pose, anchor);
    low[island] = glm::min(low[island], glm::min(at, b->pose.position));
    high[island] = glm::max(high[island], glm::max(at, b->pose.position));
  };
  const auto add_both = [&](Entity a, Entity b, Vec3 on_a, Vec3 on_b) {
    for (const std::uint32_t island : {island_of(a), island_of(b)})
      add(island, a, on_a), add(island, b, on_b);
  };
  for (const Link& l : world.links.values()) add_both(l.a, l.b, l.joint.anchor_a, l.joint.anchor_b);
  for (const Cable& c : world.cables.values())
    add_both(c.a, c.b, c.joint.anchor_a, c.joint.anchor_b);
  for (std::uint32_t i = 0; i < sizes_.size() && i < partition.island.size(); ++i)
    if (partition.island[i] != Owner::kNone)
      sizes_[i] =
          std::max(Real(0), glm::length(high[partition.island[i]] - low[partition.island[i]]));
  built_for_ = world.structure();
}

void Monitor::check_joints(const World& world) {
  const auto size_of = [&](Entity a, Entity b) {
    const std::uint32_t on_a = world.bodies.slot(a), on_b = world.bodies.slot(b);
    return std::max(on_a < sizes_.size() ? sizes_[on_a] : 0,
                    on_b < sizes_.size() ? sizes_[on_b] : 0);
  };
  for (std::uint32_t i = 0; i < world.links.size(); ++i) {
    const Link& l = world.links.values()[i];
    const Body *a = world.bodies.find(l.a), *b = world.bodies.find(l.b);
    const JointKindInfo& info = info_of(l.joint.kind);
    if (!a || !b || info.counts_turns || info.rows == 0) continue;
    const Real gap = info.gap(l.joint, a->pose, b->pose);
    if (gap > kOpen * size_of(l.a, l.b))
      note(FindingKind::joint_open, world.links.owners()[i], gap);
  }
  for (std::uint32_t i = 0; i < world.cables.size(); ++i) {
    const Cable& c = world.cables.values()[i];
    if (c.joint.compliance > 0 || !c.guides.empty()) continue;
    const Body *a = world.bodies.find(c.a), *b = world.bodies.find(c.b);
    const Real over = a && b ? stretch(c.joint, a->pose, b->pose) : 0;
    if (over > kOpen * size_of(c.a, c.b))
      note(FindingKind::cable_overlong, world.cables.owners()[i], over);
  }
}

void Monitor::end_step(const World& world, StepReport& report) {
  const std::size_t before = findings_.size();
  time_ = world.time;
  if (built_for_ != world.structure()) find_sizes(world);
  energy_.each_gain(world, [&](const EnergyAccount::Gain& gain) {
    note(FindingKind::energy_gained, gain.body, gain.amount);
  });
  check_joints(world);
  report.findings = static_cast<int>(findings_.size() - before);
}

}  // namespace pantin::detail
