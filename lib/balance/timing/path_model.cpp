#include "balance/timing/path_model.hpp"

#include "balance/base/extrema.hpp"
#include "balance/timing/path_source.hpp"

#include <algorithm>
#include <cmath>

namespace balance {
namespace {

using Kind = LimitableQuantity::Kind;

/// Coefficients of s'' below this part of those of s'² are round-off.
constexpr double zero_inertia_epsilon = 1e-9;

/// Round-off of a quantity's coefficients, as a part of the forces that go into it.
constexpr double coefficient_round_off_epsilon = 1e-12;

/// Places nearer to each other than this are one.
constexpr double path_breakpoint_tolerance = 1e-9;

MotionOutcome make_unresolved_path_outcome() {
  return {MotionStatus::limits_not_held,
          0,
          "the efforts along the path change too abruptly for a law to be found: it may come too near to a singularity",
          {}};
}

void merge_breakpoints(std::vector<double>& stations, const std::vector<double>& more) {
  for (const double place : more) {
    const bool known = std::any_of(stations.begin(), stations.end(), [&](double station) {
      return std::abs(station - place) < path_breakpoint_tolerance;
    });
    if (!known) stations.push_back(place);
  }
  std::sort(stations.begin(), stations.end());
}

/// Where friction jumps, because a coordinate turns back.
FitStatus add_friction_jumps(PathDynamicsSampler& source, std::vector<double>& stations) {
  if (source.friction_count() == 0) return FitStatus::done;
  PiecewiseChebyshevSeries rates;
  const auto sample = [&](const std::vector<double>& places, Samples& rows) {
    return source.sample_friction(places, rows);
  };
  const FitStatus status =
      fit_chebyshev_series(stations, VectorX::Constant(source.friction_count(), 1e-12), sample, rates);
  if (status != FitStatus::done) return status;
  const std::vector<double> ends = stations;
  for (Eigen::Index r = 0; r < rates.function_count(); ++r) merge_breakpoints(stations, find_roots(rates, r));
  return FitStatus::done;
}

/// Per column: what is smaller is round-off, and what comes of it is not resolved.
VectorX estimate_round_off_floor(PathDynamicsSampler& source, const std::vector<double>& stations) {
  std::vector<double> places;
  for (std::size_t i = 0; i + 1 < stations.size(); ++i)
    for (int k = 0; k < 4; ++k) places.push_back(stations[i] + (stations[i + 1] - stations[i]) * (k + 0.5) / 4);
  VectorX floor = VectorX::Zero(source.columns());
  Samples rows;
  if (!source.sample(places, rows)) return floor;
  const PathDynamicsSampler::ReactionMagnitude sizes = source.max_reactions(places);
  for (const CoefficientColumns& limit : source.limits()) {
    const std::string& unit = limit.quantity.unit;
    const auto most = [&](int column) {
      return column < 0 ? 0.0 : max_abs(rows.middleCols(column, limit.quantity.count));
    };
    const double whole =
        std::max({most(limit.a), most(limit.b), unit == "N" ? sizes.force : 0.0, unit == "N m" ? sizes.moment : 0.0});
    for (const int column : {limit.a, limit.b, limit.c, limit.d})
      if (column >= 0)
        floor.segment(column, limit.quantity.count)
            .setConstant(coefficient_round_off_epsilon * whole + 10 * coefficient_round_off_epsilon * most(column));
  }
  return floor;
}

/// The series of `all` with those of p' and p'' of the tool's place appended where rows need them.
Samples append_tool_derivatives(const Panel& panel, const Panel& first, const Panel& second,
                                const std::vector<PathConstraintRow>& rows,
                                const std::vector<CoefficientColumns>& limits, Eigen::Index columns) {
  Samples terms = Samples::Zero(PiecewiseChebyshevSeries::coefficient_count, columns);
  terms.leftCols(panel.coefficients.cols()) = panel.coefficients;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Kind kind = limits[i].quantity.kind;
    const int from = limits[i].c, count = rows[i].count;
    if (kind == Kind::tool_velocity) terms.middleCols(rows[i].d, count) = first.coefficients.middleCols(from, count);
    if (kind != Kind::tool_acceleration) continue;
    terms.middleCols(rows[i].a, count) = first.coefficients.middleCols(from, count);
    terms.middleCols(rows[i].b, count) = second.coefficients.middleCols(from, count);
  }
  return terms;
}

/// Names the columns, those of the tool's rates behind all others.
void add_rows(const std::vector<CoefficientColumns>& limits, PathModel& model, Eigen::Index& columns) {
  for (const CoefficientColumns& limit : limits) {
    PathConstraintRow row{
        limit.quantity.name, limit.quantity.unit, limit.quantity.count, limit.a, limit.b, limit.c, limit.d};
    const auto take = [&](int& column) {
      column = static_cast<int>(columns);
      columns += row.count;
    };
    const Kind kind = limit.quantity.kind;
    if (kind == Kind::tool_velocity || kind == Kind::tool_acceleration) row.c = -1;
    if (kind == Kind::tool_velocity) take(row.d);
    if (kind == Kind::tool_acceleration) take(row.a), take(row.b);
    model.rows.push_back(std::move(row));
  }
}

void find_max_magnitudes(PathModel& model) {
  model.max_magnitude.setZero(model.value.function_count());
  VectorX values(model.value.function_count());
  for (std::size_t p = 0; p < model.value.panels().size(); ++p) {
    const Panel& panel = model.value.panels()[p];
    for (int k = 0; k <= 16; ++k) {
      model.value.evaluate(p, panel.begin + (panel.end - panel.begin) * k / 16, values.data());
      model.max_magnitude = model.max_magnitude.cwiseMax(values.cwiseAbs());
    }
  }
}

/// What is round-off all along is zero.
void drop_round_off_columns(const VectorX& floor, PathModel& model) {
  for (PathConstraintRow& row : model.rows)
    for (int* column : {&row.a, &row.b, &row.c, &row.d})
      if (*column >= 0 && *column < floor.size() &&
          max_abs(model.max_magnitude.segment(*column, row.count)) <= 10 * max_abs(floor.segment(*column, row.count)))
        *column = -1;
}

double largest(const PathModel& model, int column, int count) {
  return column < 0 ? 0 : max_abs(model.max_magnitude.segment(column, count));
}

/// Rows without inertia limit the speed alone; where the others have none, u is not theirs to limit.
void find_zero_inertia(PathModel& model) {
  for (PathConstraintRow& row : model.rows) {
    const double a = largest(model, row.a, row.count), b = largest(model, row.b, row.count);
    row.has_acceleration_term = a > zero_inertia_epsilon * b && a > 0;
    if (!row.has_acceleration_term) continue;
    for (int i = 0; i < row.count; ++i) {
      for (const double place : find_roots(model.value, row.a + i)) {
        VectorX values(model.value.function_count());
        model.value.evaluate(model.value.find_panel(place, 0, model.value.panels().size()), place, values.data());
        if (values.segment(row.a, row.count).norm() < 1e-7 * a) {
          merge_breakpoints(model.zero_inertia_points, {place});
          merge_breakpoints(model.breakpoints, {place});
        }
      }
    }
  }
}

void assemble_path_model(const PathDynamicsSampler& source, const PiecewiseChebyshevSeries& sampled,
                         const VectorX& floor, PathModel& model) {
  Eigen::Index columns = sampled.function_count();
  add_rows(source.limits(), model, columns);
  const PiecewiseChebyshevSeries first = sampled.derivative(), second = first.derivative();
  std::vector<Panel> panels = sampled.panels();
  for (std::size_t p = 0; p < panels.size(); ++p)
    panels[p].coefficients = append_tool_derivatives(sampled.panels()[p], first.panels()[p], second.panels()[p],
                                                     model.rows, source.limits(), columns);
  model.value = PiecewiseChebyshevSeries(std::move(panels));
  model.first = model.value.derivative();
  model.second = model.first.derivative();
  find_max_magnitudes(model);
  drop_round_off_columns(floor, model);
  find_zero_inertia(model);
}

}  // namespace

