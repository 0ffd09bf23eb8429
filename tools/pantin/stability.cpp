#include "tools/pantin/stability.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>  // join, since fmt 11

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <memory>

#include "engine/base/utf8.hpp"
#include "engine/scene/json/text_file.hpp"
#include "tools/pantin/command_line.hpp"
#include "tools/pantin/scene_number.hpp"

namespace pantin::program {
namespace {

using Clock = std::chrono::steady_clock;

/// Parses "x=a..b", or "x=a" for a single value.
Result<Axis> read_axis(const std::string& text) {
  const auto fault = [&](std::string_view why = "") {
    return Error{
        fmt::format("--over: found \"{}\"{}, expected NAME=FROM..TO, as in step=1e-3..0.1 or "
                    "/bodies/0/mass=1..100",
                    printable(text), why)};
  };
  const std::size_t equals = text.rfind('=');
  if (equals == std::string::npos || equals == 0) return fault();
  const std::size_t dots = std::min(text.find("..", equals), text.size());
  Axis axis;
  axis.name = text.substr(0, equals);
  const auto number = [&](std::size_t from, std::size_t to, double& x) {
    const char *begin = text.data() + from, *end = text.data() + to;
    const auto read = std::from_chars(begin, end, x);
    return read.ec == std::errc() && read.ptr == end && std::isfinite(x);
  };
  const bool is_range = dots < text.size();
  if (!number(equals + 1, dots, axis.from)) return fault();
  axis.to = axis.from;
  if (is_range && !number(dots + 2, text.size(), axis.to)) return fault();
  if (is_range && !(axis.from < axis.to)) return fault(", in which the range does not go up");
  axis.is_log = axis.from > 0 && axis.to >= 10 * axis.from;
  if (axis.name == "step" || axis.name == "tolerance") {
    if (axis.from <= 0) return fault(", which begins at no more than 0");
    return axis;
  }
  for (std::size_t at = 0; at <= axis.name.size();) {
    const std::size_t end = std::min(axis.name.find(',', at), axis.name.size());
    axis.pointers.push_back(axis.name.substr(at, end - at));
    at = end + 1;
  }
  return axis;
}

class Survey {
 public:
  Survey(const MapChoices& c, Journal& journal)
      : c_(c), journal_(journal), begin_(Clock::now()), progress_(c.scene) {}

  Result<Done> read();
  /// Null if it was interrupted.
  Result<Json> make();

 private:
  Result<std::string> text_at(double x, double y) const;
  void find_whole_axes();
  Result<Json> map_of(const Method& method);
  std::optional<Symptom> ask(const Method& method, double x, double y);
  double seconds() const { return std::chrono::duration<double>(Clock::now() - begin_).count(); }

