#include "engine/scene/read/reader.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "engine/base/check.hpp"
#include "engine/base/rotation.hpp"
#include "engine/base/utf8.hpp"

namespace pantin::detail {
namespace {

constexpr std::size_t kLongestName = 200;  // bytes

Real linear_of(Real srgb) {
  return srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4);
}

/// Six hexadecimal digits after "#".
std::optional<Vec3> colour_from(std::string_view text) {
  unsigned bits = 0;
  if (text.size() != 7 || text[0] != '#') return std::nullopt;
  const char* last = text.data() + text.size();
  if (std::from_chars(text.data() + 1, last, bits, 16).ptr != last) return std::nullopt;
  const auto part = [&](unsigned shift) { return linear_of(((bits >> shift) & 0xFF) / 255.0); };
  return Vec3(part(16), part(8), part(0));
}

}  // namespace

Reader::Reader(const JsonDocument& j, Diagnostics& c, ObjectSource from, const KeySet& set)
    : json(j), diagnostics(c), node(from.node), set_(set), from_(std::move(from)) {
  if (!is_object()) {
    diagnostics.error_value(node, "an object (" + std::string(set.what) + ")");
    return;
  }
  for (NodeId child = json[node].first_child; child != kNoNode; child = json[child].next) {
    const std::string_view key = json[child].key;
    if (accepts(key)) continue;
    if (set.is_retired(key)) {
      diagnostics.warn(child, "retired key",
                       "the key \"" + std::string(key) + "\" no longer has any effect");
      continue;
    }
    const auto today = std::ranges::find(set.keys, key, &Key::old);
    if (today == set.keys.end() || key.empty())
      refuse_unknown(child);
    else
      has_old_keys_ = true, warn_of_old(child, today->name);
  }
  check_pairs();
  check_needs();
}

bool Reader::has_any(std::string_view keys) const {
  bool any = false;
  each_word(keys, [&](std::string_view key) { any = any || has(key); });
  return any;
}

/// Reports at `other`, once, if both keys are present.
void Reader::check_exclusive(std::string_view one, std::string_view other,
                             std::vector<NodeId>& told) const {
  const NodeId second = find(other);
  if (second == kNoNode || std::ranges::count(told, second) > 0) return;
  told.push_back(second);
  diagnostics.error_at_key(second, "found \"" + std::string(other) + "\" beside \"" +
                                       std::string(one) + "\", expected only one of them");
}

void Reader::check_pairs() const {
  std::vector<NodeId> told;
  for (NodeId child = json[node].first_child; child != kNoNode; child = json[child].next) {
    const std::string_view key = json[child].key;
    if (!key.ends_with("_deg")) continue;
    const std::string_view plain = key.substr(0, key.size() - 4);
    if (accepts(key) && accepts(plain) && has(plain)) check_exclusive(plain, key, told);
  }
  for (const Exclusive& pair : set_.exclusive)
    if (has(pair.one))
      each_word(pair.others,
                [&](std::string_view other) { check_exclusive(pair.one, other, told); });
}

void Reader::check_needs() const {
  for (const AnyOf& any : set_.any_of)
    if (!has_any(any.keys) && !from_.is_class_unknown)
      diagnostics.error(node, std::string(any.complaint));
  for (const Key& key : set_.keys)
    if (key.is_needed) need(key.name);
  for (const Beside& beside : set_.beside)
    if (has(beside.key) && !has_any(beside.with))
      diagnostics.error_at_key(find(beside.key), std::string(beside.complaint));
}

/// Keys under which people write comments into JSON.
constexpr std::string_view kCommentKeys[] = {"comment", "comments", "_comment",
                                             "//",      "note",     "notes"};

void Reader::refuse_unknown(NodeId child) const {
  std::vector<std::string_view> names;
  for (const Key& k : set_.keys) names.push_back(k.name);
  const std::string_view key = json[child].key;
  if (std::ranges::count(kCommentKeys, key) > 0)
    return diagnostics.error_at_key(
        child, "found key \"" + clipped(key) + "\", expected a key of a " + std::string(set_.what) +
                   ": a comment stands after // in a file named .json5 or .jsonc");
  const std::string near = diagnostics.hints.of_word(key, names);
  diagnostics.error_at_key(child, "found key \"" + clipped(key) + "\", expected a key of a " +
                                      std::string(set_.what) +
                                      (near.empty() ? ": " + listed(names) : near));
}

