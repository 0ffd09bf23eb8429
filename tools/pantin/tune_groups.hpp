#pragma once
// The cheapest way to run a scene whose groups of bodies may have solvers of their own.
#include "tools/pantin/groups.hpp"
#include "tools/pantin/tune.hpp"

namespace pantin::program {

/// A choice for all groups, with their common frame step.
struct Composition {
  double step = 0;          // s
  std::vector<Pick> picks;  // by kind of group
  double error = 0;         // the greatest of the groups, of their own sizes
  double foreseen = 0;      // s of CPU time for a simulated second: the sum of the groups alone
  // Of a run of the whole scene:
  std::string status, reason;  // empty: none was made
  double measured_error = 0;   // the greatest of the groups
  std::size_t worst = 0;       // and the kind of group that has it
  double cost = 0;             // s of CPU time for a simulated second
};

struct GroupTuning {
  Subject subject;
  Grouping grouping;
  std::vector<Tuning> kinds;           // the search of each kind of group; in the order of grouping
  std::optional<Composition> mixed;    // the best choice by groups, if their methods differ
  std::optional<Composition> uniform;  // the best one of one method for all groups
  bool is_mixed = false;               // `mixed` was chosen
  bool is_met = false;
  const Composition* choice() const { return is_mixed ? &*mixed : uniform ? &*uniform : nullptr; }
  const Ladder& ladder(const Composition& c, std::size_t kind) const {
    return kinds[kind].ladders[c.picks[kind].ladder];
  }
  const Attempt& attempt(const Composition& c, std::size_t kind) const {
    return ladder(c, kind).attempts[c.picks[kind].attempt];
  }
};

/// Beyond that many kinds of groups a scene has one choice for all: each kind is a search.
inline constexpr std::size_t kMostKinds = 24;

Result<GroupTuning> tune_groups(const TuneChoices& choices, Journal& journal, Begun begun,
                                Grouping grouping);

/// The scene as a choice runs it.
Scene composed(const GroupTuning& tuning, const Composition& choice);

/// What was measured of the whole scene under `mixed` or `uniform`; null if there is none.
Json composition_json(const GroupTuning& tuning, const std::optional<Composition>& choice);
void print_groups(const GroupTuning& tuning, const TuneChoices& choices);
/// What keeps a search from its end, or an empty string.
std::string fault_of(const GroupTuning& tuning, const TuneChoices& choices);
/// Why a kind of group has its method, a sentence.
std::string why_of_kind(const GroupTuning& tuning, std::size_t kind);
/// "crank, coupler and 1 more", with the number of its copies.
std::string words_of_kind(const GroupTuning& tuning, std::size_t kind);
/// Why the scene has one choice for all groups, or not.
std::string why_of_scene(const GroupTuning& tuning);

/// The text of the scene with the choice: the step and the most common method as the scene's own,
/// the others as "solver" of bodies, chains or instances. An error: it cannot be written there.
Result<std::string> with_groups(const GroupTuning& tuning);

}  // namespace pantin::program
