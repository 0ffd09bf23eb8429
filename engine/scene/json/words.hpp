#pragma once
/// Words for messages: numbers, lists, and the nearest of several names.
#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace pantin::detail {

/// The candidate with the least edit distance to `word`, or "" if none is near. Ties go to the
/// first.
std::string_view nearest(std::string_view word, std::span<const std::string_view> candidates);

/// What a key or word of other engines and formats (MuJoCo, URDF and Gazebo, Bullet, Unity) is
/// called here, if the candidates have it, or "".
std::string_view called_here(std::string_view word, std::span<const std::string_view> candidates);

/// "; nearest is "shin"", or "" if no candidate is near.
std::string hint(std::string_view word, std::span<const std::string_view> candidates);

/// Name suggestions for the messages of one file. Their total cost is bounded to about 0.1 s; after
/// that none are made, so that a file with many wrong names is rejected as fast as any other.
class Hints {
 public:
  bool any_left() const { return left_ > 0; }
  /// As above, or "" once the budget is spent.
  std::string_view nearest(std::string_view word, std::span<const std::string_view> candidates);
  std::string of(std::string_view word, std::span<const std::string_view> candidates);
  /// Of a key or a word of the format: "; it is called "fixed" here" if it is one of another
  /// engine.
  std::string of_word(std::string_view word, std::span<const std::string_view> candidates);

 private:
  std::size_t left_ = 20'000'000;  // cells of edit distance tables
};

/// A number for a message, with at most six digits.
std::string written(double number);

/// The shortest text that reads back as the same number.
std::string number_text(double number);

/// A name in quotes, clipped and printable.
std::string quoted_name(std::string_view name);

/// "a, b or c".
std::string listed(std::span<const std::string_view> words);

}  // namespace pantin::detail
