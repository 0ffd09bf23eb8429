#include "engine/scene/read/bind.hpp"

#include <cmath>

#include "engine/scene/read/read.hpp"

namespace pantin::detail {

std::optional<Vec3> default_of(const Key& key) {
  if (key.has_default) return Vec3(key.defaults[0], key.defaults[1], key.defaults[2]);
  const bool is_open = key.is_default_told || key.is_needed || key.name.ends_with("_deg");
  if (is_open || !key.binding) return std::nullopt;
  const std::optional<Vec3> initial = key.binding->initial();
  const bool is_number = key.type == ValueType::number || key.type == ValueType::whole;
  return initial && is_number && !key.range.holds(initial->x) ? std::nullopt : initial;
}

bool read_rows(const Reading& reading, const Reader& from, const void* tag, void* into) {
  bool is_whole = true;
  for (const Key& key : from.keys())
    if (key.binding && key.binding->owner == tag)
      is_whole = key.binding->put({reading, from, key}, into) && is_whole;
  return is_whole;
}

bool read_value(const RowValue& row, Real& to) {
  std::optional<Real> read;
  read_value(row, read);
  to = read.value_or(to);
  return true;
}

bool read_value(const RowValue& row, std::optional<Real>& to) {
  const Real x = row.from.number(row.key.name, NAN);
  if (!std::isnan(x)) to = row.key.name.ends_with("_deg") ? x * (kPi / 180) : x;
  return true;
}

bool read_value(const RowValue& row, int& to) {
  to = row.key.type == ValueType::whole
           ? row.from.whole(row.key.name, to)
           : static_cast<int>(row.from.word(row.key.name, static_cast<std::size_t>(to)));
  return true;
}

bool read_value(const RowValue& row, bool& to) {
  to = row.key.type == ValueType::flag ? row.from.flag(row.key.name, to)
                                       : row.from.word(row.key.name, to) == 1;
  return true;
}

bool read_value(const RowValue& row, std::uint32_t& to) {
  if (!row.is_there()) return !row.key.is_needed;
  to = row.key.type == ValueType::groups ? read_groups(row.reading, row.from.items(row.key.name))
                                         : find_material(row.reading, row.node(), to);
  return true;
}

bool read_value(const RowValue& row, std::string& to) {
  std::optional<std::string> read;
  if (row.key.type == ValueType::name)
    read = optional_name(row.from);
  else if (row.key.type == ValueType::text)
    read = row.from.text(row.key.name, to);
  else
    read_value(row, read);
  to = read.value_or(to);
  return read || !row.key.is_needed;
}

bool read_value(const RowValue& row, std::optional<std::string>& to) {
  to = row.from.reference(row.key.name);
  return true;
}

bool read_value(const RowValue& row, std::vector<std::string>& to) {
  to = read_names(row.reading, row.from, row.key.name);
  return true;
}

bool read_value(const RowValue& row, Vec3& to) {
  const std::string_view name = row.key.name;
  if (row.key.type == ValueType::direction)
    to = row.from.direction(name, to == Vec3(0) ? Vec3(1, 0, 0) : to);
  else
    to = row.key.type == ValueType::colour ? row.from.colour(name, to) : row.from.vec(name, to);
  return true;
}

bool read_value(const RowValue& row, Pose& to) {
  to = row.from.pose();
  return true;
}

}  // namespace pantin::detail
