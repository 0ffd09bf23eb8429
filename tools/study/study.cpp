// Measures the solvers: reference problems, orders, energies, work against error, cost.
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <functional>
#include <string>

#ifdef __GLIBC__
#include <malloc.h>
#endif

#include "engine/base/atomic_file.hpp"
#include "engine/solvers/lagrangian/internal.hpp"
#include "tools/study/pairs.hpp"
#include "tools/study/stiff.hpp"
#include "tools/study/surface_forms.hpp"

#ifdef PANTIN_HAS_EIGEN
#include <Eigen/Dense>
#endif

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::study;

namespace {

constexpr const char* kUsage = R"(usage: study WHAT [--small] [--form NAME] [--json] [--csv FILE]

Measures the solvers and prints what it found.

  references  every reference problem: error, drift of energy, open joints, CPU time
  orders      error against step
  energy      energy of a double pendulum over a minute
  work        CPU time against error, chains of 10 and 50 links, every solver
  stiff       CPU time against error of a governor with stiff springs
  surface_forms  forms of the constraint of surfaces that touch: error and cost
  pairs       the narrow phase for two shapes of each kind: time, error, points
  cost        one solve against a dense factorisation; time and memory for up to 100,000 bodies

  --small     a few points of each, in a second or two
  --form NAME one of the forms of surface_forms: analytic, gap_central, gap_richardson (the gap's
              rows by differences), paper_central, paper_richardson (C_p, C_tan and C_roll)
  --json      print one array of objects, a row each, keys as the columns' names
  --csv FILE  write comma separated values to FILE, not to the standard output

CPU times are medians of repeated runs on one thread; `spread` is the widest of them less the
narrowest, part of the median.

Examples:
  study references
  study cost --small --json
  study surface_forms --form paper_richardson
  study work --csv work.csv
)";

bool small = false;
std::optional<SurfaceForm> wanted;
std::FILE* out = stdout;

void tell(const std::string& what) {
  if (isatty(STDERR_FILENO)) std::fprintf(stderr, "\r\033[K%s", what.c_str());
}

struct Timing {
  double seconds = 0, spread = 0;
};

/// Runs `once`, which returns its own CPU seconds, until it has been seen often enough.
Timing time_often(const std::function<double()>& once) {
  std::vector<double> times;
  double total = 0;
  const std::size_t least = small ? 1 : 5;
  while (times.size() < least || (total < (small ? 0 : 0.3) && times.size() < 100)) {
    times.push_back(once());
    total += times.back();
    if (total > 20) break;
  }
  const auto [low, high] = std::minmax_element(times.begin(), times.end());
  return {median(times), (*high - *low) / std::max(median(times), 1e-12)};
}

/// A way of stepping, by the words of charts.
struct Method {
  const char* name;
  Solver solver;
  Integrator integrator;
};
constexpr Method kMethods[] = {
    {"euler", Solver::lagrangian, Integrator::euler},
    {"rattle", Solver::lagrangian, Integrator::rattle},
    {"rk4", Solver::lagrangian, Integrator::rk4},
    {"implicit", Solver::lagrangian, Integrator::implicit},
    {"auto", Solver::articulated, Integrator::rk4},
    {"shake2", Solver::shake2, Integrator::rk4},
    {"sweep", Solver::sweep, Integrator::rk4},
};

World with(World w, const Method& method, Real tolerance = 0) {
  w.default_settings.solver = method.solver;
  w.default_settings.integrator = method.integrator;
  w.default_settings.step_tolerance = tolerance;
  return w;
}

