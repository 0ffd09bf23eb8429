#include "engine/scene/build/group_builder.hpp"

#include <utility>

namespace pantin::detail {

BuiltScene build_group(BuildContext& context, const Group& group, std::uint32_t number) {
  return GroupBuilder(context, group, number).build();
}

BuiltScene GroupBuilder::build() {
  using B = GroupBuilder;
  gather_names();
  if (!make_space()) return std::move(made_);
  place_bodies();
  each(group_.bodies, ElementKind::body, &B::add_body);
  each(group_.chains, ElementKind::chain, &B::add_links_of);
  each(group_.instances, ElementKind::instance, &B::add_instance);
  each(group_.grids, ElementKind::grid, &B::add_grid);
  each(group_.mirrors, ElementKind::mirror, &B::mirror_bodies);
  each(group_.paths, ElementKind::drive, &B::add_drive);
  each(group_.chains, ElementKind::chain, &B::add_joints_of);
  each(group_.joints, ElementKind::joint, &B::add_joint);
  each(group_.gears, ElementKind::ratio, &B::add_gear);
  each(group_.belts, ElementKind::belt, &B::add_belt);
  each(group_.surface_joints, ElementKind::surface_joint, &B::add_surface_joint);
  each(group_.cables, ElementKind::string, &B::add_cable);
  each(group_.pins, ElementKind::pin, &B::add_pin);
  mirror_links();
  each(group_.poses, ElementKind::pose, &B::add_pose);
  each(group_.events, ElementKind::event, &B::add_event);  // all other elements exist now
  each(group_.sensors, ElementKind::sensor, &B::add_sensor);
  return std::move(made_);
}

// ---- Names ----

void GroupBuilder::gather_names() {
  broken_.insert(group_.broken.begin(), group_.broken.end());
  const auto note = [&](const auto& items) {
    for (const auto& x : items)
      if (!x.name.empty()) own_names_.insert(x.name);
  };
  note(group_.bodies), note(group_.instances), note(group_.chains);
  note(group_.joints), note(group_.gears), note(group_.cables), note(group_.pins);
  note(group_.surface_joints), note(group_.belts);
  for (const GridRecipe& grid : group_.grids) own_names_.insert(grid.each.name);
}

/// Whether a name refers into a member that could not be read or built; it is then not reported as
/// unknown.
bool GroupBuilder::is_below_broken(const std::string& name) const {
  const std::size_t end = name.find('/');
  return end != std::string::npos && broken_.contains(name.substr(0, end));
}

std::optional<std::uint32_t> GroupBuilder::look_up(const Places& places, const std::string& name,
                                                   const Wanted& wanted) {
  const auto it = places.find(name);
  if (it != places.end()) return it->second;
  if (is_below_broken(name)) return std::nullopt;
  std::vector<std::string_view> names;  // in order of creation
  if (messages_.hints().any_left()) {
    names.resize(&places == &bodies_ ? made_.bodies.size() : made_.joints.size());
    for (std::size_t i = 0; i < names.size(); ++i)
      names[i] = &places == &bodies_ ? made_.bodies[i].name : made_.joints[i].name;
  }
  messages_.error(wanted.from, wanted.member,
                  "found " + quoted_name(name) + ", expected " + std::string(wanted.what) +
                      messages_.hints().of(name, names));
  return std::nullopt;
}

std::optional<std::uint32_t> GroupBuilder::body_or_world(const std::string& name,
                                                         const ElementId& from,
                                                         std::string_view member) {
  if (name == "world") return kWorldBody;
  return look_up(bodies_, name, {from, member, "the name of a body or \"world\""});
}

std::optional<std::uint32_t> GroupBuilder::body(const std::string& name, const ElementId& from,
                                                std::string_view member) {
  return look_up(bodies_, name, {from, member, "the name of a body"});
}

/// A name of the form "a-b" for an object without a name.
std::string GroupBuilder::name_for(const std::string& given, const std::string& a,
                                   const std::string& b) {
  if (!given.empty()) return given;
  const std::string base = a + "-" + b;
  // Counts on from the last number of the same base, to avoid a search.
  int& count = unnamed_[base];
  std::string name;
  do name = ++count == 1 ? base : base + "#" + std::to_string(count);
  while (!own_names_.insert(name).second);
  return name;
}

// ---- Counts: checked before anything is built, since a few lines can ask for millions. ----

const BuiltPrefab* GroupBuilder::prefab_of(const InstanceRecipe& instance, const ElementId& id) {
  const BuiltPrefab* prefab = context_.prefab(instance.prefab, id, "prefab");
  if (!prefab) broken_.insert(instance.name);
  return prefab;
}

bool GroupBuilder::make_space() {
  BuildCount count;
  count.bodies = static_cast<Real>(group_.bodies.size());
  count.links =
      static_cast<Real>(group_.joints.size() + group_.gears.size() + group_.cables.size() +
                        group_.pins.size() + group_.surface_joints.size() + group_.belts.size());
  for (const BodyRecipe& b : group_.bodies)
    count.parts += static_cast<Real>(b.mass_properties.shapes.size());
  bool good = true;
  const auto see = [&](const BuildCount& more, Real times, const ElementId& id) {
    count.add(more, times);
    good = good && fits(count, id);
  };
  for (std::uint32_t i = 0; i < group_.chains.size(); ++i) {
    const ChainRecipe& chain = group_.chains[i];
    const Real names = 2 * static_cast<Real>(chain.name.size() + 16);
    const Real shapes = static_cast<Real>(chain.link.mass_properties.shapes.size());
    count.links += 1;
    see({1, 1, shapes, 0, names}, chain.links, {ElementKind::chain, number_, i});
  }
  const auto see_copies = [&](const InstanceRecipe& of, const BuiltPrefab& p, Real times) {
    BuildCount each = p.count;
    each.name_bytes += (each.bodies + each.links) * static_cast<Real>(of.name.size() + 8);
    each.copies = times > 1 ? 1 : 0;
    return each;
  };
  for (std::uint32_t i = 0; i < group_.instances.size(); ++i) {
    const ElementId id{ElementKind::instance, number_, i};
    of_instances_.push_back(prefab_of(group_.instances[i], id));
    if (of_instances_.back()) see(see_copies(group_.instances[i], *of_instances_.back(), 1), 1, id);
  }
  for (std::uint32_t i = 0; i < group_.grids.size(); ++i) {
    const GridRecipe& grid = group_.grids[i];
    const ElementId id{ElementKind::grid, number_, i};
    const Real times = Real(1) * grid.count[0] * grid.count[1] * grid.count[2];
    of_grids_.push_back(prefab_of(grid.each, id));
    if (of_grids_.back()) see(see_copies(grid.each, *of_grids_.back(), times), times, id);
  }
  if (!good || !fits(count, {ElementKind::group, number_, 0})) return false;
  made_.bodies.reserve(static_cast<std::size_t>(count.bodies));
  bodies_.reserve(static_cast<std::size_t>(count.bodies));
  context_.used.add(count, 1);
  return true;
}

bool GroupBuilder::fits(const BuildCount& count, const ElementId& at) {
  const auto check = [&](Real BuildCount::*which, std::size_t limit, const char* what) {
    // Prefabs are kept while they are copied, so each counts once more.
    const Real here = count.*which, all = here + context_.used.*which,
               most = static_cast<Real>(limit);
    if (here <= most && all <= 2 * most) return true;
    const Real found = here > most ? here : all;
    // Integers up to where a double no longer resolves units.
    const std::string number =
        found < 9e15 ? std::to_string(static_cast<std::uint64_t>(found)) : written(found);
    const std::string limited = std::to_string(here > most ? limit : 2 * limit);
    messages_.error(at, "",
                    "found " + number + " " + what + (here > most ? "" : " with all prefabs") +
                        ", expected at most " + limited);
    return false;
  };
  const SceneLimits& limits = context_.limits;
  return check(&BuildCount::bodies, limits.bodies, "bodies") &&
         check(&BuildCount::links, limits.links, "joints, gears, cables and pins") &&
         check(&BuildCount::parts, limits.parts, "shapes and keyframes") &&
         check(&BuildCount::copies, limits.copies, "copies of prefabs") &&
         check(&BuildCount::name_bytes, limits.name_bytes, "bytes of names");
}

}  // namespace pantin::detail
