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

namespace balance::read {

namespace {

std::string read_method(const Cursor& at, const std::string& what, const std::vector<std::string>& names) {
  return names[at.choice(what, names)];
}

void read_search(const Cursor& at, Draft& draft, SearchOptions& search) {
  read_fields(
      at, "how to search {global, local, seed, restarts, evaluations, seconds}",
      {{"global", Need::optional,
        [&](const Cursor& c) { search.global = read_method(c, "a global method", global_methods()); }},
       {"local", Need::optional,
        [&](const Cursor& c) { search.local = read_method(c, "a local method", local_methods()); }},
       {"seed", Need::optional,
        [&](const Cursor& c) { search.seed = static_cast<std::uint64_t>(read_whole(c, draft, 0, max_seed)); }},
       {"restarts", Need::optional,
        [&](const Cursor& c) { search.restarts = static_cast<int>(read_whole(c, draft, 1, 10'000)); }, "starts"},
       {"evaluations", Need::optional,
        [&](const Cursor& c) { search.evaluations = static_cast<int>(read_whole(c, draft, 1, 100'000'000)); }},
       {"seconds", Need::optional, [&](const Cursor& c) {
          if (!c.is_scalar()) c.expected("a number of seconds");
          search.seconds = draft.parameters.evaluate(c).value();
          if (!(search.seconds > 0))
            c.fail({.kind = "must be positive",
                    .expected = "a number of seconds > 0",
                    .found = fmt::format("{}", search.seconds)});
        }}});
}

}  // namespace

void read_design(const Cursor& section, Draft& draft) {
  DesignRequest& request = draft.study.design;
  std::optional<Cursor> front, cases, across, adapt;
  const auto keep = [](std::optional<Cursor>& slot) { return [&slot](const Cursor& c) { slot = c; }; };
  read_fields(section, "what to design for {goal, minimize, front, subject_to, choose, search, for, across, adapt}",
              {{"goal", Need::optional, [&](const Cursor& c) { request.goals = read_goals(c); }},
               {"minimize", Need::optional,
                [&](const Cursor& c) { request.minimize = read_terms(c, draft.parameters, draft.study); }},
               {"front", Need::optional, keep(front)},
               {"subject_to", Need::optional, [&](const Cursor& c) { request.subject_to = read_limits(c, draft); }},
               {"choose", Need::optional, [&](const Cursor& c) { request.choose = read_choices(c, draft); }},
               {"search", Need::optional, [&](const Cursor& c) { read_search(c, draft, request.search); }},
               {"for", Need::optional, keep(cases)},
               {"across", Need::optional, keep(across)},
               {"adapt", Need::optional, keep(adapt)}});
  if (front) draft.problems.guard([&] { request.front = read_front(*front, draft); });
  if (front && !request.minimize.empty())
    draft.problems.guard([&] { front->fail({.expected = "no 'minimize' beside a front", .found = "both"}); });
  if (cases) draft.problems.guard([&] { read_load_cases(*cases, draft, request.cases); });
  for (const auto* slot : {&across, &adapt})
    if (*slot && !cases)
      draft.problems.guard([&] { (*slot)->fail({.expected = "'for', the load cases, beside it", .found = "none"}); });
  if (across) draft.problems.guard([&] { request.cases.across = read_across(*across); });
  if (adapt) draft.problems.guard([&] { draft.adapted = read_adapted(*adapt, draft); });
}

}  // namespace balance::read
