#pragma once
/// Words for messages: numbers, lists, and the nearest of several names.
#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace pantin::detail {

/// The candidate nearest to `word` by edit distance, or "" if none is near. The first of equals.
std::string_view nearest(std::string_view word, std::span<const std::string_view> candidates);

/// "; nearest is "shin"", or "" if no candidate is near.
std::string hint(std::string_view word, std::span<const std::string_view> candidates);

/// Hints for the messages of one file. They cost at most about 0.1 s together; after that there are
/// none, so that a file of many wrong names is refused as fast as any other.
class Hints {
 public:
  bool any_left() const { return left_ > 0; }
  /// As above, or "" once the budget is spent.
  std::string_view nearest(std::string_view word, std::span<const std::string_view> candidates);
  std::string of(std::string_view word, std::span<const std::string_view> candidates);

 private:
  std::size_t left_ = 20'000'000;  // cells of edit distance tables
};

/// A number for a message, six digits at most.
std::string written(double number);

/// The shortest text that is read as the same number.
std::string number_text(double number);

/// A name in quotes, clipped and printable.
std::string quoted_name(std::string_view name);

/// "a, b or c".
std::string listed(std::span<const std::string_view> words);

}  // namespace pantin::detail