void references(const std::string& folder) {
  std::vector<Problem> problems = read_problems(folder);
  for (const HangingStart start : {HangingStart::at_rest, HangingStart::straight_halves})
    for (Problem& p : read_hanging_chains(folder, start)) problems.push_back(std::move(p));
  const bool table = out == stdout;
  if (table)
    std::printf("%-22s %-32s %-7s %-9s %-8s %-8s %-8s %-8s %-9s %s\n", "problem", "case", "steps",
                "h or tol", "error", "energy", "open", "rank", "CPU s", "spread");
  else
    std::fprintf(out,
                 "problem,case,steps,step_s,tolerance,error,energy_drift_j,constraint,rows,"
                 "least_rank,cpu_s,spread\n");
  for (const Problem& given : problems)
    for (const bool adaptive : {false, true}) {
      if (adaptive && given.file == "catenary") continue;
      if (small && (given.id.find("N40") != std::string::npos || given.id.ends_with("settles")))
        continue;
      tell(given.file + " " + given.id);
      Problem p = given;
      if (adaptive) p.world.default_settings.step_tolerance = 1e-10;
      const int divisions = adaptive ? 1 : p.divisions;
      const Score s = score(p, divisions);
      const Timing t = time_often([&] { return time_of(p, divisions, 1); });
      const double drift = p.conserves ? s.energy : NAN;
      if (table) {
        std::printf("%-22s %-32s %-7s %-9.3g %-8.1e %-8.1e %-8.1e %3d/%-4d %-9.4f %.0f %%%s\n",
                    p.file.c_str(), p.id.c_str(), adaptive ? "rk54" : "rk4",
                    adaptive ? 1e-10 : p.every / divisions, s.error, drift, s.constraint,
                    s.least_rank, s.rows, t.seconds, 100 * t.spread,
                    s.status == Status::ok ? "" : "  failed");
        std::fflush(out);
      } else {
        std::fprintf(out, "%s,%s,%s,%.9g,%g,%.3e,%.3e,%.3e,%d,%d,%.4e,%.3f\n", p.file.c_str(),
                     p.id.c_str(), adaptive ? "rk54" : "rk4", p.every / divisions,
                     adaptive ? 1e-10 : 0.0, s.error, drift, s.constraint, s.rows, s.least_rank,
                     t.seconds, t.spread);
      }
    }
  tell("");
}

/// Worlds at times that are `every` apart, s; the first is `every` after the start.
struct Way {
  Real every = 0;
  std::vector<World> worlds;
};

/// `count` Worlds, by the pair of Runge-Kutta within 1e-13.
Way exact_way(const World& start, Real every, int count) {
  Simulation sim(with(start, kMethods[2], 1e-13), {every});
  Way way{every, {}};
  for (int i = 0; i < count; ++i) {
    sim.step();
    way.worlds.push_back(sim.world);
  }
  return way;
}

/// How far two Worlds are apart: distance() or difference().
using Apart = Real(const World&, const World&);

/// The worst of `apart` from the exact way; infinite where the run failed.
Real error_along(const World& start, const Way& way, int divisions, Apart& apart) {
  Simulation sim = Simulation::copy_of(start, {way.every / divisions});
  Real worst = 0;
  for (const World& at : way.worlds) {
    for (int i = 0; i < divisions; ++i)
      if (sim.step().status == Status::diverged) return INFINITY;
    worst = std::max(worst, apart(sim.world, at));
  }
  return worst;
}

void orders() {
  std::fprintf(out, "method,step_s,error\n");
  const World start = chain(5, 1, kPi / 2);
  const Way way = exact_way(start, 0.5, 1);
  for (const Method& method : kMethods) {
    if (method.solver == Solver::sweep) continue;
    tell(method.name);
    for (int divisions = 25; divisions <= (small ? 50 : 1600); divisions *= 2)
      std::fprintf(out, "%s,%.9g,%.6e\n", method.name, 0.5 / divisions,
                   error_along(with(start, method), way, divisions, difference));
  }
  tell("");
}

void energy() {
  std::fprintf(out, "method,time_s,energy_j\n");
  const int steps = small ? 300 : 6000;
  for (const Method& method : kMethods) {
    if (method.solver == Solver::sweep) continue;
    tell(method.name);
    Simulation sim(with(chain(2, 1, kPi / 2), method), {0.01});
    for (int i = 0; i <= steps; ++i) {
      if (i % 5 == 0)
        std::fprintf(out, "%s,%.2f,%.9g\n", method.name, 0.01 * i, measure(sim.world).energy());
      sim.step();
    }
  }
  tell("");
}

double time_run(const World& start, Real every, int count, int divisions) {
  Simulation sim = Simulation::copy_of(start, {every / divisions});
  const double from = cpu_seconds();
  for (int i = 0; i < count * divisions; ++i) sim.step();
  return cpu_seconds() - from;
}

