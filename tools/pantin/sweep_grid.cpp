// The jobs of a sweep: from axes over settings, or from a list of commands.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>

#include "engine/base/hash.hpp"
#include "engine/base/utf8.hpp"
#include "engine/scene/json/text_file.hpp"
#include "tools/pantin/sweep.hpp"

namespace pantin::program {
namespace {

constexpr std::size_t kMostBytes = 1u << 30;  // of a list of commands
constexpr std::size_t kMostJobs = 1000000;
constexpr const char* kExpected =
    "NAME=A..B:COUNT, NAME=A..B or NAME=VALUE,VALUE, as in /bodies/ball/mass=1..10:5, seed=1..20 "
    "or solver=auto,lagrangian";

/// An axis of a sweep: the same values for all its names.
struct Values {
  std::vector<std::string> names, values;
};

std::optional<double> number_of(std::string_view text) {
  double x = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), x);
  if (read.ec != std::errc() || read.ptr != text.data() + text.size() || !std::isfinite(x))
    return std::nullopt;
  return x;
}

/// The parts of a text between commas that are outside of brackets and quotes.
std::vector<std::string> parts_of(std::string_view text) {
  std::vector<std::string> parts(1);
  int depth = 0;
  bool is_quoted = false;
  for (const char c : text) {
    if (c == '"') is_quoted = !is_quoted;
    if (!is_quoted && (c == '[' || c == '{')) ++depth;
    if (!is_quoted && (c == ']' || c == '}')) --depth;
    if (c == ',' && depth == 0 && !is_quoted)
      parts.emplace_back();
    else
      parts.back() += c;
  }
  return parts;
}

/// "1..10:5" or "1..20" as numbers, or what is wrong with them. `text` has two dots at `dots`.
Result<std::vector<std::string>> range_of(const std::string& text, std::size_t dots) {
  const std::size_t colon = std::min(text.find(':', dots), text.size());
  const auto from = number_of(std::string_view(text).substr(0, dots));
  const auto to = number_of(std::string_view(text).substr(dots + 2, colon - dots - 2));
  if (!from || !to) return Error{"a side of .. is no number"};
  if (*from > *to) return Error{fmt::format("the range goes down from {} to {}", *from, *to)};
  std::vector<std::string> values;
  if (colon == text.size()) {
    if (*from != std::floor(*from) || *to != std::floor(*to))
      return Error{"the ends are not whole numbers and there is no :COUNT"};
    if (*to - *from >= kMostJobs)
      return Error{fmt::format("it has more than {} values", kMostJobs)};
    for (double x = *from; x <= *to; ++x) values.push_back(fmt::format("{}", x));
    return values;
  }
  const auto count = number_of(std::string_view(text).substr(colon + 1));
  if (!count || *count != std::floor(*count) || *count < 2 || *count > kMostJobs)
    return Error{fmt::format("COUNT is no whole number from 2 to {}", kMostJobs)};
  const bool is_log = *from > 0 && *to >= 10 * *from;
  for (int i = 0; i < static_cast<int>(*count); ++i) {
    const double part = i / (*count - 1);
    const double x = i == 0                              ? *from
                     : i + 1 == static_cast<int>(*count) ? *to
                     : is_log                            ? *from * std::pow(*to / *from, part)
                                                         : *from + part * (*to - *from);
    values.push_back(fmt::format("{}", x));
  }
  return values;
}

Result<Values> read_values(const std::string& text) {
  const std::size_t equals = text.find('=');
  const Error fault{fmt::format("--over: found \"{}\", expected {}", printable(text), kExpected)};
  if (equals == std::string::npos || equals == 0 || equals + 1 == text.size()) return fault;
  Values axis;
  axis.names = parts_of(std::string_view(text).substr(0, equals));
  const std::string values = text.substr(equals + 1);
  if (const std::size_t dots = values.find(".."); dots == std::string::npos) {
    axis.values = parts_of(values);
  } else {
    Result<std::vector<std::string>> range = range_of(values, dots);
    if (!range)
      return Error{fmt::format("--over: found \"{}\", in which {}, expected {}", printable(text),
                               range.errors().front().message, kExpected)};
    axis.values = std::move(*range);
  }
  const auto is_empty = [](const std::string& s) { return s.empty(); };
  if (std::ranges::any_of(axis.names, is_empty) || std::ranges::any_of(axis.values, is_empty))
    return fault;
  return axis;
}

/// The words that give a name a value: a name with a slash is a place in the scene, any other an
/// option of the command.
void add_setting(std::vector<std::string>& words, const std::string& name,
                 const std::string& value) {
  if (name.find('/') != std::string::npos)
    words.insert(words.end(), {"--set", name + "=" + value});
  else
    words.insert(words.end(), {"--" + name, value});
}

