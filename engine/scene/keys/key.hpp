#pragma once
/// A key of an object in a file: type, range and meaning of its value. The reader takes bounds,
/// words and defaults from these rows, and the JSON Schema is generated from them. A row may be
/// bound to the member that the value is read into: see bind.hpp.
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <type_traits>

#include "engine/base/math.hpp"

namespace pantin::detail {

/// Allowed range of a number, and its description for errors.
struct Range {
  Real least, most;
  std::string_view words;
  bool open = false;  // `least` itself is not allowed

  constexpr bool holds(Real x) const { return (open ? x > least : x >= least) && x <= most; }
};

inline constexpr Real kMaxMagnitude = 1e9;  // m, m/s, rad/s: larger values are mistakes
inline constexpr Range kAnyNumber{-kMaxMagnitude, kMaxMagnitude, "a number between -1e9 and 1e9"};
inline constexpr Range kPositive{0, 1e12, "a number above 0, at most 1e12", true};
inline constexpr Range kNotNegative{0, 1e12, "a number from 0 to 1e12"};
inline constexpr Range kSize{1e-9, kMaxMagnitude, "a size from 1e-9 to 1e9 m"};
inline constexpr Range kWeight{1e-12, 1e12, "a number from 1e-12 to 1e12"};  // mass, density
inline constexpr Range kUnit{0, 1, "a number from 0 to 1"};
inline constexpr Range kDegrees{-1e6, 1e6, "an angle in degrees, between -1e6 and 1e6"};
inline constexpr Range kDegreesRate{-1e9, 1e9, "a rate in degrees/s, between -1e9 and 1e9"};
inline constexpr Range kRadians{-1e4, 1e4, "an angle in rad, between -1e4 and 1e4"};
inline constexpr Range kTime{-1e6, 1e6, "a time in seconds, between -1e6 and 1e6"};

/// The type of the value under a key.
enum class ValueType : std::uint8_t {
  number,
  whole,  // a number without a fraction
  flag,   // true or false
  text,
  name,              // the name of the object itself
  reference,         // the name of another object
  references,        // an array of them
  word,              // one of Key::words
  vector,            // three numbers
  direction,         // three numbers, not all 0
  vector_or_number,  // three numbers, or one for all three
  numbers,           // an array of Key::count numbers
  wholes,            // an array of Key::count whole numbers
  number_or_pair,    // one number, or two
  number_list,       // an array of any length
  points,            // an array of vectors
  pairs,             // an array of two numbers each
  triples,           // an array of three whole numbers each
  quaternion,        // four numbers, of length 1
  joint_turn,        // a quaternion, or the one or two angles of a joint in rad
  joint_turn_deg,    // the same in degrees, three angles in place of the quaternion
  colour,            // "#rrggbb", or three numbers
  inertia,           // three numbers, or six
  group_names,       // an array of different names, at most 32
  groups,            // an array of names or of numbers from 0 to 31
  object,            // of the kind Key::object
  objects,           // an array of them
  object_or_flag,
  object_or_reference,
  objects_or_references
};

struct JointKindInfo;
struct RowValue;

/// A tag whose address identifies a type.
template <class T>
inline constexpr char kTypeTag = 0;

/// The destination of a row's value: a member of an object of some type.
struct Binding {
  const void* owner;                             // the tag of that type
  bool (*put)(const RowValue& row, void* into);  // false: a required value could not be read
  std::optional<Vec3> (*initial)();  // initial value of the member; a single number three times
};

template <class T, class Member>
std::type_identity<T> owner_of(Member T::*);
template <class T>
std::type_identity<T> owner_of(bool (*)(const RowValue&, T&));

template <class T>
std::optional<Vec3> initial_of(const T& x) {
  constexpr bool kIsIndex = std::is_same_v<T, std::uint32_t>;  // or bits
  if constexpr (std::is_enum_v<T> || (std::is_arithmetic_v<T> && !kIsIndex))
    return Vec3(static_cast<Real>(x));
  if constexpr (std::is_same_v<T, Vec3>) return x;
  return std::nullopt;
}

/// Binds by a function bool (const RowValue&, Owner&), or by a path of pointers to members that
/// starts at the owner.
template <auto first, auto... others>
inline constexpr Binding kBinding = [] {
  using Owner = typename decltype(owner_of(first))::type;
  constexpr const void* kOwner = &kTypeTag<Owner>;
  if constexpr (std::is_function_v<std::remove_pointer_t<decltype(first)>>)
    return Binding{kOwner,
                   [](const RowValue& row, void* o) { return first(row, *static_cast<Owner*>(o)); },
                   [] { return std::optional<Vec3>(); }};
  else
    return Binding{kOwner,
                   [](const RowValue& row, void* o) {
                     return read_value(row, ((static_cast<Owner*>(o)->*first).*....*others));
                   },
                   [] { return initial_of(((Owner{}.*first).*....*others)); }};
}();

/// A row of a table of keys. `unit` and `about` are for people; `about` is one or more sentences.
struct Key {
  std::string_view name;
  ValueType type;
  std::string_view unit, about;
  Range range = kAnyNumber;                      // of numbers
  int count = 0;                                 // of an array of fixed length
  std::span<const std::string_view> words = {};  // of a word
  // Former names of `words`, one for each, accepted with a warning; "" if there is none.
  std::span<const std::string_view> old_words = {};
  std::string_view object = {};    // the kind of object
  std::string_view expected = {};  // what an error says was expected if it is missing
  bool is_needed = false;          // required: an error if it is missing
  bool is_never_zero = false;
  std::string_view never_zero = {};  // the reason, if 0 is not allowed
  std::string_view old = {};         // its name in earlier versions, accepted with a warning
  bool (*fits)(const JointKindInfo&) = nullptr;  // kinds of joints that may have it; null: all
  bool has_default = false;
  Real defaults[3] = {};             // of a number, a vector; 1 or 0 of a flag; index of a word
  const Binding* binding = nullptr;  // null: read by code
  bool is_default_told = false;      // stated in words; the member's initial value is not shown