  const MapChoices& c_;
  Journal& journal_;
  Clock::time_point begin_;
  Progress progress_;
  std::string text_, key_;
  std::optional<Scene> scene_;
  std::vector<Axis> axes_;
  std::vector<Method> methods_;
  double allowed_ = 0;  // s since begin_, for the present map
  std::vector<Error> faults_;
};

/// The text of the scene with the numbers of a place.
Result<std::string> Survey::text_at(double x, double y) const {
  Result<std::string> text = text_;
  const double parts[] = {x, y};
  for (std::size_t a = 0; a < axes_.size(); ++a)
    for (const std::string& pointer : axes_[a].pointers) {
      text = with_number(*text, pointer, axes_[a].at(parts[a]));
      if (!text) return Error{"--over: " + text.errors().front().message};
    }
  return text;
}

/// An axis counts where the scene refuses its fractions.
void Survey::find_whole_axes() {
  const Method own = *method_named("scene");
  for (std::size_t a = 0; a < axes_.size(); ++a) {
    if (axes_[a].pointers.empty() || axes_[a].from != std::floor(axes_[a].from)) continue;
    Axis& axis = axes_[a];
    const Axis asked = axis;
    axis.from = std::floor(axis.from) + 0.5;
    const auto fraction = text_at(0, 0);
    const bool refused = fraction && !load(c_.scene, *fraction, own).scene;
    axis.from = asked.from + 1;
    const auto whole = text_at(0, 0);
    axis = asked;
    axis.is_whole = refused && whole && load(c_.scene, *whole, own).scene;
  }
}

Result<Done> Survey::read() {
  Result<std::string> text = read_text(c_.scene, SceneLimits{}.bytes, "a scene file");
  if (!text) return text.errors();
  text_ = std::move(*text);
  for (const std::string& over : c_.over) {
    Result<Axis> axis = read_axis(over);
    if (!axis) return axis.errors();
    axes_.push_back(std::move(*axis));
  }
  Loaded own = load(c_.scene, text_, *method_named("scene"));
  if (!own.scene) return Error{own.refusal};
  scene_ = std::move(own.scene);
  if (auto placed = text_at(0, 0); !placed) return placed.errors();
  find_whole_axes();
  for (const std::string& name : c_.methods) methods_.push_back(*method_named(name));
  if (methods_.empty()) methods_.push_back(*method_named("scene"));
  key_ = fmt::format("{}|{}|{}|{}", hex(hash_of(*scene_, text_)), c_.scene,
                     c_.duration.value_or(scene_->duration), c_.step.value_or(scene_->step));
  return Done{};
}

std::optional<Symptom> Survey::ask(const Method& method, double x, double y) {
  std::string key = key_ + "|" + method.name;
  Case run{nullptr, c_.step.value_or(scene_->step), c_.duration.value_or(scene_->duration)};
  const double parts[] = {x, y};
  for (std::size_t a = 0; a < axes_.size(); ++a) {
    key += fmt::format("|{}={}", axes_[a].name, axes_[a].at(parts[a]));
    if (axes_[a].pointers.empty())
      (axes_[a].name == "step" ? run.step : run.tolerance) = axes_[a].at(parts[a]);
  }
  if (const Json* known = journal_.find(key))
    return symptom_named((*known)["symptom"].get<std::string>());
  if (interrupted() || seconds() > allowed_ || !faults_.empty()) return std::nullopt;
  const Result<std::string> text = text_at(x, y);
  if (!text) {
    faults_ = text.errors();
    return std::nullopt;
  }
  const Loaded loaded = load(c_.scene, *text, method);
  run.loaded = &loaded;
  Verdict verdict = judge(run);
  if (interrupted()) return std::nullopt;
  Json result{{"symptom", word_of(verdict.worst)}, {"all", Json::array()}};
  for (const Symptom s : verdict.all) result["all"].push_back(word_of(s));
  result["measured"] = std::move(verdict.measured);
  if (const auto kept = journal_.add(key, result); !kept) faults_ = kept.errors();
  return verdict.worst;
}

Result<Json> Survey::map_of(const Method& method) {
  Map map(c_.grid, c_.halvings, axes_.size());
  const double from = seconds();
  const bool whole = map.draw([&](double x, double y) {
    progress_.show(std::min(1.0, (seconds() - from) / (allowed_ - from)));
    return ask(method, x, y);
  });
  if (!faults_.empty()) return faults_;
  Json j{{"method", method.name}, {"complete", whole}, {"size", map.size()}};
  j["cells"] = Json::array(), j["points"] = Json::array();
  std::map<std::string, int> counts;
  for (const Cell& c : map.cells())
    j["cells"].push_back({c.x, c.y, c.size, static_cast<int>(map.at(c.x, c.y))});
  for (const auto& [at, symptom] : map.points())
    j["points"].push_back({at.first, at.second, static_cast<int>(symptom)});
  double area = 0;
  std::map<Symptom, double> shares;
  for (const Cell& c : map.cells()) {
    const double own = axes_.size() > 1 ? 1.0 * c.size * c.size : c.size;
    area += own, shares[map.at(c.x, c.y)] += own;
  }
  j["shares"] = Json::object();
  for (const auto& [symptom, own] : shares) j["shares"][std::string(word_of(symptom))] = own / area;
  if (axes_.size() > 1) return j;
  j["boundaries"] = Json::array();
  for (const Cell& c : map.cells()) {
    const Symptom a = map.at(c.x, 0), b = map.at(c.x + c.size, 0);
    const double size = map.size();
    if (a != b)
      j["boundaries"].push_back({{"from", axes_[0].at(c.x / size)},
                                 {"to", axes_[0].at((c.x + c.size) / size)},
                                 {"before", word_of(a)},
                                 {"after", word_of(b)}});
  }
  return j;
}

Result<Json> Survey::make() {
  Json j = build_and_machine();
  j["scene"] = c_.scene, j["title"] = scene_->title;
  j["duration_s"] = c_.duration.value_or(scene_->duration);
  j["step_s"] = c_.step.value_or(scene_->step);
  j["symptoms"] = Json::array();
  for (int s = 0; s <= static_cast<int>(Symptom::ok); ++s)
    j["symptoms"].push_back(word_of(static_cast<Symptom>(s)));
  j["axes"] = Json::array();
  for (const Axis& axis : axes_)
    j["axes"].push_back({{"name", axis.name},
                         {"from", axis.from},
                         {"to", axis.to},
                         {"log", axis.is_log},
                         {"whole", axis.is_whole}});
  j["maps"] = Json::array();
  for (std::size_t m = 0; m < methods_.size(); ++m) {
    const double left = c_.time - seconds();
    allowed_ = seconds() + left / static_cast<double>(methods_.size() - m);
    Result<Json> map = map_of(methods_[m]);
    if (!map) return map.errors();
    if (interrupted()) return Json();
    j["maps"].push_back(std::move(*map));
  }
  return j;
}

void print_map(const Json& j) {
  fmt::print("{}\n", bold(fmt::format("{}: {:.3g} s", j["scene"].get<std::string>(),
                                      j["duration_s"].get<double>())));
  for (const Json& map : j["maps"]) {
    std::string shares;
    for (const auto& [word, share] : map["shares"].items())
      shares +=
          fmt::format("{}{:.0f} % {}", shares.empty() ? "" : ", ", 100 * share.get<double>(), word);
    fmt::print("  {:<28} {}{}\n", map["method"].get<std::string>(),
               shares.empty() ? "the time was over before the coarse grid was known" : shares,
               map["complete"].get<bool>() ? "" : " (coarse: the time was over)");
    for (const Json& b : map.value("boundaries", Json::array()))
      fmt::print("    {}: {} up to {:.4g}, {} from {:.4g}\n",
                 j["axes"][0]["name"].get<std::string>(), b["before"].get<std::string>(),
                 b["from"].get<double>(), b["after"].get<std::string>(), b["to"].get<double>());
  }
}

int stability(const MapChoices& c) {
  const auto fail = [](const std::vector<Error>& errors, int code) {
    for (const Error& e : errors) print_error(e.message);
    return code;
  };
  if (c.over.empty() || c.over.size() > 2) {
    complain(fmt::format("--over: found {}, expected one or two axes", c.over.size()));
    return kUsage;
  }
  if (const auto made = make_folder(c.out); !made) return fail(made.errors(), kUnwritable);
  Journal journal;
  if (const auto opened = journal.open(
          c.out + "/runs.jsonl", c.afresh ? Journal::Earlier::discarded : Journal::Earlier::kept);
      !opened)
    return fail(opened.errors(), kUnwritable);
  Survey survey(c, journal);
  if (const auto read = survey.read(); !read) return fail(read.errors(), kUsage);
  const Result<Json> made = survey.make();
  if (interrupted()) {
    complain("interrupted; the same command goes on from here");
    return kInterrupted;
  }
  if (!made) return fail(made.errors(), kUsage);
  const std::string text = made->dump(-1, ' ', true, Json::error_handler_t::replace) + "\n";
  if (const int code = write_or_complain(c.out + "/map.json", text); code != kOk) return code;
  if (c.json)
    print_json(*made);
  else
    print_map(*made);
  draw_results("map", c.out);
  if (!c.json) fmt::print("{}/map.json\n", c.out);
  return kOk;
}

constexpr const char* kExamples =
    R"(Maps where methods fail, over one or two numbers of a scene. An axis is step, tolerance
(of a step; 1e-6 otherwise), or a JSON pointer to a number of the file, in which elements of lists
may be named: /bodies/ball/mass; several pointers with commas between take the same value. Axes that span a factor of ten or more are logarithmic;
numbers that the scene accepts only whole stay whole. A coarse grid is divided where neighbours
differ, so that boundaries are found by bisection. map.json and its picture (map.svg, map.png; by
python3 with matplotlib) are in the folder of --out. Interrupted, the same command goes on.

Examples:
  pantin stability assets/scenes/heavy_tip.json --over step=2e-3..0.1 --duration 0.5 --time 5
  pantin stability assets/scenes/pendulum.json --over step=0.01..1

What a run suffers from, the most serious first; the amounts and bounds are those of the findings of
`pantin run`, documented in engine/runtime/README.md:
  refused           the method does not support the scene
  blows up          the run ended: not finite, out of bounds, severalfold energy
  does not converge joints contradict each other, or contacts, pins or steps are not solved
  tears             a joint, cable, gear or surface is open by a thousandth of its mechanism
  gains energy      more than a twentieth of the greatest kinetic energy and all work
  sinks             bodies overlap or have passed through each other
  freezes           loses energy likewise, without anything that dissipates it
  jitters           in the last quarter a body that stays within a hundredth of the size of the
                    motion reverses in a quarter of the steps, at 5 mm/s or faster
  stalls            takes more CPU time than the time it simulates
  ok

--json prints map.json: the build and machine, scene, title, duration_s, step_s, symptoms, axes
(name, from, to, log, whole) and maps; a map has method, complete (false: the time was over), size
(of the lattice), cells (x, y, size, symptom at its corner), points (x, y, symptom), shares and, for
one axis, boundaries.

Exit codes: 0 ok, 2 usage or bad input, 4 could not write, 130 interrupted.)";

}  // namespace

