// The choices of `pantin tune` as keys of a scene file.
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "engine/base/utf8.hpp"
#include "engine/scene/json/json.hpp"
#include "engine/scene/json/words.hpp"
#include "engine/world/integrators.hpp"
#include "engine/world/partition.hpp"
#include "engine/world/solver_list.hpp"
#include "tools/pantin/scene_number.hpp"
#include "tools/pantin/tune_groups.hpp"

namespace pantin::program {

using namespace detail;

namespace {

using Keys = std::vector<std::pair<std::string, std::string>>;

std::string quoted(std::string_view word) { return fmt::format("\"{}\"", word); }

/// Solver keys of a method, with their values.
Keys keys_of(const Method& method, double tolerance) {
  const SolverChoices& c = method.choices;
  Keys keys;
  if (c.solver) keys.emplace_back("type", quoted(info_of(*c.solver).name));
  if (c.integrator) keys.emplace_back("integrator", quoted(info_of(*c.integrator).name));
  if (tolerance > 0) keys.emplace_back("step_tolerance", number_text(tolerance));
  return keys;
}

std::string object_of(const Keys& keys) {
  std::string whole;
  for (const auto& [key, value] : keys)
    whole += fmt::format("{}\"{}\": {}", whole.empty() ? "" : ", ", key, value);
  return "{" + whole + "}";
}

/// Whether a text, run with its own settings, moves as what was measured.
bool moves_alike(const Subject& subject, const Trial& asked, const std::string& text) {
  const Loaded own = load(subject.path, text, *method_named("scene"));
  if (!own.scene || own.scene->step != asked.step) return false;
  const Outcome a = run_motion(asked);
  const Outcome b = run_motion({&*own.scene, asked.step, 0, subject.sampling});
  const auto same = [](const Pose& p, const Pose& q) {
    return p.position == q.position && p.rotation == q.rotation;
  };
  return a.is_ok() && b.is_ok() && std::ranges::equal(a.track.poses, b.track.poses, same);
}

JsonDocument parsed(std::string_view text) {
  JsonLimits limits;
  limits.style = JsonStyle::json5;
  return parse_json(text, limits);
}

/// The scene's step, without keys by which it chooses solvers itself.
Result<std::string> with_step(const std::string& text, double step) {
  Result<std::string> base = with_value(text, "/step", number_text(step));
  for (const auto& [key, none] : {std::pair("error", "0"), std::pair("plane", "false")})
    if (base && parsed(*base).member(0, key) != kNoNode)
      base = with_value(*base, fmt::format("/{}", key), none);
  return base;
}

/// The text with the scene's own solver: first with all other settings of the file, then without
/// those that the method does not know.
std::vector<std::string> with_solver(const std::string& base, const Keys& keys) {
  std::vector<std::string> texts;
  Result<std::string> text = base;
  for (const auto& [key, value] : keys)
    if (text) text = with_value(*text, "/solver/" + key, value);
  if (text) texts.push_back(*text);
  if (keys.empty()) return texts;
  text = with_value(base, "/solver", object_of(keys));
  if (text) texts.push_back(*text);
  return texts;
}

/// The object of the scene's own lists that gives a body its solver: the body, its chain, or the
/// instance, grid or ring of which it is a copy.
std::string place_of(const JsonDocument& json, std::string_view body) {
  const std::vector<std::vector<std::string_view>> lists = {{"bodies"},
                                                            {"generators", "chains"},
                                                            {"instances"},
                                                            {"generators", "grids"},
                                                            {"generators", "rings"}};
  for (const std::vector<std::string_view>& keys : lists) {
    NodeId list = 0;
    for (const std::string_view key : keys)
      if (list != kNoNode)
        list = json[list].kind == JsonKind::object ? json.member(list, key) : kNoNode;
    if (list == kNoNode || json[list].kind != JsonKind::array) continue;
    for (NodeId at = json[list].first_child; at != kNoNode; at = json[at].next) {
      const NodeId name = json[at].kind == JsonKind::object ? json.member(at, "name") : kNoNode;
      if (name == kNoNode) continue;
      const std::string_view own = json[name].text;
      const bool is_copy = body.starts_with(own) && body.substr(own.size()).starts_with('/');
      if (keys.size() == 1 && keys[0] == "bodies" ? body == own : is_copy) return json.pointer(at);
    }
  }
  return {};
}

/// Settings that the groups of a choice have in the file.
class Writer {
 public:
  explicit Writer(const GroupTuning& t)
      : t_(t), json_(parsed(t.subject.text)), common_(most_common()) {}

