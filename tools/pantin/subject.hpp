#pragma once
// A scene that is measured under all methods, and the motion of reference that its journal keeps.
#include "tools/pantin/journal.hpp"
#include "tools/pantin/measure.hpp"

namespace pantin::program {

/// A scene under all methods, with the times at which motions are compared.
struct Subject {
  std::string path, text;
  std::string key;             // of its results in a journal
  std::vector<Loaded> loaded;  // by all_methods(); the last has the settings of the file
  Sampling sampling;
  double coarsest = 0;  // s, the longest step
  const Scene& own() const { return *loaded.back().scene; }
  /// The number of longest steps in an interval of the sampling.
  double coarsest_steps() const;
  const Loaded& method(const std::string& name) const;
};

/// The time that is simulated, and the longest step.
struct Span {
  std::optional<double> duration, coarsest;  // s; the scene's, and `coarser` times its step
  double coarser = 2;
};
inline constexpr int kMostSamples = 200;

/// Reads a scene with every method. An error: it does not load with its own settings.
Result<Subject> read_subject(const std::string& path, const Span& span);

/// The reference from the journal, or a search for one, which is kept. One from the journal has no
/// motion until rerun() repeats it.
Result<Reference> reference_of(const Subject& subject, Journal& journal, const Search& search);
void rerun(const Subject& subject, Reference& reference);

/// The exact motion of the scene from exact/NAME.csv beside it, which tools/exact writes, up to the
/// duration of the sampling, which then has its times. Nothing where there is no such file, where
/// it is of another text than the scene's, which is told, or where it ends sooner.
Result<std::optional<Reference>> exact_motion(Subject& subject);

/// The time of the first event after the part of the motion that the reference covers, s, where
/// that is not all of it: what an event starts is not seen there.
std::optional<double> event_unseen(const Subject& subject, const Reference& reference);

/// A number for JSON: null if it is not finite.
Json json_number(double x);

}  // namespace pantin::program