void work() {
  constexpr Real kEvery = 0.1;
  const int count = small ? 2 : 10;
  std::fprintf(out, "links,method,step_s,tolerance,error,cpu_per_second,spread\n");
  for (const int links : {10, 50}) {
    if (small && links > 10) break;
    const Real length = 0.1;
    const World start = chain(links, length, kPi / 4);
    const Way way = exact_way(start, kEvery, count);
    const auto point = [&](const char* name, const World& w, int divisions, Real tolerance) {
      tell(std::to_string(links) + " links, " + name);
      const Real error = error_along(w, way, divisions, distance) / (links * length);
      if (!(error < 1)) return;
      const Timing t = time_often([&] { return time_run(w, kEvery, count, divisions); });
      std::fprintf(out, "%d,%s,%.9g,%g,%.4e,%.4e,%.3f\n", links, name, kEvery / divisions,
                   tolerance, error, t.seconds / (count * kEvery), t.spread);
    };
    for (const Method& method : kMethods)
      for (int divisions = 3; divisions <= (small ? 6 : 400); divisions *= 2)
        point(method.name, with(start, method), divisions, 0);
    for (Real tolerance = 1e-3; tolerance > (small ? 1e-5 : 5e-12); tolerance *= 0.1)
      point("rk54", with(start, kMethods[2], tolerance), 1, tolerance);
  }
  tell("");
}

/// Bytes in use on the heap; 0 where the library does not tell.
double bytes_in_use() {
#ifdef __GLIBC__
  const struct mallinfo2 all = mallinfo2();
  return static_cast<double>(all.uordblks) + static_cast<double>(all.hblkhd);
#else
  return 0;
#endif
}

/// A dense LU of the equations of an Island.
struct Dense {
  double seconds = NAN;
  Real apart = NAN;  // its accelerations from the sparse ones, part of the greatest
};

#ifdef PANTIN_HAS_EIGEN
/// `a`: the sparse accelerations from the same `known`.
Dense time_dense(const lagrangian::Island& m, const lagrangian::Known& known,
                 std::span<const Vec3> a) {
  const auto bodies = static_cast<Eigen::Index>(m.count());
  const auto rows = static_cast<Eigen::Index>(m.rows), all = 6 * bodies + rows;
  Eigen::MatrixXd k = Eigen::MatrixXd::Zero(all, all);
  Eigen::VectorXd b(all);
  for (Eigen::Index i = 0; i < bodies; ++i) {
    const auto n = static_cast<std::size_t>(i);
    const Mat3 take = glm::inverse(m.scratch.inverse_inertia[n]);
    for (int r = 0; r < 3; ++r) {
      k(6 * i + r, 6 * i + r) = m.mass[n];
      for (int c = 0; c < 3; ++c) k(6 * i + 3 + r, 6 * i + 3 + c) = take[c][r];
      b(6 * i + r) = known.force[2 * n][r], b(6 * i + 3 + r) = known.force[2 * n + 1][r];
    }
  }
  for (const lagrangian::Block& block : m.blocks)
    for (std::size_t r = 0; r < block.rows; ++r)
      for (std::size_t e = 0; e < block.count; ++e) {
        if (block.body[e] >= m.count()) continue;
        const Eigen::Index row = 6 * bodies + static_cast<Eigen::Index>(block.first_row + r);
        const lagrangian::RowVectors j =
            lagrangian::row_of(block, &m.scratch.jacobian[block.first_vector], r, e);
        for (int c = 0; c < 6; ++c) {
          const Vec3& part = c < 3 ? j.v : j.w;
          const Eigen::Index column = 6 * Eigen::Index{block.body[e]} + c;
          k(row, column) += part[c % 3], k(column, row) += part[c % 3];
        }
      }
  for (Eigen::Index r = 0; r < rows; ++r)
    b(6 * bodies + r) = known.right[static_cast<std::size_t>(r)];
  const double from = cpu_seconds();
  const Eigen::VectorXd x = Eigen::PartialPivLU<Eigen::Ref<Eigen::MatrixXd>>(k).solve(b);
  const double seconds = cpu_seconds() - from;
  Real most = 1e-300, apart = 0;
  for (Eigen::Index i = 0; i < 6 * bodies; ++i) {
    most = std::max(most, std::abs(x(i)));
    apart = std::max(apart, std::abs(x(i) - a[static_cast<std::size_t>(i / 3)][int(i % 3)]));
  }
  return {seconds, apart / most};
}
#endif

