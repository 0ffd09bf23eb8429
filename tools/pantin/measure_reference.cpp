// Motions that others are compared with: by refinement, or from a file.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <unordered_map>

#include "engine/base/rotation.hpp"
#include "engine/scene/json/text_file.hpp"
#include "engine/world/timed_event.hpp"
#include "tools/pantin/measure.hpp"

namespace pantin::program {
namespace {

constexpr double kFinest = 1e-11;  // of the size: no finer agreement is asked for
constexpr double kGain = 0.7;      // a refinement that gains less has no gain

/// Two consecutive refinements of one method.
struct Pair {
  Track finest;
  double step = 0;  // s, of the finest
  Apart own;
  std::size_t agreed = 0, compared = 0;
  double whole = std::numeric_limits<double>::infinity();  // m, apart over all of the time
  Apart whole_apart;
};

/// `all`: the number of samples of a whole run.
Pair pair_of(const Track& coarse, const Track& fine, double step, std::size_t all) {
  Pair pair;
  pair.finest = fine, pair.step = step;
  pair.agreed = agreement(coarse, fine, kAgreement * scale_of(fine));
  pair.compared = pair.agreed;
  if (pair.agreed < all) pair.compared = (pair.agreed + 1) / 2;
  pair.own = apart(coarse, fine, pair.compared);
  if (coarse.samples() == all && fine.samples() == all)
    pair.whole_apart = apart(coarse, fine, all), pair.whole = pair.whole_apart.position;
  return pair;
}

/// Whether `a` agrees for longer than `b`, or as long and better by the factor `by`.
bool is_better(const Pair& a, const Pair& b, double by = 1) {
  return a.agreed != b.agreed ? a.agreed > b.agreed : a.own.position < by * b.own.position;
}

/// Whether a refinement gains on the best one before, or, where both part, comes closer after that:
/// what is struck moves exactly until then, and at a rate of the first order afterwards.
bool gains(const Pair& a, const Pair& best, double least_whole) {
  return is_better(a, best, kGain) || a.whole < kGain * least_whole;
}

/// Makes a pair that comes closer over the whole time one that agrees there, if an event would be
/// unseen otherwise.
void see_events(const World& world, const Search& search, double least_whole, Pair& pair) {
  if (!event_after(world, search.sampling, pair.compared)) return;
  if (!(pair.whole < kGain * least_whole) || pair.whole > kConverges * scale_of(pair.finest))
    return;
  pair.agreed = pair.compared = search.sampling.samples();
  pair.own = pair.whole_apart;
}

/// The first run. Where it does not end within a tenth of the time, it is begun anew with a step so
/// long that a refinement fits into the time, too.
Outcome first_run(Trial& trial, double seconds) {
  const double from = wall_seconds();
  const auto stop = std::move(trial.stop);
  trial.stop = [&](double) { return wall_seconds() > from + 0.1 * seconds; };
  Outcome first = run_motion(trial);
  trial.stop = stop;
  if (first.status != "stopped" || interrupted()) return first;
  double whole = (wall_seconds() - from) * trial.sampling.duration() / first.ended_at;
  double steps = std::round(trial.sampling.interval / trial.step);
  for (; 3.3 * whole > 0.8 * seconds && std::fmod(steps, 2) == 0; whole /= 2, steps /= 2)
    trial.step *= 2;
  return run_motion(trial);
}

/// Halves the step until nothing is gained; the best pair, or one without a step.
Pair refine(const Loaded& loaded, const Search& search) {
  Trial trial{&*loaded.scene, search.step, 0, search.sampling};
  const std::size_t all = search.sampling.samples();
  const double end = wall_seconds() + search.seconds;
  trial.stop = [&](double) { return wall_seconds() > end; };
  Pair best;
  Track last;
  int without_gain = 0;
  double least_whole = std::numeric_limits<double>::infinity();
  for (int n = 0; without_gain < 2; ++n, trial.step /= 2) {
    const double from = wall_seconds();
    Outcome now = n == 0 ? first_run(trial, search.seconds) : run_motion(trial);
    if (now.status == "stopped") break;
    if (n > 0) {
      Pair pair = pair_of(last, now.track, trial.step, all);
      see_events(loaded.scene->world, search, least_whole, pair);
      without_gain = n == 1 || gains(pair, best, least_whole) ? 0 : without_gain + 1;
      least_whole = std::min(least_whole, pair.whole);
      if (n == 1 || is_better(pair, best)) best = std::move(pair);
      if (best.agreed == all && best.own.position < kFinest * scale_of(best.finest)) break;
    }
    last = std::move(now.track);
    // Half the step takes about twice the time.
    if (2.2 * (wall_seconds() - from) > end - wall_seconds()) break;
  }
  return best;
}

/// Into how many parts an interval of so many rows is divided: as many as memory allows.
int parts_kept(std::size_t rows, std::size_t poses) {
  for (std::size_t parts = rows; parts > 1; --parts)
    if (rows % parts == 0 && parts * poses <= kMostPoses) return static_cast<int>(parts);
  return 1;
}

/// The columns of a table with a name in the first line.
class Table {
 public:
  explicit Table(std::string text) : text_(std::move(text)) {}
  /// An empty string, or what is wrong.
  std::string read();
  std::size_t rows() const { return names_.empty() ? 0 : numbers_.size() / names_.size(); }
  /// A column, or SIZE_MAX.
  std::size_t column(const std::string& name) const {
    const auto found = names_.find(name);
    return found == names_.end() ? SIZE_MAX : found->second;
  }
  double at(std::size_t row, std::size_t column) const { return numbers_[row * width_ + column]; }