void Reader::warn_of_old(NodeId child, std::string_view today) const {
  const std::string old(json[child].key), now(today);
  if (json.member(node, today) != kNoNode)
    diagnostics.error_at_key(child, "found \"" + old + "\" beside \"" + now +
                                        "\", expected only the latter, its current name");
  else
    diagnostics.warn(child, "old key", "the key \"" + old + "\" is now called \"" + now + "\"");
}

bool Reader::accepts(std::string_view key) const { return set_.find(key) != nullptr; }

const Key& Reader::row(std::string_view key) const {
  const Key* found = set_.find(key);
  PANTIN_ASSERT(found);
  return *found;
}

Vec3 Reader::default_of(std::string_view key) const {
  const Key& found = row(key);
  PANTIN_ASSERT(found.has_default);
  return {found.defaults[0], found.defaults[1], found.defaults[2]};
}

NodeId Reader::find(std::string_view key) const {
  PANTIN_ASSERT(accepts(key));
  if (!is_object()) return kNoNode;
  const NodeId value = find_in(node, key);
  return value != kNoNode || from_.sources.empty() ? value : find_inherited(key);
}

/// The value in that object alone, without inheritance.
NodeId Reader::find_in(NodeId object, std::string_view key) const {
  const NodeId value = json.member(object, key);
  if (value != kNoNode || row(key).old.empty()) return value;
  return object != node || has_old_keys_ ? json.member(object, row(key).old) : kNoNode;
}

/// The value in the nearest class that has it, unless a nearer source excludes it.
NodeId Reader::find_inherited(std::string_view key) const {
  const auto has_value = [&](const KeySource& source) {
    return (source.only.empty() || is_word_of(source.only, key)) &&
           find_in(source.node, key) != kNoNode;
  };
  const auto found = std::ranges::find_if(from_.sources, has_value);
  if (found == from_.sources.end()) return kNoNode;
  if (std::ranges::count(from_.left_out, key) > 0 || is_excluded_by(node, key)) return kNoNode;
  const bool is_excluded = std::any_of(from_.sources.begin(), found, [&](const KeySource& nearer) {
    return is_excluded_by(nearer.node, key);
  });
  return is_excluded ? kNoNode : find_in(found->node, key);
}

/// Whether an object has a key that excludes this one.
bool Reader::is_excluded_by(NodeId object, std::string_view key) const {
  const auto has_key = [&](std::string_view other) {
    return accepts(other) && find_in(object, other) != kNoNode;
  };
  const std::string in_degrees = std::string(key) + "_deg";
  if (has_key(in_degrees)) return true;
  if (key.ends_with("_deg") && has_key(key.substr(0, key.size() - 4))) return true;
  for (const Exclusive& pair : set_.exclusive) {
    if (is_word_of(pair.others, key) && has_key(pair.one)) return true;
    bool any = false;
    if (pair.one == key)
      each_word(pair.others, [&](std::string_view other) { any = any || has_key(other); });
    if (any) return true;
  }
  return false;
}

NodeId Reader::need(std::string_view key) const {
  const NodeId value = find(key);
  if (value == kNoNode && is_object() && !from_.is_class_unknown)
    diagnostics.error(
        node, "found no \"" + std::string(key) + "\", expected " + std::string(row(key).expected));
  return value;
}

Real Reader::number(std::string_view key, Real otherwise) const {
  return has(key) ? number(key, otherwise, row(key).range) : otherwise;
}

Real Reader::number(std::string_view key, Real otherwise, const Range& range) const {
  const NodeId value = find(key);
  if (value == kNoNode || std::isnan(json[value].number)) return otherwise;
  const Key& from = row(key);
  PANTIN_ASSERT(from.type == ValueType::number || from.type == ValueType::number_or_pair ||
                from.type == ValueType::vector_or_number || from.type == ValueType::joint_turn ||
                from.type == ValueType::joint_turn_deg);
  if (json[value].kind != JsonKind::number || !range.holds(json[value].number)) {
    diagnostics.error_value(value, range.words);
    return otherwise;
  }
  if (from.is_never_zero && json[value].number == 0)
    diagnostics.error_value(
        value, "a number other than 0" +
                   (from.never_zero.empty() ? "" : ": " + std::string(from.never_zero)));
  return json[value].number;
}

