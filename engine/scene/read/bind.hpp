#pragma once
/// Reads an object by the rows of its table: each value into the member that its row is bound to.
/// Members without a value are unchanged.
///
/// What rows cannot express is code. For a value: an overload of read_value for the type of the
/// member, or a function bound to the row. For a whole object: an overload of read_members, which
/// calls read_rows. Overloads are declared here and in read.hpp.
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "engine/scene/read/reader.hpp"

namespace pantin::detail {

struct Reading;

/// A row, and the object that contains its value.
struct RowValue {
  const Reading& reading;
  const Reader& from;
  const Key& key;

  bool is_there() const { return from.has(key.name); }
  NodeId node() const { return from.find(key.name); }
};

/// Reads the rows bound to members of the type of `tag` and ignores others. Returns false if a
/// required name or object could not be read.
bool read_rows(const Reading& reading, const Reader& from, const void* tag, void* into);
template <class T>
bool read_rows(const Reading& reading, const Reader& from, T& into) {
  return read_rows(reading, from, &kTypeTag<T>, &into);
}

/// Opens an object by its kind; one that may name a class inherits missing keys from it.
Reader open_object(const Reading& reading, NodeId node, std::string_view what);

/// A number; degrees under a key that ends in _deg are converted to radians.
bool read_value(const RowValue& row, Real& to);
bool read_value(const RowValue& row, std::optional<Real>& to);
/// A whole number or a word; a flag, or one of two words.
bool read_value(const RowValue& row, int& to);
bool read_value(const RowValue& row, bool& to);
/// A material by its name, or groups as bits.
bool read_value(const RowValue& row, std::uint32_t& to);
/// A name, a text or a reference; an array of references.
bool read_value(const RowValue& row, std::string& to);
bool read_value(const RowValue& row, std::optional<std::string>& to);
bool read_value(const RowValue& row, std::vector<std::string>& to);
/// A vector, a direction or a colour.
bool read_value(const RowValue& row, Vec3& to);
/// "position" with "rotation" or "rotation_deg".
bool read_value(const RowValue& row, Pose& to);

template <class T>
bool read_members(const Reading& reading, const Reader& from, T& into) {
  return read_rows(reading, from, into);
}

/// An object of a list; nothing if it is not an object or a required value is missing.
template <class T>
std::optional<T> read_object(const Reading& reading, NodeId node, std::string_view what) {
  const Reader from = open_object(reading, node, what);
  T made{};
  if (!from.is_object() || !read_members(reading, from, made)) return std::nullopt;
  return made;
}

/// A word, or an object.
template <class T>
bool read_value(const RowValue& row, T& to) {
  if constexpr (std::is_enum_v<T>) {
    int place = static_cast<int>(to);
    read_value(row, place);
    to = static_cast<T>(place);
    return true;
  } else {
    if (!row.is_there()) return !row.key.is_needed;
    return read_members(row.reading, open_object(row.reading, row.node(), row.key.object), to);
  }
}
/// An optional value.
template <class T>
bool read_value(const RowValue& row, std::optional<T>& to) {
  return row.is_there() ? read_value(row, to.emplace()) : !row.key.is_needed;
}
/// An array of objects.
template <class T>
bool read_value(const RowValue& row, std::vector<T>& to) {
  for (const NodeId node : row.from.items(row.key.name))
    if (auto item = read_object<T>(row.reading, node, row.key.object))
      to.push_back(std::move(*item));
  return true;
}

}  // namespace pantin::detail
