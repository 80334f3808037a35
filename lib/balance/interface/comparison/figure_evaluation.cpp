#include "balance/interface/comparison/figure_evaluation.hpp"

#include "balance/foundation/base/error.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/specification/read_spec.hpp"
#include "balance/mechanics/model/payload_intervals.hpp"
#include "balance/mechanics/results/metrics.hpp"
#include "balance/mechanics/results/orders.hpp"
#include "balance/mechanics/results/round_off.hpp"
#include "balance/synthesis/design/status_names.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace balance::comparison {
namespace {

// Readers of figures.

EvaluatedFigure make_value(double value, const std::string& unit = "") {
  EvaluatedFigure figure;
  figure.value = value;
  figure.unit = unit;
  return figure;
}

EvaluatedFigure make_mistake(const std::string& message, const std::string& name = "") {
  EvaluatedFigure figure;
  figure.mistake = message;
  figure.mistaken_name = name;
  return figure;
}

EvaluatedFigure make_reason(const std::string& reason) {
  EvaluatedFigure figure;
  figure.reason = reason;
  return figure;
}

/// A finite number, or the reason why there is none.
EvaluatedFigure value_or(double value, const std::string& unit, const std::string& reason) {
  return std::isfinite(value) ? make_value(value, unit) : make_reason(reason);
}

std::string describe_outside(double time, double begin, double end) {
  return fmt::format("{:.6g} s is outside of the run, which lasts from {:.6g} to {:.6g} s", time, begin, end);
}

EvaluatedFigure read_statistic(FigureEvaluator& evaluator, const FigureReference& reference) {
  EvaluatedFigure figure;
  const FigureEvaluator::NamedCurve* found = evaluator.find_curve(reference.quantity, figure);
  if (found == nullptr) return figure;
  const std::vector<double>& values = found->curve->sampled_values();
  const Metric metric = results::summarise_values(values, found->curve->sample_times(), found->round_off);
  const Statistic statistic = *reference.function->statistic;
  const bool is_average = statistic == Statistic::rms || statistic == Statistic::mean;
  return make_value(is_average && values.size() == 1 ? metric.peak : statistic_of(metric, statistic), found->unit);
}

template <bool is_maximum>
EvaluatedFigure read_extreme(FigureEvaluator& evaluator, const FigureReference& reference) {
  EvaluatedFigure figure;
  const FigureEvaluator::NamedCurve* found = evaluator.find_curve(reference.quantity, figure);
  if (found == nullptr) return figure;
  const auto [low, high] =
      std::minmax_element(found->curve->sampled_values().begin(), found->curve->sampled_values().end());
  return make_value(results::suppress_round_off(found->round_off, is_maximum ? *high : *low), found->unit);
}

EvaluatedFigure read_value(FigureEvaluator& evaluator, const FigureReference& reference) {
  EvaluatedFigure figure;
  const FigureEvaluator::NamedCurve* found = evaluator.find_curve(reference.quantity, figure);
  if (found == nullptr) return figure;
  const SampledCurve& curve = *found->curve;
  double time = curve.begin_time();
  if (reference.moment.kind == FigureMoment::Kind::none) {
    if (!evaluator.is_single_state() && evaluator.subject().run != nullptr)
      return make_mistake(
          fmt::format("value({0}) of a run needs a moment: value({0}, 0.3), value({0}, end), value({0}, "
                      "joint_position[A] = pi/3) or value({0}, peak({0}))",
                      reference.quantity),
          reference.quantity);
  } else {
    const std::optional<double> moment = evaluator.find_time(reference.moment, figure);
    if (!moment) return figure;
    time = *moment;
  }
  const auto [value, gap] = curve.evaluate(time, reference.side);
  switch (gap) {
    case SampledCurve::Gap::outside: return make_reason(describe_outside(time, curve.begin_time(), curve.end_time()));
    case SampledCurve::Gap::jump:
      return make_reason(fmt::format("{} jumps at about {:.6g} s: add before or after", reference.quantity, time));
    case SampledCurve::Gap::none: break;
  }
  return make_value(results::suppress_round_off(found->round_off, value), found->unit);
}

EvaluatedFigure read_time(FigureEvaluator& evaluator, const FigureReference& reference) {
  EvaluatedFigure figure;
  if (const RunResult* run = evaluator.subject().run; run == nullptr || run->time.size() < 2)
    return make_mistake("time(…) needs a run with a motion");
  const std::optional<double> time = evaluator.find_time(reference.moment, figure);
  return time ? make_value(*time, "s") : figure;
}

template <results::OrderPart part>
EvaluatedFigure read_order(FigureEvaluator& evaluator, const FigureReference& reference) {
  EvaluatedFigure figure;
  const FigureEvaluator::NamedCurve* found = evaluator.find_curve(reference.quantity, figure);
  if (found == nullptr) return figure;
  const RunResult* run = evaluator.subject().run;
  const std::optional<results::MetricSeries> series =
      run == nullptr ? std::nullopt : results::find_series(*run, reference.quantity);
  if (!series)
    return make_mistake(
        fmt::format("{}(…) is of what runs record, not of {}", reference.function->name, reference.quantity),
        reference.quantity);
  if (part != results::OrderPart::whole && series->count != 2)
    return make_mistake(fmt::format("only a vector in the plane has a {}", name_of(part)), reference.quantity);
  try {
    return make_value(results::compute_order_peak(*run, *series, reference.order, part), found->unit);
  } catch (const std::invalid_argument& error) {
    return make_reason(error.what());
  }
}

EvaluatedFigure read_fluctuation(FigureEvaluator& evaluator, const FigureReference&) {
  const RunResult* run = evaluator.subject().run;
  if (run == nullptr || run->time.size() < 2) return make_mistake("fluctuation() needs a run with a motion");
  try {
    constexpr double attainable = 2;  // of every machine: those whose speed does not fluctuate on its own are refused
    const auto found = results::analyse_speed_fluctuation(*run, results::find_uniform_turning(*run), attainable);
    return value_or(found->coefficient, "1", "the machine comes to rest");
  } catch (const std::invalid_argument& error) {
    return make_reason(error.what());
  }
}

EvaluatedFigure read_energy(FigureEvaluator& evaluator, const FigureReference&) {
  const RunResult* run = evaluator.subject().run;
  if (run == nullptr || run->time.size() < 2) return make_mistake("energy() needs a run with a motion");
  return value_or(run->energy, "J", "there is no energy of the actuators");
}

EvaluatedFigure read_duration(FigureEvaluator& evaluator, const FigureReference&) {
  const RunResult* run = evaluator.subject().run;
  if (run == nullptr || run->time.size() < 2) return make_mistake("duration() needs a run with a motion");
  return make_value(run->time[run->time.size() - 1] - run->time[0], "s");
}

/// Applies a reader to the subject's design.
EvaluatedFigure read_design(const FigureEvaluator& evaluator, const FigureReference& reference,
                            const std::function<EvaluatedFigure(const DesignReport&)>& read) {
  const DesignReport* design = evaluator.subject().design;
  if (design != nullptr) return read(*design);
  return make_mistake(fmt::format("{}() needs a case with 'design: true' or 'run: design'", reference.function->name));
}

EvaluatedFigure read_added_mass(FigureEvaluator& evaluator, const FigureReference& reference) {
  return read_design(evaluator, reference, [](const DesignReport& design) {
    return value_or(design.added_mass, "kg", "the design was not solved");
  });
}

EvaluatedFigure read_added_inertia(FigureEvaluator& evaluator, const FigureReference& reference) {
  return read_design(evaluator, reference, [](const DesignReport& design) {
    return value_or(design.added_inertia, "kg m^2", "the design was not solved");
  });
}

EvaluatedFigure read_objective_value(FigureEvaluator& evaluator, const FigureReference& reference) {
  return read_design(evaluator, reference, [&](const DesignReport& design) {
    return value_or(design.outcome.objective, evaluator.subject().objective_unit, "the design minimizes nothing");
  });
}

EvaluatedFigure read_bound(FigureEvaluator& evaluator, const FigureReference& reference) {
  return read_design(evaluator, reference, [&](const DesignReport& design) {
    return value_or(design.outcome.lower_bound, evaluator.subject().objective_unit, "the design has no proved bound");
  });
}

EvaluatedFigure read_gap(FigureEvaluator& evaluator, const FigureReference& reference) {
  return read_design(evaluator, reference, [&](const DesignReport& design) {
    return value_or(design.outcome.gap(), evaluator.subject().objective_unit, "the design has no proved bound");
  });
}

EvaluatedFigure read_verdict(FigureEvaluator& evaluator, const FigureReference& reference) {
  return read_design(evaluator, reference, [](const DesignReport& design) {
    EvaluatedFigure figure;
    figure.word = name_of(design.outcome.status);
    if (const std::string optimality = name_of(design.outcome.optimality); optimality != figure.word)
      figure.word += " " + optimality;
    return figure;
  });
}

EvaluatedFigure read_number(FigureEvaluator& evaluator, const FigureReference& reference) {
  std::vector<std::string> paths;
  for (const FigureNumber& number : evaluator.subject().numbers) {
    if (number.path == reference.quantity) return make_value(number.value);
    paths.push_back(number.path);
  }
  if (paths.empty()) return make_mistake("number(…) needs a case with a design or with 'solve'", reference.quantity);
  return make_mistake(fmt::format("there is no number {}, only {}{}", quote_for_message(reference.quantity),
                                  join_with_conjunction(paths, "and"), append_nearest_name(reference.quantity, paths)),
                      reference.quantity);
}

EvaluatedFigure read_conditions(const FigureEvaluator& evaluator, const FigureReference& reference,
                                double (*read)(const ConditionsFigures&)) {
  if (evaluator.subject().conditions) return make_value(read(*evaluator.subject().conditions));
  return make_mistake(fmt::format("{}() needs a case with 'run: conditions'", reference.function->name));
}

EvaluatedFigure read_rank(FigureEvaluator& evaluator, const FigureReference& reference) {
  return read_conditions(evaluator, reference, [](const ConditionsFigures& c) { return static_cast<double>(c.rank); });
}

EvaluatedFigure read_condition_count(FigureEvaluator& evaluator, const FigureReference& reference) {
  return read_conditions(evaluator, reference, [](const ConditionsFigures& c) { return static_cast<double>(c.count); });
}

EvaluatedFigure read_impossible(FigureEvaluator& evaluator, const FigureReference& reference) {
  return read_conditions(evaluator, reference, [](const ConditionsFigures& c) { return c.is_impossible ? 1. : 0.; });
}

EvaluatedFigure read_holds(FigureEvaluator& evaluator, const FigureReference& reference) {
  return read_conditions(evaluator, reference, [](const ConditionsFigures& c) { return c.holds ? 1. : 0.; });
}

constexpr auto quantity_argument = FigureArguments::quantity;
constexpr auto no_argument = FigureArguments::none;

// clang-format off
const std::array<FigureFunction, 25> figure_table{{
    {"peak", quantity_argument, "", Statistic::peak, read_statistic},
    {"rms", quantity_argument, "", Statistic::rms, read_statistic},
    {"mean", quantity_argument, "", Statistic::mean, read_statistic},
    {"range", quantity_argument, "", Statistic::range, read_statistic},
    {"minimum", quantity_argument, "", {}, read_extreme<false>},
    {"maximum", quantity_argument, "", {}, read_extreme<true>},
    {"order", FigureArguments::order_and_quantity, "", {}, read_order<results::OrderPart::whole>},
    {"forward_order", FigureArguments::order_and_quantity, "", {}, read_order<results::OrderPart::forward>},
    {"backward_order", FigureArguments::order_and_quantity, "", {}, read_order<results::OrderPart::backward>},
    {"fluctuation", no_argument, "1", {}, read_fluctuation},
    {"energy", no_argument, "J", {}, read_energy},
    {"value", FigureArguments::quantity_and_moment, "", {}, read_value},
    {"time", FigureArguments::moment, "s", {}, read_time},
    {"duration", no_argument, "s", {}, read_duration},
    {"added_mass", no_argument, "kg", {}, read_added_mass},
    {"added_inertia", no_argument, "kg m^2", {}, read_added_inertia},
    {"objective", no_argument, "", {}, read_objective_value},
    {"bound", no_argument, "", {}, read_bound},
    {"gap", no_argument, "", {}, read_gap},
    {"number", FigureArguments::path, "", {}, read_number},
    {"verdict", no_argument, "", {}, read_verdict},
    {"rank", no_argument, "", {}, read_rank},
    {"conditions", no_argument, "", {}, read_condition_count},
    {"impossible", no_argument, "", {}, read_impossible},
    {"holds", no_argument, "", {}, read_holds},
}};
// clang-format on

}  // namespace