  /// Binds to a member, or to a function: see kBinding. The member's initial value is the default.
  template <auto... path>
  constexpr Key to() const {
    Key key = *this;
    if constexpr (sizeof...(path) > 0) key.binding = &kBinding<path...>;
    return key;
  }
  constexpr Key without_default() const {
    Key key = *this;
    key.is_default_told = true;
    return key;
  }
  constexpr Key within(const Range& allowed) const {
    Key key = *this;
    key.range = allowed;
    return key;
  }
  /// An array of fixed length.
  constexpr Key holding(int of_fixed_length) const {
    Key key = *this;
    key.count = of_fixed_length;
    return key;
  }
  constexpr Key or_else(Real x) const { return or_else(x, x, x); }
  constexpr Key or_else(Real x, Real y, Real z) const {
    Key key = *this;
    key.has_default = true, key.defaults[0] = x, key.defaults[1] = y, key.defaults[2] = z;
    return key;
  }
  /// Required; `what` is what an error says was expected.
  constexpr Key needed(std::string_view what) const {
    Key key = expecting(what);
    key.is_needed = true;
    return key;
  }
  constexpr Key expecting(std::string_view what) const {
    Key key = *this;
    key.expected = what;
    return key;
  }
  constexpr Key once(std::string_view old_name) const {
    Key key = *this;
    key.old = old_name;
    return key;
  }
  constexpr Key once_words(std::span<const std::string_view> old_ones) const {
    Key key = *this;
    key.old_words = old_ones;
    return key;
  }
  constexpr Key not_zero(std::string_view why = {}) const {
    Key key = *this;
    key.is_never_zero = true, key.never_zero = why;
    return key;
  }
  constexpr Key of_kinds(bool (*test)(const JointKindInfo&)) const {
    Key key = *this;
    key.fits = test;
    return key;
  }
};

/// The default of a key, if the table has one: a single number three times, 1 or 0 of a flag, the
/// index of a word.
std::optional<Vec3> default_of(const Key& key);

/// Keys that exclude one another: `one`, and any of `others`, separated by spaces.
struct Exclusive {
  std::string_view one, others;
};

/// At least one of `keys`, separated by spaces, is required; and the error text if none is given.
struct AnyOf {
  std::string_view keys, complaint;
};

/// If `key` is given, one of `with` is required too; and the error text if none is.
struct Beside {
  std::string_view key, with, complaint;
};

inline constexpr std::span<const Exclusive> kNoPairs;
inline constexpr std::span<const AnyOf> kNoNeeds;

/// All keys of one kind of object. A key and the same key with _deg always exclude each other.
struct KeySet {
  std::string_view what;   // the kind of object, as errors name it
  std::string_view about;  // one line or more
  std::span<const Key> keys;
  std::span<const Exclusive> exclusive = {};
  std::span<const AnyOf> any_of = {};
  std::span<const Beside> beside = {};
  /// Keys of earlier versions, separated by spaces, that are ignored with a warning.
  std::string_view retired = {};

