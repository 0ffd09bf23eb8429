#pragma once
// A lamina's motion by modes and by dynamics, row by row of the same table.
#include <array>
#include <string>
#include <vector>

#include "tools/pantin/modes.hpp"

namespace pantin::program {

constexpr int kRows = 101;

/// What a finger does, in the mean over a row.
struct AtFinger {
  double normal = 0, tangent = 0;       // N
  double slip = 0;                      // m/s, the most
  double bears = 0;                     // part of the time
  bool sticks = false, slides = false;  // as predicted
};
/// Mass centre (m) and angle (rad) at the end of a row, and the row before it.
struct Row {
  Vec2 at;
  double angle = 0;
  double inertia = 0;  // N: mass times acceleration
  std::vector<AtFinger> fingers;
};

struct Run {
  std::vector<Row> rows;  // at equal parts of the duration
};

/// By modes. Where they have no answer the rows end.
struct Prediction {
  Run run;
  StepEnd end;
  double time = 0;  // s, of the end
  bool zeno = false;
  std::vector<std::size_t> choices;  // most modes that held at once, by row
  std::vector<int> index;            // of the mode, by row
};
Prediction predict(const LaminaPlan& plan, double duration);

/// By dynamics, the fingers slower by a factor. A finger's coefficient is that of sliding where the
/// lamina slips on it by more than a fifth of the fastest finger's speed, else that of rolling.
/// Nothing after a complaint, or an interruption.
std::optional<Run> simulate(const Scene& like, const LaminaPlan& plan, double duration,
                            double slower);

/// The way of the fastest finger, m, and its greatest speed, m/s.
double way_of(const LaminaPlan& plan, double duration);
double speed_of(const LaminaPlan& plan, double duration);

/// Where two runs part.
struct Parting {
  double worst = 0;  // m, of any point of the outline
  int row = -1;      // from which on they are apart by kApart of the way; -1: nowhere
};
constexpr double kApart = 0.02;

/// How much of an assumption of quasi-statics did not hold.
struct Breach {
  double size = 0, bound = 1;
  std::string words;
  double part() const { return size / bound; }
};
/// All of them where the runs part, the largest beside its bound first.
std::vector<Breach> breaches(const LaminaPlan& plan, const Prediction& q, const Run& run,
                             const Parting& p);

}  // namespace pantin::program