 private:
  std::vector<std::string> fields_of(std::string_view line) const;
  std::string text_;
  std::unordered_map<std::string, std::size_t> names_;
  std::vector<double> numbers_;
  std::size_t width_ = 0;
};

std::vector<std::string> Table::fields_of(std::string_view line) const {
  std::vector<std::string> fields(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (c == '"' && quoted && i + 1 < line.size() && line[i + 1] == '"')
      fields.back() += line[++i];
    else if (c == '"')
      quoted = !quoted;
    else if (c == ',' && !quoted)
      fields.emplace_back();
    else if (c != '\r')
      fields.back() += c;
  }
  return fields;
}

std::string Table::read() {
  std::size_t number = 0;
  for (std::size_t at = 0; at < text_.size();) {
    const std::size_t end = std::min(text_.find('\n', at), text_.size());
    const std::string_view line(text_.data() + at, end - at);
    at = end + 1, ++number;
    if (line.empty() || line.front() == '#') continue;
    const std::vector<std::string> fields = fields_of(line);
    if (width_ == 0) {
      width_ = fields.size();
      for (std::size_t i = 0; i < width_; ++i) names_[fields[i]] = i;
      continue;
    }
    if (fields.size() != width_)
      return fmt::format("{}: found {} fields, expected {} as in the first line", number,
                         fields.size(), width_);
    for (const std::string& f : fields) {
      double x = std::numeric_limits<double>::quiet_NaN();
      const auto read = std::from_chars(f.data(), f.data() + f.size(), x);
      if (!f.empty() && (read.ec != std::errc() || read.ptr != f.data() + f.size()))
        return fmt::format("{}: found \"{}\", expected a number", number, f);
      numbers_.push_back(x);
    }
  }
  return {};
}

/// Says which body does not start as in the World, or nothing.
std::string other_start(const Reference& reference, const World& world) {
  constexpr double kOther = 1e-3;  // of the size
  std::size_t i = 0;
  for (const Entity e : world.bodies.owners()) {
    if (world.bodies[e].motion != Motion::dynamic) continue;
    const Vec3 told = reference.track.poses[i++].position, is = world.origin_pose(e).position;
    if (glm::distance(told, is) > kOther * reference.size)
      return fmt::format(
          "found {} at ({:g}, {:g}, {:g}) at time 0, expected ({:g}, {:g}, {:g}), where it starts "
          "in "
          "the scene",
          world.name_of(e), told.x, told.y, told.z, is.x, is.y, is.z);
  }
  return {};
}

}  // namespace

Reference find_reference(std::span<const Loaded> methods, const Search& search) {
  // The most accurate ones first; the scene's own last: its contacts may have another model.
  constexpr std::string_view kOrder[] = {"lagrangian/radau", "lagrangian/rk4", "scene"};
  const std::size_t all = search.sampling.samples();
  Reference reference;
  Pair best;
  Search part = search;
  part.seconds = search.seconds / 2;
  for (const std::string_view name : kOrder) {
    const auto loaded = std::ranges::find(
        methods, name, [](const Loaded& l) { return std::string_view(l.method.name); });
    if (loaded == methods.end() || !loaded->scene || interrupted()) continue;
    Pair pair = refine(*loaded, part);
    if (pair.step == 0) continue;
    const double size = scale_of(pair.finest);
    reference.tried.push_back({loaded->method.name, pair.step, pair.own, pair.agreed});
    if (best.step > 0 && !is_better(pair, best)) continue;
    best = std::move(pair);
    reference.method = loaded->method.name, reference.size = size;
    if (best.agreed == all && best.own.position < 1e-6 * size) break;
  }
  reference.step = best.step, reference.own = best.own, reference.agreed = best.agreed;
  reference.compared = best.compared;
  reference.track = std::move(best.finest);
  // What agrees for less than an interval has been compared at no step of some runs.
  if (reference.compared <= static_cast<std::size_t>(search.sampling.between))
    reference.agreed = reference.compared = 0;
  return reference;
}

std::optional<double> event_after(const World& world, const Sampling& sampling,
                                  std::size_t samples) {
  const auto* events = detail::events_of(world);
  if (!events || samples >= sampling.samples()) return std::nullopt;
  const double seen =
      static_cast<double>(std::max<std::size_t>(samples, 1) - 1) * sampling.spacing();
  double first = sampling.duration();
  for (const TimedEvent& event : events->values())
    std::visit(
        [&](const auto& e) {
          double at = 0, every = 0;
          if constexpr (requires { e.from; })
            at = e.from;
          else
            at = e.at;
          if constexpr (requires { e.every; }) every = e.every;
          if (at <= seen && every > 0) at += every * (std::floor((seen - at) / every) + 1);
          if (at > seen) first = std::min(first, at);
        },
        event.kind);
  return first < sampling.duration() ? std::optional(first) : std::nullopt;
}

Result<Reference> read_reference(const std::string& path, const World& world, int most,
                                 Sampling& sampling) {
  constexpr std::size_t kMostBytes = 1u << 30;
  Result<std::string> text = read_text(path, kMostBytes, "a record of a run");
  if (!text) return text.errors();
  Table table(std::move(*text));
  if (const std::string fault = table.read(); !fault.empty()) return Error{path + ":" + fault};
  const std::size_t time = table.column("time_s"), rows = table.rows();
  if (time == SIZE_MAX || rows < 2)
    return Error{path + ": found no two rows with a column time_s, expected a record of a run"};
  const std::size_t each =
      (rows - 1 + static_cast<std::size_t>(most) - 1) / static_cast<std::size_t>(most);
  const double spacing = table.at(1, time) - table.at(0, time);
  for (std::size_t r = 0; r < rows; ++r)
    if (!(std::abs(table.at(r, time) - static_cast<double>(r) * spacing) <= 1e-6 * spacing))
      return Error{
          fmt::format("{}: found time_s = {:g} in row {}, expected {:g}: equal intervals from 0",
                      path, table.at(r, time), r + 1, static_cast<double>(r) * spacing)};
  Reference reference;
  reference.method = path, reference.track = track_for(world);
  const double unknown = std::numeric_limits<double>::quiet_NaN();
  std::size_t known = 0;
  std::vector<std::array<std::size_t, 7>> columns;
  for (const Entity e : world.bodies.owners()) {
    if (world.bodies[e].motion != Motion::dynamic) continue;
    const std::string name = world.name_of(e);
    std::array<std::size_t, 7>& c = columns.emplace_back();
    constexpr const char* kParts[] = {".x", ".y", ".z", ".qx", ".qy", ".qz", ".qw"};
    for (std::size_t k = 0; k < c.size(); ++k) c[k] = table.column(name + kParts[k]);
    known += c[0] != SIZE_MAX && c[1] != SIZE_MAX && c[2] != SIZE_MAX;
  }
  if (known == 0)
    return Error{path +
                 ": found no column of a body of the scene, expected NAME.x, NAME.y, NAME.z"};
  const std::size_t energy = table.column("energy_j");
  sampling = {spacing * static_cast<double>(each), static_cast<int>((rows - 1) / each),
              parts_kept(each, (rows - 1) / each * columns.size())};
  const std::size_t skip = each / static_cast<std::size_t>(sampling.between);
  for (std::size_t r = 0; reference.track.samples() < sampling.samples(); r += skip) {
    const auto cell = [&](std::size_t c) { return c == SIZE_MAX ? unknown : table.at(r, c); };
    for (const auto& c : columns)
      reference.track.poses.push_back({{cell(c[0]), cell(c[1]), cell(c[2])},
                                       Quat(cell(c[6]), cell(c[3]), cell(c[4]), cell(c[5]))});
    reference.track.energies.push_back(cell(energy));
  }
  reference.agreed = reference.compared = reference.track.samples();
  reference.own = {unknown, unknown, unknown, unknown};
  Track finite = reference.track;
  std::erase_if(finite.poses, [](const Pose& p) { return !is_finite(p.position); });
  reference.size = scale_of(finite);
  if (std::string fault = other_start(reference, world); !fault.empty())
    return Error{path + ": " + fault};
  return reference;
}

}  // namespace pantin::program
