#include "balance/spec/objective.hpp"

#include "balance/base/error.hpp"
#include "balance/base/nearest.hpp"
#include "balance/result/effort_names.hpp"
#include "balance/result/tracks.hpp"
#include "balance/spec/read_spec.hpp"
#include "balance/spec/workspace.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace balance::read {

namespace {

struct NamedSize {
  const char* name;
  ObjectiveTerm::Size size;
};

constexpr NamedSize sizes[]{{"added-mass", ObjectiveTerm::Size::added_mass},
                            {"added-inertia", ObjectiveTerm::Size::added_inertia},
                            {"total-mass", ObjectiveTerm::Size::total_mass}};

struct NamedFigure {
  const char* name;
  Figure figure;
};

constexpr NamedFigure figures[]{
    {"peak", Figure::peak}, {"rms", Figure::rms}, {"mean", Figure::mean}, {"range", Figure::range}};

ObjectiveTerm::Size read_size(const Cursor& at) {
  std::vector<std::string> names;
  for (const NamedSize& size : sizes) names.emplace_back(size.name);
  const auto found = std::find(names.begin(), names.end(), at.is_scalar() ? at.node().text : "");
  if (found != names.end()) return sizes[found - names.begin()].size;
  at.fail({.expected = fmt::format("what to minimize ({}, or a figure along a trajectory such as {{rms: torque}})",
                                   listed(names, "or")),
           .found = fmt::format("{}{}", at.found(), at.is_scalar() ? nearest_hint(at.node().text, names) : "")});
}

/// Some may be missing because of a mistake.
bool may_lack_trajectories(const Cursor& at) {
  return at.problems().lost("motion") || at.problems().lost("trajectories");
}

}  // namespace

std::string read_quantity(const Cursor& at, const Study& study) {
  const auto names = figure_names(study.mechanism);
  const Problems& problems = at.problems();
  const std::string given = at.is_scalar() ? known_quantity(at.node().text, names) : "";
  const bool known = std::find(names.begin(), names.end(), given) != names.end();
  if (known) return given;
  if (problems.doubtful("actuators") || problems.doubtful("joints")) throw Consequence();
  return names[at.choice("a quantity", names)];
}

std::string read_along(const Cursor& at, const Study& study) {
  std::vector<std::string> names;
  for (const Trajectory& trajectory : study.trajectories) names.push_back(trajectory.name);
  const bool known = at.is_scalar() && std::find(names.begin(), names.end(), at.node().text) != names.end();
  if (!known && may_lack_trajectories(at)) throw Consequence();
  if (names.empty())
    at.fail({.expected = "a spec with a trajectory", .found = fmt::format("{} but no motion", at.found())});
  return names[at.choice("a trajectory", names)];
}

std::string first_along(const Cursor& at, const Study& study) {
  if (study.trajectories.empty() && may_lack_trajectories(at)) throw Consequence();
  if (study.trajectories.empty()) at.fail({.expected = "a spec with a trajectory", .found = "a figure but no motion"});
  if (depends_on_mechanism(study.trajectories.front()))
    at.fail({.expected = "'along' a trajectory that does not depend on the mechanism",
             .found = "none, and the spec's first one is found for the mechanism"});
  return study.trajectories.front().name;
}

double read_weight(const Cursor& at, Parameters& parameters) {
  if (!at.is_scalar()) at.expected("a weight, a number or an expression");
  const double weight = parameters.evaluate(at).value();
  if (weight < 0)
    at.fail({.kind = "must not be negative", .expected = "a weight ≥ 0", .found = fmt::format("{}", weight)});
  return weight;
}

double read_deviations(const Cursor& at, Parameters& parameters, const Study& study) {
  if (!at.is_scalar()) at.expected("how many deviations, a number or an expression");
  const double count = parameters.evaluate(at).value();
  if (!(count >= 0))
    at.fail(
        {.kind = "must not be negative", .expected = "a number of deviations ≥ 0", .found = fmt::format("{}", count)});
  if (study.tolerances.empty()) {
    if (at.problems().doubtful("tolerances")) throw Consequence();
    at.fail({.expected = "a spec with 'tolerances', which say how far its numbers may be off", .found = "none"});
  }
  return count;
}

void require_stated(const Cursor& at, const ObjectiveTerm& term, const Study& study) {
  for (const Trajectory& trajectory : study.trajectories)
    if (trajectory.name == term.trajectory && depends_on_mechanism(trajectory))
      at.fail({.expected = "a trajectory that does not depend on the mechanism, which has deviations",
               .found = in_quotes(term.trajectory)});
}

