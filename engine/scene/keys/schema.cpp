#include "engine/scene/keys/schema.hpp"

#include <algorithm>
#include <string_view>
#include <vector>

#include "engine/geometry/kinds.hpp"
#include "engine/scene/json/words.hpp"
#include "engine/scene/keys/keys.hpp"
#include "engine/scene/read/surface_words.hpp"
#include "engine/world/timed_event.hpp"

namespace pantin::detail {
namespace {

std::string quoted(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + "\"";
}

/// The members of an object or the values of an array, separated by commas.
struct List {
  std::string text;
  void add(const std::string& item) { text += (text.empty() ? "" : ",") + item; }
  void add(std::string_view key, const std::string& value) { add(quoted(key) + ":" + value); }
  std::string object() const { return "{" + text + "}"; }
  std::string array() const { return "[" + text + "]"; }
};

std::string quoted_list(std::span<const std::string_view> words) {
  List list;
  for (const std::string_view word : words)
    if (!word.empty()) list.add(quoted(word));
  return list.array();
}

std::string reference_to(std::string_view what) { return quoted("#/$defs/" + std::string(what)); }

void add_range(List& into, const Range& range) {
  if (range.least == range.most) return into.add("const", number_text(range.least));
  into.add(range.open ? "exclusiveMinimum" : "minimum", number_text(range.least));
  into.add("maximum", number_text(range.most));
}

std::string number_of(const Range& range, std::string_view type = "number") {
  List list;
  list.add("type", quoted(type));
  add_range(list, range);
  return list.object();
}

/// An array of `count` such items; of any number if that is 0.
std::string array_of(const std::string& item, int count = 0) {
  List list;
  list.add("type", quoted("array"));
  list.add("items", item);
  if (count > 0) list.add("minItems", std::to_string(count));
  if (count > 0) list.add("maxItems", std::to_string(count));
  return list.object();
}

/// One of two types.
std::string either_of(const std::string& a, const std::string& b) {
  return "{\"anyOf\":[" + a + "," + b + "]}";
}

const std::string kSomeText = R"({"type":"string","minLength":1})";
const std::string kFlag = R"({"type":"boolean"})";

/// A quaternion or three angles, by their count; or the one or two angles, within the range, that a
/// joint may have instead.
std::string turn_of(int count, const Range& range) {
  const std::string whole = array_of(number_of(kAnyNumber), count);
  return "{\"anyOf\":[" + whole + "," + number_of(range) + "," + array_of(number_of(range), 2) +
         "]}";
}

std::string word_of(const Key& key) {
  std::string today = "{\"enum\":" + quoted_list(key.words) + "}";
  if (key.old_words.empty()) return today;
  return either_of(today, "{\"enum\":" + quoted_list(key.old_words) + ",\"deprecated\":true}");
}

/// Three numbers.
std::string vector_of(const Range& range) {
  const bool is_any = range.least == kAnyNumber.least && range.most == kAnyNumber.most;
  return is_any ? R"({"$ref":"#/$defs/vector"})" : array_of(number_of(range), 3);
}

/// The schema of numbers and arrays of numbers.
std::string numeric(const Key& key) {
  std::string one = number_of(key.range);
  switch (key.type) {
    case ValueType::whole:
      return number_of(key.range, "integer");
    case ValueType::vector:
    case ValueType::direction:
      return vector_of(key.range);
    case ValueType::vector_or_number:
      return either_of(vector_of(key.range), one);
    case ValueType::numbers:
      return array_of(one, key.count);
    case ValueType::wholes:
      return array_of(number_of(key.range, "integer"), key.count);
    case ValueType::number_or_pair:
      return either_of(one, array_of(one, 2));
    case ValueType::number_list:
      return array_of(one);
    case ValueType::points:
      return array_of(vector_of(key.range));
    case ValueType::pairs:
      return array_of(array_of(one, 2));
    case ValueType::triples:
      return array_of(array_of(R"({"type":"integer","minimum":0})", 3));
    case ValueType::quaternion:
      return array_of(one, 4);
    case ValueType::joint_turn:
      return turn_of(4, kRadians);
    case ValueType::joint_turn_deg:
      return turn_of(3, kDegrees);
    case ValueType::inertia:
      return either_of(array_of(one, 3), array_of(one, 6));
    default:  // number, and types that value_of() handles
      return one;
  }
}

/// The schema of a value, without its description.
std::string value_of(const Key& key) {
  std::string object = "{\"$ref\":" + reference_to(key.object) + "}";
  switch (key.type) {
    case ValueType::flag:
      return kFlag;
    case ValueType::text:
      return R"({"type":"string"})";
    case ValueType::name:
      return R"({"$ref":"#/$defs/name"})";
    case ValueType::reference:
      return kSomeText;
    case ValueType::references:
      return array_of(kSomeText);
    case ValueType::word:
      return word_of(key);
    case ValueType::colour:
      return either_of(R"({"type":"string","pattern":"^#[0-9a-fA-F]{6}$"})",
                       array_of(number_of(key.range), 3));
    case ValueType::group_names:
      return R"({"type":"array","items":)" + kSomeText + R"(,"maxItems":32,"uniqueItems":true})";
    case ValueType::groups:
      return array_of(either_of(kSomeText, R"({"type":"integer","minimum":0,"maximum":31})"));
    case ValueType::object:
      return object;
    case ValueType::objects:
      return array_of(object);
    case ValueType::object_or_flag:
      return either_of(kFlag, object);
    case ValueType::object_or_reference:
      return either_of(kSomeText, object);
    case ValueType::objects_or_references:
      return array_of(either_of(kSomeText, object));
    default:  // types made of numbers
      return numeric(key);
  }
}

std::string written_default(const Key& key, const Vec3& value) {
  switch (key.type) {
    case ValueType::flag:
      return value.x != 0 ? "true" : "false";
    case ValueType::word:
      return quoted(key.words[static_cast<std::size_t>(value.x)]);
    case ValueType::number:
    case ValueType::whole:
      return number_text(value.x);
    default:  // several numbers
      break;
  }
  List list;
  for (int i = 0; i < 3; ++i)
    if (key.count == 0 || i < key.count) list.add(number_text(value[i]));
  return list.array();
}

std::string about(const Key& key) {
  std::string text(key.about);
  const bool is_told = text.ends_with("in " + std::string(key.unit));
  if (!key.unit.empty() && !is_told)
    text += (text.empty() ? "In " : " In ") + std::string(key.unit) + ".";
  return text;
}

/// The schema of a value with its description.
std::string property_of(const Key& key) {
  List list;
  const std::string value = value_of(key);
  list.add(value.substr(1, value.size() - 2));
  if (key.is_never_zero) list.add("not", "{\"const\":0}");
  if (key.type == ValueType::direction) list.add("not", "{\"const\":[0,0,0]}");
  if (const auto x = default_of(key)) list.add("default", written_default(key, *x));
  if (const std::string words = about(key); !words.empty()) list.add("description", quoted(words));
  return list.object();
}

std::string old_property_of(const Key& key) {
  List list;
  const std::string value = value_of(key);
  list.add(value.substr(1, value.size() - 2));
  list.add("deprecated", "true");
  list.add("doNotSuggest", "true");  // read by editors of the VS Code family
  list.add("description", quoted("Now called \"" + std::string(key.name) + "\"."));
  return list.object();
}

/// The condition that a key is present, by either of its names.
std::string has(const KeySet& set, std::string_view name) {
  std::string today = "{\"required\":[" + quoted(name) + "]}";
  const Key* key = set.find(name);
  if (!key || key->old.empty()) return today;
  return either_of(today, "{\"required\":[" + quoted(key->old) + "]}");
}

std::string has_any(const KeySet& set, std::string_view names) {
  List list;
  each_word(names, [&](std::string_view name) { list.add(has(set, name)); });
  return "{\"anyOf\":" + list.array() + "}";
}

std::string not_both(const std::string& a, const std::string& b) {
  return "{\"not\":{\"allOf\":[" + a + "," + b + "]}}";
}

void add_pairs(const KeySet& set, List& rules) {
  for (const Key& key : set.keys) {
    const std::string_view name = key.name;
    if (name.ends_with("_deg") && set.find(name.substr(0, name.size() - 4)))
      rules.add(not_both(has(set, name.substr(0, name.size() - 4)), has(set, name)));
    if (!key.old.empty())
      rules.add("{\"not\":{\"required\":[" + quoted(name) + "," + quoted(key.old) + "]}}");
  }
  for (const Exclusive& pair : set.exclusive)
    rules.add(not_both(has(set, pair.one), has_any(set, pair.others)));
}

/// The required and the forbidden keys of a joint of one kind; `kind` is the condition for it.
std::string rule_of_kind(const KeySet& set, const JointKindInfo& info) {
  const bool is_joint = &set == &keys::joint;
  List needs, may_not, values;
  for (const Key& key : set.keys) {
    const bool is_parameter =
        is_joint && std::ranges::count(keys::joint_parameters(), key.name, &Key::name) > 0;
    const Parameter* own = is_parameter ? keys::parameter_of(info, key.name) : nullptr;
    if ((key.fits && !key.fits(info)) || (is_parameter && !own)) may_not.add(has(set, key.name));
    if (own && !own->needed.empty()) needs.add(quoted(key.name));
    if (own && keys::range_of(*own).least != key.range.least)
      values.add(key.name, number_of(keys::range_of(*own)));
  }
  List then;
  if (!needs.text.empty()) then.add("required", needs.array());
  if (!may_not.text.empty()) then.add("not", "{\"anyOf\":" + may_not.array() + "}");
  if (!values.text.empty()) then.add("properties", values.object());
  if (is_joint && !info.is_line)
    then.add("anyOf", "[" + has(set, "anchor") + "," + has(set, "anchor_a") + "," +
                          has(set, "anchor_b") + "]");
  std::vector<std::string_view> words{info.name};
  if (!info.alias.empty()) words.push_back(info.alias);
  List test;
  test.add("properties", "{\"kind\":{\"enum\":" + quoted_list(words) + "}}");
  const bool is_default = info.name == name_of(JointKind{});
  if (!is_default) test.add("required", "[\"kind\"]");
  test.add("not", "{\"required\":[\"class\"]}");  // which may give the kind and all other keys
  return then.text.empty() ? "" : "{\"if\":" + test.object() + ",\"then\":" + then.object() + "}";
}

void add_kinds(const KeySet& set, List& rules) {
  const bool is_joint = &set == &keys::joint;
  if (!is_joint && &set != &keys::chain) return;
  for (const JointKindInfo& info : kJointKindInfos) {
    if (!(is_joint ? keys::is_of_files(info) : keys::is_of_chains(info))) continue;
    if (const std::string rule = rule_of_kind(set, info); !rule.empty()) rules.add(rule);
  }
}

std::string rules_of(const KeySet& set) {
  List rules;
  add_pairs(set, rules);
  for (const AnyOf& any : set.any_of) rules.add(has_any(set, any.keys));
  for (const Beside& beside : set.beside)
    rules.add("{\"if\":" + has(set, beside.key) + ",\"then\":" + has_any(set, beside.with) + "}");
  add_kinds(set, rules);
  return rules.text.empty() ? "" : rules.array();
}

std::string name_schema() {
  return R"({"type":"string","minLength":1,"maxLength":200,"pattern":"^[^/\\u0000-\\u001f]+$",)"
         R"("not":{"const":"world"},"description":"A name without \"/\". All names of a scene, or )"
         R"(of a prefab, differ. Inside an instance a thing is called \"instance/name\"."})";
}