int Reader::whole(std::string_view key) const {
  return whole(key, static_cast<int>(row(key).defaults[0]));
}

int Reader::whole(std::string_view key, int otherwise) const {
  return whole(key, otherwise, static_cast<int>(row(key).range.most));
}

int Reader::whole(std::string_view key, int otherwise, int most) const {
  const NodeId value = find(key);
  if (value == kNoNode || std::isnan(json[value].number)) return otherwise;
  PANTIN_ASSERT(row(key).type == ValueType::whole);
  const int least = static_cast<int>(row(key).range.least);
  const Real x = json[value].number;
  if (json[value].kind == JsonKind::number && x == std::floor(x) && x >= least && x <= most)
    return static_cast<int>(x);
  diagnostics.error_value(
      value, "a whole number from " + std::to_string(least) + " to " + std::to_string(most));
  return otherwise;
}

bool Reader::flag(std::string_view key, bool otherwise) const {
  PANTIN_ASSERT(row(key).type == ValueType::flag);
  const NodeId value = find(key);
  if (value == kNoNode) return otherwise;
  if (json[value].kind == JsonKind::boolean) return json[value].boolean;
  diagnostics.error_value(value, "true or false");
  return otherwise;
}

std::string Reader::text(std::string_view key, std::string_view otherwise) const {
  const NodeId value = find(key);
  if (value == kNoNode) return std::string(otherwise);
  if (json[value].kind == JsonKind::string) return std::string(json[value].text);
  diagnostics.error_value(value, "text in double quotes");
  return std::string(otherwise);
}

std::optional<std::string> Reader::reference(std::string_view key) const {
  const Key& from = row(key);
  PANTIN_ASSERT(from.type == ValueType::reference);
  const NodeId value = find(key);
  if (value == kNoNode) return std::nullopt;
  if (json[value].kind == JsonKind::string && !json[value].text.empty())
    return std::string(json[value].text);
  diagnostics.error_value(value, from.expected);
  return std::nullopt;
}

std::size_t Reader::word(std::string_view key) const {
  return word(key, static_cast<std::size_t>(row(key).defaults[0]));
}

std::size_t Reader::word(std::string_view key, std::size_t otherwise) const {
  return word(key, otherwise, row(key).words);
}

std::size_t Reader::word(std::string_view key, std::size_t otherwise,
                         std::span<const std::string_view> words) const {
  const Key& from = row(key);
  PANTIN_ASSERT(from.type == ValueType::word);
  const NodeId value = find(key);
  if (value == kNoNode) return otherwise;
  if (json[value].kind == JsonKind::string && !json[value].text.empty()) {
    const std::string_view word = json[value].text;
    if (const auto it = std::ranges::find(words, word); it != words.end())
      return static_cast<std::size_t>(it - words.begin());
    if (const auto it = std::ranges::find(from.old_words, word); it != from.old_words.end()) {
      const auto place = static_cast<std::size_t>(it - from.old_words.begin());
      diagnostics.warn(
          value, "old word",
          "\"" + std::string(word) + "\" is now called \"" + std::string(words[place]) + "\"");
      return place;
    }
  }
  diagnostics.error_value(value,
                          listed(words) + diagnostics.hints.of_word(json[value].text, words));
  return otherwise;
}

bool Reader::numbers_at(NodeId array, std::span<Real> into, const Range& range) const {
  if (json[array].kind != JsonKind::array || json[array].count != into.size()) {
    diagnostics.error_value(array, "an array of " + std::to_string(into.size()) + " numbers");
    return false;
  }
  bool good = true;
  std::size_t i = 0;
  for (NodeId c = json[array].first_child; c != kNoNode; c = json[c].next, ++i) {
    into[i] = json[c].number;
    if (std::isnan(into[i])) {
      good = false;  // reported already
    } else if (json[c].kind != JsonKind::number || !range.holds(into[i])) {
      diagnostics.error_value(c, range.words);
      good = false;
    }
  }
  return good;
}

bool Reader::numbers(std::string_view key, std::span<Real> into) const {
  const NodeId value = find(key);
  return value != kNoNode && numbers_at(value, into, row(key).range);
}