void add_stability(CommandLine& program) {
  auto c = std::make_shared<MapChoices>();
  std::vector<std::string> names;
  for (const Method& method : all_methods()) names.push_back(method.name);
  const Subcommand command = program.add("stability", "Maps where methods fail");
  command.option("scene", c->scene, "scene file").required().type(kSceneType);
  command.option("--over", c->over, "an axis, as in step=1e-3..0.1; up to two")
      .required()
      .one_at_a_time();
  command.option("--methods", c->methods, "commas between; default: scene, its own settings")
      .separated_by(',')
      .one_of(names)
      .one_at_a_time();
  command.option("--out", c->out, "folder of the results; default out/stability").type(kFolderType);
  command.option("--step", c->step, "step length in seconds, where it is no axis")
      .between(1e-6, 1.0);
  command.option("--duration", c->duration, "simulated seconds").between(1e-6, 1e6);
  command.option("--grid", c->grid, "cells of the coarse grid along an axis; default 8")
      .within(1, 100);
  command.option("--halvings", c->halvings, "how often cells are divided; default 2").within(0, 20);
  command.option("--time", c->time, "seconds in all; default 300").between(0.1, 1e6);
  command.flag("--afresh", c->afresh, "discard the results of earlier runs in that folder");
  command.flag("--json", c->json, "print map.json instead of text");
  command.footer(kExamples);
  command.runs([c] { return stability(*c); });
}

}  // namespace pantin::program
