// Motions that others are compared with: by refinement, or from a file.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <unordered_map>

#include "engine/base/rotation.hpp"
#include "engine/scene/json/text_file.hpp"
#include "tools/pantin/measure.hpp"

namespace pantin::program {
namespace {

constexpr double kFinest = 1e-11;  // of the size: no finer agreement is asked for

std::size_t bodies_of(const Track& track) { return track.names.size(); }

/// The distance of the bodies at a sample, m and rad. A pose that is not finite is not known.
Apart apart_at(const Track& a, const Track& b, std::size_t sample) {
  Apart d;
  const std::size_t n = bodies_of(a);
  for (std::size_t i = sample * n; i < (sample + 1) * n; ++i) {
    const Pose &p = a.poses[i], &q = b.poses[i];
    if (const double far = glm::length(p.position - q.position); !std::isnan(far))
      d.position = std::max(d.position, far);
    const Quat turn = p.rotation * glm::conjugate(q.rotation);
    const double angle =
        2 * std::atan2(glm::length(Vec3(turn.x, turn.y, turn.z)), std::abs(turn.w));
    if (!std::isnan(angle)) d.orientation = std::max(d.orientation, angle);
  }
  if (const double e = std::abs(a.energies[sample] - b.energies[sample]); !std::isnan(e))
    d.energy = e;
  return d;
}

/// Two consecutive refinements of one method.
struct Pair {
  Track finest;
  double step = 0;  // s, of the finest
  Apart own;
  std::size_t agreed = 0, compared = 0;
};

/// `all`: the number of samples of a whole run.
Pair pair_of(const Track& coarse, const Track& fine, double step, std::size_t all) {
  Pair pair{fine, step, {}, 0, 0};
  pair.agreed = agreement(coarse, fine, kAgreement * size_of(fine));
  pair.compared = pair.agreed;
  if (pair.agreed < all) pair.compared = (pair.agreed + 1) / 2;
  pair.own = apart(coarse, fine, pair.compared);
  return pair;
}

/// Whether `a` agrees for longer than `b`, or as long and better by the factor `by`.
bool is_better(const Pair& a, const Pair& b, double by = 1) {
  return a.agreed != b.agreed ? a.agreed > b.agreed : a.own.position < by * b.own.position;
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
  const auto all = static_cast<std::size_t>(search.sampling.count) + 1;
  const double end = wall_seconds() + search.seconds;
  trial.stop = [&](double) { return wall_seconds() > end; };
  Pair best;
  Track last;
  int without_gain = 0;
  for (int n = 0; without_gain < 2; ++n, trial.step /= 2) {
    const double from = wall_seconds();
    Outcome now = n == 0 ? first_run(trial, search.seconds) : run_motion(trial);
    if (now.status == "stopped") break;
    if (n > 0) {
      Pair pair = pair_of(last, now.track, trial.step, all);
      without_gain = n == 1 || is_better(pair, best, 0.7) ? 0 : without_gain + 1;
      if (n == 1 || is_better(pair, best)) best = std::move(pair);
      if (best.agreed == all && best.own.position < kFinest * size_of(best.finest)) break;
    }
    last = std::move(now.track);
    // Half the step takes about twice the time.
    if (2.2 * (wall_seconds() - from) > end - wall_seconds()) break;
  }
  return best;
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

}  // namespace

Apart apart(const Track& a, const Track& b, std::size_t samples) {
  Apart most;
  for (std::size_t s = 0; s < samples; ++s) {
    const Apart d = apart_at(a, b, s);
    most.position = std::max(most.position, d.position);
    most.orientation = std::max(most.orientation, d.orientation);
    most.energy = std::max(most.energy, d.energy);
  }
  return most;
}

std::size_t agreement(const Track& a, const Track& b, double most) {
  const std::size_t both = std::min(a.samples(), b.samples());
  for (std::size_t s = 0; s < both; ++s)
    if (!(apart_at(a, b, s).position <= most)) return s;
  return both;
}

double size_of(const Track& track) {
  Vec3 least(std::numeric_limits<double>::infinity()), most = -least;
  for (const Pose& p : track.poses) least = min(least, p.position), most = max(most, p.position);
  const double size = glm::length(most - least);
  return std::isfinite(size) && size > 0 ? size : 1;
}

Reference find_reference(std::span<const Loaded> methods, const Search& search) {
  // The most accurate ones first; the scene's own last: its contacts may have another model.
  constexpr std::string_view kOrder[] = {"lagrangian/radau", "lagrangian/rk4", "scene"};
  const auto all = static_cast<std::size_t>(search.sampling.count) + 1;
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
    const double size = size_of(pair.finest);
    reference.tried.push_back({loaded->method.name, pair.step, pair.own, pair.agreed});
    if (best.step > 0 && !is_better(pair, best)) continue;
    best = std::move(pair);
    reference.method = loaded->method.name, reference.size = size;
    if (best.agreed == all && best.own.position < 1e-6 * size) break;
  }
  reference.step = best.step, reference.own = best.own, reference.agreed = best.agreed;
  reference.compared = best.compared;
  reference.track = std::move(best.finest);
  return reference;
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
  sampling.interval = spacing * static_cast<double>(each);
  sampling.count = static_cast<int>((rows - 1) / each);
  Reference reference;
  reference.method = path;
  const double unknown = std::numeric_limits<double>::quiet_NaN();
  std::size_t known = 0;
  std::vector<std::array<std::size_t, 7>> columns;
  for (const Entity e : world.bodies.owners()) {
    if (world.bodies[e].motion != Motion::dynamic) continue;
    const std::string name = world.name_of(e);
    reference.track.names.push_back(name);
    std::array<std::size_t, 7>& c = columns.emplace_back();
    constexpr const char* kParts[] = {".x", ".y", ".z", ".qx", ".qy", ".qz", ".qw"};
    for (std::size_t k = 0; k < c.size(); ++k) c[k] = table.column(name + kParts[k]);
    known += c[0] != SIZE_MAX && c[1] != SIZE_MAX && c[2] != SIZE_MAX;
  }
  if (known == 0)
    return Error{path +
                 ": found no column of a body of the scene, expected NAME.x, NAME.y, NAME.z"};
  const std::size_t energy = table.column("energy_j");
  for (std::size_t r = 0; r < rows; r += each) {
    const auto cell = [&](std::size_t c) { return c == SIZE_MAX ? unknown : table.at(r, c); };
    for (const auto& c : columns)
      reference.track.poses.push_back({{cell(c[0]), cell(c[1]), cell(c[2])},
                                       Quat(cell(c[6]), cell(c[3]), cell(c[4]), cell(c[5]))});
    reference.track.energies.push_back(cell(energy));
  }
  reference.agreed = reference.compared = reference.track.samples();
  Track finite = reference.track;
  std::erase_if(finite.poses, [](const Pose& p) { return !is_finite(p.position); });
  reference.size = size_of(finite);
  return reference;
}

}  // namespace pantin::program