  constexpr bool is_retired(std::string_view name) const;
  constexpr const Key* find(std::string_view name) const {
    for (const Key& key : keys)
      if (key.name == name) return &key;
    return nullptr;
  }
};

/// Calls `take` with each word of a list separated by spaces.
constexpr void each_word(std::string_view words, auto take) {
  while (!words.empty()) {
    const std::size_t end = words.find(' ') < words.size() ? words.find(' ') : words.size();
    take(words.substr(0, end));
    words.remove_prefix(end < words.size() ? end + 1 : end);
  }
}

constexpr bool KeySet::is_retired(std::string_view name) const {
  bool known = false;
  each_word(retired, [&](std::string_view word) { known = known || word == name; });
  return known;
}
/// Whether `name` is one of these words.
constexpr bool is_word_of(std::string_view words, std::string_view name) {
  bool found = false;
  each_word(words, [&](std::string_view word) { found = found || word == name; });
  return found;
}

/// The keys of a table without `own` (separated by spaces): those that a class may hold, all
/// optional.
template <const auto& kAll, std::size_t kOwn>
constexpr auto shared_keys(std::string_view own) {
  std::array<Key, std::size(kAll) - kOwn> shared{};
  std::size_t count = 0;
  for (const Key& key : kAll) {
    if (is_word_of(own, key.name)) continue;
    shared.at(count) = key;
    shared.at(count++).is_needed = false;
  }
  return shared;
}

/// Constructors of table rows, bound to a member if one is named: see Key::to.
namespace rows {

using Text = std::string_view;
using Words = std::span<const std::string_view>;

template <auto... path>
constexpr Key row(Text name, ValueType type, Text unit, Text about) {
  return Key{.name = name, .type = type, .unit = unit, .about = about}.to<path...>();
}
template <auto... path>
constexpr Key number(Text name, Text unit, const Range& range, Text about) {
  return row<path...>(name, ValueType::number, unit, about).within(range);
}
template <auto... path>
constexpr Key angle(Text name, Text about) {
  return number<path...>(name, "rad", kRadians, about);
}
template <auto... path>
constexpr Key angle_deg(Text name, Text about) {
  return number<path...>(name, "degrees", kDegrees, about);
}
template <auto... path>
constexpr Key whole(Text name, int least, int most, Text about) {
  return row<path...>(name, ValueType::whole, "", about).within({Real(least), Real(most), ""});
}
template <auto... path>
constexpr Key flag(Text name, Text about) {
  return row<path...>(name, ValueType::flag, "", about);
}
template <auto... path>
constexpr Key text(Text name, Text about) {
  return row<path...>(name, ValueType::text, "", about);
}
template <auto... path>
constexpr Key own_name(Text about) {
  return row<path...>("name", ValueType::name, "", about);
}
template <auto... path>
constexpr Key needed_name() {
  return own_name<path...>("Name for references to it.").needed("a name");
}
template <auto... path>
constexpr Key reference(Text name, Text expected, Text about) {
  return row<path...>(name, ValueType::reference, "", about).expecting(expected);
}
template <auto... path>
constexpr Key needed_reference(Text name, Text expected, Text about) {
  return reference<path...>(name, expected, about).needed(expected);
}
template <auto... path>
constexpr Key word(Text name, Words words, Text about) {
  Key key = row<path...>(name, ValueType::word, "", about);
  key.words = words;
  return key;
}
template <auto... path>
constexpr Key vector(Text name, Text unit, Text about) {
  return row<path...>(name, ValueType::vector, unit, about);
}
template <auto... path>
constexpr Key direction(Text name, Text about) {
  return row<path...>(name, ValueType::direction, "", about);
}
template <auto... path>
constexpr Key angles(Text name, Text about) {
  return row<path...>(name, ValueType::numbers, "rad", about).holding(2).within(kRadians);
}
template <auto... path>
constexpr Key angles_deg(Text name, Text about) {
  return row<path...>(name, ValueType::numbers, "degrees", about).holding(2).within(kDegrees);
}
template <auto... path>
constexpr Key of_object(Text name, ValueType type, Text object, Text about) {
  Key key = row<path...>(name, type, "", about);
  key.object = object;
  return key;
}
template <auto... path>
constexpr Key object(Text name, Text kind, Text about) {
  return of_object<path...>(name, ValueType::object, kind, about);
}
template <auto... path>
constexpr Key objects(Text name, Text kind, Text about) {
  return of_object<path...>(name, ValueType::objects, kind, about);
}

inline constexpr Key kPosition =
    vector("position", "m", "Position of the frame's origin.").or_else(0);
inline constexpr Key kRotation =
    row("rotation", ValueType::quaternion, "",
        "Quaternion [x, y, z, w] from the own frame to the frame around it. Default: none.");
inline constexpr Key kRotationDeg =
    vector("rotation_deg", "degrees",
           "The same as three angles: about the fixed x axis first, then y, then z.");
inline constexpr Key kParent =
    reference("parent", "the name of a body",
              "Name of a body in whose own frame position and rotation are given; it is no "
              "constraint. Default: none, they are given in the frame of the scene or prefab.");
inline constexpr Key kClass =
    reference("class", "the name of a class",
              "Name of one of the scene's classes: keys that are absent here are taken from it.");
inline constexpr Key kMaterial =
    reference("material", "the name of a material", "Name of a material.");

}  // namespace rows
}  // namespace pantin::detail
