#pragma once
// Where a method fails: what `pantin stability` measures. The criteria are documented in
// engine/solvers/STABILITY.md.
#include <array>
#include <nlohmann/json.hpp>

#include "tools/pantin/journal.hpp"
#include "tools/pantin/measure.hpp"

namespace pantin::program {

/// What a run suffers from, the most serious first.
enum class Symptom : std::uint8_t {
  refused,
  blows_up,
  no_convergence,
  tears,
  gains_energy,
  sinks,
  freezes,
  jitters,
  stalls,
  ok
};
/// "blows up": its word in files and pictures.
std::string_view word_of(Symptom symptom);
std::optional<Symptom> symptom_named(std::string_view word);

/// What was measured of a run, and what follows.
struct Verdict {
  Symptom worst = Symptom::ok;
  std::vector<Symptom> all;  // in order
  Json measured;
};

/// Parameters of a run that is judged.
struct Case {
  const Loaded* loaded = nullptr;
  double step = 0, duration = 0;  // s
  double tolerance = 1e-6;        // of an adaptive method
};
Verdict judge(const Case& run);

/// An axis of a map: the step, the tolerance of adaptive methods, or numbers of the scene.
struct Axis {
  std::string name;                   // as given
  std::vector<std::string> pointers;  // empty: the step or the tolerance
  double from = 0, to = 0;
  bool is_log = false, is_whole = false;
  /// The value at a part of the way, 0 to 1.
  double at(double part) const;
};

/// A square of a map, or an interval of a line, in units of the finest lattice.
struct Cell {
  int x = 0, y = 0, size = 0;
};

struct MapChoices {
  std::string scene, out = "out/stability";
  std::vector<std::string> over, methods;
  std::optional<double> duration, step;  // s
  double time = 300;                     // s, in all
  int grid = 8, halvings = 2;
  bool json = false, afresh = false;
};

/// A map of one method: symptoms at the corners of cells. Cells whose corners differ are divided,
/// until they are as small as asked for or the time is over.
class Map {
 public:
  /// The symptom at a place, each part from 0 to 1; nothing: stopped.
  using Ask = std::function<std::optional<Symptom>(double, double)>;
  Map(int grid, int halvings, std::size_t axes)
      : grid_(grid), size_(grid << halvings), is_plane_(axes > 1) {}

  /// False if it was stopped; the cells that are then known cover the whole map if any do.
  bool draw(const Ask& ask);
  const std::vector<Cell>& cells() const { return cells_; }
  Symptom at(int x, int y) const { return known_.at({x, y}); }
  const std::map<std::pair<int, int>, Symptom>& points() const { return known_; }
  int size() const { return size_; }

 private:
  bool know_corners(const Cell& cell, const Ask& ask);
  bool is_even(const Cell& cell) const;

  int grid_, size_;
  bool is_plane_;
  std::vector<Cell> cells_;
  std::map<std::pair<int, int>, Symptom> known_;
};

}  // namespace pantin::program