namespace {

/// `over: workspace`, which must be there.
void read_over(const Cursor& at, const Study& study) {
  at.choice("what to go over", {workspace_name});
  if (at.problems().doubtful(workspace_name)) throw Consequence();
  const auto& all = study.trajectories;
  if (std::none_of(all.begin(), all.end(), [](const Trajectory& t) { return t.name == workspace_name; }))
    at.fail({.expected = "a spec with a 'workspace'", .found = "none"});
}

ObjectiveTerm read_weighted_term(const Cursor& at, Parameters& parameters, const Study& study);

bool states_key(const Cursor& at, const char* key) {
  const auto& keys = at.node().keys;
  return at.is_map() && std::any_of(keys.begin(), keys.end(), [&](const Node& one) { return one.text == key; });
}

/// `{mean_plus: 3, of: {peak: torque, along: cycloid}, weight: 2}`.
ObjectiveTerm read_robust_term(const Cursor& at, Parameters& parameters, const Study& study) {
  ObjectiveTerm term;
  double weight = 1;
  std::optional<double> plus;
  const auto read_figure = [&](const Cursor& c) {
    if (!c.is_map() || states_key(c, "of") || states_key(c, "weight") || states_key(c, "mean_plus"))
      c.fail(
          {.expected = "a figure along a trajectory such as {rms: torque, along: cycloid}, without a weight of its own",
           .found = !c.is_map()               ? c.found()
                    : states_key(c, "weight") ? "a weight"
                                              : "another term"});
    term = read_weighted_term(c, parameters, study);
  };
  if (!read_fields(
          at, "a term {mean_plus: 3, of: {rms: torque, along: cycloid}}",
          {{"mean_plus", Need::required, [&](const Cursor& c) { plus = read_deviations(c, parameters, study); }},
           {"of", Need::required, read_figure},
           {"weight", Need::optional, [&](const Cursor& c) { weight = read_weight(c, parameters); }}}))
    throw Consequence();
  term.plus = plus;
  term.weight = weight;
  require_stated(at, term, study);
  return term;
}

/// `{of: added-mass, weight: 0.5}` or `{rms: torque, along: cycloid, weight: 2}`.
ObjectiveTerm read_weighted_term(const Cursor& at, Parameters& parameters, const Study& study) {
  if (states_key(at, "mean_plus")) return read_robust_term(at, parameters, study);
  ObjectiveTerm term;
  std::optional<Cursor> first, along, over;
  const auto once = [&](const Cursor& c) {
    if (first) c.fail({.expected = "one of 'of', 'peak', 'rms', 'mean' and 'range'", .found = "a second one"});
    first = c;
  };
  std::vector<Field> fields{
      {"of", Need::optional,
       [&](const Cursor& c) {
         once(c);
         if (c.is_scalar() && c.node().text == "duration")
           term.run = ObjectiveTerm::Run::duration;
         else
           term.size = read_size(c);
       }},
      {"along", Need::optional, [&](const Cursor& c) { along = c; }},
      {"over", Need::optional, [&](const Cursor& c) { over = c; }},
      {"weight", Need::optional, [&](const Cursor& c) { term.weight = read_weight(c, parameters); }},
      {"mean_plus", Need::optional, [](const Cursor&) {}}};  // named in messages; read above
  for (const NamedFigure& one : figures)
    fields.push_back({one.name, Need::optional, [&, one](const Cursor& c) {
                        once(c);
                        term.figure = one.figure;
                        term.quantity = read_quantity(c, study);
                      }});
  if (!read_fields(at, "a term {of: added-mass} or {rms: torque, along: cycloid}", fields)) return term;
  if (!first) at.missing({"of", "peak", "rms", "mean", "range"});
  const bool size = term.size != ObjectiveTerm::Size::none;
  if (over && along) over->fail({.expected = "'along' a trajectory or 'over: workspace'", .found = "both"});
  if (over) read_over(*over, study);
  if (over) along = over;
  if (size && along) along->fail({.expected = "no 'along' with 'of', which does not depend on a trajectory"});
  if (!size && along) term.trajectory = read_along(*along, study);
  if (!size && !along) term.trajectory = first_along(at, study);
  return term;
}

ObjectiveTerm read_term(const Cursor& at, Parameters& parameters, const Study& study) {
  if (at.is_map()) return read_weighted_term(at, parameters, study);
  ObjectiveTerm term;
  term.size = read_size(at);
  return term;
}

}  // namespace

std::vector<ObjectiveTerm> read_terms(const Cursor& at, Parameters& parameters, const Study& study) {
  if (!at.is_list()) return {read_term(at, parameters, study)};
  std::vector<ObjectiveTerm> terms;
  for (const Cursor& item : at.items("a list of terms"))
    at.problems().guard([&] { terms.push_back(read_term(item, parameters, study)); });
  if (at.node().items.empty()) at.expected("at least one term");
  return terms;
}

}  // namespace balance::read

namespace balance {

std::vector<ObjectiveTerm> read_objective(const std::string& text, const Study& study) {
  using namespace read;
  Problems problems = Problems::of_option("--minimize");
  std::vector<ObjectiveTerm> terms;
  problems.guard([&] {
    if (text.find_first_not_of(" \t\r\n") == std::string::npos)
      throw Problem({}, "", {.expected = "what to minimize", .found = "an empty text"});
    const Node root = parse_yaml(text, problems);
    Parameters none;
    terms = read_terms(Cursor(root, "", problems), none, study);
  });
  problems.throw_all();
  return terms;
}

}  // namespace balance