  Result<std::string> write();

 private:
  Keys keys(std::size_t kind) const {
    const Composition& c = *t_.choice();
    return keys_of(t_.ladder(c, kind).loaded->method, t_.attempt(c, kind).tolerance);
  }
  Keys most_common() const;
  std::string collect();
  std::string note(std::size_t kind, const Group& group, const IslandPlan& island);

  const GroupTuning& t_;
  JsonDocument json_;
  Keys common_;                         // of the scene itself
  std::map<std::string, Keys> places_;  // by the pointer of their object
  std::set<std::string> own_;           // those that differ from the scene's, or have had their own
};

/// The settings of the most bodies. Groups that keep those of the file do not count.
Keys Writer::most_common() const {
  std::map<Keys, std::size_t> bodies;
  for (std::size_t k = 0; k < t_.kinds.size(); ++k)
    for (const std::size_t g : t_.grouping.kinds[k].groups)
      if (!keys(k).empty()) bodies[keys(k)] += t_.grouping.groups[g].bodies.size();
  if (bodies.empty()) return {};
  return std::ranges::max_element(bodies, {}, [](const auto& b) { return b.second; })->first;
}

/// Adds the settings of an island; returns why they cannot be written, or nothing.
std::string Writer::note(std::size_t kind, const Group& group, const IslandPlan& island) {
  const World& world = t_.subject.own().world;
  Entity first = world.bodies.owners()[island.slots.front()];
  bool has_own = false;
  for (const std::uint32_t slot : island.slots)
    if (const Entity e = world.bodies.owners()[slot]; !has_own && world.settings.find(e))
      first = e, has_own = true;
  const std::string place = place_of(json_, world.name_of(first));
  if (place.empty())
    return keys(kind) == common_ && !has_own
               ? ""
               : fmt::format(
                     "the choice for {} cannot be written: body {} is in none of the "
                     "scene's own lists",
                     group.name, world.name_of(first));
  const auto [at, is_new] = places_.emplace(place, keys(kind));
  if (!is_new && at->second != keys(kind))
    return fmt::format("the choice for {} cannot be written: {} has one solver for all its copies",
                       group.name, place);
  if (keys(kind) != common_ || has_own) own_.insert(place);
  return "";
}

std::string Writer::collect() {
  const World& world = t_.subject.own().world;
  for (std::size_t k = 0; k < t_.kinds.size(); ++k) {
    if (keys(k).empty()) continue;
    for (const std::size_t g : t_.grouping.kinds[k].groups)
      for (const IslandPlan& island : find_islands(world)) {
        const Group& group = t_.grouping.groups[g];
        if (std::ranges::find(group.bodies, world.bodies.owners()[island.slots.front()]) ==
            group.bodies.end())
          continue;
        if (std::string fault = note(k, group, island); !fault.empty()) return fault;
      }
  }
  return "";
}

Result<std::string> Writer::write() {
  const std::string& path = t_.subject.path;
  if (const std::string fault = collect(); !fault.empty()) return Error{path + ": " + fault};
  const Result<std::string> base = with_step(t_.subject.text, t_.choice()->step);
  if (!base) return base;
  const Scene scene = composed(t_, *t_.choice());
  const Trial asked{&scene, t_.choice()->step, 0, t_.subject.sampling};
  for (const std::string& start : with_solver(*base, common_)) {
    Result<std::string> text = start;
    for (const std::string& place : own_)
      if (text) text = with_value(*text, place + "/solver", object_of(places_[place]));
    if (text && moves_alike(t_.subject, asked, *text)) return text;
  }
  return Error{path +
               ": the choice cannot be written: the file with it would move otherwise than "
               "what was measured"};
}

}  // namespace

Result<std::string> with_choice(const Tuning& t) {
  const Keys keys = keys_of(t.method().loaded->method, t.attempt().tolerance);
  const Result<std::string> base = with_step(t.subject.text, t.attempt().step);
  if (!base || keys.empty()) return base;
  const Trial asked{&*t.method().loaded->scene, t.attempt().step, t.attempt().tolerance,
                    t.subject.sampling};
  for (const std::string& text : with_solver(*base, keys))
    if (moves_alike(t.subject, asked, text)) return text;
  return Error{t.subject.path +
               ": found solver settings of single bodies or instances, which the choice would have "
               "to replace: remove them to have it written"};
}

Result<std::string> with_groups(const GroupTuning& t) { return Writer(t).write(); }

}  // namespace pantin::program
