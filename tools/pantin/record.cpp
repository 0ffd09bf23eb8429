#include "tools/pantin/record.hpp"

#include <fmt/format.h>
#include <fnmatch.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "engine/scene/json/words.hpp"
#include "engine/solvers/lagrangian/lagrangian.hpp"
#include "engine/solvers/solver.hpp"

namespace pantin::program {

using namespace detail;

namespace {

/// A name as a CSV field, quoted if necessary.
std::string field(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string quoted = "\"";
  for (char c : text) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + '"';
}

constexpr Real kNoNumber = std::numeric_limits<Real>::quiet_NaN();

void add_vec(std::vector<Real>& row, Vec3 v) { row.insert(row.end(), {v.x, v.y, v.z}); }

void leave_empty(std::vector<Real>& row, std::size_t cells) {
  row.insert(row.end(), cells, kNoNumber);
}

}  // namespace

/// The columns of a record without --columns.
std::vector<std::string> Record::standard_columns(const World& built) {
  const auto kept = [](const auto& owners) {
    return std::vector<Entity>(owners.begin(), owners.end());
  };
  bodies_ = kept(built.bodies.owners()), links_ = kept(built.links.owners());
  exact_links_.clear();
  std::vector<std::string> names = {"time_s"};
  const auto add = [&](const std::string& prefix, std::initializer_list<const char*> all) {
    for (const char* what : all) names.push_back(prefix + what);
  };
  for (Entity e : bodies_)
    for (const BodyColumn& column : kBodyColumns)
      names.push_back(built.name_of(e) + '.' + column.name);
  for (Entity e : links_) add(built.name_of(e) + '.', {"gap_m"});
  add("", {"kinetic_j", "potential_j", "energy_j", "px", "py", "pz", "lx", "ly", "lz"});
  exact_ = !lagrangian::islands_of(built).empty();
  for (const lagrangian::Island& m : lagrangian::islands_of(built))
    for (const lagrangian::Block& b : m.blocks)
      if (b.kind == lagrangian::BlockKind::joint)
        exact_links_.push_back(lagrangian::joint_of(built, b));
  for (Entity e : exact_links_) add(built.name_of(e) + '.', {"fx", "fy", "fz", "tx", "ty", "tz"});
  if (exact_) add("", {"elastic_j", "rows", "rank", "rescued"});
  return names;
}

/// Keeps the columns that a pattern matches, and time_s; the reason if one matches none.
std::string Record::choose(const std::vector<std::string>& patterns,
                           const std::vector<std::string>& names) {
  std::vector<bool> is_kept(names.size(), false);
  is_kept[0] = true;
  bool any = false;
  for (const std::string& pattern : patterns) {
    bool fits = false;
    for (std::size_t i = 0; i < names.size(); ++i)
      if (fnmatch(pattern.c_str(), names[i].c_str(), 0) == 0) is_kept[i] = fits = true;
    any = any || fits;
    // A scene need not have all that is asked for by a pattern.
    const bool is_last = &pattern == &patterns.back();
    const bool is_pattern = pattern.find_first_of("*?[") != std::string::npos;
    if (fits || (is_pattern && (any || !is_last))) continue;
    const std::vector<std::string_view> known(names.begin(), names.end());
    return fmt::format("--columns: found \"{}\", expected columns of this scene, such as {}{}",
                       pattern, quoted_name(names[std::min<std::size_t>(1, names.size() - 1)]),
                       hint(pattern, known));
  }
  for (std::size_t i = 0; i < names.size(); ++i)
    if (is_kept[i]) chosen_.push_back(i);
  return {};
}

Result<Done> Record::check(const World& world, const RecordChoices& choices) {
  World built = world;
  compile_if_changed(built);
  digits_ = choices.digits;
  names_ = standard_columns(built);
  if (choices.columns.empty()) return Done{};
  standard_ = names_.size();
  events_.emplace(world);
  readings_ = readings_of(built, *events_, choices.step);
  for (Reading& r : readings_of(choices.sensors)) readings_.push_back(std::move(r));
  for (const Reading& r : readings_) names_.push_back(r.name);
  if (std::string fault = choose(choices.columns, names_); !fault.empty())
    return Error{std::move(fault)};
  return Done{};
}

Result<Done> Record::open(const std::string& path) {
  if (auto opened = file_.open(path); !opened) return opened;
  std::string row;
  is_npz_ = path.ends_with(".npz"), arrays_.clear();
  const auto add = [&](const std::string& name) {
    if (!row.empty()) row += ',';
    row += field(name);
    arrays_.push_back({name, {}});
  };
  if (chosen_.empty())
    for (const std::string& name : names_) add(name);
  for (const std::size_t i : chosen_) add(names_[i]);
  return is_npz_ ? Done{} : file_.write(row + '\n');
}

void Record::add_gaps(std::vector<Real>& row, const World& world) const {
  std::vector<Real> gaps;
  for (const Link& l : world.links.values())
    gaps.push_back(glm::length(residual(l.joint, world.bodies[l.a].pose, world.bodies[l.b].pose)));
  for (const lagrangian::Island& mechanism : lagrangian::islands_of(world))
    for (std::size_t i = 0; i < mechanism.blocks.size(); ++i)
      if (const lagrangian::Block& b = mechanism.blocks[i];
          b.kind == lagrangian::BlockKind::joint && b.source < gaps.size())
        gaps[b.source] = lagrangian::joint_gap(world, mechanism, i);
  for (const Entity e : links_) {
    const std::uint32_t slot = world.links.slot(e);
    row.push_back(slot == kNoSlot ? kNoNumber : gaps[slot]);
  }
}

void Record::add_islands(std::vector<Real>& row, const World& world, const Measures& m) const {
  std::size_t rows = 0, rank = 0, rescued = 0;
  std::unordered_map<Entity, lagrangian::ConstraintWrench> wrenches;
  for (const lagrangian::Island& mechanism : lagrangian::islands_of(world)) {
    rows += mechanism.equations(), rank += mechanism.rank, rescued += mechanism.rescues > 0;
    for (std::size_t i = 0; i < mechanism.blocks.size(); ++i)
      if (mechanism.blocks[i].kind == lagrangian::BlockKind::joint)
        wrenches[lagrangian::joint_of(world, mechanism.blocks[i])] =
            lagrangian::joint_wrench(mechanism, i);
  }
  for (const Entity e : exact_links_) {
    const auto f = wrenches.find(e);
    if (f == wrenches.end())
      leave_empty(row, 6);
    else
      add_vec(row, f->second.force), add_vec(row, f->second.torque);
  }
  row.insert(row.end(), {m.elastic, static_cast<Real>(rows), static_cast<Real>(rank),
                         static_cast<Real>(rescued)});
}

Result<Done> Record::add(const World& world, const Measures& m) {
  std::vector<Real> cells = {world.time};
  for (const Entity e : bodies_) {
    const auto body = columns_of_body(world, e);
    cells.insert(cells.end(), body.begin(), body.end());
  }
  add_gaps(cells, world);
  cells.insert(cells.end(), {m.kinetic, m.potential, m.energy()});
  add_vec(cells, m.momentum);
  add_vec(cells, m.angular_momentum);
  if (exact_) add_islands(cells, world, m);
  std::string row;
  std::size_t array = 0;
  const auto write = [&](std::size_t column, Real x) {
    if (is_npz_) return arrays_[array++].values.push_back(x);
    if (column > 0) row += ',';
    if (std::isnan(x)) return;
    if (digits_ > 0)
      fmt::format_to(std::back_inserter(row), "{:.{}g}", x, digits_);
    else
      fmt::format_to(std::back_inserter(row), "{}", x);
  };
  if (events_) events_->update(world);
  for (std::size_t i = 0; chosen_.empty() && i < cells.size(); ++i) write(i, cells[i]);
  for (const std::size_t i : chosen_)
    write(i, i < standard_ ? cells[i] : readings_[i - standard_].value(world));
  row += '\n';
  return is_npz_ ? Done{} : file_.write(row);
}

Result<Done> Record::close() {
  if (is_npz_)
    if (auto written = write_npz(arrays_, file_); !written) return written;
  return file_.commit();
}

}  // namespace pantin::program
