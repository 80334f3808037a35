#include "balance/spec/front.hpp"

#include "balance/spec/objective.hpp"

#include <fmt/format.h>

namespace balance::read {

namespace {

constexpr long fewest_points = 3, most_points = 200;

/// Figures that nothing can be traded for have no front.
void require_weight(const Cursor& at, const std::vector<ObjectiveTerm>& terms) {
  for (const ObjectiveTerm& term : terms)
    if (term.weight > 0) return;
  at.fail({.expected = "a figure with a weight > 0", .found = "none"});
}

void read_figures(const Cursor& at, Draft& draft, FrontRequest& request) {
  const std::string what = "two or three figures, such as [added-mass, {rms: shaking_moment}]";
  const std::vector<Cursor> items = at.items(what);
  if (items.size() < 2 || items.size() > 3)
    at.fail({.expected = what, .found = items.size() == 1 ? "one" : fmt::format("{}", items.size())});
  read_each(items, [&](const Cursor& item) {
    request.figures.push_back(read_terms(item, draft.parameters, draft.study));
    require_weight(item, request.figures.back());
  });
}

}  // namespace

FrontRequest read_front(const Cursor& at, Draft& draft) {
  FrontRequest request;
  if (!at.is_map()) {
    read_figures(at, draft, request);
    return request;
  }
  read_fields(at, "a trade-off {of, points}",
              {{"of", Need::required, [&](const Cursor& c) { read_figures(c, draft, request); }},
               {"points", Need::optional, [&](const Cursor& c) {
                  request.points = static_cast<int>(read_whole(c, draft, fewest_points, most_points));
                }}});
  return request;
}

}  // namespace balance::read
