#include "balance/timing/path_model.hpp"

#include "balance/base/extrema.hpp"
#include "balance/timing/path_source.hpp"

#include <algorithm>
#include <cmath>

namespace balance {
namespace {

using Kind = LimitedQuantity::Kind;

/// Coefficients of s'' below this part of those of s'² are round-off.
constexpr double no_inertia = 1e-9;

/// Round-off of a quantity's coefficients, as a part of the forces that go into it.
constexpr double noise = 1e-12;

/// Places nearer to each other than this are one.
constexpr double same_place = 1e-9;

MotionOutcome too_rough() {
  return {MotionStatus::limits_not_held,
          0,
          "the efforts along the path change too abruptly for a law to be found: it may come too near to a singularity",
          {}};
}

void merge(std::vector<double>& stations, const std::vector<double>& more) {
  for (const double place : more) {
    const bool known = std::any_of(stations.begin(), stations.end(),
                                   [&](double station) { return std::abs(station - place) < same_place; });
    if (!known) stations.push_back(place);
  }
  std::sort(stations.begin(), stations.end());
}

/// Where friction jumps, because a coordinate turns back.
FitStatus add_friction_jumps(PathSource& source, std::vector<double>& stations) {
  if (source.frictions() == 0) return FitStatus::done;
  PiecewiseSeries rates;
  const auto sample = [&](const std::vector<double>& places, Samples& rows) {
    return source.sample_friction(places, rows);
  };
  const FitStatus status = fit_series(stations, VectorX::Constant(source.frictions(), 1e-12), sample, rates);
  if (status != FitStatus::done) return status;
  const std::vector<double> ends = stations;
  for (Eigen::Index r = 0; r < rates.functions(); ++r) merge(stations, zeros(rates, r));
  return FitStatus::done;
}

/// Per column: what is smaller is round-off, and what comes of it is not resolved.
VectorX noise_floor(PathSource& source, const std::vector<double>& stations) {
  std::vector<double> places;
  for (std::size_t i = 0; i + 1 < stations.size(); ++i)
    for (int k = 0; k < 4; ++k) places.push_back(stations[i] + (stations[i + 1] - stations[i]) * (k + 0.5) / 4);
  VectorX floor = VectorX::Zero(source.columns());
  Samples rows;
  if (!source.sample(places, rows)) return floor;
  const PathSource::Sizes sizes = source.measure(places);
  for (const LimitColumns& limit : source.limits()) {
    const std::string& unit = limit.quantity.unit;
    const auto most = [&](int column) {
      return column < 0 ? 0.0 : max_abs(rows.middleCols(column, limit.quantity.count));
    };
    const double whole =
        std::max({most(limit.a), most(limit.b), unit == "N" ? sizes.force : 0.0, unit == "N m" ? sizes.moment : 0.0});
    for (const int column : {limit.a, limit.b, limit.c, limit.d})
      if (column >= 0)
        floor.segment(column, limit.quantity.count).setConstant(noise * whole + 10 * noise * most(column));
  }
  return floor;
}

/// The series of `all` with those of p' and p'' of the tool's place appended where rows need them.
Samples with_derivatives(const Panel& panel, const Panel& first, const Panel& second, const std::vector<LimitRow>& rows,
                         const std::vector<LimitColumns>& limits, Eigen::Index columns) {
  Samples terms = Samples::Zero(PiecewiseSeries::terms, columns);
  terms.leftCols(panel.terms.cols()) = panel.terms;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Kind kind = limits[i].quantity.kind;
    const int from = limits[i].c, count = rows[i].count;
    if (kind == Kind::tool_velocity) terms.middleCols(rows[i].d, count) = first.terms.middleCols(from, count);
    if (kind != Kind::tool_acceleration) continue;
    terms.middleCols(rows[i].a, count) = first.terms.middleCols(from, count);
    terms.middleCols(rows[i].b, count) = second.terms.middleCols(from, count);
  }
  return terms;
}

/// Names the columns, those of the tool's rates behind all others.
void add_rows(const std::vector<LimitColumns>& limits, PathModel& model, Eigen::Index& columns) {
  for (const LimitColumns& limit : limits) {
    LimitRow row{limit.quantity.name, limit.quantity.unit, limit.quantity.count, limit.a, limit.b, limit.c, limit.d};
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

void measure(PathModel& model) {
  model.largest.setZero(model.value.functions());
  VectorX values(model.value.functions());
  for (std::size_t p = 0; p < model.value.panels().size(); ++p) {
    const Panel& panel = model.value.panels()[p];
    for (int k = 0; k <= 16; ++k) {
      model.value.at(p, panel.begin + (panel.end - panel.begin) * k / 16, values.data());
      model.largest = model.largest.cwiseMax(values.cwiseAbs());
    }
  }
}

/// What is round-off all along is zero.
void drop_noise(const VectorX& floor, PathModel& model) {
  for (LimitRow& row : model.rows)
    for (int* column : {&row.a, &row.b, &row.c, &row.d})
      if (*column >= 0 && *column < floor.size() &&
          max_abs(model.largest.segment(*column, row.count)) <= 10 * max_abs(floor.segment(*column, row.count)))
        *column = -1;
}

double largest(const PathModel& model, int column, int count) {
  return column < 0 ? 0 : max_abs(model.largest.segment(column, count));
}

/// Rows without inertia limit the speed alone; where the others have none, u is not theirs to limit.
void find_zero_inertia(PathModel& model) {
  for (LimitRow& row : model.rows) {
    const double a = largest(model, row.a, row.count), b = largest(model, row.b, row.count);
    row.limits_acceleration = a > no_inertia * b && a > 0;
    if (!row.limits_acceleration) continue;
    for (int i = 0; i < row.count; ++i) {
      for (const double place : zeros(model.value, row.a + i)) {
        VectorX values(model.value.functions());
        model.value.at(model.value.panel_at(place, 0, model.value.panels().size()), place, values.data());
        if (values.segment(row.a, row.count).norm() < 1e-7 * a) {
          merge(model.vanishing, {place});
          merge(model.stations, {place});
        }
      }
    }
  }
}

void assemble(const PathSource& source, const PiecewiseSeries& sampled, const VectorX& floor, PathModel& model) {
  Eigen::Index columns = sampled.functions();
  add_rows(source.limits(), model, columns);
  const PiecewiseSeries first = sampled.derivative(), second = first.derivative();
  std::vector<Panel> panels = sampled.panels();
  for (std::size_t p = 0; p < panels.size(); ++p)
    panels[p].terms = with_derivatives(sampled.panels()[p], first.panels()[p], second.panels()[p], model.rows,
                                       source.limits(), columns);
  model.value = PiecewiseSeries(std::move(panels));
  model.first = model.value.derivative();
  model.second = model.first.derivative();
  measure(model);
  drop_noise(floor, model);
  find_zero_inertia(model);
}

}  // namespace

PathModel model_path(const Mechanism& mechanism, const Trajectory& trajectory,
                     const std::vector<LimitedQuantity>& quantities) {
  PathModel model;
  const auto source = make_path_source(mechanism, trajectory, quantities);
  model.outcome = source->outcome();
  if (model.outcome.status != MotionStatus::done) return model;
  model.leg_ends = source->leg_ends();
  model.stations = model.leg_ends;
  merge(model.stations, source->knots());
  model.start_speed = source->start_speed();
  model.end_speed = source->end_speed();
  FitStatus status = add_friction_jumps(*source, model.stations);
  PiecewiseSeries sampled;
  VectorX floor;
  if (status == FitStatus::done) {
    const auto sample = [&](const std::vector<double>& places, Samples& rows) { return source->sample(places, rows); };
    floor = noise_floor(*source, model.stations);
    status = fit_series(model.stations, floor, sample, sampled);
  }
  if (status == FitStatus::not_sampled) model.outcome = source->outcome();
  if (status == FitStatus::too_rough) model.outcome = too_rough();
  if (status == FitStatus::done) assemble(*source, sampled, floor, model);
  return model;
}

/// Sign changes between the points of a fine grid, halved to the last digit.
std::vector<double> zeros(const PiecewiseSeries& series, Eigen::Index function) {
  constexpr int pieces = 32;
  std::vector<double> places;
  VectorX values(series.functions());
  for (std::size_t p = 0; p < series.panels().size(); ++p) {
    const Panel& panel = series.panels()[p];
    const auto at = [&](double place) {
      series.at(p, place, values.data());
      return values[function];
    };
    double left = panel.begin, at_left = at(left);
    for (int k = 1; k <= pieces; ++k) {
      const double right = k == pieces ? panel.end : panel.begin + (panel.end - panel.begin) * k / pieces;
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
