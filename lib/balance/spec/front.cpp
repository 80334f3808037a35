#include "balance/spec/front.hpp"

#include "balance/spec/objective.hpp"

#include <fmt/format.h>

namespace balance::specification {

namespace {

constexpr long min_pareto_points = 3, max_pareto_points = 200;

/// Figures that nothing can be traded for have no front.
void require_weight(const SpecCursor& at, const std::vector<ObjectiveTerm>& terms) {
  for (const ObjectiveTerm& term : terms)
    if (term.weight > 0) return;
  at.fail({.expected = "a figure with a weight > 0", .found = "none"});
}

void read_figures(const SpecCursor& at, StudyBuilder& draft, ParetoRequest& request) {
  const std::string what = "two or three figures, such as [added-mass, {rms: shaking_moment}]";
  const std::vector<SpecCursor> items = at.items(what);
  if (items.size() < 2 || items.size() > 3)
    at.fail({.expected = what, .found = items.size() == 1 ? "one" : fmt::format("{}", items.size())});
  read_each(items, [&](const SpecCursor& item) {
    request.figures.push_back(read_objective_terms(item, draft.parameters, draft.study));
    require_weight(item, request.figures.back());
  });
}

}  // namespace

ParetoRequest read_pareto_request(const SpecCursor& at, StudyBuilder& draft) {
  ParetoRequest request;
  if (!at.is_map()) {
    read_figures(at, draft, request);
    return request;
  }
  read_fields(at, "a trade-off {of, points}",
              {{"of", Presence::required, [&](const SpecCursor& c) { read_figures(c, draft, request); }},
               {"points", Presence::optional, [&](const SpecCursor& c) {
                  request.max_points = static_cast<int>(read_integer(c, draft, min_pareto_points, max_pareto_points));
                }}});
  return request;
}

}  // namespace balance::specification
