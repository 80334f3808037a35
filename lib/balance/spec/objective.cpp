#include "balance/spec/objective.hpp"

#include "balance/base/error.hpp"
#include "balance/base/nearest.hpp"
#include "balance/result/effort_names.hpp"
#include "balance/result/tracks.hpp"
#include "balance/spec/read_spec.hpp"
#include "balance/spec/workspace.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace balance::specification {

namespace {

struct NamedSize {
  const char* name;
  ObjectiveTerm::Size size;
};

constexpr NamedSize size_names[]{{"added-mass", ObjectiveTerm::Size::added_mass},
                                 {"added-inertia", ObjectiveTerm::Size::added_inertia},
                                 {"total-mass", ObjectiveTerm::Size::total_mass}};

struct NamedFigure {
  const char* name;
  Statistic figure;
};

constexpr NamedFigure figure_names[]{
    {"peak", Statistic::peak}, {"rms", Statistic::rms}, {"mean", Statistic::mean}, {"range", Statistic::range}};

ObjectiveTerm::Size read_size(const SpecCursor& at) {
  std::vector<std::string> names;
  for (const NamedSize& size : size_names) names.emplace_back(size.name);
  const auto found = std::find(names.begin(), names.end(), at.is_scalar() ? at.node().text : "");
  if (found != names.end()) return size_names[found - names.begin()].size;
  at.fail({.expected = fmt::format("what to minimize ({}, or a figure along a trajectory such as {{rms: torque}})",
                                   join_with_conjunction(names, "or")),
           .found = fmt::format("{}{}", at.describe_found(),
                                at.is_scalar() ? append_nearest_name(at.node().text, names) : "")});
}

/// Some may be missing because of a mistake.
bool can_lack_trajectories(const SpecCursor& at) {
  return at.problems().is_section_invalid("motion") || at.problems().is_section_invalid("trajectories");
}

}  // namespace

std::string read_quantity(const SpecCursor& at, const Study& study) {
  const auto names = list_metric_names(study.mechanism);
  const SpecErrorCollector& problems = at.problems();
  const std::string given = at.is_scalar() ? resolve_quantity_name(at.node().text, names) : "";
  const bool known = std::find(names.begin(), names.end(), given) != names.end();
  if (known) return given;
  if (problems.is_uncertain("actuators") || problems.is_uncertain("joints")) throw CascadingError();
  return names[at.read_choice("a quantity", names)];
}

std::string read_trajectory_name(const SpecCursor& at, const Study& study) {
  std::vector<std::string> names;
  for (const Trajectory& trajectory : study.trajectories) names.push_back(trajectory.name);
  const bool known = at.is_scalar() && std::find(names.begin(), names.end(), at.node().text) != names.end();
  if (!known && can_lack_trajectories(at)) throw CascadingError();
  if (names.empty())
    at.fail({.expected = "a spec with a trajectory", .found = fmt::format("{} but no motion", at.describe_found())});
  return names[at.read_choice("a trajectory", names)];
}

std::string default_trajectory_name(const SpecCursor& at, const Study& study) {
  if (study.trajectories.empty() && can_lack_trajectories(at)) throw CascadingError();
  if (study.trajectories.empty()) at.fail({.expected = "a spec with a trajectory", .found = "a figure but no motion"});
  if (is_mechanism_dependent(study.trajectories.front()))
    at.fail({.expected = "'along' a trajectory that does not depend on the mechanism",
             .found = "none, and the spec's first one is found for the mechanism"});
  return study.trajectories.front().name;
}

double read_weight(const SpecCursor& at, SpecParameters& parameters) {
  if (!at.is_scalar()) at.fail_expected("a weight, a number or an expression");
  const double weight = parameters.evaluate(at).value();
  if (weight < 0)
    at.fail({.kind = "must not be negative", .expected = "a weight ≥ 0", .found = fmt::format("{}", weight)});
  return weight;
}

double read_deviation_multiple(const SpecCursor& at, SpecParameters& parameters, const Study& study) {
  if (!at.is_scalar()) at.fail_expected("how many deviations, a number or an expression");
  const double count = parameters.evaluate(at).value();
  if (!(count >= 0))
    at.fail(
        {.kind = "must not be negative", .expected = "a number of deviations ≥ 0", .found = fmt::format("{}", count)});
  if (study.tolerances.empty()) {
    if (at.problems().is_uncertain("tolerances")) throw CascadingError();
    at.fail({.expected = "a spec with 'tolerances', which say how far its numbers may be off", .found = "none"});
  }
  return count;
}

void require_prescribed_motion(const SpecCursor& at, const ObjectiveTerm& term, const Study& study) {
  for (const Trajectory& trajectory : study.trajectories)
    if (trajectory.name == term.trajectory && is_mechanism_dependent(trajectory))
      at.fail({.expected = "a trajectory that does not depend on the mechanism, which has deviations",
               .found = quote_for_message(term.trajectory)});
}

