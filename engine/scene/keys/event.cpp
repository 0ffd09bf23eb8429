// Keys of timed events, from the list of their kinds.
#include <array>
#include <memory>
#include <string>
#include <vector>

#include "engine/scene/keys/keys.hpp"
#include "engine/world/solver_list.hpp"
#include "engine/world/timed_event.hpp"

namespace pantin::detail {
namespace {

using namespace rows;

constexpr Range kMoment{0, 1e6, "a time in seconds from 0 to 1e6"};
constexpr Range kRepeat{kShortestRepeat, 1e6, "a time in seconds from 1e-3 to 1e6"};

/// Value types by form, in the order of the forms.
struct FormInfo {
  EventForm form;
  ValueType type;
  Range range = kAnyNumber;
};
constexpr FormInfo kForms[] = {{EventForm::direction, ValueType::vector},
                               {EventForm::axial, ValueType::vector},
                               {EventForm::point, ValueType::vector},
                               {EventForm::anchor, ValueType::vector},
                               {EventForm::vector, ValueType::vector},
                               {EventForm::vector_or_number, ValueType::vector_or_number},
                               {EventForm::number, ValueType::number},
                               {EventForm::degrees, ValueType::number, kDegrees},
                               {EventForm::not_negative, ValueType::number, kNotNegative},
                               {EventForm::positive, ValueType::number, kPositive},
                               {EventForm::size, ValueType::number, kSize},
                               {EventForm::moment, ValueType::number, kMoment},
                               {EventForm::repeat, ValueType::number, kRepeat},
                               {EventForm::whole, ValueType::whole, {0, 1e9, ""}},
                               {EventForm::solver, ValueType::word},
                               {EventForm::reference, ValueType::reference},
                               {EventForm::references, ValueType::references},
                               {EventForm::motion, ValueType::object}};

constexpr bool is_complete_list() {
  for (std::size_t i = 0; i < std::size(kForms); ++i)
    if (kForms[i].form != static_cast<EventForm>(i)) return false;
  return std::size(kForms) == static_cast<std::size_t>(EventForm::motion) + 1;
}
static_assert(is_complete_list());

template <class T>
Key or_else(const Key& key, const T& value) {
  if constexpr (std::is_same_v<T, Vec3>)
    return key.or_else(value.x, value.y, value.z);
  else if constexpr (std::is_arithmetic_v<T>)
    return key.or_else(static_cast<Real>(value));
  else
    return key;
}

Key key_of(const EventKey& from, const auto& member) {
  if (from.form == EventForm::motion) return object(from.key, "drive_motion", from.about);
  const FormInfo& form = kForms[static_cast<std::size_t>(from.form)];
  Key key = row(from.key, form.type, from.unit, from.about).within(form.range);
  key.expected = from.needed.empty() ? from.names : from.needed;
  key.is_needed = !from.needed.empty();
  if (from.form == EventForm::solver) key.words = kSolverNames;
  return from.tells_default ? or_else(key, member) : key;
}

/// Keys of one kind, with storage for the text that their views refer to.
struct EventKeySet {
  std::string what;
  std::vector<Key> keys;
  std::vector<Exclusive> exclusive;
  std::vector<AnyOf> any_of;
  std::vector<Beside> beside;
  KeySet set;

  template <class Event>
  EventKeySet(const Event& event, std::size_t index) : what(std::string(Event::name) + "_event") {
    keys.push_back(word("type", std::span(kEventNames).subspan(index, 1), "The kind of event."));
    keys.back().is_needed = true;
    Event::scene_keys(event, [&](const EventKey& key, const auto& member) {
      keys.push_back(key_of(key, member));
      if (key.form != EventForm::anchor) return;
      keys.push_back(vector("point", "m", "The same, in the scene at the start."));
      exclusive.push_back({"anchor", "point"});
    });
    if constexpr (requires { Event::pairs; })
      for (const EventPair& pair : Event::pairs) exclusive.push_back({pair.one, pair.others});
    if constexpr (requires { Event::needs; })
      any_of.push_back({Event::needs.keys, Event::needs.complaint});
    if constexpr (Lasts<Event>)
      beside.push_back(
          {"every", "to",
           "found \"every\" without \"to\", expected the end of the first interval too"});
    set = {what, Event::about, keys, exclusive, any_of, beside};
  }
  EventKeySet(const EventKeySet&) = delete;
  EventKeySet& operator=(const EventKeySet&) = delete;
};

template <class... Kinds>
std::vector<KeySet> make_sets(const std::variant<Kinds...>*) {
  static std::vector<std::unique_ptr<EventKeySet>> owned;  // at stable addresses
  (owned.push_back(std::make_unique<EventKeySet>(Kinds{}, owned.size())), ...);
  std::vector<KeySet> sets;
  for (const auto& made : owned) sets.push_back(made->set);
  return sets;
}

}  // namespace

std::span<const KeySet> event_key_sets() {
  static const std::vector<KeySet> sets = make_sets(static_cast<const EventKinds*>(nullptr));
  return sets;
}

}  // namespace pantin::detail
