#include "balance/spec/free_value.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace balance::read {

namespace {

using Number = std::function<double(const Cursor&)>;

constexpr const char* usual_form = "a number, an expression or {free: [lower, upper]}";
constexpr std::size_t most_sizes = 10'000;
/// Part of a step, or of what lies between the bounds, that round-off of expressions may make.
constexpr double round_off = 1e-9;

double nearest_of(const std::vector<double>& sizes, double value) {
  return *std::min_element(sizes.begin(), sizes.end(),
                           [value](double a, double b) { return std::abs(a - value) < std::abs(b - value); });
}

void read_bounds(const Cursor& at, const Number& number, FreeValue& free) {
  double* bound = &free.lower;
  read_each(at.items("[lower, upper]", 2),
            [&](const Cursor& item) { *std::exchange(bound, &free.upper) = number(item); });
  if (!(free.lower < free.upper))
    at.fail({.expected = "lower < upper", .found = fmt::format("[{}, {}]", free.lower, free.upper)});
}

void read_listed_sizes(const Cursor& at, const Number& number, FreeValue& free) {
  read_each(at.items("sizes [a, b, …]"), [&](const Cursor& item) {
    const double size = number(item);
    if (std::find(free.sizes.begin(), free.sizes.end(), size) != free.sizes.end())
      item.fail({.expected = "every size once", .found = item.found() + " again"});
    if (free.sizes.size() == most_sizes) at.fail({.expected = fmt::format("at most {} sizes", most_sizes)});
    free.sizes.push_back(size);
  });
  if (free.sizes.size() < 2) at.fail({.expected = "at least two sizes", .found = fmt::format("{}", free.sizes.size())});
  std::sort(free.sizes.begin(), free.sizes.end());
}

/// Multiples of steps such as 0.1 are those that people would write.
double multiple(double lower, double step, double count) {
  const double whole = std::round(1 / step), first = lower * whole;
  if (std::abs(whole * step - 1) > 1e-12 || std::abs(first - std::round(first)) > round_off)
    return lower + count * step;
  return (std::round(first) + count) / whole;
}

void read_step(const Cursor& at, const Number& number, FreeValue& free) {
  const double step = number(at);
  if (!(step > 0)) at.fail({.kind = "must be positive", .expected = "a number > 0", .found = fmt::format("{}", step)});
  const double count = std::floor((free.upper - free.lower) / step + round_off);
  if (!(count >= 1))
    at.fail({.expected = fmt::format("a step of at most {}, what lies between the bounds", free.upper - free.lower),
             .found = fmt::format("{}", step)});
  if (!(count < static_cast<double>(most_sizes)))
    at.fail(
        {.expected = fmt::format("a step that makes at most {} sizes", most_sizes), .found = fmt::format("{}", step)});
  for (int k = 0; k <= static_cast<int>(count); ++k) free.sizes.push_back(multiple(free.lower, step, k));
}

void check_start(const Cursor& map, FreeValue& free) {
  if (!(free.start >= free.lower && free.start <= free.upper))
    map.fail({.expected = fmt::format("a start between {} and {}", free.lower, free.upper),
              .found = fmt::format("{}", free.start)});
  if (free.sizes.empty()) return;
  const double nearest = nearest_of(free.sizes, free.start);
  if (std::abs(nearest - free.start) > round_off * (free.upper - free.lower))
    map.fail({.expected = "a start that is one of the sizes",
              .found = fmt::format("{}", free.start),
              .hint = fmt::format("nearest is {}", nearest)});
  free.start = nearest;
}

}  // namespace

void FreeValue::start_at_none() {
  if (start_from != FreeNumber::StartFrom::middle || lower > 0 || upper < 0) return;
  start_near(0);
  start_from = FreeNumber::StartFrom::none;
}

void FreeValue::start_near(double value) { start = sizes.empty() ? value : nearest_of(sizes, value); }

FreeValue read_free_value(const Cursor& map, const Number& number, const std::vector<Field>& others) {
  FreeValue free;
  std::optional<double> start;
  std::optional<Cursor> step;
  const auto read_free = [&](const Cursor& c) {
    if (!c.is_map()) return read_bounds(c, number, free);
    if (!read_fields(c, "[lower, upper] or {values: [a, b, …]}",
                     {{"values", Need::required, [&](const Cursor& v) { read_listed_sizes(v, number, free); }}}))
      throw Consequence();
  };
  std::vector<Field> fields{{"free", Need::required, read_free},
                            {"start", Need::optional, [&](const Cursor& c) { start = number(c); }},
                            {"step", Need::optional, [&](const Cursor& c) { step = c; }}};
  fields.insert(fields.end(), others.begin(), others.end());
  if (!read_fields(map, usual_form, fields)) throw Consequence();
  if (step && !free.sizes.empty())
    step->fail({.expected = "no step beside values, which are the sizes themselves", .found = step->found()});
  if (step) read_step(*step, number, free);
  if (!free.sizes.empty()) {
    free.lower = free.sizes.front();
    free.upper = free.sizes.back();
  }
  if (start) free.start_from = FreeNumber::StartFrom::spec;
  free.start_near(free.lower + (free.upper - free.lower) / 2);
  if (start) free.start = *start;
  check_start(map, free);
  return free;
}

}  // namespace balance::read
