// What the free numbers are to achieve.

#include "balance/base/nearest.hpp"
#include "balance/spec/goals.hpp"
#include "balance/spec/limits.hpp"
#include "balance/spec/objective.hpp"
#include "balance/spec/sections.hpp"

#include <fmt/format.h>

namespace balance::read {

namespace {

std::string read_method(const Cursor& at, const std::string& what, const std::vector<std::string>& names) {
  return names[at.choice(what, names)];
}

void read_search(const Cursor& at, Draft& draft, SearchOptions& search) {
  read_fields(at, "how to search {global, local, seed, restarts, evaluations, seconds}",
              {{"global", Need::optional,
                [&](const Cursor& c) { search.global = read_method(c, "a global method", global_methods()); }},
               {"local", Need::optional,
                [&](const Cursor& c) { search.local = read_method(c, "a local method", local_methods()); }},
               {"seed", Need::optional,
                [&](const Cursor& c) { search.seed = static_cast<std::uint64_t>(read_whole(c, draft, 0, most_seed)); }},
               {"restarts", Need::optional,
                [&](const Cursor& c) { search.restarts = static_cast<int>(read_whole(c, draft, 1, 10'000)); }},
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
  read_fields(section, "what to design for {goal, minimize, search}",
              {{"goal", Need::optional, [&](const Cursor& c) { request.goals = read_goals(c); }},
               {"minimize", Need::optional,
                [&](const Cursor& c) { request.minimize = read_terms(c, draft.parameters, draft.study); }},
               {"search", Need::optional, [&](const Cursor& c) { read_search(c, draft, request.search); }}});
}

}  // namespace balance::read
