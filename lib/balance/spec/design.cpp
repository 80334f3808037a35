// What the free numbers are to achieve.

#include "balance/base/nearest.hpp"
#include "balance/spec/choose.hpp"
#include "balance/spec/front.hpp"
#include "balance/spec/goals.hpp"
#include "balance/spec/limits.hpp"
#include "balance/spec/load_cases.hpp"
#include "balance/spec/objective.hpp"
#include "balance/spec/sections.hpp"
#include "balance/spec/subject_to.hpp"

#include <fmt/format.h>

namespace balance::specification {

namespace {

std::string read_search_method(const SpecCursor& at, const std::string& what, const std::vector<std::string>& names) {
  return names[at.read_choice(what, names)];
}

void read_search(const SpecCursor& at, StudyBuilder& draft, SearchOptions& search) {
  read_fields(
      at, "how to search {global, local, seed, restarts, evaluations, seconds}",
      {{"global", Presence::optional,
        [&](const SpecCursor& c) { search.global = read_search_method(c, "a global method", global_methods()); }},
       {"local", Presence::optional,
        [&](const SpecCursor& c) { search.local = read_search_method(c, "a local method", local_methods()); }},
       {"seed", Presence::optional,
        [&](const SpecCursor& c) { search.seed = static_cast<std::uint64_t>(read_integer(c, draft, 0, max_seed)); }},
       {"restarts", Presence::optional,
        [&](const SpecCursor& c) { search.max_restarts = static_cast<int>(read_integer(c, draft, 1, 10'000)); },
        "starts"},
       {"evaluations", Presence::optional,
        [&](const SpecCursor& c) {
          search.max_evaluations = static_cast<int>(read_integer(c, draft, 1, 100'000'000));
        }},
       {"seconds", Presence::optional, [&](const SpecCursor& c) {
          if (!c.is_scalar()) c.fail_expected("a number of seconds");
          search.max_time = draft.parameters.evaluate(c).value();
          if (!(search.max_time > 0))
            c.fail({.kind = "must be positive",
                    .expected = "a number of seconds > 0",
                    .found = fmt::format("{}", search.max_time)});
        }}});
}

}  // namespace

void read_design(const SpecCursor& section, StudyBuilder& draft) {
  DesignRequest& request = draft.study.design;
  std::optional<SpecCursor> front, cases, across, adapt;
  const auto keep = [](std::optional<SpecCursor>& slot) { return [&slot](const SpecCursor& c) { slot = c; }; };
  read_fields(
      section, "what to design for {goal, minimize, front, subject_to, choose, search, for, across, adapt}",
      {{"goal", Presence::optional, [&](const SpecCursor& c) { request.goals = read_goals(c); }},
       {"minimize", Presence::optional,
        [&](const SpecCursor& c) { request.minimize = read_objective_terms(c, draft.parameters, draft.study); }},
       {"front", Presence::optional, keep(front)},
       {"subject_to", Presence::optional,
        [&](const SpecCursor& c) { request.subject_to = read_figure_limits(c, draft); }},
       {"choose", Presence::optional,
        [&](const SpecCursor& c) { request.cardinality = read_cardinality_requests(c, draft); }},
       {"search", Presence::optional, [&](const SpecCursor& c) { read_search(c, draft, request.search); }},
       {"for", Presence::optional, keep(cases)},
       {"across", Presence::optional, keep(across)},
       {"adapt", Presence::optional, keep(adapt)}});
  if (front) draft.problems.collect([&] { request.front = read_pareto_request(*front, draft); });
  if (front && !request.minimize.empty())
    draft.problems.collect([&] { front->fail({.expected = "no 'minimize' beside a front", .found = "both"}); });
  if (cases) draft.problems.collect([&] { read_load_cases(*cases, draft, request.cases); });
  for (const auto* slot : {&across, &adapt})
    if (*slot && !cases)
      draft.problems.collect([&] { (*slot)->fail({.expected = "'for', the load cases, beside it", .found = "none"}); });
  if (across) draft.problems.collect([&] { request.cases.aggregation = read_case_aggregation(*across); });
  if (adapt) draft.problems.collect([&] { draft.adapted = read_adapted(*adapt, draft); });
}

}  // namespace balance::specification