void add_job(std::vector<Job>& jobs, std::set<std::string>& known, Job job) {
  Hash hash;
  for (const std::string& word : job.words) hash.add(std::string_view(word));
  job.id = hex(hash.value());
  if (known.insert(job.id).second) jobs.push_back(std::move(job));
}

Result<std::vector<Job>> grid_of(const SweepChoices& c) {
  std::vector<Values> axes;
  for (const std::string& over : c.over) {
    Result<Values> axis = read_values(over);
    if (!axis) return axis.errors();
    axes.push_back(std::move(*axis));
  }
  std::vector<std::string> command = c.words;
  if (command.empty()) command = {"run", "--json"};
  std::size_t count = std::max<std::size_t>(1, c.scenes.size());
  for (const Values& axis : axes) {
    count *= axis.values.size();
    if (count > kMostJobs)
      return Error{fmt::format("found more than {} jobs, expected fewer", kMostJobs)};
  }
  std::vector<Job> jobs;
  std::set<std::string> known;
  for (std::size_t i = 0; i < count; ++i) {
    Job job;
    job.words = command;
    std::size_t rest = i, scenes = std::max<std::size_t>(1, c.scenes.size());
    if (!c.scenes.empty()) {
      job.words.insert(job.words.begin() + 1, c.scenes[rest % scenes]);
      job.set["scene"] = c.scenes[rest % scenes];
    }
    rest /= scenes;
    for (const Values& axis : axes) {
      const std::string& value = axis.values[rest % axis.values.size()];
      rest /= axis.values.size();
      for (const std::string& name : axis.names) {
        add_setting(job.words, name, value);
        const Json json = Json::parse(value, nullptr, false);
        job.set[name] = json.is_discarded() ? Json(value) : json;
      }
    }
    add_job(jobs, known, std::move(job));
  }
  return jobs;
}

Result<std::vector<Job>> listed(const std::string& path) {
  Result<std::string> text =
      detail::read_text(path == "-" ? "/dev/stdin" : path, kMostBytes, "a list of commands");
  if (!text) return text.errors();
  std::vector<Job> jobs;
  std::set<std::string> known;
  std::size_t number = 0;
  for (std::size_t at = 0; at < text->size();) {
    const std::size_t end = std::min(text->find('\n', at), text->size());
    Result<std::vector<std::string>> words =
        words_of_line(std::string_view(*text).substr(at, end - at));
    at = end + 1, ++number;
    if (!words)
      return Error{fmt::format("{}:{}: {}", path, number, words.errors().front().message)};
    if (!words->empty() && words->front() == "pantin") words->erase(words->begin());
    if (words->empty()) continue;
    Job job;
    job.words = std::move(*words);
    add_job(jobs, known, std::move(job));
  }
  return jobs;
}

}  // namespace

Result<std::vector<Job>> jobs_of(const SweepChoices& c) {
  if (!c.list.empty()) return listed(c.list);
  if (!c.one) return grid_of(c);
  std::vector<Job> jobs;
  std::set<std::string> known;
  Job job;
  job.words = c.words;
  add_job(jobs, known, std::move(job));
  return jobs;
}

std::string line_of(const std::vector<std::string>& words) {
  constexpr std::string_view kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+./=:,@%";
  std::string line;
  for (const std::string& word : words) {
    if (!line.empty()) line += ' ';
    if (!word.empty() && word.find_first_not_of(kPlain) == std::string::npos) {
      line += word;
      continue;
    }
    line += '\'';
    for (const char c : word) line += c == '\'' ? std::string("'\\''") : std::string(1, c);
    line += '\'';
  }
  return line;
}

Result<std::vector<std::string>> words_of_line(std::string_view line) {
  std::vector<std::string> words;
  bool is_word = false;
  char quote = 0;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (quote != 0) {
      if (c == quote)
        quote = 0;
      else
        words.back() += c;
      continue;
    }
    if (c == ' ' || c == '\t' || c == '\r') {
      is_word = false;
      continue;
    }
    if (c == '#' && !is_word) break;
    if (!is_word) words.emplace_back();
    is_word = true;
    if (c == '\'' || c == '"')
      quote = c;
    else if (c == '\\' && i + 1 < line.size())
      words.back() += line[++i];
    else
      words.back() += c;
  }
  if (quote != 0)
    return Error{fmt::format("found no closing {}, expected one in the same line", quote)};
  return words;
}

}  // namespace pantin::program