std::span<const FigureFunction> figure_functions() { return figure_table; }

FigureEvaluator::FigureEvaluator(FigureSubject subject)
    : subject_(std::move(subject)), quantities_(subject_.run, subject_.mechanism, subject_.points) {
  if (subject_.equations != nullptr) list_equation_quantities();
  if (subject_.modes != nullptr) list_mode_quantities();
  if (subject_.sweep != nullptr) list_sweep_quantities();
}

/// Of the modes in the order in which `balance modes` numbers them, and the place of the free coordinates.
void FigureEvaluator::list_mode_quantities() {
  const std::vector<vibration::VibrationMode>& modes = subject_.modes->modes;
  for (std::size_t k = 0; k < modes.size(); ++k) {
    const std::string number = fmt::format("[{}]", k + 1);
    quantities_.add_constant("growth" + number, "1/s", modes[k].eigenvalue.real());
    quantities_.add_constant("frequency" + number, "Hz", modes[k].frequency());
    quantities_.add_constant("damping_ratio" + number, "1", modes[k].damping_ratio());
  }
  const vibration::LinearMotion& motion = subject_.modes->motion;
  for (Eigen::Index k = 0; k < motion.free_count; ++k) {
    const Coordinate& coordinate =
        subject_.mechanism->coordinates[static_cast<std::size_t>(motion.coordinates[static_cast<std::size_t>(k)])];
    quantities_.add_constant("joint_position[" + coordinate.name + "]",
                             coordinate.kind == CoordinateKind::length ? "m" : "rad", motion.position[k]);
  }
}