Vec3 Reader::vec(std::string_view key, Vec3 otherwise) const {
  Vec3 v(0);
  return numbers(key, {&v.x, 3}) ? v : otherwise;
}

std::optional<Vec3> Reader::vec_if(std::string_view key) const {
  if (!has(key)) return std::nullopt;
  return vec(key, Vec3(0));
}

Vec3 Reader::direction(std::string_view key, Vec3 otherwise) const {
  PANTIN_ASSERT(row(key).type == ValueType::direction);
  const Vec3 v = vec(key, otherwise);
  const Real length = glm::length(v);
  if (length > 0) return v / length;
  diagnostics.error_value(find(key), "a direction: three numbers, not all 0");
  return otherwise;
}

Vec3 Reader::vec_or_number(std::string_view key, Vec3 otherwise) const {
  const NodeId value = find(key);
  if (value == kNoNode || json[value].kind == JsonKind::array) return vec(key, otherwise);
  return Vec3(number(key, otherwise.x));
}

Pose Reader::pose() const { return {vec("position"), rotation(kIdentity)}; }

Quat Reader::rotation(Quat otherwise, std::string_view key) const {
  const std::string key_deg = std::string(key) + "_deg";
  if (has(key_deg)) return from_degrees(vec(key_deg, Vec3(0)));
  const NodeId value = find(key);
  Real q[4];
  if (value == kNoNode || !numbers_at(value, q, kAnyNumber)) return otherwise;
  const Quat quaternion(q[3], q[0], q[1], q[2]);
  const Real length = glm::length(quaternion), error = std::abs(length - 1);
  if (error > 1e-3) {
    diagnostics.error(value, "found a quaternion of length " + written(length) +
                                 ", expected [x, y, z, w] of length 1");
    return otherwise;
  }
  if (error > 1e-6)
    diagnostics.warn(value, "quaternion",
                     "quaternion of length " + written(length) + " was normalised");
  return error < 1e-15 ? quaternion : quaternion * (1 / length);
}

Vec3 Reader::colour(std::string_view key, Vec3 otherwise) const {
  const NodeId value = find(key);
  if (value == kNoNode) return otherwise;
  if (json[value].kind == JsonKind::array) return vec(key, otherwise);
  if (json[value].kind == JsonKind::string)
    if (const auto colour = colour_from(json[value].text)) return *colour;
  diagnostics.error_value(value, "a colour: \"#rrggbb\" (sRGB) or [r, g, b] (linear)");
  return otherwise;
}

std::string Reader::name() const {
  const NodeId value = find("name");
  std::string word = text("name", "");
  if (value == kNoNode || json[value].kind != JsonKind::string) return {};
  if (word == "world") {
    diagnostics.error_value(value, "another name: this one stands for the fixed world");
    return {};
  }
  const bool is_plain = std::none_of(word.begin(), word.end(), [](char c) {
    return c == '/' || static_cast<unsigned char>(c) < 0x20;
  });
  if (!word.empty() && word.size() <= kLongestName && is_plain) return word;
  diagnostics.error_value(value, "a name of 1 to 200 bytes without \"/\"");
  return {};
}

std::vector<NodeId> Reader::items(std::string_view key) const {
  std::vector<NodeId> result;
  const NodeId value = find(key);
  if (value == kNoNode) return result;
  if (json[value].kind != JsonKind::array) {
    diagnostics.error_value(value, "an array");
    return result;
  }
  result.reserve(json[value].count);
  for (NodeId c = json[value].first_child; c != kNoNode; c = json[c].next) result.push_back(c);
  return result;
}

std::vector<Vec3> Reader::points() const {
  std::vector<Vec3> points;
  for (const NodeId item : items("points")) {
    Vec3& p = points.emplace_back(0);
    numbers_at(item, {&p.x, 3}, kAnyNumber);
  }
  return points;
}

Quat from_degrees(Vec3 angles) {
  const Vec3 r = angles * (kPi / 180);
  return glm::normalize(from_rotation_vector({0, 0, r.z}) * from_rotation_vector({0, r.y, 0}) *
                        from_rotation_vector({r.x, 0, 0}));
}

}  // namespace pantin::detail