/// An object selected by its "type": one of `names`, each described under its name plus `suffix`.
struct TypedObject {
  std::span<const std::string_view> names;
  std::string suffix, about_type, about;
};
std::string typed_schema(const TypedObject& object) {
  List rules;
  for (const std::string_view name : object.names)
    rules.add("{\"if\":{\"properties\":{\"type\":{\"const\":" + quoted(name) +
              "}}},\"then\":{\"$ref\":" + reference_to(std::string(name) + object.suffix) + "}}");
  return R"({"type":"object","required":["type"],"properties":{"type":{"enum":)" +
         quoted_list(object.names) + ",\"description\":" + quoted(object.about_type) +
         "}},\"allOf\":" + rules.array() + ",\"description\":" + quoted(object.about) + "}";
}

}  // namespace

std::string schema_of(const KeySet& set) {
  List properties, needed;
  for (const Key& key : set.keys) {
    properties.add(key.name, property_of(key));
    if (!key.old.empty()) properties.add(key.old, old_property_of(key));
    if (key.is_needed) needed.add(quoted(key.name));
  }
  each_word(set.retired, [&](std::string_view name) {
    properties.add(name,
                   "{\"deprecated\":true,\"doNotSuggest\":true,"
                   "\"description\":\"No longer has any effect.\"}");
  });
  List list;
  list.add("type", quoted("object"));
  list.add("description", quoted(set.about));
  if (const std::string_view text = example_of(set.what); !text.empty())
    list.add("examples", "[" + std::string(text) + "]");
  list.add("properties", properties.object());
  list.add("additionalProperties", "false");
  if (!needed.text.empty()) list.add("required", needed.array());
  if (const std::string rules = rules_of(set); !rules.empty()) list.add("allOf", rules);
  return list.object();
}

std::string scene_schema() {
  List defs;
  defs.add("name", name_schema());
  defs.add("vector", array_of(number_of(kAnyNumber), 3));
  defs.add("shape", typed_schema({kShapeNames, "", "The kind of shape.",
                                  "A shape in the body's own frame."}));
  defs.add("event", typed_schema({kEventNames, "_event", "The kind of event.",
                                  "A timed change of the scene while it runs."}));
  defs.add("face", typed_schema({kFaceTypes, "_face", "The kind of face.",
                                 "A face of a NURBS surface, u x v outwards."}));
  defs.add("curve", typed_schema({kCurveTypes, "_curve", "The kind of curve.",
                                  "A curve: of a face, or of a surface joint."}));
  for (const KeySet* set : all_key_sets()) defs.add(set->what, schema_of(*set));
  List whole;
  whole.add("$schema", quoted("https://json-schema.org/draft/2020-12/schema"));
  whole.add("$id", quoted("https://pantin.example/scene-1.schema.json"));  // a name, no address
  whole.add("title", quoted("pantin scene, version 1"));
  whole.add("$ref", reference_to("scene"));
  whole.add("$defs", defs.object());
  return whole.object();
}

}  // namespace pantin::detail