/// Values of what was swept, in its own unit.
void FigureEvaluator::list_sweep_quantities() {
  for (std::size_t k = 0; k < subject_.sweep->stability_changes.size(); ++k)
    quantities_.add_constant(fmt::format("stability_change[{}]", k + 1), "",
                             subject_.sweep->stability_changes[k].value);
  for (std::size_t k = 0; k < subject_.sweep->critical_speeds.size(); ++k)
    quantities_.add_constant(fmt::format("critical_speed[{}]", k + 1), "", subject_.sweep->critical_speeds[k].value);
}

/// Terms of the equation of motion in the independent coordinates.
void FigureEvaluator::list_equation_quantities() {
  const formulas::EquationsAtConfiguration& at = *subject_.equations;
  for (std::size_t a = 0; at.split && a < at.actuators.size(); ++a)
    quantities_.add_constant((at.is_force[a] ? "force[" : "torque[") + at.actuators[a] + "]",
                             at.is_force[a] ? "N" : "N m", at.split->effort[static_cast<Eigen::Index>(a)]);
  if (!at.terms) return;
  const dynamics::IndependentTerms& terms = *at.terms;
  const auto velocity = [&](Eigen::Index k) { return at.dq.dot(terms.velocity[static_cast<std::size_t>(k)] * at.dq); };
  const VectorX viscous = terms.viscous * at.dq, inertia = terms.mass * at.ddq, rest = terms.static_terms.sum();
  for (std::size_t i = 0; i < at.independent.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    const std::string owner = "[" + at.independent[i] + "]", unit = at.is_length[i] ? "N" : "N m";
    quantities_.add_constant("gravity" + owner, unit, terms.static_terms.weight[k]);
    quantities_.add_constant("springs" + owner, unit, terms.static_terms.springs[k]);
    quantities_.add_constant("loads" + owner, unit, terms.static_terms.loads[k]);
    if (terms.static_terms.prescribed.size() > 0)
      quantities_.add_constant("prescribed" + owner, unit, terms.static_terms.prescribed[k]);
    quantities_.add_constant("velocity" + owner, unit, velocity(k));
    quantities_.add_constant("viscous" + owner, unit, viscous[k]);
    // what a motor at the coordinate itself would give
    quantities_.add_constant((at.is_length[i] ? "force" : "torque") + owner, unit,
                             inertia[k] + velocity(k) + viscous[k] + rest[k]);
    for (std::size_t j = 0; j < at.independent.size(); ++j) {
      const int lengths = (at.is_length[i] ? 1 : 0) + (at.is_length[j] ? 1 : 0);
      quantities_.add_constant("inertia[" + at.independent[i] + "," + at.independent[j] + "]",
                               lengths == 0   ? "kg m^2"
                               : lengths == 1 ? "kg m"
                                              : "kg",
                               terms.mass(k, static_cast<Eigen::Index>(j)));
    }
  }
}

