#pragma once
// A lamina's motion by modes and by dynamics, in rows of the same times.
#include <array>
#include <string>
#include <vector>

#include "tools/pantin/modes.hpp"

namespace pantin::program {

constexpr int kRows = 101;

/// The contact of a finger, averaged over a row.
struct AtFinger {
  double normal = 0, tangent = 0;       // N
  double slip = 0;                      // m/s, maximum
  double bears = 0;                     // fraction of the time in contact
  bool sticks = false, slides = false;  // predicted state
};
/// Mass centre (m) and angle (rad) at the end of a row, and means over the row.
struct Row {
  Vec2 at;
  double angle = 0;
  double inertia = 0;  // N: mass times acceleration
  std::vector<AtFinger> fingers;
};

struct Run {
  std::vector<Row> rows;  // at equal parts of the duration
};

/// The motion by modes. If there is no feasible mode, the rows end.
struct Prediction {
  Run run;
  StepEnd end;
  double time = 0;  // s, at the end
  bool zeno = false;
  std::vector<std::size_t> choices;  // most feasible modes at once, by row
  std::vector<int> index;            // of the chosen mode, by row
};
Prediction predict(const LaminaPlan& plan, double duration);

/// The motion by dynamics, with the fingers slower by a factor. A finger's coefficient is that of
/// sliding while it slips by more than a fifth of the fastest finger's speed, else that of
/// sticking. Returns nothing after an error, or an interruption.
std::optional<Run> simulate(const Scene& like, const LaminaPlan& plan, double duration,
                            double slower);

/// The path length of the fastest finger, m, and its greatest speed, m/s.
double way_of(const LaminaPlan& plan, double duration);
double speed_of(const LaminaPlan& plan, double duration);

/// Where two runs diverge.
struct Parting {
  double worst = 0;  // m, largest distance between outline points
  int row = -1;      // the first at which they differ by kApart of the path length; -1: none
};
constexpr double kApart = 0.02;

/// The violation of a quasi-static assumption.
struct Breach {
  double size = 0, bound = 1;
  std::string words;
  double part() const { return size / bound; }
};
/// All violations where the runs diverge, in descending ratio to their bounds.
std::vector<Breach> breaches(const LaminaPlan& plan, const Prediction& q, const Run& run,
                             const Parting& p);

}  // namespace pantin::program
