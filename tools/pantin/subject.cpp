#include "tools/pantin/subject.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/scene/json/text_file.hpp"

namespace pantin::program {
namespace {

Json to_json(const Reference& reference) {
  Json r{{"method", reference.method},
         {"step_s", reference.step},
         {"position_m", reference.own.position},
         {"origin_m", reference.own.origin},
         {"orientation_rad", json_number(reference.own.orientation)},
         {"energy_j", json_number(reference.own.energy)},
         {"agreed", reference.agreed},
         {"compared", reference.compared},
         {"size_m", reference.size},
         {"tried", Json::array()}};
  for (const Reference::Tried& t : reference.tried)
    r["tried"].push_back({{"method", t.method},
                          {"step_s", t.step},
                          {"position_m", t.own.position},
                          {"agreed", t.agreed}});
  return r;
}

/// NaN for null.
double number_of(const Json& j) {
  return j.is_number() ? j.get<double>() : std::numeric_limits<double>::quiet_NaN();
}

/// Without the motion.
Reference from_json(const Json& r) {
  Reference reference;
  reference.method = r["method"].get<std::string>(), reference.step = r["step_s"].get<double>();
  reference.own = {r["position_m"].get<double>(), r["origin_m"].get<double>(),
                   number_of(r["orientation_rad"]), number_of(r["energy_j"])};
  reference.compared = r["compared"].get<std::size_t>();
  reference.agreed = r["agreed"].get<std::size_t>(), reference.size = r["size_m"].get<double>();
  for (const Json& t : r["tried"])
    reference.tried.push_back({t["method"].get<std::string>(),
                               t["step_s"].get<double>(),
                               {t["position_m"].get<double>(), 0, 0, 0},
                               t["agreed"].get<std::size_t>()});
  return reference;
}

}  // namespace

double Subject::coarsest_steps() const {
  return std::max(1.0, std::round(sampling.interval / coarsest));
}

const Loaded& Subject::method(const std::string& name) const {
  return *std::ranges::find(loaded, name, [](const Loaded& l) { return l.method.name; });
}

Result<Subject> read_subject(const std::string& path, const Span& span) {
  Result<std::string> text = read_text(path, SceneLimits{}.bytes, "a scene file");
  if (!text) return text.errors();
  Subject s;
  s.path = path, s.text = std::move(*text);
  for (const Method& method : all_methods()) s.loaded.push_back(load(path, s.text, method));
  if (!s.loaded.back().scene) return Error{s.loaded.back().refusal};
  const double duration = span.duration.value_or(s.own().duration);
  s.coarsest = std::min(span.coarsest.value_or(span.coarser * s.own().step), duration);
  const double steps = std::max(1.0, std::floor(duration / s.coarsest * (1 + 1e-9)));
  const double each = std::ceil(steps / kMostSamples);
  s.sampling = {each * s.coarsest, static_cast<int>(std::floor(steps / each * (1 + 1e-9)))};
  std::size_t bodies = 0;
  for (const Body& b : s.own().world.bodies.values()) bodies += b.motion == Motion::dynamic;
  divide(s.sampling, static_cast<std::uint64_t>(s.coarsest_steps()), bodies);
  s.key = fmt::format("{}|{}", hex(hash_of(s.own(), s.text)), path);
  return s;
}

Result<Reference> reference_of(const Subject& subject, Journal& journal, const Search& search) {
  const std::string key = subject.key + "|reference";
  if (const Json* known = journal.find(key); known && (*known)["step_s"].get<double>() > 0)
    return from_json(*known);
  Reference reference = find_reference(subject.loaded, search);
  if (interrupted()) return reference;
  if (auto kept = journal.add(key, to_json(reference)); !kept) return kept.errors();
  return reference;
}

void rerun(const Subject& subject, Reference& reference) {
  if (!reference.holds() || reference.track.samples() > 0) return;
  const Loaded& by = subject.method(reference.method);
  reference.track = run_motion({&*by.scene, reference.step, 0, subject.sampling}).track;
}

std::optional<double> event_unseen(const Subject& subject, const Reference& reference) {
  if (!reference.holds()) return std::nullopt;
  return event_after(subject.own().world, subject.sampling, reference.compared);
}

Json json_number(double x) { return std::isfinite(x) ? Json(x) : Json(nullptr); }

}  // namespace pantin::program