const FigureEvaluator::NamedCurve* FigureEvaluator::find_curve(const std::string& name, EvaluatedFigure& figure) {
  if (const auto known = curves_.find(name); known != curves_.end()) return &known->second;
  const results::NamedQuantity found = quantities_.find(name);
  if (found.quantity == nullptr) {
    figure.mistaken_name = name;
    figure.mistake = found.mistake;
    return nullptr;
  }
  const auto curve = std::make_shared<const SampledCurve>(*found.quantity->times, found.samples());
  return &curves_.emplace(name, NamedCurve{found.quantity->unit, curve, found.round_off()}).first->second;
}

std::optional<double> FigureEvaluator::find_time(const FigureMoment& moment, EvaluatedFigure& figure) {
  using Kind = FigureMoment::Kind;
  const VectorX& times = quantities_.times();
  const double begin = times.size() > 0 ? times[0] : 0, end = times.size() > 0 ? times[times.size() - 1] : 0;
  switch (moment.kind) {
    case Kind::none:
    case Kind::start: return begin;
    case Kind::end: return end;
    case Kind::time: {
      const double tolerance = 1e-9 * (end - begin);
      if (moment.time >= begin - tolerance && moment.time <= end + tolerance) return moment.time;
      figure.reason = describe_outside(moment.time, begin, end);
      return std::nullopt;
    }
    default: break;
  }
  const NamedCurve* found = find_curve(moment.quantity, figure);
  if (found == nullptr) return std::nullopt;
  const SampledCurve& curve = *found->curve;
  if (moment.kind == Kind::peak) return curve.find_extremum(SampledCurve::Extremum::peak);
  if (moment.kind == Kind::minimum) return curve.find_extremum(SampledCurve::Extremum::minimum);
  if (moment.kind == Kind::maximum) return curve.find_extremum(SampledCurve::Extremum::maximum);
  const std::vector<double> crossings = curve.find_crossings(moment.level);
  if (crossings.size() >= static_cast<std::size_t>(moment.crossing))
    return crossings[static_cast<std::size_t>(moment.crossing - 1)];
  if (crossings.empty()) {
    const auto [low, high] = std::minmax_element(curve.sampled_values().begin(), curve.sampled_values().end());
    figure.reason = fmt::format("{} never is {}: it is between {:.6g} and {:.6g}{}{}", moment.quantity,
                                moment.level_text, *low, *high, found->unit.empty() ? "" : " ", found->unit);
  } else {
    figure.reason =
        fmt::format("{} is {} {}, not {} times", moment.quantity, moment.level_text,
                    crossings.size() == 1 ? "once" : fmt::format("{} times", crossings.size()), moment.crossing);
  }
  return std::nullopt;
}