PathModel build_path_model(const Mechanism& mechanism, const Trajectory& trajectory,
                           const std::vector<LimitableQuantity>& quantities) {
  PathModel model;
  const auto source = make_path_dynamics_sampler(mechanism, trajectory, quantities);
  model.outcome = source->outcome();
  if (model.outcome.status != MotionStatus::done) return model;
  model.segment_ends = source->leg_ends();
  model.breakpoints = model.segment_ends;
  merge_breakpoints(model.breakpoints, source->knots());
  model.start_speed = source->start_speed();
  model.end_speed = source->end_speed();
  FitStatus status = add_friction_jumps(*source, model.breakpoints);
  PiecewiseChebyshevSeries sampled;
  VectorX floor;
  if (status == FitStatus::done) {
    const auto sample = [&](const std::vector<double>& places, Samples& rows) { return source->sample(places, rows); };
    floor = estimate_round_off_floor(*source, model.breakpoints);
    status = fit_chebyshev_series(model.breakpoints, floor, sample, sampled);
  }
  if (status == FitStatus::not_sampled) model.outcome = source->outcome();
  if (status == FitStatus::not_resolved) model.outcome = make_unresolved_path_outcome();
  if (status == FitStatus::done) assemble_path_model(*source, sampled, floor, model);
  return model;
}

/// Sign changes between the points of a fine grid, halved to the last digit.
std::vector<double> find_roots(const PiecewiseChebyshevSeries& series, Eigen::Index function) {
  constexpr int intervals_per_panel = 32;
  std::vector<double> places;
  VectorX values(series.function_count());
  for (std::size_t p = 0; p < series.panels().size(); ++p) {
    const Panel& panel = series.panels()[p];
    const auto at = [&](double place) {
      series.evaluate(p, place, values.data());
      return values[function];
    };
    double left = panel.begin, at_left = at(left);
    for (int k = 1; k <= intervals_per_panel; ++k) {
      const double right =
          k == intervals_per_panel ? panel.end : panel.begin + (panel.end - panel.begin) * k / intervals_per_panel;
      const double at_right = at(right);
      if (at_left == 0 || (at_left < 0) != (at_right < 0)) {
        double low = left, high = right;
        for (int halving = 0; halving < 60 && low < high; ++halving) {
          const double middle = (low + high) / 2;
          ((at(middle) < 0) == (at_left < 0) ? low : high) = middle;
        }
        places.push_back((low + high) / 2);
      }
      left = right;
      at_left = at_right;
    }
  }
  return places;
}

}  // namespace balance