namespace {

/// `over: workspace`, which must be there.
void read_over(const SpecCursor& at, const Study& study) {
  at.read_choice("what to go over", {workspace_name});
  if (at.problems().is_uncertain(workspace_name)) throw CascadingError();
  const auto& all = study.trajectories;
  if (std::none_of(all.begin(), all.end(), [](const Trajectory& t) { return t.name == workspace_name; }))
    at.fail({.expected = "a spec with a 'workspace'", .found = "none"});
}

ObjectiveTerm read_weighted_term(const SpecCursor& at, SpecParameters& parameters, const Study& study);

bool states_key(const SpecCursor& at, const char* key) {
  const auto& keys = at.node().keys;
  return at.is_map() && std::any_of(keys.begin(), keys.end(), [&](const YamlNode& one) { return one.text == key; });
}

/// `{mean_plus: 3, of: {peak: torque, along: cycloid}, weight: 2}`.
ObjectiveTerm read_robust_term(const SpecCursor& at, SpecParameters& parameters, const Study& study) {
  ObjectiveTerm term;
  double weight = 1;
  std::optional<double> plus;
  const auto read_figure = [&](const SpecCursor& c) {
    if (!c.is_map() || states_key(c, "of") || states_key(c, "weight") || states_key(c, "mean_plus"))
      c.fail(
          {.expected = "a figure along a trajectory such as {rms: torque, along: cycloid}, without a weight of its own",
           .found = !c.is_map()               ? c.describe_found()
                    : states_key(c, "weight") ? "a weight"
                                              : "another term"});
    term = read_weighted_term(c, parameters, study);
  };
  if (!read_fields(at, "a term {mean_plus: 3, of: {rms: torque, along: cycloid}}",
                   {{"mean_plus", Presence::required,
                     [&](const SpecCursor& c) { plus = read_deviation_multiple(c, parameters, study); }},
                    {"of", Presence::required, read_figure},
                    {"weight", Presence::optional, [&](const SpecCursor& c) { weight = read_weight(c, parameters); }}}))
    throw CascadingError();
  term.deviation_multiple = plus;
  term.weight = weight;
  require_prescribed_motion(at, term, study);
  return term;
}

/// `{of: added-mass, weight: 0.5}` or `{rms: torque, along: cycloid, weight: 2}`.
ObjectiveTerm read_weighted_term(const SpecCursor& at, SpecParameters& parameters, const Study& study) {
  if (states_key(at, "mean_plus")) return read_robust_term(at, parameters, study);
  ObjectiveTerm term;
  std::optional<SpecCursor> first, along, over;
  const auto once = [&](const SpecCursor& c) {
    if (first) c.fail({.expected = "one of 'of', 'peak', 'rms', 'mean' and 'range'", .found = "a second one"});
    first = c;
  };
  std::vector<Field> fields{
      {"of", Presence::optional,
       [&](const SpecCursor& c) {
         once(c);
         if (c.is_scalar() && c.node().text == "duration")
           term.run = ObjectiveTerm::RunMeasure::duration;
         else
           term.size = read_size(c);
       }},
      {"along", Presence::optional, [&](const SpecCursor& c) { along = c; }},
      {"over", Presence::optional, [&](const SpecCursor& c) { over = c; }},
      {"weight", Presence::optional, [&](const SpecCursor& c) { term.weight = read_weight(c, parameters); }},
      {"mean_plus", Presence::optional, [](const SpecCursor&) {}}};  // named in messages; read above
  for (const NamedFigure& one : figure_names)
    fields.push_back({one.name, Presence::optional, [&, one](const SpecCursor& c) {
                        once(c);
                        term.figure = one.figure;
                        term.quantity = read_quantity(c, study);
                      }});
  if (!read_fields(at, "a term {of: added-mass} or {rms: torque, along: cycloid}", fields)) return term;
  if (!first) at.fail_missing({"of", "peak", "rms", "mean", "range"});
  const bool size = term.size != ObjectiveTerm::Size::none;
  if (over && along) over->fail({.expected = "'along' a trajectory or 'over: workspace'", .found = "both"});
  if (over) read_over(*over, study);
  if (over) along = over;
  if (size && along) along->fail({.expected = "no 'along' with 'of', which does not depend on a trajectory"});
  if (!size && along) term.trajectory = read_trajectory_name(*along, study);
  if (!size && !along) term.trajectory = default_trajectory_name(at, study);
  return term;
}

ObjectiveTerm read_term(const SpecCursor& at, SpecParameters& parameters, const Study& study) {
  if (at.is_map()) return read_weighted_term(at, parameters, study);
  ObjectiveTerm term;
  term.size = read_size(at);
  return term;
}

}  // namespace

std::vector<ObjectiveTerm> read_objective_terms(const SpecCursor& at, SpecParameters& parameters, const Study& study) {
  if (!at.is_list()) return {read_term(at, parameters, study)};
  std::vector<ObjectiveTerm> terms;
  for (const SpecCursor& item : at.items("a list of terms"))
    at.problems().collect([&] { terms.push_back(read_term(item, parameters, study)); });
  if (at.node().items.empty()) at.fail_expected("at least one term");
  return terms;
}

}  // namespace balance::specification

namespace balance {

std::vector<ObjectiveTerm> read_objective(const std::string& text, const Study& study) {
  using namespace specification;
  SpecErrorCollector problems = SpecErrorCollector::of_option("--minimize");
  std::vector<ObjectiveTerm> terms;
  problems.collect([&] {
    if (text.find_first_not_of(" \t\r\n") == std::string::npos)
      throw ReadError({}, "", {.expected = "what to minimize", .found = "an empty text"});
    const YamlNode root = parse_yaml(text, problems);
    SpecParameters none;
    terms = read_objective_terms(SpecCursor(root, "", problems), none, study);
  });
  problems.throw_if_any();
  return terms;
}

}  // namespace balance