constexpr int kSizes[] = {100, 1000, 10000, 100000};

/// How times grow with sizes: the slope of their logarithms.
struct Growth {
  std::vector<double> sizes, times;
  void add(int size, double seconds) {
    sizes.push_back(std::log(size)), times.push_back(std::log(seconds));
  }
  double exponent() const {
    double x = 0, y = 0, xx = 0, xy = 0;
    const auto count = static_cast<double>(sizes.size());
    for (std::size_t i = 0; i < sizes.size(); ++i) x += sizes[i] / count, y += times[i] / count;
    for (std::size_t i = 0; i < sizes.size(); ++i)
      xx += (sizes[i] - x) * (sizes[i] - x), xy += (sizes[i] - x) * (times[i] - y);
    return xy / xx;
  }
};

void cost() {
  std::fprintf(out,
               "what,integrator,bodies,seconds,spread,bytes_per_body,dense_seconds,ratio,apart\n");
  for (const int n : {100, 300, 1000}) {
    if (small && n > 100) break;
    tell("one solve, " + std::to_string(n) + " bodies");
    Simulation sim(chain(n, 0.1, kPi / 4), {1e-3});
    for (int i = 0; i < 3; ++i) sim.step();
    lagrangian::Island& m = lagrangian::islands_of(sim.world).at(0);
    std::vector<Vec3> a(2 * m.count()), force(2 * m.count(), Vec3(0));
    for (std::size_t b = 0; b < m.count(); ++b) force[2 * b].y = -9.81 * m.mass[b];
    const std::vector<Real> right(m.rows, 0);
    std::vector<Real> lambda(m.rows);
    const Timing t = time_often([&] {
      const double from = cpu_seconds();
      lagrangian::factor(m);
      lagrangian::solve(m, {force, right}, {a, lambda});
      return cpu_seconds() - from;
    });
    Dense dense;
#ifdef PANTIN_HAS_EIGEN
    dense = time_dense(m, {force, right}, a);
#endif
    std::fprintf(out, "solve,,%d,%.4e,%.3f,,%.4e,%.1f,%.2e\n", n, t.seconds, t.spread,
                 dense.seconds, dense.seconds / t.seconds, dense.apart);
    std::fflush(out);
  }
  // Places, rows, forces, factor and solution at one instant.
  Growth accelerations;
  for (const int n : kSizes) {
    if (small && n > 1000) break;
    tell("accelerations, " + std::to_string(n) + " bodies");
    const double before = bytes_in_use();
    Simulation sim(with(chain(n, 0.1, kPi / 4), kMethods[2]), {1e-3});
    sim.step();
    const double held = bytes_in_use() - before;
    lagrangian::Island& m = lagrangian::islands_of(sim.world).at(0);
    const Timing t = time_often([&] {
      const double from = cpu_seconds();
      for (int i = 0; i < 20000 / n + 1; ++i) lagrangian::accelerate(sim.world, m, 0, 1e-3);
      return (cpu_seconds() - from) / (20000 / n + 1);
    });
    accelerations.add(n, t.seconds);
    std::fprintf(out, "acceleration,,%d,%.4e,%.3f,%.0f,,,\n", n, t.seconds, t.spread, held / n);
    std::fflush(out);
  }
  std::fprintf(out, "exponent,,,%.3f,,,,,\n", accelerations.exponent());
  for (const Method& method : kMethods) {
    if (method.solver != Solver::lagrangian) continue;
    Growth steps;
    for (const int n : kSizes) {
      if (small && n > 1000) break;
      tell(std::string(method.name) + ", " + std::to_string(n) + " bodies");
      // The tension of a longer chain makes its links quicker: as many steps a period for all.
      Simulation sim(with(chain(n, 0.1, kPi / 4), method), {1e-2 / std::sqrt(n)});
      sim.step();
      const Timing t = time_often([&] {
        const double from = cpu_seconds();
        sim.step();
        return cpu_seconds() - from;
      });
      steps.add(n, t.seconds);
      std::fprintf(out, "step,%s,%d,%.4e,%.3f,,,,\n", method.name, n, t.seconds, t.spread);
      std::fflush(out);
    }
    std::fprintf(out, "exponent,%s,,%.3f,,,,,\n", method.name, steps.exponent());
  }
  tell("");
}

}  // namespace