EvaluatedFigure FigureEvaluator::evaluate(const FigureReference& reference) {
  EvaluatedFigure figure = reference.function->read(*this, reference);
  figure.text = reference.text();
  return figure;
}

bool has_figure(const MetricTable& table, const FigureReference& figure) {
  if (figure.function->statistic) return find_metric(table, figure.quantity) != nullptr;
  return std::string_view(figure.function->name) == "energy" && !std::isnan(table.energy);
}

void evaluate_figures(const std::vector<FigureReference>& figures, FigureEvaluator& evaluator, MetricTable& table) {
  for (const FigureReference& figure : figures)
    if (!has_figure(table, figure) && find_evaluated_figure(table, figure.text()) == nullptr)
      table.figures.push_back(evaluator.evaluate(figure));
}

namespace {

/// Whether the masses of a mechanism, in the run's configurations, have the run's centre of mass.
bool is_mechanism_of(const RunResult& run, const Mechanism& mechanism) {
  if (run.coordinate_names.size() != mechanism.coordinates.size() || run.com_position.rows() != run.time.size() ||
      run.joint_position.rows() != run.time.size())
    return false;
  for (std::size_t c = 0; c < mechanism.coordinates.size(); ++c)
    if (mechanism.coordinates[c].name != run.coordinate_names[c]) return false;
  const std::vector<std::vector<results::BodyMotion>> motions = body_motions(mechanism, run, run.time.size());
  constexpr double com_tolerance =
      1e-6;  // of its distance and a metre: round-off is far smaller, other designs are not
  for (Eigen::Index k = 0; k < run.time.size(); k += std::max<Eigen::Index>(1, run.time.size() / 2)) {
    const Mechanism loaded = mechanism_at_time(mechanism, run.time[k]);
    Vector3 moment = Vector3::Zero();
    double mass = 0;
    const auto add = [&](BodyId body, double m, const Vector3& r) {
      if (body == model::ground) return;
      moment += m * motions[static_cast<std::size_t>(k)][static_cast<std::size_t>(body)].point_position(r);
      mass += m;
    };
    for (std::size_t b = 1; b < loaded.bodies.size(); ++b)
      add(static_cast<int>(b), loaded.bodies[b].mass, loaded.bodies[b].com);
    for (const Attachment& one : loaded.attachments) add(one.body, one.mass, one.position);
    for (const Disc& one : loaded.discs) add(one.body, one.mass, one.position);
    const VectorX com = run.com_position.row(k).transpose();
    if (mass > 0 && !((moment.head(run.axes) / mass - com).norm() <= com_tolerance * (1 + com.norm()))) return false;
  }
  return true;
}

}  // namespace

std::shared_ptr<const Mechanism> read_mechanism_of(const RunResult& run, const std::string& trajectory,
                                                   const std::string& spec_text, const std::string& file_name,
                                                   const std::vector<std::pair<std::string, std::string>>& overrides) {
  try {
    auto mechanism = std::make_shared<const Mechanism>(
        mechanism_along(read_spec(spec_text, file_name, ReadOptions{.set = overrides}), trajectory));
    return is_mechanism_of(run, *mechanism) ? mechanism : nullptr;
  } catch (const SpecError&) {
    return nullptr;  // a spec of another version
  } catch (const std::invalid_argument&) {
    return nullptr;  // moves of counterweights that the run's duration allowed
  } catch (const SystemError&) {
    return nullptr;  // its parts are gone
  }
}

}  // namespace balance::comparison
