#pragma once
// The cheapest way to run a scene that meets an error, or the most accurate one within a cost.
#include "tools/pantin/subject.hpp"

namespace pantin::program {

struct TuneChoices {
  std::string scene, out, results = "out/tune";
  std::vector<std::string> methods;
  std::optional<double> error;               // largest, as a fraction of the motion's size
  std::optional<double> time;                // us of CPU time for a simulated second, at most
  std::optional<double> coarsest, duration;  // s
  double within = 60;                        // s, for the search
  int rungs = 8;
  bool json = false, afresh = false;
};

/// A run of a method at one setting.
struct Attempt {
  double step = 0, tolerance = 0;  // s; 0: not adaptive
  std::string status, reason;
  double error = 0;  // position, with the reference's own, as a fraction of the motion's size
  double cost = 0;   // CPU time of the steps, s for a simulated second
  bool is_ok() const { return status == "ok"; }
};

/// What is known of a method.
struct Ladder {
  /// Why no finer step is tried.
  enum class End : std::uint8_t { none, met, over, dearer, stalls, fails, finest, time };
  const Loaded* loaded = nullptr;
  std::vector<Attempt> attempts;
  double next = 0;  // s that the next run takes, as far as it can be known
  End end = End::none;
};

/// An attempt of a method.
struct Pick {
  std::size_t ladder = 0, attempt = 0;
};

struct Tuning {
  Subject subject;
  Reference reference;
  std::vector<Ladder> ladders;
  std::optional<Pick> choice;  // the best one that was found
  bool is_met = false;
  const Ladder& method() const { return ladders[choice->ladder]; }
  const Attempt& attempt() const { return method().attempts[choice->attempt]; }
};

/// Errors at or below this one, of the reference alone, count as equal.
double error_floor(const Reference& reference);

/// Searches; without a choice if it was interrupted or no run succeeded.
Result<Tuning> tune_scene(const TuneChoices& choices, Journal& journal);

/// "step 2.5 ms", "tolerance 1e-05".
std::string words_of(const Attempt& attempt);
/// Why a method was or was not chosen: a word for programs, and a sentence.
struct Why {
  std::string verdict, sentence;
};
Why why_of(const Tuning& tuning, const TuneChoices& choices, std::size_t ladder);

/// The text of the scene with the choice as its keys "solver" and "step". An error: the file then
/// moves differently from what was measured, because its bodies have settings of their own.
Result<std::string> with_choice(const Tuning& tuning);

}  // namespace pantin::program