namespace {

/// The rows of `csv` as one JSON array of objects; what is no number is a string, no value null.
void print_json(std::FILE* csv) {
  const auto cells = [](const std::string& line) {
    std::vector<std::string> all(1);
    for (const char c : line)
      if (c == ',')
        all.emplace_back();
      else if (c != '\n')
        all.back() += c;
    return all;
  };
  const auto value = [](const std::string& cell) -> std::string {
    char* end = nullptr;
    const double x = std::strtod(cell.c_str(), &end);
    if (cell.empty() || (*end == 0 && !std::isfinite(x))) return "null";
    return *end == 0 ? cell : '"' + cell + '"';
  };
  char line[4096];
  std::vector<std::string> names;
  const char* before = "[\n  ";
  while (std::fgets(line, sizeof line, csv)) {
    const std::vector<std::string> row = cells(line);
    if (names.empty()) {
      names = row;
      continue;
    }
    std::printf("%s{", before);
    before = ",\n  ";
    for (std::size_t i = 0; i < row.size() && i < names.size(); ++i)
      std::printf("%s\"%s\": %s", i > 0 ? ", " : "", names[i].c_str(), value(row[i]).c_str());
    std::printf("}");
  }
  std::printf("\n]\n");
}

std::string text_of(std::FILE* file) {
  std::string text;
  char some[4096];
  std::rewind(file);
  while (const std::size_t n = std::fread(some, 1, sizeof some, file)) text.append(some, n);
  return text;
}

int fail_to_write(const std::string& file) {
  return std::fprintf(stderr, "study: could not write %s\n", file.c_str()), 4;
}

int refuse_form(const char* found, const char* expected) {
  return std::fprintf(stderr, "study: --form: found \"%s\", expected %s\n", found, expected), 2;
}

}  // namespace

int main(int argc, char** argv) {
  std::string what, file;
  bool json = false;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--help" || word == "-h") return std::fputs(kUsage, stdout), 0;
    if (word == "--small")
      small = true;
    else if (word == "--json")
      json = true;
    else if (word == "--form" && i + 1 < argc) {
      if (!(wanted = form_named(argv[++i]))) return refuse_form(argv[i], kFormNames);
    } else if (word == "--csv" && i + 1 < argc)
      file = argv[++i];
    else if (what.empty() && word[0] != '-')
      what = word;
    else
      return std::fprintf(stderr, "study: found \"%s\"; see study --help\n", argv[i]), 2;
  }
  if (wanted && what != "surface_forms")
    return refuse_form(what.c_str(), "the study surface_forms");
  const std::pair<const char*, std::function<void()>> studies[] = {
      {"references", [] { references(PANTIN_STUDY_DATA); }},
      {"orders", orders},
      {"energy", energy},
      {"work", work},
      {"stiff", [] { measure_stiff(out, small ? Extent::few_points : Extent::all); }},
      {"surface_forms",
       [] { measure_surface_forms(out, small ? FormSteps::few : FormSteps::all, wanted); }},
      {"pairs", [] { measure_pairs(out, small ? PairSample::few : PairSample::many); }},
      {"cost", cost}};
  for (const auto& [name, run] : studies) {
    if (what != name) continue;
    if (!file.empty() || json) out = std::tmpfile();
    if (!out) return fail_to_write("a temporary file");
    try {
      run();
    } catch (const std::exception& e) {
      return std::fprintf(stderr, "study: %s\n", e.what()), 1;
    }
    if (std::fflush(out) != 0 || std::ferror(out)) return fail_to_write("its numbers");
    if (json) std::rewind(out), print_json(out);
    if (!file.empty() && !write_file(file, text_of(out))) return fail_to_write(file);
    return 0;
  }
  std::fprintf(stderr,
               "study: expected references, orders, energy, work, stiff, surface_forms, pairs or "
               "cost; see study --help\n");
  return 2;
}
