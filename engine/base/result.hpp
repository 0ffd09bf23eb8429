#pragma once
/// Either a value or the errors that explain its absence. For mistakes that a user can make.
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace pantin {

/// One error: where it is, what was found, what was expected. `message` is one whole line.
struct Error {
  std::string message;
};

/// Thrown by Result::value() on failure; what() holds all errors, a line each.
class NoValue : public std::runtime_error {
 public:
  explicit NoValue(const std::vector<Error>& errors) : std::runtime_error(lines(errors)) {}

 private:
  static std::string lines(const std::vector<Error>& errors) {
    std::string text;
    for (const Error& e : errors) text += (text.empty() ? "" : "\n") + e.message;
    return text;
  }
};

template <class T>
class Result {
 public:
  Result(T value) : held_(std::move(value)) {}
  Result(Error error) : held_(std::vector<Error>{std::move(error)}) {}
  Result(std::vector<Error> errors) : held_(std::move(errors)) {}

  explicit operator bool() const { return held_.index() == 0; }
  T& operator*() { return std::get<0>(held_); }
  const T& operator*() const { return std::get<0>(held_); }
  T* operator->() { return &std::get<0>(held_); }
  const T* operator->() const { return &std::get<0>(held_); }

  /// The value; throws NoValue on failure.
  T& value() & {
    if (!*this) throw NoValue(errors());
    return std::get<0>(held_);
  }
  T value() && {
    if (!*this) throw NoValue(errors());
    return std::get<0>(std::move(held_));
  }

  /// All errors, in the order in which they were found. Only for a failed result.
  const std::vector<Error>& errors() const { return std::get<1>(held_); }

 private:
  std::variant<T, std::vector<Error>> held_;
};

/// A result that carries no value.
struct Done {};

}  // namespace pantin
