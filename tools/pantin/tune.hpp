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
  enum class End : std::uint8_t { none, met, over, dearer, fails, finest, time };
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
  std::optional<double> unseen;  // s: an event after all that can be compared
  std::optional<Pick> choice;    // the best one that was found
  bool is_met = false;
  double frame = 0;  // s, the step that all groups of a scene share; 0: it has one group
  const Ladder& method() const { return ladders[choice->ladder]; }
  const Attempt& attempt() const { return method().attempts[choice->attempt]; }
};

/// Errors at or below this one, of the reference alone, count as equal.
double error_floor(const Reference& reference);

/// Where a run with a tolerance or step is measured.
struct Measuring {
  const Subject& subject;
  const Reference& reference;
  Journal& journal;
  double until = 0;  // s of the clock on the wall: no run is begun that takes longer
};
struct Setting {
  double step = 0, tolerance = 0;  // s; 0: not adaptive
};
/// Runs and times a setting, which then is the last attempt of the ladder; one that the journal
/// knows is not repeated. If it takes too much of the time, the ladder ends instead.
Result<Done> try_setting(const Measuring& in, Ladder& ladder, const Setting& setting);

/// So many steps in an interval that they are steps of the sampling, nearest to the mean of two
/// numbers in ratio, and between these; 0: there is none.
double steps_between(const Sampling& sampling, double few, double many);

/// One ladder for each method that is asked for; ended where the method refuses the scene.
std::vector<Ladder> ladders_of(const Subject& subject, const TuneChoices& choices);

// Rounds that time close settings in turn, and the factor of costs that are close. The least time
// counts: load only adds to it.
inline constexpr int kRounds = 5;
inline constexpr double kClose = 1.5;
inline constexpr int kMostFailures = 4;  // a ladder ends where so many runs in a row fail

/// A scene that was read at some time, s of the clock on the wall.
struct Begun {
  Subject subject;
  double at = 0;
};
/// Searches one choice for the whole scene; without one if it was interrupted or no run succeeded.
Result<Tuning> tune_whole(const TuneChoices& choices, Journal& journal, Begun begun);

/// "step 2.5 ms", "tolerance 1e-05".
std::string words_of(const Attempt& attempt);
/// Why a method was or was not chosen: a word for programs, and a sentence.
struct Why {
  std::string verdict, sentence;
};
Why why_of(const Tuning& tuning, const TuneChoices& choices, std::size_t ladder);
/// Why nothing is vouched for where an event is unseen, a sentence.
std::string words_of_unseen(const Tuning& tuning);
/// "the 12 settings that were tried", and of how many methods the finer ones were not.
std::string words_of_tried(const Tuning& tuning);

/// The text of the scene with the choice as its keys "solver" and "step". An error: the file then
/// moves differently from what was measured, because its bodies have settings of their own.
Result<std::string> with_choice(const Tuning& tuning);

}  // namespace pantin::program
